"""One robot: its whiskers, recent events, and its fleet."""

from grafana_foundation_sdk.models.common import BigValueTextMode
from grafana_foundation_sdk.models.dashboard import DataTransformerConfig

from . import rows, variables, words
from .grafana import CONSOLE_WHISKER, Sql, by_name, drill_down, hidden, promql
from .layout import whole
from .panels import newest, stat, table, timeline, timeseries
from .rows import ROBOT, between, bucket, time
from .series import largest, of_fleet, shares, total

NAME = "robot"

OF_ROBOT = f"FROM {rows.WHISKERS} WHERE {ROBOT} AND w.position IS NOT NULL"
NAMED = """a."array" || '/' || w.whisker"""


def dashboard():
    """The dashboard."""
    return whole(
        "vibrissa-robot",
        "One robot: its whiskers now and over time, its compensations, setpoints and alarms.",
        variables.sources() + variables.console() + variables.supervisors() + variables.robot(),
        [
            ("Now", now()),
            ("Whiskers", whiskers()),
            ("Over time", over_time()),
            ("Decisions, setpoints, alarms", tables()),
            ("Its fleet", fleet()),
        ],
        rows.happenings(ROBOT),
        console="fleets/${fleet}/robots/${robot}",
    )


def now():
    count = lambda condition: Sql(f"SELECT count(*) FILTER (WHERE {condition}) AS whiskers {OF_ROBOT}")
    standing = (
        f"SELECT count(*) AS alarms FROM alarms o {rows.OF_ALARM} WHERE {ROBOT} AND o.cleared_us IS NULL"
    )
    connection = stat(
        "Connection",
        "ONLINE; SILENT if connected and not heard; OFFLINE after a farewell; CONNECTION_BROKEN by the last will.",
        "string",
        Sql(f"SELECT {rows.PRESENCE} AS connection FROM robots r WHERE {ROBOT}"),
    )
    return [
        connection.text_mode(BigValueTextMode.VALUE).reduce_options(newest("/.*/")),
        stat("Whiskers", "Whiskers of its newest factsheet.", "none", count("TRUE")),
        stat(
            "Healthy",
            "Whiskers with condition HEALTHY and without a fault.",
            "none",
            count("w.condition = 'HEALTHY' AND w.fault IS NULL"),
        ),
        stat(
            "Trimmed",
            "Whiskers with condition TRIMMED.",
            "none",
            count("w.condition = 'TRIMMED'"),
            [(None, "green"), (1, "red")],
        ),
        stat(
            "Alarms standing", "Alarms whose cause persists.", "none", Sql(standing), [(None, "green"), (1, "red")]
        ),
        stat(
            "Last message",
            "Time of the last message about one of its whiskers.",
            "dateTimeFromNow",
            Sql(f"SELECT 1000 * extract(epoch FROM {time('max(w.heard_us)')})::double precision AS heard {OF_ROBOT}"),
        ),
    ]


def whiskers():
    to_whisker = drill_down(
        "vibrissa-whisker", "Show the whisker", fleet="fleet", robot="robot", array="array", whisker="whisker"
    ) + CONSOLE_WHISKER
    lengths = [by_name(name, unit="lengthmm", decimals=1) for name in ("whole", "length", "low", "high")]
    pressures = [by_name(name, unit="pressurepa") for name in ("pressure", "setpoint")]
    places = hidden("fleet", "robot")
    return [
        table(
            "Whiskers",
            "Each whisker with its length and 95 % interval; click a whisker to open it.",
            Sql(WHISKERS),
            [
                by_name("whisker", links=to_whisker),
                *lengths,
                *pressures,
                *places,
                by_name("heard", unit="dateTimeFromNow"),
            ],
            (24, 10),
        ),
    ]


def over_time():
    contacts = lambda value: Sql(CONTACTS.replace("{value}", value), "time_series")
    options = {"fields": ["whisker"], "keepFields": False, "naming": {"asLabels": False}}
    each_whisker = DataTransformerConfig("partitionByValues", options=options)
    lines = {"from_0": False, "size": (12, 9)}
    return [
        timeline(
            "Health",
            "Each whisker's fault or, without one, its condition.",
            [Sql(HEALTH)],
            words.HEALTH,
        ).with_transformation(each_whisker),
        timeseries(
            "Lengths",
            "Estimated lengths after each contact, averaged over the panel's interval; times are the robot's.",
            "lengthmm",
            [contacts("avg(c.length_mm)")],
            **lines,
        ),
        timeseries(
            "Pressures",
            "Measured pressures, averaged over the panel's interval; times are the robot's.",
            "pressurepa",
            [contacts("1e6 * avg(c.pressure_mpa)")],
            **lines,
        ),
    ]


