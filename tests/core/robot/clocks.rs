//! Times that are wrong: no single message decides how long a setpoint lives.

use vibrissa_core::robot::Outcome;
use vibrissa_core::robot::effect::{CommandState, Effect};
use vibrissa_core::units::Micros;

use crate::by_hand::{ByHand, S, YEAR_US};

/// A plausible contact of a whisker of 70 mm: ratio, deflection in mm, strain.
const PLAIN: (f64, f64, f64) = (0.85, 2.4, 0.0117);
/// 10 s, and 2.5 s for the way from 0.1 to 0.05 MPa.
const VALID_FOR_US: u64 = 12_500_000;

/// The life of a setpoint requested now, in us, by a robot's clock that is ahead by `ahead_us`.
fn left_us(one: &mut ByHand, ahead_us: i64) -> i64 {
    let command = one.asked_for(0.05).expect("a setpoint");
    command.expires.0 as i64 - one.time(ahead_us).0 as i64
}

#[test]
fn one_contact_with_a_wrong_time_leaves_the_expiry_of_setpoints() {
    for wrong_us in [YEAR_US, 23 * S as i64, -YEAR_US] {
        for at in 0..12 {
            let mut one = ByHand::born(70.0);
            for message in 0..12 {
                one.passes_s(0.5);
                let ahead_us = if message == at { wrong_us } else { 0 };
                // Among others of the same message, too.
                one.touched(&[(PLAIN, -1000), (PLAIN, ahead_us)]);
            }
            let left_us = left_us(&mut one, 0);
            assert!(
                (VALID_FOR_US as i64 - 1000..=VALID_FOR_US as i64).contains(&left_us),
                "{wrong_us} {at}: {left_us}"
            );
        }
    }
}

#[test]
fn contacts_with_times_that_cannot_be_count_without_their_times() {
    let mut one = ByHand::born(70.0);
    for _ in 0..5 {
        one.passes_s(1.0);
        assert_eq!(one.touched(&[(PLAIN, 0)]), Outcome::Taken);
    }
    let contacts = |one: &ByHand| one.robot.whisker(0).unwrap().contacts;
    assert_eq!((contacts(&one), one.bad_times()), (5, 0));
    let outcome = one.touched(&[(PLAIN, YEAR_US), (PLAIN, 0), (PLAIN, -YEAR_US), (PLAIN, -3_600 * S as i64)]);
    assert_eq!(outcome, Outcome::Taken, "it is accounted for, and not sent again");
    assert_eq!((contacts(&one), one.bad_times()), (9, 2));
    assert_eq!(one.status(YEAR_US), Outcome::BadTime);
    assert_eq!(one.status(0), Outcome::Taken);
}

#[test]
fn the_first_message_of_a_boot_may_be_wrong_too() {
    let mut one = ByHand::born(70.0);
    one.touched(&[(PLAIN, YEAR_US)]);
    assert_eq!((one.bad_times(), one.asked_for(0.05)), (0, None), "the supervisor's clock may be the wrong one");
    one.passes_s(0.1);
    one.touched(&[(PLAIN, 0)]);
    assert_eq!(left_us(&mut one, 0), VALID_FOR_US as i64);
}

#[test]
fn a_clock_that_is_years_behind_is_followed_and_may_go_back_with_a_new_boot() {
    let mut one = ByHand::born(70.0);
    for _ in 0..4 {
        one.passes_s(1.0);
        one.status(0);
    }
    assert_eq!(left_us(&mut one, 0), VALID_FOR_US as i64);
    one.boots("b2", 70.0);
    let since_1970_us = -(one.now.0 as i64) + 7 * S as i64;
    for _ in 0..3 {
        assert_eq!(one.asked_for(0.05), None);
        one.passes_s(1.0);
        assert_eq!(one.touched(&[(PLAIN, since_1970_us)]), Outcome::Taken);
    }
    assert_eq!(one.bad_times(), 0);
    assert_eq!(left_us(&mut one, since_1970_us), VALID_FOR_US as i64);
}

