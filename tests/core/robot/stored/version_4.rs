//! Robots that version 4 of the state stored, written by the program of then.

use vibrissa_core::policy::Mode;
use vibrissa_core::robot::effect::Effect;
use vibrissa_core::robot::event::Link;
use vibrissa_core::robot::{Event, OperatorAction, Outcome, Place, Robot};
use vibrissa_core::units::Micros;

use super::life::Store;
use super::plant::params;
use super::{ARRAY, BOOTS, WHISKERS, parts_of};

/// Two robots of then, each with its parts.
fn of_version_4() -> Vec<Vec<Vec<u8>>> {
    let parts = parts_of(include_bytes!("../../../data/state-4/robots.bin"));
    parts.chunks(1 + usize::from(WHISKERS)).map(<[_]>::to_vec).collect()
}

/// Describes the parts of a robot's state that existed in that version.
fn text_of(robot: &Robot) -> String {
    let mut text = format!("{:?}\n", robot.connection_state());
    BOOTS[..3].iter().for_each(|boot| text += &format!("{:?}\n", robot.sequence(boot)));
    text += &format!("{:?}\n{:#?}\n", robot.arrays().collect::<Vec<_>>(), robot.compensations());
    text += &format!("{:#?}\n", robot.commands_under_way().collect::<Vec<_>>());
    (0..robot.whisker_count()).for_each(|index| {
        let view = format!("{:#?}\n", robot.whisker(index).unwrap());
        // No touch tests and no ranges of gauges were known then.
        text += &view
            .replace("    touch_test: None,\n", "")
            .replace("    zero: None,\n", "")
            .replace("        strain_max: None,\n", "")
            .replace("        length_tolerance_mm: 0.5,\n", "");
    });
    text
}

/// The text without lengths and offsets, which later programs state by other equations; the fixtures compare them.
fn without_lengths(text: &str) -> String {
    let mut kept = String::new();
    let mut is_left_out = false;
    for line in text.lines() {
        is_left_out |= matches!(
            line,
            "    length: LengthEstimate {" | "    relative_length: LengthEstimate {" | "    offset: Offset {"
        );
        if !is_left_out {
            kept += line;
            kept += "\n";
        }
        is_left_out &= line != "    },";
    }
    kept
}

#[test]
fn golden_robots_of_version_4_lose_nothing_that_was_learned() {
    let mut text = String::new();
    for parts in of_version_4() {
        let (head, whiskers) = (&parts[0], &parts[1..]);
        let robot = Robot::restore(head, whiskers).unwrap();
        text += &text_of(&robot);
        let Store { head: now, whiskers: same } = Store::all_of(&robot);
        assert_eq!((head[0], now[0]), (4, 12));
        assert_eq!(same.len(), whiskers.len());
        assert_eq!(Robot::restore(&now, &same).unwrap(), robot);
    }
    let (text, expected) = (without_lengths(&text), without_lengths(include_str!("../../../data/state-4/robots.txt")));
    assert!(text.len() > 10_000, "{}", text.len());
    let differs = text.lines().zip(expected.lines()).find(|(text, expected)| text != expected);
    assert_eq!((differs, text.len()), (None, expected.len()));
}

#[test]
fn a_robot_of_version_4_goes_on_once_it_has_said_its_time_again() {
    let parts = &of_version_4()[0];
    let mut robot = Robot::from_bytes(&parts[0], &parts[1..], 2, Micros(1_795_260_000_000_000)).unwrap();
    let (boot_id, now) = (robot.connection_state().0.unwrap().to_owned(), Micros(1_795_260_001_000_000));
    let mut effects = Vec::new();
    let mut step = |event: &Event<'_>| robot.step(&params(Mode::Automatic), now, event, &mut effects);
    step(&Event::Connection { boot_id: &boot_id, link: Link::Online });
    let whisker = Place { array: ARRAY, whisker: 3 };
    let by_hand = Event::Operator(&OperatorAction::Setpoint { whisker, pressure_mpa: 0.05 });
    assert!(matches!(step(&by_hand), Outcome::Refused(_)), "its clock is not known");
    step(&Event::Status { boot_id: &boot_id, robot_time: now, whiskers: &[] });
    step(&by_hand);
    step(&Event::Tick);
    let sent = effects.iter().find_map(|effect| match effect {
        Effect::Command(command) if command.whisker == 3 => Some(command),
        _ => None,
    });
    let left_s = Micros(sent.expect("a setpoint").expires.0 - now.0).as_s();
    assert!((10.0..15.0).contains(&left_s), "{left_s} s");
}

/// An earlier version could learn such a length from contacts. A stored NaN cannot occur.
#[test]
fn regress_a_whisker_whose_stored_length_is_infinite_is_learned_anew() {
    let mut parts = of_version_4().swap_remove(0);
    let whole = Robot::restore(&parts[0], &parts[1..]).unwrap();
    let view = whole.whisker(0).unwrap();
    assert!(view.contacts > 0);
    let share_left = view.length.length.mm() / view.sheet.length.mm();
    // The stated length is corrected for the slope of the offset: `LengthFilter::length`.
    let log_length = (share_left.ln() * (1.0 - 0.33 * view.offset.slope / share_left)) as f32;
    let places: Vec<usize> =
        (0..parts[1].len() - 4).filter(|&at| parts[1][at..at + 4] == log_length.to_le_bytes()).collect();
    let [at] = places[..] else { panic!("the filter's log length {log_length} is at {places:?}") };
    parts[1][at..at + 4].copy_from_slice(&f32::INFINITY.to_le_bytes());
    let mut robot = Robot::restore(&parts[0], &parts[1..]).unwrap();
    let view = robot.whisker(0).unwrap();
    assert_eq!((view.length.length.mm(), view.contacts), (view.sheet.length.mm(), 0));
    assert!(view.length.sd_mm.is_finite() && !format!("{robot:?}").contains("inf,"));
    let mut changed = Vec::new();
    robot.take_changed_whiskers(|index| changed.push(index));
    assert_eq!(changed, [0], "what is stored is written anew");
    assert_eq!(robot.whisker(1).unwrap(), whole.whisker(1).unwrap());
}
