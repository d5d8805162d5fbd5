//! Invalid messages of robots are refused with the right reason and have no other effect.

mod contacts;
mod topics;

use std::collections::BTreeMap;

use serde_json::Value;
use vibrissa_protocol::{ArrayType, Contact, Contacts};
use vibrissa_tests::robot::{HandRobot, array};

use crate::running::Running;

/// Contacts that were sent and must be recorded: boot, number, position, whisker, and time by the robot's clock.
type Names = Vec<(String, i64, i64, i64, i64)>;

async fn start(robot: &str) -> (Running, HandRobot) {
    let running = Running::start().await;
    let robot = HandRobot::born(running.port(), robot, array(ArrayType::Type1, &[70.0, 65.0])).await;
    (running, robot)
}

fn names(message: &Contacts) -> Names {
    let name = |(position, contact): (i64, &Contact)| {
        (message.boot_id.to_string(), message.seq as i64, position, i64::from(contact.whisker), contact.t_us as i64)
    };
    (0..).zip(&message.contacts).map(name).collect()
}

/// Sends two valid contacts and returns their names.
async fn good(robot: &mut HandRobot) -> Names {
    let contacts = vec![robot.contact(0), robot.contact(1)];
    names(&robot.send(contacts).await)
}

/// Checks that exactly these contacts are in the database, in this order.
async fn assert_recorded(running: &Running, expected: &Names) {
    let rows = running.database.contacts().await;
    let found: Names =
        rows.into_iter().map(|row| (row.boot_id, row.seq, row.position, row.whisker, row.t_us)).collect();
    assert_eq!(&found, expected);
}

fn counts(reasons: &[&str]) -> BTreeMap<String, f64> {
    let mut counts = BTreeMap::new();
    for reason in reasons {
        *counts.entry((*reason).to_owned()).or_default() += 1.0;
    }
    counts
}

/// A valid message as JSON, to be changed.
fn template(robot: &mut HandRobot) -> Value {
    let contacts = vec![robot.contact(0), robot.contact(1)];
    serde_json::to_value(robot.message(contacts)).unwrap()
}
