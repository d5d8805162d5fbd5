"""Variables at the top of a dashboard: data sources, supervisors, and the place of a whisker."""

from .grafana import POSTGRES, PROMETHEUS, tidy


def sources():
    """Both data sources, with names that tell them apart."""
    return [
        source(
            "prometheus_datasource",
            "Prometheus data source",
            "prometheus",
            "The Prometheus that scrapes the supervisors.",
        ),
        source("postgres_datasource", "PostgreSQL data source", POSTGRES["type"], "The supervisors' database."),
    ]


def source(name, label, query, description):
    return {
        "type": "datasource",
        "name": name,
        "label": label,
        "description": description,
        "query": query,
        "regex": "",
        "current": {},
        "options": [],
        "refresh": 1,
        "hide": 0,
        "multi": False,
        "includeAll": False,
        "skipUrlSync": False,
    }


def console():
    """Address of the console, for links from panels."""
    address = "http://127.0.0.1:8080"
    return [
        {
            "type": "textbox",
            "name": "console",
            "label": "Console",
            "description": "Address of a supervisor, whose console the links open.",
            "query": address,
            "current": {"text": address, "value": address},
            "options": [{"selected": True, "text": address, "value": address}],
            "hide": 0,
            "skipUrlSync": False,
        }
    ]


def supervisors():
    """Supervisors: all by default."""
    return [
        several("job", "Job", "Prometheus' name for the supervisors.", labels("vibrissa_build_info", "job"), ".+"),
        several(
            "instance",
            "Instance",
            "A supervisor's address.",
            labels('vibrissa_build_info{job=~"$job"}', "instance"),
            ".+",
        ),
    ]


LEASES = 'vibrissa_lease_held{job=~"$job",instance=~"$instance"}'


def fleets():
    """Fleets: all by default."""
    return [several("fleet", "Fleet", "Robots that are supervised together.", labels(LEASES, "fleet"))]


def robot():
    """One robot of one fleet."""
    return [
        one("fleet", "Fleet", "Robots that are supervised together.", "SELECT DISTINCT fleet FROM robots ORDER BY 1"),
        one(
            "robot",
            "Robot",
            "A robot of the fleet.",
            "SELECT robot FROM robots WHERE fleet = ${fleet:sqlstring} ORDER BY 1",
        ),
    ]


def whisker():
    """One whisker of one robot."""
    return robot() + [
        one(
            "array",
            "Array",
            "An array of the robot.",
            """
            SELECT a."array" FROM arrays a JOIN robots r USING (robot_id)
            WHERE r.fleet = ${fleet:sqlstring} AND r.robot = ${robot:sqlstring} ORDER BY 1
            """,
        ),
        one(
            "whisker",
            "Whisker",
            "A whisker's number in its array.",
            """
            SELECT w.whisker::text FROM whiskers w JOIN arrays a USING (array_id)
            JOIN robots r ON r.robot_id = a.robot_id
            WHERE r.fleet = ${fleet:sqlstring} AND r.robot = ${robot:sqlstring} AND a."array" = ${array:sqlstring}
            ORDER BY w.whisker
            """,
        ),
    ]


def labels(series, label):
    return f"label_values({series}, {label})"


def several(name, label, description, query, all_value=None):
    """A selection of several values from Prometheus."""
    everything = {"selected": True, "text": ["All"], "value": ["$__all"]}
    made = variable(name, label, description, PROMETHEUS, query, {"query": query, "refId": name, "qryType": 1})
    made.update(multi=True, includeAll=True, current=everything, sort=1)
    return {**made, "allValue": all_value} if all_value else made


def one(name, label, description, query):
    """A selection of one value from the database."""
    return variable(name, label, description, POSTGRES, tidy(query), tidy(query))


def variable(name, label, description, datasource, definition, query):
    return {
        "type": "query",
        "name": name,
        "label": label,
        "description": description,
        "datasource": datasource,
        "definition": definition,
        "query": query,
        "regex": "",
        "current": {},
        "options": [],
        # Reload when the dashboard's time changes, because the values may have changed, too.
        "refresh": 2,
        "sort": 0,
        "hide": 0,
        "multi": False,
        "includeAll": False,
        "skipUrlSync": False,
    }
