"""Dashboards in the JSON of Grafana 12 (schema 42): rows of panels, placed automatically."""

SCHEMA = 42
WIDTH = 24

# The dashboards in the order of their links: uid, title, and purpose.
ALL = [
    ("vibrissa-fleet", "Fleets", "Robots, whiskers, trims, alarms"),
    ("vibrissa-compensation", "Compensation error", "Compensation errors, compared with the paper"),
    ("vibrissa-robot", "Robot", "One robot and its whiskers"),
    ("vibrissa-whisker", "Whisker", "One whisker over time"),
    ("vibrissa-supervisor", "Supervisors", "The supervisors themselves"),
]


def whole(uid, description, variables, rows, annotations=(), refresh="10s", since="now-1h", console="#/alarms"):
    """A dashboard; `rows` are (title, panels), and `console` is the page of the console that its panels link to."""
    title = next(title for known, title, _ in ALL if known == uid)
    return {
        "uid": uid,
        "title": f"vibrissa: {title}",
        "description": description,
        "tags": ["vibrissa"],
        "schemaVersion": SCHEMA,
        "version": 1,
        "editable": False,
        "graphTooltip": 1,
        "fiscalYearStartMonth": 0,
        "timezone": "browser",
        "refresh": refresh,
        "time": {"from": since, "to": "now"},
        "timepicker": {},
        "templating": {"list": list(variables)},
        "annotations": {"list": list(annotations)},
        "links": [link_to(*other) for other in ALL if other[0] != uid],
        "panels": [linked(panel, console) for panel in placed(rows)],
    }


def link_to(uid, title, tooltip):
    """A link at the top of a dashboard, which passes on time and variables."""
    return {
        "type": "link",
        "title": title,
        "tooltip": tooltip,
        "url": f"/d/{uid}",
        "icon": "dashboard",
        "tags": [],
        "asDropdown": False,
        "includeVars": True,
        "keepTime": True,
        "targetBlank": False,
    }


def placed(rows):
    """Panels with their numbers and positions: from left to right, with line breaks."""
    panels, y = [], 0
    for title, members in rows:
        panels.append(
            {"type": "row", "title": title, "collapsed": False, "panels": [], "gridPos": place(0, y, WIDTH, 1)}
        )
        x, height, y = 0, 0, y + 1
        for panel in members:
            width, tall = panel.pop("size")
            if x + width > WIDTH:
                x, height, y = 0, 0, y + height
            panels.append({**panel, "gridPos": place(x, y, width, tall)})
            x, height = x + width, max(height, tall)
        y += height
    return [{"id": number, **panel} for number, panel in enumerate(panels, 1)]


def linked(panel, page):
    """A panel whose series and numbers link to a page of the console; rows and columns with links keep their own."""
    if panel["type"] == "row":
        return panel
    link = {"title": "Open in the console", "url": "${console:raw}/" + page, "targetBlank": True}
    config = panel["fieldConfig"]
    return {**panel, "fieldConfig": {**config, "defaults": {**config["defaults"], "links": [link]}}}


def place(x, y, width, height):
    return {"x": x, "y": y, "w": width, "h": height}
