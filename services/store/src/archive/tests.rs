use sqlx::{AssertSqlSafe, SqlSafeStr as _};

use super::*;
use crate::retention::Retention;
use crate::sqlite::tests::Folder;
use crate::{DatabaseAddress, Supervisor};

const MINUTE_US: i64 = 60_000_000;
/// `date -u -d @1795262400`: 2026-11-21 12:00:00
const NOON_US: i64 = 1_795_262_400_000_000;

#[test]
fn a_file_is_due_when_its_span_is_complete() {
    let next =
        |horizon_us| next_span(NOON_US, horizon_us, 10 * MINUTE_US).map(|span| (span.to_us - NOON_US) / MINUTE_US);
    assert_eq!(next(0), None);
    assert_eq!(next(NOON_US + 10 * MINUTE_US - 1), None);
    assert_eq!(next(NOON_US + 10 * MINUTE_US), Some(10));
    assert_eq!(next(NOON_US + 17 * MINUTE_US), Some(17));
    assert_eq!(next(NOON_US + 90 * MINUTE_US), Some(60), "an archive that is behind catches up in hours");
}

#[test]
fn no_file_has_contacts_of_two_days() {
    let midnight_us = NOON_US + DAY_US / 2;
    let span = next_span(midnight_us - 3 * MINUTE_US, midnight_us + MINUTE_US, 10 * MINUTE_US).unwrap();
    assert_eq!(span.to_us, midnight_us);
    assert_eq!(next_span(midnight_us, midnight_us + MINUTE_US, 10 * MINUTE_US), None);
}

/// A fleet's owner on a new database.
async fn owner(folder: &Folder) -> (Store, Writer, Lease) {
    let store = Store::open(&DatabaseAddress::Sqlite(folder.file()), "test").await.unwrap();
    store.prepare().await.unwrap();
    let supervisor = Supervisor {
        id: "s".into(),
        name: "s".to_owned(),
        fleets: vec![fleet()],
        time_to_live: Duration::from_secs(60),
    };
    let mut writer = store.writer();
    writer.sign_in(&supervisor, &[]).await.unwrap();
    let lease = writer.acquire(&supervisor, &fleet()).await.unwrap().unwrap();
    (store, writer, lease)
}

fn fleet() -> Name {
    Name::new("lab").unwrap()
}

async fn run(store: &Store, sql: &str) {
    let Either::Sqlite(pool) = &store.pool else { panic!("SQLite") };
    sqlx::raw_sql(AssertSqlSafe(sql).into_sql_str()).execute(pool).await.unwrap();
}

/// Records contacts a second apart. The first ones bring their whisker with them.
async fn record(store: &Store, at_us: i64, rows: i64) {
    const WHISKER: &str = "INSERT INTO robots (robot_id, fleet, robot) VALUES (1, 'lab', 'r') ON CONFLICT DO NOTHING; \
         INSERT INTO arrays (array_id, robot_id, \"array\", array_type) VALUES (1, 1, 'a', 'TYPE_1') ON CONFLICT DO NOTHING; \
         INSERT INTO whiskers (whisker_id, array_id, robot_id, whisker, x_mm, y_mm, model, whole_length_mm, \
         nominal_pressure_mpa, pressure_max_mpa, length_mm, length_sd_mm, condition, setpoint_mpa) \
         VALUES (1, 1, 1, 0, 0, 0, 'm', 70, 0.1, 0.2, 70, 1, 'HEALTHY', 0.1) ON CONFLICT DO NOTHING; \
         INSERT INTO boots (boot, robot_id, boot_id, first_seen_us) VALUES (1, 1, 'b', 0) ON CONFLICT DO NOTHING";
    run(store, WHISKER).await;
    let contacts = format!(
        "WITH RECURSIVE c (n) AS (SELECT 0 UNION ALL SELECT n + 1 FROM c WHERE n + 1 < {rows}) INSERT INTO contacts \
         (whisker_id, boot, seq, position, t_us, received_us, ratio, deflection_mm, strain, pressure_mpa, temperature_c, used, \
         length_mm, length_sd_mm) SELECT 1, 1, n, 0, {at_us}, {at_us} + n * 1000000, 0.9, 2, 0.01, 0.1, 24, 'USED', 70, 1 FROM c"
    );
    run(store, &contacts).await;
}

