//! A failover to a standby that lacks the leader's last commits, as without synchronous replication.

use sqlx::postgres::PgConnectOptions;
use sqlx::{ConnectOptions, Executor};
use vibrissa_tests::postgres::Postgres;
use vibrissa_tests::proxy::Proxy;
use vibrissa_tests::standby::Standby;
use vibrissa_tests::wait::until_within;

use crate::stage::{LONG, Stage, contacts, count};

/// Contacts that the leader records after its last change reached the standby.
const TAIL: i64 = 200;

#[tokio::test(flavor = "multi_thread")]
async fn acknowledged_commits_that_are_lost_make_nothing_stale_or_twice() {
    let mut leader = Postgres::start().await;
    let link = Proxy::to(leader.port()).await;
    let standby = Standby::of(&leader, link.port()).await;
    let url = format!("postgres://vibrissa@127.0.0.1:{},127.0.0.1:{}/vibrissa", leader.port(), standby.port());
    let stage = Stage::start(&url).await;
    let (old, new) = (leader.connect(), standby.connect());
    stage.until_busy(&old).await;
    // Commits wait for nothing, and the supervisor says so.
    stage.until_metric("vibrissa_database_asynchronous", |value| value == 1.0).await;
    assert!(stage.log().contains("a failover may lose acknowledged ones"), "{}", stage.log());

    link.stall(true);
    let before = contacts(&old).await.unwrap();
    let setpoints = count(&old, "SELECT count(*) FROM setpoints").await.unwrap();
    until_within(LONG, "commits that the standby lacks", async || {
        let is_more = count(&old, "SELECT count(*) FROM setpoints").await? > setpoints;
        (contacts(&old).await? >= before + TAIL && is_more).then_some(())
    })
    .await;
    let epoch = count(&old, "SELECT epoch FROM leases").await.unwrap();
    leader.kill();
    promote(&new).await;
    let recorded = stage.until_recorded(&new).await;
    println!("contacts recorded {:.1} s after the promotion", recorded.as_secs_f64());
    let lost = stage.until_metric("vibrissa_database_commits_lost_total", |value| value > 0.0).await;
    println!("{lost} transactions lost");
    assert!(stage.log().contains("acknowledged transactions"), "{}", stage.log());
    assert!(count(&new, "SELECT epoch FROM leases").await.unwrap() > epoch, "an epoch is given twice");

    let verdict = stage.end(&new).await;
    let (contacts, setpoints) = (verdict.contacts, verdict.setpoints);
    // Robots do not keep receipted contacts: the tail is lost, and nothing else.
    assert!(contacts.missing >= TAIL as u64 && contacts.missing < 10 * TAIL as u64, "{contacts:?}");
    assert_eq!((contacts.duplicate, contacts.wrong), (0, 0), "{contacts:?}");
    // The tail's setpoints are at the robots, and not in the database.
    assert!(setpoints.uncommitted > 0 && setpoints.uncommitted < setpoints.applied, "{setpoints:?}");
    assert_eq!((setpoints.twice, setpoints.stale, setpoints.two_for_one), (0, 0, 0), "{setpoints:?}");
}

async fn promote(standby: &PgConnectOptions) {
    let mut connection = standby.connect().await.unwrap();
    connection.execute("SELECT pg_promote()").await.unwrap();
}
