//! Robots that multiply their readings: a gain serves what air cannot.

use vibrissa_core::mechanics::{Formulation, Model, Objective};
use vibrissa_core::policy::{Case, LongerForShorter};
use vibrissa_core::robot::effect::{AlarmKind, Command, CompensationError, Condition, Decision, Effect, Fault};
use vibrissa_core::robot::{Event, OperatorAction, Outcome, Params, Place, Scope};
use vibrissa_core::units::{ContactRatio, Megapascal, Millimetre};
use vibrissa_evaluation::World;
use vibrissa_protocol::{AirControl, ArrayType, Task};
use vibrissa_simulator::Scenario;
use vibrissa_simulator::scenario::{Change, Event as Planned};

/// Start pressure of every whisker, MPa.
const NOMINAL_MPA: f64 = 0.1;
/// Share of its sensitivity that whisker 0 keeps.
const KEPT: f64 = 0.6;

/// One whisker of 70 mm, which stiffens after 400 contacts.
fn stiffening(applies_gain: bool) -> Scenario {
    let mut scenario = super::scenario(71, ArrayType::Type2, &[70.0]);
    scenario.robots[0].applies_gain = applies_gain;
    let change = Change::Temperature { sensitivity_factor: KEPT, temperature_c: 24.0 };
    scenario.robots[0].events.push(Planned { array: Some(super::name("left")), ..Planned::robot_at_s(8.0, change) });
    scenario
}

fn run(scenario: &Scenario, objective: Objective, seconds: f64) -> World {
    let mut params = Params::nguyen_2021(Formulation::Published);
    params.policy.objective = objective;
    let mut world = World::new(scenario, params);
    world.run_until_s(seconds);
    world
}

fn commands(world: &World) -> Vec<Command> {
    world.picked(|effect| if let Effect::Command(command) = effect { Some((**command).clone()) } else { None })
}

#[test]
fn a_loss_of_sensitivity_is_served_by_a_gain_at_the_same_pressure_and_still_told() {
    let world = run(&stiffening(true), Objective::Shape, 30.0);
    let whisker = world.core.whisker(0).expect("there");
    assert_eq!(whisker.condition, Condition::SensitivityLoss);
    assert!(whisker.standing.kinds().any(|kind| kind == AlarmKind::SensitivityLoss), "the operator learns of it");
    let [one] = world.core.compensations() else { panic!("{:?}", world.core.compensations()) };
    assert_eq!((one.target(), one.compensator(), one.case()), (0, 0, Case::SelfCompensation));
    let gain = one.reading_gain().expect("one number");
    assert!((gain * KEPT - 1.0).abs() < 0.02, "{gain}");
    assert!(one.is_settled());
    assert!(commands(&world).iter().all(|command| command.pressure.mpa() == NOMINAL_MPA), "no air is moved");
    // Eq. 35: with the gain hardly anything of the loss is left, without it everything.
    let error: CompensationError = world
        .picked(|effect| if let Effect::Error(error) = effect { Some((**error).clone()) } else { None })
        .pop()
        .expect("a measured error");
    let (by_air, _) = error.air_alone.expect("the error without the gain");
    assert!(error.mean < 0.1 && (by_air - 1.0).abs() < 0.1, "{error:?}");
}

#[test]
fn a_loss_of_sensitivity_without_gains_moves_nothing() {
    for (applies_gain, objective) in [(false, Objective::Shape), (true, Objective::Tip), (true, Objective::Mean)] {
        let world = run(&stiffening(applies_gain), objective, 30.0);
        assert_eq!(world.core.whisker(0).expect("there").condition, Condition::SensitivityLoss);
        assert_eq!((world.core.compensations().len(), commands(&world).len()), (0, 0), "{applies_gain} {objective:?}");
    }
}

