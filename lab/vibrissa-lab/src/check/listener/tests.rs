//! Messages of several boots of one robot.

use std::time::Duration;

use bytes::Bytes;
use serde_json::{Value, json};
use tokio::time::Instant;

use super::super::report::{Finding, Outcome};
use super::super::restart::reporting_birth;
use super::*;

fn name(text: &str) -> Name {
    Name::new(text).unwrap()
}

fn boot(text: &str) -> BootId {
    BootId::new(text).unwrap()
}

struct Robot(Listener);

impl Robot {
    fn new() -> Self {
        let mut listener = Listener::new(Duration::from_secs(1_000_000_000), Duration::from_secs(1));
        listener.is_live = true;
        Self(listener)
    }

    fn says(&mut self, kind: RobotTopic, boot: &str, seq: u64, mut body: Value) {
        (body["boot_id"], body["seq"]) = (json!(boot), json!(seq));
        let (topic, payload) = (kind.of(&name("f"), &name("r")).to_string(), Bytes::from(body.to_string()));
        let retained = kind == RobotTopic::Connection;
        let before = self.0.log.len();
        self.0.take(&ReceivedMessage { topic, payload, qos: u8::from(retained), retained, at: Instant::now() });
        assert_eq!(self.0.log.len(), before + 1, "{body}");
    }

    fn is_born(&mut self, boot: &str, seq: u64) {
        self.says(
            RobotTopic::Connection,
            boot,
            seq,
            json!({"timestamp": "2026-11-21T08:00:00.000Z", "state": "ONLINE"}),
        );
    }

    fn reports(&mut self, boot: &str, seq: u64) {
        self.says(RobotTopic::Status, boot, seq, json!({"t_us": 1, "whiskers": []}));
    }

    fn touches(&mut self, boot: &str, seq: u64) {
        self.says(
            RobotTopic::Contacts,
            boot,
            seq,
            json!({"contacts": [], "missed": [{"array": "left", "whisker": 0, "t_us": 1, "distance_mm": 60.0}]}),
        );
    }

    fn finding(self, rule: Rule) -> Finding {
        self.0.findings.close("").0.into_iter().find(|finding| finding.rule == rule).unwrap()
    }
}

/// Each change of the boot forgot what had come: the pauses were never seen, and a receipt had the numbers of the other boot.
#[test]
fn regress_contacts_of_an_earlier_boot_are_not_taken_for_those_of_the_present_one() {
    let mut robot = Robot::new();
    robot.is_born("b", 0);
    for (boot, seq) in [("a", 40), ("b", 0), ("a", 41), ("b", 1), ("a", 40), ("b", 0)] {
        robot.touches(boot, seq);
    }
    let [earlier, present] = ["a", "b"].map(|text| robot.0.ledger(&boot(text)));
    assert_eq!((earlier.end(), earlier.times(40).len(), earlier.times(41).len()), (42, 2, 1));
    assert_eq!((present.end(), present.times(0).len(), present.uncovered()), (2, 2, vec![0, 1]));
    robot.0.ledger_mut(&boot("b")).unwrap().cover(1, &[], Instant::now());
    robot.touches("a", 42);
    assert_eq!(robot.0.ledger(&boot("b")).uncovered(), [1]);
    assert_eq!(robot.0.ledger(&boot("a")).uncovered(), [40, 41, 42]);
}

/// The numbers of earlier boots, and of the present one that goes on, were judged as those of a restart.
#[test]
fn regress_a_robot_that_introduces_an_earlier_boot_has_not_restarted() {
    let mut robot = Robot::new();
    robot.is_born("b", 0);
    robot.reports("b", 10);
    robot.is_born("a", 3);
    robot.is_born("b", 1);
    robot.touches("a", 40);
    robot.reports("b", 11);
    robot.touches("b", 57);
    assert!(!robot.0.was_born(&boot("b")));
    assert_eq!(robot.finding(Rule::SeqFromZero).outcome, Outcome::Skipped);
    for (seq, outcome) in [(0, Outcome::Pass), (1, Outcome::Fail)] {
        let mut robot = Robot::new();
        robot.is_born("b", 0);
        robot.is_born("a", 3);
        robot.is_born("c", 0);
        robot.touches("c", seq);
        robot.reports("c", 0);
        assert_eq!(robot.finding(Rule::SeqFromZero).outcome, outcome, "{seq}");
    }
}

/// The first birth that followed counted as the new boot, although it was that of an earlier one.
#[test]
fn regress_the_birth_of_a_restart_is_that_of_the_boot_with_statuses() {
    let mut robot = Robot::new();
    robot.is_born("b", 0);
    robot.reports("b", 0);
    let mark = robot.0.log.len();
    robot.is_born("a", 3);
    robot.is_born("b", 1);
    let present = |heard: &Listener| reporting_birth(heard, mark).map(|(at, (birth, _))| (at, birth.boot_id));
    assert_eq!(present(&robot.0), None);
    robot.reports("b", 1);
    assert_eq!(present(&robot.0), Some((mark + 1, boot("b"))));
}
