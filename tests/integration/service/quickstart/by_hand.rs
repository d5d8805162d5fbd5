//! The robot with the test as its supervisor: all answers to setpoints, and contacts until they are receipted.

use std::time::{Duration, Instant};

use rumqttc::QoS;
use vibrissa_protocol::{
    BootId, ConnectionState, Message, Name, Receipt, Request, RequestKind, RobotTopic, Setpoint, SetpointError,
    SetpointOutcome, SetpointReason, SetpointState, Timestamp,
};
use vibrissa_simulator::clock::now_us;
use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::observer::{Heard, Observer};

use super::script::Script;
use crate::program::LABORATORY;

/// A robot that has sent its birth, and its supervisor.
struct Scene {
    robot: Script,
    supervisor: Observer,
    boot_id: BootId,
    broker: Mosquitto,
}

impl Scene {
    async fn start() -> Self {
        Self::with(|port| Script::start(port, 1e6)).await
    }

    async fn with(start: impl Fn(u16) -> Script) -> Self {
        let broker = Mosquitto::start();
        // Only topics of robots, because the supervisor's own messages may be invalid on purpose.
        let filters = RobotTopic::ALL.into_iter().filter(|topic| topic.is_from_robot());
        let filters: Vec<String> = filters.map(|topic| format!("whisker/v1/f/r/{topic}")).collect();
        let filters: Vec<&str> = filters.iter().map(String::as_str).collect();
        let mut supervisor = Observer::subscribed(broker.port(), "supervisor", &filters).await;
        let robot = start(broker.port());
        let (boot_id, _) = connection(&mut supervisor, ConnectionState::Online).await;
        Self { robot, supervisor, boot_id, broker }
    }

    /// A valid setpoint with this version.
    fn setpoint(&self, version: u64) -> Setpoint {
        Setpoint {
            boot_id: BootId::new("s1").unwrap(),
            seq: version,
            command_id: format!("c{version}"),
            epoch: 7,
            version,
            robot_boot_id: self.boot_id.clone(),
            array: Name::new("left").unwrap(),
            whisker: 1,
            pressure_mpa: 0.1,
            slew_mpa_per_s: 0.1,
            issued: Timestamp(now_us()),
            expires_us: now_us() + 30_000_000,
            reason: SetpointReason::Operator,
            gain: vec![],
            reading_gain: None,
        }
    }

    /// The next answer to any setpoint.
    async fn answer(&mut self) -> SetpointState {
        let answer = |heard: Heard| match heard.message {
            Message::SetpointState(state) => Some(state),
            _ => None,
        };
        self.supervisor.expect("an answer", answer).await
    }

    /// Sends a setpoint and expects exactly these answers.
    async fn answered(&mut self, setpoint: &Setpoint, expected: &[SetpointOutcome]) -> Vec<SetpointState> {
        self.supervisor.send(RobotTopic::Setpoint, setpoint).await;
        let mut answers = Vec::new();
        for &outcome in expected {
            let answer = self.answer().await;
            assert_eq!((&answer.command_id, answer.state), (&setpoint.command_id, outcome));
            answers.push(answer);
        }
        answers
    }

    async fn rejected(&mut self, setpoint: &Setpoint, error: SetpointError) {
        let answers = self.answered(setpoint, &[SetpointOutcome::Rejected]).await;
        assert_eq!(answers[0].error, Some(error));
    }

    /// Waits until the robot has received all earlier messages.
    async fn heard_all(&mut self) {
        let request =
            Request { boot_id: BootId::new("s1").unwrap(), seq: 0, request: RequestKind::Factsheet, touch_test: None };
        self.supervisor.send(RobotTopic::Request, &request).await;
        let factsheet = |heard: Heard| matches!(heard.message, Message::Factsheet(_)).then_some(());
        self.supervisor.expect("a factsheet again", factsheet).await;
    }

    /// Number of the next contacts message.
    async fn contacts(&mut self) -> u64 {
        let contacts = |heard: Heard| match heard.message {
            Message::Contacts(contacts) => Some(contacts.seq),
            _ => None,
        };
        self.supervisor.expect("contacts", contacts).await
    }
}

async fn connection(supervisor: &mut Observer, state: ConnectionState) -> (BootId, u64) {
    let connection = |heard: Heard| match heard.message {
        Message::Connection(said) if said.state == state => Some((said.boot_id, said.seq)),
        _ => None,
    };
    supervisor.expect(state.as_str(), connection).await
}

const TAKEN: [SetpointOutcome; 3] = [SetpointOutcome::Received, SetpointOutcome::Applying, SetpointOutcome::Applied];

