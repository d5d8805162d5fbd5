"""All fleets at a glance: what is there, what has happened to it, and where to look next."""

from . import rows, variables, words
from .grafana import bargauge, by_name, drill_down, promql, sql, stat, table, timeseries
from .layout import whole
from .rows import FLEETS, between, time
from .series import any_of, gained, largest, least, mean, of_fleet, rate, shares, total

NAME = "fleet"

RED_ABOVE_0 = [(None, "green"), (1e-9, "red")]


def dashboard():
    """The dashboard."""
    return whole(
        "vibrissa-fleet",
        "Robots, whiskers, trims, compensations, setpoints and alarms of all fleets.",
        variables.sources() + variables.supervisors() + variables.fleets(),
        [
            ("Now", now()),
            ("Whiskers and alarms", whiskers()),
            ("Trims and compensations", trims()),
            ("Setpoints", setpoints()),
            ("Where to look", tables()),
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
            "Robots that have said good-bye, or have fallen silent.",
            "none",
            promql(total(away), "away"),
            RED_ABOVE_0,
        ),
        stat(
            "Healthy whiskers",
            "Share of the whiskers that are whole, learned, and have no fault.",
            "percentunit",
            promql(f"{healthy} / {total(of_fleet('vibrissa_whiskers'))}", "healthy"),
            [(None, "red"), (0.8, "yellow"), (0.95, "green")],
        ),
        stat(
            "Alarms standing",
            "Alarms whose cause is not over.",
            "none",
            promql(f"{total(of_fleet('vibrissa_alarms_standing'))} or vector(0)", "alarms"),
            RED_ABOVE_0,
        ),
        stat(
            "Compensation error",
            "Mean measured error (Eq. 35) of the compensations in force, by their number.",
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
    """Better than the paper's case 1, than its case 2, or neither."""
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
            "ONLINE, OFFLINE after a good-bye, CONNECTION_BROKEN after none.",
            "none",
            [promql(any_of(total(of_fleet("vibrissa_robots"), "connection"), "connection"), "{{connection}}")],
            stacked=True,
        ),
        timeseries(
            "Alarms standing by kind",
            "Alarms whose cause is not over.",
            "none",
            [promql(any_of(total(of_fleet("vibrissa_alarms_standing"), "kind"), "kind"), "{{kind}}")],
            stacked=True,
        ),
        timeseries(
            "Contacts by use",
            "Contacts per second by what they were used for; all but USED and LEARNING tell nothing of lengths.",
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
            "What a healthy whisker's detector promises: the mean number of contacts from one false alarm to the next.",
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
            "Trims found in this time.",
            "none",
            promql(total(gained(of_fleet("vibrissa_trims_total"))), "trims", instant=True),
            size=(4, 8),
            defaults={"decimals": 0},
        ),
        timeseries(
            "Contacts to find a trim",
            "Contacts from the likeliest moment of a cut to the decision, of the trims found lately.",
            "none",
            [promql(mean(of_fleet, "vibrissa_trim_detection_contacts"), "mean")]
            + shares(of_fleet, "vibrissa_trim_detection_contacts", by=(0.5, 0.95)),
            size=(10, 8),
        ),
        timeseries(
            "Compensations in force",
            "Compensations that go on, by case.",
            "none",
            [promql(any_of(total(of_fleet("vibrissa_compensations_in_force"), "case"), "case"), "{{case}}")],
            size=(10, 8),
            stacked=True,
        ),
        timeseries(
            "Decisions and ends",
            "What decisions and compensations came to, per hour: STARTED and PROPOSED at first, UNSERVED where no one"
            " can, then why they ended.",
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
            "How often each case came to each outcome in this time; NONE where no one can serve.",
            "none",
            promql(any_of(by_outcome, "case", "outcome"), "{{case}}: {{outcome}}", instant=True),
            defaults={"decimals": 0},
        ),
    ]


def setpoints():
    return [
        timeseries(
            "Setpoints by state",
            "Setpoints per minute by each state that they came into.",
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
            "Until applied",
            "From the message that led to a setpoint to its APPLIED: most of it is the robot's pressure that moves.",
            "s",
            shares(of_fleet, "vibrissa_setpoint_application_seconds", by=(0.5, 0.95)),
        ),
        timeseries(
            "Under way",
            "Setpoints that are not answered finally yet, and those that were sent again per minute.",
            "none",
            [
                promql(total(of_fleet("vibrissa_setpoints_under_way")), "under way"),
                promql(f"60 * {total(rate(of_fleet('vibrissa_setpoints_resent_total')))}", "sent again per minute"),
            ],
        ),
    ]


def tables():
    to_robot = drill_down("vibrissa-robot", "Show the robot", fleet="fleet", robot="robot")
    to_whisker = drill_down(
        "vibrissa-whisker", "Show the whisker", fleet="fleet", robot="robot", array="array", whisker="whisker"
    )
    return [
        table(
            "Robots",
            "Every robot with its whiskers; a click shows it.",
            sql(ROBOTS),
            [by_name("robot", links=to_robot), by_name("heard", unit="dateTimeFromNow")],
        ),
        table(
            "Standing alarms",
            "Alarms whose cause is not over, the newest first; a click shows the whisker.",
            sql(ALARMS),
            [by_name("whisker", links=to_whisker), by_name("robot", links=to_robot)],
            (12, 9),
        ),
        table(
            "Newest trims",
            "Trims of this time, the newest first; a click shows the whisker.",
            sql(TRIMS),
            [by_name("whisker", links=to_whisker), by_name("robot", links=to_robot)]
            + [by_name(name, unit="lengthmm", decimals=1) for name in ("before", "after", "+-")],
            (12, 9),
        ),
    ]


ROBOTS = f"""
    SELECT r.fleet, r.robot, r.connection, r.model, count(w.whisker_id) AS whiskers,
        count(*) FILTER (WHERE w.condition = 'HEALTHY' AND w.fault IS NULL) AS healthy,
        count(*) FILTER (WHERE w.condition = 'TRIMMED') AS trimmed,
        count(*) FILTER (WHERE w.fault IS NOT NULL) AS faults,
        (SELECT count(*) FROM alarms o JOIN whiskers x USING (whisker_id)
            WHERE x.robot_id = r.robot_id AND o.cleared_us IS NULL) AS alarms,
        coalesce(sum(w.contacts), 0)::bigint AS contacts, r.held, {time("max(w.heard_us)")} AS heard
    FROM robots r LEFT JOIN whiskers w ON w.robot_id = r.robot_id AND w.position IS NOT NULL
    WHERE {FLEETS} GROUP BY r.robot_id ORDER BY alarms DESC, trimmed DESC, r.fleet, r.robot
"""

ALARMS = f"""
    SELECT {rows.PLACE}, o.kind, {time("o.raised_us")} AS raised, o.acknowledged_by AS "acknowledged by"
    FROM alarms o {rows.OF_WHISKER}
    WHERE {FLEETS} AND o.cleared_us IS NULL ORDER BY o.raised_us DESC LIMIT 200
"""

TRIMS = f"""
    SELECT {rows.PLACE}, {time("t.detected_us")} AS found, t.length_before_mm AS before, t.length_after_mm AS after,
        {rows.Z95} * t.length_after_sd_mm AS "+-", t.contacts_to_detect AS contacts
    FROM trims t {rows.OF_WHISKER}
    WHERE {FLEETS} AND {between("t.detected_us")} ORDER BY t.detected_us DESC LIMIT 200
"""
