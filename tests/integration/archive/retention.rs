//! No contact is deleted from the database before it is archived.

use std::time::Duration;

use vibrissa_protocol::Name;
use vibrissa_store::archive::{Archived, Span};
use vibrissa_store::retention::{Done, Retention};
use vibrissa_store::{DatabaseAddress, Lease, Store, Supervisor, Writer};
use vibrissa_tests::postgres::Postgres;

const DAY_US: i64 = 86_400_000_000;
/// `date -u -d @1795262400`: 2026-11-21 12:00:00
const NOON_US: i64 = 1_795_262_400_000_000;

fn fleet() -> Name {
    Name::new("lab").unwrap()
}

async fn owner(store: &Store) -> (Writer, Lease) {
    let supervisor = Supervisor {
        id: "s".into(),
        name: "s".to_owned(),
        fleets: vec![fleet()],
        time_to_live: Duration::from_secs(60),
    };
    let mut writer = store.writer();
    writer.sign_in(&supervisor, &[]).await.unwrap();
    let lease = writer.acquire(&supervisor, &fleet()).await.unwrap().unwrap();
    (writer, lease)
}

/// Partitions that are dropped at noon of the tenth day, if contacts are kept for one day.
async fn dropped(store: &Store) -> usize {
    let mut reports = Vec::new();
    let retention = Retention { contacts_days: 1, minutes_days: 0, black_boxes_days: 0, records_days: 0 };
    store.look_after(retention, NOON_US + 10 * DAY_US, &mut |done| reports.push(done)).await.unwrap();
    let is_of_contacts =
        |done: &&Done| matches!(done, Done::Dropped { partition, .. } if partition.starts_with("contacts_2026112"));
    reports.iter().filter(is_of_contacts).count()
}

#[tokio::test]
async fn a_day_goes_when_it_is_archived_and_too_old() {
    let server = Postgres::start_with_supervisor().await;
    let address: DatabaseAddress = Postgres::supervisor_url(server.port()).parse().unwrap();
    let store = Store::open(&address, "test").await.unwrap();
    store.prepare().await.unwrap();
    for day in 0..3 {
        store.make_partitions(NOON_US + day * DAY_US, &mut |_| {}).await.unwrap();
    }
    let (mut writer, lease) = owner(&store).await;
    store.begin_archives(&[fleet()], NOON_US + DAY_US).await.unwrap();
    // The archive begins with the day before, as there are no contacts yet.
    let begin_us = NOON_US - DAY_US / 2;
    assert_eq!(store.archived_to(&fleet()).await.unwrap(), Some(begin_us));
    assert_eq!(dropped(&store).await, 0);

    assert_eq!(writer.plan_archive(&lease, DAY_US).await.unwrap(), None, "no owner has stated a horizon");
    writer.state_horizon(&lease, begin_us + DAY_US).await.unwrap();
    assert_eq!(writer.archive_floor(&fleet()).await.unwrap(), begin_us + DAY_US);
    let span = writer.plan_archive(&lease, DAY_US).await.unwrap().unwrap();
    assert_eq!(span, Span { from_us: begin_us, to_us: begin_us + DAY_US });
    assert_eq!(writer.plan_archive(&lease, 1).await.unwrap(), Some(span), "a plan stays until it is carried out");
    assert!(writer.is_archive_planned(&lease, span).await.unwrap());
    assert_eq!(dropped(&store).await, 0, "a planned span is not archived yet");
    writer.advance_archive(&lease, span, Archived { contacts: 3, bytes: 200 }).await.unwrap();
    assert!(!writer.is_archive_planned(&lease, span).await.unwrap());
    assert_eq!(dropped(&store).await, 1, "the first day, and no other");

    // A former owner changes nothing.
    writer.release(&lease).await.unwrap();
    assert!(writer.plan_archive(&lease, 1).await.is_err());
    assert!(writer.state_horizon(&lease, begin_us + 5 * DAY_US).await.is_err());
}
