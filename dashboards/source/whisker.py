"""One whisker: length, sensitivity, pressure and compensation error over time, and its decisions."""

from . import rows, variables, whisker_rows, words
from .fleet import error_steps
from .grafana import Sql, by_name, drill_down, hidden, to_console
from .layout import whole
from .panels import barchart, newest, stat, table, timeline, timeseries
from .rows import WHISKER, WHISKERS

NAME = "whisker"

THIS = f"FROM {WHISKERS} WHERE {WHISKER}"


def dashboard():
    """The dashboard."""
    return whole(
        "vibrissa-whisker",
        "One whisker: length, sensitivity, pressure and compensation error over time, decisions with all candidates.",
        # No query goes to Prometheus, but links to the other dashboards pass its data source on.
        variables.sources() + variables.console() + variables.supervisors() + variables.whisker(),
        [
            ("Now", now()),
            ("Length and sensitivity", lengths()),
            ("Pressure", pressures()),
            ("Compensation error", errors()),
            ("Decisions, setpoints, alarms", tables()),
        ],
        rows.happenings(WHISKER),
        console="fleets/${fleet}/robots/${robot}/arrays/${array}/whiskers/${whisker}",
    )


def now():
    one = lambda column: Sql(f"SELECT {column} {THIS}")
    health = stat(
        "Health", "Its fault or, without one, its condition.", "string", one("coalesce(w.fault, w.condition) AS health")
    )
    return [
        health.reduce_options(newest("/.*/")),
        stat("Length", "Estimated length now.", "lengthmm", one("w.length_mm AS length")).decimals(1),
        stat(
            "Lost",
            "Difference between the whole length and the present length.",
            "lengthmm",
            one("w.whole_length_mm - w.length_mm AS lost"),
        ).decimals(1),
        stat("Setpoint", "The pressure that it should have.", "pressurepa", one("1e6 * w.setpoint_mpa AS setpoint")),
        stat(
            "Compensation error",
            "The newest measured error of its compensation, as target or as compensator.",
            "percentunit",
            Sql(whisker_rows.NEWEST_ERROR),
            error_steps(),
        ),
        stat("Contacts", "Contacts since the first factsheet.", "locale", one("w.contacts")),
    ]


def band(low, high, of):
    """Draws the area between two series."""
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
            [Sql(whisker_rows.LENGTH, "time_series")],
            size=(12, 10),
            from_0=False,
        ).overrides(band("low", "high", "length")),
        timeseries(
            "Sensitivity against the model's",
            "Measured over predicted sensitivity of the used contacts: 100 % where the estimated length explains the"
            " readings.",
            "percentunit",
            [Sql(whisker_rows.RESIDUAL, "time_series")],
            size=(12, 10),
            from_0=False,
        ).overrides(band("low", "high", "measured over predicted")),
        timeline(
            "Health",
            "Its fault or, without one, its condition.",
            [Sql(whisker_rows.HEALTH)],
            words.HEALTH,
            (12, 6),
        ),
        timeseries(
            "Contacts by use",
            "Contacts per panel's interval by their use; times are the robot's.",
            "none",
            [Sql(whisker_rows.USE, "time_series")],
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
            "Setpoint, and pressure that the robot measured at contacts.",
            "pressurepa",
            [Sql(whisker_rows.PRESSURE, "time_series"), Sql(whisker_rows.SETPOINT, "time_series")],
            size=(14, 9),
        ).overrides([stepped]),
        barchart(
            "Sensitivity by contact ratio",
            "Measured strain per millimetre of deflection in the selected time: it falls with the distance from the"
            " base.",
            "none",
            Sql(whisker_rows.SENSITIVITY),
            "contact ratio",
            (10, 9),
        ),
    ]


def errors():
    return [
        timeseries(
            "Compensation error over time",
            "Measured error (Eq. 35) of its compensations with the 95 % interval, the predicted error, and the error"
            " with the published gain.",
            "percentunit",
            [Sql(whisker_rows.ERROR, "time_series")],
            size=(12, 10),
        ).overrides(band("low", "high", "measured")),
        barchart(
            "Compensation error by contact ratio",
            "As Fig. 10 of the paper: the newest measured error of its compensation with the 95 % interval, and the"
            " predicted error.",
            "percentunit",
            Sql(whisker_rows.BY_RATIO),
            "contact ratio",
            (12, 10),
        ),
    ]


def tables():
    other = drill_down(
        "vibrissa-whisker", "Show this whisker", fleet="fleet", robot="robot", array="array", whisker="candidate"
    ) + to_console("fleets", ":fleet", "robots", ":robot", "arrays", ":array", "whiskers", ":candidate")
    places = hidden("fleet", "robot", "array")
    shares = [by_name(name, unit="percentunit", decimals=1) for name in ("predicted", "low", "high")]
    in_pascals = lambda *names: [by_name(name, unit="pressurepa") for name in names]
    return [
        table(
            "Decisions and candidates",
            "Decisions about this whisker in the selected time: all candidates, the predictions of Eq. 34 and 35, and"
            " the reason why each was refused; click a candidate to open it.",
            Sql(whisker_rows.CANDIDATES),
            [
                by_name("candidate", links=other),
                *places,
                *shares,
                *in_pascals("pressure", "before"),
                by_name("length", unit="lengthmm", decimals=1),
            ],
            (24, 10),
        ),
        table(
            "Trims",
            "Trims detected in the selected time.",
            Sql(whisker_rows.TRIMS),
            [by_name(name, unit="lengthmm", decimals=1) for name in ("before", "after", "+-")],
            (8, 9),
        ),
        table(
            "Setpoints",
            "Its setpoints in the selected time with each state that they reached, newest first.",
            Sql(whisker_rows.SETPOINTS),
            in_pascals("pressure", "reached"),
            (16, 9),
        ),
        table(
            "Reviews of its compensation",
            "Reviews of the setpoints of its compensations, newest first.",
            Sql(whisker_rows.REFINEMENTS),
            [by_name(name, unit="percentunit", decimals=1) for name in ("error", "with gain", "expected")]
            + in_pascals("pressure", "best"),
            (12, 9),
        ),
        table(
            "Alarms",
            "Its alarms of the selected time and standing alarms, newest first.",
            Sql(whisker_rows.ALARMS),
            [],
            (12, 9),
        ),
    ]
