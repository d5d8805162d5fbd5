//! The log of events as far as webhooks read it, the targets, and their dead letters. All events are kept: nothing is lost.

use vibrissa_store::Lease;
use vibrissa_store::batch::EventRow;
use vibrissa_store::events::StoredEvent;
use vibrissa_store::fault::{self, Fault};
use vibrissa_store::model::Webhooks;
use vibrissa_store::webhooks::WebhookRow;
use vibrissa_store::webhooks::dead::Fate;
use vibrissa_store::webhooks::manage::WebhookSettings;
use vibrissa_store::webhooks::queue::{Due, Holding, Job, Outcome, Queue};

use super::{FactRow, ModelStore};

/// Readers of the events that webhooks may get.
const PEOPLE: &str = "PEOPLE";

/// A row of the targets, with its hold.
#[derive(Debug, Clone)]
pub(super) struct Webhook {
    row: WebhookRow,
    secret: Vec<u8>,
    holder: Option<String>,
    /// End of the hold, µs since 1970 UTC; 0 if nobody holds it.
    held_until_us: i64,
    /// Failed attempts of the event that is next.
    attempts: i64,
}

impl Webhook {
    /// Whether the pause after the last attempt is over. It is if that attempt is in the future: the clock was stepped back.
    fn is_time(&self, now_us: i64) -> bool {
        self.row.next_us <= now_us || self.row.last_us.is_some_and(|last_us| last_us > now_us)
    }

    fn release(&mut self) {
        (self.holder, self.held_until_us) = (None, 0);
    }
}

/// An event that a target did not take.
#[derive(Debug, Clone)]
pub(super) struct Letter {
    /// Whether it is delivered again.
    again: bool,
}

/// An event of the log.
#[derive(Debug, Clone)]
pub(super) struct LogEvent {
    fleet: String,
    row: EventRow,
}

impl ModelStore {
    /// Appends an event to the log.
    pub(super) fn append_event(&mut self, lease: &Lease, row: EventRow) {
        if row.audience == PEOPLE {
            let event_id = self.next_number();
            self.events.set(event_id, LogEvent { fleet: lease.fleet().to_string(), row: row.clone() });
        }
        self.note(lease, FactRow::Event(row));
    }

    /// Inserts a target, which gets the events from now on; returns its number.
    pub fn add_webhook(&mut self, new: &WebhookSettings) -> i64 {
        let (webhook_id, done_event) = (self.next_number(), self.last_number);
        let row = WebhookRow {
            webhook_id,
            name: new.name.clone(),
            url: new.url.clone(),
            fleets: new.fleets.clone(),
            kinds: new.kinds.clone(),
            level: new.level.clone(),
            enabled: new.enabled,
            previous_until_us: None,
            created_us: self.clock_us,
            changed_us: self.clock_us,
            changed_by: "admin".to_owned(),
            done_tx: 0,
            done_event,
            streak: 0,
            next_us: 0,
            last_us: None,
            last_status: None,
            last_problem: None,
            last_success_us: None,
            delivered: 0,
            failed: 0,
            lost: 0,
        };
        let secret = webhook_id.to_be_bytes().to_vec();
        self.webhooks.set(webhook_id, Webhook { row, secret, holder: None, held_until_us: 0, attempts: 0 });
        webhook_id
    }

    /// Sets whether a target gets events. It begins at once.
    pub fn enable_webhook(&mut self, webhook_id: i64, enabled: bool) {
        self.webhooks.change(&webhook_id, |one| one.row.enabled = enabled);
        self.begin_at_once(webhook_id);
    }

    /// Moves the last attempt of a target by a time, µs, as a step of the database's clock does.
    pub fn move_attempt(&mut self, webhook_id: i64, by_us: i64) {
        self.webhooks.change(&webhook_id, |one| {
            one.row.next_us += by_us;
            one.row.last_us = one.row.last_us.map(|last_us| last_us + by_us);
        });
    }