/// It keeps its reach, so it needs nobody: an alarm would send an operator for nothing.
#[test]
fn regress_a_loss_of_sensitivity_in_an_array_that_reads_distances_is_no_loss_of_reach() {
    let mut scenario = stiffening(true);
    scenario.behaviour.task = Some(Task::Distance);
    let world = run(&scenario, Objective::Shape, 30.0);
    let whisker = world.core.whisker(0).expect("there");
    assert_eq!(whisker.condition, Condition::SensitivityLoss);
    assert!(!whisker.standing.kinds().any(|kind| kind == AlarmKind::Uncompensated));
    assert_eq!((world.core.compensations().len(), commands(&world).len()), (0, 0));
}

#[test]
fn the_error_of_the_air_alone_is_told_only_where_a_gain_is_applied() {
    for applies_gain in [false, true] {
        let mut scenario = super::scenario(72, ArrayType::Type2, &[70.0]);
        scenario.robots[0].applies_gain = applies_gain;
        scenario.robots[0].events.push(Planned::at_contact(
            400,
            super::name("left"),
            0,
            Change::Trim { length_mm: 65.0 },
        ));
        let world = run(&scenario, Objective::Shape, 30.0);
        let errors =
            world.picked(|effect| if let Effect::Error(error) = effect { Some((**error).clone()) } else { None });
        assert!(!errors.is_empty());
        assert!(errors.iter().all(|error| error.air_alone.is_some() == applies_gain), "{errors:?}");
        let last = errors.last().expect("one");
        assert!(last.air_alone.is_none_or(|(air, _)| air > 3.0 * last.mean), "{last:?}");
    }
}

/// Its readings before the compensation were those of a cut whisker, not of a whole one.
#[test]
fn regress_a_cut_whisker_that_loses_sensitivity_before_it_is_served_was_shorter_before() {
    let mut scenario = stiffening(true);
    scenario.calibration_error = 0.0;
    scenario.robots[0].events.push(Planned::at_contact(400, super::name("left"), 0, Change::Trim { length_mm: 62.0 }));
    scenario.robots[0].events[0].at_s = Some(20.0);
    let mut params = Params::nguyen_2021(Formulation::Consistent);
    params.policy.predicted_error_max = 0.0;
    let mut world = World::new(&scenario, params);
    world.run_until_s(18.0);
    assert_eq!(world.core.whisker(0).expect("there").condition, Condition::Trimmed);
    world.run_until_s(32.0);
    assert_eq!(world.core.whisker(0).expect("there").condition, Condition::SensitivityLoss);
    assert_eq!(world.core.compensations().len(), 0, "no error is small enough");
    world.params.policy.predicted_error_max = 0.5;
    world.step(&Event::PolicyChanged);
    world.run_until_s(60.0);
    let error: CompensationError = world
        .picked(|effect| if let Effect::Error(error) = effect { Some((**error).clone()) } else { None })
        .pop()
        .expect("a measured error");
    let model = Model::nguyen_2021(Formulation::Consistent);
    let morphology = model.morphology(Megapascal::known(NOMINAL_MPA));
    for bin in &error.bins {
        let ratio = ContactRatio::known(bin.ratio);
        let cut = model.sensitivity_per_mm(ratio, Millimetre::known(62.0), &morphology).expect("no chamber");
        assert!((bin.before_per_mm / (KEPT * cut) - 1.0).abs() < 0.05, "{bin:?}: {}", KEPT * cut);
    }
}

/// The decision for a cut whisker of 66 mm with a longer neighbour, which must lower or raise its pressure.
fn decided(air_control: Option<AirControl>, applies_gain: bool) -> Decision {
    let mut scenario = super::scenario(73, ArrayType::Type1, &[66.0, 70.0]);
    scenario.behaviour.air_control = air_control;
    scenario.robots[0].applies_gain = applies_gain;
    scenario.robots[0].events.push(Planned::at_contact(400, super::name("left"), 0, Change::Trim { length_mm: 58.0 }));
    let mut params = Params::nguyen_2021(Formulation::Published);
    params.policy.longer_for_shorter = LongerForShorter::Allowed;
    let mut world = World::new(&scenario, params);
    world.run_until_s(20.0);
    world
        .picked(|effect| if let Effect::Decided(decision) = effect { Some((**decision).clone()) } else { None })
        .into_iter()
        .next()
        .expect("a decision")
}

