//! Setpoints by hand, held whiskers, and baselines that are learned anew.

use vibrissa_core::policy::Mode;
use vibrissa_core::robot::effect::{AlarmKind, Condition, Effect, EndReason, Reason};
use vibrissa_core::robot::event::Link;
use vibrissa_core::robot::{ActionProblem, Event, OperatorAction, Outcome, Scope};
use vibrissa_core::units::Megapascal;
use vibrissa_evaluation::World;
use vibrissa_protocol::ArrayType;
use vibrissa_simulator::scenario::{Change, Event as Planned};

use super::{ask, at, commands, cut_world, decisions, ended, params, standing};

#[test]
fn a_manual_setpoint_ends_what_it_serves_in_and_holds_until_released() {
    let mut world = cut_world(Mode::Automatic, &[70.0, 66.0], &[(0, 54.0)]);
    let nominal = world.core.whisker(1).unwrap().sheet.pressure;
    let set = |pressure_mpa| OperatorAction::Setpoint { whisker: at(1), pressure_mpa };
    for pressure_mpa in [-0.001, 0.2001, f64::NAN, f64::INFINITY] {
        let refused = ask(&mut world, set(pressure_mpa));
        let Outcome::Refused(problem @ ActionProblem::PressureOutOfRange { .. }) = refused else {
            panic!("{pressure_mpa}: {refused:?}")
        };
        assert!(problem.to_string().contains("0 to 0.2 MPa"), "{problem}");
    }
    assert_eq!(ended(&world), []);
    world.effects.clear();
    assert_eq!(ask(&mut world, set(0.05)), Outcome::Taken);
    assert_eq!(ended(&world), [EndReason::Operator]);
    let sent: Vec<_> = commands(&world).iter().map(|one| (one.whisker, one.pressure.mpa(), one.reason)).collect();
    assert_eq!(sent, [(1, 0.05, Reason::Operator)]);
    assert!(world.core.whisker(1).unwrap().held);
    world.run_until_s(20.0);
    let mut expected = Megapascal::known(0.05);
    assert_eq!((world.core.whisker(1).unwrap().setpoint, commands(&world).len()), (expected, 1));
    assert_eq!(standing(&world, 0), [AlarmKind::Uncompensated], "nobody else can serve it");
    assert_eq!(ask(&mut world, OperatorAction::Release(Scope::Whisker(at(1)))), Outcome::Taken);
    expected = commands(&world)[1].pressure;
    assert_ne!(expected, nominal, "it serves again at once");
    assert_eq!(commands(&world)[1].reason, Reason::Compensation(vibrissa_core::policy::Case::ShorterForLonger));
    assert_eq!(standing(&world, 0), []);
}

#[test]
fn a_manual_setpoint_is_neither_taken_while_offline_nor_sent_after_a_restart() {
    let mut world = cut_world(Mode::Automatic, &[70.0, 66.0], &[]);
    let boot_id = world.core.connection_state().0.unwrap().to_owned();
    let set = OperatorAction::Setpoint { whisker: at(1), pressure_mpa: 0.12 };
    world.step(&Event::Connection { boot_id: &boot_id, link: Link::Broken });
    assert_eq!(ask(&mut world, set), Outcome::Refused(ActionProblem::RobotOffline));
    assert_eq!(world.core.standing().collect::<Vec<_>>(), [AlarmKind::RobotSilent]);
    assert_eq!(standing(&world, 1), [], "the robot has the alarm");
    world.step(&Event::Connection { boot_id: &boot_id, link: Link::Online });
    // Straight to the core: it is on its way, and no answer comes.
    let now = world.core.whisker(1).unwrap().heard.unwrap();
    let mut effects = Vec::new();
    world.core.step(&world.params, now, &Event::Operator(&set), &mut effects);
    assert!(effects.iter().any(|effect| matches!(effect, Effect::Command(_))), "{effects:?}");
    world.effects.clear();
    world.step(&Event::Connection { boot_id: &boot_id, link: Link::Offline });
    world.step(&Event::Connection { boot_id: "another", link: Link::Online });
    for _ in 0..3 {
        world.silent_for_s(15.0);
    }
    assert_eq!(commands(&world), []);
    assert!(world.core.whisker(1).unwrap().held, "the hold stays");
}

