//! A robot as the supervisor knows it, and the one function that moves it on:
//! `step(state, params, now, event) -> effects`.
//!
//! The state is [`Robot`]; [`Event`] is what can happen, [`Effect`] what must be done about it. Nothing here
//! waits, sends or stores: the caller commits the effects together with the state, and then carries them out.
//! The same events give the same effects, byte for byte.
//!
//! - [`event`], [`effect`], [`action`], [`params`], `view`, `what_if`: the interface.
//! - [`state`]: clock, message numbers, layout, whiskers.
//! - [`health`]: contacts and the detector's verdicts, faults, gauges, changes common to an array, alarms.
//! - [`compensation`]: who serves whom, the error of Eq. 35, the closed loop.
//! - `setpoints`: commands to the robot, and operators' actions.
//! - `codec`: the stored bytes.

pub mod action;
mod codec;
pub mod compensation;
pub mod effect;
pub mod event;
pub mod health;
pub mod params;
mod setpoints;
pub mod state;
mod view;
mod what_if;

use borsh::{BorshDeserialize, BorshSerialize};
use smallvec::SmallVec;

pub use action::{ActionProblem, OperatorAction, Place, Scope};
pub use codec::robot::RestoreError;
pub use compensation::Compensation;
pub use effect::Effect;
pub use event::Event;
pub use params::Params;
pub use state::sequence::{Admission, Sequence, Sequences};
pub use state::sheet::Sheet;
pub use state::whisker::Whisker;
pub use view::WhiskerView;
pub use what_if::{Planned, WhatIf, WhatIfError};

use crate::text::ShortText;
use crate::units::Micros;
use event::{ArrayKind, Factsheet, Link};
use state::clock::{Clock, Told};
use state::deadline::Quiet;
use state::moment::Moment;
use state::places::Places;

/// One robot: its numbers, its whiskers, its compensations.
#[derive(Debug, Clone, PartialEq, BorshSerialize, BorshDeserialize)]
pub struct Robot {
    epoch: u64,
    link: Link,
    /// The newest boot, as its birth said.
    boot_id: Option<ShortText>,
    /// The clock of that boot.
    clock: Clock,
    sequences: Sequences,
    arrays: Vec<Array>,
    compensations: Vec<Compensation>,
    next_version: u64,
    next_trim: u32,
    next_compensation: u32,
    /// Something has changed that a decision rests on.
    undecided: bool,
    /// An operator holds all whiskers, also those that come later.
    held: bool,
    /// Since when this program listens: silence before that is not the robot's.
    listening_since: Micros,
    /// What is done about a factsheet that is missing.
    #[borsh(skip)]
    awaited: Awaited,
    /// It was taken up, not met for the first time: what its whiskers hold may have been set by commands that are not
    /// remembered here, because the database was restored or the state could not be read.
    is_taken_up: bool,
    #[borsh(skip)]
    changed: bool,
    /// Stored one by one: see [`Robot::to_bytes`].
    #[borsh(skip)]
    whiskers: Vec<Whisker>,
    /// Follows from the layout.
    #[borsh(skip)]
    places: Places,
    /// Those whose alarms are to be looked at, at the end of this step.
    #[borsh(skip)]
    touched: SmallVec<[u32; TOUCHED]>,
    /// What a tick would find out anyway.
    #[borsh(skip)]
    quiet: Quiet,
}

/// An array of the factsheet.
#[derive(Debug, Clone, PartialEq, Eq, BorshSerialize, BorshDeserialize)]
pub struct Array {
    /// Name.
    pub name: ShortText,
    /// Kind.
    pub kind: ArrayKind,
    /// Index and number of its first whisker; they follow from the layout.
    #[borsh(skip)]
    first: (u32, u16),
}

/// The first free numbers of a robot's trims and compensations.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Numbers {
    /// Of trims.
    pub next_trim: u32,
    /// Of compensations.
    pub next_compensation: u32,
}

/// Whiskers that an ordinary message is about, at the most: of more the list lies elsewhere.
const TOUCHED: usize = 24;
/// A factsheet that does not come by itself is asked for after this, and again.
const FACTSHEET_PATIENCE: Micros = Micros(2_000_000);

/// The factsheet of the newest boot, as long as it is missing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
enum Awaited {
    /// It is there, or nobody has looked for it.
    #[default]
    Not,
    /// It follows a birth, since then.
    Since(Micros),
    /// It was asked for then: again only where contacts wait for it.
    Asked(Micros),
}

