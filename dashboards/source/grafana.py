"""Panels and queries in the JSON of Grafana 12."""

VERSION = "12.4.0"

PROMETHEUS = {"type": "prometheus", "uid": "${prometheus_datasource}"}
POSTGRES = {"type": "grafana-postgresql-datasource", "uid": "${postgres_datasource}"}


def promql(expression, legend, instant=False, form="time_series"):
    """A query in PromQL."""
    return {
        "datasource": PROMETHEUS,
        "editorMode": "code",
        "expr": expression,
        "legendFormat": legend,
        "format": form,
        "instant": instant,
        "range": not instant,
    }


def sql(query, form="table"):
    """A query in SQL; as `time_series` it has a column `time`, numbers, and optionally texts that name the series."""
    return {"datasource": POSTGRES, "editorMode": "code", "rawQuery": True, "rawSql": tidy(query), "format": form}


def tidy(query):
    """Removes the indentation of the source."""
    lines = [line.rstrip() for line in query.strip("\n").splitlines()]
    indent = min((len(line) - len(line.lstrip()) for line in lines if line.strip()), default=0)
    return "\n".join(line[indent:] for line in lines if line.strip())


def panel(kind, title, description, unit, targets, size, options, defaults=None, custom=None, overrides=(), steps=None):
    """Any panel; `steps` are (value, colour) from low to high, the first value None."""
    return {
        "type": kind,
        "title": title,
        "description": description,
        "pluginVersion": VERSION,
        "datasource": targets[0]["datasource"],
        "targets": [{"refId": chr(ord("A") + index), **target} for index, target in enumerate(targets)],
        "options": options,
        "fieldConfig": {
            "defaults": {
                "unit": unit,
                "color": {"mode": "thresholds" if steps else "palette-classic"},
                "thresholds": thresholds(steps or [(None, "green")]),
                "mappings": [],
                "custom": custom or {},
                **(defaults or {}),
            },
            "overrides": list(overrides),
        },
        "size": size,
    }


def thresholds(steps):
    return {"mode": "absolute", "steps": [{"value": value, "color": color} for value, color in steps]}


def legend(calcs=()):
    return {
        "displayMode": "table" if calcs else "list",
        "placement": "right" if calcs else "bottom",
        "showLegend": True,
        "calcs": list(calcs),
    }


TOOLTIP = {"mode": "multi", "sort": "desc"}


def timeseries(title, description, unit, targets, size=(8, 8), stacked=False, bars=False, **more):
    """Lines over time."""
    custom = {
        "drawStyle": "bars" if bars else "line",
        "lineWidth": 1,
        "fillOpacity": 60 if bars else 15 if stacked else 0,
        "showPoints": "never" if stacked or bars else "auto",
        "pointSize": 4,
        "spanNulls": False,
        "axisSoftMin": 0,
        "stacking": {"mode": "normal" if stacked else "none", "group": "A"},
        **more.pop("custom", {}),
    }
    options = {"legend": legend(), "tooltip": TOOLTIP}
    return panel("timeseries", title, description, unit, targets, size, options, custom=custom, **more)


def stat(title, description, unit, target, steps=None, size=(4, 4), trend=True, **more):
    """One number."""
    options = {
        "reduceOptions": {"calcs": ["lastNotNull"], "fields": "", "values": False},
        "orientation": "auto",
        "textMode": "auto",
        "colorMode": "value",
        "graphMode": "area" if trend and not target.get("instant") and "expr" in target else "none",
        "justifyMode": "auto",
        "wideLayout": True,
    }
    steps = steps or [(None, "text")]
    return panel("stat", title, description, unit, [target], size, options, steps=steps, **more)


def table(title, description, target, columns, size=(24, 9), unit="none"):
    """A table; `columns` are overrides for some columns."""
    options = {"showHeader": True, "cellHeight": "sm"}
    custom = {"align": "auto", "cellOptions": {"type": "auto"}, "filterable": True}
    return panel("table", title, description, unit, [target], size, options, custom=custom, overrides=columns)


def xychart(title, description, unit, targets, pairs, size=(12, 9), overrides=()):
    """One number against another: `pairs` are (number of the query, x, y, name)."""
    by = lambda name: {"matcher": {"id": "byName", "options": name}}
    options = {
        "mapping": "manual",
        "series": [
            {
                "frame": {"matcher": {"id": "byIndex", "options": index}},
                "x": by(x),
                "y": by(y),
                "name": {"fixed": name},
            }
            for index, x, y, name in pairs
        ],
        "legend": legend(),
        "tooltip": {"mode": "single", "sort": "none"},
    }
    custom = {
        "show": "points",
        "pointSize": {"fixed": 6},
        "pointShape": "circle",
        "pointStrokeWidth": 1,
        "lineWidth": 1,
    }
    return panel("xychart", title, description, unit, targets, size, options, custom=custom, overrides=overrides)


