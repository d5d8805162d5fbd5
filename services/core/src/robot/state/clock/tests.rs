use super::*;

const START: Micros = Micros(1_795_248_000_000_000);
const SECOND_US: i64 = 1_000_000;
const YEAR_US: i64 = 365 * 86_400 * SECOND_US;

/// So many milliseconds after the start.
fn at(ms: u64) -> Micros {
    Micros(START.0 + 1000 * ms)
}

fn robot_time_at(now: Micros, offset_us: i64) -> Micros {
    Micros(now.0.saturating_add_signed(offset_us))
}

/// Hears a message every 500 ms from `from_ms` on.
fn hear(clock: &mut Clock, from_ms: u64, messages: u64, offset_us: i64, kind: TimeKind) {
    for message in 0..messages {
        let now = at(from_ms + 500 * message);
        clock.hear(now, robot_time_at(now, offset_us), kind);
    }
}

/// How far the estimate is ahead of a true offset.
fn ahead_us(clock: &Clock, now: Micros, offset_us: i64) -> i64 {
    let robot_time = clock.robot_time(now).expect("known");
    robot_time.0 as i64 - robot_time_at(now, offset_us).0 as i64
}

#[test]
fn no_single_message_moves_it_wherever_it_comes() {
    for kind in [TimeKind::Live, TimeKind::Recorded] {
        for place in 0..40 {
            for wrong_us in [YEAR_US, -YEAR_US / 100, 23 * SECOND_US, 9 * SECOND_US, -23 * SECOND_US] {
                let mut clock = Clock::default();
                for message in 0..40_u64 {
                    let now = at(700 * message);
                    let offset_us = if message == place { wrong_us } else { 0 };
                    clock.hear(now, robot_time_at(now, offset_us), kind);
                    if let Some(robot_time) = clock.robot_time(now) {
                        let ahead_us = robot_time.0 as i64 - now.0 as i64;
                        // The first alone is believed within the tolerance.
                        assert!(ahead_us <= if place == 0 && message == 0 { NEAR_US } else { 0 }, "{place} {message}");
                    }
                }
                assert_eq!(ahead_us(&clock, at(28_000), 0), 0, "{kind:?} {place} {wrong_us}");
            }
        }
    }
}

#[test]
fn wrong_messages_in_every_slot_do_not_outweigh_right_ones() {
    let mut clock = Clock::default();
    hear(&mut clock, 0, 7, 0, TimeKind::Live);
    for message in 0..2000 {
        let now = at(4_000 + 100 * message);
        let offset_us = if message % 10 == 0 { 0 } else { YEAR_US };
        clock.hear(now, robot_time_at(now, offset_us), TimeKind::Live);
    }
    assert_eq!(ahead_us(&clock, at(300_000), 0), 0);
}

#[test]
fn a_robot_in_1970_is_known_by_its_third_message_and_one_in_time_by_its_first() {
    let mut clock = Clock::default();
    let since_1970_us = 5_000_000 - START.0 as i64;
    for message in 0..3 {
        assert_eq!(clock.robot_time(at(100)), None, "{message}");
        clock.hear(at(200 * message), robot_time_at(at(200 * message), since_1970_us), TimeKind::Recorded);
    }
    assert_eq!(ahead_us(&clock, at(10_000), since_1970_us), 0);
    assert!(clock.plausible(at(10_000)).contains(&Micros(15_000_000)));

    let mut clock = Clock::default();
    clock.hear(at(0), robot_time_at(at(0), -30_000), TimeKind::Recorded);
    assert_eq!(ahead_us(&clock, at(60_000), 0), -30_000);
}

#[test]
fn a_first_time_that_is_years_off_lets_no_setpoint_out() {
    let mut clock = Clock::default();
    clock.hear(at(0), robot_time_at(at(0), YEAR_US), TimeKind::Live);
    assert!(!clock.plausible(at(0)).contains(&robot_time_at(at(0), YEAR_US)) && clock.robot_time(at(0)).is_none());
    clock.hear(at(10), at(10), TimeKind::Live);
    assert_eq!(ahead_us(&clock, at(20), 0), 0);
}

