//! Charts of recorded data of whiskers and compensations.

use super::lines::{Across, Lines, Mark, Point, Shape};
use vibrissa_core::mechanics::CONTACT_RATIOS;
use vibrissa_store::lists::compensations::{CompensationSummary, Numbers, RatioError};
use vibrissa_store::lists::errors::ErrorStatement;
use vibrissa_store::lists::setpoints::Setpoint;
use vibrissa_store::lists::whiskers::Whisker;
use vibrissa_store::series::{ContactMean, Series};
use vibrissa_store::time::Time;

/// The paper's measured mean error of case 1 and self-compensation.
const PAPER_ERROR: f64 = 0.203_85;
/// Half the width of a 95 % interval, in standard deviations.
const Z95: f64 = 1.959_963_984_540_054;

fn name(whisker: &Whisker) -> String {
    format!("{}/{}/{}", whisker.robot, whisker.array, whisker.whisker)
}

/// Time range and number of points, in words.
fn span(series: &Series) -> String {
    match (series.items.first(), series.items.last()) {
        (Some(first), Some(last)) => {
            let [from, to] = [first, last].map(|one| Time(one.at_us).to_string());
            format!("From {from} to {to}, {} contacts in {} points.", series.total, series.items.len())
        }
        _ => "Nothing recorded yet.".to_owned(),
    }
}

fn points(series: &Series, y: impl Fn(&ContactMean) -> Option<f64>) -> Vec<Point> {
    series.items.iter().filter_map(|one| Some(Point::at(one.at_us as f64, y(one)?))).collect()
}

/// Estimated length over time.
pub(crate) fn lengths(whisker: &Whisker, series: &Series) -> String {
    let with_bounds = series.items.iter().map(|one| {
        let half = Z95 * one.length_sd_mm;
        let bounds = Some((one.length_mm - half, one.length_mm + half));
        Point { x: one.at_us as f64, y: one.length_mm, bounds }
    });
    let told = match (series.items.first(), series.items.last()) {
        (Some(first), Some(last)) => format!(
            " {:.1} mm at first, {:.1} mm at last (95 % interval {:.1} to {:.1} mm); {:.1} mm when whole.",
            first.length_mm,
            last.length_mm,
            last.length_mm - Z95 * last.length_sd_mm,
            last.length_mm + Z95 * last.length_sd_mm,
            whisker.whole_length_mm
        ),
        _ => String::new(),
    };
    Lines {
        title: format!("Estimated length, {}", name(whisker)),
        desc: span(series) + &told,
        across: Across::Time,
        up: "length, mm",
        up_at_least: (whisker.whole_length_mm - 1.0, whisker.whole_length_mm + 0.5),
        marks: vec![
            Mark::Line {
                class: "p-a",
                dash: "",
                label: "length, 95 % interval".to_owned(),
                points: with_bounds.collect(),
            },
            Mark::Level {
                class: "p-m",
                dash: "7 4",
                label: format!("whole, {:.1} mm", whisker.whole_length_mm),
                y: whisker.whole_length_mm,
            },
        ],
    }
    .draw()
}

/// Ratio of measured to predicted sensitivity over time.
pub(crate) fn contacts(whisker: &Whisker, series: &Series) -> String {
    let ratios = points(series, |one| one.residual.map(f64::exp));
    let count = ratios.len().max(1) as f64;
    let mean = ratios.iter().map(|point| point.y).sum::<f64>() / count;
    let told = if ratios.is_empty() { String::new() } else { format!(" Measured / predicted: {mean:.3} on average.") };
    Lines {
        title: format!("Sensitivity against the model, {}", name(whisker)),
        desc: span(series) + &told,
        across: Across::Time,
        up: "measured / predicted",
        up_at_least: (0.95, 1.05),
        marks: vec![
            Mark::Points { class: "p-a", shape: Shape::Dot, label: "contacts".to_owned(), points: ratios },
            Mark::Level { class: "p-m", dash: "7 4", label: "as predicted".to_owned(), y: 1.0 },
        ],
    }
    .draw()
}

/// Measured pressures and setpoints over time. `setpoints` are in the order in which they were sent.
pub(crate) fn pressures(whisker: &Whisker, series: &Series, setpoints: &[Setpoint]) -> String {
    let (first, last) = (series.items.first(), series.items.last());
    let mut set = Vec::new();
    if let (Some(first), Some(last)) = (first, last) {
        let (from, to) = (first.at_us as f64, last.at_us as f64);
        let mut held = whisker.nominal_pressure_mpa;
        set.push((from, held));
        for one in setpoints {
            let at = (one.issued_at.0 as f64).clamp(from, to);
            set.push((at, held));
            held = one.pressure_mpa;
            set.push((at, held));
        }
        set.push((to, held));
    }
    let told = match (last, set.last()) {
        (Some(last), Some((_, held))) => format!(
            " Last measured {:.4} MPa, last set {held:.4} MPa, nominal {:.3} MPa.",
            last.pressure_mpa, whisker.nominal_pressure_mpa
        ),
        _ => String::new(),
    };
    let set = set.into_iter().map(|(x, y)| Point::at(x, y)).collect();
    Lines {
        title: format!("Pressure, {}", name(whisker)),
        desc: span(series) + &told,
        across: Across::Time,
        up: "pressure, MPa",
        up_at_least: (0.0, whisker.nominal_pressure_mpa),
        marks: vec![
            Mark::Line { class: "p-b", dash: "8 4", label: "set".to_owned(), points: set },
            Mark::Points {
                class: "p-a",
                shape: Shape::Dot,
                label: "measured".to_owned(),
                points: points(series, |one| Some(one.pressure_mpa)),
            },
        ],
    }
    .draw()
}

