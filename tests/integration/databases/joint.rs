//! Batches of several shards in one transaction.

use std::time::Duration;

use serde_json::Value;
use sqlx::ConnectOptions;
use vibrissa_edge::shard::FleetShard;
use vibrissa_store::batch::JournalRow;
use vibrissa_store::{Batch, Lease, StoreError, Supervisor, Writer};
use vibrissa_tests::postgres::Postgres;
use vibrissa_tests::proxy::Proxy;
use vibrissa_tests::wait::until_true;

use crate::contract::records;
use crate::rows::{self, Numbered, contacts};
use crate::supervisors::Stage;
use crate::{Fresh, fleet, supervisor};

/// Number of shards.
const SHARDS: u32 = 3;
/// Contacts of each shard that make a joint batch so large that `COPY` writes them. One shard's are not.
const COPIED: i64 = 700;

/// A robot in each shard of a fleet that `a` owns.
async fn robots(writer: &mut Writer, a: &Supervisor) -> Vec<(Lease, Numbered)> {
    writer.sign_in(a, &[]).await.unwrap();
    let whole = writer.acquire(a, &fleet()).await.unwrap().unwrap();
    writer.want_shards(&fleet(), SHARDS).await.unwrap();
    writer.divide(std::slice::from_ref(&whole), SHARDS).await.unwrap().unwrap();
    let mut all = Vec::new();
    for shard in FleetShard::all(&fleet(), SHARDS) {
        let lease = writer.acquire_shard(a, &shard).await.unwrap().unwrap();
        let name = (0..).map(|number| format!("r{number}")).find(|name| shard.has(name)).unwrap();
        let robot = rows::numbered(writer, &lease, &name).await;
        writer.commit(&lease, &rows::states(&robot)).await.unwrap();
        all.push((lease, robot));
    }
    all
}

/// Rows of all kinds that one statement can write.
fn steps(robot: &Numbered) -> Vec<Batch> {
    let states = Batch { layouts: Vec::new(), ..rows::states(robot) };
    let journal = |number| Some(JournalRow { number, entries: vec![number as u8; 5] });
    let mut steps = vec![
        Batch { journal: journal(1), ..contacts(robot, 0..COPIED) },
        Batch { journal: journal(2), journal_done: Some(1), ..states },
    ];
    steps.extend(records(robot).into_iter().map(|record| Batch { records: vec![record], ..Batch::default() }));
    steps.retain(Batch::fits_one_statement);
    steps
}

/// The rows of a table as JSON without the numbers that the database gives, in the order of their text.
async fn rows_of(database: &Fresh, table: &str, numbers: &[&str]) -> Vec<String> {
    let mut link = database.server.as_ref().unwrap().connect().connect().await.unwrap();
    let sql = format!("SELECT to_jsonb(t)::text FROM {table} t");
    let rows: Vec<String> = sqlx::query_scalar(sqlx::AssertSqlSafe(sql)).fetch_all(&mut link).await.unwrap();
    let mut texts = Vec::new();
    for row in rows {
        let mut row: Value = serde_json::from_str(&row).unwrap();
        let columns = row.as_object_mut().unwrap();
        numbers.iter().for_each(|number| drop(columns.remove(*number)));
        texts.push(row.to_string());
    }
    texts.sort();
    texts
}

