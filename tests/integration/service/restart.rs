//! The service stops at any moment, orderly or not, and continues from its last commit.

use std::path::Path;

use serde_json::Value;
use sqlx::sqlite::{SqliteConnectOptions, SqliteConnection};
use sqlx::{ConnectOptions, Connection};
use vibrissa_protocol::{
    ArrayType, BootId, Message, RobotTopic, SetpointOutcome, SupervisorPresence, SupervisorState, encode,
};
use vibrissa_simulator::{Broker, Fleet, Scenario};
use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::observer::Observer;
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::{until, until_true};

use crate::database::Database;
use crate::program::{Ending, Program};
use crate::running::{LEARNED, Running, database_in, list, quick};

/// Robot `one` is compensated; then robot `two` is cut so much that its chamber vents for seconds.
const SCENARIO: &str = r#"
fleet = "f"
seed = 7
[behaviour]
contacts_per_second = 100.0
contacts_per_message = 10
message_after_s = 0.2
[[robots]]
robot = "one"
arrays = [{ array = "left", type = "TYPE_2", whiskers = [{ whisker = 0 }, { whisker = 1 }] }]
events = [{ at_contact = 100, array = "left", whisker = 0, change = { kind = "TRIM", length_mm = 68.0 } }]
[[robots]]
robot = "two"
arrays = [{ array = "left", type = "TYPE_2", whiskers = [{ whisker = 0 }, { whisker = 1 }] }]
events = [{ at_contact = 350, array = "left", whisker = 0, change = { kind = "TRIM", length_mm = 62.0 } }]
"#;

fn start_fleet(broker: &Mosquitto) -> Fleet {
    let scenario = Scenario::from_toml_str(SCENARIO).unwrap();
    Fleet::start(&scenario, &Broker::new("127.0.0.1", broker.port())).unwrap()
}

/// Waits until the robots have made this many further contacts.
async fn more_contacts(fleet: &Fleet, more: u64) {
    let goal = fleet.contacts_made() + more;
    until_true("more contacts", async || fleet.contacts_made() >= goal).await;
}

/// Stops the contacts, waits until every message is receipted, and checks that each contact is recorded once.
async fn assert_each_contact_is_there_once(fleet: &Fleet, database: &Database) {
    fleet.rest();
    until_true("every message receipted", async || fleet.is_receipted()).await;
    let made = fleet.contacts_made() as i64;
    assert_eq!(database.counted().await, (made, made));
}

/// State of a robot's newest setpoint for a compensation.
fn setpoint_state<'a>(compensations: &'a [Value], robot: &str) -> Option<&'a str> {
    compensations.iter().find(|one| one["robot"] == robot)?["setpoint_state"].as_str()
}

/// The supervisor's next state that differs from `last`, because states are repeated. Becomes the last one.
async fn next_supervisor_state(
    observer: &mut Observer,
    last: &mut Option<(SupervisorPresence, u64)>,
) -> (SupervisorPresence, u64) {
    observer
        .expect("a supervisor's state", |heard| match heard.message {
            Message::SupervisorState(state) => {
                let new = (state.state, state.epoch);
                (last.replace(new) != Some(new)).then_some(new)
            }
            _ => None,
        })
        .await
}