def barchart(title, description, unit, target, x_field, size=(12, 9), **more):
    """Bars by category."""
    options = {
        "xField": x_field,
        "orientation": "vertical",
        "showValue": "never",
        "stacking": "none",
        "groupWidth": 0.8,
        "barWidth": 0.9,
        "xTickLabelRotation": 0,
        "legend": legend(),
        "tooltip": TOOLTIP,
    }
    custom = {"lineWidth": 1, "fillOpacity": 70, "axisSoftMin": 0}
    return panel("barchart", title, description, unit, [target], size, options, custom=custom, **more)


def bargauge(title, description, unit, target, size=(12, 8), **more):
    """A bar for the present value of each series."""
    options = {
        "displayMode": "basic",
        "orientation": "horizontal",
        "showUnfilled": True,
        "valueMode": "color",
        "namePlacement": "left",
        "sizing": "auto",
        "legend": {**legend(), "showLegend": False},
        "reduceOptions": {"calcs": ["lastNotNull"], "fields": "", "values": False},
    }
    return panel("bargauge", title, description, unit, [target], size, options, **more)


def heatmap(title, description, unit, target, size=(12, 8)):
    """A histogram of Prometheus over time."""
    options = {
        "calculate": False,
        "cellGap": 1,
        "color": {"mode": "scheme", "scheme": "Oranges", "steps": 64, "exponent": 0.5, "reverse": False},
        "rowsFrame": {"layout": "auto"},
        "cellValues": {"unit": "short"},
        "yAxis": {"unit": unit, "axisPlacement": "left", "reverse": False},
        "filterValues": {"le": 1e-9},
        "showValue": "never",
        "legend": {"show": True},
        "tooltip": {"mode": "single", "yHistogram": False, "showColorScale": False},
    }
    return panel("heatmap", title, description, unit, [target], size, options)


def timeline(title, description, targets, words, size=(24, 8), transformations=()):
    """States over time; `words` gives each its colour."""
    options = {
        "mergeValues": True,
        "showValue": "auto",
        "alignValue": "left",
        "rowHeight": 0.85,
        "legend": legend(),
        "tooltip": {"mode": "single", "sort": "none"},
    }
    custom = {"fillOpacity": 70, "lineWidth": 0}
    made = panel(
        "state-timeline", title, description, "string", targets, size, options, {"mappings": mapping(words)}, custom
    )
    return {**made, "transformations": list(transformations)}


def mapping(words):
    """Words with colours."""
    options = {
        word: {"text": word, "color": color, "index": index} for index, (word, color) in enumerate(words.items())
    }
    return [{"type": "value", "options": options}]


def by_name(name, **properties):
    """An override for the column or series with that name; write dots in a property's name as two underscores."""
    listed = [{"id": key.replace("__", "."), "value": value} for key, value in properties.items()]
    return {"matcher": {"id": "byName", "options": name}, "properties": listed}


def hidden(*names):
    """Hides columns that only links use, with the property of Grafana 12.2 and newer and with the older one."""
    return [by_name(name, custom__hideFrom__viz=True, custom__hidden=True) for name in names]


def to_console(*path):
    """A link from a cell or a series to a page of the console; fields of the row are named with a colon before them."""
    part = lambda one: f"${{__data.fields.{one[1:]}}}" if one.startswith(":") else one
    url = "${console:raw}/#/" + "/".join(part(one) for one in path)
    return [{"title": "Open in the console", "url": url, "targetBlank": True}]


CONSOLE_ROBOT = to_console("fleets", ":fleet", "robots", ":robot")
CONSOLE_WHISKER = to_console("fleets", ":fleet", "robots", ":robot", "arrays", ":array", "whiskers", ":whisker")


def drill_down(uid, title, **variables):
    """A link from a cell to a dashboard, with variables from the cell's row."""
    along = [f"var-{name}=${{__data.fields.{field}}}" for name, field in variables.items()]
    along += [f"${{{name}:queryparam}}" for name in ("prometheus_datasource", "postgres_datasource", "console")]
    return [{"title": title, "url": f"/d/{uid}?{'&'.join(along)}&${{__url_time_range}}", "targetBlank": False}]
