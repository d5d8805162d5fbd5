//! A robot as the supervisor knows it, and the one function that moves it on:
//! `step(state, params, now, event) -> effects`.
//!
//! The state is [`Robot`]; [`Event`] is what can happen, [`Effect`] what must be done about it. Nothing here
//! waits, sends or stores: the caller commits the effects together with the state, and then carries them out.
//! The same events give the same effects, byte for byte.
//!
//! - [`event`], [`effect`], [`action`], [`params`], `view`, `what_if`, `locate`: the interface.
//! - [`state`]: clock, message numbers, layout, whiskers.
//! - [`health`]: contacts and the detector's verdicts, faults, gauges, changes common to an array, alarms.
//! - [`compensation`]: who serves whom, the error of Eq. 35, the closed loop.
//! - `setpoints`: commands to the robot, and operators' actions.
//! - `touch_tests`: the reach of whiskers, and requests to measure their length by touches.
//! - `codec`: the stored bytes.

pub mod action;
mod codec;
mod command_key;
pub mod compensation;
pub mod effect;
pub mod event;
pub mod health;
mod locate;
pub mod params;
mod setpoints;
pub mod state;
mod touch_tests;
mod view;
mod what_if;

pub use action::{ActionProblem, OperatorAction, Place, Scope};
pub use codec::robot::RestoreError;
pub use compensation::{Compensation, one_number};
pub use effect::Effect;
pub use event::Event;
pub use locate::{LocateError, Located, ResponsePoint, Touch};
pub use params::Params;
pub use state::factsheet::{LENGTH_TOLERANCE_MM, Sheet};
pub use state::head::Array;
pub use state::sequence::{Admission, Sequence, Sequences};
pub use state::whisker::Whisker;
pub use view::WhiskerView;
pub use what_if::{Planned, Served, WhatIf, WhatIfError};

use crate::units::Micros;
use event::{Contact, Factsheet, Link};
use state::clock::{Clock, TimeKind, TimeTrust};
use state::deadline::TickDeadline;
use state::head::Head;
use state::index::WhiskerIndexTable;
use state::tracked::{KnownCompensations, Tracked, Whiskers};

/// One robot: its numbers, its whiskers, its compensations.
#[derive(Debug, Clone, PartialEq)]
pub struct Robot {
    /// Stored as one piece, see [`Robot::to_bytes`].
    head: Tracked<Head>,
    /// Stored one by one.
    whiskers: Whiskers,
    // The fields below are not stored.
    /// The factsheet of the newest boot, as long as it is missing.
    awaited: Awaited,
    /// Index of whiskers by array and number; follows from the layout.
    index: WhiskerIndexTable,
    /// Compensations as of the last step, to find changes.
    known_compensations: KnownCompensations,
    /// Time until which a tick has nothing to do.
    tick_deadline: TickDeadline,
}

/// The first free numbers of a robot's trims and compensations.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Numbers {
    /// First free number of a trim.
    pub next_trim: u32,
    /// First free number of a compensation.
    pub next_compensation: u32,
}

/// A missing factsheet is requested after this time, and again after each further one.
const FACTSHEET_PATIENCE: Micros = Micros(2_000_000);

/// The factsheet of the newest boot, as long as it is missing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
enum Awaited {
    /// It is known, or was not missed yet.
    #[default]
    Not,
    /// It is expected since the birth at this time.
    Since(Micros),
    /// It was requested at this time: again only if contacts wait for it.
    Requested(Micros),
}

/// Outcome of an event as a whole.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Outcome {
    /// The event was taken.
    Taken,
    /// The event was seen before, and changed nothing.
    Duplicate,
    /// It cannot be taken now; the robot will send it again.
    NotYet(Admission),
    /// The event comes from an older boot.
    OldBoot,
    /// The event has an implausible time.
    BadTime,
    /// The operator's action is refused and has changed nothing.
    Refused(ActionProblem),
}

impl Robot {
    /// A robot of which nothing is known. `numbers` are the first free numbers of its trims and compensations, 0 for a
    /// robot that was never supervised.
    #[must_use]
    pub fn new(epoch: u64, numbers: Numbers) -> Self {
        Self::of(Tracked::new(Head::new(epoch, numbers)), Whiskers::default())
    }

    fn of(head: Tracked<Head>, whiskers: Whiskers) -> Self {
        let mut robot = Self {
            head,
            whiskers,
            awaited: Awaited::Not,
            index: WhiskerIndexTable::default(),
            known_compensations: KnownCompensations::new(),
            tick_deadline: TickDeadline::default(),
        };
        robot.renew_index();
        robot.know_compensations();
        robot
    }

