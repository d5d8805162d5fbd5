//! Timers: the deadlines of a robot, as data.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use rand::Rng;
use rand_chacha::ChaCha8Rng;
use vibrissa_protocol::Contact;
use vibrissa_robot::contract::Moment;

use super::{Outgoing, Robot, Whisker};
use crate::plant::Reading;
use crate::random::{Purpose, stream};
use crate::regulator::TICK_US;
use crate::scenario::Misbehaviour;

/// Shortest time between status messages that report a change, in microseconds.
const STATUS_PAUSE_US: u64 = 100_000;

/// Kinds of timers; of simultaneous ones, the first in this list comes first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Timer {
    /// An event of the scenario.
    Event,
    /// The next step of the regulators.
    Tick,
    /// A contact of a whisker.
    Contact,
    /// An incomplete contacts message has waited long enough.
    Flush,
    /// Unreceipted messages are sent again.
    Resend,
    /// A status is due.
    Status,
    /// A request for births is answered.
    Birth,
}

/// Times of the whiskers' next contacts: irregular, at an exact mean rate.
#[derive(Debug)]
pub(super) struct Contacts {
    start_us: u64,
    interval_us: f64,
    streams: Vec<(ChaCha8Rng, u64)>,
    next: BinaryHeap<Reverse<(u64, usize)>>,
}

impl Contacts {
    pub(super) fn new(start_us: u64, per_second: f64) -> Self {
        Self { start_us, interval_us: 1e6 / per_second, streams: Vec::new(), next: BinaryHeap::new() }
    }

    /// Plans a whisker's next contact: contact k lies at a random time in the k-th interval.
    fn plan(&mut self, whisker: usize) {
        let Some((stream, made)) = self.streams.get_mut(whisker) else {
            return;
        };
        let intervals = *made as f64 + stream.random::<f64>();
        *made += 1;
        self.next.push(Reverse((self.start_us + (intervals * self.interval_us) as u64, whisker)));
    }

    pub(super) fn stop(&mut self) {
        self.next.clear();
    }

    /// Goes on from a time at another rate.
    pub(super) fn restart(&mut self, start_us: u64, per_second: f64) {
        self.stop();
        self.start_us = start_us;
        self.interval_us = 1e6 / per_second;
        self.streams.iter_mut().for_each(|(_, made)| *made = 0);
        (0..self.streams.len()).for_each(|whisker| self.plan(whisker));
    }
}

impl Robot {
    pub(super) fn plan_contacts(&mut self) {
        for whisker in &self.whiskers {
            let (robot, array) = (self.config.robot.robot.as_str(), whisker.array().as_str());
            self.contacts.streams.push((stream(self.seed, robot, array, whisker.number(), Purpose::Timing), 0));
        }
        (0..self.whiskers.len()).for_each(|whisker| self.contacts.plan(whisker));
    }

    /// The timer that is due first.
    pub(super) fn next_timer(&self) -> Option<(u64, Timer)> {
        let connected = |at_us: Option<u64>| at_us.filter(|_| self.connected);
        [
            (self.events.front().map(|&(at_us, _)| at_us), Timer::Event),
            (Some(self.tick_at_us), Timer::Tick),
            (self.contacts.next.peek().map(|&Reverse((at_us, _))| at_us), Timer::Contact),
            (self.batch_until_us, Timer::Flush),
            (connected(self.outbox.resend_at().map(Moment::as_us)), Timer::Resend),
            (connected(Some(self.status_at_us)), Timer::Status),
            (connected(self.births.due().map(Moment::as_us)), Timer::Birth),
        ]
        .into_iter()
        .filter_map(|(at_us, timer)| Some((at_us?, timer)))
        .min()
    }

    /// Handles a timer that was due at `at_us`.
    pub(super) fn expire(&mut self, timer: Timer, at_us: u64, now_us: u64, out: &mut Vec<Outgoing>) {
        match timer {
            Timer::Event => {
                if let Some((_, event)) = self.events.pop_front() {
                    self.happen(&event, at_us, out);
                }
            }
            Timer::Tick => {
                // A late tick answers no earlier than the message before: times must not decrease.
                self.tick(at_us.max(self.received_us), out);
                self.tick_at_us += TICK_US;
            }
            Timer::Contact => {
                if let Some(Reverse((_, whisker))) = self.contacts.next.pop() {
                    self.touch(whisker, at_us, out);
                    self.contacts.plan(whisker);
                }
            }
            // A robot at rest flushes with a due time of 0; the message gets at least the time of the last tick.
            Timer::Flush => self.flush(at_us.max(self.tick_at_us.saturating_sub(TICK_US)), out),
            // These refer to the present: a late robot does not repeat them for each missed time.
            Timer::Resend => self.resend(now_us, out),
            Timer::Status => self.status(now_us, out),
            Timer::Birth => self.answer_birth_request(now_us, out),
        }
    }

    /// Steps the regulators, then handles setpoints and changes of condition.
    fn tick(&mut self, at_us: u64, out: &mut Vec<Outgoing>) {
        for whisker in &mut self.whiskers {
            whisker.regulator.tick(whisker.leak_mpa_per_s, self.supply_mpa);
        }
        self.follow_setpoints(at_us, out);
        self.follow_tests(at_us, out);
        self.miss_supervisor(at_us, out);
        self.report_change(at_us);
    }

    /// Brings the next status forward if a whisker's condition differs from the last report.
    pub(super) fn report_change(&mut self, at_us: u64) {
        if self.breaks(Misbehaviour::ReportsOnSchedule) {
            return;
        }
        if self.whiskers.iter().any(|whisker| whisker.condition() != whisker.reported) {
            self.status_at_us = self.status_at_us.min(at_us.max(self.status_sent_us + STATUS_PAUSE_US));
        }
    }

    /// Makes one contact of a whisker.
    fn touch(&mut self, at: usize, at_us: u64, out: &mut Vec<Outgoing>) {
        self.happen_by_contact(at, at_us);
        let Some(whisker) = self.whiskers.get_mut(at) else {
            return;
        };
        // A robot does not report a contact on the chamber, where the gauge cannot measure it, nor an object out of reach.
        let places = self.config.behaviour.places;
        let Ok(Some((reading, touch))) = whisker.plant.touch_at(places, whisker.regulator.pressure_mpa()) else {
            return;
        };
        if whisker.is_silent(at_us) {
            return;
        }
        let number = whisker.plant.contacts();
        let mut contact = contact_of(whisker, &reading, at_us);
        places.state(&mut contact, &touch, whisker.estimated_mm);
        self.batch.push(self.contact_as_sent(contact, number));
        if self.batch.len() >= self.config.behaviour.contacts_per_message {
            self.flush(at_us, out);
        } else if self.batch_until_us.is_none() {
            self.batch_until_us = Some(at_us + (self.config.behaviour.message_after_s * 1e6) as u64);
        }
    }
}

/// A contact without its place.
pub(crate) fn contact_of(whisker: &Whisker, reading: &Reading, at_us: u64) -> Contact {
    Contact {
        array: whisker.array().clone(),
        whisker: whisker.number(),
        t_us: at_us,
        ratio: None,
        ratio_sd: None,
        distance_mm: None,
        distance_sd_mm: None,
        tip: false,
        deflection_mm: reading.deflection_mm,
        strain: reading.strain,
        saturated: false,
        pressure_mpa: whisker.regulator.reading_mpa(),
        temperature_c: reading.temperature_c,
        angle_deg: None,
        angle_sd_deg: None,
        test_id: None,
    }
}
