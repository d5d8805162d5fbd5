//! Messages that lead to rows which the database always refuses affect only their sender.

use std::time::Duration;

use vibrissa_protocol::{ArrayType, RobotTopic};
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::until;

use crate::planted::Admin;
use crate::stage::Stage;
use crate::with_limits::DatabaseKind;

/// Contacts after which a whisker's cut is detected, with the program's defaults.
const LEARNED: usize = 300;

/// Another robot's contacts are recorded while the database still refuses the rows.
async fn goes_on(robot: &mut HandRobot) {
    robot.touch(0, 5).await;
    robot.receipted().await;
}

async fn born(stage: &Stage, name: &str, lengths_mm: &[f64]) -> HandRobot {
    HandRobot::born(stage.broker.port(), name, array(ArrayType::Type2, lengths_mm)).await
}

/// One of many messages leads to a refused row; only this message is quarantined.
async fn one_message(kind: DatabaseKind) {
    let stage = Stage::start(kind).await;
    let mut admin = Admin::of(&stage).await;
    let (mut good, mut bad) = (born(&stage, "good", &[70.0]).await, born(&stage, "bad", &[70.0]).await);
    let mut contacts = 0;
    admin.refuse("contacts", "n.strain = 0.0123456789").await;
    for number in 0..40 {
        let mut one = bad.contact(0);
        if number == 17 {
            one.strain = 0.012_345_678_9;
        } else {
            contacts += 1;
        }
        bad.send(vec![one]).await;
    }
    goes_on(&mut good).await;
    // The bad message is receipted, too, so that the robot does not send it again.
    bad.receipted().await;
    let series = "vibrissa_messages_quarantined_total{cause=\"CONSTRAINT\",fleet=\"f\"}";
    until("the message is in quarantine", async || (stage.metric(series).await > 0.0).then_some(())).await;
    let recorded = "SELECT count(*) FROM contacts c JOIN boots b USING (boot) JOIN robots r ON r.robot_id = b.robot_id \
                    WHERE r.robot = 'bad'";
    until("all others are recorded once", async || {
        let (all, distinct) =
            (admin.numbers(recorded).await, admin.numbers(&recorded.replace("count(*)", "count(DISTINCT seq)")).await);
        (all == [contacts] && distinct == [contacts]).then_some(())
    })
    .await;
    // The first message of a robot is empty, so its 18th contact is in message 18.
    assert_eq!(admin.numbers("SELECT seq FROM quarantine WHERE robot = 'bad' AND topic = 'contacts'").await, [18]);
    assert!((stage.metric(series).await - 1.0).abs() < 1e-9);
    let listed = stage.get("/v1/quarantine?fleet=f&robot=bad").await;
    assert_eq!(listed["items"][0]["seq"], 18, "{listed}");
    stage.ready().await;
    stage.stop().await;
}

#[tokio::test]
async fn regress_a_refused_contact_is_put_into_quarantine_alone_on_sqlite() {
    one_message(DatabaseKind::Sqlite).await;
}

#[tokio::test]
async fn regress_a_refused_contact_is_put_into_quarantine_alone_on_postgres() {
    one_message(DatabaseKind::Postgres).await;
}

/// An action for another robot is done, although more than are read at a time wait for the suspect.
async fn actions_of_others(stage: &Stage, admin: &mut Admin) {
    let expires_us = i64::MAX;
    for number in 0..=100 {
        let robot = if number < 100 { "bad" } else { "good" };
        let sql = format!(
            "INSERT INTO actions (fleet, robot, kind, parameters, actor, role, request_id, asked_us, expires_us, state) \
             VALUES ('f', '{robot}', 'HOLD', '{{}}', 'test', 'operator', 'test-{number}', 1, {expires_us}, 'PENDING') \
             RETURNING action_id"
        );
        admin.numbers(&sql).await;
    }
    let pending = |robot: &str| format!("SELECT count(*) FROM actions WHERE robot = '{robot}' AND state = 'PENDING'");
    until("the other robot's action is done", async || (admin.numbers(&pending("good")).await == [0]).then_some(()))
        .await;
    let waiting = admin.numbers(&pending("bad")).await;
    if stage.metric("vibrissa_robots_suspect{fleet=\"f\"}").await >= 1.0 {
        assert_eq!(waiting, [100], "actions for a suspect wait");
    }
}

