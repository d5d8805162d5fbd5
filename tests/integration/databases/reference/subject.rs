//! A database under test, with the numbers that it has given.

use std::sync::Arc;
use std::time::Duration;

use rand::Rng;
use rand_chacha::ChaCha8Rng;
use vibrissa_core::robot::Robot;
use vibrissa_protocol::Name;
use vibrissa_simulation::store::{AtHand, FactRow, ModelStore};
use vibrissa_store::batch::Record;
use vibrissa_store::events::Position;
use vibrissa_store::{Batch, Lease, Refused, Store, StoreError, Supervisor, Writer};

use super::{text, webhooks};
use crate::Fresh;
use crate::refused::Admin;

/// A number that no row has.
pub(super) const NOBODY: i64 = 999_999_999;

/// The way to a database beside the store.
pub(super) enum Behind {
    Database(Admin),
    Model(Arc<AtHand>),
}

impl Behind {
    pub(super) async fn of(database: &Fresh) -> Self {
        Self::Database(Admin::of(database).await)
    }
}

/// A robot.
pub(super) struct KnownRobot {
    pub(super) name: String,
    pub(super) robot_id: i64,
    pub(super) core: Robot,
    /// By their number on the array.
    pub(super) whiskers: Vec<i64>,
    /// Numbers of trims and compensations that were drawn, existing or not.
    pub(super) drawn: i64,
}

/// A database under test.
pub(super) struct Subject {
    pub(super) store: Store,
    pub(super) behind: Behind,
    pub(super) writer: Writer,
    pub(super) lease: Lease,
    /// The lease of an earlier owner.
    pub(super) lost: Lease,
    pub(super) robots: Vec<KnownRobot>,
    pub(super) boots: Vec<i64>,
    pub(super) actions: Vec<i64>,
    pub(super) calibrations: Vec<i64>,
    pub(super) webhooks: webhooks::Known,
    /// Number of the last row of the journal.
    pub(super) journal: i64,
    /// Version of the last policy that was drawn.
    pub(super) policy: i64,
    /// Times of rows, each another one.
    ticks: i64,
}

impl Subject {
    /// The second owner of a fleet.
    pub(super) async fn new(store: Store, behind: Behind, fleet: &Name) -> Self {
        let mut writer = store.writer();
        let own = |id: &str| Supervisor {
            id: id.into(),
            name: id.to_owned(),
            fleets: vec![fleet.clone()],
            time_to_live: Duration::from_secs(600),
        };
        writer.sign_in(&own("a"), &[]).await.unwrap();
        let lost = writer.acquire(&own("a"), fleet).await.unwrap().unwrap();
        writer.release(&lost).await.unwrap();
        writer.sign_in(&own("b"), &[]).await.unwrap();
        let lease = writer.acquire(&own("b"), fleet).await.unwrap().unwrap();
        let (robots, boots, actions, calibrations) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let (webhooks, journal, policy, ticks) = (webhooks::Known::default(), 0, 0, 1_795_248_000_000_000);
        Self {
            store,
            behind,
            writer,
            lease,
            lost,
            robots,
            boots,
            actions,
            calibrations,
            webhooks,
            journal,
            policy,
            ticks,
        }
    }

    pub(super) fn fleet(&self) -> Name {
        self.lease.fleet().clone()
    }

    pub(super) fn tick(&mut self) -> i64 {
        self.ticks += 1_000_000;
        self.ticks
    }

    /// A robot, if there is one.
    pub(super) fn any_robot(&self, random: &mut ChaCha8Rng) -> Option<usize> {
        (!self.robots.is_empty()).then(|| random.random_range(0..self.robots.len()))
    }

    /// An action, or a number that none has.
    pub(super) fn any_action(&self, random: &mut ChaCha8Rng) -> i64 {
        self.actions.get(random.random_range(0..=self.actions.len())).copied().unwrap_or(NOBODY)
    }

    /// A robot by its place.
    pub(super) fn place(&self, robot_id: i64) -> Option<usize> {
        self.robots.iter().position(|robot| robot.robot_id == robot_id)
    }

    /// A whisker by the place of its robot and its own.
    pub(super) fn whisker_place(&self, whisker_id: i64) -> Option<(usize, usize)> {
        let places = self.robots.iter().map(|robot| robot.whiskers.iter().position(|id| *id == whisker_id));
        places.enumerate().find_map(|(robot, whisker)| Some((robot, whisker?)))
    }

