//! A simulated robot and a real broker: the contract's rules about connections, wills and delivery.

#![allow(
    clippy::unwrap_used,
    clippy::wildcard_enum_match_arm,
    reason = "a test that cannot go on has failed, and it picks the messages that it waits for"
)]

mod load;
mod state;

use std::collections::BTreeSet;

use vibrissa_protocol::{
    BootId, Connection, ConnectionState, Contacts, Message, Name, Receipt, RobotTopic, Setpoint, SetpointOutcome,
    SetpointReason, Timestamp,
};
use vibrissa_simulator::clock::now_us;
use vibrissa_simulator::{Broker, Fleet, RobotHandle, Scenario};
use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::observer::{Heard, Observer};

const SCENARIO: &str = r#"
fleet = "f"
seed = 1
[behaviour]
contacts_per_second = 50.0
message_after_s = 0.2
[[robots]]
robot = "r"
[[robots.arrays]]
array = "left"
type = "TYPE_1"
whiskers = [{ whisker = 0, neighbours = [1] }, { whisker = 1 }]
"#;

fn start(broker: &Mosquitto, events: &str) -> (Fleet, RobotHandle) {
    let scenario = Scenario::from_toml_str(&format!("{SCENARIO}{events}")).unwrap();
    let fleet = Fleet::start(&scenario, &Broker::new("127.0.0.1", broker.port())).unwrap();
    let robot = fleet.robots()[0].clone();
    (fleet, robot)
}

fn supervisor() -> BootId {
    BootId::new("s1").unwrap()
}

/// The next connection message with this state, and whether it was retained.
async fn connection(observer: &mut Observer, state: ConnectionState) -> (Connection, bool) {
    observer
        .expect(state.as_str(), |heard| match heard {
            Heard { message: Message::Connection(connection), retained, .. } if connection.state == state => {
                Some((connection, retained))
            }
            _ => None,
        })
        .await
}

/// The next contacts message.
async fn contacts(observer: &mut Observer) -> Contacts {
    observer
        .expect("contacts", |heard| match heard.message {
            Message::Contacts(contacts) => Some(contacts),
            _ => None,
        })
        .await
}

/// Sends a receipt for all messages before the first gap.
async fn receipt(observer: &Observer, robot_boot_id: &BootId, arrived: &BTreeSet<u64>) {
    let next = arrived.iter().zip(0..).take_while(|&(&seq, expected)| seq == expected).count() as u64;
    let receipt = Receipt { boot_id: supervisor(), seq: 0, robot_boot_id: robot_boot_id.clone(), next, held: vec![] };
    observer.send(RobotTopic::Receipt, &receipt).await;
}

/// Stops the robot's contacts and sends receipts until it keeps no message. Returns the numbers that have arrived.
async fn drain(observer: &mut Observer, robot: &RobotHandle, mut arrived: BTreeSet<u64>) -> BTreeSet<u64> {
    robot.with(vibrissa_simulator::Robot::rest);
    let boot_id = robot.with(|robot| robot.boot_id().clone());
    receipt(observer, &boot_id, &arrived).await;
    loop {
        // A status arrives every second, so the loop continues even if messages are lost.
        let heard = observer.expect("anything", Some).await;
        if let Message::Contacts(contacts) = heard.message {
            arrived.insert(contacts.seq);
        }
        receipt(observer, &boot_id, &arrived).await;
        // Contacts in a message that is not yet full are due at once when a robot rests.
        let all_sent = robot.with(|robot| robot.next_deadline() > robot.start_us());
        if all_sent && robot.with(|robot| robot.messages_kept()) == 0 {
            return arrived;
        }
    }
}

#[tokio::test]
async fn a_robot_is_born_with_its_factsheet_and_sends_contacts_and_statuses() {
    let broker = Mosquitto::start();
    let mut observer = Observer::connect(broker.port(), "observer").await;
    let (fleet, robot) = start(&broker, "");
    let (birth, _) = connection(&mut observer, ConnectionState::Online).await;
    assert_eq!(birth.boot_id, robot.with(|robot| robot.boot_id().clone()));
    let mut missing = BTreeSet::from(["factsheet", "status", "contacts"]);
    while !missing.is_empty() {
        let kind = observer
            .expect("factsheet, status and contacts", |heard| match heard.message {
                Message::Factsheet(facts) => Some((facts.boot_id, "factsheet")),
                Message::Status(status) => Some((status.boot_id, "status")),
                Message::Contacts(contacts) => Some((contacts.boot_id, "contacts")),
                _ => None,
            })
            .await;
        assert_eq!(kind.0, birth.boot_id);
        missing.remove(kind.1);
    }
    fleet.stop().await;
}

#[tokio::test]
async fn birth_and_factsheet_are_retained_for_whoever_comes_later() {
    let broker = Mosquitto::start();
    let mut early = Observer::connect(broker.port(), "early").await;
    let (fleet, _) = start(&broker, "");
    contacts(&mut early).await;
    let mut late = Observer::connect(broker.port(), "late").await;
    let mut retained = BTreeSet::new();
    while retained.len() < 2 {
        let kind = late
            .expect("retained birth and factsheet", |heard| match heard {
                Heard { message: Message::Connection(_), retained: true, .. } => Some("connection"),
                Heard { message: Message::Factsheet(_), retained: true, .. } => Some("factsheet"),
                Heard { retained, message, .. } => {
                    assert!(!retained, "{message:?} must not be retained");
                    None
                }
            })
            .await;
        retained.insert(kind);
    }
    fleet.stop().await;
}

