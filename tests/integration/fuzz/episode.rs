//! An episode: some dozens of messages from one robot, drawn from a seed. A failed episode is reduced to the fewest
//! messages that still fail.

use std::cell::Cell;
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Once;

use rand::Rng;
use rand::SeedableRng;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};
use vibrissa_core::robot::Params;
use vibrissa_core::units::{ContactRatio, Megapascal, Micros, Millimetre};
use vibrissa_protocol::RobotTopic;
use vibrissa_tests::extremes::{Context, Messages, Without, number};

use crate::subject::{Fate, Input, Subject, name_of};

/// Number of messages in an episode.
pub(crate) const MESSAGES: usize = 64;
const START_US: u64 = 1_795_248_000_000_000;
const MODEL: &str = "nguyen-2021";
/// The whole state is checked after this many inputs and at the end; a number that is not finite remains in the state.
const LOOK_EVERY: usize = 16;
/// Ordinary contacts at the start of an episode that learns its whiskers first: more than the cold start of the test.
const LEARNED: usize = 28;

/// Inputs with their times by the supervisor's clock.
pub(crate) type Inputs = Vec<(Micros, Input)>;

/// Result of an episode.
pub(crate) struct Played {
    pub(crate) inputs: Inputs,
    pub(crate) fates: BTreeMap<&'static str, u64>,
    /// First violation of an invariant.
    pub(crate) fault: Option<String>,
}

thread_local! {
    static IS_QUIET: Cell<bool> = const { Cell::new(false) };
}

/// Runs a closure. A panic becomes an error and is not printed.
fn caught<T>(work: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let before = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            if !IS_QUIET.get() {
                before(panic);
            }
        }));
    });
    IS_QUIET.set(true);
    let result = catch_unwind(AssertUnwindSafe(work));
    IS_QUIET.set(false);
    result.unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<String>().cloned();
        let text = text.or_else(|| panic.downcast_ref::<&str>().map(|text| (*text).to_owned()));
        Err(format!("panic: {}", text.unwrap_or_default()))
    })
}

/// Plays the episode of a seed.
pub(crate) fn play(seed: u64, params: &Params, messages: &Messages, without: &Without) -> Played {
    let mut player = Player::new(seed, messages, without);
    let mut inputs = Inputs::new();
    let mut fates = BTreeMap::new();
    let fault = caught(|| {
        let mut subject = Subject::new(params);
        let mut said = 0;
        while said < MESSAGES {
            let (now, input) = player.next(&subject);
            inputs.push((now, input));
            let (now, input) = &inputs[inputs.len() - 1];
            let fate = subject.take(*now, input)?;
            if *input != Input::Tick {
                said += 1;
                let label = match fate {
                    Fate::Taken => "taken",
                    Fate::Refused(label) => label,
                };
                *fates.entry(label).or_default() += 1;
            }
            if inputs.len().is_multiple_of(LOOK_EVERY) {
                subject.check_state()?;
            }
        }
        subject.check_state()
    });
    Played { inputs, fates, fault: fault.err() }
}

/// Plays the inputs and checks the state after each one. Returns the number of inputs up to the first fault, and the
/// fault.
fn fault_of(inputs: &[(Micros, Input)], params: &Params) -> Option<(usize, String)> {
    let mut count = 0;
    let result = caught(|| {
        let mut subject = Subject::new(params);
        for (now, input) in inputs {
            count += 1;
            subject.take(*now, input)?;
            subject.check_state()?;
        }
        Ok(())
    });
    result.err().map(|fault| (count, fault))
}

