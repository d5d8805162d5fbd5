//! Robots' messages at the limits of the contract: the least and greatest values of each range, numbers close to zero,
//! clocks that are years off, texts with control characters.
//!
//! Ranges, words and lengths come from the contract's own schemas, so a change of the contract also changes these
//! messages. The same seed gives the same messages.

mod finite;
mod shape;
mod values;
mod without;

use std::fmt::{Display, Write as _};

use rand::Rng;
use rand::seq::IndexedRandom;
use vibrissa_protocol::RobotTopic;
use vibrissa_protocol::document::{Channel, json_schema};

pub use finite::not_finite;
pub use shape::{Range, Shape, Text};
pub use values::{number, time_us, write_number};
pub use without::Without;

/// The topics that robots publish on.
pub const FROM_ROBOTS: [RobotTopic; 5] = [
    RobotTopic::Connection,
    RobotTopic::Factsheet,
    RobotTopic::Contacts,
    RobotTopic::Status,
    RobotTopic::SetpointState,
];

/// The identifiers and times that make a message relevant to the supervisor.
#[derive(Debug, Clone, Default)]
pub struct Context {
    /// Boot id of the robot.
    pub boot_id: String,
    /// Sequence number of the message.
    pub seq: u64,
    /// Current time, in microseconds since 1970 UTC.
    pub now_us: u64,
    /// Names of arrays, each with its number of whiskers.
    pub arrays: Vec<(String, u16)>,
    /// Names of the whisker models that the supervisor has loaded.
    pub models: Vec<String>,
    /// Command ids of the setpoints that wait for an answer.
    pub commands: Vec<String>,
    /// Target pressures of whiskers, in MPa; two thirds of all drawn pressures are among them. The supervisor does not
    /// use contacts that were measured far from the target pressure.
    pub pressures_mpa: Vec<f64>,
    /// Share of correct times, from 0 to 1: one wrong time may make the supervisor ignore all later messages.
    pub right_times: f64,
    /// Share of odd texts, from 0 to 1: after a refused factsheet the supervisor ignores all later messages.
    pub odd_texts: f64,
    /// Largest number of entries in a list.
    pub list_most: usize,
}

/// Draws random robot messages from the schemas of the contract.
#[derive(Debug, Clone)]
pub struct Messages {
    shapes: [Shape; FROM_ROBOTS.len()],
}

impl Default for Messages {
    fn default() -> Self {
        let of = |kind| {
            let schema = serde_json::to_value(json_schema(Channel::Robot(kind))).expect("a schema is JSON");
            Shape::of_schema(&schema)
        };
        Self { shapes: FROM_ROBOTS.map(of) }
    }
}

impl Messages {
    /// The shape of the messages of a topic.
    ///
    /// # Panics
    /// Robots do not publish on the topic.
    #[must_use]
    pub fn shape(&self, kind: RobotTopic) -> &Shape {
        let at = FROM_ROBOTS.iter().position(|&one| one == kind);
        &self.shapes[at.expect("a topic of robots")]
    }

    /// The range of a field of contacts, such as `strain`, as the contract allows it.
    ///
    /// # Panics
    /// Contacts have no number of that name.
    #[must_use]
    pub fn contact_range(&self, field: &str) -> Range {
        let ranges = self.shape(RobotTopic::Contacts).at(&["contacts", field]).map(Shape::ranges).unwrap_or_default();
        assert!(!ranges.is_empty(), "contacts have no number {field}");
        let least = ranges.iter().map(|range| range.least).fold(f64::MAX, f64::min);
        Range { least, most: ranges.iter().map(|range| range.most).fold(f64::MIN, f64::max) }
    }

    /// Draws a message of one topic, as JSON.
    pub fn draw(&self, random: &mut impl Rng, kind: RobotTopic, context: &Context) -> String {
        let mut out = String::new();
        Writer { context, random, whisker: 0, whiskers: 0, pressures: [None; 2] }.write(self.shape(kind), "", &mut out);
        out
    }
}

/// Fields that state a contact's place, and the sets of them that the contract allows.
const PLACE_FIELDS: [&str; 5] = ["ratio", "ratio_sd", "distance_mm", "distance_sd_mm", "tip"];
const PLACES: [&[&str]; 6] = [
    &["ratio"],
    &["ratio", "ratio_sd"],
    &["distance_mm"],
    &["distance_mm", "distance_sd_mm"],
    &["distance_mm", "distance_sd_mm", "tip"],
    &[],
];

struct Writer<'a, R> {
    context: &'a Context,
    random: &'a mut R,
    /// Number of the whisker being written in the factsheet's array.
    whisker: u16,
    whiskers: u16,
    /// Nominal pressure of that whisker and its pressure limit, which must not be below the nominal pressure.
    pressures: [Option<f64>; 2],
}