/// A trigger refuses all rows of one robot, in one table after the other. The other robot continues, and the affected
/// robot continues once the trigger is removed.
async fn one_robot(kind: DatabaseKind) {
    let stage = Stage::start(kind).await;
    let mut admin = Admin::of(&stage).await;
    let (mut good, mut bad) = (born(&stage, "good", &[70.0]).await, born(&stage, "bad", &[70.0, 70.0, 70.0]).await);
    for whisker in 0..3 {
        bad.touch(whisker, LEARNED).await;
    }
    bad.receipted().await;
    let robot_id = admin.numbers("SELECT robot_id FROM robots WHERE robot = 'bad'").await[0];
    let of_it =
        "n.whisker_id IN (SELECT whisker_id FROM whiskers WHERE robot_id = {r})".replace("{r}", &robot_id.to_string());
    let cases = [
        ("robots", format!("n.robot_id = {robot_id}")),
        ("whiskers", format!("n.robot_id = {robot_id}")),
        ("contacts", of_it.clone()),
        ("health_changes", of_it),
        ("trims", format!("n.robot_id = {robot_id}")),
        ("compensations", format!("n.robot_id = {robot_id}")),
        ("setpoints", format!("n.robot_id = {robot_id}")),
    ];
    for (at, (table, condition)) in cases.into_iter().enumerate() {
        admin.refuse(table, &condition).await;
        // A cut writes rows to each of the tables. In later cases the whisker has been cut before.
        bad.cut(at as u16 % 3, 64.0 - 2.0 * (at / 3) as f64);
        bad.touch(at as u16 % 3, 60).await;
        bad.connection(vibrissa_protocol::ConnectionState::Online).await;
        for _ in 0..3 {
            goes_on(&mut good).await;
        }
        admin.relent(table).await;
        stage.ready().await;
    }
    let next = bad.next_seq(RobotTopic::Contacts);
    until("the affected robot continues", async || {
        let message = serde_json::json!({"boot_id": bad.boot_id.as_str(), "seq": next, "contacts": []});
        bad.say(RobotTopic::Contacts, message.to_string()).await;
        let heard = bad.mqtt.next(Duration::from_millis(500)).await?;
        let vibrissa_protocol::Message::Receipt(receipt) = heard.message else { return None };
        receipt.covers(next).then_some(())
    })
    .await;
    assert!(
        stage.metric("vibrissa_robots_suspect{fleet=\"f\"}").await >= 1.0,
        "the robot must be suspect for a minute"
    );
    actions_of_others(&stage, &mut admin).await;
    stage.stop().await;
}

#[tokio::test]
async fn regress_a_robot_whose_rows_are_refused_stops_no_other_on_sqlite() {
    one_robot(DatabaseKind::Sqlite).await;
}

#[tokio::test]
async fn regress_a_robot_whose_rows_are_refused_stops_no_other_on_postgres() {
    one_robot(DatabaseKind::Postgres).await;
}

/// A factsheet whose rows are refused when ids are assigned, before it has any effect.
async fn a_factsheet(kind: DatabaseKind) {
    let stage = Stage::start(kind).await;
    let mut admin = Admin::of(&stage).await;
    let mut good = born(&stage, "good", &[70.0]).await;
    admin.refuse("arrays", "n.\"array\" = 'odd'").await;
    let mut odd = array(ArrayType::Type2, &[70.0]);
    odd.array = vibrissa_protocol::Name::new("odd").unwrap();
    let mut bad = HandRobot::connect(stage.broker.port(), "bad", odd).await;
    bad.birth().await;
    goes_on(&mut good).await;
    until("the factsheet is in quarantine", async || {
        (admin.numbers("SELECT count(*) FROM quarantine WHERE topic = 'factsheet'").await == [1]).then_some(())
    })
    .await;
    stage.stop().await;
}

#[tokio::test]
async fn regress_a_factsheet_that_is_refused_is_put_into_quarantine_on_sqlite() {
    a_factsheet(DatabaseKind::Sqlite).await;
}

#[tokio::test]
async fn regress_a_factsheet_that_is_refused_is_put_into_quarantine_on_postgres() {
    a_factsheet(DatabaseKind::Postgres).await;
}
