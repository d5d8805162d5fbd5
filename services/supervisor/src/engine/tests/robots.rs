//! Receipts of many robots, and robots that announce themselves.

use super::super::commit::journal::{Journal, JournalEvent};
use super::super::part::Part;
use super::*;
use crate::outbox::ToRobot;

#[test]
fn receipts_of_many_robots_go_out_in_turn() {
    let mut worker = worker(12);
    let (robots, stepper) = worker.parts();
    for known in robots.values_mut() {
        stepper.receipt(known, "b");
    }
    let mut sent = |most| {
        worker.publish_receipts(most);
        worker.batch_mut().take_publications().into_iter().map(|one| one.robot).collect::<Vec<_>>()
    };
    let (first, second, rest) = (sent(1), sent(4), sent(usize::MAX));
    assert_eq!([first.len(), second.len(), rest.len()], [3, 4, 5], "at least a quarter, at most the limit, all");
    let all: std::collections::BTreeSet<_> = [first, second, rest].concat().into_iter().collect();
    assert_eq!(all.len(), 12, "each robot once");
    assert!(sent(usize::MAX).is_empty());
}

#[test]
fn a_robot_that_was_only_announced_is_not_taken_up() {
    let (mut workers, mut replay) = (Workers::new(vec![worker(0)]), Replay::default());
    let stored = |robot_id: i64, held: bool| StoredRobot {
        robot_id,
        robot: format!("r{robot_id}"),
        state: None,
        software: "[]".to_owned(),
        whisker_ids: Vec::new(),
        whisker_states: Vec::new(),
        segmenters: Vec::new(),
        boots: BTreeMap::new(),
        rollups: Vec::new(),
        journal_number: 0,
        held,
        numbers: Numbers::default(),
    };
    for (robot_id, held) in [(1, false), (2, true)] {
        replay.load(stored(robot_id, held), Name::robot(&format!("r{robot_id}")).unwrap(), 7, &mut workers);
    }
    let names: Vec<&str> = workers.robots().map(|known| known.name.as_str()).collect();
    assert_eq!(names, ["r2"], "a held robot must be kept");
}

#[test]
fn robots_of_a_newer_program_get_no_tick_by_a_replay() {
    let ticks = |waits: bool| {
        let (mut worker, now) = (worker(2), Micros(5_000_000));
        let mut rate = CheckpointRate::new(Micros(1));
        worker.set_part(Part { number: 0, of: 1 });
        if waits {
            worker.leave_to_newer_program(Name::robot("r9").unwrap(), 9);
        }
        seal(&mut worker, Micros(1), &mut rate);
        let mut world = World::new(1);
        [1, 2].into_iter().for_each(|robot_id| world.status(&mut worker, robot_id));
        worker.tick(now, &Delayed::new(), usize::MAX);
        let row = seal(&mut worker, now, &mut rate).journal.unwrap();
        let row = StoredEntries::new(JournalReading { number: row.number, log_partition: 0, entries: row.entries });
        let entries = row.entries().map(Result::unwrap);
        let ticks = entries.filter(|entry| matches!(entry.event, JournalEvent::Tick | JournalEvent::TickAll { .. }));
        ticks.map(|entry| entry.robot_id).collect::<Vec<_>>()
    };
    // No robot has the number 0: it is the tick of all.
    assert_eq!((ticks(false), ticks(true)), (vec![0], vec![1, 2]));
}