/// Archives all contacts up to a horizon; returns how many.
async fn archive(store: &Store, writer: &mut Writer, lease: &Lease, horizon_us: i64) -> u64 {
    writer.state_horizon(lease, horizon_us).await.unwrap();
    let mut contacts = 0;
    while let Some(span) = writer.plan_archive(lease, DAY_US).await.unwrap() {
        let (send, mut rows) = mpsc::channel::<Vec<Vec<Cell>>>(4);
        let read = async {
            let mut read = 0;
            while let Some(group) = rows.recv().await {
                read += group.len() as u64;
            }
            read
        };
        let (done, read) = tokio::join!(store.read_span(lease.fleet(), span, send), read);
        done.unwrap();
        writer.advance_archive(lease, span, Archived { contacts: read, bytes: read }).await.unwrap();
        contacts += read;
    }
    contacts
}

/// Number of contacts that are left after upkeep, if they are kept for a day.
async fn kept(store: &Store, now_us: i64) -> i64 {
    let retention = Retention { contacts_days: 1, minutes_days: 0, black_boxes_days: 0, records_days: 0 };
    while store.look_after(retention, now_us, &mut |_| {}).await.unwrap() {}
    store.contact_count().await.unwrap()
}

/// SQLite numbers contacts from 1 again once all are deleted. The archive looked for numbers after the last one.
#[tokio::test]
async fn regress_contacts_after_an_idle_time_are_archived() {
    let folder = Folder::new();
    let (store, mut writer, lease) = owner(&folder).await;
    store.begin_archives(&[fleet()], NOON_US).await.unwrap();
    record(&store, NOON_US, 50).await;
    record(&store, NOON_US + DAY_US, 50).await;
    assert_eq!(archive(&store, &mut writer, &lease, NOON_US + 2 * DAY_US).await, 100);
    assert_eq!(kept(&store, NOON_US + 4 * DAY_US).await, 0);
    record(&store, NOON_US + 5 * DAY_US, 10).await;
    assert_eq!(kept(&store, NOON_US + 5 * DAY_US + MINUTE_US).await, 10);
    assert_eq!(archive(&store, &mut writer, &lease, NOON_US + 6 * DAY_US).await, 10);
    store.close().await;
}

/// The host was three months ahead when the archive began. Nothing was archived for three months, but deleted.
#[tokio::test]
async fn regress_an_archive_that_begins_in_the_future_loses_no_contact() {
    let folder = Folder::new();
    let (store, mut writer, lease) = owner(&folder).await;
    store.begin_archives(&[fleet()], NOON_US + 90 * DAY_US).await.unwrap();
    let ahead_us = NOON_US + 90 * DAY_US - DAY_US / 2 - DAY_US;
    assert_eq!(store.archive_ahead(NOON_US).await.unwrap(), Some(("lab".to_owned(), ahead_us)));
    record(&store, NOON_US, 20).await;
    record(&store, NOON_US + 20 * DAY_US, 20).await;
    assert_eq!(kept(&store, NOON_US + 40 * DAY_US).await, 40, "nothing is archived yet");
    // An older program has left contacts of many days.
    let horizon_us = NOON_US + 21 * DAY_US;
    assert_eq!(archive(&store, &mut writer, &lease, horizon_us).await, 40);
    assert_eq!(store.archive_ahead(horizon_us).await.unwrap(), None);
    assert_eq!(kept(&store, NOON_US + 40 * DAY_US).await, 0);
    store.close().await;
}

/// The boots were seen by a clock that was ahead.
#[tokio::test]
async fn regress_an_archive_begins_with_the_oldest_contact() {
    let folder = Folder::new();
    let (store, mut writer, lease) = owner(&folder).await;
    record(&store, NOON_US, 5).await;
    run(&store, &format!("UPDATE boots SET first_seen_us = {}", NOON_US + 90 * DAY_US)).await;
    store.begin_archives(&[fleet()], NOON_US + 3 * DAY_US).await.unwrap();
    assert_eq!(store.archived_to(&fleet()).await.unwrap(), Some(NOON_US - DAY_US / 2 - DAY_US));
    assert_eq!(archive(&store, &mut writer, &lease, NOON_US + 3 * DAY_US).await, 5);
    store.close().await;
}

/// Each file read all contacts of the fleet.
#[tokio::test]
async fn regress_a_file_reads_the_contacts_of_its_span_only() {
    let folder = Folder::new();
    let (store, ..) = owner(&folder).await;
    let Either::Sqlite(pool) = &store.pool else { panic!("SQLite") };
    let sql =
        format!("EXPLAIN QUERY PLAN {} WHERE r.fleet = $1 AND c.received_us >= $2 AND c.received_us < $3", by_time());
    let steps: Vec<(i64, i64, i64, String)> =
        sqlx::query_as(AssertSqlSafe(sql)).bind("lab").bind(1).bind(2).fetch_all(pool).await.unwrap();
    assert!(steps[0].3.contains("contacts_by_time (received_us>? AND received_us<?)"), "{steps:?}");
    store.close().await;
}
