//! The links to the drivers during a calibration: as the agent talks to them, with all chambers empty.

mod end;
mod lines;

use std::collections::BTreeMap;
use std::io::Write as _;
use std::time::Duration;

use tokio::io::{AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::process::Child;
use tokio::sync::mpsc;
use tokio::task::JoinSet;
use tokio::time::{Instant, timeout, timeout_at};
use vibrissa_host::task;
use vibrissa_program::signals::StopSignals;
use vibrissa_protocol::Name;

use super::measure::Sample;
use crate::config::{Config, DriverConfig};
use crate::driver::link::{Door, Link};
use crate::driver::told::HelloWhisker;
use crate::driver::{Lines, Opening, ToDriver, VERSION};

/// Time limit for a driver to be reached, and for a line to be written.
const REACH: Duration = Duration::from_secs(15);
const WRITE: Duration = Duration::from_secs(2);
/// Lines that wait to be handled.
const LINES_MAX: usize = 1024;
/// Longest pulse of the interface, ms.
const PULSE_MAX_MS: f64 = 1000.0;
/// Slew of a change of pressure, MPa/s.
const SLEW_MPA_PER_S: f64 = 0.05;

/// A whisker: array and number.
pub(in crate::calibrate) type Place = (Name, u16);

/// Why a calibration ends early.
#[derive(Debug, thiserror::Error)]
pub(in crate::calibrate) enum Ended {
    #[error("{0} has gone")]
    Gone(String),
    #[error("no answer comes any more")]
    NoAnswer,
    #[error("it was stopped")]
    Stopped,
}

/// Lines of the drivers about the present whisker since the last question.
#[derive(Debug, Default)]
pub(in crate::calibrate) struct Seen {
    pub(in crate::calibrate) strains: Vec<Sample>,
    /// Time of receipt and reading of the sensor.
    pub(in crate::calibrate) pressures: Vec<(f64, f64)>,
    /// The newest way of the base.
    pub(in crate::calibrate) deflection_mm: Option<f64>,
}

enum Heard {
    Line(usize, Vec<u8>),
    Gone(usize),
}

/// A driver at the other end of a link.
struct End {
    config: DriverConfig,
    writer: Box<dyn AsyncWrite + Send + Unpin>,
    child: Option<Child>,
    is_there: bool,
}

/// How the air of the present whisker is moved.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Air {
    /// By the driver, to this pressure.
    Held(f64),
    /// By pulses; until then one lasts.
    Pulsed(Instant),
}

/// Open links to all drivers.
pub(in crate::calibrate) struct Session<'a> {
    ends: Vec<End>,
    heard: mpsc::Receiver<Heard>,
    answers: &'a mut mpsc::Receiver<String>,
    signals: &'a mut StopSignals,
    _reading: JoinSet<()>,
    began: Instant,
    repeat: Duration,
    repeat_at: Instant,
    whiskers: BTreeMap<Place, f64>,
    /// Readings of the sensors at an empty chamber.
    zeros: BTreeMap<Place, f64>,
    /// Newest reading of each chamber.
    newest: BTreeMap<Place, f64>,
    present: Option<Place>,
    seen: Seen,
    air: Air,
    /// Pressure above which the present chamber is vented, and whether it was.
    ceiling_mpa: f64,
    exceeded: bool,
}

/// Tells the person at the terminal.
pub(in crate::calibrate) fn say(text: &str) {
    // Without a terminal the calibration goes on to its end, which closes the valves.
    let _ = writeln!(std::io::stdout(), "{text}").and_then(|()| std::io::stdout().flush());
}