impl<R: Rng> Writer<'_, R> {
    fn write(&mut self, shape: &Shape, name: &str, out: &mut String) {
        if self.write_known(shape, name, out) {
            return;
        }
        match shape {
            Shape::Constant(json) => out.push_str(json),
            Shape::Choice(choices) => {
                if let Some(choice) = choices.choose(self.random) {
                    self.write(choice, "", out);
                }
            }
            Shape::Integer(least, most) => {
                let _ = write!(out, "{}", values::integer(self.random, *least, *most));
            }
            Shape::Number(range) => write_number(number(self.random, *range), out),
            Shape::Text(kind) => values::text(self.random, *kind, self.context.now_us, out),
            Shape::List { item, most } => {
                let most = (*most).min(self.context.list_most);
                let count = self.random.random_range(0..=most);
                self.list(item, count, out);
            }
            Shape::Object(fields) => {
                out.push('{');
                let place = self.place();
                for field in fields.iter() {
                    let is_wanted = match place {
                        Some(place) if PLACE_FIELDS.contains(&field.name.as_str()) => {
                            place.contains(&field.name.as_str())
                        }
                        _ => field.is_required || self.random.random(),
                    };
                    if !is_wanted {
                        continue;
                    }
                    if !out.ends_with('{') {
                        out.push(',');
                    }
                    let _ = write!(out, "\"{}\":", field.name);
                    self.write(&field.shape, &field.name, out);
                }
                out.push('}');
            }
        }
    }

    /// Fields of a contact's place that the contract allows together; `None` for any fields.
    fn place(&mut self) -> Option<&'static [&'static str]> {
        if self.random.random_bool(0.05) { None } else { PLACES.choose(self.random).copied() }
    }

    fn list(&mut self, item: &Shape, count: usize, out: &mut String) {
        out.push('[');
        for index in 0..count {
            if index > 0 {
                out.push(',');
            }
            self.write(item, "", out);
        }
        out.push(']');
    }

    /// Writes fields whose values depend on other fields. Returns false for all other fields.
    fn write_known(&mut self, shape: &Shape, name: &str, out: &mut String) -> bool {
        let is_odd = self.random.random_bool(self.context.odd_texts);
        match (name, shape) {
            ("boot_id", _) if !is_odd => quoted(&self.context.boot_id, out),
            ("seq", _) => put(self.context.seq, out),
            ("t_us", Shape::Integer(_, most)) => {
                let is_right = self.random.random_bool(self.context.right_times);
                let now_us = self.context.now_us;
                put(if is_right { now_us } else { time_us(self.random, now_us, *most) }, out);
            }
            ("arrays", Shape::List { item, .. }) => self.arrays(item, out),
            ("array", _) if !is_odd => {
                let Some((array, count)) = self.context.arrays.choose(self.random) else { return false };
                self.whiskers = *count;
                quoted(array, out);
            }
            // A factsheet numbers its whiskers in order; other messages refer to a whisker that may or may not exist.
            ("whisker", _) if self.pressures != [None; 2] => put(self.whisker, out),
            ("whisker", _) if !is_odd && self.whiskers > 0 => {
                put(self.random.random_range(0..self.whiskers), out);
            }
            ("model", _) if !is_odd => match self.context.models.choose(self.random) {
                Some(model) => quoted(model, out),
                None => return false,
            },
            ("neighbours", _) => {
                let others = (0..self.whiskers).filter(|&other| other != self.whisker);
                let beside: Vec<String> = others.map(|other| other.to_string()).collect();
                put(format_args!("[{}]", beside.join(",")), out);
            }
            ("pressure_mpa", _) if self.pressures[0].is_some() => {
                write_number(self.pressures[0].take().unwrap_or_default(), out);
            }
            ("pressure_max_mpa", _) if self.pressures[1].is_some() => {
                write_number(self.pressures[1].unwrap_or_default(), out);
            }
            ("pressure_mpa" | "setpoint_mpa", Shape::Number(_)) if self.random.random_bool(0.66) => {
                let Some(&pressure_mpa) = self.context.pressures_mpa.choose(self.random) else { return false };
                write_number(pressure_mpa, out);
            }
            ("command_id", _) if !is_odd => match self.context.commands.choose(self.random) {
                Some(command) => quoted(command, out),
                None => return false,
            },
            _ => return false,
        }
        true
    }

    /// Writes the arrays of a factsheet with the names of the context.
    fn arrays(&mut self, array: &Shape, out: &mut String) {
        out.push('[');
        let arrays = &self.context.arrays;
        for (index, (name, count)) in arrays.iter().enumerate() {
            out.push_str(if index == 0 { "{" } else { ",{" });
            let _ = write!(out, "\"array\":\"{name}\",\"type\":");
            if let Some(kind) = array.at(&["type"]) {
                self.write(kind, "type", out);
            }
            out.push_str(",\"whiskers\":[");
            self.whiskers = *count;
            for whisker in 0..*count {
                if whisker > 0 {
                    out.push(',');
                }
                self.whisker = whisker;
                if let Some(facts) = array.at(&["whiskers"]) {
                    let ranges = facts.at(&["pressure_mpa"]).map(Shape::ranges).unwrap_or_default();
                    let mut pressure = || ranges.first().map(|&range| number(self.random, range));
                    let (one, other) = (pressure().unwrap_or_default(), pressure().unwrap_or_default());
                    self.pressures = [Some(one.min(other)), Some(one.max(other))];
                    self.write(facts, "", out);
                    self.pressures = [None; 2];
                }
            }
            out.push_str("]}");
        }
        out.push(']');
    }
}

fn put(value: impl Display, out: &mut String) {
    let _ = write!(out, "{value}");
}

fn quoted(text: &str, out: &mut String) {
    put(format_args!("\"{text}\""), out);
}

#[cfg(test)]
mod tests;
