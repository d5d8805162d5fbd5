//! The chamber's leak, from the pressure that is lost between the pulses of a hold.

use crate::Params;

/// Measurements older than this lose half their weight. µs.
const MEMORY_US: f32 = 60e6;
/// Time after which the loss is added up even without a pulse. µs.
const SEGMENT_US: f32 = 5e6;
/// Sensor steps that must be lost before a leak is believed.
const LEAK_STEPS: f32 = 2.5;
/// Sensor steps that must be gained before the fill valve is not believed to be closed.
const RISE_STEPS: f32 = 6.0;

/// Result of the measurement of the leak.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Tightness {
    Unclear,
    Tight,
    Leaks,
    Burst,
    /// Air comes in while both valves are closed.
    Rises,
}

/// Pressure lost in the time between pulses.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Leak {
    lost_mpa: f32,
    time_us: f32,
    start_mpa: f32,
    segment_us: f32,
}

impl Leak {
    /// Both valves are closed, and the pressure has settled at this reading.
    pub(crate) fn begin(&mut self, mpa: f32) {
        self.start_mpa = mpa;
        self.segment_us = 0.0;
    }

    /// Time passes with both valves closed.
    pub(crate) fn pass(&mut self, dt_us: f32, mpa: f32) {
        self.segment_us += dt_us;
        if self.segment_us > SEGMENT_US {
            self.end(mpa);
        }
    }

    /// A pulse ends the time in which the pressure was left alone.
    pub(crate) fn end(&mut self, mpa: f32) {
        if self.segment_us > 0.0 {
            self.lost_mpa += self.start_mpa - mpa;
            self.time_us += self.segment_us;
        }
        self.segment_us = 0.0;
        self.start_mpa = mpa;
        if self.time_us > MEMORY_US {
            self.lost_mpa *= 0.5;
            self.time_us *= 0.5;
        }
    }

    /// Pressure that is lost, in MPa per second; 0 before anything was measured.
    pub(crate) fn rate(&self, mpa: f32) -> f32 {
        let time_us = self.time_us + self.segment_us;
        // Half a second of readings says nothing.
        if time_us < 0.5e6 { 0.0 } else { (self.lost_mpa + self.start_mpa - mpa) / time_us * 1e6 }
    }

    pub(crate) fn verdict(&self, params: &Params, mpa: f32) -> Tightness {
        let lost = self.lost_mpa + self.start_mpa - mpa;
        let rate = self.rate(mpa);
        let step = params.sensor_step_mpa;
        if lost > LEAK_STEPS * step {
            if rate > params.leak_burst_mpa_per_s && lost > 4.0 * LEAK_STEPS * step {
                return Tightness::Burst;
            }
            if rate > params.leak_report_mpa_per_s {
                return Tightness::Leaks;
            }
        }
        if -lost > RISE_STEPS * step && -rate > 10.0 * params.leak_report_mpa_per_s {
            return Tightness::Rises;
        }
        if self.time_us + self.segment_us > 0.5 * MEMORY_US && rate < 0.5 * params.leak_report_mpa_per_s {
            return Tightness::Tight;
        }
        Tightness::Unclear
    }
}
