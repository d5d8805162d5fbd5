"""Variables at the top of a dashboard: data sources, supervisors, and the place of a whisker."""

from grafana_foundation_sdk.builders import dashboard
from grafana_foundation_sdk.models.dashboard import VariableOption, VariableRefresh, VariableSort

from .grafana import POSTGRES, PROMETHEUS, tidy


def sources():
    """Both data sources, with names that tell them apart."""
    prometheus = dashboard.DatasourceVariable("prometheus_datasource").type("prometheus")
    postgres = dashboard.DatasourceVariable("postgres_datasource").type("grafana-postgresql-datasource")
    return [
        prometheus.label("Prometheus data source").description("The Prometheus that scrapes the supervisors."),
        postgres.label("PostgreSQL data source").description("The supervisors' database."),
    ]


def console():
    """Address of the console, for links from panels."""
    address = "http://127.0.0.1:8080"
    box = dashboard.TextBoxVariable("console").label("Console").default_value(address)
    box.description("Address of a supervisor, whose console the links open.")
    return [box.current(VariableOption(text=address, value=address))]


def supervisors():
    """Supervisors: all by default."""
    jobs = labels("vibrissa_build_info", "job")
    instances = labels('vibrissa_build_info{job=~"$job"}', "instance")
    return [
        several("job", "Job", "Prometheus' name for the supervisors.", jobs).all_value(".+"),
        several("instance", "Instance", "A supervisor's address.", instances).all_value(".+"),
    ]


LEASES = 'vibrissa_lease_held{job=~"$job",instance=~"$instance"}'


def fleets():
    """Fleets: all by default; a pattern can be written, too."""
    meaning = "Robots that are supervised together. Choose several, or write a pattern such as hall-.*"
    return [several("fleet", "Fleet", meaning, labels(LEASES, "fleet"))]


def robot():
    """One robot of one fleet."""
    fleets = "SELECT DISTINCT fleet FROM robots ORDER BY 1"
    robots = "SELECT robot FROM robots WHERE fleet = ${fleet:sqlstring} ORDER BY 1"
    return [
        one("fleet", "Fleet", "Robots that are supervised together.", fleets),
        one("robot", "Robot", "A robot of the fleet.", robots),
    ]


ARRAYS = """
    SELECT a."array" FROM arrays a JOIN robots r USING (robot_id)
    WHERE r.fleet = ${fleet:sqlstring} AND r.robot = ${robot:sqlstring} ORDER BY 1
"""

WHISKERS = """
    SELECT w.whisker::text FROM whiskers w JOIN arrays a USING (array_id)
    JOIN robots r ON r.robot_id = a.robot_id
    WHERE r.fleet = ${fleet:sqlstring} AND r.robot = ${robot:sqlstring} AND a."array" = ${array:sqlstring}
    ORDER BY w.whisker
"""


def whisker():
    """One whisker of one robot."""
    return robot() + [
        one("array", "Array", "An array of the robot.", ARRAYS),
        one("whisker", "Whisker", "A whisker's number in its array.", WHISKERS),
    ]


def labels(series, label):
    return f"label_values({series}, {label})"


def several(name, label, description, query) -> dashboard.QueryVariable:
    """A selection of several values from Prometheus."""
    made = queried(name, label, description).datasource(PROMETHEUS)
    made.query({"query": query, "refId": name, "qryType": 1}).sort(VariableSort.ALPHABETICAL_ASC)
    return made.multi(True).include_all(True).current(VariableOption(True, ["All"], ["$__all"]))


def one(name, label, description, query) -> dashboard.QueryVariable:
    """A selection of one value from the database."""
    return queried(name, label, description).datasource(POSTGRES).query(tidy(query))


def queried(name, label, description) -> dashboard.QueryVariable:
    # Reloaded when the dashboard's time changes, because the values may have changed, too.
    made = dashboard.QueryVariable(name).label(label).description(description)
    return made.refresh(VariableRefresh.ON_TIME_RANGE_CHANGED)
