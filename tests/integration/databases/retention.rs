//! Partitions are created in time, contain the right rows, and are dropped when they are old. Old rows of other tables
//! are deleted.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use sqlx::postgres::PgConnection;
use sqlx::{ConnectOptions, Connection, Executor, Row};
use vibrissa_store::batch::{
    AlarmClearedRow, AlarmRow, DecisionRow, ErrorBinRow, ErrorRow, HealthRow, Interval, Record, RefinementRow,
    SetpointRow,
};
use vibrissa_store::retention::{Done, Retention};
use vibrissa_store::series::Span;
use vibrissa_store::time::Time;
use vibrissa_store::{Batch, DatabaseAddress, Lease, Store, Writer};

use crate::rows::{self, Numbered};
use crate::{Fresh, fleet, supervisor};

const DAY_US: i64 = 86_400_000_000;
/// 2027-03-01T12:00:00Z, far from the current time in this test.
const NOON_US: i64 = 1_803_902_400_000_000;

/// A database with one robot, and the writer of its owner.
async fn taken(database: &Fresh) -> (Writer, Lease, Numbered) {
    let (a, mut writer) = (supervisor("a"), database.store.writer());
    writer.sign_in(&a, &[]).await.unwrap();
    let lease = writer.acquire(&a, &fleet()).await.unwrap().unwrap();
    let numbered = rows::robot(&mut writer, &lease).await;
    (writer, lease, numbered)
}

/// Records contacts that were made and received one second apart, beginning at this time.
async fn record(writer: &mut Writer, lease: &Lease, numbered: &Numbered, at_us: i64, count: i64) {
    let mut batch = rows::contacts(numbered, 0..count);
    for (contact, number) in batch.contacts.iter_mut().zip(0..) {
        contact.received_us = at_us + number * 1_000_000;
        contact.t_us = contact.received_us;
    }
    writer.commit(lease, &batch).await.unwrap();
}

async fn link(database: &Fresh) -> PgConnection {
    database.server.as_ref().unwrap().connect().connect().await.unwrap()
}

/// Number of contacts in each partition.
async fn partitions(link: &mut PgConnection) -> Vec<(String, i64)> {
    let names = "SELECT relname::text AS name FROM pg_inherits JOIN pg_class ON oid = inhrelid \
                 WHERE inhparent = 'contacts'::regclass ORDER BY relname";
    let mut counted = Vec::new();
    for row in link.fetch_all(names).await.unwrap() {
        let name: String = row.get("name");
        let count = sqlx::AssertSqlSafe(format!("SELECT count(*) FROM {name}"));
        counted.push((name, sqlx::query_scalar(count).fetch_one(&mut *link).await.unwrap()));
    }
    counted
}

async fn make(store: &Store, now_us: i64) -> Vec<String> {
    let mut made = Vec::new();
    store
        .make_partitions(now_us, &mut |done| match done {
            Done::Made { partition } => made.push(partition),
            Done::Indexed { .. } | Done::Dropped { .. } | Done::Removed { .. } => panic!("{done:?}"),
        })
        .await
        .unwrap();
    made
}

async fn look_after(store: &Store, days: u32, now_us: i64) -> (Vec<Done>, bool) {
    let mut reports = Vec::new();
    let retention = Retention { contacts_days: days, minutes_days: 0, black_boxes_days: 0, records_days: 0 };
    let is_more = store.look_after(retention, now_us, &mut |done| reports.push(done)).await.unwrap();
    (reports, is_more)
}

