//! The state machine: ready, pulse, settle. `pulse.rs` has the pulses, and `watch.rs` the decisions between them.

mod pulse;
mod watch;

use crate::diagnosis::Leak;
use crate::learning::Gain;
use crate::{Command, Condition, Fault, Params, Way};

/// Longest time between two steps that is believed: after a longer one the machine starts anew. µs.
const GAP_US: u64 = 2_000_000;
/// Below so many sensor steps the vent valve cannot prove anything, and a reading may be the sensor's zero error.
const LOW_STEPS: f32 = 8.0;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    Ready,
    Pulse,
    Settle,
}

/// Reason for a pulse.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Aim {
    Setpoint,
    /// Vents a little, to see whether the reading answers.
    Probe,
    /// Vents what fill pulses without an answer may have let in.
    Purge,
}

/// Regulates one chamber.
#[derive(Clone, Debug)]
pub struct Regulator {
    params: Params,
    setpoint_mpa: Option<f32>,
    slew_mpa_per_s: f32,
    ramp_mpa: f32,
    last_us: Option<u64>,
    // Readings.
    filtered_mpa: f32,
    /// Filtered with a sixth of the time constant: what is left when a pulse begins.
    quick_mpa: f32,
    known: bool,
    bad_us: u32,
    good_us: u32,
    // The pulse.
    phase: Phase,
    way: Way,
    aim: Aim,
    pulse_us: u32,
    left_us: u32,
    before_mpa: f32,
    drive_mpa: f32,
    aim_mpa: f32,
    early: bool,
    sum_mpa: f32,
    count: u32,
    since_pulse_us: u32,
    /// Time that the pressure is out of the band.
    off_us: u32,
    /// Time since the machine was ready, pulses included.
    elapsed_us: u32,
    // Progress.
    reached: bool,
    approaches: u32,
    travel_us: u32,
    nearest_mpa: f32,
    short_us: u32,
    held_us: u32,
    floor_mpa: f32,
    fill: Gain,
    vent: Gain,
    // Diagnosis.
    leak: Leak,
    leaks: bool,
    supply_low: bool,
    supply_given: bool,
    supply_dead: bool,
    tries: u32,
    next: Option<Aim>,
    probes: u32,
    probe_mpa: f32,
    fault: Option<Fault>,
    vented_us: u32,
}

impl Regulator {
    /// A regulator without a setpoint: both valves stay closed.
    pub fn new(params: Params) -> Regulator {
        Regulator {
            setpoint_mpa: None,
            slew_mpa_per_s: 0.0,
            ramp_mpa: 0.0,
            last_us: None,
            filtered_mpa: 0.0,
            quick_mpa: 0.0,
            known: false,
            bad_us: 0,
            good_us: 0,
            phase: Phase::Ready,
            way: Way::Fill,
            aim: Aim::Setpoint,
            pulse_us: 0,
            left_us: 0,
            before_mpa: 0.0,
            drive_mpa: 0.0,
            aim_mpa: 0.0,
            early: false,
            off_us: 0,
            probe_mpa: 0.0,
            sum_mpa: 0.0,
            count: 0,
            since_pulse_us: u32::MAX,
            elapsed_us: 0,
            reached: false,
            approaches: 0,
            travel_us: 0,
            nearest_mpa: f32::MAX,
            short_us: 0,
            held_us: 0,
            floor_mpa: 0.0,
            fill: Gain::new(&params),
            vent: Gain::new(&params),
            leak: Leak::default(),
            leaks: false,
            supply_low: false,
            supply_given: false,
            supply_dead: false,
            tries: 0,
            next: None,
            probes: 0,
            fault: None,
            vented_us: 0,
            params,
        }
    }

