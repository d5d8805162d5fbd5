//! A chart of lines, bands and points over an axis of numbers or of time.

use super::svg::{Anchor, Svg, text_width};
use super::ticks::{numbers, times};

/// Quantity of the horizontal axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Across {
    /// Time, in microseconds since 1970.
    Time,
    /// Numbers: name of the axis, its lowest and its highest number.
    Number(&'static str, f64, f64),
}

/// Shape of the points in a chart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Shape {
    /// A filled circle.
    Dot,
    /// An open diamond.
    Diamond,
}

/// A point with its bounds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Point {
    pub(crate) x: f64,
    pub(crate) y: f64,
    /// Lower and upper bound.
    pub(crate) bounds: Option<(f64, f64)>,
}

impl Point {
    /// A point without bounds.
    pub(crate) fn at(x: f64, y: f64) -> Self {
        Self { x, y, bounds: None }
    }
}

/// An element of a chart. Its class is one of `p-a`, `p-b`, `p-c`, `p-m`.
#[derive(Debug)]
pub(crate) enum Mark {
    /// A line, with a band where points have bounds. Without a label it is not in the legend.
    Line { class: &'static str, dash: &'static str, label: String, points: Vec<Point> },
    /// Points, with bars where they have bounds.
    Points { class: &'static str, shape: Shape, label: String, points: Vec<Point> },
    /// A horizontal line at a level.
    Level { class: &'static str, dash: &'static str, label: String, y: f64 },
}

impl Mark {
    fn points(&self) -> &[Point] {
        match self {
            Self::Line { points, .. } | Self::Points { points, .. } => points,
            Self::Level { .. } => &[],
        }
    }

    fn label(&self) -> &str {
        match self {
            Self::Line { label, .. } | Self::Points { label, .. } | Self::Level { label, .. } => label,
        }
    }
}

/// A chart with its texts, axes and marks.
#[derive(Debug)]
pub(crate) struct Lines {
    pub(crate) title: String,
    /// The chart described in words.
    pub(crate) desc: String,
    pub(crate) across: Across,
    /// Name and unit of the vertical axis.
    pub(crate) up: &'static str,
    /// Range that the vertical axis shows at least.
    pub(crate) up_at_least: (f64, f64),
    pub(crate) marks: Vec<Mark>,
}

const WIDTH: f64 = 420.0;
const PLOT_HEIGHT: f64 = 210.0;
const LEFT: f64 = 54.0;
const RIGHT: f64 = 14.0;
const LINE_HEIGHT: f64 = 18.0;

/// Geometry of the plot area in the picture.
struct Frame {
    top: f64,
    x: (f64, f64),
    y: (f64, f64),
}

impl Frame {
    fn x(&self, x: f64) -> f64 {
        LEFT + (x - self.x.0) / (self.x.1 - self.x.0) * (WIDTH - LEFT - RIGHT)
    }

    fn y(&self, y: f64) -> f64 {
        let share = ((y - self.y.0) / (self.y.1 - self.y.0)).clamp(-0.02, 1.02);
        self.top + (1.0 - share) * PLOT_HEIGHT
    }

    fn bottom(&self) -> f64 {
        self.top + PLOT_HEIGHT
    }

    fn place(&self, point: &Point) -> (f64, f64) {
        (self.x(point.x), self.y(point.y))
    }
}

impl Lines {
    /// Draws the chart as SVG.
    pub(crate) fn draw(&self) -> String {
        self.svg().document(&self.title, &self.desc)
    }

    /// Draws several charts as one document, from top to bottom. The first chart's title is the document's.
    pub(crate) fn draw_stacked(charts: &[Self]) -> String {
        let mut all = Svg::new(WIDTH, 0.0);
        for chart in charts {
            all.append_below(chart.svg());
        }
        let title = charts.first().map_or("", |chart| &chart.title);
        let descriptions: Vec<&str> = charts.iter().map(|chart| chart.desc.as_str()).collect();
        all.document(title, &descriptions.join(" "))
    }

    fn svg(&self) -> Svg {
        let legend = self.legend();
        let rows = legend.last().map_or(0.0, |one| one.1 + 1.0);
        let (low, high) = self.reach();
        let frame = Frame { top: 34.0 + rows * LINE_HEIGHT, x: self.width(), y: (low, high) };
        let mut svg = Svg::new(WIDTH, frame.bottom() + 46.0);
        svg.text("p-ink p-title", (8.0, 20.0), Anchor::Start, &self.title);
        for (mark, (x, row)) in self.marks.iter().zip(&legend) {
            if !mark.label().is_empty() {
                sample(&mut svg, mark, (8.0 + x, 34.0 + row * LINE_HEIGHT));
            }
        }
        self.axes(&mut svg, &frame);
        if self.is_empty() {
            let middle = (0.5 * (WIDTH + LEFT), frame.top + 0.5 * PLOT_HEIGHT);
            svg.text("p-soft", middle, Anchor::Middle, "nothing recorded yet");
        }
        for mark in &self.marks {
            put(&mut svg, mark, &frame);
        }
        svg
    }

    fn is_empty(&self) -> bool {
        self.marks.iter().all(|mark| mark.points().is_empty())
    }

    /// Position and row of each mark in the legend.
    fn legend(&self) -> Vec<(f64, f64)> {
        let (mut x, mut row) = (0.0, 0.0);
        let mut places = Vec::with_capacity(self.marks.len());
        for mark in &self.marks {
            if mark.label().is_empty() {
                places.push((x, row));
                continue;
            }
            let wide = 34.0 + text_width(mark.label());
            if x > 0.0 && x + wide > WIDTH - 16.0 {
                (x, row) = (0.0, row + 1.0);
            }
            places.push((x, row));
            x += wide + 10.0;
        }
        places
    }