/// What was made of an event as a whole.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Outcome {
    /// It was taken.
    Taken,
    /// It was seen before, and changed nothing.
    Duplicate,
    /// It cannot be taken now; the robot will send it again.
    NotYet(Admission),
    /// It comes from a boot that is no more.
    OldBoot,
    /// It says a time that cannot be right.
    BadTime,
    /// What an operator asked is not done, and has changed nothing.
    Refused(ActionProblem),
}

impl Robot {
    /// A robot of which nothing is known. `numbers` are the first free ones of its trims and compensations,
    /// 0 for one that was never supervised.
    #[must_use]
    pub fn new(epoch: u64, numbers: Numbers) -> Self {
        Self {
            epoch,
            link: Link::Offline,
            boot_id: None,
            clock: Clock::default(),
            sequences: Sequences::default(),
            arrays: Vec::new(),
            compensations: Vec::new(),
            next_version: 0,
            next_trim: numbers.next_trim,
            next_compensation: numbers.next_compensation,
            undecided: false,
            held: false,
            listening_since: Micros::default(),
            awaited: Awaited::Not,
            is_taken_up: false,
            changed: true,
            whiskers: Vec::new(),
            places: Places::default(),
            touched: SmallVec::new(),
            quiet: Quiet::default(),
        }
    }

    /// Takes one event in and says what must be done.
    ///
    /// `now` is the supervisor's clock. Effects are appended, so that the caller can use one buffer again.
    pub fn step(&mut self, params: &Params, now: Micros, event: &Event<'_>, effects: &mut Vec<Effect>) -> Outcome {
        if let Event::Factsheet { boot_id, factsheet } = *event
            && self.is_told(boot_id, factsheet)
        {
            return Outcome::Duplicate;
        }
        let was_undecided = self.undecided;
        match event {
            Event::Contacts { .. } | Event::Status { .. } => {
                self.quiet.not_beyond(now.after(params.health.stale_after))
            }
            Event::Tick => {}
            Event::Connection { .. }
            | Event::Factsheet { .. }
            | Event::Setpoint { .. }
            | Event::Operator(_)
            | Event::PolicyChanged => {
                self.quiet.end();
                self.touch_all();
            }
        }
        let outcome = match *event {
            Event::Connection { boot_id, link } => self.connection(params, now, boot_id, link, effects),
            Event::Factsheet { boot_id, factsheet } => self.factsheet(params, now, boot_id, factsheet, effects),
            Event::Contacts { boot_id, seq, contacts } => self.contacts(params, now, boot_id, seq, contacts, effects),
            Event::Status { boot_id, robot_time, whiskers } => {
                if self.is_old(boot_id) {
                    return Outcome::OldBoot;
                }
                let is_plausible = self.clock.plausible(now).contains(&robot_time);
                self.hear_time(now, robot_time, Told::Live);
                if !is_plausible {
                    // The next one comes within seconds.
                    return Outcome::BadTime;
                }
                for entry in whiskers {
                    self.status(params, now, robot_time, entry, effects);
                }
                Outcome::Taken
            }
            Event::Setpoint { boot_id, command, report, robot_time } => {
                if self.is_old(boot_id) {
                    return Outcome::OldBoot;
                }
                // Nothing but the clock's estimate rests on the time of an answer.
                self.hear_time(now, robot_time, Told::Live);
                self.setpoint_reported(params, now, command, report, effects);
                Outcome::Taken
            }
            Event::Operator(action) => self.operate(params, now, action, effects),
            Event::PolicyChanged => {
                self.policy_changed();
                Outcome::Taken
            }
            Event::Tick => {
                self.tick(params, now, effects);
                Outcome::Taken
            }
        };
        self.decide(params, now, effects);
        self.tell_alarms(effects);
        self.changed |= self.undecided != was_undecided;
        outcome
    }

    fn is_old(&self, boot_id: &str) -> bool {
        self.boot_id.as_ref().is_none_or(|newest| *newest != *boot_id)
    }

    fn hear_time(&mut self, now: Micros, robot_time: Micros, told: Told) {
        self.clock.hear(now, robot_time, told);
        self.changed = true;
    }