#[test]
fn a_robot_gets_no_pressure_that_its_air_cannot_give() {
    let pressures = |air_control| {
        let decision = decided(air_control, true);
        let of = |whisker| decision.candidates.iter().find(|one| one.whisker == whisker).expect("asked");
        [of(0), of(1)].map(|one| one.pressure.expect("solved").mpa())
    };
    let [own, longer] = pressures(None);
    assert!(own < NOMINAL_MPA && longer > NOMINAL_MPA, "{own} {longer}");
    assert_eq!(pressures(Some(AirControl::FillAndVent)), [own, longer]);
    let [own_by_venting, longer_by_venting] = pressures(Some(AirControl::VentOnly));
    assert_eq!(own_by_venting, own);
    assert!((longer_by_venting - NOMINAL_MPA).abs() < 1e-6, "{longer_by_venting}");
    assert_eq!(pressures(Some(AirControl::None)), [NOMINAL_MPA; 2]);
}

/// Without air and without a gain there is nothing to compensate with.
#[test]
fn a_robot_without_air_and_gain_is_not_compensated() {
    let decision = decided(Some(AirControl::None), false);
    assert_eq!(decision.chosen, None);
    assert!(decision.candidates.iter().all(|one| one.refused.is_some()), "{decision:?}");
}

/// Setpoints for a whisker of 70 mm that is cut to 65 mm, whose gauge has this range.
fn with_range(strain_max: Option<f64>) -> Vec<Command> {
    let mut scenario = super::scenario(75, ArrayType::Type2, &[70.0]);
    scenario.robots[0].applies_gain = true;
    scenario.robots[0].arrays[0].whiskers[0].strain_max = strain_max;
    scenario.robots[0].events.push(Planned::at_contact(800, super::name("left"), 0, Change::Trim { length_mm: 65.0 }));
    commands(&run(&scenario, Objective::Shape, 26.0))
}

/// Strains of a shorter whisker are larger. At a lower pressure they stay within the range of the gauge.
#[test]
fn a_gauge_that_strains_would_leave_gets_a_lower_pressure_and_any_other_the_same() {
    let free = with_range(None);
    assert_eq!(with_range(Some(0.4)), free, "to the last bit");
    // The whole whisker's strain at the nearest and strongest contact of the simulation.
    let model = Model::nguyen_2021(Formulation::Published);
    let [nearest, ..] = model.log_sensitivities(Millimetre::known(70.0), Megapascal::known(NOMINAL_MPA));
    let whole = 6.0 * nearest.expect("no chamber").exp();
    let pressures = |sent: &[Command]| sent[0].pressure.mpa();
    let limited = with_range(Some(1.05 * whole));
    assert!(pressures(&limited) < pressures(&free) - 0.005, "{limited:?} {free:?}");
    let largest = |mpa: f64| {
        let [nearest, ..] = model.log_sensitivities(Millimetre::known(65.0), Megapascal::known(mpa));
        6.0 * nearest.expect("no chamber").exp()
    };
    let (before, after) = (largest(pressures(&free)), largest(pressures(&limited)));
    assert!(before > 1.08 * whole && after < 1.08 * whole, "{before} {after} {whole}");
}

/// A whisker of 70 mm, cut to 65 mm and served, whose chamber then leaks faster than it can be filled.
fn leaking(applies_gain: bool, air_control: Option<AirControl>) -> World {
    let mut scenario = super::scenario(74, ArrayType::Type2, &[70.0]);
    scenario.robots[0].applies_gain = applies_gain;
    scenario.behaviour.air_control = air_control;
    let changes = [
        (400, Change::Trim { length_mm: 65.0 }),
        (1500, Change::Leak { rate_mpa_per_s: 0.2 }),
        // Repaired after the end of this run.
        (4600, Change::Leak { rate_mpa_per_s: 0.0 }),
    ];
    for (contact, change) in changes {
        scenario.robots[0].events.push(Planned::at_contact(contact, super::name("left"), 0, change));
    }
    run(&scenario, Objective::Shape, 90.0)
}