#[tokio::test]
async fn it_is_born_tells_what_is_on_it_and_leaves_a_will() {
    let mut scene = Scene::start().await;
    let boot_id = scene.boot_id.clone();
    let mut seqs = Vec::new();
    for kind in [None, Some(RequestKind::Factsheet)] {
        if let Some(request) = kind {
            let request = Request { boot_id: BootId::new("s1").unwrap(), seq: 0, request, touch_test: None };
            scene.supervisor.send(RobotTopic::Request, &request).await;
        }
        let factsheet = |heard: Heard| match heard.message {
            Message::Factsheet(facts) => Some((facts.seq, facts.boot_id, facts.arrays[0].whiskers.len())),
            _ => None,
        };
        let (seq, of, whiskers) = scene.supervisor.expect("a factsheet", factsheet).await;
        assert_eq!((&of, whiskers), (&boot_id, 3));
        seqs.push(seq);
    }
    assert_eq!(seqs, [0, 1]);
    let mut last_us = 0;
    for _ in 0..3 {
        let status = |heard: Heard| match heard.message {
            Message::Status(status) => Some((status.t_us, heard.qos)),
            _ => None,
        };
        let (t_us, qos) = scene.supervisor.expect("a status", status).await;
        assert_eq!(qos, QoS::AtMostOnce);
        assert!(last_us == 0 || (900_000..9_000_000).contains(&(t_us - last_us)), "expected one status per second");
        last_us = t_us;
    }
    scene.robot.process.kill();
    assert_eq!(connection(&mut scene.supervisor, ConnectionState::ConnectionBroken).await, (boot_id, 1));
}

#[tokio::test]
async fn a_setpoint_is_taken_followed_and_answered_again_but_not_applied_again() {
    let mut scene = Scene::start().await;
    let setpoint = Setpoint { pressure_mpa: 0.05, ..scene.setpoint(1) };
    let answers = scene.answered(&setpoint, &TAKEN).await;
    assert!((answers[2].pressure_mpa.unwrap() - 0.05).abs() < 1e-6);
    // 0.05 MPa at 0.1 MPa/s; the robot polls its regulator at most 20 times per second.
    let slewing_us = answers[2].t_us - answers[0].t_us;
    assert!((400_000..9_000_000).contains(&slewing_us), "{slewing_us} us");

    let next = Setpoint { pressure_mpa: 0.06, whisker: 2, ..scene.setpoint(2) };
    scene.answered(&next, &TAKEN).await;
    scene.answered(&setpoint, &[SetpointOutcome::Applied]).await;
    scene.rejected(&Setpoint { version: 1, ..scene.setpoint(3) }, SetpointError::Stale).await;
}

#[tokio::test]
async fn what_a_robot_must_not_take_is_rejected_with_its_reason() {
    let mut scene = Scene::start().await;
    scene.answered(&scene.setpoint(10), &TAKEN).await;
    let fresh = scene.setpoint(11);
    let other_boot = BootId::new("before").unwrap();
    scene.rejected(&Setpoint { version: 10, ..fresh.clone() }, SetpointError::Stale).await;
    scene.rejected(&Setpoint { epoch: 6, ..scene.setpoint(99) }, SetpointError::Stale).await;
    scene.rejected(&Setpoint { robot_boot_id: other_boot, ..scene.setpoint(100) }, SetpointError::WrongBoot).await;
    scene.rejected(&Setpoint { whisker: 3, ..scene.setpoint(101) }, SetpointError::UnknownWhisker).await;
    let right = Name::new("right").unwrap();
    scene.rejected(&Setpoint { array: right, ..scene.setpoint(102) }, SetpointError::UnknownWhisker).await;
    scene.rejected(&Setpoint { expires_us: now_us() - 1, ..scene.setpoint(12) }, SetpointError::Expired).await;
    scene.rejected(&Setpoint { pressure_mpa: 0.2001, ..scene.setpoint(13) }, SetpointError::OutOfRange).await;
    scene.rejected(&Setpoint { pressure_mpa: -0.001, ..scene.setpoint(14) }, SetpointError::OutOfRange).await;
    // A rejected setpoint still counts as seen, except one for another boot.
    scene.rejected(&Setpoint { version: 13, ..scene.setpoint(15) }, SetpointError::Stale).await;
    scene.answered(&Setpoint { version: 20, ..scene.setpoint(16) }, &TAKEN).await;
    scene.answered(&Setpoint { epoch: 8, version: 0, ..scene.setpoint(17) }, &TAKEN).await;
}