def tables():
    to_whisker = drill_down(
        "vibrissa-whisker", "Show the whisker", fleet="fleet", robot="robot", array="array", whisker="whisker"
    ) + CONSOLE_WHISKER
    places = hidden("fleet", "robot")
    linked = [by_name("whisker", links=to_whisker), *places]
    errors = [by_name(name, unit="percentunit", decimals=1) for name in ("predicted", "measured")]
    pressure, reached = (by_name(name, unit="pressurepa") for name in ("pressure", "reached"))
    return [
        table(
            "Compensations",
            "Decisions about its whiskers in the selected time, and compensations in force, newest first.",
            Sql(COMPENSATIONS),
            [*linked, *errors, pressure],
        ),
        table(
            "Setpoints",
            "Setpoints in the selected time, newest first.",
            Sql(SETPOINTS),
            [*linked, pressure, reached],
            (12, 9),
        ),
        table("Alarms", "Alarms of the selected time and standing alarms, newest first.", Sql(ALARMS), linked, (12, 9)),
    ]


def fleet():
    silence = f"time() - {largest(of_fleet('vibrissa_last_contact_timestamp_seconds') + ' > 0')}"
    return [
        timeseries(
            "From contact to commit",
            "From the newest contact of a message, by the robots' clocks, to its commit; for the whole fleet.",
            "s",
            shares(of_fleet, "vibrissa_contact_to_commit_seconds"),
        ),
        timeseries(
            "From message to applied setpoint",
            "From the message that led to a setpoint to its state APPLIED; for the whole fleet.",
            "s",
            shares(of_fleet, "vibrissa_setpoint_application_seconds", by=(0.5, 0.95)),
        ),
        timeseries(
            "Waiting messages, and silence",
            "Messages in the fleet's inbox, and on the right the time since its last contacts message.",
            "none",
            [
                promql(total(of_fleet("vibrissa_queue_messages", 'queue="inbox"')), "inbox"),
                promql(silence, "silence"),
            ],
        ).overrides([by_name("silence", unit="s", custom__axisPlacement="right")]),
    ]


WHISKERS = f"""
    SELECT {rows.PLACE}, w.condition, w.fault, w.whole_length_mm AS whole, w.length_mm AS length,
        w.length_mm - {rows.Z95} * w.length_sd_mm AS low, w.length_mm + {rows.Z95} * w.length_sd_mm AS high,
        1e6 * w.pressure_mpa AS pressure, 1e6 * w.setpoint_mpa AS setpoint,
        w.contacts, w.held, {time("w.heard_us")} AS heard
    {OF_ROBOT} ORDER BY a."array", w.whisker
"""

# {{value}} is an aggregate over contacts. Each whisker's contacts are read by their index.
CONTACTS = f"""
    SELECT c."time", {NAMED} AS metric, c.value
    FROM {rows.WHISKERS}
    CROSS JOIN LATERAL (
        SELECT {bucket("c.t_us")} AS "time", {{value}} AS value FROM contacts c
        WHERE c.whisker_id = w.whisker_id AND {between("c.t_us")} GROUP BY 1
    ) c
    WHERE {ROBOT} AND w.position IS NOT NULL ORDER BY 1, 2
"""

HEALTH = f"""
    SELECT {time("s.us")} AS "time", {NAMED} AS whisker, s.state
    FROM {rows.WHISKERS} CROSS JOIN LATERAL ({rows.health("w.whisker_id")}) s
    WHERE {ROBOT} AND w.position IS NOT NULL ORDER BY a."array", w.whisker, s.us
"""

COMPENSATIONS = f"""
    SELECT {rows.PLACE}, {time("c.decided_us")} AS decided, c.compensation_case AS "case", s.whisker AS "served by",
        1e6 * c.pressure_mpa AS pressure, c.predicted_error AS predicted, e.error AS measured, e.contacts, c.approval,
        {time("c.ended_us")} AS ended, c.end_reason AS "end reason"
    FROM compensations c
    {rows.OF_TARGET}
    LEFT JOIN whiskers s ON s.whisker_id = c.compensator_whisker_id
    LEFT JOIN LATERAL (
        SELECT e.error, e.contacts FROM compensation_errors e
        WHERE e.compensation_id = c.compensation_id ORDER BY e.recorded_us DESC LIMIT 1
    ) e ON TRUE
    WHERE {ROBOT} AND (c.ended_us IS NULL OR {between("c.decided_us")}) ORDER BY c.decided_us DESC LIMIT 200
"""

SETPOINTS = f"""
    SELECT {rows.PLACE}, {time("s.issued_us")} AS issued, s.reason, 1e6 * s.pressure_mpa AS pressure, s.state, s.error,
        1e6 * s.reached_mpa AS reached
    FROM setpoints s {rows.OF_WHISKER}
    WHERE {ROBOT} AND {between("s.issued_us")} ORDER BY s.issued_us DESC LIMIT 200
"""

ALARMS = f"""
    SELECT {rows.PLACE}, o.kind, {time("o.raised_us")} AS raised, {time("o.cleared_us")} AS over,
        o.acknowledged_by AS "acknowledged by"
    FROM alarms o {rows.OF_ALARM}
    WHERE {ROBOT} AND (o.cleared_us IS NULL OR {between("o.raised_us")}) ORDER BY o.raised_us DESC LIMIT 200
"""