/// Measured error of the compensations for a whisker over time, oldest first.
pub(crate) fn errors(whisker: &Whisker, statements: &[ErrorStatement]) -> String {
    let percent = |one: &ErrorStatement| Point {
        x: one.recorded_at.0 as f64,
        y: 100.0 * one.error,
        bounds: Some((100.0 * one.error_low, 100.0 * one.error_high)),
    };
    let with_gain = statements.iter().filter_map(|one| {
        let bounds = one.error_with_gain_low.zip(one.error_with_gain_high);
        Some(Point {
            x: one.recorded_at.0 as f64,
            y: 100.0 * one.error_with_gain?,
            bounds: bounds.map(|(low, high)| (100.0 * low, 100.0 * high)),
        })
    });
    let told = statements.last().map_or_else(
        || "Nothing measured yet.".to_owned(),
        |last| {
            format!(
                "{} statements from {} to {}. The last: {:.1} % (95 % interval {:.1} to {:.1} %), the paper measured {:.1} %.",
                statements.len(),
                statements.first().map(|first| first.recorded_at.to_string()).unwrap_or_default(),
                last.recorded_at,
                100.0 * last.error,
                100.0 * last.error_low,
                100.0 * last.error_high,
                100.0 * PAPER_ERROR
            )
        },
    );
    Lines {
        title: format!("Compensation error for {}", name(whisker)),
        desc: told,
        across: Across::Time,
        up: "error (Eq. 35), %",
        up_at_least: (0.0, 25.0),
        marks: vec![
            Mark::Line {
                class: "p-a",
                dash: "",
                label: "measured, 95 % interval".to_owned(),
                points: statements.iter().map(percent).collect(),
            },
            Mark::Line { class: "p-c", dash: "3 3", label: "with gain".to_owned(), points: with_gain.collect() },
            paper(),
        ],
    }
    .draw()
}

fn paper() -> Mark {
    Mark::Level {
        class: "p-m",
        dash: "7 4",
        label: format!("paper, {:.1} %", 100.0 * PAPER_ERROR),
        y: 100.0 * PAPER_ERROR,
    }
}

/// Error of a compensation by contact ratio: predicted and measured.
pub(crate) fn by_ratio(one: &CompensationSummary, predicted: Option<&Numbers>, measured: &[RatioError]) -> String {
    let predicted = predicted.map(|numbers| numbers.0.as_slice()).unwrap_or_default();
    let predicted: Vec<Point> =
        CONTACT_RATIOS.iter().zip(predicted).map(|(ratio, error)| Point::at(*ratio, 100.0 * error)).collect();
    let measured = measured.iter().map(|bin| Point {
        x: bin.ratio,
        y: 100.0 * bin.error,
        bounds: Some((100.0 * bin.error_low, 100.0 * bin.error_high)),
    });
    let measured: Vec<Point> = measured.collect();
    let told = |what: &str, error: Option<f64>| {
        error.map_or_else(|| format!("Nothing {what}. "), |error| format!("{:.1} % {what} on average. ", 100.0 * error))
    };
    let by = one.compensator_whisker.map_or_else(|| "no compensator".to_owned(), |by| by.to_string());
    let each = measured.iter().map(|point| format!("{:.1} % at {:.2}", point.y, point.x)).collect::<Vec<_>>();
    Lines {
        title: format!("Error by contact ratio: {by} for {}/{}/{}", one.robot, one.array, one.target_whisker),
        desc: format!(
            "{}{}{}",
            told("predicted", one.predicted_error),
            told("measured", one.measured_error),
            each.join(", ")
        ),
        across: Across::Number("contact ratio", 0.425, 1.025),
        up: "error (Eq. 35), %",
        up_at_least: (0.0, 25.0),
        marks: vec![
            Mark::Points {
                class: "p-a",
                shape: Shape::Dot,
                label: "measured, 95 % interval".to_owned(),
                points: measured,
            },
            Mark::Line { class: "p-b", dash: "6 3", label: String::new(), points: predicted.clone() },
            Mark::Points { class: "p-b", shape: Shape::Diamond, label: "predicted".to_owned(), points: predicted },
            paper(),
        ],
    }
    .draw()
}
