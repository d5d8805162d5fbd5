"""Parts of queries in SQL. Times of the database are microseconds since 1970 UTC as integers, and so are the bounds
here: expressions that an index on such a column serves."""

import typing

from grafana_foundation_sdk.builders import dashboard

from .grafana import POSTGRES, Sql

FROM_US = "$__unixEpochNanoFrom() / 1000"
TO_US = "$__unixEpochNanoTo() / 1000"
# Limited to now, because a dashboard's time may be in the future.
SO_FAR_US = f"least({TO_US}, (extract(epoch FROM now()) * 1000000)::bigint)"
# Factor of a standard deviation for a 95 % interval.
Z95 = "1.959963984540054"



def of_fleets(column):
    """Condition: the column is one of the selected fleets, of which each may be a pattern."""
    return rf"{column} ~ ANY (ARRAY(SELECT '\A(' || f || ')\Z' FROM unnest(ARRAY[${{fleet:sqlstring}}]::text[]) f))"


FLEETS = of_fleets("r.fleet")
ROBOT = "r.fleet = ${fleet:sqlstring} AND r.robot = ${robot:sqlstring}"
WHISKER = f"""{ROBOT} AND a."array" = ${{array:sqlstring}} AND w.whisker::text = ${{whisker:sqlstring}}"""

WHISKERS = "whiskers w JOIN arrays a USING (array_id) JOIN robots r ON r.robot_id = w.robot_id"
# The selected whisker's number, evaluated once per query.
WHISKER_ID = f"(SELECT w.whisker_id FROM {WHISKERS} WHERE {WHISKER})"

# Joins to the whisker, for tables with its number, and for compensations by their target.
OF_WHISKER = f"JOIN {WHISKERS.replace(' JOIN', ' USING (whisker_id) JOIN', 1)}"
# The same for alarms, of which some concern a robot as a whole.
OF_ALARM = (
    "LEFT JOIN whiskers w USING (whisker_id) LEFT JOIN arrays a ON a.array_id = w.array_id"
    " JOIN robots r ON r.robot_id = coalesce(o.robot_id, w.robot_id)"
)
OF_TARGET = OF_WHISKER.replace("USING (whisker_id)", "ON w.whisker_id = c.target_whisker_id")

PLACE = """r.fleet, r.robot, a."array", w.whisker"""


# The error predicted for the compensation of `e` at the contact ratio of `b`; the array counts 0.45, 0.50 .. 1.00.
PREDICTED_AT_RATIO = """
    LEFT JOIN LATERAL (
        SELECT one.text::double precision AS predicted
        FROM compensation_candidates k,
            json_array_elements_text(k.predicted_error_by_ratio::json) WITH ORDINALITY AS one (text, number)
        WHERE k.compensation_id = e.compensation_id AND k.chosen AND abs(0.4 + 0.05 * one.number - b.ratio) < 1e-6
    ) p ON TRUE
"""


def between(column):
    """Condition: the column is in the dashboard's time."""
    return f"{column} BETWEEN {FROM_US} AND {TO_US}"


def time(column):
    return f"to_timestamp({column} / 1e6)"


def bucket(column):
    """The beginning of the panel's interval that contains the time."""
    step = "($__interval_ms * 1000::bigint)"
    return f"to_timestamp({column} / {step} * {step} / 1e6)"


def steps(events, initial):
    """States over time: the state at the beginning, each change, and the state at the end.

    `events` is a query for rows (us, state) that ends in its WHERE clause; `initial` is the state before the first
    row."""
    last = "SELECT state FROM ({events}) e WHERE us {until} ORDER BY us DESC LIMIT 1"
    at_begin = last.format(events=events, until=f"< {FROM_US}")
    at_end = last.format(events=events, until=f"<= {TO_US}")
    return f"""
        SELECT us, state FROM ({events}) e WHERE {between("us")}
        UNION ALL SELECT {FROM_US}, coalesce(({at_begin}), {initial})
        UNION ALL SELECT {SO_FAR_US}, coalesce(({at_end}), {initial})
    """


def health(whisker_id):
    """A whisker's fault or, without one, its condition: rows (us, state)."""
    newest = """
        SELECT x.becomes FROM health_changes x
        WHERE x.whisker_id = h.whisker_id AND x.kind = '{kind}' AND x.recorded_us <= h.recorded_us
        ORDER BY x.recorded_us DESC, x.health_change_id DESC LIMIT 1
    """
    fault, condition = newest.format(kind="FAULT"), newest.format(kind="CONDITION")
    changes = f"""
        SELECT h.recorded_us AS us, coalesce(({fault}), ({condition}), 'LEARNING') AS state
        FROM health_changes h WHERE h.whisker_id = {whisker_id}
    """
    return steps(changes, "'LEARNING'")


def short(value):
    """A number for people."""
    return f"round(({value})::numeric, 1)"


def annotation(name, color, query):
    """Marks events in every panel over time."""
    made = dashboard.AnnotationQuery().name(name).datasource(POSTGRES).enable(True).hide(False).icon_color(color)
    # The SDK knows no target with a query.
    return made.target(typing.cast(typing.Any, Sql(query)))


def happenings(place):
    """Trims and setpoints of the whiskers that `place` selects."""
    named = """r.robot || '/' || a."array" || '/' || w.whisker"""
    trims = f"""
        SELECT {time("t.detected_us")} AS "time", 'trim' AS tags,
            {named} || ': ' || {short('t.length_before_mm')} || ' mm to ' || {short('t.length_after_mm')} || ' mm'
            AS text
        FROM trims t {OF_WHISKER}
        WHERE {place} AND {between("t.detected_us")} ORDER BY t.detected_us DESC LIMIT 200
    """
    setpoints = f"""
        SELECT {time("s.issued_us")} AS "time", 'setpoint,' || lower(s.reason) AS tags,
            {named} || ': ' || {short('1000 * s.pressure_mpa')} || ' kPa, ' || s.state AS text
        FROM setpoints s {OF_WHISKER}
        WHERE {place} AND {between("s.issued_us")} ORDER BY s.issued_us DESC LIMIT 200
    """
    return [annotation("Trims", "red", trims), annotation("Setpoints", "blue", setpoints)]

# Connection state of the robot `r`; SILENT is connected, but not heard.
PRESENCE = (
    "CASE WHEN r.connection = 'ONLINE' AND EXISTS (SELECT FROM alarms z WHERE z.robot_id = r.robot_id"
    " AND z.kind = 'ROBOT_SILENT' AND z.cleared_us IS NULL) THEN 'SILENT' ELSE r.connection END"
)