#[test]
fn a_cut_whisker_whose_chamber_leaks_is_served_by_a_gain_on_the_empty_chamber() {
    let world = leaking(true, None);
    let [one] = world.core.compensations() else { panic!("{:?}", world.core.compensations()) };
    assert_eq!((one.target(), one.compensator(), one.case()), (0, 0, Case::SelfCompensation));
    let sent: Vec<f64> = commands(&world).iter().map(|command| command.pressure.mpa()).collect();
    assert!(sent[0] > 0.05, "air for the shape while it is tight: {sent:?}");
    let emptied = sent.iter().position(|&pressure_mpa| pressure_mpa == 0.0).expect("it is emptied");
    assert!(sent[emptied..].iter().all(|&pressure_mpa| pressure_mpa == 0.0), "and stays empty: {sent:?}");
    assert!(one.is_settled() && one.reading_gain().expect("one number") > 1.0, "an empty chamber is less sensitive");
    let last: CompensationError = world
        .picked(|effect| if let Effect::Error(error) = effect { Some((**error).clone()) } else { None })
        .pop()
        .expect("a measured error");
    // Less air corrects the shape too much: more remains than at the best pressure, and less than half.
    let (by_air, _) = last.air_alone.expect("the error without the gain");
    assert!(last.pressure.mpa() == 0.0 && last.mean < 0.5 * by_air, "{last:?}");
}

#[test]
fn a_leaking_whisker_without_gains_is_not_served() {
    let world = leaking(false, None);
    assert!(world.core.compensations().is_empty());
    assert!(commands(&world).iter().all(|command| command.pressure.mpa() > 0.0));
}

/// It cannot vent, but its chamber has emptied, and the gain for that serves.
#[test]
fn a_leaking_whisker_without_valves_is_served_at_the_pressure_that_is_left() {
    let world = leaking(true, Some(AirControl::None));
    let [one] = world.core.compensations() else { panic!("{:?}", world.core.compensations()) };
    assert!(one.is_settled() && one.pressure().mpa() < 0.004, "{one:?}");
    assert!(one.reading_gain().expect("one number") > 1.0, "{one:?}");
}

/// A slow leak is filled again and again: the pressure is held, and the compensation goes on as it is.
#[test]
fn a_compensator_that_holds_its_pressure_in_spite_of_a_leak_serves_on() {
    let mut scenario = faulty(&[(1500, Change::Leak { rate_mpa_per_s: 0.002 })]);
    scenario.robots[0].events.push(Planned::at_contact(400, super::name("left"), 0, Change::Trim { length_mm: 65.0 }));
    let mut world = World::new(&scenario, Params::nguyen_2021(Formulation::Published));
    world.run_until_s(28.0);
    let before = world.core.compensations()[0].clone();
    world.run_until_s(120.0);
    assert_eq!(world.core.whisker(0).expect("there").fault, Some(Fault::Leak));
    let [one] = world.core.compensations() else { panic!("{:?}", world.core.compensations()) };
    assert_eq!((one.id(), one.pressure()), (before.id(), before.pressure()));
    assert!(error(&world).mean < 0.08, "{:?}", error(&world));
}

/// Last measured error.
fn error(world: &World) -> CompensationError {
    world
        .picked(|effect| if let Effect::Error(error) = effect { Some((**error).clone()) } else { None })
        .pop()
        .expect("a measured error")
}

/// A whisker of 70 mm of a robot that applies gains, with changes after so many of its contacts.
fn faulty(changes: &[(u64, Change)]) -> Scenario {
    let mut scenario = super::scenario(76, ArrayType::Type2, &[70.0]);
    scenario.robots[0].applies_gain = true;
    let events = changes.iter().map(|&(contact, change)| Planned::at_contact(contact, super::name("left"), 0, change));
    scenario.robots[0].events.extend(events);
    scenario
}

fn true_mpa(world: &World) -> f64 {
    world.robot.whiskers()[0].regulator().pressure_mpa()
}