#[tokio::test]
async fn partitions_are_made_once_whoever_does_it_and_rows_are_in_the_right_one() {
    let database = Fresh::postgres().await;
    let mut link = link(&database).await;
    // Partitions of today and tomorrow exist from the start.
    let today: Vec<(String, i64)> = partitions(&mut link).await;
    assert_eq!(today.len(), 3, "{today:?}");
    let others: Vec<Store> = futures_util::future::join_all(
        (0..6).map(async |number| Store::open(&database.address, &format!("s{number}")).await.unwrap()),
    )
    .await;
    let made = futures_util::future::join_all(others.iter().map(|store| make(store, NOON_US))).await.concat();
    let expected = ["contact_minutes_20270201", "contact_minutes_20270303", "contacts_20270301", "contacts_20270302"];
    let mut sorted = made.clone();
    sorted.sort();
    assert_eq!(sorted, expected, "each partition must be made by exactly one supervisor");
    assert!(make(&database.store, NOON_US).await.is_empty());

    let (mut writer, lease, numbered) = taken(&database).await;
    for (at_us, count) in [(NOON_US, 5), (NOON_US + DAY_US, 7), (NOON_US + 2 * DAY_US, 11), (NOON_US - DAY_US / 2, 2)] {
        record(&mut writer, &lease, &numbered, at_us, count).await;
    }
    let count = |all: &[(String, i64)], name: &str| all.iter().find(|(one, _)| one == name).map(|one| one.1);
    let all = partitions(&mut link).await;
    assert_eq!((count(&all, "contacts_20270301"), count(&all, "contacts_20270302")), (Some(7), Some(7)));
    assert_eq!(count(&all, "contacts_default"), Some(11), "their day must not have a partition");
    // Creating the partition moves earlier rows of that day into it.
    assert_eq!(make(&database.store, NOON_US + DAY_US).await, ["contacts_20270303"]);
    let all = partitions(&mut link).await;
    assert_eq!((count(&all, "contacts_20270303"), count(&all, "contacts_default")), (Some(11), Some(0)));
    assert_eq!(database.store.contact_count().await.unwrap(), 25);
}

#[tokio::test]
async fn partitions_that_are_too_old_go_and_those_that_are_over_are_indexed() {
    let database = Fresh::postgres().await;
    let (mut writer, lease, numbered) = taken(&database).await;
    for day in 0..5 {
        make(&database.store, NOON_US + day * DAY_US).await;
        record(&mut writer, &lease, &numbered, NOON_US + day * DAY_US, 10).await;
    }
    // Contacts from a supervisor whose clock was wrong.
    record(&mut writer, &lease, &numbered, NOON_US - 300 * DAY_US, 12).await;
    let now_us = NOON_US + 4 * DAY_US;
    let (reports, _) = look_after(&database.store, 2, now_us).await;
    // The limit of two days before noon lies in the third partition, which therefore also has rows that are young
    // enough.
    let dropped: Vec<&str> = reports
        .iter()
        .filter_map(|done| match done {
            Done::Dropped { partition, bytes } if *bytes > 0 => Some(partition.as_str()),
            Done::Made { .. } | Done::Indexed { .. } | Done::Dropped { .. } | Done::Removed { .. } => None,
        })
        .filter(|name| name.starts_with("contacts_2027"))
        .collect();
    assert_eq!(dropped, ["contacts_20270301", "contacts_20270302"]);
    assert!(reports.contains(&Done::Removed { table: "contacts", rows: 12 }), "{reports:?}");
    for name in ["contacts_20270303", "contacts_20270304"] {
        assert!(reports.contains(&Done::Indexed { partition: name.to_owned() }), "{name} {reports:?}");
    }
    assert!(
        !reports.contains(&Done::Indexed { partition: "contacts_20270305".to_owned() }),
        "a partition that is still written must not be indexed"
    );
    let mut link = link(&database).await;
    let left: Vec<(String, i64)> = partitions(&mut link).await;
    let expected = [("contacts_20270303", 10), ("contacts_20270304", 10), ("contacts_20270305", 10)];
    let expected = expected.into_iter().chain([("contacts_20270306", 0), ("contacts_default", 0)]);
    assert_eq!(left, expected.map(|(name, count)| (name.to_owned(), count)).collect::<Vec<_>>());
    assert!(look_after(&database.store, 2, now_us).await.0.is_empty(), "a second run must have nothing to do");
    assert!(
        look_after(&database.store, 0, now_us + 1000 * DAY_US)
            .await
            .0
            .iter()
            .all(|done| matches!(done, Done::Indexed { .. }))
    );
    assert_eq!(database.store.contact_count().await.unwrap(), 30);
}

