//! An array drawn to scale, seen from the side: one row for each line of whiskers, tips upwards.

use super::svg::{Anchor, Svg};
use vibrissa_core::robot::effect::{Condition, Fault};
use vibrissa_core::robot::event::GaugeState;
use vibrissa_edge::words::{Word as _, named};
use vibrissa_store::lists::whiskers::Whisker;

/// Space above the longest whisker of a row, for arrows.
const ABOVE: f64 = 46.0;
/// Space below the array's surface, for labels.
const BELOW: f64 = 96.0;
/// Width of a whisker's labels.
const COLUMN: f64 = 88.0;
/// Letters of a word that fit a column.
const WORD_MAX: usize = 11;
/// Maximum vertical scale, in units of the picture per mm.
const UP_MAX: f64 = 3.6;
const HEAD: f64 = 82.0;
/// Half widths at the base and at the whole tip.
const BASE: f64 = 7.0;
const TIP: f64 = 2.2;
const WIDTH_MIN: f64 = 420.0;
/// Whiskers closer than this in y are in the same row.
const ROW_MM: f64 = 1.0;

/// Health of a whisker as a word, a shape and a colour.
struct Health<'a> {
    word: &'a str,
    shape: &'static str,
    class: &'static str,
}

fn health(whisker: &Whisker) -> Health<'_> {
    if let Some(fault) = &whisker.fault {
        return Health { word: fault, shape: "\u{2716}", class: "p-b" };
    }
    let (shape, class) = match named(&whisker.condition) {
        Some(Condition::Healthy) => ("\u{25cf}", "p-c"),
        Some(Condition::Trimmed) => ("\u{25bc}", "p-b"),
        Some(Condition::Eroding | Condition::SensitivityLoss) => ("\u{25e2}", "p-b"),
        Some(Condition::Suspected) => ("\u{25c6}", "p-a"),
        Some(Condition::Learning) | None => ("\u{25cb}", "p-m"),
    };
    Health { word: &whisker.condition, shape, class }
}

/// Positions of the whiskers in the picture.
struct Layout<'a> {
    px_per_mm: f64,
    left_mm: f64,
    /// Position of `left_mm` in the picture.
    left: f64,
    width: f64,
    rows: Vec<Vec<&'a Whisker>>,
}

impl<'a> Layout<'a> {
    fn of(whiskers: &'a [Whisker]) -> Self {
        let mut sorted: Vec<&Whisker> = whiskers.iter().collect();
        // The farthest row is drawn first, as seen from the front.
        sorted.sort_by(|a, b| b.y_mm.total_cmp(&a.y_mm).then(a.x_mm.total_cmp(&b.x_mm)));
        let mut rows: Vec<Vec<&Whisker>> = Vec::new();
        for one in sorted {
            match rows.last_mut() {
                Some(row) if (row[0].y_mm - one.y_mm).abs() < ROW_MM => row.push(one),
                _ => rows.push(vec![one]),
            }
        }
        for row in &mut rows {
            row.sort_by(|a, b| a.x_mm.total_cmp(&b.x_mm));
        }
        let nearest = rows.iter().flat_map(|row| row.windows(2)).map(|pair| pair[1].x_mm - pair[0].x_mm);
        let nearest_mm = nearest.filter(|gap| *gap > 0.1).fold(f64::INFINITY, f64::min);
        let (left_mm, right_mm) = whiskers
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), one| (low.min(one.x_mm), high.max(one.x_mm)));
        let (left_mm, span_mm) = if left_mm <= right_mm { (left_mm, right_mm - left_mm) } else { (0.0, 0.0) };
        // Labels must not overlap, however close the whiskers are.
        let px_per_mm = (COLUMN / nearest_mm).clamp(1.6, 12.0);
        let needed = span_mm * px_per_mm + COLUMN + 16.0;
        let width = needed.max(WIDTH_MIN);
        Self { px_per_mm, left_mm, left: 0.5 * (width - needed + COLUMN + 16.0), width, rows }
    }

    fn x(&self, whisker: &Whisker) -> f64 {
        self.left + (whisker.x_mm - self.left_mm) * self.px_per_mm
    }

    fn row_height(&self, row: &[&Whisker]) -> f64 {
        let longest_mm = row.iter().map(|one| one.whole_length_mm.max(one.length_mm)).fold(0.0, f64::max);
        ABOVE + longest_mm * self.px_per_mm.min(UP_MAX) + BELOW
    }
}

