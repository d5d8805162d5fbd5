"""Data sources, queries, overrides and links, in the types of Grafana's SDK."""

from grafana_foundation_sdk.builders import dashboard, prometheus
from grafana_foundation_sdk.cog.builder import Builder
from grafana_foundation_sdk.cog.variants import Dataquery
from grafana_foundation_sdk.models.dashboard import (
    DashboardFieldConfigSourceOverrides,
    DataSourceRef,
    DynamicConfigValue,
    MatcherConfig,
)
from grafana_foundation_sdk.models.prometheus import PromQueryFormat, QueryEditorMode

PROMETHEUS = DataSourceRef(type_val="prometheus", uid="${prometheus_datasource}")
POSTGRES = DataSourceRef(type_val="grafana-postgresql-datasource", uid="${postgres_datasource}")


def promql(expression, legend) -> prometheus.Dataquery:
    """A query in PromQL over the dashboard's time; with `.instant()` at its end only."""
    query = prometheus.Dataquery().datasource(PROMETHEUS).editor_mode(QueryEditorMode.CODE)
    return query.expr(expression).legend_format(legend).format(PromQueryFormat.TIME_SERIES).range()


class Sql(Builder[Dataquery], Dataquery):
    """A query in SQL, for which the SDK has no type.

    As `time_series` it has a column `time`, numbers, and optionally texts that name the series.
    """

    datasource = POSTGRES

    def __init__(self, query, form="table"):
        self.query, self.form, self.letter = tidy(query), form, "Anno"

    def ref_id(self, letter):
        self.letter = letter
        return self

    def build(self):
        return self

    def to_json(self):
        written = {"editorMode": "code", "rawQuery": True, "rawSql": self.query, "format": self.form}
        return {"refId": self.letter, "datasource": self.datasource, **written}


def tidy(query):
    """Removes the indentation of the source."""
    lines = [line.rstrip() for line in query.strip("\n").splitlines()]
    indent = min((len(line) - len(line.lstrip()) for line in lines if line.strip()), default=0)
    return "\n".join(line[indent:] for line in lines if line.strip())


def by_name(name, **properties) -> Builder[DashboardFieldConfigSourceOverrides]:
    """An override for the column or series with that name; write dots in a property's name as two underscores."""
    listed = [DynamicConfigValue(key.replace("__", "."), value) for key, value in properties.items()]
    override = dashboard.DashboardFieldConfigSourceOverrides()
    return override.matcher(MatcherConfig("byName", name)).properties(listed)


def hidden(*names):
    """Hides columns that only links use, with the property of Grafana 12.2 and newer and with the older one."""
    return [by_name(name, custom__hideFrom__viz=True, custom__hidden=True) for name in names]


def console_page(path) -> dashboard.DashboardLink:
    """A link to a page of the console."""
    link = dashboard.DashboardLink("Open in the console")
    return link.url("${console:raw}/#/" + path).target_blank(True)


def to_console(*path):
    """The same from a cell or a series; fields of the row are named with a colon before them."""
    part = lambda one: f"${{__data.fields.{one[1:]}}}" if one.startswith(":") else one
    return [console_page("/".join(map(part, path))).build()]


CONSOLE_ROBOT = to_console("fleets", ":fleet", "robots", ":robot")
CONSOLE_WHISKER = to_console("fleets", ":fleet", "robots", ":robot", "arrays", ":array", "whiskers", ":whisker")


def drill_down(uid, title, **variables):
    """A link from a cell to a dashboard, with variables from the cell's row."""
    along = [f"var-{name}=${{__data.fields.{field}}}" for name, field in variables.items()]
    along += [f"${{{name}:queryparam}}" for name in ("prometheus_datasource", "postgres_datasource", "console")]
    return [dashboard.DashboardLink(title).url(f"/d/{uid}?{'&'.join(along)}&${{__url_time_range}}").build()]