/// A long query delays dropping a partition, and no commit waits for it.
#[tokio::test]
async fn a_long_query_puts_dropping_off_and_holds_no_commit_up() {
    let database = Fresh::postgres().await;
    let (mut writer, lease, numbered) = taken(&database).await;
    make(&database.store, NOON_US).await;
    record(&mut writer, &lease, &numbered, NOON_US, 10).await;
    let mut link = link(&database).await;
    let mut reader = link.begin().await.unwrap();
    reader.execute("SELECT count(*) FROM contacts").await.unwrap();
    let retention = Retention { contacts_days: 1, minutes_days: 0, black_boxes_days: 0, records_days: 0 };
    let later_us = NOON_US + 10 * DAY_US;
    let mut reports = Vec::new();
    let mut tell = |done| reports.push(done);
    let dropping = database.store.look_after(retention, later_us, &mut tell);
    let committing = async {
        let begun = Instant::now();
        while begun.elapsed() < Duration::from_millis(600) {
            let one = Instant::now();
            record(&mut writer, &lease, &numbered, NOON_US, 1).await;
            assert!(one.elapsed() < Duration::from_secs(3), "{:?}", one.elapsed());
        }
    };
    let (dropped, ()) = tokio::join!(dropping, committing);
    let problem = dropped.unwrap_err();
    assert!(problem.is_passing() && problem.to_string().contains("lock timeout"), "{problem}");
    assert!(reports.is_empty(), "{reports:?}");
    reader.rollback().await.unwrap();
    let (reports, _) = look_after(&database.store, 1, later_us).await;
    assert!(
        reports.iter().any(|done| matches!(done, Done::Dropped { partition, .. } if partition == "contacts_20270301"))
    );
}

#[tokio::test]
async fn old_rows_of_sqlite_go_in_pieces() {
    let database = Fresh::sqlite().await;
    let (mut writer, lease, numbered) = taken(&database).await;
    // Contacts of a time at which the clock was ahead came first, and nothing behind them was deleted.
    record(&mut writer, &lease, &numbered, NOON_US + 400 * DAY_US, 2_000).await;
    record(&mut writer, &lease, &numbered, NOON_US, 12_000).await;
    record(&mut writer, &lease, &numbered, NOON_US + 10 * DAY_US, 300).await;
    let mut pieces = Vec::new();
    loop {
        let (reports, is_more) = look_after(&database.store, 7, NOON_US + 10 * DAY_US).await;
        pieces.extend(reports);
        if !is_more {
            break;
        }
    }
    let piece = |rows| Done::Removed { table: "contacts", rows };
    assert_eq!(pieces, [piece(2000), piece(2000), piece(2000), piece(2000), piece(2000), piece(2000)]);
    assert_eq!(database.store.contact_count().await.unwrap(), 2_300);
    assert!(make(&database.store, NOON_US).await.is_empty());
}

/// The latest contacts are found in any partition, with and without an index.
async fn newest(database: &Fresh) {
    let (mut writer, lease, numbered) = taken(database).await;
    for day in 0..4 {
        make(&database.store, NOON_US + day * DAY_US).await;
        record(&mut writer, &lease, &numbered, NOON_US + day * DAY_US, 300).await;
    }
    look_after(&database.store, 0, NOON_US + 3 * DAY_US).await;
    let times: Vec<i64> =
        (0..4).flat_map(|day| (0..300).map(move |n| NOON_US + day * DAY_US + n * 1_000_000)).collect();
    let whisker_id = numbered.whisker_ids[0];
    for points in [1, 200, 301, 900, 2000] {
        let span = Span { from: None, to: None, points };
        let series = database.store.contacts(whisker_id, span).await.unwrap();
        let newest = &times[times.len().saturating_sub(points as usize)..];
        assert_eq!(series.items.iter().map(|one| one.at_us).collect::<Vec<_>>(), newest, "{points}");
    }
    let span = Span { from: Some(Time(NOON_US)), to: Some(Time(NOON_US + DAY_US + 10_000_000)), points: 2000 };
    let series = database.store.contacts(whisker_id, span).await.unwrap();
    assert_eq!(series.items.iter().map(|one| one.at_us).collect::<Vec<_>>(), times[..310]);
}

#[tokio::test]
async fn brute_force_the_newest_contacts_of_sqlite() {
    newest(&Fresh::sqlite().await).await;
}

#[tokio::test]
async fn brute_force_the_newest_contacts_of_postgres() {
    newest(&Fresh::postgres().await).await;
}

