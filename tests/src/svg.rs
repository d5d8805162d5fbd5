//! Drawings in the documents: written by tests, or compared with what the program draws now.

use std::path::Path;

/// Variable that lets tests write documents.
const WRITE: &str = "VIBRISSA_WRITE_DOCS";

/// Whether tests write documents instead of comparing them.
#[must_use]
pub fn writes_docs() -> bool {
    std::env::var_os(WRITE).is_some()
}

/// Path of a document.
#[must_use]
pub fn document(name: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs").join(name)
}

/// The look of a drawing without its data: its size, its texts, and the styles of its shapes, each once. Texts that are
/// numbers are ticks, which may follow from the data.
#[must_use]
pub fn look(svg: &str) -> Vec<String> {
    let mut parts = Vec::new();
    for piece in svg.split('<').skip(1) {
        let Some((tag, text)) = piece.split_once('>') else { continue };
        let name = tag.split([' ', '/']).next().unwrap_or_default();
        let styles = tag.split('"').collect::<Vec<_>>();
        // Names of attributes are at even places, values at odd ones.
        let styles = styles.chunks_exact(2).map(|pair| (pair[0].trim(), pair[1]));
        let kept = styles.filter_map(|(attribute, value)| {
            let attribute = attribute.rsplit(' ').next().unwrap_or_default().trim_end_matches('=');
            let is_style = ["fill", "stroke", "stroke-width", "opacity", "font-size", "font-family", "viewBox"];
            is_style.contains(&attribute).then(|| format!(" {attribute}={value}"))
        });
        let kept: String = kept.collect();
        let text = text.trim();
        let text = if text.parse::<f64>().is_ok() { "(number)" } else { text };
        let part = format!("{name}{kept} {text}");
        if !name.is_empty() && !parts.contains(&part) {
            parts.push(part);
        }
    }
    parts
}

/// Writes a drawing of the documents if [`writes_docs`], or compares its look with what the program draws now.
///
/// # Panics
/// The drawing in the documents is outdated.
pub fn is_up_to_date(name: &str, drawn: &str, mend: &str) {
    if writes_docs() {
        std::fs::write(document(name), drawn).expect("a document");
        return;
    }
    let written = std::fs::read_to_string(document(name)).expect("a document");
    let (now, then) = (look(drawn), look(&written));
    let new: Vec<&String> = now.iter().filter(|part| !then.contains(part)).collect();
    let gone: Vec<&String> = then.iter().filter(|part| !now.contains(part)).collect();
    assert!(
        new.is_empty() && gone.is_empty(),
        "docs/{name} is outdated: write it with {WRITE}=1 {mend}\nnew: {new:#?}\nno longer drawn: {gone:#?}"
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_look_has_texts_and_styles_without_data() {
        let svg = |text: &str, y: &str, fill: &str| {
            format!(
                "<svg viewBox=\"0 0 9 9\">\n<text x=\"1\" fill=\"#000\">\n{text}\n</text>\n<circle cy=\"{y}\" fill=\"{fill}\"/>\n</svg>"
            )
        };
        assert_eq!(look(&svg("length", "1", "#111")), look(&svg("length", "2", "#111")));
        assert_eq!(look(&svg("10", "1", "#111")), look(&svg("20", "1", "#111")));
        assert_ne!(look(&svg("length", "1", "#111")), look(&svg("width", "1", "#111")));
        assert_ne!(look(&svg("length", "1", "#111")), look(&svg("length", "1", "#222")));
        assert!(look(&svg("length", "1", "#111")).contains(&"text fill=#000 length".to_owned()));
    }
}
