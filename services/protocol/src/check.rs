//! Ranges of the contract's quantities, each defined once for both the check of messages and the schemas.

use crate::messages::Checked;
use crate::{GAIN_POINTS_MAX, INTEGER_LIMIT, RESPONSE_POINTS_MAX, Refusal};

/// Longest free text (name of a model, command id, boot id), in characters.
pub(crate) const TEXT_MAX_CHARS: usize = 64;

/// Permitted values of a quantity.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Range {
    pub(crate) least: f64,
    /// Whether `least` itself is outside the range.
    pub(crate) is_least_excluded: bool,
    pub(crate) most: f64,
    /// Least magnitude of values other than 0; smaller ones are not measurements. 0 for no such limit.
    pub(crate) least_magnitude: f64,
    /// Description of the range for people.
    allowed: &'static str,
}

/// Defines a range and its description from the same numbers.
macro_rules! range {
    (above $least:literal to $most:literal $unit:literal) => {
        Range {
            least: $least as f64,
            is_least_excluded: true,
            most: $most as f64,
            least_magnitude: 0.0,
            allowed: concat!("above ", $least, " and at most ", $most, $unit),
        }
    };
    (between $least:literal and $most:literal $unit:literal) => {
        Range {
            least: $least as f64,
            is_least_excluded: false,
            most: $most as f64,
            least_magnitude: 0.0,
            allowed: concat!("between ", $least, " and ", $most, $unit),
        }
    };
    (zero or magnitude $least:literal to $most:literal $unit:literal) => {
        Range {
            least: -($most as f64),
            is_least_excluded: false,
            most: $most as f64,
            least_magnitude: $least as f64,
            allowed: concat!("0, or in magnitude between ", $least, " and ", $most, $unit),
        }
    };
}

/// Contact ratio a of the paper. Below the lower limit, the contact would lie on the chamber of any existing
/// whisker.
pub(crate) const RATIO: Range = range!(between 0.01 and 1 "");
/// Standard deviation of a contact ratio.
pub(crate) const RATIO_SD: Range = range!(above 0 to 0.5 "");
/// Distance of a contact from the whisker's base, in mm.
pub(crate) const DISTANCE_MM: Range = range!(between 0.1 and 1000 " mm");
/// Standard deviation of such a distance, in mm.
pub(crate) const DISTANCE_SD_MM: Range = range!(above 0 to 100 " mm");
/// Length of a whisker, in mm.
pub(crate) const LENGTH_MM: Range = range!(between 1 and 1000 " mm");
/// Error of a stated length, in mm.
pub(crate) const LENGTH_TOLERANCE_MM: Range = range!(between 0 and 20 " mm");
/// Length that a whisker has lost, in mm.
pub(crate) const WEAR_MM: Range = range!(between 0 and 1000 " mm");
/// Number of contacts that a whisker lasts.
pub(crate) const CONTACTS_LEFT: Range = range!(between 0 and 1000000000 "");
/// Bound of the 95 % interval of a whisker's length, in mm.
pub(crate) const LENGTH_BOUND_MM: Range = range!(between 0 and 2000 " mm");
/// Deflection, in mm. The lower limit is below the resolution of any sensor on a robot.
pub(crate) const DEFLECTION_MM: Range = range!(between 0.01 and 1000 " mm");
/// Position on the robot, in mm.
pub(crate) const PLACE_MM: Range = range!(between -100000 and 100000 " mm");
/// Strain, in m/m. A dead gauge reads 0; other values below a thousandth of the best amplifiers' resolution are
/// invalid.
pub(crate) const STRAIN: Range = range!(zero or magnitude 1e-9 to 1 " (m/m)");
/// Largest strain that a gauge reads, in m/m.
pub(crate) const STRAIN_MAX: Range = range!(above 0 to 1 " (m/m)");
/// Angle of a contact to the plane of the gauge, in degrees.
pub(crate) const ANGLE_DEG: Range = range!(between -75 and 75 " degrees");
/// Standard deviation of such an angle, in degrees.
pub(crate) const ANGLE_SD_DEG: Range = range!(above 0 to 45 " degrees");
/// Strain of a whisker per mm of deflection, in 1/mm.
pub(crate) const STRAIN_PER_MM: Range = range!(above 0 to 10 " per mm");
/// Gauge pressure, in MPa.
pub(crate) const PRESSURE_MPA: Range = range!(between 0 and 1 " MPa");
/// Temperature, in degrees Celsius.
pub(crate) const TEMPERATURE_C: Range = range!(between -100 and 300 " degrees Celsius");
/// Rate of change of a pressure, in MPa/s.
pub(crate) const SLEW_MPA_PER_S: Range = range!(above 0 to 10 " MPa/s");
/// Factor on a strain, dimensionless.
pub(crate) const GAIN: Range = range!(above 0 to 1000 "");
/// Factor on all readings of a whisker, dimensionless.
pub(crate) const READING_GAIN: Range = range!(between 0.05 and 20 "");