#[tokio::test]
async fn property_batches_written_together_leave_the_rows_of_batches_written_one_by_one() {
    let (together, single) = (Fresh::postgres().await, Fresh::postgres().await);
    let a = supervisor("a");
    for (database, is_together) in [(&together, true), (&single, false)] {
        let mut writer = database.store.writer();
        let robots = robots(&mut writer, &a).await;
        let all: Vec<Vec<Batch>> = robots.iter().map(|(_, robot)| steps(robot)).collect();
        assert!(all[0].len() > 20, "{}", all[0].len());
        for step in 0..all[0].len() {
            if is_together {
                let batches: Vec<_> =
                    robots.iter().zip(&all).map(|((lease, _), steps)| (lease, &steps[step])).collect();
                assert!(writer.commit_together(&batches).await.unwrap());
            } else {
                for ((lease, _), steps) in robots.iter().zip(&all) {
                    writer.commit(lease, &steps[step]).await.unwrap();
                }
            }
        }
    }
    let tables: [(&str, &[&str]); 15] = [
        ("contacts", &[]),
        ("journal", &[]),
        ("robots", &[]),
        ("whiskers", &[]),
        ("health_changes", &["health_change_id"]),
        ("trims", &[]),
        ("compensations", &[]),
        ("compensation_candidates", &[]),
        ("compensation_errors", &["compensation_error_id"]),
        ("compensation_error_bins", &["compensation_error_id"]),
        ("compensation_refinements", &["compensation_refinement_id"]),
        ("setpoints", &[]),
        ("setpoint_states", &["setpoint_state_id"]),
        ("alarms", &["alarm_id"]),
        ("leases", &["epoch", "expires_us"]),
    ];
    for (table, numbers) in tables {
        let rows = rows_of(&together, table, numbers).await;
        assert!(!rows.is_empty(), "{table}");
        assert_eq!(rows, rows_of(&single, table, numbers).await, "{table}");
    }
}

/// `each` is the number of contacts of each batch.
async fn nothing_is_written_together(each: i64) {
    let database = Fresh::postgres().await;
    let (a, b) = (supervisor("a"), supervisor("b"));
    let (mut writer, mut other) = (database.store.writer(), database.store.writer());
    let robots = robots(&mut writer, &a).await;
    let leases: Vec<Lease> = robots.iter().map(|(lease, _)| lease.clone()).collect();
    writer.release(&leases[1]).await.unwrap();
    other.sign_in(&b, &[]).await.unwrap();
    other.acquire_shard(&b, leases[1].shard()).await.unwrap().unwrap();

    let batches: Vec<Batch> = robots.iter().map(|(_, robot)| contacts(robot, 0..each)).collect();
    let all: Vec<_> = leases.iter().zip(&batches).collect();
    assert!(!writer.commit_together(&all).await.unwrap());
    assert_eq!(database.store.contact_count().await.unwrap(), 0);
    for (number, (lease, batch)) in all.iter().enumerate() {
        let written = writer.commit(lease, batch).await;
        match number {
            1 => assert!(matches!(written, Err(StoreError::LeaseLost { .. })), "{written:?}"),
            _ => written.unwrap(),
        }
    }
    assert_eq!(database.store.contact_count().await.unwrap(), 2 * each);
    let owned = [all[0], all[2]];
    let next: Vec<Batch> = [0, 2].iter().map(|&at| contacts(&robots[at].1, each..each + 2)).collect();
    let next: Vec<_> = owned.iter().zip(&next).map(|((lease, _), batch)| (*lease, batch)).collect();
    assert!(writer.commit_together(&next).await.unwrap(), "the others still write together");
    assert_eq!(database.store.contact_count().await.unwrap(), 2 * each + 4);
}

#[tokio::test]
async fn nothing_is_written_together_if_one_shard_has_another_owner() {
    nothing_is_written_together(3).await;
}

#[tokio::test]
async fn nothing_is_copied_together_if_one_shard_has_another_owner() {
    nothing_is_written_together(COPIED).await;
}