/// A new owner had excused a robot's silence, and read nothing of it but a repeated message. The next owner replayed the message,
/// and then the ticks of all for the robot: it was called silent.
#[test]
fn regress_a_robot_whose_records_changed_nothing_gets_no_tick_by_a_replay() {
    let (mut live, mut world, mut tables) = (worker(1), World::new(1), Tables::default());
    let name = Name::robot("r1").unwrap();
    let contacts = [Contact { temperature_c: Some(20.0), ..world.contact(1, PRESSURE_MPA) }];
    let message = protocol::Contacts {
        boot_id: BootId::new("b").unwrap(),
        seq: 0,
        contacts: contacts.iter().map(as_sent).collect(),
        missed: Vec::new(),
    };
    let event = Event::Contacts { boot_id: "b", seq: 0, contacts: &contacts, missed: &[] };
    let (robots, stepper) = live.parts();
    stepper.step(&mut robots[&name], world.now, &event, Some(Source { message: &message, boot: 1 }));
    let silent = world.now.after(stepper.params_of(&name).health.stale_after).after(Micros(2));
    live.batch_mut().checkpoints().make_due();
    tables.write(seal(&mut live, world.now, &mut CheckpointRate::new(Micros(1))));

    let mut journal = Journal::default();
    journal.contacts(&live.robots()[&name], world.now, &event, Some(&message));
    let before = journal.bytes();
    journal.tick_all(before, silent, Part { number: 0, of: 1 });
    let reading = JournalReading { number: 100, log_partition: 0, entries: journal.take().0 };
    let (mut workers, mut replay) = (Workers::new(vec![worker(0)]), Replay::default());
    replay.load(tables.stored(1), name.clone(), 7, &mut workers);
    assert_eq!(replay.replay_row(&StoredEntries::new(reading), &LogRecords::new(), &mut workers), 1);
    assert_eq!(workers.robot(&name).unwrap().robot.standing().count(), 0, "its owner had heard no more of it");
}

fn raw_message(robot: &str, kind: RobotTopic, payload: Vec<u8>) -> RawMessage {
    let robot = Name::robot(robot).unwrap();
    let topic = kind.of(&Name::new("f").unwrap(), &robot);
    RawMessage { topic, robot, kind, payload: payload.into(), received: Micros(1) }
}

fn birth(robot: &str, boot_id: &str) -> RawMessage {
    let connection = protocol::Connection {
        boot_id: BootId::new(boot_id).unwrap(),
        seq: 0,
        timestamp: protocol::Timestamp(0),
        state: protocol::ConnectionState::Online,
    };
    raw_message(robot, RobotTopic::Connection, protocol::encode(&connection))
}

#[test]
fn a_robot_has_some_new_boots_at_once_and_the_last_one_that_was_refused_later() {
    let mut worker = worker(1);
    for number in 1..=BOOTS_AT_ONCE + 2 {
        worker.handle(&birth("r1", &format!("new-{number}")));
    }
    let known = &worker.robots()["r1"];
    assert_eq!(known.robot.connection_state().0, Some("new-10"));
    assert_eq!(known.refused_boot.as_ref().map(BootId::as_str), Some("new-12"));
    assert_eq!(worker.metrics().messages_refused.of(["too_many_boots"]).get(), 2);
    worker.tick(Micros(2), &Delayed::new(), 1000);
    assert_eq!(worker.robots()["r1"].robot.connection_state().0, Some("new-10"), "the limit does not allow it yet");
    // A full bucket, as after a minute.
    worker.robots_mut()["r1"].new_boots = Bucket::new(1, 1);
    worker.tick(Micros(3), &Delayed::new(), 1000);
    let known = &worker.robots()["r1"];
    assert_eq!((known.robot.connection_state().0, &known.refused_boot), (Some("new-12"), &None));
}

#[test]
fn births_make_nothing_known_and_a_factsheet_without_its_birth_neither() {
    let mut worker = worker(0);
    let factsheet = |robot: &str| {
        let facts = protocol::Factsheet {
            boot_id: BootId::new("b").unwrap(),
            seq: 0,
            timestamp: protocol::Timestamp(0),
            model: "m".to_owned(),
            on_supervisor_loss: protocol::OnSupervisorLoss::Hold,
            arrays: Vec::new(),
            touch_tests: Vec::new(),
            applies_gain: false,
            air_control: Default::default(),
            software: Vec::new(),
        };
        raw_message(robot, RobotTopic::Factsheet, protocol::encode(&facts))
    };
    assert!(worker.factsheet(&factsheet("r1")).is_none(), "refused without a birth");
    for number in 1..=5000 {
        worker.handle(&birth(&format!("r{number}"), "b"));
    }
    assert!(worker.robots().is_empty() && worker.batch().is_empty(), "nothing is written for a birth");
    assert!(worker.factsheet(&factsheet("r5000")).is_some());
    assert!(worker.factsheet(&factsheet("r1")).is_none(), "its announcement must be forgotten");
    worker.tick(Micros(5_000_000), &Delayed::new(), 1000);
    let asked = worker.batch_mut().take_publications().len();
    assert!((1000..=1024).contains(&asked), "their factsheets must be requested: {asked}");
}

