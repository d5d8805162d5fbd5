"""Dashboards as rows of panels, with the settings that they share."""

from grafana_foundation_sdk.builders import dashboard
from grafana_foundation_sdk.models.dashboard import DashboardCursorSync, DashboardLinkType, Panel

from .grafana import console_page

# Grafana 12 writes this version; it would migrate an older one, such as the SDK's, on load.
SCHEMA = 42
PLUGINS = "12.4.0"

# The dashboards in the order of their links: uid, title, and purpose.
ALL = [
    ("vibrissa-fleet", "Fleets", "Robots, whiskers, trims, alarms"),
    ("vibrissa-compensation", "Compensation error", "Compensation errors, compared with the paper"),
    ("vibrissa-robot", "Robot", "One robot and its whiskers"),
    ("vibrissa-whisker", "Whisker", "One whisker over time"),
    ("vibrissa-supervisor", "Supervisors", "The supervisors themselves"),
]


def whole(uid, description, variables, rows, annotations=(), console="alarms"):
    """A dashboard; `rows` are (title, panels), and `console` is the page of the console that its panels link to."""
    title = next(title for known, title, _ in ALL if known == uid)
    board = dashboard.Dashboard(f"vibrissa: {title}").uid(uid).description(description).tags(["vibrissa"])
    board.version(1).readonly().tooltip(DashboardCursorSync.CROSSHAIR).refresh("10s").time("now-1h", "now")
    board.variables(variables).annotations(list(annotations)).links([link_to(*one) for one in ALL if one[0] != uid])
    for name, panels in rows:
        board.with_row(dashboard.Row(name))
        for panel in panels:
            # Series and numbers lead to the console; rows and columns with links keep their own.
            board.with_panel(panel.data_links([console_page(console)]))
    made = board.build()
    made.schema_version = SCHEMA
    for number, panel in enumerate(made.panels or [], 1):
        panel.id_val = number
        if isinstance(panel, Panel):
            panel.plugin_version = PLUGINS
    return made


def link_to(uid, title, tooltip):
    """A link at the top of a dashboard, which passes on time and variables."""
    link = dashboard.DashboardLink(title).type(DashboardLinkType.LINK).tooltip(tooltip).url(f"/d/{uid}")
    return link.icon("dashboard").include_vars(True).keep_time(True)