    fn connection(
        &mut self,
        params: &Params,
        now: Micros,
        boot_id: &str,
        link: Link,
        effects: &mut Vec<Effect>,
    ) -> Outcome {
        if self.is_old(boot_id) {
            // The order of receipt counts: a birth makes its boot the newest, an end speaks of its own only.
            if link != Link::Online || self.sequences.is_old(boot_id) {
                return Outcome::OldBoot;
            }
            self.abandon_commands(effects);
            // Those who were given up may serve again.
            self.undecided = true;
            self.boot_id = Some(boot_id.into());
            // A clock may go back with a new boot.
            self.clock = Clock::default();
        }
        self.link = link;
        self.changed = true;
        self.sequences.wait_anew();
        if link != Link::Online {
            self.forget_manual();
        }
        for index in 0..self.whiskers.len() {
            self.refresh_fault(params, now, index, effects);
        }
        if link == Link::Online && self.sequences.of(boot_id).is_none() {
            self.awaited = Awaited::Since(now);
        }
        Outcome::Taken
    }

    /// Asks for a factsheet that has not followed its birth.
    fn await_factsheet(&mut self, now: Micros, effects: &mut Vec<Effect>) {
        let Awaited::Since(since) = self.awaited else { return };
        let is_missing = self.boot_id.as_ref().is_some_and(|boot_id| self.sequences.of(boot_id.as_str()).is_none());
        if !is_missing {
            self.awaited = Awaited::Not;
        } else if self.link == Link::Online && now.since(since) >= FACTSHEET_PATIENCE {
            self.ask_for_factsheet(now, effects);
        }
    }

    /// Asks for a factsheet that is missed, unless it is expected any moment.
    fn ask_for_factsheet(&mut self, now: Micros, effects: &mut Vec<Effect>) {
        let is_expected = match self.awaited {
            Awaited::Not => false,
            Awaited::Since(since) | Awaited::Asked(since) => now.since(since) < FACTSHEET_PATIENCE,
        };
        if !is_expected {
            self.awaited = Awaited::Asked(now);
            effects.push(Effect::AskForFactsheet);
        }
    }

    /// Whether a factsheet says nothing that is not known of this boot: it was retained, or asked for.
    fn is_told(&self, boot_id: &str, factsheet: &Factsheet) -> bool {
        !self.is_old(boot_id) && self.sequences.of(boot_id).is_some() && self.is_as_known(factsheet)
    }

    fn factsheet(
        &mut self,
        params: &Params,
        now: Micros,
        boot_id: &str,
        factsheet: &Factsheet,
        effects: &mut Vec<Effect>,
    ) -> Outcome {
        if self.is_old(boot_id) {
            return Outcome::OldBoot;
        }
        self.sequences.begin(boot_id);
        self.changed = true;
        if !self.is_as_known(factsheet) {
            self.lay_out(params, factsheet, effects);
        }
        // A whisker that the robot has and that never says anything becomes stale, too.
        for whisker in &mut self.whiskers {
            whisker.changed |= whisker.heard == Moment::NONE;
            whisker.heard.get_or_insert(now);
        }
        self.touch_all();
        Outcome::Taken
    }

    fn contacts(
        &mut self,
        params: &Params,
        now: Micros,
        boot_id: &str,
        seq: u64,
        contacts: &[event::Contact<'_>],
        effects: &mut Vec<Effect>,
    ) -> Outcome {
        let (admission, changed) = self.sequences.admit(boot_id, seq, now);
        self.changed |= changed;
        match admission {
            Admission::New => {}
            Admission::Duplicate => {
                self.changed |= self.has_gap(boot_id);
                return Outcome::Duplicate;
            }
            Admission::UnknownBoot if self.sequences.is_old(boot_id) => return Outcome::OldBoot,
            Admission::UnknownBoot => {
                self.ask_for_factsheet(now, effects);
                return Outcome::NotYet(Admission::UnknownBoot);
            }
            Admission::TooManyGaps => {
                self.changed = true;
                return Outcome::NotYet(Admission::TooManyGaps);
            }
        }
        let is_newest = !self.is_old(boot_id);
        let plausible = if is_newest { self.clock.plausible(now) } else { self.clock.plausible_of_older_boot(now) };
        if is_newest {
            // One sample of a message, however many contacts it has; if none of its times can be right, any of them says so.
            let mut times = contacts.iter().map(|contact| contact.robot_time);
            let newest = times.clone().filter(|time| plausible.contains(time)).max().or_else(|| times.next_back());
            self.hear_time(now, newest.unwrap_or_default(), Told::Later);
        }
        for (position, contact) in contacts.iter().enumerate() {
            if plausible.contains(&contact.robot_time) {
                self.contact(params, now, position, contact, effects);
            } else {
                // Only this contact is rejected: other whiskers' times can still be right, and the message is accounted for.
                effects.push(Effect::BadTime { position });
            }
        }
        Outcome::Taken
    }
}
