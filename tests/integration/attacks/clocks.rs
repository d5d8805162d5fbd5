//! Robots that send wrong times.

use vibrissa_protocol::{Contact, SetpointOutcome};
use vibrissa_simulator::clock::now_us;
use vibrissa_tests::robot::HandRobot;
use vibrissa_tests::wait::until_true;

use crate::supervised::{LEARNED, Supervised};

const YEAR_US: u64 = 365 * 86_400 * 1_000_000;
/// The program's default time to live, plus the time of a pressure change from 0.1 MPa to 0 at 0.02 MPa/s.
const VALID_FOR_US: u64 = 15_000_000;

/// Robot `r` with learned baselines and a correct clock.
async fn learned(supervised: &Supervised) -> HandRobot {
    let mut robot = supervised.robot("r").await;
    robot.touch(0, LEARNED + 20).await;
    robot.receipted().await;
    robot
}

async fn one_wrong_time_decides_nothing(supervised: Supervised) {
    let mut robot = learned(&supervised).await;
    for _ in 0..2 {
        robot.clock_us = now_us();
        robot.status().await;
        let wrong = Contact { t_us: now_us() + YEAR_US, ..robot.contact(0) };
        let right = robot.contact(0);
        robot.send(vec![right, wrong]).await;
    }
    // A whole message of wrong times, and a status.
    let wrong = Contact { t_us: now_us() + YEAR_US, ..robot.contact(0) };
    robot.send(vec![wrong]).await;
    robot.clock_us = now_us() + YEAR_US;
    robot.status().await;
    robot.clock_us = now_us();
    robot.receipted().await;
    supervised.has_refused(&[("bad_time", 1.0)]).await;
    assert!(supervised.metric("vibrissa_contacts_bad_time_total{fleet=\"f\"}").await >= 3.0);
    assert!(supervised.logged("bad_time") >= 1);

    robot.cut(0, 64.0);
    robot.touch(0, 80).await;
    let (setpoint, heard) = robot.setpoint().await;
    assert!(setpoint.expires_us <= now_us() + VALID_FOR_US, "{setpoint:?} at {}", now_us());
    assert!(heard.expiry_s.is_some_and(|expiry_s| u64::from(expiry_s) * 1_000_000 <= VALID_FOR_US));
    robot.clock_us = now_us();
    robot.answer(&setpoint, SetpointOutcome::Applied, None).await;

    // All contacts are recorded, whatever their times.
    robot.receipted().await;
    until_true("every contact recorded", async || {
        supervised.number("SELECT count(*) FROM contacts").await == (LEARNED as i64 + 20) + 5 + 80
    })
    .await;
    let future = "SELECT count(*) FROM contacts WHERE t_us > received_us + 3600000000";
    assert_eq!(supervised.number(future).await, 3);
}

#[tokio::test]
async fn one_wrong_time_does_not_decide_how_long_setpoints_live_on_sqlite() {
    one_wrong_time_decides_nothing(Supervised::on_sqlite().await).await;
}

#[tokio::test]
async fn one_wrong_time_does_not_decide_how_long_setpoints_live_on_postgres() {
    one_wrong_time_decides_nothing(Supervised::on_postgres().await).await;
}

async fn a_setpoint_that_had_to_wait_is_dropped(supervised: Supervised) {
    let mut robot = learned(&supervised).await;
    robot.clock_us = now_us();
    robot.status().await;
    robot.touch(0, 1).await;
    robot.receipted().await;
    // Only the supervisor loses the broker, for longer than the setpoint's time to live.
    supervised.proxy.stall(true);
    supervised.proxy.cut();
    supervised.set_by_hand(0, 0.05).await;
    let expired = "SELECT count(*) FROM setpoints WHERE state = 'EXPIRED'";
    until_true("the end of its time to live", async || supervised.number(expired).await == 1).await;
    supervised.proxy.stall(false);
    supervised.is_ready().await;
    robot.clock_us = now_us();
    robot.status().await;
    robot.touch(0, 1).await;
    robot.receipted().await;
    supervised.set_by_hand(1, 0.06).await;
    let (setpoint, _) = robot.setpoint().await;
    assert_eq!((setpoint.whisker, setpoint.pressure_mpa), (1, 0.06), "no expired setpoint may come first");
    assert!(supervised.metric("vibrissa_setpoints_expired_unsent_total{fleet=\"f\"}").await >= 1.0);
}

#[tokio::test]
async fn a_setpoint_does_not_reach_a_robot_after_its_time_to_live_on_sqlite() {
    a_setpoint_that_had_to_wait_is_dropped(Supervised::on_sqlite().await).await;
}

#[tokio::test]
async fn a_setpoint_does_not_reach_a_robot_after_its_time_to_live_on_postgres() {
    a_setpoint_that_had_to_wait_is_dropped(Supervised::on_postgres().await).await;
}
