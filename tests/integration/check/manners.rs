//! Conditions under which a check does not begin, and early ends of a check.

use std::time::Duration;

use vibrissa_lab::check::{CheckOptions, Help, Outcome, Progress, check};
use vibrissa_protocol::{
    BootId, Connection as Told, ConnectionState, RobotTopic, Rule, SupervisorPresence, Timestamp, encode,
};
use vibrissa_simulator::clock::now_us;
use vibrissa_simulator::places::Places;
use vibrissa_simulator::{Broker, Fleet};
use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::observer::Observer;
use vibrissa_tests::wait::until_true;

use super::{EPOCH, FLEET, connection, options, robot, scenario_of, setpoint, supervisor, topic};

/// The reason why a check of robot `r` ends before it has begun.
async fn refusal(broker: &Mosquitto) -> String {
    let ended = check(&connection(broker, "r"), options("r"), &mut |_| {}, std::future::pending()).await;
    format!("{:#}", ended.unwrap_err())
}

#[tokio::test(flavor = "multi_thread")]
async fn nothing_is_checked_while_a_supervisor_owns_the_fleet() {
    let broker = Mosquitto::start();
    supervisor(&broker, SupervisorPresence::Online).await;
    let (fleet, robot) = robot(&broker, "r", None).await;
    let why = refusal(&broker).await;
    assert!(why.contains("stop the supervisor first") && why.contains("epoch 6"), "{why}");
    assert_eq!(robot.with(|robot| robot.messages_refused()), 0);
    fleet.stop().await;
}

