//! Ranges of the contract's quantities: each checked in one place.

use crate::{INTEGER_LIMIT, Refusal};

/// Refuses a number unless `holds`.
fn number(path: &str, value: f64, holds: bool, allowed: &'static str) -> Result<(), Refusal> {
    // The path is only built for a refusal: this runs for every contact.
    if holds { Ok(()) } else { Err(Refusal::OutOfRange { path: path.to_owned(), value, allowed }) }
}

/// An integer that every JSON reader keeps exact: `seq`, `t_us`, `epoch`, `version`.
pub(crate) fn integer(path: &str, value: u64) -> Result<(), Refusal> {
    number(path, value as f64, value < INTEGER_LIMIT, "an integer from 0 and below 2^53")
}

/// The paper's contact ratio a.
pub(crate) fn ratio(path: &str, value: f64) -> Result<(), Refusal> {
    number(path, value, value > 0.0 && value <= 1.0, "above 0 and at most 1")
}

/// A length or deflection in mm.
pub(crate) fn positive_mm(path: &str, value: f64) -> Result<(), Refusal> {
    number(path, value, value > 0.0 && value <= 1000.0, "above 0 and at most 1000 mm")
}

/// A place on the robot in mm.
pub(crate) fn place_mm(path: &str, value: f64) -> Result<(), Refusal> {
    number(path, value, value.abs() <= 100_000.0, "between -100000 and 100000 mm")
}

/// A strain in m/m.
pub(crate) fn strain(path: &str, value: f64) -> Result<(), Refusal> {
    number(path, value, value.abs() <= 1.0, "between -1 and 1 (m/m)")
}

/// A gauge pressure in MPa.
pub(crate) fn pressure_mpa(path: &str, value: f64) -> Result<(), Refusal> {
    number(path, value, (0.0..=1.0).contains(&value), "between 0 and 1 MPa")
}

/// A temperature in degrees Celsius.
pub(crate) fn temperature_c(path: &str, value: f64) -> Result<(), Refusal> {
    number(path, value, (-100.0..=300.0).contains(&value), "between -100 and 300 degrees Celsius")
}

/// How fast a pressure may change.
pub(crate) fn slew_mpa_per_s(path: &str, value: f64) -> Result<(), Refusal> {
    number(path, value, value > 0.0 && value <= 10.0, "above 0 and at most 10 MPa/s")
}

/// A factor on a strain.
pub(crate) fn gain(path: &str, value: f64) -> Result<(), Refusal> {
    number(path, value, value > 0.0 && value <= 1000.0, "above 0 and at most 1000")
}

/// The length of a list.
pub(crate) fn count(path: &str, count: usize, most: usize) -> Result<(), Refusal> {
    if count <= most { Ok(()) } else { Err(Refusal::TooMany { path: path.to_owned(), count, most }) }
}

/// A free text that identifies something, such as a command.
pub(crate) fn identifier(path: &str, text: &str) -> Result<(), Refusal> {
    if (1..=64).contains(&text.chars().count()) && !text.chars().any(char::is_control) {
        Ok(())
    } else {
        Err(Refusal::Malformed {
            path: path.to_owned(),
            problem: "must have 1 to 64 characters, none of them a control character".to_owned(),
        })
    }
}

/// Checks each element and names its place in the list.
pub(crate) fn each<T>(list: &str, items: &[T], check: impl Fn(&T) -> Result<(), Refusal>) -> Result<(), Refusal> {
    items.iter().enumerate().try_for_each(|(index, item)| check(item).map_err(|refusal| refusal.within(list, index)))
}
