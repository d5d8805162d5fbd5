//! Lines of the drivers, as far as a calibration needs them.

use super::{PULSE_MAX_MS, Place, Session};
use crate::calibrate::measure::Sample;
use crate::driver::words::{Origin, Samples};
use crate::driver::{FromDriver, Opening};

impl Session<'_> {
    pub(super) async fn take(&mut self, end: usize, line: &[u8]) {
        // A wrong line is the agent's to tell.
        let Ok(word) = FromDriver::read(line) else { return };
        let t_s = self.now_s();
        match word {
            FromDriver::Hello(_) => self.greet(end).await,
            FromDriver::Strain(line) if self.is_present(end, &line.origin()) => {
                let strains = line.strain.as_slice();
                let ways = line.deflection_mm.as_ref().map(Samples::as_slice);
                let every_s = line.every_us.unwrap_or(0) as f64 / 1e6;
                for (at, &strain) in strains.iter().enumerate().filter(|(_, strain)| strain.is_finite()) {
                    let way_mm = ways.and_then(|ways| ways.get(at).or(ways.last()).copied());
                    self.seen.deflection_mm = way_mm.or(self.seen.deflection_mm);
                    let before_s = (strains.len() - 1 - at) as f64 * every_s;
                    let deflection_mm = self.seen.deflection_mm;
                    self.seen.strains.push(Sample { t_s: t_s - before_s, strain, deflection_mm });
                }
            }
            FromDriver::Motion(line) if self.is_present(end, &line.origin()) => {
                let newest = line.deflection_mm.as_ref().and_then(|ways| ways.as_slice().last().copied());
                self.seen.deflection_mm = newest.or(self.seen.deflection_mm);
            }
            FromDriver::Pressure(line) => {
                let origin = line.origin();
                if let Some(place) = self.place_of(end, &origin) {
                    self.newest.insert(place, line.pressure_mpa);
                }
                if self.is_present(end, &origin) {
                    self.seen.pressures.push((t_s, line.pressure_mpa));
                    self.keep_below(line.pressure_mpa).await;
                }
            }
            FromDriver::Strain(_)
            | FromDriver::Motion(_)
            | FromDriver::Contact(_)
            | FromDriver::Fault(_)
            | FromDriver::TestState(_)
            | FromDriver::Driving(_)
            | FromDriver::Task(_)
            | FromDriver::Locate(_)
            | FromDriver::Configured(_)
            | FromDriver::Configuration(_)
            | FromDriver::Error(_) => {}
        }
    }

    async fn keep_below(&mut self, mpa: f64) {
        if mpa <= self.ceiling_mpa {
            return;
        }
        self.exceeded = true;
        self.hold(0.0).await;
        self.pulse(Opening::Close, 0.0).await;
        self.pulse(Opening::Vent, PULSE_MAX_MS).await;
    }

    fn place_of(&self, end: usize, origin: &Origin) -> Option<Place> {
        let serves = &self.ends[end].config.whiskers;
        serves
            .iter()
            .find(|(array, number)| {
                *number == origin.whisker && origin.array.as_ref().is_none_or(|named| named == array)
            })
            .cloned()
    }

    fn is_present(&self, end: usize, origin: &Origin) -> bool {
        self.present.is_some() && self.place_of(end, origin) == self.present
    }
}