/// A robot whose factsheet is refused has none, like one whose factsheet has not arrived.
#[test]
fn a_refused_factsheet_is_missing_after_half_a_minute() {
    let mut worker = worker(0);
    worker.handle(&birth("r1", "b"));
    let missing = |worker: &mut Worker, seconds: u64| {
        let mut without = Found::default();
        let now = tokio::time::Instant::now() + std::time::Duration::from_secs(seconds);
        worker.find_without_factsheet(now, &mut without);
        without.one.map(|name| name.to_string())
    };
    let refused = raw_message("r1", RobotTopic::Factsheet, b"{\"boot_id\":\"b\"}".to_vec());
    assert!(worker.factsheet(&refused).is_none(), "it lacks everything else");
    assert_eq!(missing(&mut worker, 0), None);
    assert_eq!(missing(&mut worker, 31).as_deref(), Some("r1"));
}

/// The log named the index within the robot, without fleet and array.
#[test]
fn regress_a_full_name_counts_within_the_array() {
    let mut worker = worker(1);
    let (robots, stepper) = worker.parts();
    let known = &mut robots["r1"];
    let mut factsheet = factsheet();
    let mut second = factsheet.arrays[0].clone();
    second.name = "right".to_owned();
    factsheet.arrays.push(second);
    stepper.step(known, Micros(2), &Event::Factsheet { boot_id: "b", factsheet: &factsheet }, None);
    let names = [0, 5, 6, 7, 12].map(|index| known.full_name_of(index).to_string());
    assert_eq!(names, ["f/r1/a/0", "f/r1/a/5", "f/r1/right/0", "f/r1/right/1", "f/r1"]);
}

/// A broker ended the connection of a robot for its large factsheet, again and again. Each end began the time anew.
#[test]
fn regress_a_missing_factsheet_is_told_although_the_connection_breaks_again_and_again() {
    use std::time::Duration;
    use tokio::time::Instant;
    let (mut worker, begin) = (worker(2), Instant::now());
    let missing = |worker: &mut Worker, seconds: u64| {
        let mut without = Found::default();
        worker.find_without_factsheet(begin + Duration::from_secs(seconds), &mut without);
        without.one.map(|name| name.to_string())
    };
    let link = |worker: &mut Worker, boot_id: &str, link| {
        let (robots, stepper) = worker.parts();
        stepper.step(&mut robots["r1"], Micros(1), &Event::Connection { boot_id, link }, None);
    };
    assert_eq!(missing(&mut worker, 0), None, "both have factsheets");
    for second in 0..30 {
        link(&mut worker, "new", [Link::Online, Link::Broken][second as usize % 2]);
        assert_eq!(missing(&mut worker, second), None, "{second} s");
    }
    assert_eq!(missing(&mut worker, 31).as_deref(), Some("r1"));
    link(&mut worker, "new", Link::Offline);
    assert_eq!(missing(&mut worker, 32), None, "it has left in order");
    link(&mut worker, "new", Link::Broken);
    assert_eq!(missing(&mut worker, 90), None);
    link(&mut worker, "b", Link::Online);
    assert_eq!(missing(&mut worker, 91), None, "its factsheet is known");
}

/// A robot was decommissioned while the broker was away: its last messages stayed there.
#[test]
fn regress_retained_messages_of_a_decommissioned_robot_are_cleared_again_after_a_loss() {
    let mut workers = Workers::new(vec![worker(2)]);
    let name = Name::robot("r1").unwrap();
    let known = workers.of(&name).take_out(&name).unwrap();
    workers.of(&name).forget(known);
    let cleared = |workers: &mut Workers| {
        workers.publish_estimates(tokio::time::Instant::now());
        let sent = workers.of(&name).batch_mut().take_publications();
        sent.iter().filter(|one| one.robot == name && matches!(one.message, ToRobot::Cleared(_))).count()
    };
    let at_once = cleared(&mut workers);
    assert!(at_once > 0);
    assert_eq!(cleared(&mut workers), 0);
    workers.repeat_retained();
    assert_eq!([cleared(&mut workers), cleared(&mut workers)], [at_once, 0]);
}