#[test]
fn a_clock_that_is_years_ahead_is_followed_from_the_third_message_on() {
    let mut one = ByHand::born(70.0);
    let contacts = |one: &ByHand| one.robot.whisker(0).unwrap().contacts;
    for message in 1..=10 {
        one.passes_s(1.0);
        assert_eq!(one.status(YEAR_US), Outcome::Taken);
        assert_eq!(one.touched(&[(PLAIN, YEAR_US)]), Outcome::Taken);
        assert_eq!(contacts(&one), message);
    }
    assert_eq!(one.bad_times(), 0);
    assert_eq!(left_us(&mut one, YEAR_US), VALID_FOR_US as i64);
    // A new boot may set it right, which is back by a year.
    one.boots("b2", 70.0);
    for _ in 0..3 {
        one.passes_s(1.0);
        assert_eq!(one.status(0), Outcome::Taken);
    }
    assert_eq!(left_us(&mut one, 0), VALID_FOR_US as i64);
}

#[test]
fn a_setpoint_is_not_sent_again_beyond_its_time_to_live() {
    let mut one = ByHand::born(70.0);
    one.status(0);
    one.passes_s(0.1);
    let (before, issued) = (one.effects.len(), one.now);
    one.asked_for(0.05).expect("a setpoint");
    // Nothing is heard any more, so that no message tells the time.
    one.silent_for_s(60.0);
    let fates = one.fates_from(before);
    assert_eq!(fates.iter().filter(|fate| fate.is_none()).count(), 6, "every two seconds: {fates:?}");
    assert_eq!(fates.last(), Some(&Some(CommandState::Expired)));
    assert_eq!(one.commands_from(before).len(), 1, "what was asked by hand is not sent later");
    assert!(one.now.since(issued) > Micros(VALID_FOR_US));
}

#[test]
fn a_setpoint_does_not_live_longer_when_the_supervisors_clock_is_set_back() {
    let mut one = ByHand::born(70.0);
    one.status(0);
    let before = one.effects.len();
    one.asked_for(0.05).expect("a setpoint");
    one.now = Micros(one.now.0 - 3_600 * S);
    one.silent_for_s(1.0);
    assert_eq!(one.fates_from(before), [Some(CommandState::Expired)]);
}

#[test]
fn a_robot_that_is_not_heard_for_a_while_has_not_failed() {
    let mut one = ByHand::born(70.0);
    for _ in 0..10 {
        one.status(0);
        one.passes_s(0.1);
        // It answers nothing, and then there is silence for five minutes: as often as the broker is away.
        let before = one.effects.len();
        one.asked_for(0.05);
        one.silent_for_s(300.0);
        assert!(one.commands_from(before).len() <= 1);
        one.status(0);
    }
    let failed = one.effects.iter().filter(|effect| {
        matches!(effect, vibrissa_core::robot::effect::Effect::Alarm { kind, .. }
            if *kind == vibrissa_core::robot::effect::AlarmKind::SetpointFailed)
    });
    assert_eq!(failed.count(), 0);
}

#[test]
fn a_step_of_the_robots_clock_does_not_make_its_setpoints_fail() {
    use vibrissa_core::robot::Event;
    use vibrissa_core::robot::event::{Rejection, SetpointReport};

    let step_us = 3_600 * S as i64;
    let mut one = ByHand::born(70.0);
    for _ in 0..8 {
        one.passes_s(10.0);
        one.status(0);
    }
    // It has gone forward by an hour, and everything that comes is late by it.
    let mut refused = 0;
    let mut command = one.asked_for(0.05);
    let taken = loop {
        let sent = command.take().expect("another setpoint");
        if sent.expires >= one.time(step_us) {
            break sent;
        }
        refused += 1;
        let (key, report) = (sent.key, SetpointReport::Rejected(Rejection::Expired));
        let robot_time = one.time(step_us);
        one.step(&Event::Setpoint { boot_id: "b1", command: key, report, robot_time });
        let before = one.effects.len();
        for _ in 0..40 {
            one.passes_s(0.5);
            one.status(step_us);
            one.step(&Event::Tick);
        }
        command = one.commands_from(before).pop();
    };
    assert_eq!(refused, 1);
    assert!(taken.expires.since(one.time(step_us)) <= Micros(VALID_FOR_US));
}

