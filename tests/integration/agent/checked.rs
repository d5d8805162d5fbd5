//! `check-robot` passes the agent, with no rule skipped. A test helps at the robot: it stops the agent, closes the air supply of
//! its board, and so on.

use std::fs;
use std::net::{Ipv4Addr, SocketAddr};
use std::time::Duration;

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use serde_json::Value;
use tempfile::TempDir;
use vibrissa_lab::check::{Action, CheckOptions, Help, Outcome, Progress, Report, Timings, check};
use vibrissa_protocol::{BootId, Name, Rule};
use vibrissa_supervisor::mqtt::{BrokerAddress, Connection, Relay, prepare};
use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::process::Process;

use crate::stage::{agent, board_as_child, configuration};

/// Contacts of each whisker per second: the memory of 200 messages is full after about 15 s.
const CONTACTS_PER_S: f64 = 10.0;

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
        help: ms(20_000),
        fill: ms(60_000),
        silence: ms(24_000),
    }
}

/// An agent and its board, and the helper at them.
struct Robot {
    folder: TempDir,
    agent: Process,
}

impl Robot {
    /// Closes the air supply of the newest board, or opens it again.
    fn turn_supply(&self) {
        let text = fs::read_to_string(self.folder.path().join("board.log")).unwrap();
        let lines = text.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
        let pid = lines.rev().find(|line| line["log"] == "started").unwrap()["pid"].as_i64().unwrap();
        kill(Pid::from_raw(i32::try_from(pid).unwrap()), Signal::SIGUSR2).unwrap();
    }

    fn act(&mut self, action: &Action) {
        match action {
            Action::CutPower => {
                self.agent.kill();
                self.agent.restart();
            }
            Action::CloseSupply(_) | Action::OpenSupply(_) => self.turn_supply(),
            Action::Stop => self.agent.signal(Signal::SIGTERM),
            Action::Start => {
                // It has said its farewell, and may be about to end.
                if self.agent.ended_already().is_none() {
                    self.agent.kill();
                }
                self.agent.restart();
            }
            // Its board is touched all the time, at one place.
            Action::Touch | Action::TouchPlace(_) | Action::Rest => {}
        }
    }
}

/// Checks an agent whose driver divides distances by the length of the estimate.
async fn assisted() -> Report {
    let (folder, broker) = (tempfile::tempdir().unwrap(), Mosquitto::start());
    let listen = SocketAddr::from((Ipv4Addr::LOCALHOST, 0));
    let relay = Relay::start(listen, ("127.0.0.1".to_owned(), broker.port())).await.unwrap();
    let driver = board_as_child(folder.path(), CONTACTS_PER_S);
    let path = folder.path().join("scenario.toml");
    let scenario = fs::read_to_string(&path).unwrap();
    fs::write(&path, scenario.replace("[behaviour]", "[behaviour]\nplaces = \"ESTIMATED_RATIO\"")).unwrap();
    let driver = driver.replace("\"board\",", "\"board\", \"--touch-ratio\", \"0.7\",");
    let text = configuration(relay.address().port(), &driver)
        .replace("robot = \"r\"", "robot = \"r\"\napplies_gain = true\non_supervisor_loss = \"NOMINAL\"")
        .replace("place = \"RATIO\"", "place = \"RATIO\", strain_max = 0.5")
        .replace("[outbox]", "[outbox]\nmessages = 200\ndisk_bytes = 0")
        .replace("[supervisor]", "[supervisor]\nlost_after_s = 20.0");
    let agent = agent(folder.path(), &text);
    let mut robot = Robot { folder, agent };
    let address = BrokerAddress::new("127.0.0.1", broker.port());
    let prepared = prepare(&address).unwrap();
    let fleet = Name::new("f").unwrap();
    let of = fleet.clone();
    let connection = Connection::new(address, prepared, of, BootId::new("check").unwrap());
    let options = CheckOptions {
        fleet,
        robot: Name::robot("r").unwrap(),
        whisker: None,
        // No supervisor has owned the fleet; one epoch below must exist.
        epoch: Some(7),
        help: Help::All,
        relay: Some(relay.record()),
        timings: timings(),
    };
    vibrissa_tests::wait::until_true("a connected agent", async || {
        fs::read_to_string(robot.folder.path().join("agent.log")).unwrap().contains("connected to the broker")
    })
    .await;
    let mut progress = |progress| {
        println!("{progress}");
        if let Progress::Act(action, _) = progress {
            robot.act(&action);
        }
    };
    let report = check(&connection, options, &mut progress, std::future::pending()).await.unwrap();
    println!("{report}");
    report
}

#[tokio::test]
async fn the_agent_keeps_each_rule_of_the_contract() {
    let report = assisted().await;
    for rule in Rule::ALL {
        let finding = report.findings.iter().find(|finding| finding.rule == *rule).unwrap();
        assert_eq!(finding.outcome, Outcome::Pass, "{rule}: {}", finding.seen);
    }
}
