//! Retained messages that a node replicates late: they are of an earlier boot, and arrive after the robot's new birth.

use vibrissa_protocol::{Message, Name, RobotTopic};
use vibrissa_simulator::Robot;
use vibrissa_tests::observer::{Heard, Observer};
use vibrissa_tests::wait::until_true;

use crate::engine::{ALL, Engine, PASSWORD};
use crate::running::{LEARNED, Running, cut, robots, touches};

#[tokio::test]
async fn retained_messages_of_an_earlier_boot_change_nothing_when_they_come_late() {
    let Some(started) = Engine::Mosquitto.start().await else { return };
    let ports = started.ports();
    let fleet = robots(&ports);
    let running = Running::start(&ports).await;
    running.knows(&fleet).await;
    touches(&fleet, 2 * LEARNED as u64).await;
    let mut node = Observer::subscribed_as(ports[0], "node", Some((ALL, PASSWORD)), &["whisker/v1/f/one/+"]).await;
    let mut old = Vec::new();
    while old.len() < 2 {
        let retained = |heard: Heard| match heard.message {
            Message::Connection(_) if heard.retained => Some((RobotTopic::Connection, heard.payload)),
            Message::Factsheet(_) if heard.retained => Some((RobotTopic::Factsheet, heard.payload)),
            _ => None,
        };
        old.push(node.expect("a retained message", retained).await);
    }

    let robot = fleet.robot(&Name::robot("one").unwrap()).unwrap();
    let before = robot.with(|robot| robot.boot_id().clone());
    robot.with(Robot::restart_soon);
    until_true("a new boot", async || robot.with(|robot| *robot.boot_id() != before && robot.is_connected())).await;
    running.knows(&fleet).await;
    for (topic, payload) in old {
        node.publish(&format!("whisker/v1/f/one/{topic}"), payload, true).await;
    }
    // The next owner finds only the old ones retained, and asks the robots.
    let folder = running.stop().await;
    let running = Running::on(folder, &ports).await;
    running.knows(&fleet).await;
    touches(&fleet, 4 * LEARNED as u64).await;
    cut(&fleet, "one", 65.0);
    running.applied("one", 0).await;
    running.knows(&fleet).await;
    fleet.rest();
    until_true("every message receipted", async || fleet.is_receipted()).await;
    let mut late =
        Observer::subscribed_as(ports[0], "late", Some((ALL, PASSWORD)), &["whisker/v1/f/one/connection"]).await;
    let birth = |heard: Heard| match heard.message {
        Message::Connection(connection) => Some(connection.boot_id),
        _ => None,
    };
    assert_eq!(late.expect("the retained birth", birth).await, robot.with(|robot| robot.boot_id().clone()));
    fleet.stop().await;
    running.service.stop().await;
}