    /// Writes a batch; its answer may be lost once.
    pub(super) async fn commit(&mut self, batch: &Batch, loses_answer: bool) -> Result<(), StoreError> {
        self.will_lose(loses_answer, 0);
        let first = self.writer.commit(&self.lease, batch).await;
        if !loses_answer || !self.lost(&first).await {
            return first;
        }
        self.writer.commit(&self.lease, batch).await
    }

    /// Writes a batch robot by robot; returns who was left out and what was written.
    pub(super) async fn commit_apart(&mut self, batch: &mut Batch, loses_answer: bool) -> String {
        let robots: Vec<i64> = self.robots.iter().map(|robot| robot.robot_id).collect();
        let split = |entries: &[u8]| -> Vec<(i64, Vec<u8>)> {
            entries.iter().map(|robot| (robots[usize::from(*robot)], vec![*robot])).collect()
        };
        let mut refused: Vec<Refused> = Vec::new();
        self.will_lose(loses_answer, 1);
        let mut written = self.writer.commit_apart(&self.lease, batch, split, &mut refused).await;
        if loses_answer && self.lost(&written).await {
            written = self.writer.commit_apart(&self.lease, batch, split, &mut refused).await;
        }
        let owner = |one: &Refused| match one.owner {
            vibrissa_store::batch::Owner::Robot(robot_id) => format!("{:?}", self.place(robot_id)),
            other => format!("{other:?}"),
        };
        let refused: Vec<_> = refused.iter().map(|one| (owner(one), one.rejection.cause)).collect();
        let rows = [batch.robots.len(), batch.contacts.len(), batch.records.len(), batch.events.len()];
        let entries = batch.journal.as_ref().map(|row| row.entries.clone());
        format!("{} {refused:?} {rows:?} {entries:?}", text(written))
    }

    fn will_lose(&self, loses_answer: bool, further: i64) {
        if let (true, Behind::Model(at_hand)) = (loses_answer, &self.behind) {
            at_hand.lose_answer(further);
        }
    }

    /// Whether the answer to a commit is lost: then the commit counter of a database is ahead by one.
    async fn lost(&mut self, first: &Result<(), StoreError>) -> bool {
        match &mut self.behind {
            Behind::Model(_) => true,
            Behind::Database(admin) if first.is_ok() => {
                let fleet = self.lease.fleet();
                admin.execute(format!("UPDATE leases SET commits = commits + 1 WHERE fleet = '{fleet}'")).await;
                true
            }
            Behind::Database(_) => false,
        }
    }
}

/// Rows that no owner loads.
pub(super) struct Kept {
    /// Time, fleet, kind, word and data.
    pub(super) events: Vec<(i64, String, String, Option<String>, String)>,
    /// Numbers of contacts, changes of health, and states of setpoints.
    pub(super) counts: [usize; 3],
}

pub(super) fn kept(model: &mut ModelStore) -> Kept {
    let (mut events, mut counts) = (Vec::new(), [0; 3]);
    for fact in model.take_facts() {
        match fact.row {
            FactRow::Contact(_) => counts[0] += 1,
            FactRow::Record(Record::Health(_)) => counts[1] += 1,
            FactRow::Record(Record::Setpoint(_) | Record::SetpointState(_)) => counts[2] += 1,
            FactRow::Event(row) => events.push((
                row.recorded_us,
                fact.fleet.to_string(),
                row.kind.to_owned(),
                row.word.map(str::to_owned),
                row.data,
            )),
            _ => {}
        }
    }
    Kept { events, counts }
}

pub(super) async fn stored(store: &Store) -> Kept {
    let (mut events, mut after) = (Vec::new(), Position::default());
    loop {
        let some = store.events_after(after).await.unwrap();
        let Some((last, _)) = some.last() else { break };
        after = *last;
        let rows = some.into_iter().filter_map(|(_, row)| row);
        events.extend(rows.map(|row| (row.recorded_us, row.fleet, row.kind, row.word, row.data)));
    }
    let contacts = store.contact_count().await.unwrap() as usize;
    let health = store.health_changes().await.unwrap().len();
    Kept { events, counts: [contacts, health, store.setpoint_history().await.unwrap().len()] }
}
