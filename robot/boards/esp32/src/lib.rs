//! A board for one whisker: the driver interface of vibrissa-robot, two valves, and a watchdog that vents.
//!
//! For any microcontroller whose pins have the traits of `embedded-hal`, such as an ESP32 with `esp-hal`. The program
//! around it reads the converter and the serial line, and calls [`Board::receive`] for each byte and [`Board::step`]
//! every two milliseconds or more often. Nothing here waits or allocates.

#![no_std]

mod gauge;
mod line;

use core::fmt::Write as _;

use embedded_hal::digital::OutputPin;
use gauge::Gauge;
pub use line::Lines;
use line::{field, is_text, number};
use vibrissa_regulator::{Command, Params, Regulator, Valves};

/// Longest line that is read.
const LINE_MOST: usize = 200;
/// Samples in a line of strain.
const SAMPLES: usize = 10;
/// Spacing of the samples. µs.
const STRAIN_US: u64 = 10_000;
/// Spacing of the lines of pressure. µs.
const PRESSURE_US: u64 = 250_000;
/// Without an order for this long the board vents. µs.
const SILENT_US: u64 = 5_000_000;
/// An order may exceed the limit by the zero of a sensor, which the agent adds, MPa. It counts as the limit.
const ABOVE_MPA: f32 = 0.01;
/// Length of a pulse that ends a pressure above the limit. µs.
const RELIEF_US: u32 = 100_000;

/// Readings of the sensors.
#[derive(Clone, Copy, Debug)]
pub struct Readings {
    /// Pressure of the chamber, MPa; not a number if it could not be read.
    pub pressure_mpa: f32,
    /// Pressure of the supply, MPa, if there is a sensor.
    pub supply_mpa: Option<f32>,
    /// Strain of the gauge, m/m; not a number if it could not be read.
    pub strain: f32,
    /// Whether the converter of the strain is at an end of its range, so that the strain may be larger.
    pub strain_at_end: bool,
    /// Way of the whisker's base by a slide potentiometer, mm, if there is one: without a way the agent makes no contacts of
    /// the strain. Not a number if it could not be read.
    pub deflection_mm: Option<f32>,
}

/// The board of one whisker.
pub struct Board<Fill, Vent> {
    fill: Fill,
    vent: Vent,
    array: &'static str,
    whisker: u32,
    limit_mpa: f32,
    regulator: Regulator,
    valves: Valves,
    line: [u8; LINE_MOST],
    length: usize,
    too_long: bool,
    last_line_us: u64,
    by_hand: bool,
    silent: bool,
    /// An order above the limit is to be answered.
    refused: bool,
    pressure_mpa: f32,
    strains: [f32; SAMPLES],
    ways_mm: [f32; SAMPLES],
    strain_count: usize,
    strain_first_us: u64,
    gauge: Gauge,
    next_strain_us: u64,
    next_pressure_us: u64,
    said_hello: bool,
}

impl<Fill: OutputPin, Vent: OutputPin> Board<Fill, Vent> {
    /// A board with both valves closed.
    ///
    /// # Errors
    /// A pin could not be set.
    pub fn new(
        mut fill: Fill,
        mut vent: Vent,
        array: &'static str,
        whisker: u32,
        limit_mpa: f32,
    ) -> Result<Self, PinError> {
        fill.set_low().map_err(|_| PinError)?;
        vent.set_low().map_err(|_| PinError)?;
        Ok(Board {
            fill,
            vent,
            array,
            whisker,
            limit_mpa,
            regulator: Regulator::new(Params { max_mpa: limit_mpa, ..Params::default() }),
            valves: Valves::new(),
            line: [0; LINE_MOST],
            length: 0,
            too_long: false,
            last_line_us: 0,
            by_hand: false,
            silent: false,
            refused: false,
            pressure_mpa: 0.0,
            strains: [0.0; SAMPLES],
            ways_mm: [0.0; SAMPLES],
            strain_count: 0,
            strain_first_us: 0,
            gauge: Gauge::default(),
            next_strain_us: 0,
            next_pressure_us: 0,
            said_hello: false,
        })
    }

