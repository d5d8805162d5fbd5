"""One whisker: its length, sensitivity, pressure and compensation error over time, and everything decided about it."""

from . import rows, variables, words
from .fleet import error_steps
from .grafana import barchart, by_name, drill_down, hidden, sql, stat, table, timeline, timeseries, whole
from .rows import WHISKER, WHISKER_ID, WHISKERS, between, bucket, time

NAME = "whisker"

FREE = {"axisSoftMin": None}
THIS = f"FROM {WHISKERS} WHERE {WHISKER}"
# Compensations for it, and those that it serves.
ITS = f"(c.target_whisker_id = {WHISKER_ID} OR c.compensator_whisker_id = {WHISKER_ID})"


def dashboard():
    """The dashboard."""
    return whole(
        "vibrissa-whisker",
        "One whisker: length, sensitivity, pressure and compensation error over time, decisions with everyone who was"
        " asked.",
        # No query goes to Prometheus, but the other dashboards are led to with the same data source.
        variables.sources() + variables.supervisors() + variables.whisker(),
        [
            ("Now", now()),
            ("Length and sensitivity", lengths()),
            ("Pressure", pressures()),
            ("Compensation error", errors()),
            ("Decisions, setpoints, alarms", tables()),
        ],
        rows.happenings(WHISKER),
    )


def now():
    one = lambda column: sql(f"SELECT {column} {THIS}")
    health = stat(
        "Health", "Its fault or, without one, its condition.", "string", one("coalesce(w.fault, w.condition) AS health")
    )
    health["options"]["reduceOptions"]["fields"] = "/.*/"
    newest = (
        f"SELECT e.error AS error FROM compensations c JOIN compensation_errors e USING (compensation_id) WHERE {ITS}"
        " AND c.ended_us IS NULL ORDER BY e.recorded_us DESC LIMIT 1"
    )
    return [
        health,
        stat("Length", "Estimated length now.", "lengthmm", one("w.length_mm AS length"), defaults={"decimals": 1}),
        stat(
            "Lost",
            "What is missing of its whole length.",
            "lengthmm",
            one("w.whole_length_mm - w.length_mm AS lost"),
            defaults={"decimals": 1},
        ),
        stat("Setpoint", "The pressure that it is to have.", "pressurepa", one("1e6 * w.setpoint_mpa AS setpoint")),
        stat(
            "Compensation error",
            "The newest measured error of the compensation that it is in, for itself or for another.",
            "percentunit",
            sql(newest),
            error_steps(),
        ),
        stat("Contacts", "Contacts since it is known.", "locale", one("w.contacts")),
    ]


def band(low, high, of):
    """Draws two series as the borders of what lies between them."""
    border = {"custom__lineWidth": 0, "custom__showPoints": "never", "color": {"mode": "fixed", "fixedColor": "blue"}}
    return [
        by_name(of, color={"mode": "fixed", "fixedColor": "blue"}, custom__lineWidth=2),
        by_name(low, **border),
        by_name(high, custom__fillBelowTo=low, custom__fillOpacity=15, **border),
    ]


def lengths():
    return [
        timeseries(
            "Length",
            "Estimated length with its 95 % interval, averaged over the panel's interval; times are the robot's.",
            "lengthmm",
            [sql(LENGTH, "time_series")],
            size=(12, 10),
            custom=FREE,
            overrides=band("low", "high", "length"),
        ),
        timeseries(
            "Sensitivity against the model's",
            "Measured over predicted sensitivity of the contacts that were used: 100 % where the estimated length"
            " explains what is felt.",
            "percentunit",
            [sql(RESIDUAL, "time_series")],
            size=(12, 10),
            custom=FREE,
            overrides=band("low", "high", "measured over predicted"),
        ),
        timeline("Health", "Its fault or, without one, its condition.", [sql(HEALTH)], words.HEALTH, (12, 6)),
        timeseries(
            "Contacts by use",
            "Contacts per panel's interval by what they were used for; times are the robot's.",
            "none",
            [sql(USE, "time_series")],
            size=(12, 6),
            bars=True,
            stacked=True,
        ),
    ]


def pressures():
    stepped = by_name("setpoint", custom__lineInterpolation="stepAfter", custom__lineWidth=2)
    return [
        timeseries(
            "Pressure, set and measured",
            "What it is to have, and what the robot measures at contacts.",
            "pressurepa",
            [sql(PRESSURE, "time_series"), sql(SETPOINT, "time_series")],
            size=(14, 9),
            overrides=[stepped],
        ),
        barchart(
            "Sensitivity by contact ratio",
            "Strain for each millimetre of deflection, of this time's contacts, as measured: it falls with the distance"
            " from the base.",
            "none",
            sql(SENSITIVITY),
            "contact ratio",
            (10, 9),
        ),
    ]


