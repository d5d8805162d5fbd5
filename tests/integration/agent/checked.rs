//! `check-robot` passes the agent, with no rule skipped that a test from outside can verify.

use std::time::Duration;

use vibrissa::check::{CheckOptions, Outcome, Progress, Timings, check};
use vibrissa_edge::shard::FleetShard;
use vibrissa_protocol::{BootId, Name, Rule};
use vibrissa_supervisor::mqtt::{BrokerAddress, Connection, prepare};
use vibrissa_tests::mosquitto::Mosquitto;

use crate::stage::{agent, board_as_child, configuration};

/// Timings for an agent, which answers at once.
fn timings() -> Timings {
    let ms = Duration::from_millis;
    Timings {
        retained: ms(400),
        supervisor: ms(400),
        answer: ms(2500),
        grace: ms(400),
        status: (ms(1000), ms(3000)),
        clock: ms(2000),
        apply: ms(15_000),
        slew: ms(2000),
        contacts: ms(5000),
        resend: ms(8000),
        backoff: ms(20_000),
        restart: ms(20_000),
    }
}

#[tokio::test]
async fn the_agent_keeps_each_rule_that_can_be_tested() {
    let (folder, broker) = (tempfile::tempdir().unwrap(), Mosquitto::start());
    let driver = board_as_child(folder.path(), 4.0);
    let mut robot = agent(folder.path(), &configuration(broker.port(), &driver));
    let address = BrokerAddress::new("127.0.0.1", broker.port());
    let prepared = prepare(&address).unwrap();
    let fleet = Name::new("f").unwrap();
    let of = FleetShard::whole(fleet.clone());
    let connection = Connection::new(address, prepared, of, BootId::new("check").unwrap());
    let options = CheckOptions {
        fleet,
        robot: Name::robot("r").unwrap(),
        whisker: None,
        // No supervisor has owned the fleet; one epoch below must exist.
        epoch: Some(7),
        restart: true,
        timings: timings(),
    };
    vibrissa_tests::wait::until_true("a connected agent", async || {
        std::fs::read_to_string(folder.path().join("agent.log")).unwrap().contains("connected to the broker")
    })
    .await;
    let mut progress = |progress| {
        if matches!(progress, Progress::RestartNow(_)) {
            robot.kill();
            robot.restart();
        }
    };
    let report = check(&connection, options, &mut progress, std::future::pending()).await.unwrap();
    for rule in Rule::ALL.iter().filter(|rule| rule.is_testable()) {
        let finding = report.findings.iter().find(|finding| finding.rule == *rule).unwrap();
        assert_eq!(finding.outcome, Outcome::Pass, "{rule}: {}", finding.seen);
    }
}