    /// Sets the pressure to hold, and the fastest change in MPa per second (0: as fast as the valves can). A pressure
    /// beyond the limits is cut to them; one that is not a number is ignored. A changed setpoint ends a fault.
    pub fn set_target(&mut self, setpoint_mpa: f32, slew_mpa_per_s: f32) {
        if setpoint_mpa.is_nan() {
            return;
        }
        let setpoint_mpa = setpoint_mpa.clamp(0.0, self.params.max_mpa);
        self.slew_mpa_per_s = if slew_mpa_per_s > 0.0 { slew_mpa_per_s } else { 0.0 };
        if self.setpoint_mpa == Some(setpoint_mpa) {
            return;
        }
        self.setpoint_mpa = Some(setpoint_mpa);
        self.ramp_mpa = self.filtered_mpa;
        self.leak = Leak::default();
        self.start_travel();
        self.clear_fault();
    }

    /// Ends a fault; it comes back if its cause is still there.
    pub fn clear_fault(&mut self) {
        self.fault = None;
        self.vented_us = 0;
        self.tries = 0;
        self.probes = 0;
        self.next = None;
    }

    /// The pressure to hold.
    pub fn target_mpa(&self) -> Option<f32> {
        self.setpoint_mpa
    }

    /// The filtered reading; none before the first good one.
    pub fn pressure_mpa(&self) -> Option<f32> {
        self.known.then_some(self.filtered_mpa)
    }

    /// Pressure that the chamber loses, in MPa per second; 0 until it was measured.
    pub fn leak_mpa_per_s(&self) -> f32 {
        self.leak.rate(self.filtered_mpa)
    }

    /// Reason for which the regulator has stopped.
    pub fn fault(&self) -> Option<Fault> {
        self.fault
    }

    /// Learned gains per second and dead times in µs, of the fill valve and of the vent valve.
    pub fn learned(&self) -> [(f32, f32); 2] {
        [(self.fill.per_s, self.fill.dead_us), (self.vent.per_s, self.vent.dead_us)]
    }

    /// Condition to report.
    pub fn condition(&self) -> Condition {
        if self.fault.is_some() {
            return Condition::Fault;
        }
        if self.supply_low {
            return Condition::SupplyLow;
        }
        if self.leaks {
            return Condition::Leak;
        }
        match self.setpoint_mpa {
            Some(setpoint_mpa) if self.known && !self.reached => {
                if setpoint_mpa > self.filtered_mpa {
                    Condition::Filling
                } else {
                    Condition::Venting
                }
            }
            Some(_) | None => Condition::Ok,
        }
    }

    /// One step: the time, a reading of the chamber, and a reading of the supply if there is one.
    ///
    /// Call it with each reading: 100 times a second or more while a valve is open, four times a second at least.
    pub fn step(&mut self, now_us: u64, reading_mpa: f32, supply_mpa: Option<f32>) -> Command {
        let gap_us = self.last_us.map_or(0, |last_us| now_us.saturating_sub(last_us));
        self.last_us = Some(now_us);
        if gap_us > GAP_US {
            self.start_anew();
        }
        self.advance(gap_us.min(GAP_US) as u32, reading_mpa, supply_mpa)
    }

    fn start_anew(&mut self) {
        self.phase = Phase::Ready;
        self.known = false;
        self.leak = Leak::default();
        self.start_travel();
    }

    fn start_travel(&mut self) {
        self.reached = false;
        self.approaches = 0;
        self.travel_us = 0;
        self.nearest_mpa = f32::MAX;
        self.short_us = 0;
        self.held_us = 0;
        self.elapsed_us = 0;
    }