impl<'a> Session<'a> {
    /// Reaches all drivers, and greets them with empty chambers.
    ///
    /// # Errors
    /// One cannot be reached.
    pub(in crate::calibrate) async fn open(
        config: &Config,
        answers: &'a mut mpsc::Receiver<String>,
        signals: &'a mut StopSignals,
    ) -> anyhow::Result<Self> {
        let (sender, heard) = mpsc::channel(LINES_MAX);
        let (mut ends, mut reading) = (Vec::new(), JoinSet::new());
        for (index, driver) in config.drivers.iter().enumerate() {
            let reached = async { Door::open(driver).await?.link().await };
            let reached = tokio::select! {
                reached = timeout(REACH, reached) => reached,
                () = signals.received() => anyhow::bail!("it was stopped"),
            };
            let link = reached.map_err(|_| std::io::Error::from(std::io::ErrorKind::TimedOut)).and_then(|link| link);
            let Link { reader, writer, child } =
                link.map_err(|problem| anyhow::anyhow!("cannot reach {}: {problem}", driver.label))?;
            task::spawn_in(&mut reading, read(index, reader, sender.clone()));
            ends.push(End { config: driver.clone(), writer, child, is_there: true });
        }
        let whiskers = config.facts.arrays.iter().flat_map(|array| {
            array.whiskers.iter().map(|one| ((array.array.clone(), one.whisker), one.pressure_max_mpa))
        });
        let repeat_us = config.drivers.iter().map(|driver| driver.limits.repeat_us).min().unwrap_or(2_000_000);
        let now = Instant::now();
        let mut session = Self {
            ends,
            heard,
            answers,
            signals,
            _reading: reading,
            began: now,
            repeat: Duration::from_micros(repeat_us),
            repeat_at: now,
            whiskers: whiskers.collect(),
            zeros: config.whiskers.iter().map(|(place, one)| (place.clone(), one.pressure_zero_mpa)).collect(),
            newest: BTreeMap::new(),
            present: None,
            seen: Seen::default(),
            air: Air::Held(0.0),
            ceiling_mpa: f64::INFINITY,
            exceeded: false,
        };
        for end in 0..session.ends.len() {
            session.greet(end).await;
        }
        Ok(session)
    }

    async fn greet(&mut self, end: usize) {
        let hello = |place: &Place| HelloWhisker {
            array: place.0.clone(),
            whisker: place.1,
            pressure_mpa: 0.0,
            pressure_max_mpa: self.whiskers.get(place).copied().unwrap_or(0.0),
        };
        let whiskers = self.ends[end].config.whiskers.iter().map(hello).collect();
        self.tell(end, &ToDriver::Hello { version: VERSION, whiskers }).await;
    }

    /// Turns to a whisker. All other chambers stay empty.
    pub(in crate::calibrate) fn turn_to(&mut self, place: &Place) {
        (self.present, self.air) = (Some(place.clone()), Air::Held(0.0));
        self.ceiling_mpa = f64::INFINITY;
        self.clear();
        // At once, not with the next repetition.
        self.repeat_at = Instant::now();
    }

    /// The lines about the present whisker.
    pub(in crate::calibrate) fn seen(&self) -> &Seen {
        &self.seen
    }

    /// Forgets the samples, but not the place of the base.
    pub(in crate::calibrate) fn clear(&mut self) {
        (self.seen.strains, self.seen.pressures) = (Vec::new(), Vec::new());
    }

    /// Seconds since the begin, as in [`Seen`].
    pub(in crate::calibrate) fn now_s(&self) -> f64 {
        self.began.elapsed().as_secs_f64()
    }

    /// Vents the present chamber as soon as its sensor reads more than this.
    pub(in crate::calibrate) fn guard(&mut self, ceiling_mpa: f64) {
        (self.ceiling_mpa, self.exceeded) = (ceiling_mpa, false);
    }

    /// Whether it was vented for that.
    pub(in crate::calibrate) fn has_exceeded(&self) -> bool {
        self.exceeded
    }

    /// The sensor of the present chamber reads this when it is empty.
    pub(in crate::calibrate) fn set_zero(&mut self, mpa: f64) {
        self.zeros.extend(self.present.clone().map(|place| (place, mpa)));
    }

    /// Lets the driver hold this pressure, as its sensor reads it.
    pub(in crate::calibrate) async fn hold(&mut self, mpa: f64) {
        self.air = Air::Held(mpa);
        self.repeat().await;
    }

    /// Opens a valve of the present chamber for a pulse.
    pub(in crate::calibrate) async fn pulse(&mut self, open: Opening, for_ms: f64) {
        let for_ms = for_ms.min(PULSE_MAX_MS);
        self.air = Air::Pulsed(Instant::now() + Duration::from_secs_f64(for_ms / 1000.0));
        if let Some((array, whisker)) = self.present.clone() {
            self.tell_whisker(&ToDriver::Valve { array, whisker, open, for_ms }).await;
        }
    }

