//! A setpoint that a chamber is applying.

use vibrissa_protocol::{Regulator, Setpoint};

use super::Chamber;
use crate::contract::{Moment, Now};
use crate::driver::ToDriver;

/// Change of pressure that valves of small robots manage, in MPa/s.
const VALVES_MPA_PER_S: f64 = 0.02;

/// Distance of the pressure that ends a fault from the setpoint after it, in MPa: too little to matter to a chamber.
const OTHER_MPA: f64 = 0.001;

/// A setpoint that is being applied.
#[derive(Debug)]
pub(in crate::agent) struct Applying {
    pub(in crate::agent) command_id: String,
    reading_gain: Option<f64>,
    fails_at: Moment,
    /// Since when all readings are at the target.
    near_since: Option<Moment>,
    is_settled: bool,
}

impl Applying {
    /// Takes a reading, and whether it is at the target.
    pub(super) fn read(&mut self, is_near: bool, at: Moment, settle_us: u64) {
        self.near_since = self.near_since.filter(|_| is_near).or(is_near.then_some(at));
        self.is_settled = self.near_since.is_some_and(|since| at >= since + settle_us);
    }

    /// Nothing is known of the chamber for a while.
    pub(super) fn unsettle(&mut self) {
        (self.near_since, self.is_settled) = (None, false);
    }
}

impl Chamber {
    /// Begins to apply a setpoint.
    pub(in crate::agent) fn apply(&mut self, setpoint: &Setpoint, now: Now) {
        self.end_fault();
        self.target_mpa = setpoint.pressure_mpa;
        self.slew_mpa_per_s = setpoint.slew_mpa_per_s;
        let way_mpa = self.reading.map_or(self.max_mpa, |reading| (self.target_mpa - reading.pressure_mpa).abs());
        let way_us = (way_mpa / self.slew_mpa_per_s.min(VALVES_MPA_PER_S) * 1e6) as u64;
        self.applying = Some(Applying {
            command_id: setpoint.command_id.clone(),
            reading_gain: setpoint.reading_gain,
            fails_at: now.at + way_us + self.limits.fail_after_us,
            near_since: None,
            is_settled: false,
        });
    }

    /// The setpoint is applied: its gain is in force. Returns its id.
    pub(in crate::agent) fn applied(&mut self) -> Option<String> {
        let applying = self.applying.take()?;
        self.gain.applied(self.target_mpa, applying.reading_gain);
        Some(applying.command_id)
    }

    /// A driver refuses an order: a setpoint that is being applied fails now. Returns whether that is news. After a refusal of
    /// another pressure the first one may still be for that: orders are repeated, and it comes again.
    pub(in crate::agent) fn refuse(&mut self, now: Now) -> bool {
        let is_told = match self.refused {
            Some((mpa, is_told)) if mpa == self.target_mpa => is_told,
            Some(_) => {
                self.refused = Some((self.target_mpa, false));
                return false;
            }
            None => false,
        };
        self.refused = Some((self.target_mpa, true));
        if let Some(applying) = &mut self.applying {
            applying.unsettle();
            applying.fails_at = now.at;
        }
        !is_told
    }

    /// The line before a setpoint that ends a fault of the driver's own regulator. A new setpoint of the same pressure would be a
    /// repeated line, which changes nothing.
    pub(in crate::agent) fn ends_fault(&self, setpoint: &Setpoint) -> Option<ToDriver> {
        let is_faulty = self.valves.is_none() && self.regulator == Some(Regulator::Fault);
        let (array, whisker) = (self.array.clone(), self.number);
        let is_low = setpoint.pressure_mpa < OTHER_MPA;
        let pressure_mpa = setpoint.pressure_mpa + if is_low { OTHER_MPA } else { -OTHER_MPA };
        let slew_mpa_per_s = setpoint.slew_mpa_per_s;
        is_faulty.then_some(ToDriver::SetPressure { array, whisker, pressure_mpa, slew_mpa_per_s })
    }

    pub(in crate::agent) fn is_settled(&self) -> bool {
        self.applying.as_ref().is_some_and(|applying| applying.is_settled)
    }

    pub(in crate::agent) fn fails_at(&self) -> Option<Moment> {
        self.applying.as_ref().map(|applying| applying.fails_at)
    }
}
