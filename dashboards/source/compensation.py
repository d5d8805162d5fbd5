"""Compensation errors over time, by case and contact ratio, compared with the paper and with predictions."""

from . import rows, variables, words
from .fleet import error_steps, in_force
from .grafana import CONSOLE_ROBOT, CONSOLE_WHISKER, Sql, by_name, drill_down, promql
from .layout import whole
from .panels import barchart, bargauge, heatmap, stat, table, timeseries, xychart
from .rows import FLEETS, between
from .series import any_of, buckets, gained, largest, mean, of_fleet, quantile, rate, total

NAME = "compensation"

MEASURED = "vibrissa_compensation_error_mean_ratio"
WITH_GAIN = "vibrissa_compensation_error_with_gain_mean_ratio"
AIR_ALONE = "vibrissa_compensation_air_error_mean_ratio"
PREDICTED = "vibrissa_compensation_predicted_error_mean_ratio"
CASE_1, CASE_2 = "paper, case 1 (shorter for longer, and itself)", "paper, case 2 (longer for shorter)"
DASHED = {"custom__lineStyle": {"fill": "dash", "dash": [10, 10]}, "custom__showPoints": "never"}
PAPER_LINES = [
    by_name(CASE_1, color={"mode": "fixed", "fixedColor": "green"}, **DASHED),
    by_name(CASE_2, color={"mode": "fixed", "fixedColor": "orange"}, **DASHED),
]


def dashboard():
    """The dashboard."""
    return whole(
        "vibrissa-compensation",
        "Compensation errors (Eq. 35): over time, by case, by contact ratio, and compared with predictions.",
        variables.sources() + variables.console() + variables.supervisors() + variables.fleets(),
        [
            ("Compensations in force", now()),
            ("Over time", over_time()),
            ("By contact ratio, and compared with predictions", by_ratio()),
            ("Largest errors", tables()),
            ("The closed loop", refinements()),
        ],
        rows.happenings(FLEETS),
    )


def paper():
    return [promql(f"vector({words.PAPER_CASE_1})", CASE_1), promql(f"vector({words.PAPER_CASE_2})", CASE_2)]


def weighted(name):
    """The mean over all compensations in force, weighted by their number in each case."""
    count = f"({of_fleet('vibrissa_compensations_in_force')} and {of_fleet(name)})"
    return f"{total(f'{of_fleet(name)} * {count}')} / {total(count)}"


def now():
    limit = promql(largest(of_fleet("vibrissa_compensation_error_limit_ratio")), "limit")
    worst = promql(largest(of_fleet("vibrissa_compensation_error_worst_ratio")), "worst")
    share = lambda title, description, target, steps=None: stat(title, description, "percentunit", target, steps)
    return [
        share(
            "Measured",
            "Mean measured error, weighted by the number of each case.",
            promql(weighted(MEASURED), "measured"),
            error_steps(),
        ),
        share(
            "With the gain",
            "The same with the published gain applied to the compensators' strain.",
            promql(weighted(WITH_GAIN), "with gain"),
            error_steps(),
        ),
        share("Predicted", "Mean error predicted at their decision.", promql(weighted(PREDICTED), "predicted")),
        share("Worst", "Largest measured error of one compensation.", worst, error_steps()),
        share("Limit", "The policy's limit of the predicted error: above it no candidate is chosen.", limit),
        stat(
            "In force", "Compensations in force with a measured error.", "none", promql(total(in_force()), "in force")
        ),
    ]


def over_time():
    by_case = lambda name, what: promql(f"avg by (case) ({of_fleet(name)})", what + ", {{case}}")
    stated = "vibrissa_compensation_error_ratio"
    return [
        timeseries(
            "Compensation error by case",
            "Mean measured error of the compensations in force, and the values measured in the paper: 20.385 % for a"
            " shorter whisker that compensates for a longer one (self-compensation included), 36.18 % for a longer one"
            " that compensates for a shorter one.",
            "percentunit",
            [promql(f"avg by (case) ({of_fleet(MEASURED)})", "{{case}}")] + paper(),
            size=(12, 10),
        ).overrides(PAPER_LINES),
        timeseries(
            "Predicted, measured, with the gain, by air alone",
            "By case: predicted error, measured error of the reading, and measured error with the published gain. For"
            " robots that apply a gain also the error of the air alone.",
            "percentunit",
            [
                by_case(PREDICTED, "predicted"),
                by_case(MEASURED, "measured"),
                by_case(WITH_GAIN, "with gain"),
                by_case(AIR_ALONE, "air alone"),
            ],
            size=(12, 10),
        ),
        heatmap(
            "Reported errors",
            "Number of errors in each range; an error is reported again as contacts arrive.",
            "percentunit",
            promql(buckets(of_fleet, stated), "{{le}}"),
        ),
        timeseries(
            "Reported errors: mean and quantiles",
            "Mean and quantiles of recently reported errors.",
            "percentunit",
            [
                promql(mean(of_fleet, stated), "mean"),
                promql(quantile(0.5, of_fleet, stated), "50 %"),
                promql(quantile(0.9, of_fleet, stated), "90 %"),
            ]
            + paper(),
            size=(12, 8),
        ).overrides(PAPER_LINES),
    ]


