//! A search for numbers that are not finite, in any value.

use std::fmt::{self, Debug, Write};

/// How `Debug` writes numbers that are not finite; it writes the sign separately.
const NOT_FINITE: [&str; 2] = ["NaN", "inf"];
/// Number of characters before such a number in a report.
const BEFORE: usize = 120;

/// Checks the output piece by piece without a copy: each number is a piece of its own.
#[derive(Default)]
struct Search {
    is_found: bool,
}

impl Write for Search {
    fn write_str(&mut self, piece: &str) -> fmt::Result {
        if NOT_FINITE.contains(&piece) {
            self.is_found = true;
            // An error ends the formatting early.
            return Err(fmt::Error);
        }
        Ok(())
    }
}

/// Collects the `Debug` output up to the number.
#[derive(Default)]
struct TextBeforeNumber {
    text: String,
}

impl Write for TextBeforeNumber {
    fn write_str(&mut self, piece: &str) -> fmt::Result {
        self.text.push_str(piece);
        if NOT_FINITE.contains(&piece) { Err(fmt::Error) } else { Ok(()) }
    }
}

/// The `Debug` output before the first number that is not finite, or None if all numbers are finite.
///
/// A derived `Debug` visits every field, so new fields are checked, too. Texts must not be `NaN` or `inf`.
pub fn not_finite(value: &impl Debug) -> Option<String> {
    let mut search = Search::default();
    // The write fails on purpose as soon as a number is found.
    let _ = write!(search, "{value:?}");
    search.is_found.then(|| {
        let mut place = TextBeforeNumber::default();
        let _ = write!(place, "{value:?}");
        let count = place.text.chars().count();
        place.text.chars().skip(count.saturating_sub(BEFORE)).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug)]
    struct Deep {
        _list: Vec<(Option<f64>, f32)>,
    }

    #[test]
    fn a_number_that_is_not_finite_is_found_at_any_depth() {
        for (good, bad) in [(1.0, f64::NAN), (f64::MAX, f64::INFINITY), (5e-324, f64::NEG_INFINITY)] {
            assert_eq!(not_finite(&Deep { _list: vec![(Some(good), 1.0), (None, 0.0)] }), None);
            let found = not_finite(&Deep { _list: vec![(Some(good), 1.0), (Some(bad), 0.0)] }).unwrap();
            assert!(found.contains("_list") && found.contains("1.0"), "{found}");
            assert!(not_finite(&Deep { _list: vec![(None, bad as f32)] }).is_some());
        }
        assert_eq!(not_finite(&"information"), None);
    }
}