#[test]
fn a_held_whisker_goes_on_serving_and_being_measured_and_is_refined_once_released() {
    let mut world = cut_world(Mode::Automatic, &[70.0, 66.0], &[(0, 54.0)]);
    world.run_until_s(14.0);
    ask(&mut world, OperatorAction::Hold(Scope::Robot));
    let one = ask(&mut world, OperatorAction::Release(Scope::Whisker(at(1))));
    assert_eq!(one, Outcome::Refused(ActionProblem::RobotHeld));
    world.effects.clear();
    world.run_until_s(60.0);
    let measured = world.picked(|effect| matches!(effect, Effect::Error(_)).then_some(())).len();
    assert!(measured >= 5, "{measured}");
    assert_eq!((commands(&world), ended(&world)), (Vec::new(), Vec::new()));
    assert!(world.picked(|effect| matches!(effect, Effect::Refined(_)).then_some(())).is_empty());
    ask(&mut world, OperatorAction::Release(Scope::Robot));
    world.run_until_s(61.0);
    assert_eq!(world.picked(|effect| matches!(effect, Effect::Refined(_)).then_some(())).len(), 1);
}

#[test]
fn a_held_target_is_decided_on_when_it_is_released() {
    let mut scenario = crate::scenario(73, ArrayType::Type1, &[70.0, 66.0]);
    let change = Change::Trim { length_mm: 54.0 };
    scenario.robots[0].events.push(Planned::at_contact(100, crate::name("left"), 0, change));
    let mut world = World::new(&scenario, params(Mode::Automatic));
    world.run_until_s(1.0);
    ask(&mut world, OperatorAction::Hold(Scope::Whisker(at(0))));
    world.run_until_s(10.0);
    assert_eq!(world.core.whisker(0).unwrap().condition, Condition::Trimmed, "detection goes on");
    assert_eq!((decisions(&world), commands(&world)), (Vec::new(), Vec::new()));
    ask(&mut world, OperatorAction::Release(Scope::Whisker(at(0))));
    assert_eq!(decisions(&world).len(), 1);
    assert_eq!(commands(&world).len(), 1);
}

/// A whisker whose gauge reads differently from the 150th contact on, for which a person says so or not.
fn glued_anew(is_reported: bool) -> World {
    let mut scenario = crate::scenario(74, ArrayType::Type2, &[70.0]);
    let change = Change::Temperature { sensitivity_factor: 1.25, temperature_c: 24.0 };
    let mut glued = Planned::at_contact(150, crate::name("left"), 0, change);
    (glued.at_s, glued.at_contact, glued.whisker) = (Some(3.0), None, None);
    scenario.robots[0].events.push(glued);
    let mut world = World::new(&scenario, params(Mode::Automatic));
    world.run_until_s(3.0);
    if is_reported {
        ask(&mut world, OperatorAction::Rebaseline(at(0)));
        assert_eq!(world.core.whisker(0).unwrap().condition, Condition::Learning);
    }
    world.run_until_s(20.0);
    world
}

#[test]
fn a_gauge_that_was_glued_anew_is_no_cut_where_a_person_says_so() {
    let trims = |world: &World| world.picked(|effect| matches!(effect, Effect::Trim(_)).then_some(())).len();
    assert_eq!(trims(&glued_anew(false)), 1, "it looks like one");
    let world = glued_anew(true);
    let view = world.core.whisker(0).unwrap();
    assert_eq!((trims(&world), view.condition), (0, Condition::Healthy));
    assert!((view.length.length.mm() - 70.0).abs() < 0.3, "{:?}", view.length);
    assert!((view.offset.level - 1.25_f64.ln()).abs() < 0.06, "{:?}", view.offset);
}

#[test]
fn a_trimmed_whisker_that_is_learned_anew_stays_trimmed_and_served() {
    let mut world = cut_world(Mode::Automatic, &[70.0, 66.0], &[(0, 54.0)]);
    let before = (world.core.whisker(0).unwrap().length, world.core.compensations()[0].id());
    world.effects.clear();
    for whisker in [0, 1] {
        assert_eq!(ask(&mut world, OperatorAction::Rebaseline(at(whisker))), Outcome::Taken);
    }
    let views = [0, 1].map(|index| world.core.whisker(index).unwrap());
    assert_eq!(views.map(|view| view.condition), [Condition::Trimmed, Condition::Learning]);
    assert_eq!((views[0].length, world.core.compensations()[0].id()), before);
    world.run_until_s(40.0);
    assert_eq!(ended(&world), []);
    assert_eq!(world.core.whisker(1).unwrap().condition, Condition::Healthy);
    assert!(!world.picked(|effect| matches!(effect, Effect::Error(_)).then_some(())).is_empty(), "measured again");
    assert!((world.core.whisker(0).unwrap().length.length.mm() - 54.0).abs() < 1.5);
}
