//! The effect of a valve's pulses, learned from pulse to pulse: a gain and a dead time.
//!
//! The pressure changes by `gain * drive * (pulse - dead)`, where the drive is the pressure difference over the valve:
//! supply minus chamber, or chamber minus surroundings. Long pulses teach the gain, short ones the dead time.

use crate::Params;

/// Fewest sensor steps of change that tell something of the gain.
const GAIN_STEPS: f32 = 4.0;
/// Sensor steps of change that are expected before a missing answer is believed.
const ANSWER_STEPS: f32 = 3.0;
/// Smallest drive in computations of a pulse, as the pulse would become endless. MPa.
const DRIVE_LEAST_MPA: f32 = 0.005;

/// Whether pulses change the pressure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PulseResponse {
    Unclear,
    Yes,
    No,
}

/// Learned effect of one valve.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gain {
    pub(crate) per_s: f32,
    pub(crate) dead_us: f32,
    /// Least gain that counts as an answer: a part of the learned gain, or of the slowest chamber's.
    least_per_s: f32,
    learned: bool,
    /// Factor on the pulse after pulses that had no effect.
    boost: f32,
    expected_mpa: f32,
    measured_mpa: f32,
}

impl Gain {
    pub(crate) fn new(params: &Params) -> Gain {
        Gain {
            per_s: params.gain_first_per_s,
            dead_us: params.dead_first_us,
            least_per_s: params.gain_least_per_s,
            learned: false,
            boost: 1.0,
            expected_mpa: 0.0,
            measured_mpa: 0.0,
        }
    }

    /// Length of the pulse that changes the pressure by this much, in µs.
    pub(crate) fn pulse_us(&self, params: &Params, change_mpa: f32, drive_mpa: f32, cautious: bool) -> u32 {
        let rate = self.per_s * drive_mpa.max(DRIVE_LEAST_MPA);
        let us = self.dead_us + change_mpa / rate * 1e6 * self.boost;
        // The slowest chamber answers to this one. More would fill a fast one too much if the sensor is frozen.
        let proof_us = params.dead_most_us
            + ANSWER_STEPS * params.sensor_step_mpa / (self.least_per_s * drive_mpa.max(DRIVE_LEAST_MPA)) * 1.05e6;
        let most_us = if self.learned || !cautious {
            params.pulse_most_us as f32
        } else {
            proof_us.min(params.pulse_most_us as f32)
        };
        us.min(most_us) as u32
    }

    /// Takes in what a pulse did.
    pub(crate) fn learn(
        &mut self,
        params: &Params,
        pulse_us: f32,
        drive_mpa: f32,
        change_mpa: f32,
        early: bool,
    ) -> PulseResponse {
        let step = params.sensor_step_mpa;
        let rate = self.per_s * drive_mpa.max(DRIVE_LEAST_MPA);
        let predicted = rate * (pulse_us - self.dead_us).max(0.0) * 1e-6;
        self.boost = if change_mpa < 0.3 * predicted { (self.boost * 1.5).min(16.0) } else { 1.0 };
        if predicted >= GAIN_STEPS * step || (change_mpa >= GAIN_STEPS * step && pulse_us > 3.0 * self.dead_us) {
            let ratio = (change_mpa / predicted.max(0.5 * step)).clamp(0.5, 2.0);
            let weight = if self.learned { 0.5 } else { 1.0 };
            self.per_s = (self.per_s * (1.0 + weight * (ratio - 1.0))).clamp(0.5 * params.gain_least_per_s, 100.0);
            if change_mpa >= GAIN_STEPS * step {
                self.learned = true;
                self.least_per_s = 0.3 * self.per_s;
            }
        } else {
            let error_us = ((predicted - change_mpa) / rate * 1e6).clamp(-3_000.0, 3_000.0);
            self.dead_us = (self.dead_us + 0.5 * error_us).clamp(0.0, params.dead_most_us);
        }
        let dead_us = if self.learned { 1.5 * self.dead_us + 2_000.0 } else { params.dead_most_us };
        self.expected_mpa += self.least_per_s * drive_mpa * (pulse_us - dead_us).max(0.0) * 1e-6;
        // A pulse that was cut short at its aim was answered, even if the air has gone again.
        self.measured_mpa += if early { change_mpa.max(predicted) } else { change_mpa };
        if self.expected_mpa < ANSWER_STEPS * step {
            return PulseResponse::Unclear;
        }
        let answer = if self.measured_mpa > 0.25 * self.expected_mpa { PulseResponse::Yes } else { PulseResponse::No };
        self.expected_mpa = 0.0;
        self.measured_mpa = 0.0;
        answer
    }
}