#[test]
fn a_clock_that_is_stepped_is_followed_within_a_minute_in_either_direction() {
    for (step_us, kind) in [(3_600 * SECOND_US, TimeKind::Live), (-3_600 * SECOND_US, TimeKind::Live)]
        .into_iter()
        .chain([(-3 * SECOND_US, TimeKind::Recorded), (YEAR_US, TimeKind::Recorded)])
    {
        let mut clock = Clock::default();
        hear(&mut clock, 0, 60, 0, kind);
        hear(&mut clock, 30_000, 24, step_us, kind);
        assert_eq!(ahead_us(&clock, at(42_000), step_us), 0, "{step_us} {kind:?}");
        assert!(clock.plausible(at(42_000)).contains(&robot_time_at(at(42_000), step_us)));
    }
    // With a status every ten seconds.
    let mut clock = Clock::default();
    for message in 0..20 {
        let now = at(10_000 * message);
        clock.hear(now, robot_time_at(now, if message < 16 { 0 } else { 3_600 * SECOND_US }), TimeKind::Live);
    }
    assert_eq!(ahead_us(&clock, at(200_000), 3_600 * SECOND_US), 0);
}

#[test]
fn old_contacts_that_are_sent_again_do_not_lower_it_while_statuses_come() {
    let mut clock = Clock::default();
    hear(&mut clock, 0, 20, 0, TimeKind::Live);
    for ms in (10_000..100_000).step_by(20) {
        // Two minutes old, then a status every ten seconds.
        clock.hear(at(ms), robot_time_at(at(ms), -120 * SECOND_US), TimeKind::Recorded);
        if ms % 10_000 == 0 {
            clock.hear(at(ms), at(ms), TimeKind::Live);
        }
        assert_eq!(ahead_us(&clock, at(ms), 0), 0, "{ms}");
    }
    assert!(clock.plausible(at(100_000)).contains(&robot_time_at(at(100_000), -120 * SECOND_US)));
}

#[test]
fn old_contacts_alone_lower_it_until_new_ones_come() {
    let mut clock = Clock::default();
    hear(&mut clock, 0, 60, -120 * SECOND_US, TimeKind::Recorded);
    assert_eq!(ahead_us(&clock, at(30_000), 0), -120 * SECOND_US, "too early is safe");
    hear(&mut clock, 30_000, 24, 0, TimeKind::Recorded);
    assert_eq!(ahead_us(&clock, at(42_000), 0), 0);
}

#[test]
fn contacts_count_again_where_statuses_have_ceased() {
    let mut clock = Clock::default();
    hear(&mut clock, 0, 20, 0, TimeKind::Live);
    hear(&mut clock, 80_000, 40, 5 * SECOND_US, TimeKind::Recorded);
    assert_eq!(ahead_us(&clock, at(100_000), 5 * SECOND_US), 0);
}

#[test]
fn a_drift_of_100_ppm_and_a_delay_are_errors_of_milliseconds() {
    let mut clock = Clock::default();
    for message in 0..400_u64 {
        let sent = at(10_000 * message);
        let drift_us = (sent.0 - START.0) as i64 / 10_000;
        let now = Micros(sent.0 + 20_000 + 977 * (message % 7));
        clock.hear(now, robot_time_at(sent, drift_us), TimeKind::Live);
        if message >= 7 {
            let ahead_us = ahead_us(&clock, now, drift_us);
            assert!((-40_000..=0).contains(&ahead_us), "{ahead_us}");
        }
    }
}

#[test]
fn times_that_cannot_be_are_told_from_those_that_can() {
    let mut clock = Clock::default();
    hear(&mut clock, 0, 20, 0, TimeKind::Live);
    let now = at(10_000);
    for (offset_us, is_plausible) in [
        (0, true),
        (59 * SECOND_US, true),
        (61 * SECOND_US, false),
        (YEAR_US, false),
        (-29 * 86_400 * SECOND_US, true),
        (-YEAR_US, false),
    ] {
        assert_eq!(clock.plausible(now).contains(&robot_time_at(now, offset_us)), is_plausible, "{offset_us}");
        let is_of_older = offset_us <= AHEAD_MAX_US;
        assert_eq!(
            clock.plausible_of_older_boot(now).contains(&robot_time_at(now, offset_us)),
            is_of_older,
            "{offset_us}"
        );
    }
    assert!([0, u64::MAX].iter().all(|&time| !clock.plausible(now).contains(&Micros(time))));
}