    /// Takes a byte of the serial line.
    pub fn receive(&mut self, now_us: u64, byte: u8) {
        if byte != b'\n' {
            match self.line.get_mut(self.length) {
                Some(place) => {
                    *place = byte;
                    self.length += 1;
                }
                None => self.too_long = true,
            }
            return;
        }
        let line = self.line;
        let length = self.length;
        let too_long = self.too_long;
        self.length = 0;
        self.too_long = false;
        // Lines for richer drivers may be longer: they are not read.
        if !too_long && let Ok(text) = core::str::from_utf8(&line[..length]) {
            self.take(now_us, text.trim_end());
        }
    }

    /// Only an order that this board obeys shows that somebody holds the pressure: noise, echoes and orders for others do not.
    fn heard(&mut self, now_us: u64) {
        self.last_line_us = now_us;
        self.silent = false;
    }

    fn take(&mut self, now_us: u64, line: &str) {
        let Some(kind) = field(line, "type") else { return };
        // Of a line that lost its end, the last number may be another one.
        let is_whole = line.starts_with('{') && line.ends_with('}');
        let mine = field(line, "array").is_none_or(|array| is_text(array, self.array))
            && field(line, "whisker").is_none_or(|text| number(text) == Some(self.whisker as f32));
        if !mine || !is_whole {
            return;
        }
        if is_text(kind, "set_pressure") {
            let Some(mpa) = field(line, "pressure_mpa").and_then(number) else { return };
            if (0.0..=self.limit_mpa + ABOVE_MPA).contains(&mpa) {
                self.heard(now_us);
                self.by_hand = false;
                self.regulator
                    .set_target(mpa.min(self.limit_mpa), field(line, "slew_mpa_per_s").and_then(number).unwrap_or(0.0));
            }
            self.refused = mpa > self.limit_mpa + ABOVE_MPA;
        } else if is_text(kind, "valve") {
            let Some(ms) = field(line, "for_ms").and_then(number).filter(|ms| (0.0..=1000.0).contains(ms)) else {
                return;
            };
            let Some(open) = field(line, "open") else { return };
            if !["FILL", "VENT", "CLOSE"].iter().any(|word| is_text(open, word)) {
                return;
            }
            let us = (ms * 1000.0) as u32;
            self.heard(now_us);
            self.by_hand = true;
            if is_text(open, "FILL") && self.pressure_mpa < self.limit_mpa {
                self.valves.apply(now_us, Command::Fill(us));
            } else if is_text(open, "VENT") {
                self.valves.apply(now_us, Command::Vent(us));
            } else if is_text(open, "CLOSE") {
                self.valves.apply(now_us, Command::Close);
            }
        }
    }

    /// Regulates, closes valves whose pulse is over, and adds lines to send.
    ///
    /// # Errors
    /// A pin could not be set: the caller should let its hardware watchdog restart the board.
    pub fn step<const N: usize>(
        &mut self,
        now_us: u64,
        readings: Readings,
        lines: &mut Lines<N>,
    ) -> Result<(), PinError> {
        if lines.forget_old(now_us) {
            self.said_hello = false;
        }
        self.pressure_mpa = readings.pressure_mpa;
        if !self.silent && now_us.saturating_sub(self.last_line_us) >= SILENT_US {
            self.silent = true;
            self.by_hand = false;
            self.regulator.set_target(0.0, 0.0);
        }
        let command = self.regulator.step(now_us, readings.pressure_mpa, readings.supply_mpa);
        if !self.by_hand {
            self.valves.apply(now_us, command);
        } else if readings.pressure_mpa > self.limit_mpa && !self.valves.outputs(now_us).1 {
            self.valves.apply(now_us, Command::Vent(RELIEF_US));
        }
        let (fill, vent) = self.valves.outputs(now_us);
        self.fill.set_state(fill.into()).map_err(|_| PinError)?;
        self.vent.set_state(vent.into()).map_err(|_| PinError)?;
        self.report(now_us, readings, lines);
        Ok(())
    }

