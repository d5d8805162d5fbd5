//! Whether anything holds a number that is none.

use std::fmt::{self, Debug, Write};

/// How a number that is not finite looks in what `Debug` writes; the sign is written by itself.
const NOT_FINITE: [&str; 2] = ["NaN", "inf"];
/// Characters before such a number that are told with it.
const BEFORE: usize = 120;

/// Looks at what is written, piece by piece, and keeps nothing: numbers are pieces of their own.
#[derive(Default)]
struct Search {
    is_found: bool,
}

impl Write for Search {
    fn write_str(&mut self, piece: &str) -> fmt::Result {
        if NOT_FINITE.contains(&piece) {
            self.is_found = true;
            // Ends the writing.
            return Err(fmt::Error);
        }
        Ok(())
    }
}

/// Keeps what is written up to the number.
#[derive(Default)]
struct Place {
    text: String,
}

impl Write for Place {
    fn write_str(&mut self, piece: &str) -> fmt::Result {
        self.text.push_str(piece);
        if NOT_FINITE.contains(&piece) { Err(fmt::Error) } else { Ok(()) }
    }
}

/// Where the first number stands that is not finite, with what `Debug` writes before it; none if all are finite.
///
/// `Debug` is derived, so it visits every field: no list of fields has to be kept. Texts must not be `NaN` or `inf`.
pub fn not_finite(value: &impl Debug) -> Option<String> {
    let mut search = Search::default();
    // It fails on purpose as soon as something is found.
    let _ = write!(search, "{value:?}");
    search.is_found.then(|| {
        let mut place = Place::default();
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
    fn a_number_that_is_none_is_found_wherever_it_lies() {
        for (good, bad) in [(1.0, f64::NAN), (f64::MAX, f64::INFINITY), (5e-324, f64::NEG_INFINITY)] {
            assert_eq!(not_finite(&Deep { _list: vec![(Some(good), 1.0), (None, 0.0)] }), None);
            let found = not_finite(&Deep { _list: vec![(Some(good), 1.0), (Some(bad), 0.0)] }).unwrap();
            assert!(found.contains("_list") && found.contains("1.0"), "{found}");
            assert!(not_finite(&Deep { _list: vec![(None, bad as f32)] }).is_some());
        }
        assert_eq!(not_finite(&"information"), None);
    }
}