#[test]
fn regress_a_clock_at_the_end_of_the_contracts_times_lets_no_setpoint_expire() {
    let mut clock = Clock::default();
    for second in 0..4 {
        let now = at(1_000 * second);
        let robot_time = if second == 0 { now } else { Micros((1 << 53) - 1) };
        clock.hear(now, robot_time, TimeKind::Live);
    }
    assert_eq!(clock.robot_time(at(3_000)), None);
}

#[test]
fn property_what_is_stored_is_read_again() {
    let mut clock = Clock::default();
    for message in 0..50 {
        let bytes = borsh::to_vec(&clock).unwrap();
        assert!(bytes.len() <= 160, "{}", bytes.len());
        assert_eq!(borsh::from_slice::<Clock>(&bytes).unwrap(), clock);
        let kind = if message % 3 == 0 { TimeKind::Live } else { TimeKind::Recorded };
        let offset_us = [0, -YEAR_US, i64::MAX, 7, -1][message as usize % 5];
        clock.hear(at(1_700 * message), robot_time_at(at(1_700 * message), offset_us), kind);
    }
    let too_many = [1, 8, 0];
    assert!(borsh::from_slice::<Clock>(&too_many).is_err());
}

/// A robot that counts `per_second` units each second, from `from` on, and says so in messages of both kinds.
fn counting(from: u64, per_second: f64, messages: u64) -> Clock {
    let mut clock = Clock::default();
    for message in 0..messages {
        let now = at(300 * message);
        let robot_time = Micros(from + (0.3 * message as f64 * per_second) as u64);
        let kind = if message % 5 == 0 { TimeKind::Live } else { TimeKind::Recorded };
        clock.hear(now, robot_time, kind);
        let is_of_microseconds = (500_000.0..=2_000_000.0).contains(&per_second);
        assert!(clock.robot_time(now).is_none() || is_of_microseconds, "{per_second} {message}");
    }
    clock
}

#[test]
fn regress_times_in_another_unit_let_no_setpoint_out() {
    for (from, per_second) in [
        (1_795_248_000_000, 1e3),
        (1_795_248_000, 1.0),
        (7_000, 1e3),
        (7, 1.0),
        (179_524_800_000, 1e2),
        (1_795_248_000_000, 1e9),
        (7_000_000, 4e6),
        (7_000_000, 2.5e5),
    ] {
        let clock = counting(from, per_second, 60);
        assert!(clock.has_wrong_unit(), "{from} {per_second}");
        assert_eq!(clock.robot_time(at(18_000)), None, "{from} {per_second}");
    }
    // Microseconds since the robot's start, also by a bad oscillator.
    for per_second in [1e6, 0.6e6, 1.8e6] {
        let clock = counting(7_000_000, per_second, 60);
        assert!(!clock.has_wrong_unit() && clock.robot_time(at(18_000)).is_some(), "{per_second}");
    }
}

#[test]
fn neither_steps_nor_delays_look_like_another_unit() {
    let mut clock = Clock::default();
    hear(&mut clock, 0, 20, -YEAR_US, TimeKind::Live);
    for step in 1..8 {
        hear(&mut clock, 10_000 * step, 20, -YEAR_US / step as i64, TimeKind::Live);
        assert!(!clock.has_wrong_unit(), "{step}");
    }
    // Contacts of an outage are sent again within seconds.
    let mut clock = Clock::default();
    for message in 0..200 {
        clock.hear(at(100 * message), Micros(1_000_000 * (1 + message)), TimeKind::Recorded);
        assert!(!clock.has_wrong_unit());
    }
}