def errors():
    names = [label for _, label in ERROR_PARTS]
    return [
        timeseries(
            "Compensation error over time",
            "Measured error (Eq. 35) of the compensations that it is in, with its 95 % interval; what was predicted;"
            " and what the published gain leaves.",
            "percentunit",
            [sql(ERROR, "time_series")],
            size=(12, 10),
            overrides=band("low", "high", names[0]),
        ),
        barchart(
            "Compensation error by contact ratio",
            "As Fig. 10 of the paper: the newest measured error of the compensation that it is in, with its 95 %"
            " interval, and what was predicted.",
            "percentunit",
            sql(BY_RATIO),
            "contact ratio",
            (12, 10),
        ),
    ]


def tables():
    other = drill_down(
        "vibrissa-whisker", "Show this whisker", fleet="fleet", robot="robot", array="array", whisker="asked"
    )
    places = hidden("fleet", "robot", "array")
    shares = [by_name(name, unit="percentunit", decimals=1) for name in ("predicted", "low", "high")]
    in_pascals = lambda *names: [by_name(name, unit="pressurepa") for name in names]
    return [
        table(
            "Decisions and who was asked",
            "Decisions of this time about it, with everyone who was asked, what Eq. 34 and 35 predict for them, and why"
            " they were not chosen; a click shows the one asked.",
            sql(CANDIDATES),
            [
                by_name("asked", links=other),
                *places,
                *shares,
                *in_pascals("pressure", "before"),
                by_name("length", unit="lengthmm", decimals=1),
            ],
            (24, 10),
        ),
        table(
            "Trims",
            "Cuts that were found in this time.",
            sql(TRIMS),
            [by_name(name, unit="lengthmm", decimals=1) for name in ("before", "after", "+-")],
            (8, 9),
        ),
        table(
            "Setpoints",
            "Its setpoints of this time with every state that they came into, the newest first.",
            sql(SETPOINTS),
            in_pascals("pressure", "reached"),
            (16, 9),
        ),
        table(
            "Looks at its compensation",
            "Looks at the setpoint of the compensations that it is in, the newest first.",
            sql(REFINEMENTS),
            [by_name(name, unit="percentunit", decimals=1) for name in ("error", "with gain", "expected")]
            + in_pascals("pressure", "best"),
            (12, 9),
        ),
        table("Alarms", "Its alarms of this time and those that stand, the newest first.", sql(ALARMS), [], (12, 9)),
    ]


OF_CONTACTS = f"FROM contacts c WHERE c.whisker_id = {WHISKER_ID} AND {between('c.t_us')}"

LENGTH = f"""
    SELECT {bucket("c.t_us")} AS "time", avg(c.length_mm) AS length,
        avg(c.length_mm) - {rows.Z95} * avg(c.length_sd_mm) AS low,
        avg(c.length_mm) + {rows.Z95} * avg(c.length_sd_mm) AS high
    {OF_CONTACTS} GROUP BY 1 ORDER BY 1
"""

# The interval is that of the mean; a single contact has none.
RESIDUAL = f"""
    SELECT "time", exp(mean) AS "measured over predicted",
        exp(mean - {rows.Z95} * error) AS low, exp(mean + {rows.Z95} * error) AS high
    FROM (
        SELECT {bucket("c.t_us")} AS "time", avg(c.residual) AS mean, stddev_samp(c.residual) / sqrt(count(*)) AS error
        {OF_CONTACTS} AND c.residual IS NOT NULL GROUP BY 1
    ) binned ORDER BY 1
"""

HEALTH = f"""
    SELECT {time("s.us")} AS "time", s.state AS health FROM ({rows.health(WHISKER_ID)}) s ORDER BY s.us
"""

USE = f"""
    SELECT {bucket("c.t_us")} AS "time", c.used AS metric, count(*) AS contacts
    {OF_CONTACTS} GROUP BY 1, 2 ORDER BY 1, 2
"""

PRESSURE = f"""
    SELECT {bucket("c.t_us")} AS "time", 1e6 * avg(c.pressure_mpa) AS measured {OF_CONTACTS} GROUP BY 1 ORDER BY 1
"""

ISSUED = f"SELECT s.issued_us AS us, s.pressure_mpa AS state FROM setpoints s WHERE s.whisker_id = {WHISKER_ID}"
NOMINAL = f"(SELECT x.nominal_pressure_mpa FROM whiskers x WHERE x.whisker_id = {WHISKER_ID})"
SETPOINT = f"""
    SELECT {time("p.us")} AS "time", 1e6 * p.state AS setpoint FROM ({rows.steps(ISSUED, NOMINAL)}) p ORDER BY p.us
"""

