//! An earlier boot sends messages again after a later one.

use vibrissa_protocol::{BootId, ConnectionState, RobotTopic, encode};
use vibrissa_tests::wait::until_true;

use crate::supervised::Supervised;

async fn an_old_boot_stays_old(mut supervised: Supervised) {
    let mut robot = supervised.robot("r").await;
    let old = robot.boot_id.clone();
    let contacts = vec![robot.contact(0), robot.contact(1)];
    let mut message = robot.message(contacts);
    robot.say(RobotTopic::Contacts, encode(&message)).await;
    robot.receipted().await;
    let mut newest = old.clone();
    for boot in 0..6 {
        robot.restart();
        newest = BootId::new(&format!("newer-{boot}")).unwrap();
        robot.boot_id = newest.clone();
        robot.birth().await;
        robot.settle().await;
    }
    // With and without a restart: the supervisor must remember old boots in memory and in the database.
    for is_restarted in [false, true] {
        if is_restarted {
            supervised.restart().await;
            robot.boot_id = newest.clone();
            robot.settle().await;
        }
        robot.boot_id = old.clone();
        robot.connection(ConnectionState::Online).await;
        let factsheet = robot.factsheet();
        robot.say(RobotTopic::Factsheet, encode(&factsheet)).await;
        for seq in 0..2 {
            message.seq = seq;
            robot.say(RobotTopic::Contacts, encode(&message)).await;
        }
        // A birth, a factsheet, and contacts with numbers that are not known.
        supervised.has_refused(&[("old_boot", 4.0)]).await;
        assert!(supervised.logged("old_boot") >= 1);
        // The newest boot continues, and the retained messages are its own again.
        robot.boot_id = newest.clone();
        robot.connection(ConnectionState::Online).await;
        let factsheet = robot.factsheet();
        robot.say(RobotTopic::Factsheet, encode(&factsheet)).await;
        let contacts = vec![robot.contact(0)];
        robot.send(contacts).await;
        robot.receipted().await;
    }
    until_true("all contacts are recorded", async || supervised.number("SELECT count(*) FROM contacts").await == 4)
        .await;
    let twice = "SELECT count(*) - count(DISTINCT b.boot_id || ' ' || seq || ' ' || position) \
                 FROM contacts c JOIN boots b ON b.boot = c.boot";
    assert_eq!(supervised.number(twice).await, 0);
}

#[tokio::test]
async fn a_boot_that_others_have_followed_is_not_recorded_again_on_sqlite() {
    an_old_boot_stays_old(Supervised::on_sqlite().await).await;
}

#[tokio::test]
async fn a_boot_that_others_have_followed_is_not_recorded_again_on_postgres() {
    an_old_boot_stays_old(Supervised::on_postgres().await).await;
}