/// Ends the program while robot `two` vents, and starts it again after a while.
async fn goes_on_after(ending: Ending) {
    let broker = Mosquitto::start();
    let folder = tempfile::tempdir().unwrap();
    let path = database_in(&folder);
    let mut observer = Observer::subscribed(broker.port(), "observer", &["whisker/v1/f/supervisor/state"]).await;
    let mut last = None;
    let program = Program::start(&path, broker.port());
    let (presence, first) = next_supervisor_state(&mut observer, &mut last).await;
    assert_eq!(presence, SupervisorPresence::Online);
    let fleet = start_fleet(&broker);
    until_true("one compensated and two on its way", async || {
        let compensations = list(program.http, "compensations").await;
        setpoint_state(&compensations, "one") == Some("APPLIED")
            && setpoint_state(&compensations, "two") == Some("APPLYING")
    })
    .await;

    program.end(ending).await;
    assert_eq!(next_supervisor_state(&mut observer, &mut last).await, (SupervisorPresence::Offline, first));
    let database = Database::open(&path).await;
    let before = conditions(&database).await;
    more_contacts(&fleet, 200).await;
    let program = Program::start(&path, broker.port());
    let (presence, second) = next_supervisor_state(&mut observer, &mut last).await;
    assert!(presence == SupervisorPresence::Online && second > first, "{presence:?} in epoch {second} after {first}");
    assert_eq!(conditions(&database).await, before, "conditions must be restored");

    until_true("two compensated", async || {
        setpoint_state(&list(program.http, "compensations").await, "two") == Some("APPLIED")
    })
    .await;
    more_contacts(&fleet, 200).await;
    assert_each_contact_is_there_once(&fleet, &database).await;
    assert_eq!(conditions(&database).await, before, "nothing may be learned or detected again");
    assert_went_on(&database).await;
    program.end(Ending::Terminated).await;
    fleet.stop().await;
}

async fn conditions(database: &Database) -> Vec<String> {
    database.texts("SELECT condition || coalesce(fault, '') FROM whiskers ORDER BY whisker_id").await
}

/// Checks that learning, lengths, decisions and setpoints continue without a restart.
async fn assert_went_on(database: &Database) {
    let learned = database.number("SELECT count(*) FROM contacts WHERE used = 'LEARNING'").await;
    assert_eq!(learned, 4 * LEARNED as i64, "each of the four whiskers must learn once");
    assert_eq!(database.number("SELECT count(pressure_mpa) FROM trims").await, 2);
    assert_eq!(database.number("SELECT count(*) FROM compensations").await, 2, "each trim must be decided once");
    assert_eq!(database.number("SELECT count(*) FROM compensations WHERE ended_us IS NOT NULL").await, 0);
    // A refinement may be pending at any moment; setpoints of decisions are sent once.
    let decided = database.texts("SELECT state FROM setpoints WHERE reason <> 'REFINEMENT'").await;
    assert_eq!(decided, ["APPLIED", "APPLIED"]);

    let contacts = database.contacts().await;
    for robot in ["one", "two"] {
        let whole: Vec<f64> =
            contacts.iter().filter(|one| one.robot == robot && one.whisker == 1).map(|one| one.length_mm).collect();
        let jump = whole.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
        assert!(jump < 0.1, "the length of an uncut whisker jumps by {jump} mm");
    }
    let cut = contacts.iter().rfind(|one| one.robot == "one" && one.whisker == 0).unwrap();
    assert!((cut.length_mm - 68.0).abs() < 1.0, "{cut:?}");
}

#[tokio::test]
async fn a_supervisor_that_was_terminated_goes_on_where_it_was() {
    goes_on_after(Ending::Terminated).await;
}

#[tokio::test]
async fn a_supervisor_that_was_killed_goes_on_where_its_last_commit_was() {
    goes_on_after(Ending::Killed).await;
}

#[tokio::test]
async fn no_contact_is_missing_or_there_twice_when_the_supervisor_is_killed_again_and_again() {
    let broker = Mosquitto::start();
    let folder = tempfile::tempdir().unwrap();
    let fleet = start_fleet(&broker);
    let database = database_in(&folder);
    let owners = async || Database::early_number(&database, "SELECT count(*) FROM epochs").await;
    for number in 1..5 {
        let program = Program::start(&database, broker.port());
        until_true("the supervisor owns the fleet", async || owners().await == number).await;
        more_contacts(&fleet, 150).await;
        program.end(Ending::Killed).await;
    }
    let program = Program::start(&database_in(&folder), broker.port());
    let database = Database::open(&database_in(&folder)).await;
    assert_each_contact_is_there_once(&fleet, &database).await;
    assert_eq!(database.number("SELECT count(*) FROM epochs").await, 5);
    program.end(Ending::Terminated).await;
    fleet.stop().await;
}