/// Old alarms go once they are cleared; those that stand stay.
async fn old_records_go(database: Fresh) {
    let (mut writer, lease, numbered) = taken(&database).await;
    let whisker_id = numbered.whisker_ids[0];
    let kind = "LEAK";
    let change = |recorded_us| {
        Record::Health(HealthRow { whisker_id, recorded_us, kind: "FAULT", was: None, becomes: Some(kind) })
    };
    let alarm = |raised_us| Record::Alarm(AlarmRow { whisker_id, raised_us, kind });
    let cleared = |cleared_us| Record::AlarmCleared(AlarmClearedRow { whisker_id, cleared_us, kind });
    let setpoint = |version, issued_us| {
        Record::Setpoint(Box::new(SetpointRow {
            command_id: format!("c{version}"),
            robot_id: numbered.robot_id,
            whisker_id,
            compensation_id: None,
            epoch: 1,
            version,
            robot_boot_id: "b".to_owned(),
            pressure_mpa: 0.1,
            slew_mpa_per_s: 0.02,
            issued_us,
            expires_us: issued_us + 1,
            reason: "RELEASE",
            gain: None,
        }))
    };
    let mut records =
        vec![change(NOON_US), alarm(NOON_US), cleared(NOON_US + 1), change(NOON_US + 9 * DAY_US), alarm(NOON_US + 2)];
    records.extend([setpoint(1, NOON_US), setpoint(2, NOON_US + 9 * DAY_US)]);
    writer.commit(&lease, &Batch { records, ..Batch::default() }).await.unwrap();
    let retention = Retention { contacts_days: 0, minutes_days: 0, black_boxes_days: 0, records_days: 5 };
    let mut reports = Vec::new();
    database.store.look_after(retention, NOON_US + 10 * DAY_US, &mut |done| reports.push(done)).await.unwrap();
    reports.retain(|done| matches!(done, Done::Removed { .. }));
    let removed = |table| Done::Removed { table, rows: 1 };
    let expected = ["alarms", "health_changes", "setpoint_states", "setpoints"].map(removed);
    assert_eq!(reports, expected, "the alarm that stands is kept");
}

#[tokio::test]
async fn old_records_of_sqlite_go_when_they_are_over() {
    old_records_go(Fresh::sqlite().await).await;
}

#[tokio::test]
async fn old_records_of_postgres_go_when_they_are_over() {
    old_records_go(Fresh::postgres().await).await;
}

/// Boots that were seen a day before the oldest contact go, except the newest four of them.
async fn former_boots_go(database: Fresh) {
    let (mut writer, lease, numbered) = taken(&database).await;
    let (robot_id, now_us) = (numbered.robot_id, NOON_US);
    let boots_at = async |writer: &mut Writer, name: &str, at_us: i64, count: i64| {
        for number in 0..count {
            writer.boot(&lease, robot_id, &format!("{name}-{number}"), at_us + number).await.unwrap();
        }
    };
    // "b1" of the rows is from 1970; more than one piece follows it.
    boots_at(&mut writer, "old", now_us - 40 * DAY_US, 2100).await;
    let last_old = writer.boot(&lease, numbered.robot_id, "old-2099", 0).await.unwrap();
    boots_at(&mut writer, "young", now_us - 9 * DAY_US, 6).await;
    let touched = Numbered { boot: last_old, ..numbered };
    make(&database.store, now_us - 10 * DAY_US).await;
    record(&mut writer, &lease, &touched, now_us - 10 * DAY_US, 3).await;
    let left = async |database: &Fresh| -> Vec<String> {
        let sql = "SELECT boot_id FROM boots ORDER BY boot";
        match &database.server {
            Some(_) => sqlx::query_scalar(sql).fetch_all(&mut link(database).await).await.unwrap(),
            None => {
                let DatabaseAddress::Sqlite(path) = &database.address else { panic!("SQLite") };
                let mut link = sqlx::sqlite::SqliteConnectOptions::new().filename(path).connect().await.unwrap();
                sqlx::query_scalar(sql).fetch_all(&mut link).await.unwrap()
            }
        }
    };
    let removed = async |days: u32, now_us: i64| {
        let (told, _) = look_after(&database.store, days, now_us).await;
        let rows = |done: &Done| match done {
            Done::Removed { table: "boots", rows } => *rows,
            Done::Made { .. } | Done::Indexed { .. } | Done::Dropped { .. } | Done::Removed { .. } => 0,
        };
        told.iter().map(rows).sum::<u64>()
    };
    assert_eq!(removed(0, now_us).await, 0, "the robot's state was not stored since: the journal may refer to them");
    writer.commit(&lease, &states_at(&touched, now_us)).await.unwrap();
    assert_eq!([removed(0, now_us).await, removed(0, now_us).await, removed(0, now_us).await], [2000, 97, 0]);
    let old = (2096..2100).map(|number| format!("old-{number}"));
    let young = (0..6).map(|number| format!("young-{number}"));
    assert_eq!(left(&database).await, old.chain(young).collect::<Vec<_>>(), "the touched one is there");
    // Once the contacts have gone, those before the newest four go, too.
    assert_eq!([removed(5, now_us).await, removed(5, now_us).await], [0, 6]);
    assert_eq!(left(&database).await, ["young-2", "young-3", "young-4", "young-5"]);
}