    /// Asks the person, and waits for a line.
    pub(in crate::calibrate) async fn ask(&mut self, question: &str) -> Result<String, Ended> {
        say(question);
        loop {
            if let Some(answer) = self.next(None).await? {
                return Ok(answer.trim().to_owned());
            }
        }
    }

    /// Listens for so long, or until something is seen; whether it was.
    pub(in crate::calibrate) async fn wait(
        &mut self,
        seconds: f64,
        mut done: impl FnMut(&Seen) -> bool,
    ) -> Result<bool, Ended> {
        let until = Instant::now() + Duration::from_secs_f64(seconds);
        loop {
            if done(&self.seen) {
                return Ok(true);
            }
            if Instant::now() >= until {
                return Ok(false);
            }
            self.next(Some(until)).await?;
        }
    }

    /// Handles the next line, repetition or answer. Answers come only without a limit of the time.
    async fn next(&mut self, until: Option<Instant>) -> Result<Option<String>, Ended> {
        let due = until.map_or(self.repeat_at, |until| until.min(self.repeat_at));
        let heard = tokio::select! {
            () = self.signals.received() => return Err(Ended::Stopped),
            answer = self.answers.recv(), if until.is_none() => return answer.map(Some).ok_or(Ended::NoAnswer),
            heard = timeout_at(due, self.heard.recv()) => heard,
        };
        match heard {
            Ok(Some(Heard::Line(end, line))) => self.take(end, &line).await,
            Ok(Some(Heard::Gone(end))) => {
                self.ends[end].is_there = false;
                return Err(Ended::Gone(self.ends[end].config.label.clone()));
            }
            Ok(None) => return Err(Ended::Gone("each driver".to_owned())),
            Err(_) => {}
        }
        if Instant::now() >= self.repeat_at {
            self.repeat().await;
        }
        Ok(None)
    }

    /// Tells all pressures again: a board that hears nothing vents by its watchdog.
    async fn repeat(&mut self) {
        self.repeat_at = Instant::now() + self.repeat;
        for place in self.whiskers.keys().cloned().collect::<Vec<_>>() {
            let (array, whisker) = place.clone();
            let hold = |pressure_mpa| ToDriver::SetPressure {
                array: array.clone(),
                whisker,
                pressure_mpa,
                slew_mpa_per_s: SLEW_MPA_PER_S,
            };
            let line = match self.air {
                Air::Held(mpa) if self.present.as_ref() == Some(&place) => hold(mpa),
                Air::Pulsed(until) if self.present.as_ref() == Some(&place) => {
                    if Instant::now() < until {
                        continue;
                    }
                    ToDriver::Valve { array: array.clone(), whisker, open: Opening::Close, for_ms: 0.0 }
                }
                Air::Held(_) | Air::Pulsed(_) => hold(0.0),
            };
            self.tell_place(&place, &line).await;
        }
    }

    async fn tell_whisker(&mut self, line: &ToDriver) {
        if let Some(place) = self.present.clone() {
            self.tell_place(&place, line).await;
        }
    }

    async fn tell_place(&mut self, place: &Place, line: &ToDriver) {
        for end in 0..self.ends.len() {
            if self.ends[end].config.whiskers.contains(place) {
                self.tell(end, line).await;
            }
        }
    }

    async fn tell(&mut self, end: usize, line: &ToDriver) {
        let End { writer, is_there, .. } = &mut self.ends[end];
        let write = async { writer.write_all(&line.line()).await.and(writer.flush().await) };
        // The end of its output tells that it has gone.
        if *is_there && !matches!(timeout(WRITE, write).await, Ok(Ok(()))) {
            tracing::debug!("{} reads nothing", self.ends[end].config.label);
        }
    }
}

async fn read(end: usize, mut reader: Box<dyn tokio::io::AsyncRead + Send + Unpin>, sender: mpsc::Sender<Heard>) {
    let (mut buffer, mut cut) = (vec![0; 4096], Lines::default());
    while let Ok(read @ 1..) = reader.read(&mut buffer).await {
        for line in cut.push(&buffer[..read]).into_iter().flatten() {
            if sender.send(Heard::Line(end, line)).await.is_err() {
                return;
            }
        }
    }
    let _ = sender.send(Heard::Gone(end)).await;
}
