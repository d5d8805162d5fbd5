//! Pulses of a valve: their length, the time to settle, and the answer of the pressure.

use super::{Aim, LOW_STEPS, Phase, Regulator};
use crate::learning::PulseResponse;
use crate::{Command, Fault, Way};

impl Regulator {
    pub(super) fn begin(&mut self, way: Way, aim: Aim, change_mpa: f32, supply_mpa: f32) -> Command {
        let mpa = self.quick_mpa;
        let step = self.params.sensor_step_mpa;
        self.leak.end(mpa);
        let (gain, drive_mpa) = match way {
            Way::Fill => (&self.fill, (supply_mpa - mpa).max(0.0)),
            Way::Vent => (&self.vent, mpa.max(0.0)),
        };
        // Far from the aim the rest is left to the next pulse, which knows more.
        let far = change_mpa > 8.0 * step;
        // Close to the limit a pulse that does more than expected would exceed it.
        let limit = way == Way::Fill && mpa + change_mpa > self.params.max_mpa - 4.0 * step;
        let part = match (far, limit) {
            (true, true) => 0.7,
            (true, false) => 0.85,
            (false, true) => 0.6,
            (false, false) if self.reached => 0.8,
            (false, false) => 1.0,
        };
        self.pulse_us = gain.pulse_us(&self.params, part * change_mpa, drive_mpa, way == Way::Fill);
        self.phase = Phase::Pulse;
        self.way = way;
        self.aim = aim;
        self.left_us = self.pulse_us;
        self.early = false;
        self.before_mpa = mpa;
        self.drive_mpa = drive_mpa;
        self.approaches = self.approaches.saturating_add(1);
        match way {
            Way::Fill => {
                self.aim_mpa = mpa + change_mpa;
                Command::Fill(self.pulse_us)
            }
            Way::Vent => {
                self.aim_mpa = mpa - change_mpa;
                Command::Vent(self.pulse_us)
            }
        }
    }

    pub(super) fn pulse(&mut self, dt_us: u32, reading_mpa: f32) -> Command {
        self.left_us = self.left_us.saturating_sub(dt_us);
        let half = 0.5 * self.params.sensor_step_mpa;
        let past = match self.way {
            Way::Fill => reading_mpa > self.aim_mpa + half,
            Way::Vent => reading_mpa < self.aim_mpa - half,
        };
        let early = past && self.left_us > 0;
        if early {
            self.pulse_us -= self.left_us;
            self.early = true;
        }
        if early || self.left_us == 0 {
            self.phase = Phase::Settle;
            self.left_us = self.params.settle_us;
            self.sum_mpa = 0.0;
            self.count = 0;
        }
        if early { Command::Close } else { Command::None }
    }

    pub(super) fn settle(&mut self, dt_us: u32, reading_mpa: f32) -> Command {
        self.left_us = self.left_us.saturating_sub(dt_us);
        if self.left_us <= self.params.settle_us / 2 {
            self.sum_mpa += reading_mpa;
            self.count += 1;
        }
        if self.left_us > 0 || self.count < self.params.settle_readings {
            return Command::None;
        }
        let mean_mpa = self.sum_mpa / self.count as f32;
        self.filtered_mpa = mean_mpa;
        self.quick_mpa = mean_mpa;
        self.leak.begin(mean_mpa);
        self.phase = Phase::Ready;
        self.since_pulse_us = 0;
        let (gain, change_mpa) = match self.way {
            Way::Fill => (&mut self.fill, mean_mpa - self.before_mpa),
            Way::Vent => (&mut self.vent, self.before_mpa - mean_mpa),
        };
        let answer = gain.learn(&self.params, self.pulse_us as f32, self.drive_mpa, change_mpa, self.early);
        match self.aim {
            Aim::Setpoint => self.answered(answer, mean_mpa, change_mpa),
            Aim::Probe => self.probed(self.probe_mpa - mean_mpa),
            Aim::Purge => Command::None,
        }
    }

    /// Draws conclusions from pulses towards the setpoint.
    pub(super) fn answered(&mut self, answer: PulseResponse, mpa: f32, change_mpa: f32) -> Command {
        if self.way == Way::Fill && change_mpa > 1.5 * self.params.sensor_step_mpa {
            self.supply_dead = false;
            self.tries = 0;
        }
        let low = mpa < LOW_STEPS * self.params.sensor_step_mpa;
        match (answer, self.way) {
            (PulseResponse::Unclear | PulseResponse::Yes, _) => {}
            (PulseResponse::No, Way::Vent) if low => self.floor_mpa = mpa,
            (PulseResponse::No, Way::Vent) => return self.fail(Fault::NoResponse),
            (PulseResponse::No, Way::Fill) if !low => self.next = Some(Aim::Probe),
            (PulseResponse::No, Way::Fill) if self.supply_given || self.tries >= 3 => {
                return self.fail(Fault::NoResponse);
            }
            (PulseResponse::No, Way::Fill) => {
                self.tries += 1;
                self.supply_dead = true;
                self.next = Some(Aim::Purge);
            }
        }
        Command::None
    }

    /// Fill pulses did nothing, but does the reading answer to the vent valve?
    pub(super) fn probed(&mut self, change_mpa: f32) -> Command {
        if change_mpa < 1.5 * self.params.sensor_step_mpa {
            self.probes += 1;
            if self.probes >= 5 {
                return self.fail(Fault::NoResponse);
            }
            self.next = Some(Aim::Probe);
            return Command::None;
        }
        self.probes = 0;
        if self.supply_given {
            return self.fail(Fault::FillValve);
        }
        self.supply_dead = true;
        Command::None
    }
}
