//! SVG pictures for screens of any size, light and dark, and for screen readers: without scripts or fixed pixels.

use std::fmt::{Display, Write as _};

/// A picture being drawn.
#[derive(Debug)]
pub(crate) struct Svg {
    width: f64,
    height: f64,
    body: String,
}

/// Colours by class, for light and dark backgrounds; each has a contrast of at least 4.5:1.
const STYLE: &str = "\
.p-ground{fill:#fff}.p-ink{fill:#1b1f24}.p-soft{fill:#57606a}\
.p-grid{stroke:#d8dee4;stroke-width:1}.p-axis{stroke:#57606a;stroke-width:1.2}\
.p-a{fill:#0b5cad;stroke:#0b5cad}.p-b{fill:#b03a06;stroke:#b03a06}.p-c{fill:#1a6e3c;stroke:#1a6e3c}\
.p-m{fill:#57606a;stroke:#57606a}\
@media(prefers-color-scheme:dark){\
.p-ground{fill:#0f1419}.p-ink{fill:#e6edf3}.p-soft{fill:#a0abb6}\
.p-grid{stroke:#2a323b}.p-axis{stroke:#a0abb6}\
.p-a{fill:#79b8ff;stroke:#79b8ff}.p-b{fill:#ff9c66;stroke:#ff9c66}.p-c{fill:#6fd6a0;stroke:#6fd6a0}\
.p-m{fill:#a0abb6;stroke:#a0abb6}}\
.p-line{fill:none;stroke-width:2;stroke-linejoin:round}.p-thin{fill:none;stroke-width:1.5}\
.p-open{fill:none;stroke-width:1.6}.p-band{stroke:none;fill-opacity:.22}.p-body{stroke-width:1.2;fill-opacity:.75}\
text{font:13px system-ui,sans-serif}text[class]{stroke:none}.p-title{font-weight:600;font-size:14px}.p-small{font-size:12px}";

/// Alignment of a text to its point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Anchor {
    /// The text begins at the point.
    Start,
    /// The text is centred at the point.
    Middle,
    /// The text ends at the point.
    End,
}

impl Anchor {
    const fn word(self) -> &'static str {
        match self {
            Self::Start => "start",
            Self::Middle => "middle",
            Self::End => "end",
        }
    }
}

/// Escapes characters with a meaning in XML, and replaces control characters by spaces.
pub(crate) fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for one in text.chars() {
        match one {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            one if one.is_control() => safe.push(' '),
            one => safe.push(one),
        }
    }
    safe
}

/// Approximate upper bound of the width of a text at 13 px.
pub(crate) fn text_width(text: &str) -> f64 {
    7.1 * text.chars().count() as f64
}

impl Svg {
    /// An empty picture.
    pub(crate) fn new(width: f64, height: f64) -> Self {
        Self { width, height, body: String::new() }
    }

    /// Adds an element verbatim.
    pub(crate) fn raw(&mut self, element: impl Display) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.body, "{element}");
    }

    /// Adds another picture of the same width at the bottom.
    pub(crate) fn append_below(&mut self, other: Self) {
        let top = self.height;
        self.raw(format_args!("<g transform=\"translate(0 {top:.0})\">\n{}</g>", other.body));
        self.height += other.height;
    }

    /// Adds a straight line.
    pub(crate) fn line(&mut self, class: &str, from: (f64, f64), to: (f64, f64), dash: &str) {
        let dash = if dash.is_empty() { String::new() } else { format!(" stroke-dasharray=\"{dash}\"") };
        self.raw(format_args!(
            "<line class=\"{class}\" x1=\"{:.1}\" y1=\"{:.1}\" x2=\"{:.1}\" y2=\"{:.1}\"{dash}/>",
            from.0, from.1, to.0, to.1
        ));
    }

    /// Adds a path through points; `closed` makes it an area.
    pub(crate) fn path(&mut self, class: &str, points: &[(f64, f64)], closed: bool, dash: &str) {
        if points.is_empty() {
            return;
        }
        let mut d = String::with_capacity(points.len() * 12);
        for (index, (x, y)) in points.iter().enumerate() {
            let _ = write!(d, "{}{x:.1} {y:.1}", if index == 0 { "M" } else { "L" });
        }
        let dash = if dash.is_empty() { String::new() } else { format!(" stroke-dasharray=\"{dash}\"") };
        let end = if closed { "Z" } else { "" };
        self.raw(format_args!("<path class=\"{class}\" d=\"{d}{end}\"{dash}/>"));
    }

    /// Adds a text at a point.
    pub(crate) fn text(&mut self, class: &str, at: (f64, f64), anchor: Anchor, text: &str) {
        let (x, y, anchor) = (at.0, at.1, anchor.word());
        self.raw(format_args!(
            "<text class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{}</text>",
            escaped(text)
        ));
    }

    /// The complete document with a title and a description in words.
    pub(crate) fn document(self, title: &str, desc: &str) -> String {
        let Self { width, height, body } = self;
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" role=\"img\" \
             aria-labelledby=\"p-title p-desc\">\n<title id=\"p-title\">{}</title>\n<desc id=\"p-desc\">{}</desc>\n\
             <style>{STYLE}</style>\n<rect class=\"p-ground\" width=\"{width:.0}\" height=\"{height:.0}\"/>\n{body}</svg>\n",
            escaped(title),
            escaped(desc)
        )
    }
}