/// The fewest inputs that still lead to a fault, and that fault.
pub(crate) fn shrunk(mut inputs: Inputs, params: &Params) -> Option<(Inputs, String)> {
    let (count, mut fault) = fault_of(&inputs, params)?;
    inputs.truncate(count);
    let mut piece = inputs.len() / 2;
    while piece > 0 {
        let mut at = 0;
        while at < inputs.len() {
            let mut fewer = inputs.clone();
            fewer.drain(at..(at + piece).min(inputs.len()));
            match fault_of(&fewer, params) {
                Some((count, found)) => {
                    fewer.truncate(count);
                    (inputs, fault) = (fewer, found);
                }
                None => at += piece,
            }
        }
        piece /= 2;
    }
    for at in 0..inputs.len() {
        while let Some((fewer, found)) = with_fewer_entries(&inputs, at, params) {
            (inputs, fault) = (fewer, found);
        }
    }
    Some((inputs, fault))
}

/// Removes one entry from a list of one message. None if there is no fault any more.
fn with_fewer_entries(inputs: &Inputs, at: usize, params: &Params) -> Option<(Inputs, String)> {
    let Input::Message(kind, payload) = &inputs.get(at)?.1 else { return None };
    let message: Value = serde_json::from_slice(payload).ok()?;
    let name = ["contacts", "whiskers", "arrays"].into_iter().find(|name| message[*name].is_array())?;
    (0..message[name].as_array()?.len()).find_map(|entry| {
        let mut message = message.clone();
        message[name].as_array_mut()?.remove(entry);
        let mut fewer = inputs.clone();
        fewer[at].1 = Input::Message(*kind, message.to_string().into_bytes());
        fault_of(&fewer, params).map(|(count, fault)| {
            fewer.truncate(count);
            (fewer, fault)
        })
    })
}

/// Draws the inputs of an episode one after the other.
struct Player<'a> {
    messages: &'a Messages,
    without: &'a Without,
    model: vibrissa_core::mechanics::Model,
    random: ChaCha8Rng,
    now_us: u64,
    boots: u32,
    seqs: BTreeMap<RobotTopic, u64>,
    arrays: Vec<(String, u16)>,
    /// True length in mm and pressure in MPa by array and whisker.
    truth: BTreeMap<(usize, u16), (f64, f64)>,
    /// Whether its whiskers pass the cold start before the first extreme message.
    learns_first: bool,
    ordinary: usize,
    said: usize,
}