#[tokio::test]
async fn no_contact_is_missing_or_there_twice_when_the_broker_is_killed() {
    let mut broker = Mosquitto::start();
    let running = Running::with(quick(), Some(broker.port())).await;
    let fleet = start_fleet(&broker);
    for _ in 0..2 {
        more_contacts(&fleet, 200).await;
        broker.kill();
        more_contacts(&fleet, 100).await;
        broker.restart();
    }
    more_contacts(&fleet, 200).await;
    assert_each_contact_is_there_once(&fleet, &running.database).await;
    running.service.stop().await;
    fleet.stop().await;
}

#[tokio::test]
async fn a_message_from_before_the_restart_changes_nothing_when_it_comes_again() {
    let broker = Mosquitto::start();
    let running = Running::with(quick(), Some(broker.port())).await;
    let mut robot = HandRobot::born(broker.port(), "r", array(ArrayType::Type2, &[70.0])).await;
    let contacts = vec![robot.contact(0)];
    let of_old_boot = robot.send(contacts).await;
    robot.receipted().await;
    robot.restart();
    robot.birth().await;
    robot.settle().await;
    let contacts = vec![robot.contact(0), robot.contact(0)];
    let of_this_boot = robot.send(contacts).await;
    robot.receipted().await;

    let running = running.again(quick(), Some(broker.port())).await;
    for message in [&of_old_boot, &of_this_boot] {
        robot.say(RobotTopic::Contacts, encode(message)).await;
    }
    until_true("two duplicates", async || {
        running.metric("vibrissa_messages_duplicate_total{fleet=\"f\"}").await == 2.0
    })
    .await;
    assert_eq!(running.database.counted().await, (3, 3));
    robot.touch(0, 1).await;
    robot.receipted().await;
    assert_eq!(running.database.counted().await, (4, 4));
    running.service.stop().await;
}

#[tokio::test]
async fn what_is_held_beyond_a_gap_survives_a_restart() {
    let broker = Mosquitto::start();
    let running = Running::with(quick(), Some(broker.port())).await;
    let mut robot = HandRobot::born(broker.port(), "r", array(ArrayType::Type2, &[70.0])).await;
    let one = |robot: &mut HandRobot| vec![robot.contact(0)];
    let contacts = one(&mut robot);
    let before = robot.send(contacts).await.seq;
    let contacts = one(&mut robot);
    let lost = robot.message(contacts);
    let contacts = one(&mut robot);
    let beyond = robot.send(contacts).await;
    let receipt = async |robot: &mut HandRobot, next: u64, held: &[(u64, u64)]| {
        robot
            .hear("the receipt", |heard| match &heard.message {
                Message::Receipt(received) => (received.next == next && received.held == held).then_some(()),
                _ => None,
            })
            .await;
    };
    receipt(&mut robot, before + 1, &[(beyond.seq, beyond.seq)]).await;

    let running = running.again(quick(), Some(broker.port())).await;
    robot.say(RobotTopic::Contacts, encode(&beyond)).await;
    receipt(&mut robot, before + 1, &[(beyond.seq, beyond.seq)]).await;
    robot.say(RobotTopic::Contacts, encode(&lost)).await;
    receipt(&mut robot, beyond.seq + 1, &[]).await;
    assert_eq!(running.metric("vibrissa_messages_duplicate_total{fleet=\"f\"}").await, 1.0);
    assert_eq!(running.database.counted().await, (3, 3));
    running.service.stop().await;
}

/// Lets a whisker learn, cuts it and returns the setpoint that follows.
async fn cut(robot: &mut HandRobot, length_mm: f64) -> vibrissa_protocol::Setpoint {
    robot.touch(0, LEARNED + 20).await;
    robot.cut(0, length_mm);
    robot.touch(0, 80).await;
    robot.setpoint().await.0
}