/// Robots answer a request for births there, and the rules about retained messages are not judged.
#[tokio::test(flavor = "multi_thread")]
async fn a_robot_is_checked_with_a_broker_that_retains_nothing() {
    let broker = Mosquitto::builder().line("retain_available false").start();
    let (fleet, _) = robot(&broker, "r", None).await;
    let options = CheckOptions { help: Help::None, ..options("r") };
    let report =
        check(&connection(&broker, "r"), options, &mut |_: Progress| {}, std::future::pending()).await.unwrap();
    assert_eq!(report.rules(Outcome::Fail), [], "{report}");
    let seen = |rule: Rule| report.findings.iter().find(|one| one.rule == rule).map_or("", |one| one.seen.as_str());
    assert_eq!(seen(Rule::FactsheetRetained), "the broker retains no messages");
    assert_eq!(seen(Rule::Birth), "ONLINE; the broker retains no messages");
    assert_eq!(seen(Rule::FactsheetAfterBirth), "it followed the birth");
    fleet.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_robot_that_is_not_there_is_told_so() {
    let broker = Mosquitto::start();
    let why = refusal(&broker).await;
    assert!(why.contains("no message of f/r"), "{why}");
    let observer = Observer::subscribed(broker.port(), "left", &[]).await;
    let (boot_id, state) = (BootId::new("b1").unwrap(), ConnectionState::ConnectionBroken);
    let message = Told { boot_id, seq: 1, timestamp: Timestamp(0), state };
    observer.publish(&topic("r", RobotTopic::Connection), encode(&message), true).await;
    let why = refusal(&broker).await;
    assert!(why.contains("not connected") && why.contains("CONNECTION_BROKEN"), "{why}");
}

#[tokio::test(flavor = "multi_thread")]
async fn an_interrupted_check_puts_the_pressure_back() {
    let broker = Mosquitto::start();
    supervisor(&broker, SupervisorPresence::Offline).await;
    let (fleet, robot) = robot(&broker, "r", None).await;
    let target_mpa = || robot.with(|robot| robot.whiskers()[0].regulator().target_mpa());
    // Stops the check as soon as the chamber has another setpoint.
    let stop = until_true("a setpoint", async || target_mpa() > 0.105);
    let report = check(&connection(&broker, "r"), options("r"), &mut |_: Progress| {}, stop).await.unwrap();
    assert!(report.is_interrupted);
    assert_eq!(target_mpa(), 0.1);
    assert!(report.notes.iter().any(|note| note.contains("0.1000 MPa was restored")), "{report}");
    assert_eq!(report.count(Outcome::Fail), 0, "{report}");
    assert!(report.rules(Outcome::Skipped).contains(&Rule::Supersede), "{report}");
    fleet.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn an_interrupted_check_withdraws_the_lengths_that_it_told() {
    let broker = Mosquitto::start();
    supervisor(&broker, SupervisorPresence::Offline).await;
    let mut scenario = scenario_of(FLEET, "r", None);
    scenario.behaviour.places = Places::EstimatedRatio;
    let fleet = Fleet::start(&scenario, &Broker::new("127.0.0.1", broker.port())).unwrap();
    let robot = fleet.robots()[0].clone();
    until_true("a connected robot", async || robot.with(|robot| robot.is_connected())).await;
    let lengths_mm = || robot.with(|robot| [0, 1].map(|index| robot.whiskers()[index].estimated_length_mm()));
    // Stops the check as soon as it has told a wrong length.
    let is_wrong = |sent_mm: &Option<f64>| sent_mm.is_some_and(|length_mm| length_mm != 70.0);
    let stop = until_true("a wrong length", async || lengths_mm().iter().any(is_wrong));
    // The help that this rule needs is there already; the other rules do not wait long for theirs.
    robot.with(|robot| {
        let array = robot.whiskers()[0].array().clone();
        [0, 1].iter().for_each(|&number| robot.touch_at_place(&array, number, Some(0.7)));
    });
    let mut options = CheckOptions { help: Help::All, ..options("r") };
    (options.timings.help, options.timings.fill) = (Duration::from_secs(2), Duration::from_secs(2));
    let report = check(&connection(&broker, "r"), options, &mut |_: Progress| {}, stop).await.unwrap();
    assert!(report.is_interrupted, "{report}");
    until_true("no estimates", async || lengths_mm() == [None; 2]).await;
    fleet.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_next_supervisors_setpoints_are_taken_after_a_check() {
    let broker = Mosquitto::start();
    supervisor(&broker, SupervisorPresence::Offline).await;
    let (fleet, robot) = robot(&broker, "r", None).await;
    let without = CheckOptions { help: Help::None, ..options("r") };
    let report = check(&connection(&broker, "r"), without, &mut |_| {}, std::future::pending()).await.unwrap();
    assert_eq!(report.count(Outcome::Fail), 0, "{report}");
    assert_eq!(report.epoch, EPOCH);
    let next = setpoint(&robot, EPOCH + 1, 1);
    let answers = robot.with(|robot| robot.receive(RobotTopic::Setpoint, &encode(&next), now_us()));
    assert_eq!(answers.len(), 2, "RECEIVED and APPLYING: {answers:?}");
    fleet.stop().await;
}

/// The check waits for a limited time, and fails no rule.
#[tokio::test(flavor = "multi_thread")]
async fn without_the_help_that_was_promised_rules_are_skipped_with_the_reason() {
    let broker = Mosquitto::start();
    supervisor(&broker, SupervisorPresence::Offline).await;
    let (fleet, _) = robot(&broker, "r", None).await;
    let mut options = CheckOptions { help: Help::All, ..options("r") };
    options.timings.help = Duration::from_secs(2);
    options.timings.fill = Duration::from_secs(2);
    let mut asked = Vec::new();
    let mut progress = |progress| {
        if let Progress::Act(action, _) = progress {
            asked.push(action.word());
        }
    };
    let report = check(&connection(&broker, "r"), options, &mut progress, std::future::pending()).await.unwrap();
    assert_eq!(report.count(Outcome::Fail), 0, "{report}");
    let why = |rule: Rule| {
        let finding = report.findings.iter().find(|one| one.rule == rule).unwrap();
        assert_eq!(finding.outcome, Outcome::Skipped, "{report}");
        finding.seen.clone()
    };
    for (rule, reason) in [
        (Rule::FailedWithReason, "the supply was not closed within 2.0 s"),
        (Rule::ContactsDropped, "raise --fill"),
        (Rule::Will, "the robot was not restarted within 2.0 s"),
        (Rule::Farewell, "the robot was not stopped within 2.0 s"),
        (Rule::EstimateLength, "the whisker was not touched at one place"),
        (Rule::OwnLevel, "--relay"),
    ] {
        assert!(why(rule).contains(reason), "{rule}: {}", why(rule));
    }
    let all = "close-supply open-supply touch rest cut-power stop touch-place rest";
    assert_eq!(asked.join(" "), all);
    fleet.stop().await;
}