    fn width(&self) -> (f64, f64) {
        let all = self.marks.iter().flat_map(Mark::points).map(|point| point.x);
        let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        match self.across {
            Across::Number(_, from, to) => (from, to),
            Across::Time if low < high => (low, high),
            Across::Time if low == high => (low - 5e5, low + 5e5),
            Across::Time => (0.0, 1e6),
        }
    }

    /// Range of the vertical axis. It includes bounds, but extends at most by half the span of the values.
    fn reach(&self) -> (f64, f64) {
        let points = || self.marks.iter().flat_map(Mark::points);
        let levels = self.marks.iter().filter_map(|mark| match mark {
            Mark::Level { y, .. } => Some(*y),
            Mark::Line { .. } | Mark::Points { .. } => None,
        });
        let mut reach = self.up_at_least;
        for y in points().map(|point| point.y).chain(levels) {
            reach = (reach.0.min(y), reach.1.max(y));
        }
        let span = (reach.1 - reach.0).max(1e-9);
        let (lowest, highest) = (reach.0 - 0.5 * span, reach.1 + 0.5 * span);
        for (low, high) in points().filter_map(|point| point.bounds) {
            reach = (reach.0.min(low.max(lowest)), reach.1.max(high.min(highest)));
        }
        let margin = 0.04 * (reach.1 - reach.0).max(1e-9);
        let low = if reach.0 == 0.0 { 0.0 } else { reach.0 - margin };
        (low, reach.1 + margin)
    }

    fn axes(&self, svg: &mut Svg, frame: &Frame) {
        for (y, label) in numbers(frame.y.0, frame.y.1, 6) {
            svg.line("p-grid", (LEFT, frame.y(y)), (WIDTH - RIGHT, frame.y(y)), "");
            svg.text("p-soft p-small", (LEFT - 6.0, frame.y(y) + 4.0), Anchor::End, &label);
        }
        let (ticks, name) = match self.across {
            Across::Time if self.is_empty() => (Vec::new(), "time, UTC".to_owned()),
            Across::Time => times(frame.x.0 as i64, frame.x.1 as i64),
            Across::Number(name, ..) => (numbers(frame.x.0, frame.x.1, 8), name.to_owned()),
        };
        let bottom = frame.bottom();
        for (x, label) in ticks {
            svg.line("p-axis", (frame.x(x), bottom), (frame.x(x), bottom + 5.0), "");
            let half = 0.5 * text_width(&label);
            let at = frame.x(x).min(WIDTH - half);
            svg.text("p-soft p-small", (at, bottom + 18.0), Anchor::Middle, &label);
        }
        svg.line("p-axis", (LEFT, bottom), (WIDTH - RIGHT, bottom), "");
        svg.line("p-axis", (LEFT, frame.top), (LEFT, bottom), "");
        svg.text("p-soft p-small", (0.5 * (LEFT + WIDTH - RIGHT), bottom + 37.0), Anchor::Middle, &name);
        svg.raw(format_args!(
            "<text class=\"p-soft p-small\" transform=\"translate(13 {:.1}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
            frame.top + 0.5 * PLOT_HEIGHT,
            super::svg::escaped(self.up)
        ));
    }
}

/// A mark's sample in the legend.
fn sample(svg: &mut Svg, mark: &Mark, (x, y): (f64, f64)) {
    let middle = (x + 13.0, y + 6.0);
    match mark {
        Mark::Line { class, dash, .. } | Mark::Level { class, dash, .. } => {
            svg.line(&format!("{class} p-line"), (x, middle.1), (x + 26.0, middle.1), dash);
        }
        Mark::Points { class, shape, .. } => dot(svg, class, *shape, middle, 4.0),
    }
    svg.text("p-ink p-small", (x + 31.0, y + 10.0), Anchor::Start, mark.label());
}

fn dot(svg: &mut Svg, class: &str, shape: Shape, (x, y): (f64, f64), radius: f64) {
    match shape {
        Shape::Dot => {
            svg.raw(format_args!(
                "<circle class=\"{class}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius:.1}\" stroke=\"none\"/>"
            ));
        }
        Shape::Diamond => {
            let r = radius + 1.0;
            svg.path(&format!("{class} p-open"), &[(x, y - r), (x + r, y), (x, y + r), (x - r, y)], true, "");
        }
    }
}

fn put(svg: &mut Svg, mark: &Mark, frame: &Frame) {
    match mark {
        Mark::Level { class, dash, y, .. } => {
            svg.line(&format!("{class} p-thin"), (LEFT, frame.y(*y)), (WIDTH - RIGHT, frame.y(*y)), dash);
        }
        Mark::Line { class, dash, points, .. } => {
            let bounded = points.iter().filter_map(|point| Some((frame.x(point.x), point.bounds?)));
            let upper = bounded.clone().map(|(x, (_, high))| (x, frame.y(high)));
            let lower = bounded.rev().map(|(x, (low, _))| (x, frame.y(low)));
            svg.path(&format!("{class} p-band"), &upper.chain(lower).collect::<Vec<_>>(), true, "");
            let places: Vec<_> = points.iter().map(|point| frame.place(point)).collect();
            svg.path(&format!("{class} p-line"), &places, false, dash);
            if let [only] = places[..] {
                dot(svg, class, Shape::Dot, only, 3.0);
            }
        }
        Mark::Points { class, shape, points, .. } => {
            let radius = if points.len() > 60 { 1.6 } else { 3.5 };
            for point in points {
                if let Some((low, high)) = point.bounds {
                    let x = frame.x(point.x);
                    svg.line(&format!("{class} p-thin"), (x, frame.y(low)), (x, frame.y(high)), "");
                }
                dot(svg, class, *shape, frame.place(point), radius);
            }
        }
    }
}
