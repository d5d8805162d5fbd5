//! Old rows of every table go, whatever times the rows around them have.

use std::collections::BTreeMap;

use sqlx::sqlite::SqliteConnection;
use sqlx::{AssertSqlSafe, Connection as _, SqlSafeStr as _};

use super::records::{RECORDS, removal};
use super::tables::{Kept, TABLES};
use super::{DAY_US, Done, OLD_CONTACTS, OLD_MINUTES, ROWS, Retention};
use crate::database::Either;
use crate::sqlite::tests::Folder;
use crate::{DatabaseAddress, Store};

/// The time 2027-03-01T12:00:00Z, µs since 1970 UTC.
const NOON_US: i64 = 1_803_902_400_000_000;
const NOW_US: i64 = NOON_US + 10 * DAY_US;
const RETENTION: Retention = Retention { contacts_days: 5, minutes_days: 5, black_boxes_days: 5, records_days: 5 };

/// Number of the first old row; those of all other rows are less than half of it.
const OLD: i64 = 1_000_000;
/// Number of old rows.
const OLD_ROWS: i64 = 300;

/// A new database, and a connection that checks no keys and constraints.
async fn unchecked(folder: &Folder) -> (Store, SqliteConnection) {
    let store = Store::open(&DatabaseAddress::Sqlite(folder.file()), "test").await.unwrap();
    store.prepare().await.unwrap();
    let Either::Sqlite(mut link) = store.options.connect("test").await.unwrap() else { panic!("SQLite") };
    run(&mut link, "PRAGMA foreign_keys = OFF; PRAGMA ignore_check_constraints = ON").await;
    (store, link)
}

async fn run(link: &mut SqliteConnection, sql: &str) {
    sqlx::raw_sql(AssertSqlSafe(sql).into_sql_str()).execute(link).await.unwrap();
}

/// The tables that keep their rows for some days.
fn tables() -> Vec<&'static str> {
    TABLES.iter().filter(|(_, kept)| matches!(kept, Kept::Days(_))).map(|(table, _)| *table).collect()
}

/// Columns of a table, each with its type and whether it may be NULL.
async fn columns(link: &mut SqliteConnection, table: &str) -> Vec<(String, String, bool)> {
    const SQL: &str = "SELECT name, type, NOT \"notnull\" AND NOT pk FROM pragma_table_info($1)";
    sqlx::query_as(SQL).bind(table).fetch_all(link).await.unwrap()
}

/// Adds rows with successive numbers to a table. All their times are `at_us` or little later; without an end, those that may be
/// NULL are NULL. Two rows belong to a compensation.
async fn add(link: &mut SqliteConnection, table: &str, (first, rows): (i64, i64), at_us: i64, is_over: bool) {
    let value = |(name, kind, may_lack): &(String, String, bool)| match (name.as_str(), kind.as_str()) {
        (name, _) if name.ends_with("_us") && *may_lack && !is_over => "NULL".to_owned(),
        (name, _) if name.ends_with("_us") => format!("{at_us} + n"),
        ("compensation_id", _) if table != "compensations" => "number / 2".to_owned(),
        (_, "TEXT") => "'t' || number".to_owned(),
        (_, "BLOB") => "x'00'".to_owned(),
        (_, "REAL") => "0.5".to_owned(),
        _ => "number".to_owned(),
    };
    let columns = columns(link, table).await;
    let names: Vec<String> = columns.iter().map(|(name, ..)| format!("\"{name}\"")).collect();
    let values: Vec<String> = columns.iter().map(value).collect();
    let sql = format!(
        "WITH RECURSIVE c (n) AS (SELECT 0 UNION ALL SELECT n + 1 FROM c WHERE n + 1 < {rows}), \
         r (n, number) AS (SELECT n, {first} + n FROM c) INSERT INTO {table} ({}) SELECT {} FROM r",
        names.join(", "),
        values.join(", ")
    );
    run(link, &sql).await;
}