    fn advance(&mut self, dt_us: u32, reading_mpa: f32, supply_mpa: Option<f32>) -> Command {
        self.since_pulse_us = self.since_pulse_us.saturating_add(dt_us);
        self.elapsed_us = self.elapsed_us.saturating_add(dt_us);
        // False for a NaN.
        let good = reading_mpa >= self.params.reading_low_mpa && reading_mpa <= self.params.reading_high_mpa;
        if !good {
            return self.bad_reading(dt_us);
        }
        self.good_us = self.good_us.saturating_add(dt_us);
        if self.good_us > self.params.sensor_us {
            self.bad_us = 0;
            if self.fault == Some(Fault::Sensor) {
                self.clear_fault();
                self.start_anew();
            }
        }
        let dt = dt_us as f32;
        if self.known {
            let filter_us = if self.reached { self.params.filter_us } else { 0.3 * self.params.filter_us };
            self.filtered_mpa += (reading_mpa - self.filtered_mpa) * dt / (filter_us + dt);
            self.quick_mpa += (reading_mpa - self.quick_mpa) * dt / (self.params.filter_us / 6.0 + dt);
        } else {
            self.filtered_mpa = reading_mpa;
            self.quick_mpa = reading_mpa;
            self.ramp_mpa = reading_mpa;
            self.known = true;
            self.leak.begin(reading_mpa);
        }
        if self.fault.is_some() {
            return self.stopped(dt_us, reading_mpa);
        }
        let Some(setpoint_mpa) = self.setpoint_mpa else {
            return Command::None;
        };
        self.move_ramp(setpoint_mpa, dt);
        self.see_supply(setpoint_mpa, supply_mpa);
        match self.phase {
            Phase::Pulse => self.pulse(dt_us, reading_mpa),
            Phase::Settle => self.settle(dt_us, reading_mpa),
            Phase::Ready => self.ready(dt_us, reading_mpa, supply_mpa),
        }
    }

    fn bad_reading(&mut self, dt_us: u32) -> Command {
        self.good_us = 0;
        self.bad_us = self.bad_us.saturating_add(dt_us);
        if self.fault.is_some() {
            return self.stopped(dt_us, self.params.reading_high_mpa);
        }
        if self.bad_us > self.params.sensor_us {
            return self.fail(Fault::Sensor);
        }
        if self.phase == Phase::Ready {
            return Command::None;
        }
        self.phase = Phase::Ready;
        Command::Close
    }

    fn fail(&mut self, fault: Fault) -> Command {
        self.fault = Some(fault);
        self.phase = Phase::Ready;
        self.left_us = 0;
        self.vented_us = 0;
        self.leak = Leak::default();
        Command::Close
    }

    /// In a fault: vents until the chamber is empty or the time for it is over.
    fn stopped(&mut self, dt_us: u32, reading_mpa: f32) -> Command {
        self.left_us = self.left_us.saturating_sub(dt_us);
        // A frozen reading does not tell that the chamber is empty.
        let empty = self.fault != Some(Fault::NoResponse) && reading_mpa < 2.0 * self.params.sensor_step_mpa;
        let over = reading_mpa > self.params.max_mpa && self.fault != Some(Fault::Sensor);
        let may = self.vented_us < self.params.vent_on_fault_us || over;
        if self.left_us > 0 || !self.params.vent_on_fault || empty || !may {
            return Command::None;
        }
        let pulse_us = self.params.pulse_most_us;
        self.left_us = pulse_us;
        self.vented_us = self.vented_us.saturating_add(pulse_us);
        Command::Vent(pulse_us)
    }

    fn move_ramp(&mut self, setpoint_mpa: f32, dt: f32) {
        if self.slew_mpa_per_s > 0.0 {
            let most = self.slew_mpa_per_s * dt * 1e-6;
            self.ramp_mpa += (setpoint_mpa - self.ramp_mpa).clamp(-most, most);
        } else {
            self.ramp_mpa = setpoint_mpa;
        }
    }

    fn see_supply(&mut self, setpoint_mpa: f32, supply_mpa: Option<f32>) {
        self.supply_given = false;
        let Some(supply_mpa) = supply_mpa.filter(|mpa| mpa.is_finite()) else {
            self.supply_low = self.supply_dead;
            return;
        };
        self.supply_given = true;
        self.supply_dead = false;
        // A tenth of the margin as hysteresis keeps the word from flickering.
        let margin = if self.supply_low { 1.1 } else { 1.0 } * self.params.supply_margin_mpa;
        self.supply_low = supply_mpa < setpoint_mpa + margin;
    }
}