/// Contacts that were taken, of `sent`, by a supervisor that takes the robot over and whose clock differs by `step_us`.
/// The robot's clock differs by `ahead_us` from the former supervisor's.
fn taken_after_takeover(step_us: i64, ahead_us: i64) -> (u64, u64) {
    let mut one = ByHand::born(70.0);
    let contacts = |one: &ByHand| one.robot.whisker(0).unwrap().contacts;
    let mut sent = 0;
    let mut talk = |one: &mut ByHand, ahead_us: i64| {
        for second in 0..20 {
            one.passes_s(1.0);
            if second % 5 == 0 {
                assert_eq!(one.status(ahead_us), Outcome::Taken, "{step_us} {ahead_us} {second}");
            }
            assert_eq!(one.touched(&[(PLAIN, ahead_us)]), Outcome::Taken);
            sent += 1;
        }
    };
    talk(&mut one, ahead_us);
    one.now = Micros(one.now.0.saturating_add_signed(step_us));
    one.robot.take_up(2, one.now);
    let ahead_us = ahead_us - step_us;
    talk(&mut one, ahead_us);
    let left_us = left_us(&mut one, ahead_us);
    assert!((0..=VALID_FOR_US as i64).contains(&left_us), "{step_us} {ahead_us}: {left_us}");
    assert_eq!(one.bad_times(), 0, "{step_us} {ahead_us}");
    (contacts(&one), sent)
}

#[test]
fn regress_no_contact_is_lost_when_another_clock_takes_a_robot_over() {
    let hour_us = 3_600 * S as i64;
    let to_1970_us = -(ByHand::born(70.0).now.0 as i64) + 5 * S as i64;
    for step_us in [hour_us, -hour_us, -120 * S as i64, 120 * S as i64, YEAR_US, to_1970_us] {
        for ahead_us in [0, 90 * S as i64, -YEAR_US, YEAR_US] {
            let (taken, sent) = taken_after_takeover(step_us, ahead_us);
            assert_eq!(taken, sent, "{step_us} {ahead_us}");
        }
    }
}

#[test]
fn regress_no_contact_is_lost_when_the_robots_clock_is_stepped() {
    for step_us in [3_600 * S as i64, -3_600 * S as i64, 40 * YEAR_US, -40 * YEAR_US] {
        let mut one = ByHand::born(70.0);
        for message in 0..40 {
            one.passes_s(0.5);
            let ahead_us = if message < 20 { 0 } else { step_us };
            assert_eq!(one.touched(&[(PLAIN, ahead_us)]), Outcome::Taken);
        }
        assert_eq!(one.robot.whisker(0).unwrap().contacts, 40, "{step_us}");
    }
}

/// Four statuses with the new time follow each other before it is believed: 40 s at a status every 10 s. The robot was called silent
/// meanwhile.
#[test]
fn regress_a_robot_whose_clock_is_stepped_is_not_silent() {
    for step_us in [2 * 3_600 * S as i64, -40 * YEAR_US] {
        let mut one = ByHand::born(70.0);
        for status in 0..20 {
            let ahead_us = if status < 7 { 0 } else { step_us };
            one.status(ahead_us);
            one.silent_for_s(10.0);
        }
        let alarms: Vec<&Effect> = one
            .effects
            .iter()
            .filter(|effect| matches!(effect, Effect::RobotAlarm { .. } | Effect::Alarm { .. }))
            .collect();
        assert!(alarms.is_empty(), "{step_us}: {alarms:?}");
    }
}