/// The answer to a joint commit is lost at every moment of it. Then each shard commits on its own, and each batch is stored
/// once. `each` is the number of contacts of each batch; a commit takes up to 150 times `step`.
async fn without_an_answer(each: i64, step: Duration) {
    let database = Fresh::postgres().await;
    let proxy = Proxy::to(database.server.as_ref().unwrap().port()).await;
    let address = Postgres::url(proxy.port()).parse().unwrap();
    let through = vibrissa_store::Store::open(&address, "through").await.unwrap();
    let mut a = supervisor("a");
    a.time_to_live = Duration::from_secs(60);
    let mut writer = through.writer();
    let robots = robots(&mut writer, &a).await;
    let (mut failures, mut written_before) = (0, 0);
    for seq in 0..1500 {
        if seq >= 150 && written_before > 0 {
            break;
        }
        let batches: Vec<Batch> =
            robots.iter().map(|(_, robot)| contacts(robot, seq * each..(seq + 1) * each)).collect();
        let all: Vec<_> = robots.iter().map(|(lease, _)| lease).zip(&batches).collect();
        // The link is cut at a different moment of each commit.
        let cut = async {
            tokio::time::sleep(step * (seq as u32 % 150)).await;
            proxy.cut();
        };
        let (tried, ()) = tokio::join!(writer.commit_together(&all), cut);
        if !tried.as_ref().is_ok_and(|is_written| *is_written) {
            failures += 1;
            for (at, (lease, batch)) in all.iter().enumerate() {
                while writer.commit(lease, batch).await.is_err() {}
                let is_whole = database.store.contact_count().await.unwrap() == (seq + 1) * each * i64::from(SHARDS);
                written_before += usize::from(at == 0 && is_whole);
            }
        }
        assert_eq!(database.store.contact_count().await.unwrap(), (seq + 1) * each * i64::from(SHARDS));
    }
    assert!(failures >= 20, "the link was cut during only {failures} commits");
    assert!(written_before > 0, "no joint commit of {failures} was written although its answer was lost");
}

#[tokio::test]
async fn batches_written_together_without_an_answer_are_written_once() {
    without_an_answer(1, Duration::from_micros(60)).await;
}

#[tokio::test]
async fn batches_copied_together_without_an_answer_are_written_once() {
    without_an_answer(COPIED, Duration::from_micros(300)).await;
}

#[tokio::test]
async fn rejected_rows_and_rare_ones_are_not_written_together() {
    let database = Fresh::postgres().await;
    let mut writer = database.store.writer();
    let robots = robots(&mut writer, &supervisor("a")).await;
    let mut batches: Vec<Batch> = robots.iter().map(|(_, robot)| contacts(robot, 0..3)).collect();
    // The number of a journal's row is given twice.
    let journal = || Some(JournalRow { number: 1, entries: vec![1] });
    writer.commit(&robots[2].0, &Batch { journal: journal(), ..Batch::default() }).await.unwrap();
    batches[2].journal = journal();
    let rejected: Vec<_> = robots.iter().map(|(lease, _)| lease).zip(&batches).collect();
    let problem = writer.commit_together(&rejected).await.unwrap_err();
    assert!(problem.rejection().is_some(), "{problem}");
    let rare: Vec<Batch> = robots.iter().map(|(_, robot)| rows::states(robot)).collect();
    assert!(!rare[0].fits_one_statement());
    let rare: Vec<_> = robots.iter().map(|(lease, _)| lease).zip(&rare).collect();
    assert!(!writer.commit_together(&rare).await.unwrap());
    assert_eq!(database.store.contact_count().await.unwrap(), 0);
    // Others are not concerned.
    writer.commit(rejected[0].0, rejected[0].1).await.unwrap();
    assert_eq!(database.store.contact_count().await.unwrap(), 3);
}

/// A supervisor with four shards of a quiet fleet.
#[tokio::test]
async fn a_supervisor_commits_its_quiet_shards_together() {
    let stage = Stage::new().await;
    let a = stage.replica_with("a", "f", 1.0, &["--fleet-shards", "4"]);
    until_true("a has all", async || stage.count_of("a").await == 4).await;
    let robots = crate::shards::crowd(stage.broker_port(), 0..12);
    // xmin is the transaction that wrote a row.
    const JOINT: &str = "SELECT count(*) FROM (SELECT c.xmin::text FROM contacts c JOIN whiskers w USING (whisker_id) \
         JOIN robots r USING (robot_id) GROUP BY c.xmin::text HAVING count(DISTINCT r.shard_hash % 4) > 1) t";
    until_true("four joint transactions", async || stage.number(JOINT).await > 3).await;
    robots.rest();
    until_true("every message receipted", async || robots.is_receipted()).await;
    let made = robots.contacts_made() as i64;
    assert_eq!(stage.counted().await, (made, made));
    drop(a);
    robots.stop().await;
}
