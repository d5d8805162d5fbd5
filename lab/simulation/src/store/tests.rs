use std::future::pending;
use std::sync::Arc;
use std::time::Duration;

use tokio::sync::watch;
use vibrissa_protocol::Name;
use vibrissa_store::batch::{AlarmRow, EventRow, Owner, Record};
use vibrissa_store::model::{Model, ModelServer, Way};
use vibrissa_store::{Batch, Lease, LossCause, RejectionCause, Store, StoreError, Supervisor, Writer};

use super::*;

fn supervisor(id: &str) -> Supervisor {
    let (name, fleets) = (format!("supervisor {id}"), vec![Name::new("f").expect("a name")]);
    Supervisor { id: id.into(), name, fleets, time_to_live: Duration::from_secs(2) }
}

async fn acquired(store: &Store, id: &str) -> (Writer, Lease) {
    let (own, mut writer) = (supervisor(id), store.writer());
    writer.sign_in(&own, &[]).await.expect("signed in");
    let lease = writer.acquire(&own, &own.fleets[0]).await.expect("an answer").expect("a free lease");
    (writer, lease)
}

fn event(recorded_us: i64) -> Batch {
    let events = vec![EventRow::new(vibrissa_edge::events::EventKind::Policy, recorded_us)];
    Batch { events, ..Batch::default() }
}

#[tokio::test(start_paused = true)]
async fn a_commit_whose_answer_is_lost_is_written_once() {
    let server = Arc::new(AtHand::default());
    let store = Store::modelled(server.clone());
    assert!(store.is_shared());
    let (mut writer, lease) = acquired(&store, "a").await;
    server.lose_answer(0);
    assert!(matches!(writer.commit(&lease, &event(1)).await, Err(StoreError::Query { .. })));
    writer.commit(&lease, &event(1)).await.expect("written before");
    writer.commit(&lease, &event(2)).await.expect("written");
    let facts = server.store().take_facts();
    assert_eq!(facts.len(), 2);
    assert!(facts.iter().all(|fact| fact.epoch == lease.epoch()));
    assert!(server.store().take_facts().is_empty());
}

#[tokio::test(start_paused = true)]
async fn a_failover_that_loses_commits_ends_the_lease() {
    let server = Arc::new(AtHand::default());
    let store = Store::modelled(server.clone());
    let (mut writer, lease) = acquired(&store, "a").await;
    let before = server.store().clone();
    writer.commit(&lease, &event(1)).await.expect("written");
    *server.store() = before;
    let lost = writer.commit(&lease, &event(2)).await.expect_err("the lease is lost");
    let StoreError::LeaseLost { cause: LossCause::CommitsLost { commits: 1 }, .. } = lost else { panic!("{lost}") };
    assert!(server.store().take_facts().is_empty());
    let (_, next) = acquired(&store, "a").await;
    assert!(next.epoch() > lease.epoch());
    assert_eq!(server.store().epochs().count(), 2);
}

/// A batch after a boot's number was lost would refer to a boot that does not exist.
#[tokio::test(start_paused = true)]
async fn regress_a_failover_that_loses_an_assigned_number_ends_the_lease() {
    let server = Arc::new(AtHand::default());
    let store = Store::modelled(server.clone());
    let (mut writer, lease) = acquired(&store, "a").await;
    let robot_id = writer.register(&lease, ("r", "b"), 1).await.expect("registered").expect("a new robot").robot_id;
    let before = server.store().clone();
    // Nobody knows of a number whose answer was lost, so its loss is harmless.
    server.lose_answer(0);
    writer.boot(&lease, robot_id, "b", 1).await.expect_err("no answer");
    *server.store() = before.clone();
    writer.commit(&lease, &event(1)).await.expect("written");
    let before = server.store().clone();
    writer.boot(&lease, robot_id, "b", 1).await.expect("a number");
    *server.store() = before;
    for lost in [writer.commit(&lease, &event(2)).await, writer.boot(&lease, robot_id, "c", 2).await.map(drop)] {
        let lost = lost.expect_err("the lease is lost");
        let StoreError::LeaseLost { cause: LossCause::CommitsLost { commits: 1 }, .. } = lost else { panic!("{lost}") };
    }
    let (mut writer, next) = acquired(&store, "a").await;
    writer.boot(&next, robot_id, "b", 2).await.expect("a number in the next epoch");
    writer.commit(&next, &event(2)).await.expect("written");
}

