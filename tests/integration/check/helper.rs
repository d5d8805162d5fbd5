//! A simulated robot behind a relay, and the helper who acts on it as a check asks.

use std::net::{Ipv4Addr, SocketAddr};

use tokio::sync::mpsc;
use vibrissa_lab::check::{Action, CheckOptions, Help, Progress, Report, check};
use vibrissa_protocol::SupervisorPresence;
use vibrissa_simulator::clock::now_us;
use vibrissa_simulator::scenario::Change;
use vibrissa_simulator::{Broker, Fleet, RobotHandle, Scenario};
use vibrissa_supervisor::mqtt::Relay;
use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::wait;

use super::{CONTACTS_PER_S, connection_in, options_in, supervisor_of};

/// Contacts of each whisker per second while the memory is filled.
const MANY_PER_S: f64 = 40.0;
/// Pressure of the open supply, in MPa.
const SUPPLY_MPA: f64 = 0.3;
/// Contact ratio of the touches at one place.
const PLACE: f64 = 0.7;

/// A robot, unless it is stopped.
pub(crate) struct Helper {
    scenario: Scenario,
    broker: Broker,
    fleet: Option<Fleet>,
}

impl Helper {
    /// A helper of a robot that runs.
    pub(crate) async fn of(scenario: Scenario, broker: Broker) -> Self {
        let mut helper = Self { scenario, broker, fleet: None };
        helper.start().await;
        helper
    }

    /// The end of the robot.
    pub(crate) async fn end(self) {
        if let Some(fleet) = self.fleet {
            fleet.stop().await;
        }
    }

    async fn start(&mut self) {
        let fleet = Fleet::start(&self.scenario, &self.broker).unwrap();
        let robot = fleet.robots()[0].clone();
        self.fleet = Some(fleet);
        wait::until_true("a connected robot", async || robot.with(|robot| robot.is_connected())).await;
    }

    fn robot(&self) -> Option<&RobotHandle> {
        self.fleet.as_ref().map(|fleet| &fleet.robots()[0])
    }

    fn happens(&self, change: Change) {
        if let Some(robot) = self.robot() {
            robot.with(|robot| robot.happen_soon(None, None, change, now_us())).unwrap();
        }
    }

    fn touch(&self, per_second: f64, place: Option<f64>) {
        let Some(robot) = self.robot() else { return };
        robot.with(|robot| {
            let whiskers: Vec<_> = robot.whiskers().iter().map(|one| (one.array().clone(), one.number())).collect();
            whiskers.iter().for_each(|(array, number)| robot.touch_at_place(array, *number, place));
            robot.touch_at_rate(per_second, now_us());
        });
    }

    pub(crate) async fn act(&mut self, action: Action) {
        match action {
            Action::CutPower => {
                if let Some(robot) = self.robot() {
                    robot.with(vibrissa_simulator::Robot::restart_soon);
                }
            }
            Action::CloseSupply(_) => self.happens(Change::SupplyLow { supply_mpa: 0.0 }),
            Action::OpenSupply(_) => self.happens(Change::SupplyLow { supply_mpa: SUPPLY_MPA }),
            Action::Touch => self.touch(MANY_PER_S, None),
            Action::TouchPlace(_) => self.touch(CONTACTS_PER_S, Some(PLACE)),
            Action::Rest => self.touch(CONTACTS_PER_S, None),
            Action::Stop => {
                if let Some(fleet) = self.fleet.take() {
                    fleet.stop().await;
                }
            }
            Action::Start => self.start().await,
        }
    }
}

/// Checks the only robot of a scenario, behind a relay before the broker, with all help.
pub(crate) async fn assisted(broker: &Mosquitto, scenario: Scenario) -> Report {
    let (fleet, name) = (scenario.fleet.to_string(), scenario.robots[0].robot.to_string());
    supervisor_of(&fleet, broker, SupervisorPresence::Offline).await;
    let listen = SocketAddr::from((Ipv4Addr::LOCALHOST, 0));
    let relay = Relay::start(listen, ("127.0.0.1".to_owned(), broker.port())).await.unwrap();
    let mut helper = Helper::of(scenario, Broker::new("127.0.0.1", relay.address().port())).await;
    let (asked, mut actions) = mpsc::unbounded_channel();
    let helping = tokio::task::spawn_local(async move {
        while let Some(action) = actions.recv().await {
            helper.act(action).await;
        }
        helper
    });
    let mut progress = |progress| {
        if let Progress::Act(action, _) = progress {
            asked.send(action).unwrap();
        }
    };
    let connection = connection_in(&fleet, broker, &name);
    let options = CheckOptions { help: Help::All, relay: Some(relay.record()), ..options_in(&fleet, &name) };
    let report = check(&connection, options, &mut progress, std::future::pending()).await.unwrap();
    drop(asked);
    helping.await.unwrap().end().await;
    report
}