    /// Takes one event in and appends its effects.
    ///
    /// `now` is the time by the supervisor's clock. Effects are appended, so that the caller can reuse its buffer.
    pub fn step(&mut self, params: &Params, now: Micros, event: &Event<'_>, effects: &mut Vec<Effect>) -> Outcome {
        let outcome = self.handle(params, now, event, effects);
        match outcome {
            Outcome::Taken | Outcome::BadTime => {
                if is_for_policy(event) {
                    self.head.undecided = true;
                }
                self.finish_step(params, now, effects);
            }
            // The event was not taken: nothing follows from it.
            Outcome::Duplicate | Outcome::NotYet(_) | Outcome::OldBoot | Outcome::Refused(_) => {}
        }
        outcome
    }

    fn handle(&mut self, params: &Params, now: Micros, event: &Event<'_>, effects: &mut Vec<Effect>) -> Outcome {
        match *event {
            Event::Connection { boot_id, link } => self.connection(params, now, boot_id, link, effects),
            Event::Factsheet { boot_id, factsheet } => self.factsheet(params, now, boot_id, factsheet, effects),
            Event::Contacts { boot_id, seq, contacts, missed } => {
                self.contacts(params, now, (boot_id, seq), contacts, missed, effects)
            }
            Event::Status { boot_id, robot_time, whiskers } => {
                if self.is_old(boot_id) {
                    return Outcome::OldBoot;
                }
                let trust = self.head.clock.trust(now, robot_time);
                self.head.clock.hear(now, robot_time, TimeKind::Live);
                if trust == TimeTrust::Far {
                    // After a step of the robot's clock four of them follow each other. They are signs of life all the same.
                    for entry in whiskers {
                        if let Some(index) = self.find(entry.array, entry.whisker) {
                            self.whiskers[index].heard = Some(now);
                        }
                    }
                    return Outcome::BadTime;
                }
                if self.is_duplicated() {
                    return Outcome::Taken;
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
                self.head.clock.hear(now, robot_time, TimeKind::Live);
                self.setpoint_reported(params, now, (command, robot_time), report, effects);
                Outcome::Taken
            }
            Event::TouchTest { boot_id, test, report, robot_time } => {
                if self.is_old(boot_id) {
                    return Outcome::OldBoot;
                }
                self.head.clock.hear(now, robot_time, TimeKind::Live);
                self.test_reported(params, now, test, report, effects);
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
        }
    }

    fn is_old(&self, boot_id: &str) -> bool {
        self.head.boot_id.as_ref().is_none_or(|newest| *newest != *boot_id)
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
            if link != Link::Online || self.head.sequences.is_old(boot_id) {
                if link == Link::Online && self.is_replaced(boot_id) {
                    self.boot_returned(now, effects);
                }
                return Outcome::OldBoot;
            }
            self.abandon_commands(effects);
            self.abandon_tests(effects);
            self.test_after_restart(params);
            // Those who were given up may serve again.
            self.head.undecided = true;
            self.head.boot_id = Some(boot_id.into());
            // A clock may go back with a new boot.
            self.head.clock = Clock::default();
        }
        if self.is_duplicated() && link != Link::Online {
            // The other robot has taken its place at the broker.
            return Outcome::Taken;
        }
        self.head.link = link;
        self.head.sequences.wait_anew();
        if link != Link::Online {
            self.forget_manual();
        }
        for index in 0..self.whiskers.len() {
            self.refresh_fault(params, now, index, effects);
        }
        if link == Link::Online && self.head.sequences.of(boot_id).is_none() {
            self.awaited = Awaited::Since(now);
        }
        Outcome::Taken
    }

    /// Asks for a factsheet that has not followed its birth.
    fn await_factsheet(&mut self, now: Micros, effects: &mut Vec<Effect>) {
        let Awaited::Since(since) = self.awaited else { return };
        let is_missing =
            self.head.boot_id.as_ref().is_some_and(|boot_id| self.head.sequences.of(boot_id.as_str()).is_none());
        if !is_missing {
            self.awaited = Awaited::Not;
        } else if self.head.link == Link::Online && now.since(since) >= FACTSHEET_PATIENCE {
            self.ask_for_factsheet(now, effects);
        }
    }

    /// Asks for a factsheet that is missed, unless it is expected any moment.
    fn ask_for_factsheet(&mut self, now: Micros, effects: &mut Vec<Effect>) {
        let is_expected = match self.awaited {
            Awaited::Not => false,
            Awaited::Since(since) | Awaited::Requested(since) => now.since(since) < FACTSHEET_PATIENCE,
        };
        if !is_expected {
            self.awaited = Awaited::Requested(now);
            effects.push(Effect::AskForFactsheet);
        }
    }

    /// Whether a factsheet is known of this boot already: it was retained, or requested.
    fn is_told(&self, boot_id: &str, factsheet: &Factsheet) -> bool {
        !self.is_old(boot_id) && self.head.sequences.of(boot_id).is_some() && self.is_as_known(factsheet)
    }

    fn factsheet(
        &mut self,
        params: &Params,
        now: Micros,
        boot_id: &str,
        factsheet: &Factsheet,
        effects: &mut Vec<Effect>,
    ) -> Outcome {
        if self.is_told(boot_id, factsheet) {
            return Outcome::Duplicate;
        }
        if self.is_old(boot_id) {
            return Outcome::OldBoot;
        }
        self.head.sequences.begin(boot_id);
        if !self.is_as_known(factsheet) {
            self.lay_out(params, now, factsheet, effects);
        }
        // A whisker that is never heard becomes stale, too.
        for index in 0..self.whiskers.len() {
            if self.whiskers[index].heard.is_none() {
                self.whiskers[index].heard = Some(now);
            }
        }
        Outcome::Taken
    }

    fn contacts(
        &mut self,
        params: &Params,
        now: Micros,
        (boot_id, seq): (&str, u64),
        contacts: &[Contact<'_>],
        missed: &[event::MissedTouch<'_>],
        effects: &mut Vec<Effect>,
    ) -> Outcome {
        let Some(sequence) = self.head.sequences.of(boot_id) else {
            if self.head.sequences.is_old(boot_id) {
                return Outcome::OldBoot;
            }
            self.ask_for_factsheet(now, effects);
            return Outcome::NotYet(Admission::UnknownBoot);
        };
        if self.is_duplicated() {
            return Outcome::NotYet(Admission::TwoRobots);
        }
        // Read first: a robot that sends everything again must not make its state be written again each time.
        if sequence.is_plain_duplicate(seq) {
            return Outcome::Duplicate;
        }
        match self.head.sequences.admit(boot_id, seq, now) {
            Admission::New => {}
            Admission::Duplicate => return Outcome::Duplicate,
            not_yet @ (Admission::UnknownBoot | Admission::TooManyGaps | Admission::TwoRobots) => {
                return Outcome::NotYet(not_yet);
            }
        }
        let is_newest = !self.is_old(boot_id);
        let before = self.head.clock.clone();
        let trust = |robot_time| match is_newest {
            true => before.trust(now, robot_time),
            false => before.trust_of_older_boot(now, robot_time),
        };
        if is_newest {
            // One sample for each message, however many contacts it has; an implausible time if it has no other.
            let touched = contacts.iter().map(|contact| contact.robot_time);
            let mut times = touched.chain(missed.iter().map(|one| one.robot_time));
            let sound = times.clone().filter(|&time| trust(time) == TimeTrust::Sound).max();
            let newest = sound.or_else(|| times.next_back());
            self.head.clock.hear(now, newest.unwrap_or_default(), TimeKind::Recorded);
        }
        for (position, contact) in contacts.iter().enumerate() {
            let trust = trust(contact.robot_time);
            if trust == TimeTrust::Far {
                effects.push(Effect::BadTime { position });
            }
            // A wrong time makes no reading wrong. The contact counts, and what rests on times leaves it out.
            let untimed = Contact { robot_time: Micros::default(), ..*contact };
            let contact = if trust == TimeTrust::Sound { contact } else { &untimed };
            self.contact(params, now, position, contact, effects);
            if is_newest {
                self.note_touch(params, contact);
            }
        }
        for one in missed.iter().filter(|one| trust(one.robot_time) != TimeTrust::Far) {
            self.missed_touch(params, now, one, effects);
        }
        Outcome::Taken
    }
}

/// Whether the policy looks at all arrays after an event, whatever it changed.
fn is_for_policy(event: &Event<'_>) -> bool {
    match event {
        Event::Operator(_) | Event::PolicyChanged => true,
        Event::Connection { .. }
        | Event::Factsheet { .. }
        | Event::Contacts { .. }
        | Event::Status { .. }
        | Event::Setpoint { .. }
        | Event::TouchTest { .. }
        | Event::Tick => false,
    }
}