/// Draws the array.
pub(crate) fn draw(array: &str, whiskers: &[Whisker]) -> String {
    let layout = Layout::of(whiskers);
    // Vertical and horizontal scales are equal, unless the whiskers are so close that their labels need space.
    let up = layout.px_per_mm.min(UP_MAX);
    let height = HEAD + layout.rows.iter().map(|row| layout.row_height(row)).sum::<f64>();
    let mut svg = Svg::new(layout.width, height.max(120.0));
    svg.raw(ARROW);
    svg.text("p-ink p-title", (8.0, 20.0), Anchor::Start, &format!("Array {array}"));
    scales(&mut svg, layout.px_per_mm, up);
    let mut top = HEAD;
    let mut tips = Vec::new();
    for row in &layout.rows {
        top += layout.row_height(row);
        let base = top - BELOW;
        svg.line("p-axis", (6.0, base), (layout.width - 6.0, base), "");
        for whisker in row {
            let x = layout.x(whisker);
            body(&mut svg, whisker, (x, base), up);
            words(&mut svg, whisker, (x, base));
            tips.push((*whisker, x, base - whisker.whole_length_mm.max(whisker.length_mm) * up));
        }
    }
    arrows(&mut svg, &tips);
    svg.document(&format!("Array {array}"), &described(whiskers))
}

const ARROW: &str = "<defs><marker id=\"p-head\" viewBox=\"0 0 10 10\" refX=\"8\" refY=\"5\" markerWidth=\"5\" \
    markerHeight=\"5\" orient=\"auto-start-reverse\"><path class=\"p-a\" d=\"M0 0L10 5L0 10Z\"/></marker></defs>";

/// Scale bars of 20 mm.
fn scales(svg: &mut Svg, across: f64, up: f64) {
    let (x, y) = (8.0, 44.0);
    let both = (across - up).abs() < 1e-9;
    let mut bar = |x: f64, px_per_mm: f64, label: &str| {
        let end = x + 20.0 * px_per_mm;
        svg.line("p-axis", (x, y), (end, y), "");
        svg.line("p-axis", (x, y - 5.0), (x, y + 5.0), "");
        svg.line("p-axis", (end, y - 5.0), (end, y + 5.0), "");
        svg.text("p-soft p-small", (end + 6.0, y + 4.0), Anchor::Start, label);
        end
    };
    if both {
        bar(x, across, "20 mm");
    } else {
        let end = bar(x, up, "20 mm up");
        bar(end + 76.0, across, "20 mm across");
    }
    svg.text("p-soft p-small", (8.0, 68.0), Anchor::Start, "dashed: whole; solid: present");
}

/// A whisker: its whole length as an outline, its present length as a solid shape.
fn body(svg: &mut Svg, whisker: &Whisker, (x, base): (f64, f64), up: f64) {
    let half = |length_mm: f64| BASE + (TIP - BASE) * (length_mm / whisker.whole_length_mm.max(1.0)).min(1.0);
    let shape = |length_mm: f64| {
        let (tip, wide) = (base - length_mm * up, half(length_mm));
        [(x - BASE, base), (x - wide, tip), (x + wide, tip), (x + BASE, base)]
    };
    svg.path(&format!("{} p-body", health(whisker).class), &shape(whisker.length_mm), true, "");
    svg.path("p-m p-open", &shape(whisker.whole_length_mm), true, "3 3");
}

