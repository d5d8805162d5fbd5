"""All fleets: robots, whiskers, recent events, and links to details."""

from . import rows, variables, words
from .grafana import CONSOLE_ROBOT, CONSOLE_WHISKER, Sql, by_name, drill_down, promql
from .layout import whole
from .panels import bargauge, stat, table, timeseries
from .rows import FLEETS, between, bucket, time
from .series import any_of, gained, largest, least, mean, of_fleet, rate, shares, total

NAME = "fleet"

RED_ABOVE_0 = [(None, "green"), (1e-9, "red")]


def dashboard():
    """The dashboard."""
    return whole(
        "vibrissa-fleet",
        "Robots, whiskers, trims, compensations, setpoints and alarms of all fleets.",
        variables.sources() + variables.console() + variables.supervisors() + variables.fleets(),
        [
            ("Now", now()),
            ("Whiskers and alarms", whiskers()),
            ("Trims and compensations", trims()),
            ("Setpoints", setpoints()),
            ("Details", tables()),
        ],
        rows.happenings(FLEETS),
    )


def now():
    healthy = total(of_fleet("vibrissa_whiskers", 'health="HEALTHY"'))
    last_heard = f"time() - {largest(of_fleet('vibrissa_last_contact_timestamp_seconds') + ' > 0')}"
    away = of_fleet("vibrissa_robots", 'connection!="ONLINE"')
    error = f"{total(of_fleet('vibrissa_compensation_error_mean_ratio') + ' * ' + in_force())} / {total(in_force())}"
    return [
        stat(
            "Robots online",
            "Robots that are connected.",
            "none",
            promql(total(of_fleet("vibrissa_robots", 'connection="ONLINE"')), "online"),
        ),
        stat(
            "Robots away",
            "Robots that are OFFLINE or SILENT, or whose connection broke.",
            "none",
            promql(total(away), "away"),
            RED_ABOVE_0,
        ),
        stat(
            "Healthy whiskers",
            "Share of the whiskers with condition HEALTHY and without a fault.",
            "percentunit",
            promql(f"{healthy} / {total(of_fleet('vibrissa_whiskers'))}", "healthy"),
            [(None, "red"), (0.8, "yellow"), (0.95, "green")],
        ),
        stat(
            "Alarms standing",
            "Alarms whose cause persists.",
            "none",
            promql(f"{total(of_fleet('vibrissa_alarms_standing'))} or vector(0)", "alarms"),
            RED_ABOVE_0,
        ),
        stat(
            "Compensation error",
            "Mean measured error (Eq. 35) over all compensations in force.",
            "percentunit",
            promql(error, "error"),
            error_steps(),
        ),
        stat(
            "Silence",
            "Time since the last contacts message of any robot.",
            "s",
            promql(last_heard, "silence"),
            [(None, "green"), (60, "yellow"), (600, "red")],
        ),
    ]


def in_force():
    """Compensations in force of cases that have a measured error."""
    measured = of_fleet("vibrissa_compensation_error_mean_ratio")
    return f"({of_fleet('vibrissa_compensations_in_force')} and {measured})"


def error_steps():
    """Colours: better than the paper's case 1, better than its case 2, or worse."""
    return [(None, "green"), (words.PAPER_CASE_1, "yellow"), (words.PAPER_CASE_2, "red")]