#[test]
fn a_compensator_whose_regulator_breaks_is_served_by_a_gain_at_the_pressure_that_it_has() {
    let changes = [(400, Change::Trim { length_mm: 65.0 }), (1500, Change::ValvesBroken), (6000, Change::ValvesOk)];
    let mut world = World::new(&faulty(&changes), Params::nguyen_2021(Formulation::Published));
    world.run_until_s(28.0);
    let before = world.core.compensations()[0].clone();
    world.run_until_s(110.0);
    assert_eq!(world.core.whisker(0).expect("there").fault, Some(Fault::Regulator));
    let [one] = world.core.compensations() else { panic!("{:?}", world.core.compensations()) };
    assert!(one.id() > before.id() && one.is_settled(), "{one:?}");
    assert!((one.pressure().mpa() - true_mpa(&world)).abs() < 0.002, "{one:?} {}", true_mpa(&world));
    assert!(error(&world).mean < 0.1, "{:?}", error(&world));
    let (broken_id, sent) = (one.id(), commands(&world).len());
    assert!(sent < 12, "{sent}");
    // The repair shows in the regulator's report, and air serves again.
    world.run_until_s(180.0);
    let [repaired] = world.core.compensations() else { panic!("{:?}", world.core.compensations()) };
    assert!(repaired.id() > broken_id && repaired.is_settled(), "{repaired:?}");
    assert!(commands(&world).len() - sent < 12);
}

/// With broken valves even a small leak empties the chamber: the gain follows.
#[test]
fn the_gain_follows_a_pressure_that_drifts_with_few_setpoints() {
    let changes = [
        (400, Change::Trim { length_mm: 65.0 }),
        (1500, Change::ValvesBroken),
        (2000, Change::Leak { rate_mpa_per_s: 0.0005 }),
    ];
    let mut world = World::new(&faulty(&changes), Params::nguyen_2021(Formulation::Published));
    world.run_until_s(40.0);
    let (from_mpa, sent) = (true_mpa(&world), commands(&world).len());
    let mut most_off_mpa = 0.0_f64;
    while world.seconds() < 260.0 {
        world.run_until_s(world.seconds() + 1.0);
        let held = world.core.compensations().first().map(|one| one.pressure().mpa()).unwrap_or(f64::NAN);
        most_off_mpa = most_off_mpa.max((held - true_mpa(&world)).abs());
    }
    assert!(true_mpa(&world) < 0.001, "{}", true_mpa(&world));
    assert!(most_off_mpa < 0.007, "{most_off_mpa}");
    let followed = commands(&world).len() - sent;
    assert!(f64::from(followed as u32) < from_mpa / 0.004 + 12.0, "{followed} setpoints from {from_mpa}");
    let [one] = world.core.compensations() else { panic!("{:?}", world.core.compensations()) };
    assert!(one.is_settled() && one.reading_gain().expect("one number") > 1.0, "{one:?}");
    let (by_air, _) = error(&world).air_alone.expect("the error without the gain");
    assert!(error(&world).mean < 0.5 * by_air, "{:?}", error(&world));
}

#[test]
fn a_repaired_chamber_gets_air_again_when_an_operator_has_shown_that_it_holds() {
    let mut world = leaking(true, None);
    world.run_until_s(120.0);
    assert!(commands(&world).last().expect("sent").pressure.mpa() == 0.0, "an empty chamber shows no leak");
    let whisker = Place { array: "left", whisker: 0 };
    for action in [
        OperatorAction::Setpoint { whisker, pressure_mpa: NOMINAL_MPA },
        OperatorAction::Release(Scope::Whisker(whisker)),
    ] {
        assert_eq!(world.step(&Event::Operator(&action)), Outcome::Taken, "{action:?}");
        world.run_until_s(world.seconds() + 30.0);
        assert_eq!(world.core.whisker(0).expect("there").fault, None, "{action:?}");
    }
    let [one] = world.core.compensations() else { panic!("{:?}", world.core.compensations()) };
    let last = commands(&world).pop().expect("sent");
    assert!(one.is_settled() && (0.05..NOMINAL_MPA).contains(&last.pressure.mpa()), "{last:?}");
}