    fn report<const N: usize>(&mut self, now_us: u64, readings: Readings, lines: &mut Lines<N>) {
        if !self.said_hello {
            // A restart may have cut a line, or nobody took the rest: the first end of line separates it from this one.
            self.said_hello =
                lines.add(|line| line.write_str("\n{\"type\":\"hello\",\"version\":1,\"name\":\"vibrissa-board\"}"));
        }
        let (array, whisker) = (self.array, self.whisker);
        if self.refused {
            let limit_mpa = self.limit_mpa;
            let told = lines.add(|line| {
                write!(line, "{{\"type\":\"error\",\"array\":\"{array}\",\"whisker\":{whisker},")?;
                write!(line, "\"problem\":\"the pressure is above limit_mpa, which is {limit_mpa}\",")?;
                line.write_str("\"do\":\"lower pressure_max_mpa in agent.toml, or raise the limit of the board\"}")
            });
            self.refused = !told;
        }
        self.gauge.read(readings.strain, readings.strain_at_end);
        if let Some(word) = self.gauge.due(now_us) {
            let ms = now_us / 1000;
            let told = lines.add(|line| {
                write!(line, "{{\"type\":\"fault\",\"array\":\"{array}\",\"whisker\":{whisker},\"t_ms\":{ms}")?;
                write!(line, ",\"gauge\":\"{word}\"}}")
            });
            if told {
                self.gauge.told(now_us);
            }
        }
        let (strain, way_mm) = (readings.strain, readings.deflection_mm.unwrap_or_default());
        // JSON has no NaN: the next reading takes the place of one that failed.
        if now_us >= self.next_strain_us && strain.is_finite() && way_mm.is_finite() {
            // The samples of a line are evenly spaced. After a gap both line and grid begin anew.
            if now_us.saturating_sub(self.next_strain_us) > 3 * STRAIN_US {
                self.strain_count = 0;
                self.next_strain_us = now_us;
            }
            self.next_strain_us += STRAIN_US;
            if self.strain_count == 0 {
                self.strain_first_us = now_us;
            }
            self.strains[self.strain_count] = strain;
            self.ways_mm[self.strain_count] = way_mm;
            self.strain_count += 1;
            if self.strain_count == SAMPLES {
                self.strain_count = 0;
                let (ms, strains) = (self.strain_first_us / 1000, &self.strains);
                let ways_mm = readings.deflection_mm.map(|_| &self.ways_mm);
                lines.add(|line| {
                    write!(line, "{{\"type\":\"strain\",\"array\":\"{array}\",\"whisker\":{whisker},\"t_ms\":{ms}")?;
                    write!(line, ",\"every_us\":{STRAIN_US},\"strain\":")?;
                    write_list(line, strains, 6)?;
                    if let Some(ways_mm) = ways_mm {
                        line.write_str(",\"deflection_mm\":")?;
                        write_list(line, ways_mm, 2)?;
                    }
                    line.write_str("}")
                });
            }
        }
        if now_us >= self.next_pressure_us && self.pressure_mpa.is_finite() {
            let (ms, mpa, condition) = (now_us / 1000, self.pressure_mpa, self.regulator.condition().word());
            let sent = lines.add(|line| {
                write!(line, "{{\"type\":\"pressure\",\"array\":\"{array}\",\"whisker\":{whisker},\"t_ms\":{ms}")?;
                write!(line, ",\"pressure_mpa\":{mpa:.5},\"regulator\":\"{condition}\"}}")
            });
            if sent {
                self.next_pressure_us = (self.next_pressure_us + PRESSURE_US).max(now_us);
            }
        }
    }
}

fn write_list(line: &mut impl core::fmt::Write, numbers: &[f32], places: usize) -> core::fmt::Result {
    for (index, number) in numbers.iter().enumerate() {
        write!(line, "{}{number:.places$}", if index == 0 { '[' } else { ',' })?;
    }
    line.write_str("]")
}

/// A pin could not be set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PinError;
