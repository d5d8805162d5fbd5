//! The robot with the real service: it is registered, each contact is recorded once, and its cut leads to a setpoint.

use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::wait::until_true;

use super::script::Script;
use crate::running::{Running, quick};

/// Whether each contact is recorded once and no message is missing.
async fn each_is_there_once(running: &Running) -> bool {
    let (contacts, names) = running.database.counted().await;
    assert_eq!(contacts, names, "each contact must be recorded once");
    // Messages have three contacts and are numbered from 0.
    contacts == 3 * running.database.number("SELECT max(seq) + 1 FROM contacts").await
}

#[tokio::test]
async fn it_is_known_and_its_cut_is_found_and_compensated() {
    let running = Running::start().await;
    let robot = Script::start(running.port(), 5.0);
    until_true("its whiskers", async || running.list("whiskers").await.len() == 3).await;
    until_true("a setpoint applied", async || {
        running.database.number("SELECT count(*) FROM setpoints WHERE state = 'APPLIED'").await == 1
    })
    .await;
    let whiskers = running.list("whiskers").await;
    let trimmed: Vec<_> = whiskers.iter().filter(|whisker| whisker["condition"] == "TRIMMED").collect();
    assert_eq!(trimmed.len(), 1);
    assert_eq!((&trimmed[0]["robot"], trimmed[0]["whisker"].as_u64()), (&"r".into(), Some(1)));
    let length_mm = trimmed[0]["length_mm"].as_f64().unwrap();
    // The robot's formula is invented and differs from the model, so the estimate is only approximate.
    assert!((61.0..69.0).contains(&length_mm), "{length_mm} mm");
    until_true("all contacts once", async || each_is_there_once(&running).await).await;
    assert_eq!(robot.complaints(), "");
    drop(robot);
    running.service.stop().await;
}

#[tokio::test]
async fn its_contacts_may_be_in_cbor() {
    let running = Running::start().await;
    let robot = Script::start_with_cbor(running.port(), 1e6);
    let contacts = "SELECT count(*) FROM contacts";
    until_true("contacts", async || running.database.number(contacts).await >= 60).await;
    until_true("all contacts once", async || each_is_there_once(&running).await).await;
    assert_eq!(robot.complaints(), "");
    drop(robot);
    running.service.stop().await;
}

#[tokio::test]
async fn what_it_felt_while_the_broker_was_down_comes_later_and_once() {
    let mut broker = Mosquitto::start();
    let running = Running::with(quick(), Some(broker.port())).await;
    let _robot = Script::start(broker.port(), 1e6);
    let last = async || running.database.number("SELECT coalesce(max(seq), -1) FROM contacts").await;
    until_true("some contacts", async || last().await > 10).await;
    let before = last().await;
    broker.kill();
    broker.restart();
    until_true("later contacts", async || last().await > before + 40).await;
    until_true("those between", async || each_is_there_once(&running).await).await;
    assert_eq!(running.database.number("SELECT count(*) FROM boots").await, 1, "the robot must not restart");
    running.service.stop().await;
}