#[tokio::test(start_paused = true)]
async fn rows_that_break_a_rule_leave_nothing() {
    let server = Arc::new(AtHand::default());
    let (mut writer, lease) = acquired(&Store::modelled(server.clone()), "a").await;
    let alarm = |robot_id| {
        let row = vibrissa_store::batch::RobotAlarmRow { robot_id, raised_us: 1, kind: "LEAK" };
        Record::RobotAlarm(row)
    };
    let known = writer.register(&lease, ("r", "b"), 1).await.expect("registered").expect("a new robot").robot_id;
    let mut batch = Batch { records: vec![alarm(known), alarm(known + 1)], ..event(1) };
    let refused = writer.commit(&lease, &batch).await.expect_err("refused");
    assert_eq!(
        refused.rejection().map(|why| (why.cause, why.code)),
        Some((RejectionCause::Constraint, "23503".into()))
    );
    assert!(server.store().take_facts().is_empty());
    let mut refused = Vec::new();
    writer.commit_apart(&lease, &mut batch, |_| Vec::new(), &mut refused).await.expect("written");
    assert_eq!(refused.iter().map(|one| one.owner).collect::<Vec<_>>(), [Owner::Robot(known + 1)]);
    assert_eq!(server.store().take_facts().len(), 2);
    assert_eq!(writer.robots_with_alarm(&lease, "LEAK").await.expect("an answer"), [known]);
    let whisker = Record::Alarm(AlarmRow { whisker_id: 99, raised_us: 1, kind: "LEAK" });
    assert!(writer.commit(&lease, &Batch { records: vec![whisker], ..Batch::default() }).await.is_err());
}

#[tokio::test(start_paused = true)]
async fn rows_wait_for_room_on_the_disk_and_leases_do_not() {
    let server = Arc::new(AtHand::default());
    let (mut writer, lease) = acquired(&Store::modelled(server.clone()), "a").await;
    server.store().set_full(true);
    let refused = writer.commit(&lease, &event(1)).await.expect_err("no room");
    assert!(refused.is_passing() && refused.rejection().is_none(), "{refused}");
    assert!(refused.to_string().contains("53100"), "{refused}");
    assert!(server.store().take_facts().is_empty());
    writer.sign_in(&supervisor("a"), std::slice::from_ref(&lease)).await.expect("renewed");
    server.store().set_full(false);
    writer.commit(&lease, &event(1)).await.expect("written");
    assert_eq!(server.store().take_facts().len(), 1);
}

/// A server that no request reaches.
#[derive(Debug, Default)]
struct CutOff(watch::Sender<u64>);

impl ModelServer for CutOff {
    fn reach(&self) -> Way<'_> {
        Box::pin(pending())
    }

    fn answer(&self) -> Way<'_> {
        Box::pin(pending())
    }

    fn with(&self, _: &mut dyn FnMut(&mut dyn Model)) {}

    fn leader_changes(&self) -> watch::Receiver<u64> {
        self.0.subscribe()
    }
}

#[tokio::test(start_paused = true)]
async fn a_request_ends_with_its_patience_or_with_a_new_leader() {
    let server = Arc::new(CutOff::default());
    let (store, own) = (Store::modelled(server.clone()), supervisor("a"));
    let mut writer = store.writer();
    let began = tokio::time::Instant::now();
    assert!(matches!(writer.sign_in(&own, &[]).await, Err(StoreError::NoAnswer { .. })));
    assert_eq!(began.elapsed(), own.time_to_live);
    let new_leader = async { server.0.send_modify(|changes| *changes += 1) };
    let (signed_in, ()) = tokio::join!(writer.sign_in(&own, &[]), new_leader);
    assert!(matches!(signed_in, Err(StoreError::Query { .. })));
    assert_eq!(began.elapsed(), own.time_to_live);
    let problem = store.ping().await.expect_err("no answer");
    assert!(problem.is_passing(), "{problem}");
    // What is in SQL only fails at once.
    let now = tokio::time::Instant::now();
    assert!(store.contact_count().await.is_err());
    assert_eq!(now.elapsed(), Duration::ZERO);
}
