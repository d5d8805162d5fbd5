//! Two robots under one name, and what looks like them.

use vibrissa_core::robot::effect::{AlarmKind, Effect};
use vibrissa_core::robot::event::Link;
use vibrissa_core::robot::{Admission, Event, Outcome, Robot};

use crate::by_hand::ByHand;

const PLAIN: (f64, f64, f64) = (0.85, 2.4, 0.0117);

/// Alarms about the robot that were raised (true) and cleared.
fn alarms(one: &ByHand) -> Vec<(bool, AlarmKind)> {
    let alarm = |effect: &Effect| match effect {
        Effect::RobotAlarm { kind } => Some((true, *kind)),
        Effect::RobotAlarmCleared { kind } => Some((false, *kind)),
        _ => None,
    };
    one.effects.iter().filter_map(alarm).collect()
}

fn connects(one: &mut ByHand, boot_id: &str, link: Link) -> Outcome {
    one.passes_s(0.1);
    one.step(&Event::Connection { boot_id, link })
}

/// One robot, and a second one with a newer boot.
fn two() -> ByHand {
    let mut one = ByHand::born(70.0);
    one.status(0);
    one.passes_s(1.0);
    one.boots("b2", 70.0);
    for _ in 0..3 {
        one.passes_s(1.0);
        one.touched(&[(PLAIN, 0)]);
        one.status(0);
    }
    one.effects.clear();
    one
}

/// Four reconnections a second led to 152 alarms, none of which named the cause.
#[test]
fn regress_two_robots_with_one_name_have_one_alarm_and_nothing_is_learned_from_them() {
    let mut one = two();
    let contacts = |one: &ByHand| one.robot.whisker(0).unwrap().contacts;
    for round in 0..400 {
        connects(&mut one, "b2", Link::Broken);
        assert_eq!(connects(&mut one, "b1", Link::Online), Outcome::OldBoot);
        connects(&mut one, "b2", Link::Online);
        if round > 3 {
            assert_eq!(one.touched(&[(PLAIN, 0)]), Outcome::NotYet(Admission::TwoRobots));
            assert_eq!(one.asked_for(0.05), None);
        }
        one.step(&Event::Tick);
    }
    let lasting = |(_, kind): &(bool, AlarmKind)| *kind == AlarmKind::DuplicateRobot;
    assert_eq!(alarms(&one).into_iter().filter(lasting).collect::<Vec<_>>(), [(true, AlarmKind::DuplicateRobot)]);
    // Before it is certain, a lost connection is one.
    assert!(alarms(&one).len() <= 7, "{:?}", alarms(&one));
    assert_eq!(one.robot.standing().collect::<Vec<_>>(), [AlarmKind::DuplicateRobot]);
    assert_eq!(contacts(&one), 3);
    let bytes = (one.robot.to_bytes().unwrap(), one.robot.whisker_to_bytes(0).unwrap());
    let stored = Robot::restore(&bytes.0, &[bytes.1]).unwrap();
    assert_eq!(stored.standing().collect::<Vec<_>>(), [AlarmKind::DuplicateRobot], "after a restart, too");

    // One of them is gone.
    for _ in 0..70 {
        one.passes_s(1.0);
        one.status(0);
        one.step(&Event::Tick);
    }
    assert_eq!(one.robot.standing().count(), 0);
    assert_eq!(alarms(&one).last(), Some(&(false, AlarmKind::DuplicateRobot)));
    assert_eq!(one.touched(&[(PLAIN, 0)]), Outcome::Taken);
    assert!(one.asked_for(0.05).is_some());
}

#[test]
fn a_kept_birth_restarts_and_repeated_births_are_no_second_robot() {
    let mut one = two();
    for _ in 0..5 {
        // The broker has kept a birth, and repeats it when the supervisor connects.
        connects(&mut one, "b1", Link::Online);
        for _ in 0..20 {
            connects(&mut one, "b2", Link::Online);
        }
        one.passes_s(61.0);
        one.step(&Event::Tick);
    }
    for boot in 3..20 {
        one.boots(&format!("b{boot}"), 70.0);
        one.passes_s(1.0);
    }
    assert!(alarms(&one).iter().all(|(_, kind)| *kind != AlarmKind::DuplicateRobot), "{:?}", alarms(&one));
}
