//! A whisker: its readings, and the setpoint that moves towards the agent's pressure.

use crate::words::{Estimate, Named, ToAgent};

/// Age from which a reading no longer counts, seconds. The agent wants one each second.
const READING_STALE_S: f64 = 3.0;
/// Age from which a command no longer counts, seconds. The agent repeats it every 2 s.
const COMMAND_STALE_S: f64 = 10.0;
/// Shortest interval of readings for the agent, seconds; those between are left out.
const READING_EVERY_S: f64 = 0.05;
/// Interval of reports of a silence, seconds.
const SILENCE_EVERY_S: f64 = 2.0;
/// Interval in which an unchanged setpoint is repeated, so that a board can vent if it hears none, seconds.
const REPEAT_S: f64 = 1.0;
/// Factors on readings that the contract allows.
const GAINS: std::ops::RangeInclusive<f64> = 0.05..=20.0;
/// Deviation from an order beyond which nothing has set it, MPa: the tolerance of the agent.
const UNMET_MPA: f64 = 0.003;
/// Smallest change that is published at once, MPa.
const CHANGE_MPA: f64 = 1e-6;

#[derive(Debug, Clone, Copy)]
struct Timed<T> {
    at_s: f64,
    value: T,
}

#[derive(Debug, Clone, Copy)]
struct Command {
    pressure_mpa: f64,
    slew_mpa_per_s: f64,
}

/// A whisker of the robot.
#[derive(Debug)]
pub(crate) struct Whisker {
    named: Named,
    opened_at_s: f64,
    /// Whether nothing takes its setpoints.
    is_passive: bool,
    reading: Option<Timed<f64>>,
    passed_on_at_s: f64,
    command: Option<Timed<Command>>,
    /// The setpoint on its way, and when it was computed.
    moving: Option<Timed<f64>>,
    published: Option<Timed<f64>>,
    /// When the silence was last reported; `None` while readings come.
    silent_at_s: Option<f64>,
    /// States of gauge and regulator as a node reports them. Each reading repeats the regulator's: without it the agent
    /// concludes one itself.
    gauge: Option<&'static str>,
    regulator: Option<&'static str>,
    pub(crate) estimate: Option<Estimate>,
    /// Factor on the readings; `None` for a robot that applies no gain.
    pub(crate) reading_gain: Option<f64>,
}

impl Whisker {
    pub(crate) fn new(now_s: f64, named: Named, is_passive: bool) -> Self {
        Self {
            named,
            is_passive,
            opened_at_s: now_s,
            reading: None,
            passed_on_at_s: f64::NEG_INFINITY,
            command: None,
            moving: None,
            published: None,
            silent_at_s: None,
            gauge: None,
            regulator: None,
            estimate: None,
            reading_gain: None,
        }
    }

    /// Its place: array/number.
    pub(crate) fn name(&self) -> String {
        format!("{}/{}", self.named.array, self.named.whisker)
    }

    /// The whisker as the agent names it.
    pub(crate) fn named(&self) -> &Named {
        &self.named
    }

    /// Takes what a new `hello` says of it: another agent may have another limit of the pressure.
    pub(crate) fn rename(&mut self, named: Named) {
        self.named = named;
    }

    /// Whether nothing takes its setpoints.
    pub(crate) fn is_passive(&self) -> bool {
        self.is_passive
    }

