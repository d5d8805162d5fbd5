//! ROS uses metres and pascals, the agent millimetres and megapascals above the atmosphere.

use crate::messages::Contact;
use crate::words::ContactLine;

/// Longest identifier of a touch test, in bytes.
const TEST_ID_MAX: usize = 64;
/// Readings beyond this are no chamber pressures, MPa.
const GAUGE_MAX_MPA: f64 = 1.0;
/// Lowest gauge pressure: a vacuum is below any whisker's use, MPa.
const GAUGE_MIN_MPA: f64 = -0.05;

/// Meaning of `fluid_pressure`, in readings and setpoints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pressures {
    /// Absolute pressure, as `sensor_msgs/FluidPressure` defines it; the atmosphere's pressure in Pa.
    Absolute(f64),
    /// Pressure above the atmosphere.
    Gauge,
}

impl Pressures {
    fn offset_pa(self) -> f64 {
        match self {
            Self::Absolute(atmosphere_pa) => atmosphere_pa,
            Self::Gauge => 0.0,
        }
    }

    /// The gauge pressure of a reading in Pa, in MPa.
    ///
    /// # Errors
    /// The reading cannot be the pressure of a chamber.
    pub fn gauge_mpa(self, reading_pa: f64) -> Result<f64, String> {
        let gauge_mpa = (reading_pa - self.offset_pa()) * 1e-6;
        if gauge_mpa.is_finite() && (GAUGE_MIN_MPA..=GAUGE_MAX_MPA).contains(&gauge_mpa) {
            return Ok(gauge_mpa);
        }
        let meaning = match self {
            Self::Absolute(_) => "absolute: is it gauge pressure? Then start with --pressures gauge",
            Self::Gauge => "gauge: is its unit Pa?",
        };
        Err(format!("a pressure of {reading_pa} Pa, {meaning}"))
    }

    /// A gauge pressure in MPa as a ROS pressure, Pa.
    #[must_use]
    pub fn pa(self, gauge_mpa: f64) -> f64 {
        gauge_mpa * 1e6 + self.offset_pa()
    }
}

/// A contact in the words of the agent, which checks ranges itself.
///
/// # Errors
/// A number is not finite, or the place is unknown.
pub fn line_of(contact: Contact) -> Result<ContactLine, String> {
    let name = format!("{}/{}", contact.array, contact.whisker);
    let numbers = [
        ("deflection_m", contact.deflection_m),
        ("strain", contact.strain),
        ("distance_m", contact.distance_m),
        ("distance_sd_m", contact.distance_sd_m),
        ("ratio", contact.ratio),
        ("ratio_sd", contact.ratio_sd),
    ];
    if let Some((field, value)) = numbers.iter().find(|(_, value)| !value.is_finite()) {
        return Err(format!("a contact of {name}: {field} is {value}"));
    }
    if contact.test_id.len() > TEST_ID_MAX {
        return Err(format!("a contact of {name}: test_id has more than {TEST_ID_MAX} bytes"));
    }
    let above_0 = |value: f64| (value > 0.0).then_some(value);
    let (distance_mm, distance_sd_mm) = (contact.distance_m * 1e3, above_0(contact.distance_sd_m * 1e3));
    let mut line = ContactLine {
        array: contact.array,
        whisker: contact.whisker,
        deflection_mm: contact.deflection_m * 1e3,
        strain: contact.strain,
        distance_mm: None,
        distance_sd_mm: None,
        ratio: None,
        ratio_sd: None,
        tip: None,
        test_id: Some(contact.test_id).filter(|test_id| !test_id.is_empty()),
        touched: contact.missed.then_some(false),
    };
    match contact.place {
        0 => {}
        1 => (line.distance_mm, line.distance_sd_mm) = (Some(distance_mm), distance_sd_mm),
        2 => (line.ratio, line.ratio_sd) = (Some(contact.ratio), above_0(contact.ratio_sd)),
        3 => {
            line.tip = Some(true);
            line.distance_mm = above_0(distance_mm);
            line.distance_sd_mm = line.distance_mm.and(distance_sd_mm);
        }
        other => return Err(format!("a contact of {name}: place is {other}, and none of the constants 0 to 3")),
    }
    Ok(line)
}
