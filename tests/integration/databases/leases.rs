//! Leases in the database: one owner at a time, and each transaction once.

use sqlx::{AssertSqlSafe, ConnectOptions, Executor};
use vibrissa_store::{LossCause, StoreError};
use vibrissa_tests::wait::{until, until_true};

use crate::refused::Admin;
use crate::rows::{self, contacts};
use crate::{Fresh, brief, fleet, supervisor};

/// Sets the clock by which the database stamps leases so far ahead of the true time.
async fn set_clock(database: &Fresh, ahead_s: i64) {
    let mut server = database.server.as_ref().unwrap().connect().connect().await.unwrap();
    let sql = format!(
        "CREATE OR REPLACE FUNCTION clock_us() RETURNS BIGINT LANGUAGE SQL VOLATILE \
         AS 'SELECT (extract(epoch FROM clock_timestamp()) * 1000000)::BIGINT + ({ahead_s} * 1000000::BIGINT)'"
    );
    server.execute(AssertSqlSafe(sql)).await.unwrap();
}

#[tokio::test]
async fn regress_a_step_of_the_databases_clock_decides_about_no_lease() {
    let database = Fresh::postgres().await;
    let (a, b) = (brief("a"), brief("b"));
    let (mut writer_a, mut writer_b) = (database.store.writer(), database.store.writer());
    writer_a.sign_in(&a, &[]).await.unwrap();
    let lease = writer_a.acquire(&a, &fleet()).await.unwrap().unwrap();
    writer_b.sign_in(&b, &[]).await.unwrap();
    // A living owner keeps its lease, whatever the clock does.
    for ahead_s in [3600, -120, 0, 7200] {
        set_clock(&database, ahead_s).await;
        for _ in 0..3 {
            let roll = writer_b.sign_in(&b, &[]).await.unwrap();
            assert!(!roll.leases[0].free, "{ahead_s}");
            assert!(writer_b.acquire(&b, &fleet()).await.unwrap().is_none(), "{ahead_s}");
            writer_a.sign_in(&a, std::slice::from_ref(&lease)).await.unwrap();
        }
    }
    // A dead one loses it, although its lease seems to live for hours.
    set_clock(&database, 0).await;
    let taken = until("taken over", async || {
        let roll = writer_b.sign_in(&b, &[]).await.unwrap();
        roll.leases[0].free.then_some(())?;
        assert!(roll.present.iter().all(|one| one.supervisor == "b"), "the dead owner is not present");
        writer_b.acquire(&b, &fleet()).await.unwrap()
    })
    .await;
    assert!(taken.epoch() > lease.epoch() && !lease.is_fresh());
}

/// The answer to a commit is lost repeatedly, at every moment of the commit. After the retries each batch is stored
/// once.
#[tokio::test]
async fn regress_a_commit_whose_answer_is_lost_is_written_once() {
    let database = Fresh::postgres().await;
    let server = database.server.as_ref().unwrap();
    let proxy = vibrissa_tests::proxy::Proxy::to(server.port()).await;
    let address = vibrissa_tests::postgres::Postgres::url(proxy.port()).parse().unwrap();
    let through = vibrissa_store::Store::open(&address, "through").await.unwrap();
    let a = supervisor("a");
    let mut writer = through.writer();
    writer.sign_in(&a, &[]).await.unwrap();
    let lease = writer.acquire(&a, &fleet()).await.unwrap().unwrap();
    let robot = rows::robot(&mut writer, &lease).await;
    let mut failures = 0;
    for seq in 0..60 {
        let batch = contacts(&robot, seq..seq + 1);
        // The link is cut after another number of bytes of each commit and its answer.
        proxy.cut_after(60 * seq as usize);
        while writer.commit(&lease, &batch).await.is_err() {
            failures += 1;
        }
        assert_eq!(database.store.contact_count().await.unwrap(), seq + 1);
    }
    assert!(failures >= 12, "the link was cut during only {failures} commits");
}

/// A supervisor that freezes during a transaction does not keep its fleet.
#[tokio::test]
async fn a_transaction_that_is_left_open_does_not_keep_a_fleet() {
    let database = Fresh::postgres().await;
    let server = database.server.as_ref().unwrap();
    let proxy = vibrissa_tests::proxy::Proxy::to(server.port()).await;
    let address = vibrissa_tests::postgres::Postgres::url(proxy.port()).parse().unwrap();
    let through = vibrissa_store::Store::open(&address, "through").await.unwrap();
    let (a, b) = (brief("a"), brief("b"));
    let mut writer_a = through.writer();
    writer_a.sign_in(&a, &[]).await.unwrap();
    let lease = writer_a.acquire(&a, &fleet()).await.unwrap().unwrap();
    let robot = rows::robot(&mut writer_a, &lease).await;
    // Commits until the link stalls, somewhere inside a transaction.
    let stalled = tokio::spawn(async move {
        for seq in 0.. {
            let written = writer_a.commit(&lease, &contacts(&robot, seq..seq + 1)).await;
            if written.is_err() {
                return;
            }
        }
    });
    until_true("contacts", async || database.store.contact_count().await.unwrap() > 20).await;
    proxy.stall(true);
    let mut writer_b = database.store.writer();
    // The link is still silent.
    until("taken over", async || writer_b.acquire(&b, &fleet()).await.unwrap()).await;
    let taken_over = database.store.contact_count().await.unwrap();
    proxy.stall(false);
    stalled.await.unwrap();
    assert_eq!(database.store.contact_count().await.unwrap(), taken_over, "no late write may arrive");
}

