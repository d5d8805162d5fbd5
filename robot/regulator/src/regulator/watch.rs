//! Decisions between two pulses: whether one is due, and whether the chamber leaks or a valve has failed.

use super::{Aim, LOW_STEPS, Regulator};
use crate::diagnosis::Tightness;
use crate::{Command, Fault, Way};

/// Pulses that may miss the band before the nearest pressure counts as reached.
const APPROACHES: u32 = 12;

impl Regulator {
    pub(super) fn ready(&mut self, dt_us: u32, reading_mpa: f32, supply_mpa: Option<f32>) -> Command {
        let step = self.params.sensor_step_mpa;
        let setpoint_mpa = self.setpoint_mpa.unwrap_or(0.0);
        let supply_mpa = supply_mpa.filter(|mpa| mpa.is_finite()).unwrap_or(self.params.supply_mpa);
        match self.next.take() {
            Some(Aim::Probe) => {
                if self.probes == 0 {
                    self.probe_mpa = self.filtered_mpa;
                }
                return self.begin(Way::Vent, Aim::Probe, (4 << self.probes) as f32 * step, supply_mpa);
            }
            // As long as a pulse may be: this empties a chamber that a few fill pulses have filled.
            Some(Aim::Purge) => return self.begin(Way::Vent, Aim::Purge, self.params.max_mpa, supply_mpa),
            Some(Aim::Setpoint) | None => {}
        }
        if reading_mpa > self.params.max_mpa + step && self.filtered_mpa > self.params.max_mpa + 0.5 * step {
            return self.begin(Way::Vent, Aim::Setpoint, reading_mpa - setpoint_mpa.min(self.ramp_mpa), supply_mpa);
        }
        let moving = self.ramp_mpa != setpoint_mpa;
        let hold_against = if self.leaks { self.leak_mpa_per_s().max(0.0) } else { 0.0 };
        // Half of what is lost until the next refill is filled in advance.
        let lead = (hold_against * self.params.refill_interval_us as f32 * 0.5e-6).min(0.4 * step);
        let error = self.ramp_mpa + lead - self.filtered_mpa;
        let fault = self.watch(dt_us, error);
        self.elapsed_us = 0;
        if let Some(fault) = fault {
            return self.fail(fault);
        }
        let size = error.abs();
        let band = if moving { 1.0 } else { 0.55 } * step;
        if !moving && !self.reached {
            let near = self.approaches >= APPROACHES && size < 2.0 * step;
            if size <= band || near || self.at_floor(error) {
                self.reached = true;
                self.held_us = 0;
            }
        }
        let fast = hold_against > 4.0 * self.params.leak_report_mpa_per_s || size > 4.0 * step;
        let wait_us = match (self.reached, fast) {
            (false, _) => 0,
            (true, true) => self.params.refill_interval_us,
            (true, false) => self.params.hold_interval_us,
        };
        self.off_us = if size <= band { 0 } else { self.off_us.saturating_add(dt_us) };
        let hasty = self.reached && !fast && self.off_us < self.params.filter_us as u32 * 2;
        if size <= band || hasty || self.at_floor(error) || self.since_pulse_us < wait_us {
            return Command::None;
        }
        if error < 0.0 {
            return self.begin(Way::Vent, Aim::Setpoint, size, supply_mpa);
        }
        let low = self.supply_low && (self.supply_given || self.since_pulse_us < self.params.retry_us);
        if low || supply_mpa < self.filtered_mpa + 0.5 * self.params.supply_margin_mpa {
            return Command::None;
        }
        // A supply that gave nothing is tried with little: the sensor may be frozen.
        let most = if self.supply_dead { 5.0 * step } else { size };
        self.begin(Way::Fill, Aim::Setpoint, size.min(most), supply_mpa)
    }

    /// Near zero a reading that does not fall any more is the sensor's zero error.
    pub(super) fn at_floor(&self, error: f32) -> bool {
        error < 0.0 && self.filtered_mpa <= self.floor_mpa + self.params.sensor_step_mpa
    }

    /// Measures the leak, and how long the setpoint is not reached.
    pub(super) fn watch(&mut self, dt_us: u32, error: f32) -> Option<Fault> {
        let step = self.params.sensor_step_mpa;
        if !self.reached {
            return self.watch_travel(error);
        }
        let far = error > LOW_STEPS * step && !self.supply_low;
        self.short_us = if far { self.short_us.saturating_add(self.elapsed_us) } else { 0 };
        if self.short_us > self.params.reach_us / 2 {
            return Some(Fault::Burst);
        }
        self.held_us = self.held_us.saturating_add(dt_us);
        if self.held_us < self.params.leak_after_us {
            self.leak.begin(self.filtered_mpa);
            return None;
        }
        self.leak.pass(dt_us as f32, self.filtered_mpa);
        match self.leak.verdict(&self.params, self.filtered_mpa) {
            Tightness::Unclear => None,
            Tightness::Tight => {
                self.leaks = false;
                None
            }
            Tightness::Leaks => {
                self.leaks = true;
                None
            }
            Tightness::Burst => Some(Fault::Burst),
            Tightness::Rises => Some(Fault::FillValve),
        }
    }

    /// On the way: without progress for long, air is lost or comes in.
    pub(super) fn watch_travel(&mut self, error: f32) -> Option<Fault> {
        let step = self.params.sensor_step_mpa;
        self.short_us = 0;
        if self.ramp_mpa != self.setpoint_mpa.unwrap_or(0.0) || self.supply_low {
            self.travel_us = 0;
            self.nearest_mpa = f32::MAX;
            return None;
        }
        if error.abs() < self.nearest_mpa - 2.0 * step {
            self.nearest_mpa = error.abs();
            self.travel_us = 0;
        }
        self.travel_us = self.travel_us.saturating_add(self.elapsed_us);
        if self.travel_us < self.params.reach_us {
            return None;
        }
        if error < -4.0 * step {
            return Some(Fault::FillValve);
        }
        self.leaks = true;
        if error > 4.0 * step && self.travel_us > 2 * self.params.reach_us { Some(Fault::Burst) } else { None }
    }
}