def whiskers():
    return [
        timeseries(
            "Whiskers by health",
            "Whiskers by their fault or, without one, their condition.",
            "none",
            [promql(any_of(total(of_fleet("vibrissa_whiskers"), "health"), "health"), "{{health}}")],
            stacked=True,
        ),
        timeseries(
            "Robots by connection",
            "ONLINE; SILENT if connected and not heard; OFFLINE after a farewell; CONNECTION_BROKEN by the last will.",
            "none",
            [promql(any_of(total(of_fleet("vibrissa_robots"), "connection"), "connection"), "{{connection}}")],
            stacked=True,
        ),
        timeseries(
            "Alarms standing by kind",
            "Alarms whose cause persists.",
            "none",
            [promql(any_of(total(of_fleet("vibrissa_alarms_standing"), "kind"), "kind"), "{{kind}}")],
            stacked=True,
        ),
        timeseries(
            "Contacts by use",
            "Contacts per second by their use; only USED and LEARNING contribute to estimated lengths.",
            "cps",
            [promql(total(rate(of_fleet("vibrissa_contacts_total")), "used"), "{{used}}")],
            stacked=True,
        ),
        timeseries(
            "Alarms raised by kind",
            "Alarms raised per minute.",
            "cpm",
            [
                promql(
                    any_of(f"60 * {total(rate(of_fleet('vibrissa_alarms_raised_total')), 'kind')}", "kind"), "{{kind}}"
                )
            ],
            bars=True,
            stacked=True,
        ),
        stat(
            "Contacts between false alarms",
            "Mean number of contacts between two false alarms of the detector on a healthy whisker, as configured.",
            "locale",
            promql(least(of_fleet("vibrissa_detector_arl_contacts")), "contacts"),
            size=(8, 8),
            trend=False,
        ),
    ]


def trims():
    by_outcome = total(gained(of_fleet("vibrissa_compensations_total")), "case, outcome")
    return [
        stat(
            "Trims",
            "Trims detected in the selected time.",
            "none",
            promql(total(gained(of_fleet("vibrissa_trims_total"))), "trims").instant(),
            size=(4, 8),
        ).decimals(0),
        timeseries(
            "Contacts to detect a trim",
            "Contacts from the most likely time of a cut to its detection, for recent trims.",
            "none",
            [promql(mean(of_fleet, "vibrissa_trim_detection_contacts"), "mean")]
            + shares(of_fleet, "vibrissa_trim_detection_contacts", by=(0.5, 0.95)),
            size=(10, 8),
        ),
        timeseries(
            "Compensations in force",
            "Compensations in force, by case.",
            "none",
            [promql(any_of(total(of_fleet("vibrissa_compensations_in_force"), "case"), "case"), "{{case}}")],
            size=(10, 8),
            stacked=True,
        ),
        timeseries(
            "Decisions and ends",
            "Outcomes of decisions and compensations per hour: first STARTED, PROPOSED or UNSERVED (none can"
            " compensate), then the reasons for their end.",
            "none",
            [
                promql(
                    any_of(f"3600 * {total(rate(of_fleet('vibrissa_compensations_total')), 'outcome')}", "outcome"),
                    "{{outcome}}",
                )
            ],
            size=(12, 8),
            bars=True,
            stacked=True,
        ),
        bargauge(
            "Outcomes by case",
            "Number of outcomes by case in the selected time; NONE if none can compensate.",
            "none",
            promql(any_of(by_outcome, "case", "outcome"), "{{case}}: {{outcome}}").instant(),
        ).decimals(0),
        timeseries(
            "Errors by robot",
            "Mean measured error (Eq. 35) of each robot's compensations, averaged over the panel's interval: the twenty robots"
            " with the largest errors in the selected time.",
            "percentunit",
            [Sql(ERRORS, "time_series")],
            size=(24, 9),
        ),
    ]


def setpoints():
    return [
        timeseries(
            "Setpoints by state",
            "Setpoints per minute by each state that they reached.",
            "cpm",
            [
                promql(
                    any_of(f"60 * {total(rate(of_fleet('vibrissa_setpoints_total')), 'state')}", "state"), "{{state}}"
                )
            ],
            bars=True,
            stacked=True,
        ),
        timeseries(
            "Time to APPLIED",
            "From the message that led to a setpoint to its state APPLIED; mostly the robot's change of pressure.",
            "s",
            shares(of_fleet, "vibrissa_setpoint_application_seconds", by=(0.5, 0.95)),
        ),
        timeseries(
            "Under way",
            "Setpoints without a final state, and setpoints sent again per minute.",
            "none",
            [
                promql(total(of_fleet("vibrissa_setpoints_under_way")), "under way"),
                promql(f"60 * {total(rate(of_fleet('vibrissa_setpoints_resent_total')))}", "sent again per minute"),
            ],
        ),
    ]