    /// Delivers all dead letters of a target again, or deletes them; returns how many.
    pub fn settle_dead_letters(&mut self, webhook_id: i64, fate: Fate) -> u64 {
        let letters = self.dead_letters.keys_of(|(of, _), _| *of == webhook_id);
        for letter in &letters {
            match fate {
                Fate::Again => self.dead_letters.set(*letter, Letter { again: true }),
                Fate::Discarded => self.dead_letters.remove(letter),
            }
        }
        self.begin_at_once(webhook_id);
        letters.len() as u64
    }

    /// The events of a target's dead letters, each with whether it is delivered again.
    pub fn dead_letters(&self, webhook_id: i64) -> impl Iterator<Item = (i64, bool)> {
        let letters = self.dead_letters.range((webhook_id, i64::MIN)..=(webhook_id, i64::MAX));
        letters.map(|((_, event_id), letter)| (*event_id, letter.again))
    }

    /// The events of the log that a target wants.
    pub fn events_for(&self, webhook_id: i64) -> impl Iterator<Item = StoredEvent> {
        let row = self.webhooks.get(&webhook_id).map(|one| &one.row);
        row.into_iter().flat_map(|row| {
            let interest = row.interest();
            let all = self.events.iter().map(|(event_id, event)| self.stored_event(*event_id, event));
            all.filter(move |event| event.event_id > row.webhook_id && event.is_in(&interest))
        })
    }

    fn begin_at_once(&mut self, webhook_id: i64) {
        self.webhooks.change(&webhook_id, |one| (one.row.next_us, one.row.streak, one.attempts) = (0, 0, 0));
    }

    fn stored_event(&self, event_id: i64, LogEvent { fleet, row }: &LogEvent) -> StoredEvent {
        let whisker = row.whisker_id.and_then(|id| self.name_of_whisker(id));
        StoredEvent {
            event_id,
            tx: 0,
            recorded_us: row.recorded_us,
            version: row.version,
            kind: row.kind.to_owned(),
            word: row.word.map(str::to_owned),
            fleet: fleet.clone(),
            robot: row.robot_id.and_then(|id| self.name_of_robot(id)).map(str::to_owned),
            array: whisker.map(|(_, array, _)| array.to_owned()),
            whisker: whisker.map(|(_, _, number)| number),
            data: row.data.clone(),
        }
    }

    fn has_work(&self, row: &WebhookRow) -> bool {
        self.events.range(row.done_event + 1..).next().is_some()
            || self.dead_letters(row.webhook_id).any(|(_, again)| again)
    }

    /// The oldest dead letter to deliver again, or else the next event that the target wants. Those before it are done.
    fn next_event(&mut self, row: &WebhookRow) -> Option<(StoredEvent, bool)> {
        let again = self.dead_letters(row.webhook_id).find(|(_, again)| *again);
        if let Some((event_id, _)) = again {
            return self.events.get(&event_id).map(|event| (self.stored_event(event_id, event), true));
        }
        let (interest, mut done) = (row.interest(), row.done_event);
        let mut found = None;
        for (event_id, event) in self.events.range(row.done_event + 1..) {
            let event = self.stored_event(*event_id, event);
            if event.is_in(&interest) {
                found = Some((event, false));
                break;
            }
            done = *event_id;
        }
        self.webhooks.change(&row.webhook_id, |one| one.row.done_event = done);
        found
    }
}

impl Webhooks for ModelStore {
    fn due(&self) -> Vec<Due> {
        let all = self.webhooks.iter().map(|(_, one)| one);
        let due = all.filter(|one| one.row.enabled && one.is_time(self.clock_us) && self.has_work(&one.row));
        let due = due.map(|one| Due {
            webhook_id: one.row.webhook_id,
            holder: one.holder.clone(),
            held_until_us: if fault::is(Fault::NoHold) { 0 } else { one.held_until_us },
        });
        due.collect()
    }