impl Range {
    /// Returns a refusal if the number is outside the range.
    pub(crate) fn check(&self, path: &str, value: f64) -> Result<(), Refusal> {
        let is_enough = if self.is_least_excluded { value > self.least } else { value >= self.least }
            && (value == 0.0 || value.abs() >= self.least_magnitude);
        // The path is allocated only for a refusal: this runs for every contact.
        number(path, value, is_enough && value <= self.most, self.allowed)
    }
}

fn number(path: &str, value: f64, holds: bool, allowed: &'static str) -> Result<(), Refusal> {
    if holds { Ok(()) } else { Err(Refusal::OutOfRange { path: path.to_owned(), value, allowed }) }
}

/// Checks an integer that every JSON reader represents exactly: `seq`, `t_us`, `epoch`, `version`.
pub(crate) fn integer(path: &str, value: u64) -> Result<(), Refusal> {
    number(path, value as f64, value < INTEGER_LIMIT, "an integer from 0 and below 2^53")
}

/// Checks the length of a list.
pub(crate) fn count(path: &str, count: usize, most: usize) -> Result<(), Refusal> {
    if count <= most { Ok(()) } else { Err(Refusal::TooMany { path: path.to_owned(), count, most }) }
}

/// Whether a free text has 1 to 64 characters and no control characters. Some databases reject control characters,
/// and terminals execute them.
pub(crate) fn is_identifier(text: &str) -> bool {
    (1..=TEXT_MAX_CHARS).contains(&text.chars().count()) && !text.chars().any(char::is_control)
}

/// The rule of [`is_identifier`] as an error text.
pub(crate) fn identifier_rule() -> String {
    format!("must have 1 to {TEXT_MAX_CHARS} characters, none of them a control character")
}

/// Checks a free text that identifies something, such as a command.
pub(crate) fn identifier(path: &str, text: &str) -> Result<(), Refusal> {
    if is_identifier(text) {
        Ok(())
    } else {
        Err(Refusal::Malformed { path: path.to_owned(), problem: identifier_rule() })
    }
}

/// Checks each element and adds its index in the list to a refusal's path.
pub(crate) fn each<T>(list: &str, items: &[T], check: impl Fn(&T) -> Result<(), Refusal>) -> Result<(), Refusal> {
    items.iter().enumerate().try_for_each(|(index, item)| check(item).map_err(|refusal| refusal.within(list, index)))
}

/// Removes the elements that are wrong, and adds a refusal for each.
pub(crate) fn keep_valid<T: Checked>(list: &str, items: &mut Vec<T>, refused: &mut Vec<Refusal>) {
    let mut index = 0;
    items.retain(|item| {
        let checked = item.check();
        index += 1;
        checked.map_err(|refusal| refused.push(refusal.within(list, index - 1))).is_ok()
    });
}

/// Checks the factor on all readings of a whisker, if the message states one.
pub(crate) fn reading_gain(factor: Option<f64>) -> Result<(), Refusal> {
    factor.map_or(Ok(()), |factor| READING_GAIN.check("reading_gain", factor))
}

/// Checks pairs of contact ratio and factor.
pub(crate) fn gain(points: &[(f64, f64)]) -> Result<(), Refusal> {
    count("gain", points.len(), GAIN_POINTS_MAX)?;
    each("gain", points, |&(ratio, factor)| {
        RATIO.check("ratio", ratio)?;
        GAIN.check("factor", factor)
    })?;
    if points.is_sorted_by(|(before, _), (after, _)| before < after) {
        return Ok(());
    }
    Err(Refusal::Malformed { path: "gain".to_owned(), problem: "contact ratios must rise".to_owned() })
}

/// Checks points of a whisker's response: distance, strain per mm and its standard deviation.
pub(crate) fn response(points: &[(f64, f64, f64)]) -> Result<(), Refusal> {
    count("response", points.len(), RESPONSE_POINTS_MAX)?;
    each("response", points, |&(distance_mm, strain_per_mm, sd_per_mm)| {
        DISTANCE_MM.check("distance_mm", distance_mm)?;
        STRAIN_PER_MM.check("strain_per_mm", strain_per_mm)?;
        STRAIN_PER_MM.check("sd_per_mm", sd_per_mm)
    })?;
    if points.is_sorted_by(|before, after| before.0 < after.0 && before.1 > after.1) {
        return Ok(());
    }
    let problem = "distances must rise, and strains per mm must fall".to_owned();
    Err(Refusal::Malformed { path: "response".to_owned(), problem })
}