/// Adds rows to all tables, with the compensations that they belong to.
async fn add_all(link: &mut SqliteConnection, (first, rows): (i64, i64), at_us: i64, is_over: bool) {
    run(link, "BEGIN").await;
    add(link, "compensations", (first / 2, rows / 2 + 1), at_us, is_over).await;
    for table in tables() {
        add(link, table, (first, rows), at_us, is_over).await;
    }
    run(link, "COMMIT").await;
}

/// Number of old rows in each table.
async fn old_rows(link: &mut SqliteConnection) -> BTreeMap<&'static str, i64> {
    let mut counted = BTreeMap::new();
    for table in tables() {
        let columns = columns(link, table).await;
        let number = columns.iter().find(|(name, kind, _)| kind == "INTEGER" && !name.ends_with("_us"));
        let sql = format!("SELECT count(*) FROM {table} WHERE {} >= {}", number.unwrap().0, OLD / 2);
        counted.insert(table, sqlx::query_scalar(AssertSqlSafe(sql)).fetch_one(&mut *link).await.unwrap());
    }
    counted
}

/// Number of old rows that are left in each table of a database with other rows, whose numbers are lower.
async fn left(others: &[(i64, i64, bool)]) -> BTreeMap<&'static str, i64> {
    let folder = Folder::new();
    let (store, mut link) = unchecked(&folder).await;
    for &(first, at_us, is_over) in others {
        add_all(&mut link, (first, ROWS + 1), at_us, is_over).await;
    }
    add_all(&mut link, (OLD, OLD_ROWS), NOON_US, true).await;
    assert!(old_rows(&mut link).await.values().all(|rows| *rows == OLD_ROWS));
    for _ in 0..50 {
        if !store.look_after(RETENTION, NOW_US, &mut |_| {}).await.unwrap() {
            break;
        }
    }
    let left = old_rows(&mut link).await;
    link.close().await.unwrap();
    store.close().await;
    left
}

/// A table whose oldest numbers are looked at first keeps all rows behind some thousand that are young, or not over.
#[tokio::test]
async fn regress_rows_that_stay_keep_no_old_rows_in_any_table() {
    let alone = left(&[]).await;
    assert!(alone.values().all(|rows| *rows <= OLD_ROWS / 2 + 1), "{alone:?}");
    // The clock was ahead by a year; it was ahead by some days, and this time has come; the rows before all others are not over.
    let others =
        [(1, NOON_US + 400 * DAY_US, true), (10_000, NOW_US - DAY_US, true), (20_000, NOON_US - DAY_US, false)];
    assert_eq!(left(&others).await, alone);
}

/// Without an index of the time, each deletion reads a whole table while it locks the database for all others.
#[tokio::test]
async fn regress_no_deletion_reads_a_whole_table_but_that_of_decisions() {
    let folder = Folder::new();
    let (store, mut link) = unchecked(&folder).await;
    let records = RECORDS.map(|(table, which)| removal(table, which, "rowid"));
    for sql in records.into_iter().chain([OLD_CONTACTS.to_owned(), OLD_MINUTES.to_owned()]) {
        let explained = AssertSqlSafe(format!("EXPLAIN QUERY PLAN {sql}"));
        let steps: Vec<(i64, i64, i64, String)> =
            sqlx::query_as(explained).bind(NOW_US).bind(ROWS).fetch_all(&mut link).await.unwrap();
        for (.., step) in steps {
            // The decisions.
            assert!(!step.starts_with("SCAN") || step == "SCAN c" || step.starts_with("SCAN c "), "{step}: {sql}");
        }
    }
    store.close().await;
}

