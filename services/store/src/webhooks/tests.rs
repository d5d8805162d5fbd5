use std::time::Duration;

use sqlx::AssertSqlSafe;

use super::{DEAD_LETTERS_MAX, dead, now_us_of};
use crate::database::Either;
use crate::sqlite::tests::Folder;
use crate::{DatabaseAddress, Store};

const HOUR_US: i64 = 3_600_000_000;

/// A database with a target that wants all events, and with some events.
async fn target(folder: &Folder, events: i64) -> Store {
    const WEBHOOK: &str = "INSERT INTO webhooks (webhook_id, name, url, level, enabled, secret, created_us, changed_us, \
         changed_by, done_tx, done_event) VALUES (1, 'n', 'mailto:a@example.org', 'NOTICE', 1, x'00', 0, 0, 'a', 0, 0)";
    let store = Store::open(&DatabaseAddress::Sqlite(folder.file()), "test").await.unwrap();
    store.prepare().await.unwrap();
    let rows = format!(
        "{WEBHOOK}; WITH RECURSIVE n (i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < {events}) INSERT INTO events \
         (fleet, kind, audience, recorded_us, version, data) SELECT 'f', 'TRIM', 'PEOPLE', i, 2, '{{}}' FROM n"
    );
    run(&store, rows).await;
    store
}

async fn run(store: &Store, sql: String) {
    let Either::Sqlite(pool) = &store.pool else { panic!("SQLite") };
    sqlx::raw_sql(AssertSqlSafe(sql)).execute(pool).await.unwrap();
}

/// A mail was postponed by a minute while the clock was ahead by three hours. Nobody got a mail for three hours.
#[tokio::test]
async fn regress_a_postponed_mail_does_not_wait_for_a_clock_that_went_back() {
    let folder = Folder::new();
    let store = target(&folder, 1).await;
    let now_us = now_us_of(&store.pool).await.unwrap();
    // A postponed mail; a step of the clock; pauses after failed attempts.
    for (next_us, streak, is_due) in [
        (now_us + HOUR_US / 6, 0, false),
        (now_us + 3 * HOUR_US, 0, true),
        (now_us + 3 * HOUR_US, 1, false),
        (now_us + HOUR_US / 6, 1, false),
    ] {
        run(&store, format!("UPDATE webhooks SET next_us = {next_us}, streak = {streak}, last_us = 1")).await;
        let due = store.due_webhooks("s", Duration::from_secs(1)).await.unwrap();
        assert_eq!(due == [1], is_due, "{streak} failed attempts, {next_us}");
    }
    store.close().await;
}

/// After a time at which the clock was ahead, each new dead letter was deleted at once.
#[tokio::test]
async fn regress_the_letters_of_the_newest_events_stay() {
    let folder = Folder::new();
    let store = target(&folder, DEAD_LETTERS_MAX + 1).await;
    let letters = format!(
        "INSERT INTO webhook_dead_letters (webhook_id, event_id, attempts, dead_us, problem) \
         SELECT 1, event_id, 1, CASE WHEN event_id > {DEAD_LETTERS_MAX} THEN 1 ELSE {HOUR_US} END, '' FROM events"
    );
    run(&store, letters).await;
    let mut tx = store.pool.begin().await.unwrap();
    dead::keep_newest(&mut tx, 1).await.unwrap();
    tx.commit().await.unwrap();
    let Either::Sqlite(pool) = &store.pool else { panic!("SQLite") };
    let left: (i64, i64, i64) =
        sqlx::query_as("SELECT min(event_id), max(event_id), (SELECT lost FROM webhooks) FROM webhook_dead_letters")
            .fetch_one(pool)
            .await
            .unwrap();
    assert_eq!(left, (2, DEAD_LETTERS_MAX + 1, 1));
    store.close().await;
}