#[tokio::test]
async fn a_setpoint_whose_end_was_not_heard_is_asked_after() {
    let broker = Mosquitto::start();
    let running = Running::with(quick(), Some(broker.port())).await;
    let mut robot = HandRobot::born(broker.port(), "r", array(ArrayType::Type2, &[70.0])).await;
    let setpoint = cut(&mut robot, 66.0).await;
    robot.answer(&setpoint, SetpointOutcome::Applying, None).await;
    let state = "SELECT state FROM setpoints";
    until("the setpoint on its way", async || {
        running.database.texts(state).await.contains(&"APPLYING".to_owned()).then_some(())
    })
    .await;

    let running = running.again(quick(), Some(broker.port())).await;
    let (again, _) = robot.setpoint().await;
    assert_eq!((&again.command_id, again.epoch, again.seq), (&setpoint.command_id, setpoint.epoch, 0));
    assert_ne!(again.boot_id, setpoint.boot_id);
    robot.answer(&again, SetpointOutcome::Applied, None).await;
    until_true("the setpoint applied", async || running.database.texts(state).await == ["APPLIED"]).await;
    running.service.stop().await;
}

async fn spoil_the_states(path: &Path) {
    let options = SqliteConnectOptions::new().filename(path);
    let mut database: SqliteConnection = options.connect().await.unwrap();
    sqlx::query("UPDATE robots SET state = x'00'").execute(&mut database).await.unwrap();
    database.close().await.unwrap();
}

#[tokio::test]
async fn a_robot_whose_stored_state_cannot_be_read_starts_anew_and_its_trims_have_new_numbers() {
    let broker = Mosquitto::start();
    let running = Running::with(quick(), Some(broker.port())).await;
    let mut robot = HandRobot::born(broker.port(), "r", array(ArrayType::Type2, &[70.0])).await;
    let setpoint = cut(&mut robot, 68.0).await;
    robot.answer(&setpoint, SetpointOutcome::Applied, None).await;
    robot.touch(0, 1).await;
    robot.receipted().await;

    let folder = running.stop().await;
    spoil_the_states(&database_in(&folder)).await;
    let running = Running::on(folder, quick(), Some(broker.port())).await;
    robot.restart();
    robot.birth().await;
    robot.settle().await;
    cut(&mut robot, 64.0).await;
    robot.receipted().await;
    assert_eq!(running.database.number("SELECT count(*) FROM trims").await, 2);
    assert_eq!(running.database.number("SELECT count(*) FROM compensations").await, 2);
    running.service.stop().await;
}

/// The broker may declare a frozen supervisor dead long after another one has acquired its fleet.
#[tokio::test]
async fn a_predecessors_late_will_does_not_stay_the_last_word() {
    let broker = Mosquitto::start();
    let folder = tempfile::tempdir().unwrap();
    let topic = "whisker/v1/f/supervisor/state";
    let mut observer = Observer::subscribed(broker.port(), "observer", &[topic]).await;
    let mut last = None;
    let program = Program::start(&database_in(&folder), broker.port());
    let (_, first) = next_supervisor_state(&mut observer, &mut last).await;
    program.end(Ending::Terminated).await;
    assert_eq!(next_supervisor_state(&mut observer, &mut last).await, (SupervisorPresence::Offline, first));
    let program = Program::start(&database_in(&folder), broker.port());
    let (_, second) = next_supervisor_state(&mut observer, &mut last).await;
    // The will of the predecessor, its return for a moment, and the will of one of its earlier connections.
    let (online, offline) = (SupervisorPresence::Online, SupervisorPresence::Offline);
    for (state, epoch) in [(offline, first), (online, first), (offline, second)] {
        let boot_id = BootId::new("before").unwrap();
        let late = SupervisorState { boot_id, seq: 1, state, epoch };
        observer.publish(topic, encode(&late), true).await;
        assert_eq!(next_supervisor_state(&mut observer, &mut last).await, (state, epoch));
        assert_eq!(next_supervisor_state(&mut observer, &mut last).await, (SupervisorPresence::Online, second));
    }
    program.end(Ending::Terminated).await;
}
