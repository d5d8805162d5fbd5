//! Robots that have announced themselves, but have not sent a factsheet yet.
//!
//! They are not in the database, because every client that may publish can invent names. The supervisor requests the
//! factsheet, which makes the robot known.

use std::time::Duration;

use bytes::Bytes;
use indexmap::IndexMap;
use tokio::time::Instant;
use vibrissa_core::robot::effect::Effect;
use vibrissa_core::robot::event::Link;
use vibrissa_core::robot::{Event, Numbers, Robot};
use vibrissa_core::units::Micros;
use vibrissa_protocol::{Name, RequestKind};

use super::stepper::Stepper;
use crate::engine::message::RawMessage;
use crate::engine::robot::seqs::Seqs;

/// Limit of announced robots per fleet; beyond it, the one announced first is forgotten.
const ANNOUNCED_MAX: usize = 1024;
/// How long after its last message a robot is remembered without a factsheet.
const PATIENCE: Duration = Duration::from_secs(600);

/// A robot whose factsheet is missing.
#[derive(Debug)]
pub(super) struct Announcement {
    pub(super) robot: Robot,
    pub(super) seqs: Seqs,
    /// Time of its last message.
    heard: Instant,
    /// Time of its first birth, or of the end of this supervisor's last standstill, since when the factsheet has been missing.
    first: Instant,
    /// Receipt time and payload of the last connection message, for the first black box.
    pub(super) birth: (Micros, Bytes),
}

/// The robots of a worker whose factsheets are missing, in the order of their last births.
#[derive(Debug)]
pub(super) struct Announced {
    robots: IndexMap<Name, Announcement>,
    most: usize,
}

impl Announced {
    /// The announced robots of one of `workers` workers.
    pub(super) fn of_workers(workers: usize) -> Self {
        Self { robots: IndexMap::new(), most: (ANNOUNCED_MAX / workers.max(1)).max(1) }
    }

    /// Handles a birth or a farewell.
    pub(super) fn connection(
        &mut self,
        stepper: &mut Stepper,
        (name, epoch): (&Name, u64),
        raw: &RawMessage,
        event: &Event<'_>,
    ) {
        let now = raw.received;
        let known = self.robots.shift_remove(name);
        let is_birth = matches!(event, Event::Connection { link: Link::Online, .. });
        if known.is_none() && !is_birth {
            return;
        }
        if known.is_none() && self.robots.len() >= self.most {
            self.robots.shift_remove_index(0);
        }
        let heard = Instant::now();
        let (robot, seqs, first) = known.map_or_else(
            || (Robot::new(epoch, Numbers::default()), Seqs::default(), heard),
            |known| (known.robot, known.seqs, known.first),
        );
        let birth = (now, raw.payload.clone());
        let mut announcement = Announcement { robot, seqs, heard, first, birth };
        announcement.step(stepper, name, now, event);
        self.robots.insert(name.clone(), announcement);
    }

    /// Whether a robot has announced itself.
    pub(super) fn has(&self, name: &Name) -> bool {
        self.robots.contains_key(name)
    }

    /// Handles a message that is useless without a factsheet.
    pub(super) fn early(&mut self, stepper: &mut Stepper, name: &Name, now: Micros, event: &Event<'_>) {
        if let Some(announcement) = self.robots.get_mut(name) {
            announcement.heard = Instant::now();
            announcement.step(stepper, name, now, event);
        }
    }

    /// Handles a tick: requests missing factsheets again, and forgets robots whose factsheet has not arrived in time.
    pub(super) fn tick(&mut self, stepper: &mut Stepper, now: Micros) {
        self.robots.retain(|_, announcement| announcement.heard.elapsed() < PATIENCE);
        for (name, announcement) in &mut self.robots {
            announcement.step(stepper, name, now, &Event::Tick);
        }
    }

    /// Whether this boot of a robot was announced.
    pub(super) fn has_boot(&self, name: &Name, boot_id: &str) -> bool {
        self.robots.get(name).is_some_and(|announcement| announcement.robot.connection_state().0 == Some(boot_id))
    }

    /// Requests a factsheet that cannot be accepted now again some seconds later.
    pub(super) fn ask_later(&mut self, stepper: &mut Stepper, name: &Name, now: Micros) {
        let Some(announcement) = self.robots.get_mut(name) else { return };
        let (boot_id, link) = announcement.robot.connection_state();
        let Some(boot_id) = boot_id.map(str::to_owned) else { return };
        announcement.step(stepper, name, now, &Event::Connection { boot_id: &boot_id, link });
    }

    /// Robots that are online, and have been without a factsheet for longer than `patience`.
    pub(super) fn overdue(&self, now: Instant, patience: Duration) -> impl Iterator<Item = &Name> {
        let is_overdue = move |announcement: &Announcement| {
            announcement.robot.connection_state().1 == Link::Online
                && now.saturating_duration_since(announcement.first) >= patience
        };
        self.robots.iter().filter(move |(_, announcement)| is_overdue(announcement)).map(|(name, _)| name)
    }

    /// Waits for all factsheets anew from `now` on.
    pub(super) fn excuse_standstill(&mut self, now: Instant) {
        self.robots.values_mut().for_each(|announcement| announcement.first = now);
    }

    /// Removes a robot because it becomes known.
    pub(super) fn take(&mut self, name: &Name) -> Option<Announcement> {
        self.robots.shift_remove(name)
    }
}

impl Announcement {
    fn step(&mut self, stepper: &mut Stepper, name: &Name, now: Micros, event: &Event<'_>) {
        let mut effects = Vec::new();
        self.robot.step(&stepper.params, now, event, &mut effects);
        if effects.iter().any(|effect| matches!(effect, Effect::AskForFactsheet)) {
            stepper.publish_request(name, &mut self.seqs, RequestKind::Factsheet);
        }
    }
}