/// Checkpoints at this time.
fn states_at(numbered: &Numbered, at_us: i64) -> Batch {
    let mut batch = rows::states(numbered);
    batch.robots.iter_mut().for_each(|robot| robot.updated_us = at_us);
    batch
}

#[tokio::test]
async fn regress_former_boots_go_from_sqlite() {
    former_boots_go(Fresh::sqlite().await).await;
}

#[tokio::test]
async fn regress_former_boots_go_from_postgres() {
    former_boots_go(Fresh::postgres().await).await;
}

/// Measurements of a compensation in force come every hundred contacts. They had no retention.
async fn old_measurements_go(database: Fresh) {
    let (mut writer, lease, numbered) = taken(&database).await;
    let whisker_id = numbered.whisker_ids[0];
    let one = |mean: f64| Interval { mean, low: mean, high: mean };
    let of = |number: i64, days: &[i64]| -> Vec<Record> {
        let compensation_id = numbered.robot_id << 32 | number;
        let decision = DecisionRow {
            compensation_id,
            robot_id: numbered.robot_id,
            target_whisker_id: whisker_id,
            target_length_mm: 70.0,
            target_pressure_mpa: 0.1,
            decided_us: NOON_US,
            approval: "AUTOMATIC",
            candidates: Vec::new(),
        };
        let bin = |ratio| ErrorBinRow {
            ratio,
            contacts: 9,
            after_per_mm: 0.004,
            before_per_mm: 0.003,
            before_origin: "MEASURED",
            target_per_mm: 0.0035,
            target_origin: "MODEL",
            error: one(0.2),
        };
        let measured = |&day: &i64| {
            let error = ErrorRow {
                compensation_id,
                recorded_us: NOON_US + day * DAY_US,
                contacts: 100,
                pressure_mpa: 0.05,
                error: one(0.2),
                with_gain: None,
                air_error: None,
                bins: [0.5, 0.9].map(bin).to_vec(),
            };
            let look = RefinementRow {
                compensation_id,
                recorded_us: error.recorded_us,
                contacts: 200,
                outcome: "HELD_MARGIN",
                pressure_from_mpa: 0.05,
                pressure_best_mpa: None,
                error: one(0.2),
                error_best: None,
                error_with_gain: 0.1,
                error_with_own_gain: 0.1,
                gain_published: false,
            };
            [Record::Error(Box::new(error)), Record::Refinement(Box::new(look))]
        };
        std::iter::once(Record::Decision(Box::new(decision))).chain(days.iter().flat_map(measured)).collect()
    };
    // One with young measurements, and one whose newest is old.
    let records = [of(1, &[0, 1, 2, 9]), of(2, &[0, 1])].concat();
    writer.commit(&lease, &Batch { records, ..Batch::default() }).await.unwrap();
    let retention = Retention { contacts_days: 0, minutes_days: 0, black_boxes_days: 0, records_days: 5 };
    for rows in [[8, 4, 4], [0; 3]] {
        let mut told = Vec::new();
        database.store.look_after(retention, NOON_US + 10 * DAY_US, &mut |done| told.push(done)).await.unwrap();
        let tables = ["compensation_error_bins", "compensation_errors", "compensation_refinements"];
        let removed = tables.into_iter().zip(rows).filter(|(_, rows)| *rows > 0);
        let removed: Vec<Done> = removed.map(|(table, rows)| Done::Removed { table, rows }).collect();
        told.retain(|done| matches!(done, Done::Removed { .. }));
        assert_eq!(told, removed, "the newest of each compensation is kept");
    }
}