SENSITIVITY = f"""
    SELECT to_char(round(c.ratio::numeric / 0.05) * 0.05, 'FM0.00') AS "contact ratio",
        avg(c.strain / c.deflection_mm) AS "strain per mm"
    {OF_CONTACTS} AND c.deflection_mm > 0 GROUP BY 1 ORDER BY 1
"""

ERROR_PARTS = [
    ("e.error", "measured"),
    ("e.error_low", "low"),
    ("e.error_high", "high"),
    ("e.error_with_gain", "with gain"),
    ("c.predicted_error", "predicted"),
]
ERROR = f"""
    SELECT {time("e.recorded_us")} AS "time", {", ".join(f'{column} AS "{label}"' for column, label in ERROR_PARTS)}
    FROM compensations c JOIN compensation_errors e USING (compensation_id)
    WHERE {ITS} AND {between("e.recorded_us")} ORDER BY e.recorded_us
"""

BY_RATIO = f"""
    SELECT to_char(b.ratio, 'FM0.00') AS "contact ratio", b.error AS measured, b.error_low AS low, b.error_high AS high,
        p.predicted
    FROM (
        SELECT e.compensation_id, e.compensation_error_id
        FROM compensations c JOIN compensation_errors e USING (compensation_id)
        WHERE {ITS} AND {between("e.recorded_us")} ORDER BY e.recorded_us DESC LIMIT 1
    ) e
    JOIN compensation_error_bins b USING (compensation_error_id)
    {rows.PREDICTED_AT_RATIO.strip()}
    ORDER BY b.ratio
"""

CANDIDATES = f"""
    SELECT {time("c.decided_us")} AS decided, r.fleet, r.robot, a."array", w.whisker AS asked, k.chosen, k.refused,
        k.compensation_case AS "case", k.length_mm AS length, 1e6 * k.pressure_before_mpa AS before,
        1e6 * k.pressure_mpa AS pressure,
        k.predicted_error AS predicted, k.predicted_error_low AS low, k.predicted_error_high AS high,
        k.gives_up_own_role AS "gives up its own", c.approval, {time("c.ended_us")} AS ended, c.end_reason AS why
    FROM compensations c JOIN compensation_candidates k USING (compensation_id)
    {rows.OF_WHISKER}
    WHERE c.target_whisker_id = {WHISKER_ID} AND (c.ended_us IS NULL OR {between("c.decided_us")})
    ORDER BY c.decided_us DESC, k.ordinal LIMIT 200
"""

TRIMS = f"""
    SELECT {time("t.detected_us")} AS found, t.length_before_mm AS before, t.length_after_mm AS after,
        {rows.Z95} * t.length_after_sd_mm AS "+-", t.contacts_to_detect AS contacts
    FROM trims t WHERE t.whisker_id = {WHISKER_ID} AND {between("t.detected_us")} ORDER BY t.detected_us DESC LIMIT 200
"""

SETPOINTS = f"""
    SELECT {time("h.recorded_us")} AS heard, s.reason, 1e6 * s.pressure_mpa AS pressure, h.state, h.error,
        1e6 * h.pressure_mpa AS reached, {time("s.issued_us")} AS issued, s.epoch, s.version
    FROM setpoints s JOIN setpoint_states h USING (command_id)
    WHERE s.whisker_id = {WHISKER_ID} AND {between("s.issued_us")}
    ORDER BY s.issued_us DESC, h.setpoint_state_id DESC LIMIT 200
"""

REFINEMENTS = f"""
    SELECT {time("f.recorded_us")} AS looked, f.outcome, f.contacts, 1e6 * f.pressure_from_mpa AS pressure,
        1e6 * f.pressure_best_mpa AS best, f.error, f.error_best AS expected, f.error_with_gain AS "with gain",
        f.gain_published AS "new gain"
    FROM compensations c JOIN compensation_refinements f USING (compensation_id)
    WHERE {ITS} AND {between("f.recorded_us")} ORDER BY f.recorded_us DESC LIMIT 200
"""

ALARMS = f"""
    SELECT o.kind, {time("o.raised_us")} AS raised, {time("o.cleared_us")} AS over,
        o.acknowledged_by AS "acknowledged by"
    FROM alarms o WHERE o.whisker_id = {WHISKER_ID} AND (o.cleared_us IS NULL OR {between("o.raised_us")})
    ORDER BY o.raised_us DESC LIMIT 200
"""