#[tokio::test]
async fn an_abrupt_cut_leaves_the_will_and_the_robot_comes_back_in_the_same_boot() {
    let broker = Mosquitto::start();
    let mut observer = Observer::connect(broker.port(), "observer").await;
    let (fleet, robot) = start(&broker, "");
    let (birth, _) = connection(&mut observer, ConnectionState::Online).await;
    robot.cut();
    let (will, _) = connection(&mut observer, ConnectionState::ConnectionBroken).await;
    let (again, _) = connection(&mut observer, ConnectionState::Online).await;
    assert_eq!((&will.boot_id, &again.boot_id), (&birth.boot_id, &birth.boot_id));
    assert_eq!((birth.seq, will.seq, again.seq), (0, 1, 2));
    fleet.stop().await;
}

#[tokio::test]
async fn a_restart_leaves_the_old_boots_will_and_is_born_anew() {
    let broker = Mosquitto::start();
    let mut observer = Observer::connect(broker.port(), "observer").await;
    let (fleet, _) = start(&broker, "[[robots.events]]\nat_s = 0.5\nchange = { kind = \"RESTART\" }");
    let (birth, _) = connection(&mut observer, ConnectionState::Online).await;
    let (will, _) = connection(&mut observer, ConnectionState::ConnectionBroken).await;
    let (again, _) = connection(&mut observer, ConnectionState::Online).await;
    assert_eq!(will.boot_id, birth.boot_id);
    assert_ne!(again.boot_id, birth.boot_id);
    assert_eq!(again.seq, 0);
    fleet.stop().await;
}

#[tokio::test]
async fn an_orderly_end_says_offline_and_leaves_no_will() {
    let broker = Mosquitto::start();
    let mut observer = Observer::connect(broker.port(), "observer").await;
    let (fleet, _) = start(&broker, "");
    connection(&mut observer, ConnectionState::Online).await;
    fleet.stop().await;
    let (farewell, _) = connection(&mut observer, ConnectionState::Offline).await;
    assert_eq!(farewell.seq, 1);
    let mut late = Observer::connect(broker.port(), "late").await;
    let (last, retained) = connection(&mut late, ConnectionState::Offline).await;
    assert!(retained && last == farewell, "nothing may follow it");
}

#[tokio::test]
async fn a_setpoint_is_applied() {
    let broker = Mosquitto::start();
    let mut observer = Observer::connect(broker.port(), "observer").await;
    let (fleet, robot) = start(&broker, "");
    let (birth, _) = connection(&mut observer, ConnectionState::Online).await;
    let array = Name::new("left").unwrap();
    let setpoint = Setpoint {
        boot_id: supervisor(),
        seq: 0,
        command_id: "c1".to_owned(),
        epoch: 1,
        version: 1,
        robot_boot_id: birth.boot_id,
        array: array.clone(),
        whisker: 1,
        pressure_mpa: 0.08,
        slew_mpa_per_s: 0.02,
        issued: Timestamp(now_us()),
        expires_us: now_us() + 30_000_000,
        reason: SetpointReason::SelfCompensation,
        gain: vec![(1.0, 1.0)],
        reading_gain: None,
    };
    observer.send(RobotTopic::Setpoint, &setpoint).await;
    for expected in [SetpointOutcome::Received, SetpointOutcome::Applying, SetpointOutcome::Applied] {
        let state = observer
            .expect(expected.as_str(), |heard| match heard.message {
                Message::SetpointState(state) => Some(state),
                _ => None,
            })
            .await;
        assert_eq!((state.command_id.as_str(), state.state), ("c1", expected));
    }
    let pressure_mpa = robot.with(|robot| robot.whisker(&array, 1).unwrap().regulator().pressure_mpa());
    assert!((pressure_mpa - 0.08).abs() < 0.004, "{pressure_mpa}");
    fleet.stop().await;
}

#[tokio::test]
async fn contacts_are_sent_again_until_they_are_receipted() {
    let broker = Mosquitto::start();
    let mut observer = Observer::connect(broker.port(), "observer").await;
    let (fleet, robot) = start(&broker, "");
    let first = contacts(&mut observer).await;
    let mut arrived = BTreeSet::from([first.seq]);
    loop {
        let again = contacts(&mut observer).await;
        if again.seq == first.seq {
            assert_eq!(again, first, "the same number must have the same content");
            break;
        }
        arrived.insert(again.seq);
    }
    let arrived = drain(&mut observer, &robot, arrived).await;
    assert!(arrived.iter().zip(0..).all(|(&seq, expected)| seq == expected), "numbers must have no gap");
    fleet.stop().await;
}

#[tokio::test]
async fn no_contact_is_lost_when_the_broker_is_killed() {
    let mut broker = Mosquitto::start();
    let mut observer = Observer::connect(broker.port(), "before").await;
    let (fleet, robot) = start(&broker, "");
    let mut times = BTreeSet::new();
    let mut arrived = BTreeSet::new();
    while arrived.len() < 5 {
        let message = contacts(&mut observer).await;
        arrived.insert(message.seq);
        times.extend(message.contacts.iter().map(|contact| (contact.whisker, contact.t_us)));
    }
    broker.kill();
    drop(observer);
    broker.restart();
    let mut observer = Observer::connect(broker.port(), "after").await;
    let boot_id = robot.with(|robot| robot.boot_id().clone());
    loop {
        let message = contacts(&mut observer).await;
        arrived.insert(message.seq);
        times.extend(message.contacts.iter().map(|contact| (contact.whisker, contact.t_us)));
        receipt(&observer, &boot_id, &arrived).await;
        // After that, only contacts made before the rest are outstanding.
        robot.with(|robot| {
            if robot.contacts_made() > 300 {
                robot.rest()
            }
        });
        if robot.with(|robot| robot.contacts_made()) == times.len() as u64 {
            break;
        }
    }
    drain(&mut observer, &robot, arrived).await;
    fleet.stop().await;
}