#[tokio::test]
async fn regress_old_measurements_of_compensations_in_force_go_from_sqlite() {
    old_measurements_go(Fresh::sqlite().await).await;
}

#[tokio::test]
async fn regress_old_measurements_of_compensations_in_force_go_from_postgres() {
    old_measurements_go(Fresh::postgres().await).await;
}

/// Whiskers that a layout has left out go after a day, unless they were touched.
async fn unused_whiskers_go(database: Fresh) {
    let (mut writer, lease, numbered) = taken(&database).await;
    // The newest whisker stays.
    rows::numbered(&mut writer, &lease, "other").await;
    record(&mut writer, &lease, &numbered, NOON_US, 1).await;
    let change = HealthRow {
        whisker_id: numbered.whisker_ids[1],
        recorded_us: NOON_US,
        kind: "FAULT",
        was: None,
        becomes: Some("STALE"),
    };
    let empty = Batch { whiskers: Vec::new(), records: vec![Record::Health(change)], ..rows::states(&numbered) };
    writer.commit(&lease, &empty).await.unwrap();
    let retention = Retention { contacts_days: 0, minutes_days: 0, black_boxes_days: 0, records_days: 0 };
    let now_us = vibrissa_edge::clock::wall_clock().0 as i64;
    let mut reports = Vec::new();
    for (later_us, gone) in [(DAY_US / 2, 0), (2 * DAY_US, 1), (2 * DAY_US, 0)] {
        reports.clear();
        database.store.look_after(retention, now_us + later_us, &mut |done| reports.push(done)).await.unwrap();
        let removed = reports.iter().filter(|done| matches!(done, Done::Removed { table: "whiskers", rows: 1 }));
        assert_eq!(removed.count(), gone, "{reports:?}");
    }
    // The touched one has its number still. Nobody gets the number of the other one, which has no row left.
    let again = rows::numbered(&mut writer, &lease, "r").await.whisker_ids;
    assert_eq!(again[0], numbered.whisker_ids[0]);
    assert_ne!(again[1], numbered.whisker_ids[1]);
}

/// An owner puts a whisker on a layout again at the moment of its removal. It was removed nevertheless.
#[tokio::test]
async fn regress_a_whisker_that_comes_back_is_not_removed() {
    let database = Fresh::postgres().await;
    let (mut writer, lease, numbered) = taken(&database).await;
    let newest = rows::numbered(&mut writer, &lease, "other").await.whisker_ids[1];
    let mut other = link(&database).await;
    let sql = format!("UPDATE whiskers SET position = NULL, absent_us = 1 WHERE whisker_id <> {newest}");
    other.execute(sqlx::AssertSqlSafe(sql)).await.unwrap();
    let mut owner = other.begin().await.unwrap();
    let back = format!("UPDATE whiskers SET absent_us = NULL WHERE whisker_id = {}", numbered.whisker_ids[0]);
    owner.execute(sqlx::AssertSqlSafe(back)).await.unwrap();
    let is_over = AtomicBool::new(false);
    let removing = async {
        look_after(&database.store, 0, NOON_US).await;
        is_over.store(true, Ordering::Relaxed);
    };
    let mut watch = link(&database).await;
    let coming_back = async {
        let waits = "SELECT count(*) FROM pg_stat_activity WHERE wait_event_type = 'Lock'";
        loop {
            let waiting: i64 = sqlx::query_scalar(waits).fetch_one(&mut watch).await.unwrap();
            if waiting > 0 || is_over.load(Ordering::Relaxed) {
                break owner.commit().await.unwrap();
            }
        }
    };
    tokio::join!(removing, coming_back);
    let left = "SELECT whisker_id FROM whiskers ORDER BY whisker_id";
    let left: Vec<i64> = sqlx::query_scalar(left).fetch_all(&mut watch).await.unwrap();
    assert!(left.contains(&numbered.whisker_ids[0]) && !left.contains(&numbered.whisker_ids[1]), "{left:?}");
}

#[tokio::test]
async fn regress_unused_whiskers_of_former_layouts_go_from_sqlite() {
    unused_whiskers_go(Fresh::sqlite().await).await;
}

#[tokio::test]
async fn regress_unused_whiskers_of_former_layouts_go_from_postgres() {
    unused_whiskers_go(Fresh::postgres().await).await;
}