/// The database has lost the transaction that assigned the last number, and no batch.
async fn lost_number(database: Fresh) {
    let (a, mut admin, mut writer) = (supervisor("a"), Admin::of(&database).await, database.store.writer());
    writer.sign_in(&a, &[]).await.unwrap();
    let lost = writer.acquire(&a, &fleet()).await.unwrap().unwrap();
    let robot = rows::robot(&mut writer, &lost).await;
    writer.commit(&lost, &contacts(&robot, 0..3)).await.unwrap();
    admin.execute("UPDATE leases SET numbers = numbers - 1".to_owned()).await;
    let batch = writer.commit(&lost, &contacts(&robot, 3..5)).await;
    let boot = writer.boot(&lost, robot.robot_id, "c", 1).await.map(drop);
    for refused in [batch, boot] {
        let StoreError::LeaseLost { cause, .. } = refused.unwrap_err() else { panic!("another error") };
        assert_eq!(cause, LossCause::CommitsLost { commits: 1 });
    }
    assert_eq!(database.store.contact_count().await.unwrap(), 3, "nothing was written");

    // A later epoch counts anew.
    writer.sign_in(&a, &[]).await.unwrap();
    let next = writer.acquire(&a, &fleet()).await.unwrap().unwrap();
    writer.commit(&next, &contacts(&robot, 3..5)).await.unwrap();
    writer.boot(&next, robot.robot_id, "c", 1).await.unwrap();
    // A higher count is of a transaction whose answer was lost.
    admin.execute("UPDATE leases SET numbers = numbers + 1".to_owned()).await;
    writer.commit(&next, &contacts(&robot, 5..7)).await.unwrap();
    assert_eq!(database.store.contact_count().await.unwrap(), 7);
}

#[tokio::test]
async fn regress_a_number_that_the_database_has_lost_ends_the_lease_on_sqlite() {
    lost_number(Fresh::sqlite().await).await;
}

#[tokio::test]
async fn regress_a_number_that_the_database_has_lost_ends_the_lease_on_postgres() {
    lost_number(Fresh::postgres().await).await;
}

/// A failover lost the last commits, and the former leader's clock was a day ahead: its epochs are known to supervisors
/// and not to the database.
#[tokio::test]
async fn an_epoch_that_the_database_has_lost_is_not_given_again() {
    let database = Fresh::postgres().await;
    let mut server = database.server.as_ref().unwrap().connect().connect().await.unwrap();
    let a = supervisor("a");
    let mut writer = database.store.writer();
    writer.sign_in(&a, &[]).await.unwrap();
    server.execute("UPDATE leases SET epoch = (clock_us() + 86400000000) / 1000").await.unwrap();
    writer.sign_in(&a, &[]).await.unwrap();
    let lost = writer.acquire(&a, &fleet()).await.unwrap().unwrap();
    let robot = rows::robot(&mut writer, &lost).await;
    writer.commit(&lost, &contacts(&robot, 0..3)).await.unwrap();
    writer.commit(&lost, &contacts(&robot, 3..5)).await.unwrap();

    // The lease is the same, and its last transactions are gone.
    server.execute("UPDATE leases SET commits = commits - 2").await.unwrap();
    let refused = writer.commit(&lost, &contacts(&robot, 5..7)).await.unwrap_err();
    let StoreError::LeaseLost { cause, .. } = refused else { panic!("{refused}") };
    assert_eq!(cause, LossCause::CommitsLost { commits: 2 });
    assert_eq!(database.store.contact_count().await.unwrap(), 5, "nothing was written");

    // The lease itself is gone.
    server.execute("UPDATE leases SET epoch = 5, owner = NULL, expires_us = 0, commits = 0").await.unwrap();
    let roll = writer.sign_in(&a, &[]).await.unwrap();
    assert_eq!(roll.leases[0].epoch, 5);
    let next = writer.acquire(&a, &fleet()).await.unwrap().unwrap();
    assert!(next.epoch() > lost.epoch(), "{} after {}", next.epoch(), lost.epoch());
}
