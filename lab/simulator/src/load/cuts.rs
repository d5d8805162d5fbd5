//! Cuts whiskers one after the other, and measures the setpoints that follow.

use std::collections::BTreeMap;

use vibrissa_core::mechanics::ModelError;
use vibrissa_protocol::{Setpoint, SetpointReason};

use super::texts::Touching;

/// Number of contacts without a setpoint after which the next whisker is cut.
const CONTACTS_MAX: usize = 200;
/// Remaining lengths of cut whiskers, in mm, from the longest to the shortest.
const LENGTHS_MM: [f64; 5] = [66.0, 65.0, 64.0, 63.0, 62.0];
/// Setpoints state their time of issue in milliseconds, rounded down.
const ISSUED_WITHIN_US: u64 = 1000;

/// Cut whiskers of one robot.
#[derive(Debug, Default)]
pub struct Cuts {
    touching: BTreeMap<usize, Touching>,
    /// The whisker that was cut last, and the transmission times of its contacts since then.
    active: Option<(usize, Vec<u64>)>,
    /// Number of cut whiskers that got no setpoint.
    pub missed: u64,
}

impl Cuts {
    /// The whisker that waits for a setpoint; cuts the next one if none does. `None` once all are cut.
    ///
    /// # Errors
    /// The mechanics are invalid; cannot happen.
    pub fn active(&mut self, robot: usize, whiskers: usize, now_us: u64) -> Result<Option<usize>, ModelError> {
        if self.active.as_ref().is_some_and(|(_, sent_us)| sent_us.len() >= CONTACTS_MAX) {
            self.missed += 1;
            self.active = None;
        }
        let next = self.touching.len();
        if self.active.is_none() && next < whiskers {
            let mut touching = Touching::new(&robot.to_string(), next as u16)?;
            touching.trim(now_us, LENGTHS_MM[(robot + next) % LENGTHS_MM.len()]);
            self.touching.insert(next, touching);
            self.active = Some((next, Vec::new()));
        }
        Ok(self.active.as_ref().map(|&(whisker, _)| whisker))
    }

    /// The encoded reading of a cut whisker for a contact that is sent now; `None` for a whole whisker.
    pub fn touch(&mut self, whisker: usize, now_us: u64) -> Option<Vec<u8>> {
        let reading = self.touching.get_mut(&whisker)?.touch();
        if let Some((active, sent_us)) = &mut self.active
            && *active == whisker
        {
            sent_us.push(now_us);
        }
        Some(reading)
    }

    /// Applies a setpoint. Returns the time since the contact that led to it, in microseconds, if it is the first
    /// setpoint for the whisker that was cut last.
    ///
    /// That contact is the whisker's last one sent before the setpoint was issued.
    pub fn take(&mut self, whisker: usize, setpoint: &Setpoint, now_us: u64) -> Option<u64> {
        if let Some(touching) = self.touching.get_mut(&whisker) {
            touching.set_pressure(setpoint.pressure_mpa);
        }
        let is_answer = setpoint.reason == SetpointReason::SelfCompensation;
        let (_, sent_us) = self.active.take_if(|(active, _)| *active == whisker && is_answer)?;
        let issued_us = setpoint.issued.0 + ISSUED_WITHIN_US;
        let sent_us = sent_us.into_iter().rev().find(|&sent_us| sent_us < issued_us)?;
        Some(now_us.saturating_sub(sent_us))
    }
}