/// The page of a compensation shows the measurement and the evaluation with the highest number.
#[tokio::test]
async fn regress_the_newest_measurement_stays_after_a_time_at_which_the_clock_was_ahead() {
    let folder = Folder::new();
    let (store, mut link) = unchecked(&folder).await;
    add(&mut link, "compensations", (0, 1), NOON_US, false).await;
    for table in ["compensation_errors", "compensation_refinements"] {
        for (number, at_us) in [(1, NOON_US + 400 * DAY_US), (2, NOON_US), (3, NOON_US + 1)] {
            add(&mut link, table, (number, 1), at_us, true).await;
        }
        run(&mut link, &format!("UPDATE {table} SET compensation_id = 0")).await;
    }
    let mut told = Vec::new();
    store.look_after(RETENTION, NOW_US, &mut |done| told.push(done)).await.unwrap();
    let removed = |table| Done::Removed { table, rows: 1 };
    assert_eq!(told, ["compensation_errors", "compensation_refinements"].map(removed));
    let left: Vec<i64> = sqlx::query_scalar("SELECT compensation_error_id FROM compensation_errors ORDER BY 1")
        .fetch_all(&mut link)
        .await
        .unwrap();
    assert_eq!(left, [1, 3]);
    store.close().await;
}

/// The contact with the lowest number was taken for the oldest one.
#[tokio::test]
async fn regress_boots_of_contacts_stay_after_a_time_at_which_the_clock_was_ahead() {
    let folder = Folder::new();
    let (store, mut link) = unchecked(&folder).await;
    add(&mut link, "robots", (1, 1), NOW_US, true).await;
    add(&mut link, "contacts", (1, 1), NOON_US + 400 * DAY_US, true).await;
    for day in 0..7 {
        add(&mut link, "boots", (10 + day, 1), NOON_US + day * DAY_US, true).await;
        add(&mut link, "contacts", (10 + day, 1), NOON_US + day * DAY_US, true).await;
    }
    run(&mut link, "UPDATE boots SET robot_id = 1").await;
    let mut told = Vec::new();
    store.look_after(Retention { contacts_days: 30, ..RETENTION }, NOW_US, &mut |done| told.push(done)).await.unwrap();
    assert!(told.is_empty(), "{told:?}");
    store.close().await;
}

/// A robot without an end of its compensation adds a row at each contact.
#[tokio::test]
async fn regress_old_responses_of_compensations_in_force_go() {
    let folder = Folder::new();
    let (store, mut link) = unchecked(&folder).await;
    add(&mut link, "compensations", (0, 1), NOON_US, false).await;
    for (at_us, rows) in [(NOW_US - 7 * DAY_US, 3), (NOW_US - 5 * DAY_US - DAY_US / 2, 2), (NOW_US, 4)] {
        add(&mut link, "compensation_responses", (0, rows), at_us, true).await;
    }
    run(&mut link, "UPDATE compensation_responses SET compensation_id = 0").await;
    let mut told = Vec::new();
    store.look_after(RETENTION, NOW_US, &mut |done| told.push(done)).await.unwrap();
    assert_eq!(told, [Done::Removed { table: "compensation_responses", rows: 3 }], "a day more, by the robot's clock");
    store.close().await;
}

/// SQLite gives the highest number again once its row has gone: an event of a week ago named the whisker of another robot then.
#[tokio::test]
async fn regress_numbers_of_removed_whiskers_and_alarms_are_not_given_again() {
    let folder = Folder::new();
    let (store, mut link) = unchecked(&folder).await;
    add(&mut link, "arrays", (1, 4), NOON_US, true).await;
    add(&mut link, "whiskers", (1, 4), NOON_US, true).await;
    run(&mut link, "UPDATE whiskers SET position = NULL WHERE whisker_id > 1").await;
    // The newest alarm is of whisker 3, and over.
    add(&mut link, "alarms", (1, 3), NOON_US, true).await;
    run(&mut link, "UPDATE alarms SET robot_id = NULL").await;
    while store.look_after(RETENTION, NOW_US, &mut |_| {}).await.unwrap() {}
    let numbers = async |link: &mut SqliteConnection, sql: &'static str| -> Vec<i64> {
        sqlx::query_scalar(sql).fetch_all(link).await.unwrap()
    };
    assert_eq!(numbers(&mut link, "SELECT whisker_id FROM whiskers ORDER BY 1").await, [1, 3, 4]);
    assert_eq!(numbers(&mut link, "SELECT alarm_id FROM alarms ORDER BY 1").await, [3]);
    store.close().await;
}