impl<'a> Player<'a> {
    fn new(seed: u64, messages: &'a Messages, without: &'a Without) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut arrays = vec![("left".to_owned(), random.random_range(1..=3))];
        if random.random_bool(0.2) {
            arrays.push(("right".to_owned(), 1));
        }
        Self {
            messages,
            without,
            model: vibrissa_core::mechanics::Model::nguyen_2021(vibrissa_core::mechanics::Formulation::Published),
            now_us: START_US + random.random_range(0..1_000_000),
            boots: 1,
            seqs: BTreeMap::new(),
            truth: BTreeMap::new(),
            // If factsheets or contacts are ordinary in the whole run, every episode begins with ordinary ones.
            learns_first: random.random_bool(0.6)
                || without.is_ordinary(RobotTopic::Factsheet)
                || without.is_ordinary(RobotTopic::Contacts),
            ordinary: 0,
            said: 0,
            random,
            arrays,
        }
    }

    fn next(&mut self, subject: &Subject<'_>) -> (Micros, Input) {
        let pause_us = match self.random.random_range(0..40) {
            0 => self.random.random_range(0..30_000_000),
            _ => self.random.random_range(1_000..300_000),
        };
        self.now_us += pause_us;
        let now = Micros(self.now_us);
        if self.said >= 2 && self.random.random_bool(0.15) {
            return (now, Input::Tick);
        }
        self.said += 1;
        let kind = match self.said {
            1 => RobotTopic::Connection,
            2 => RobotTopic::Factsheet,
            _ if self.learns_first && self.ordinary < LEARNED => RobotTopic::Contacts,
            // This test cannot make an ordinary status, so contacts replace it.
            _ => Some(self.kind())
                .filter(|&kind| kind != RobotTopic::Status || !self.without.is_ordinary(kind))
                .unwrap_or(RobotTopic::Contacts),
        };
        let text = self.message(kind, subject);
        (now, Input::Message(kind, text.into_bytes()))
    }

    fn kind(&mut self) -> RobotTopic {
        match self.random.random_range(0..100) {
            0..66 => RobotTopic::Contacts,
            66..80 => RobotTopic::Status,
            80..92 => RobotTopic::SetpointState,
            92..97 => RobotTopic::Factsheet,
            _ => RobotTopic::Connection,
        }
    }

    fn seq(&mut self, kind: RobotTopic) -> u64 {
        if self.said > 2 && self.random.random_bool(0.03) {
            let anywhere = [0, 1, 5, (1 << 53) - 1, (1 << 53) - 2, 1 << 40];
            return anywhere.choose(&mut self.random).copied().unwrap_or_default();
        }
        let next = self.seqs.entry(kind).or_default();
        *next += 1;
        *next - 1
    }

    fn message(&mut self, kind: RobotTopic, subject: &Subject<'_>) -> String {
        if kind == RobotTopic::Connection && self.said > 2 && self.random.random_bool(0.3) {
            self.boots += 1;
            self.seqs.clear();
        }
        let seq = self.seq(kind);
        let is_learning = self.learns_first && self.ordinary < LEARNED;
        let by_chance = self.learns_first && self.random.random_bool(0.5);
        if is_learning || self.said <= 2 || by_chance || self.without.is_ordinary(kind) {
            let ordinary = match kind {
                RobotTopic::Connection => Some(json!({"timestamp": "2026-11-21T08:00:00.000Z", "state": "ONLINE"})),
                RobotTopic::Factsheet if self.learns_first => Some(self.factsheet()),
                RobotTopic::Contacts if !self.truth.is_empty() => Some(self.contacts()),
                RobotTopic::SetpointState => self.applied(subject),
                _ => None,
            };
            match ordinary {
                Some(fields) => return self.in_order(kind, seq, fields),
                None if self.without.is_ordinary(kind) => {
                    return self.in_order(RobotTopic::Connection, seq, json!({"state": "ONLINE"}));
                }
                None => {}
            }
        }
        let context = Context {
            boot_id: self.boot_id(),
            seq,
            now_us: self.now_us,
            arrays: self.arrays.clone(),
            models: vec![MODEL.to_owned()],
            commands: subject.robot.commands_under_way().map(|command| name_of(command.key)).collect(),
            pressures_mpa: (0..subject.robot.whisker_count())
                .filter_map(|index| subject.robot.whisker(index))
                .map(|view| view.setpoint.mpa())
                .collect(),
            right_times: if self.without.times { 1.0 } else { 0.7 },
            odd_texts: if self.said <= 2 || self.without.texts { 0.0 } else { 0.01 },
            list_most: 6,
        };
        self.messages.draw(&mut self.random, kind, &context)
    }

    fn boot_id(&self) -> String {
        format!("b{}", self.boots)
    }

    /// A message with its fields in the order of the contract, as nearly every robot writes them.
    fn in_order(&self, kind: RobotTopic, seq: u64, mut fields: Value) -> String {
        if kind == RobotTopic::Contacts {
            let contacts = fields["contacts"].as_str().unwrap_or_default();
            return format!("{{\"boot_id\":\"{}\",\"seq\":{seq},\"contacts\":[{contacts}]}}", self.boot_id());
        }
        fields["boot_id"] = json!(self.boot_id());
        fields["seq"] = json!(seq);
        fields.to_string()
    }

    fn factsheet(&mut self) -> Value {
        let mut arrays = Vec::new();
        self.truth.clear();
        for (index, (name, count)) in self.arrays.iter().enumerate() {
            let beside = |whisker: u16| (0..*count).filter(|&other| other.abs_diff(whisker) == 1).collect::<Vec<_>>();
            let whiskers: Vec<Value> = (0..*count)
                .map(|whisker| {
                    self.truth.insert((index, whisker), (70.0, 0.1));
                    json!({"whisker": whisker, "x_mm": 25 * whisker, "y_mm": 0, "model": MODEL, "length_mm": 70,
                        "pressure_mpa": 0.1, "pressure_max_mpa": 0.2, "neighbours": beside(whisker)})
                })
                .collect();
            let kind = if index == 0 { "TYPE_1" } else { "TYPE_2" };
            arrays.push(json!({"array": name, "type": kind, "whiskers": whiskers}));
        }
        json!({"timestamp": "2026-11-21T08:00:00.000Z", "model": "m", "on_supervisor_loss": "HOLD", "arrays": arrays})
    }

    /// Plausible contacts; after the first ones, some have extreme numbers in some fields.
    fn contacts(&mut self) -> Value {
        let is_learning = self.ordinary < LEARNED;
        let count = if is_learning { 8 } else { self.random.random_range(1..=3) };
        // Sometimes a whisker is cut.
        if !is_learning && self.random.random_bool(0.1) {
            let cut_mm = self.random.random_range(50.0..69.0);
            let whiskers: Vec<(usize, u16)> = self.truth.keys().copied().collect();
            let cut = whiskers.choose(&mut self.random).and_then(|whisker| self.truth.get_mut(whisker));
            if let Some((length_mm, _)) = cut {
                *length_mm = cut_mm;
            }
        }
        let contacts: Vec<String> = (0..count).filter_map(|_| self.contact(is_learning)).collect();
        self.ordinary += count;
        json!({ "contacts": contacts.join(",") })
    }

    fn contact(&mut self, is_learning: bool) -> Option<String> {
        let whiskers: Vec<(usize, u16)> = self.truth.keys().copied().collect();
        let &(array, whisker) = whiskers.choose(&mut self.random)?;
        let &(length_mm, pressure_mpa) = self.truth.get(&(array, whisker))?;
        let (ratio, deflection_mm) = (self.random.random_range(0.6..1.0), self.random.random_range(0.5..4.0));
        let morphology = self.model.morphology(Megapascal::known(pressure_mpa));
        let (at, length) = (ContactRatio::known(ratio), Millimetre::known(length_mm));
        let per_mm = self.model.sensitivity_per_mm(at, length, &morphology).ok()?;
        let strain = per_mm * deflection_mm * (1.0 + self.random.random_range(-0.04..0.04));
        let mut numbers = [
            ("ratio", ratio),
            ("deflection_mm", deflection_mm),
            ("strain", strain),
            ("pressure_mpa", pressure_mpa),
            ("temperature_c", 24.0),
        ];
        if !is_learning && !self.without.is_ordinary(RobotTopic::Contacts) && self.random.random_bool(0.2) {
            for (field, value) in &mut numbers {
                // The pressure is mostly correct: contacts far from the setpoint's pressure are not used.
                let is_odd = self.random.random_bool(if *field == "pressure_mpa" { 0.1 } else { 0.5 });
                if is_odd {
                    *value = number(&mut self.random, self.messages.contact_range(field));
                }
            }
        }
        let numbers: String = numbers.iter().map(|(field, value)| format!(",\"{field}\":{value:e}")).collect();
        let (name, t_us) = (&self.arrays[array].0, self.now_us);
        Some(format!("{{\"array\":\"{name}\",\"whisker\":{whisker},\"t_us\":{t_us}{numbers}}}"))
    }

    /// Answers a pending setpoint with APPLIED.
    fn applied(&mut self, subject: &Subject<'_>) -> Option<Value> {
        let command = subject.robot.commands_under_way().next()?;
        let view = subject.robot.whisker(command.whisker)?;
        let array = self.arrays.iter().position(|(name, _)| name == view.array)?;
        if let Some((_, pressure_mpa)) = self.truth.get_mut(&(array, view.sheet.number)) {
            *pressure_mpa = command.pressure.mpa();
        }
        Some(json!({"command_id": name_of(command.key), "state": "APPLIED", "t_us": self.now_us,
            "pressure_mpa": command.pressure.mpa()}))
    }
}
