//! Silence of robots: in portions, and never that of the supervisor itself.

use std::collections::HashSet;

use vibrissa_store::batch::Record;

use super::super::allow_list::AllowList;
use super::*;

#[test]
fn what_befalls_all_robots_at_once_is_written_in_several_transactions() {
    let mut worker = worker(5);
    let silent = worker.parts().1.params_of(&Name::robot("r1").unwrap()).health.stale_after.0 + 2;
    let mut rate = CheckpointRate::new(Micros(1));
    seal(&mut worker, Micros(1), &mut rate);
    let mut written = Vec::new();
    for round in 0.. {
        let now = Micros(silent + round);
        let is_done = worker.tick(now, &Delayed::new(), usize::from(WHISKERS) + 1);
        let rows = seal(&mut worker, now, &mut rate);
        assert!(rows.robots.len() <= 2, "two robots are enough for a transaction");
        assert_eq!(rows.records.is_empty(), rows.robots.is_empty(), "silence must lead to a fault");
        written.extend(rows.robots.iter().map(|row| row.robot_id));
        if is_done {
            break;
        }
    }
    assert_eq!(written, [1, 2, 3, 4, 5], "each robot once, in order");
}

/// All robots of a large fleet were written at once. That took too long for the database, which refused it each time.
#[test]
fn regress_after_an_outage_only_robots_that_would_become_silent_are_written_and_not_all_at_once() {
    let mut worker = worker(5);
    let stale_after = worker.parts().1.params_of(&Name::robot("r1").unwrap()).health.stale_after;
    let mut rate = CheckpointRate::new(Micros(1));
    seal(&mut worker, Micros(1), &mut rate);
    let back = Micros(stale_after.0 - 1);
    worker.restart_silence_timers(back);
    let rows = seal(&mut worker, back, &mut rate);
    assert!(rows.robots.is_empty(), "nobody is silent yet");
    // The second robot is heard before it would become silent.
    let mut world = World::new(1);
    world.now = Micros(stale_after.0);
    world.status(&mut worker, 2);
    worker.batch_mut().checkpoints().make_due();
    seal(&mut worker, world.now, &mut rate);

    let mut written = Vec::new();
    for round in 0.. {
        let now = Micros(stale_after.0 + 2 + round);
        let is_done = worker.tick(now, &Delayed::new(), usize::from(WHISKERS) + 1);
        let rows = seal(&mut worker, now, &mut rate);
        assert!(rows.robots.len() <= 2 && rows.records.is_empty(), "nobody is silent: {:?}", rows.records);
        written.extend(rows.robots.iter().map(|row| row.robot_id));
        if is_done {
            break;
        }
    }
    assert_eq!(written, [1, 3, 4, 5], "those that were not heard, once, in order");

    let late = back.after(stale_after).after(Micros(1));
    assert!(worker.tick(late, &Delayed::new(), usize::MAX));
    let silent: BTreeSet<i64> = seal(&mut worker, late, &mut rate).robots.iter().map(|row| row.robot_id).collect();
    assert_eq!(silent, BTreeSet::from([1, 3, 4, 5]), "silence after the outage counts");
}

/// Messages of a robot that sends too much wait. Its whiskers were found silent meanwhile.
#[test]
fn regress_a_robot_whose_messages_wait_is_not_silent() {
    let mut worker = worker(3);
    let silent = Micros(worker.parts().1.params_of(&Name::robot("r1").unwrap()).health.stale_after.0 + 2);
    let mut rate = CheckpointRate::new(Micros(1));
    seal(&mut worker, Micros(1), &mut rate);
    let faulty = |worker: &mut Worker, rate: &mut CheckpointRate| -> Vec<i64> {
        seal(worker, silent, rate).robots.iter().map(|row| row.robot_id).collect()
    };
    let delayed = Delayed::from([(b"r2".to_vec(), Micros(3)), (b"unknown".to_vec(), Micros(3))]);
    assert!(worker.tick(silent, &delayed, usize::MAX));
    assert_eq!(faulty(&mut worker, &mut rate), [1, 3]);
    // Once nothing of it waits, it has the time of all.
    assert!(worker.tick(silent, &Delayed::new(), usize::MAX));
    assert_eq!(faulty(&mut worker, &mut rate), [2]);
}

/// A roll-out reached a robot that was taken off the allow list. Its alarms stood until it was allowed again.
#[test]
fn regress_a_robot_that_the_allow_list_excludes_raises_no_alarm() {
    let mut worker = worker(1);
    let name = Name::robot("r1").unwrap();
    let silent = Micros(worker.parts().1.params_of(&name).health.stale_after.0 + 2);
    let mut rate = CheckpointRate::new(Micros(1));
    assert!(worker.tick(silent, &Delayed::new(), usize::MAX));
    let raised = |rows: &Batch| {
        let is_alarm = |record: &&Record| matches!(record, Record::Alarm(_) | Record::RobotAlarm(_));
        rows.records.iter().filter(is_alarm).count()
    };
    assert_eq!(raised(&seal(&mut worker, silent, &mut rate)), 1, "it is silent");

    let mut nobody = AllowList::default();
    nobody.set_listed(Some(HashSet::new()));
    worker.set_allow_list(nobody);
    worker.step_robot(&name, silent, &Event::PolicyChanged);
    assert_eq!(raised(&seal(&mut worker, silent, &mut rate)), 0, "nobody is responsible for it");
    assert_eq!(worker.robots()[&name].robot.standing().count(), 0);
}

/// A checkpoint between the exclusion and the next step made it miss alarms that were due: until the next status in a release
/// build; a debug build panicked.
#[test]
fn regress_alarms_of_an_excluded_robot_survive_checkpoints() {
    let mut worker = worker(1);
    let name = Name::robot("r1").unwrap();
    let now = Micros(4_000_000);
    let mut rate = CheckpointRate::new(Micros(1));
    let mut written = |worker: &mut Worker| {
        worker.batch_mut().checkpoints().make_due();
        seal(worker, now, &mut rate).records.iter().filter(|record| matches!(record, Record::Alarm(_))).count()
    };
    let (robots, stepper) = worker.parts();
    let (regulator, gauge) = (RegulatorState::Ok, GaugeState::Open);
    let pressure = robots[&name].robot.whisker(0).unwrap().setpoint;
    let broken = WhiskerStatus { array: "a", whisker: 0, pressure, setpoint: pressure, regulator, gauge };
    // A fault that lasts less than a second is no alarm.
    for at in [Micros(2_000_000), now] {
        let event = Event::Status { boot_id: "b", robot_time: at, whiskers: &[broken] };
        stepper.step(&mut robots[&name], at, &event, None);
    }
    assert_eq!(written(&mut worker), 1, "its gauge is broken");

    let list = |worker: &mut Worker, names: Option<HashSet<Name>>| {
        let mut listed = AllowList::default();
        listed.set_listed(names);
        worker.set_allow_list(listed);
    };
    list(&mut worker, Some(HashSet::new()));
    written(&mut worker);
    worker.step_robot(&name, now, &Event::PolicyChanged);
    assert_eq!(written(&mut worker), 0, "nobody is responsible for it");

    list(&mut worker, None);
    assert_eq!(written(&mut worker), 0, "nothing has happened yet");
    assert!(worker.tick(now, &Delayed::new(), usize::MAX));
    assert_eq!(written(&mut worker), 1, "it is supervised again, and its gauge is still broken");
}