fn words(svg: &mut Svg, whisker: &Whisker, (x, base): (f64, f64)) {
    let health = health(whisker);
    let pressure = whisker.pressure_mpa.unwrap_or(whisker.setpoint_mpa);
    svg.text("p-ink p-title", (x, base + 19.0), Anchor::Middle, &whisker.whisker.to_string());
    svg.text(&format!("{} p-small", health.class), (x, base + 37.0), Anchor::Middle, &short(health.shape, health.word));
    svg.text("p-ink p-small", (x, base + 54.0), Anchor::Middle, &format!("{:.1} mm", whisker.length_mm));
    svg.text("p-ink p-small", (x, base + 71.0), Anchor::Middle, &format!("{pressure:.3} MPa"));
}

/// A label that fits its column.
fn short(shape: &str, word: &str) -> String {
    let word = if word == Condition::SensitivityLoss.word() {
        "FEELS LESS".to_owned()
    } else if word == Fault::Gauge(GaugeState::Saturated).word() {
        "GAUGE FULL".to_owned()
    } else if word.len() > WORD_MAX {
        let start: String = word.chars().take(WORD_MAX - 1).collect();
        format!("{}\u{2026}", start.replace('_', " "))
    } else {
        word.replace('_', " ")
    };
    format!("{shape} {word}")
}

/// Pairs of compensator and target.
fn pairs<T>(all: &[T], whisker: impl Fn(&T) -> &Whisker + Copy) -> impl Iterator<Item = (&T, &T)> {
    all.iter().filter_map(move |target| {
        let by = whisker(target).compensated_by?;
        Some((all.iter().find(|one| whisker(one).serves_in == Some(by))?, target))
    })
}

/// Arrows from compensators to their targets; a loop for self-compensation.
fn arrows(svg: &mut Svg, tips: &[(&Whisker, f64, f64)]) {
    for (by, target) in pairs(tips, |tip| tip.0) {
        let ((x1, y1), (x2, y2)) = ((by.1, by.2 - 5.0), (target.1, target.2 - 5.0));
        if by.0.whisker == target.0.whisker {
            let (left, right, up) = (x1 - 9.0, x1 + 9.0, y1 - 24.0);
            svg.raw(format_args!(
                "<path class=\"p-a p-line\" d=\"M{left:.1} {y1:.1}C{:.1} {up:.1} {:.1} {up:.1} {right:.1} {y1:.1}\" \
                 marker-end=\"url(#p-head)\"/>",
                left - 6.0,
                right + 6.0
            ));
            svg.text("p-a p-small", (x1, y1 - 24.0), Anchor::Middle, "serves itself");
        } else {
            let (middle, up) = (0.5 * (x1 + x2), y1.min(y2) - 30.0);
            svg.raw(format_args!(
                "<path class=\"p-a p-line\" d=\"M{x1:.1} {y1:.1}Q{middle:.1} {up:.1} {x2:.1} {y2:.1}\" \
                 marker-end=\"url(#p-head)\"/>"
            ));
            let label = format!("{} serves {}", by.0.whisker, target.0.whisker);
            svg.text("p-a p-small", (middle, 0.5 * (up + y1.min(y2)) - 5.0), Anchor::Middle, &label);
        }
    }
}

/// The picture described in words.
fn described(whiskers: &[Whisker]) -> String {
    let each = whiskers.iter().map(|one| {
        format!(
            "whisker {} at {:.0}, {:.0} mm is {}, {:.1} of {:.1} mm long, at {:.3} MPa",
            one.whisker,
            one.x_mm,
            one.y_mm,
            health(one).word,
            one.length_mm,
            one.whole_length_mm,
            one.pressure_mpa.unwrap_or(one.setpoint_mpa)
        )
    });
    let served = pairs(whiskers, |one| one).map(|(by, target)| format!("{} serves {}", by.whisker, target.whisker));
    let all: Vec<String> = each.chain(served).collect();
    if all.is_empty() { "No whiskers.".to_owned() } else { format!("{}.", all.join("; ")) }
}