    fn take_job(&mut self, webhook_id: i64, holding: &Holding<'_>) -> Option<Job> {
        let (now_us, one) = (self.clock_us, self.webhooks.get(&webhook_id)?);
        let is_own = one.holder.as_deref() == Some(holding.holder);
        let is_free = is_own || [0, holding.seen].contains(&one.held_until_us) || fault::is(Fault::NoHold);
        if !one.row.enabled || !one.is_time(now_us) || !is_free {
            return None;
        }
        self.webhooks.change(&webhook_id, |one| {
            (one.holder, one.held_until_us) = (Some(holding.holder.to_owned()), now_us + holding.hold_us);
        });
        let Webhook { row, secret, attempts, .. } = self.webhooks.get(&webhook_id)?.clone();
        let Some((event, is_again)) = self.next_event(&row) else {
            self.webhooks.change(&webhook_id, Webhook::release);
            return None;
        };
        let age_us = now_us - event.recorded_us;
        // Mails go through no model: there is one event at a time.
        Some(Job { webhook: row, event, more: Vec::new(), secrets: vec![secret], attempts, is_again, age_us })
    }

    fn finish_job(&mut self, job: &Job, holder: &str, outcome: &Outcome) -> bool {
        let (webhook_id, event_id, now_us) = (job.webhook.webhook_id, job.event.event_id, self.clock_us);
        let is_held = self.webhooks.get(&webhook_id).is_some_and(|one| one.holder.as_deref() == Some(holder));
        if !is_held {
            return false;
        }
        if let Outcome::Postponed { pause_us } = outcome {
            self.webhooks.change(&webhook_id, |one| {
                one.row.next_us = now_us + pause_us;
                one.release();
            });
            return true;
        }
        let is_over = matches!(outcome, Outcome::Delivered { .. } | Outcome::Failed { is_dead: true, .. });
        self.webhooks.change(&webhook_id, |one| {
            one.row.last_us = Some(now_us);
            one.attempts = if is_over { 0 } else { one.attempts + 1 };
            if is_over && !job.is_again {
                one.row.done_event = event_id;
            }
            match outcome {
                Outcome::Delivered { status } => {
                    (one.row.last_status, one.row.last_problem) = (Some(i64::from(*status)), None);
                    (one.row.last_success_us, one.row.next_us, one.row.streak) = (Some(now_us), 0, 0);
                    one.row.delivered += 1;
                }
                Outcome::Postponed { .. } => {}
                Outcome::Failed { status, problem, pause_us, .. } => {
                    one.row.last_status = status.map(i64::from);
                    (one.row.last_problem, one.row.next_us) = (Some(problem.clone()), now_us + pause_us);
                    (one.row.streak, one.row.failed) = (one.row.streak + 1, one.row.failed + 1);
                    one.release();
                }
            }
        });
        match outcome {
            Outcome::Delivered { .. } if job.is_again => self.dead_letters.remove(&(webhook_id, event_id)),
            Outcome::Failed { is_dead: true, .. } => {
                self.dead_letters.set((webhook_id, event_id), Letter { again: false });
            }
            Outcome::Delivered { .. } | Outcome::Postponed { .. } | Outcome::Failed { .. } => {}
        }
        true
    }

    fn release_holds(&mut self, holder: &str) {
        for webhook_id in self.webhooks.keys_of(|_, one| one.holder.as_deref() == Some(holder)) {
            self.webhooks.change(&webhook_id, Webhook::release);
        }
    }

    fn webhooks(&self) -> Vec<WebhookRow> {
        let mut rows: Vec<WebhookRow> = self.webhooks.iter().map(|(_, one)| one.row.clone()).collect();
        rows.sort_by(|one, other| one.name.cmp(&other.name));
        rows
    }

    fn queues(&self, webhooks: &[WebhookRow]) -> Vec<Queue> {
        let of = |row: &WebhookRow| {
            let dead = self.dead_letters(row.webhook_id).filter(|(_, again)| !again).count() as i64;
            let interest = row.interest();
            let events = self.events.range(row.done_event + 1..);
            let events = events.map(|(event_id, event)| self.stored_event(*event_id, event));
            let waiting: Vec<i64> =
                events.filter(|event| event.is_in(&interest)).map(|event| event.recorded_us).collect();
            Queue { waiting: waiting.len() as i64, oldest_us: waiting.iter().min().copied(), dead }
        };
        webhooks.iter().map(of).collect()
    }
}