    /// The state of the regulator as a node reports it.
    pub(crate) fn regulator(&self) -> Option<&'static str> {
        self.regulator
    }

    /// The pressure that the agent orders and nothing can set, MPa.
    pub(crate) fn unmet_mpa(&self, now_s: f64) -> Option<f64> {
        let command = self.command.filter(|command| self.is_passive && now_s - command.at_s < COMMAND_STALE_S)?;
        let ordered_mpa = command.value.pressure_mpa;
        (self.pressure_mpa(now_s)? - ordered_mpa).abs().gt(&UNMET_MPA).then_some(ordered_mpa)
    }

    /// Takes states that a node reports; returns the line for the agent.
    pub(crate) fn report(&mut self, [gauge, regulator]: [Option<&'static str>; 2]) -> ToAgent {
        self.gauge = gauge.or(self.gauge);
        self.regulator = regulator.or(self.regulator);
        self.fault(gauge, regulator)
    }

    /// The line with all reported states, for an agent that has just come.
    pub(crate) fn reported(&self) -> Option<ToAgent> {
        (self.gauge.is_some() || self.regulator.is_some()).then(|| self.fault(self.gauge, self.regulator))
    }

    fn fault(&self, gauge: Option<&'static str>, regulator: Option<&'static str>) -> ToAgent {
        ToAgent::Fault { array: self.named.array.clone(), whisker: self.named.whisker, gauge, regulator }
    }

    /// The newest reading, MPa, unless it is old.
    pub(crate) fn pressure_mpa(&self, now_s: f64) -> Option<f64> {
        self.reading.filter(|reading| now_s - reading.at_s < READING_STALE_S).map(|reading| reading.value)
    }

    /// The last published setpoint, MPa.
    pub(crate) fn setpoint_mpa(&self) -> Option<f64> {
        self.published.map(|published| published.value)
    }

    /// Takes a command of the agent.
    pub(crate) fn command(&mut self, now_s: f64, pressure_mpa: f64, slew_mpa_per_s: f64) -> Result<(), String> {
        let max_mpa = self.named.pressure_max_mpa;
        if !(0.0..=max_mpa).contains(&pressure_mpa) {
            return Err(format!(
                "{}: the agent commands {pressure_mpa} MPa; allowed are 0 to {max_mpa} MPa",
                self.name()
            ));
        }
        if !(slew_mpa_per_s.is_finite() && slew_mpa_per_s > 0.0) {
            return Err(format!("{}: the agent commands a slew of {slew_mpa_per_s} MPa/s", self.name()));
        }
        self.command = Some(Timed { at_s: now_s, value: Command { pressure_mpa, slew_mpa_per_s } });
        Ok(())
    }

    /// Takes a factor on the readings.
    pub(crate) fn multiply(&mut self, reading_gain: f64) -> Result<(), String> {
        if !GAINS.contains(&reading_gain) {
            return Err(format!("{}: the agent tells a factor of {reading_gain} on readings", self.name()));
        }
        self.reading_gain = Some(reading_gain);
        Ok(())
    }

    /// Takes a reading; returns the line for the agent, unless one has just been sent.
    pub(crate) fn read(&mut self, now_s: f64, t_us: Option<u64>, pressure_mpa: f64) -> Option<ToAgent> {
        self.reading = Some(Timed { at_s: now_s, value: pressure_mpa });
        let has_returned = self.silent_at_s.take().is_some();
        if !has_returned && now_s - self.passed_on_at_s < READING_EVERY_S {
            return None;
        }
        self.passed_on_at_s = now_s;
        let (array, whisker) = (self.named.array.clone(), self.named.whisker);
        let regulator = self.regulator.or(has_returned.then_some("OK"));
        Some(ToAgent::Pressure { array, whisker, t_us, pressure_mpa, regulator })
    }

    /// The fault to report while readings do not come. It is repeated: the agent must not take this driver for silent.
    pub(crate) fn silence(&mut self, now_s: f64) -> Option<ToAgent> {
        let heard_at_s = self.reading.map_or(self.opened_at_s, |reading| reading.at_s);
        let is_due = self.silent_at_s.is_none_or(|at_s| now_s - at_s >= SILENCE_EVERY_S);
        if now_s - heard_at_s < READING_STALE_S || !is_due {
            return None;
        }
        self.silent_at_s = Some(now_s);
        Some(self.fault(None, Some("FAULT")))
    }

    /// Forgets the setpoint on its way: the next one begins at the measured pressure.
    pub(crate) fn release(&mut self) {
        self.moving = None;
        self.published = None;
    }

    /// The setpoint to publish now, MPa. It moves from the measured pressure to the commanded one, as fast as the
    /// command allows. It stops without a fresh reading and a fresh command: a board that hears no setpoint vents.
    pub(crate) fn setpoint(&mut self, now_s: f64) -> Option<f64> {
        let command = self.command.filter(|command| now_s - command.at_s < COMMAND_STALE_S);
        let (Some(command), Some(reading_mpa)) = (command, self.pressure_mpa(now_s)) else {
            self.moving = None;
            return None;
        };
        let command = command.value;
        let begun = Timed { at_s: now_s, value: reading_mpa.clamp(0.0, self.named.pressure_max_mpa) };
        let from = self.moving.unwrap_or(begun);
        let step_mpa = command.slew_mpa_per_s * (now_s - from.at_s).max(0.0);
        let setpoint_mpa = from.value + (command.pressure_mpa - from.value).clamp(-step_mpa, step_mpa);
        self.moving = Some(Timed { at_s: now_s, value: setpoint_mpa });
        let is_due = self.published.is_none_or(|published| {
            (published.value - setpoint_mpa).abs() >= CHANGE_MPA || now_s - published.at_s >= REPEAT_S
        });
        is_due.then(|| {
            self.published = Some(Timed { at_s: now_s, value: setpoint_mpa });
            setpoint_mpa
        })
    }
}
