//! Places of touches, for drivers that know strain and deflection and not the place.

use super::Agent;
use super::chamber::Chamber;
use crate::contract::Now;
use crate::contract::response::Place;
use crate::driver::{ToDriver, words};

/// Largest difference between the pressure of a chamber and that of its response, in MPa: it moves a place by about a
/// millimetre.
const TOLERANCE_MPA: f64 = 0.005;

impl Agent {
    /// The answer to `locate`: a place, or the reason why it is unknown.
    pub(super) fn locate(&mut self, from: usize, line: words::Locate, now: Now) -> ToDriver {
        let located = match self.place(from, &line.origin(), now) {
            Ok((at, _)) => located(&self.chambers[at], line.strain, line.deflection_mm),
            Err(bad) => Err(bad.problem),
        };
        let place = located.as_ref().ok();
        ToDriver::Place {
            id: line.id.map(|id| words::cut(&id)),
            array: line.array,
            whisker: line.whisker,
            distance_mm: place.map(|place| rounded(place.distance_mm)),
            distance_low_mm: place.map(|place| rounded(place.interval_mm.0)),
            distance_high_mm: place.map(|place| rounded(place.interval_mm.1)),
            problem: located.err(),
        }
    }
}

/// Without digits beyond any accuracy.
fn rounded(mm: f64) -> f64 {
    (mm * 100.0).round() / 100.0
}

fn located(chamber: &Chamber, strain: f64, deflection_mm: f64) -> Result<Place, String> {
    let Some(response) = &chamber.response else {
        return Err("the supervisor has not told the whisker's response yet".to_owned());
    };
    let Some(reading) = chamber.present_reading() else {
        return Err("no driver reads the pressure of the whisker".to_owned());
    };
    if (reading.pressure_mpa - response.pressure_mpa).abs() > TOLERANCE_MPA {
        return Err(format!(
            "the chamber has {:.4} MPa, and the response is known at {:.4} MPa: wait until the pressure is reached",
            reading.pressure_mpa, response.pressure_mpa
        ));
    }
    response.place(strain, deflection_mm).map_err(|why| why.to_string())
}