def tables():
    to_robot = drill_down("vibrissa-robot", "Show the robot", fleet="fleet", robot="robot") + CONSOLE_ROBOT
    to_whisker = drill_down(
        "vibrissa-whisker", "Show the whisker", fleet="fleet", robot="robot", array="array", whisker="whisker"
    ) + CONSOLE_WHISKER
    return [
        table(
            "Robots",
            "Every robot with its whiskers; click a robot to open it.",
            Sql(ROBOTS),
            [by_name("robot", links=to_robot), by_name("heard", unit="dateTimeFromNow")],
        ),
        table(
            "Standing alarms",
            "Alarms whose cause persists, newest first; click a whisker to open it.",
            Sql(ALARMS),
            [by_name("whisker", links=to_whisker), by_name("robot", links=to_robot)],
            (12, 9),
        ),
        table(
            "Newest trims",
            "Trims in the selected time, newest first; click a whisker to open it.",
            Sql(TRIMS),
            [by_name("whisker", links=to_whisker), by_name("robot", links=to_robot)]
            + [by_name(name, unit="lengthmm", decimals=1) for name in ("before", "after", "+-")],
            (12, 9),
        ),
    ]


ROBOTS = f"""
    SELECT r.fleet, r.robot, {rows.PRESENCE} AS connection, r.model, count(w.whisker_id) AS whiskers,
        count(*) FILTER (WHERE w.condition = 'HEALTHY' AND w.fault IS NULL) AS healthy,
        count(*) FILTER (WHERE w.condition = 'TRIMMED') AS trimmed,
        count(*) FILTER (WHERE w.fault IS NOT NULL) AS faults,
        (SELECT count(*) FROM alarms o LEFT JOIN whiskers x USING (whisker_id)
            WHERE coalesce(o.robot_id, x.robot_id) = r.robot_id AND o.cleared_us IS NULL) AS alarms,
        coalesce(sum(w.contacts), 0)::bigint AS contacts, r.held, {time("max(w.heard_us)")} AS heard
    FROM robots r LEFT JOIN whiskers w ON w.robot_id = r.robot_id AND w.position IS NOT NULL
    WHERE {FLEETS} GROUP BY r.robot_id ORDER BY alarms DESC, trimmed DESC, r.fleet, r.robot
"""

ALARMS = f"""
    SELECT {rows.PLACE}, o.kind, {time("o.raised_us")} AS raised, o.acknowledged_by AS "acknowledged by"
    FROM alarms o {rows.OF_ALARM}
    WHERE {FLEETS} AND o.cleared_us IS NULL ORDER BY o.raised_us DESC LIMIT 200
"""

# Measured errors of the selected fleets in the selected time.
ERRORS_OF_FLEETS = f"""
    FROM compensation_errors e JOIN compensations c USING (compensation_id) {rows.OF_TARGET}
    WHERE {FLEETS} AND {between("e.recorded_us")}
"""

ERRORS = f"""
    SELECT {bucket("e.recorded_us")} AS "time", r.fleet || '/' || r.robot AS metric, avg(e.error) AS value
    {ERRORS_OF_FLEETS.strip()}
        AND r.robot_id IN (SELECT r.robot_id {ERRORS_OF_FLEETS.strip()} GROUP BY 1 ORDER BY avg(e.error) DESC LIMIT 20)
    GROUP BY 1, 2 ORDER BY 1, 2
"""

TRIMS = f"""
    SELECT {rows.PLACE}, {time("t.detected_us")} AS found, t.length_before_mm AS before, t.length_after_mm AS after,
        {rows.Z95} * t.length_after_sd_mm AS "+-", t.contacts_to_detect AS contacts
    FROM trims t {rows.OF_WHISKER}
    WHERE {FLEETS} AND {between("t.detected_us")} ORDER BY t.detected_us DESC LIMIT 200
"""