def by_ratio():
    identity = by_name("any", custom__show="lines", color={"mode": "fixed", "fixedColor": "text"})
    return [
        barchart(
            "Compensation error by contact ratio",
            "As Fig. 10 of the paper, at the same contact ratios: the newest measured errors of the compensations in"
            " the selected time, averaged by case, and the predicted errors.",
            "percentunit",
            Sql(BY_RATIO),
            "contact ratio",
            (14, 10),
        ),
        xychart(
            "Predicted against measured",
            "One point for each compensation, with its newest measured error: points below the line are better than"
            " predicted.",
            "percentunit",
            [Sql(AGAINST), Sql('SELECT unnest(ARRAY[0, 0.6]) AS same, unnest(ARRAY[0, 0.6]) AS "any"')],
            [
                (0, "predicted", "measured", "measured"),
                (0, "predicted", "with gain", "with the gain"),
                (1, "same", "any", "as predicted"),
            ],
            (10, 10),
        ).overrides([identity]),
    ]


def tables():
    to_whisker = drill_down(
        "vibrissa-whisker", "Show the whisker", fleet="fleet", robot="robot", array="array", whisker="whisker"
    ) + CONSOLE_WHISKER
    to_robot = drill_down("vibrissa-robot", "Show the robot", fleet="fleet", robot="robot") + CONSOLE_ROBOT
    errors = [
        by_name(name, unit="percentunit", decimals=1) for name in ("measured", "low", "high", "with gain", "predicted")
    ]
    pressures = [by_name(name, unit="pressurepa") for name in ("pressure", "before")]
    return [
        table(
            "Worst whiskers",
            "Compensations in force with the 95 % interval of their measured error, largest first; click a whisker to"
            " open it.",
            Sql(WORST),
            [by_name("whisker", links=to_whisker), by_name("robot", links=to_robot), *errors, *pressures],
            (24, 10),
        ),
    ]


def refinements():
    outcomes = total(gained(of_fleet("vibrissa_refinements_total")), "outcome")
    return [
        timeseries(
            "Reviews of setpoints",
            "Reviews of compensations' setpoints per hour by outcome: REFINED, or the reason why the pressure stays.",
            "none",
            [
                promql(
                    any_of(f"3600 * {total(rate(of_fleet('vibrissa_refinements_total')), 'outcome')}", "outcome"),
                    "{{outcome}}",
                )
            ],
            size=(12, 8),
            bars=True,
            stacked=True,
        ),
        bargauge(
            "Outcomes",
            "Number of reviews by outcome in the selected time.",
            "none",
            promql(outcomes, "{{outcome}}").instant(),
        ).decimals(0),
    ]


# The newest error of each compensation in the selected time.
NEWEST = f"""
    compensations c JOIN robots r USING (robot_id)
    CROSS JOIN LATERAL (
        SELECT e.* FROM compensation_errors e
        WHERE e.compensation_id = c.compensation_id AND {between("e.recorded_us")}
        ORDER BY e.recorded_us DESC LIMIT 1
    ) e
"""

MEASURED_CASES = ",\n        ".join(
    f"""avg(b.error) FILTER (WHERE c.compensation_case = '{case}') AS "{label}" """.strip()
    for case, label in words.CASES.items()
)

BY_RATIO = f"""
    SELECT to_char(b.ratio, 'FM0.00') AS "contact ratio",
        {MEASURED_CASES},
        avg(p.predicted) AS predicted
    FROM {NEWEST.strip()}
    JOIN compensation_error_bins b ON b.compensation_error_id = e.compensation_error_id
    {rows.PREDICTED_AT_RATIO.strip()}
    WHERE {FLEETS} GROUP BY b.ratio ORDER BY b.ratio
"""

AGAINST = f"""
    SELECT c.predicted_error AS predicted, e.error AS measured, e.error_with_gain AS "with gain"
    FROM {NEWEST.strip()}
    WHERE {FLEETS} AND c.predicted_error IS NOT NULL
"""

WORST = f"""
    SELECT {rows.PLACE}, c.compensation_case AS "case", s.whisker AS "served by", e.error AS measured,
        e.error_low AS low,
        e.error_high AS high, e.error_with_gain AS "with gain", c.predicted_error AS predicted, e.contacts,
        1e6 * e.pressure_mpa AS pressure, 1e6 * c.pressure_before_mpa AS before
    FROM compensations c
    {rows.OF_TARGET}
    JOIN whiskers s ON s.whisker_id = c.compensator_whisker_id
    CROSS JOIN LATERAL (
        SELECT * FROM compensation_errors e
        WHERE e.compensation_id = c.compensation_id ORDER BY e.recorded_us DESC LIMIT 1
    ) e
    WHERE {FLEETS} AND c.ended_us IS NULL ORDER BY e.error DESC LIMIT 50
"""