#[tokio::test]
async fn a_newer_setpoint_supersedes_one_under_way_and_junk_changes_nothing() {
    let mut scene = Scene::start().await;
    // A distant target, so that the first setpoint is still in progress when the next one arrives.
    let first = Setpoint { pressure_mpa: 0.2, slew_mpa_per_s: 0.001, ..scene.setpoint(1) };
    scene.answered(&first, &[SetpointOutcome::Received, SetpointOutcome::Applying]).await;
    for junk in ["{}", "nonsense", "[]", "7", r#"{"command_id":"x","epoch":9,"version":9}"#] {
        scene.supervisor.publish("whisker/v1/f/r/setpoint", junk.into(), false).await;
    }
    scene.heard_all().await;
    assert_eq!(scene.robot.complaints().lines().count(), 5, "{}", scene.robot.complaints());
    let second = scene.setpoint(2);
    scene.supervisor.send(RobotTopic::Setpoint, &second).await;
    let mut states = Vec::new();
    for _ in 0..4 {
        let answer = scene.answer().await;
        states.push((answer.command_id, answer.state));
    }
    let of = |setpoint: &Setpoint, state| (setpoint.command_id.clone(), state);
    let [received, applying, applied] = TAKEN.map(|state| of(&second, state));
    assert_eq!(states, [received, of(&first, SetpointOutcome::Superseded), applying, applied]);
}

#[tokio::test]
async fn contacts_come_again_after_pauses_that_double_until_a_receipt_covers_them() {
    let mut scene = Scene::start().await;
    let mut heard_at = Vec::new();
    while heard_at.len() < 3 {
        if scene.contacts().await == 0 {
            heard_at.push(Instant::now());
        }
    }
    let pauses: Vec<Duration> = heard_at.windows(2).map(|pair| pair[1] - pair[0]).collect();
    assert!(pauses[0] > Duration::from_millis(900) && pauses[1] > Duration::from_millis(1_900), "{pauses:?}");
    let receipt = |robot_boot_id: &str| Receipt {
        boot_id: BootId::new("s1").unwrap(),
        seq: 0,
        robot_boot_id: BootId::new(robot_boot_id).unwrap(),
        next: 5,
        held: vec![(7, 8)],
    };
    scene.supervisor.send(RobotTopic::Receipt, &receipt("another-boot")).await;
    while scene.contacts().await != 0 {}
    let boot_id = scene.boot_id.clone();
    scene.supervisor.send(RobotTopic::Receipt, &receipt(boot_id.as_str())).await;
    scene.heard_all().await;
    let mut again = Vec::new();
    while !(again.contains(&5) && again.contains(&6) && again.contains(&9)) {
        again.push(scene.contacts().await);
    }
    assert!(again.iter().all(|&seq| seq >= 5 && seq != 7 && seq != 8), "{again:?}");
}

#[tokio::test]
async fn its_times_run_evenly_and_its_setpoints_are_taken_while_the_clock_is_set() {
    let mut scene = Scene::with(|port| Script::start_while_the_clock_is_set(port, 1e6)).await;
    scene.answered(&scene.setpoint(1), &TAKEN).await;
    let mut times_us = std::collections::BTreeMap::new();
    while times_us.len() < 40 {
        let contacts = |heard: Heard| match heard.message {
            Message::Contacts(contacts) => Some((contacts.seq, contacts.contacts[0].t_us)),
            _ => None,
        };
        times_us.extend([scene.supervisor.expect("contacts", contacts).await]);
    }
    let of_one = times_us.iter().zip(times_us.iter().skip(1)).map(|(one, next)| (next.1 - one.1) / (next.0 - one.0));
    let of_one: Vec<u64> = of_one.collect();
    assert!(of_one.iter().all(|us| (40_000..1_000_000).contains(us)), "{of_one:?}");
    let ago_us = now_us().abs_diff(*times_us.values().max().expect("forty"));
    assert!(ago_us < 10_000_000, "its time is right: {ago_us}");
}

/// Uses the contract's own times and takes half a minute.
#[tokio::test(flavor = "multi_thread")]
async fn it_passes_the_check_of_robots() {
    let scene = Scene::start().await;
    let checked = tokio::process::Command::new(LABORATORY)
        .args(["check-robot", "--fleet", "f", "--robot", "r", "--broker"])
        .arg(format!("mqtt://127.0.0.1:{}", scene.broker.port()))
        .stdin(std::process::Stdio::null())
        .kill_on_drop(true)
        .output()
        .await
        .unwrap();
    let report = String::from_utf8_lossy(&checked.stdout);
    assert!(
        checked.status.success() && report.contains(" 0 failed"),
        "{report}{}",
        String::from_utf8_lossy(&checked.stderr)
    );
}
