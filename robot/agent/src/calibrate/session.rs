//! The links to the drivers during a calibration: as the agent talks to them, with all chambers empty.

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
use crate::driver::words::{HelloWhisker, Origin, Samples};
use crate::driver::{FromDriver, Lines, Opening, ToDriver, VERSION};

/// Time limit for a driver to be reached, and for a line to be written.
const REACH: Duration = Duration::from_secs(15);
const WRITE: Duration = Duration::from_secs(2);
/// Lines that wait to be handled.
const LINES_MAX: usize = 1024;
/// Longest pulse of the interface, ms.
const PULSE_MAX_MS: f64 = 1000.0;
/// Longest time for all chambers to be empty at the end, and the pressure that counts as empty.
const VENT: Duration = Duration::from_secs(15);
const EMPTY_MPA: f64 = 0.003;
/// Slew of a change of pressure, MPa/s.
const SLEW_MPA_PER_S: f64 = 0.05;

/// A whisker: array and number.
pub(super) type Place = (Name, u16);

/// Why a calibration ends early.
#[derive(Debug, thiserror::Error)]
pub(super) enum Ended {
    #[error("{0} has gone")]
    Gone(String),
    #[error("no answer comes any more")]
    NoAnswer,
    #[error("it was stopped")]
    Stopped,
}

/// Lines of the drivers about the present whisker since the last question.
#[derive(Debug, Default)]
pub(super) struct Seen {
    pub(super) strains: Vec<Sample>,
    /// Time of receipt and reading of the sensor.
    pub(super) pressures: Vec<(f64, f64)>,
    /// The newest way of the base.
    pub(super) deflection_mm: Option<f64>,
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
pub(super) struct Session<'a> {
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
pub(super) fn say(text: &str) {
    // Without a terminal the calibration goes on to its end, which closes the valves.
    let _ = writeln!(std::io::stdout(), "{text}").and_then(|()| std::io::stdout().flush());
}

impl<'a> Session<'a> {
    /// Reaches all drivers, and greets them with empty chambers.
    ///
    /// # Errors
    /// One cannot be reached.
    pub(super) async fn open(
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
    pub(super) fn turn_to(&mut self, place: &Place) {
        (self.present, self.air) = (Some(place.clone()), Air::Held(0.0));
        self.ceiling_mpa = f64::INFINITY;
        self.clear();
        // At once, not with the next repetition.
        self.repeat_at = Instant::now();
    }

    /// The lines about the present whisker.
    pub(super) fn seen(&self) -> &Seen {
        &self.seen
    }

    /// Forgets the samples, but not the place of the base.
    pub(super) fn clear(&mut self) {
        (self.seen.strains, self.seen.pressures) = (Vec::new(), Vec::new());
    }

    /// Seconds since the begin, as in [`Seen`].
    pub(super) fn now_s(&self) -> f64 {
        self.began.elapsed().as_secs_f64()
    }

    /// Vents the present chamber as soon as its sensor reads more than this.
    pub(super) fn guard(&mut self, ceiling_mpa: f64) {
        (self.ceiling_mpa, self.exceeded) = (ceiling_mpa, false);
    }

    /// Whether it was vented for that.
    pub(super) fn has_exceeded(&self) -> bool {
        self.exceeded
    }

    /// The sensor of the present chamber reads this when it is empty.
    pub(super) fn set_zero(&mut self, mpa: f64) {
        self.zeros.extend(self.present.clone().map(|place| (place, mpa)));
    }

    /// Lets the driver hold this pressure, as its sensor reads it.
    pub(super) async fn hold(&mut self, mpa: f64) {
        self.air = Air::Held(mpa);
        self.repeat().await;
    }

    /// Opens a valve of the present chamber for a pulse.
    pub(super) async fn pulse(&mut self, open: Opening, for_ms: f64) {
        let for_ms = for_ms.min(PULSE_MAX_MS);
        self.air = Air::Pulsed(Instant::now() + Duration::from_secs_f64(for_ms / 1000.0));
        if let Some((array, whisker)) = self.present.clone() {
            self.tell_whisker(&ToDriver::Valve { array, whisker, open, for_ms }).await;
        }
    }

    /// Asks the person, and waits for a line.
    pub(super) async fn ask(&mut self, question: &str) -> Result<String, Ended> {
        say(question);
        loop {
            if let Some(answer) = self.next(None).await? {
                return Ok(answer.trim().to_owned());
            }
        }
    }

    /// Listens for so long, or until something is seen; whether it was.
    pub(super) async fn wait(&mut self, seconds: f64, mut done: impl FnMut(&Seen) -> bool) -> Result<bool, Ended> {
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

    async fn take(&mut self, end: usize, line: &[u8]) {
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
            | FromDriver::Driving(_) => {}
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

    /// Empties all chambers, closes all valves, and ends the links; whether all chambers are known to be empty.
    pub(super) async fn close(mut self) -> bool {
        let until = Instant::now() + VENT;
        let (mut is_empty, mut pulse_at) = (false, Instant::now());
        (self.present, self.air) = (None, Air::Held(0.0));
        self.newest.clear();
        self.repeat().await;
        while !is_empty && Instant::now() < until && self.ends.iter().any(|end| end.is_there) {
            if Instant::now() >= pulse_at {
                // Only drivers without a regulator need pulses: for others `set_pressure` is enough.
                self.tell_valves(Opening::Vent, PULSE_MAX_MS, true).await;
                pulse_at = Instant::now() + Duration::from_millis(500);
            }
            if let Ok(Some(heard)) = timeout_at(pulse_at, self.heard.recv()).await {
                match heard {
                    Heard::Line(end, line) => self.take(end, &line).await,
                    Heard::Gone(end) => self.ends[end].is_there = false,
                }
            }
            if Instant::now() >= self.repeat_at {
                self.repeat().await;
            }
            let zero_mpa = |place| self.zeros.get(place).copied().unwrap_or(0.0);
            let is_at_zero = |place| self.newest.get(place).is_some_and(|mpa| *mpa - zero_mpa(place) <= EMPTY_MPA);
            is_empty = self.whiskers.keys().all(is_at_zero);
        }
        self.tell_valves(Opening::Close, 0.0, false).await;
        for End { writer, child, .. } in self.ends {
            Link { reader: Box::new(tokio::io::empty()), writer, child }.close().await;
        }
        is_empty
    }

    async fn tell_valves(&mut self, open: Opening, for_ms: f64, only_without_regulator: bool) {
        for end in 0..self.ends.len() {
            if only_without_regulator && !self.ends[end].config.limits.regulate {
                continue;
            }
            for (array, whisker) in self.ends[end].config.whiskers.clone() {
                self.tell(end, &ToDriver::Valve { array, whisker, open, for_ms }).await;
            }
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
