//! The way of docs/first-robot.md: touches, a cut, the rod that is moved after it, and the compensation.

use std::collections::BTreeMap;

use vibrissa_core::mechanics::Formulation;
use vibrissa_core::robot::Params;
use vibrissa_core::robot::effect::{CommandState, Condition, Effect};
use vibrissa_evaluation::World;
use vibrissa_protocol::{Contact, Gauge, Segmenter};

use crate::desk::{Begin, CUT_MM, CYCLE_S, Desk, NOMINAL_MPA, WHOLE_MM, Wired};

/// Longest times that a person waits, s: until the whiskers are known, until a cut is found, and until the pressure is
/// reached.
const KNOWN_S: f64 = 75.0;
const FOUND_S: f64 = 45.0;
const REACHED_S: f64 = 25.0;
/// Time for which the cut whisker passes its rod, s.
const PASSED_S: f64 = 5.0;
/// Difference of a chamber from its setpoint, MPa: the agent's tolerance and a step of the converter.
const TOLERANCE_MPA: f64 = 0.004;

/// Touches that are counted after a start.
const TOUCHES: usize = 8;
/// Whiskers of a Mega: gauges at A8, two HX711, an ADS1115, A9 and A10. Whiskers that share an ADS1115 share its rate: three
/// have too few samples for touches of 0.1 s.
const MEGA: [(f64, f64); 6] = [(-1.0, 0.006), (1.0, 0.4), (-1.0, 0.4), (1.0, 0.008), (1.0, 0.02), (-1.0, 0.01)];

/// What happens while the whiskers are touched for the first time.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Disturbance {
    None,
    /// The system's clock of the robot is set by so many seconds, and back.
    ClockSet(i64),
}

/// The supervisor learns a whisker from 150 touches; here from fewer, because the microcontroller is slow to simulate.
fn params() -> Params {
    let mut params = Params::nguyen_2021(Formulation::Published);
    params.detection.cold_start_contacts = 60;
    params
}

fn wired(list: &[(f64, f64)]) -> Vec<Wired> {
    list.iter().map(|&(polarity, strain_per_v)| Wired { polarity, strain_per_v }).collect()
}

fn conditions(world: &World<Desk>) -> Vec<Condition> {
    (0..world.core.whisker_count()).map(|at| world.core.whisker(at).unwrap().condition).collect()
}

/// Goes on until something holds; fails after so many seconds.
fn until(world: &mut World<Desk>, limit_s: f64, what: &str, holds: impl Fn(&World<Desk>) -> bool) -> f64 {
    let begun_s = world.seconds();
    while !holds(world) {
        let waited_s = world.seconds() - begun_s;
        if waited_s > limit_s {
            let (conditions, warnings) = (conditions(world), world.robot.warnings.clone());
            panic!(
                "{what}: not within {limit_s} s: {conditions:?} {warnings:?} {:#?}",
                world.robot.snapshot().whiskers
            );
        }
        world.run_until_s(world.seconds() + 0.5);
    }
    world.seconds() - begun_s
}

fn of(contacts: &[Contact], whisker: usize) -> Vec<&Contact> {
    contacts.iter().filter(|one| usize::from(one.whisker) == whisker).collect()
}

/// Mean strain per mm of contacts.
fn per_mm(contacts: &[&Contact]) -> f64 {
    assert!(contacts.len() > 4, "{} contacts", contacts.len());
    contacts.iter().map(|one| one.strain / one.deflection_mm).sum::<f64>() / contacts.len() as f64
}

/// Walks with these whiskers, of which the last one is cut.
fn walk(list: &[(f64, f64)], begin: Begin, disturbance: Disturbance) {
    let what = format!("{list:?}, {begin:?}, {disturbance:?}");
    let Some(desk) = Desk::wire(&wired(list), begin) else { return };
    let mut world = World::of(desk, params());
    let (count, cut) = (list.len(), list.len() - 1);
    if let Disturbance::ClockSet(seconds) = disturbance {
        world.run_until_s(8.0);
        world.robot.clock_step_us = seconds * 1_000_000;
        world.run_until_s(16.0);
        world.robot.clock_step_us = 0;
    }
    let known_s = until(&mut world, KNOWN_S, &format!("{what}: whiskers that are known"), |world| {
        conditions(world).iter().all(|one| *one == Condition::Healthy)
    });
    let whole = world.robot.contacts.clone();
    // Touches are positive, at the tip, and as deep as the slide goes.
    for contact in &whole {
        assert!(contact.tip && contact.strain > 0.0 && !contact.saturated, "{what}: {contact:?}");
    }
    for at in 0..count {
        // Those of before were compared with a rest that was not known yet.
        let late: Vec<&Contact> = of(&whole, at).into_iter().skip(10).collect();
        let off = per_mm(&late) / world.robot.per_mm(at, WHOLE_MM, NOMINAL_MPA) - 1.0;
        assert!(off.abs() < 0.1, "{what}: strains of whisker {at} are off by {off}");
    }
    let warnings = world.robot.warnings.iter().filter(|text| !text.contains("counts as 0")).collect::<Vec<_>>();
    assert!(world.robot.restarts == 0 && warnings.is_empty(), "{what}: {warnings:?}");

    world.robot.cut(cut);
    world.run_until_s(world.seconds() + 0.5);
    let before = of(&world.robot.contacts, cut).len();
    world.run_until_s(world.seconds() + PASSED_S);
    assert_eq!(of(&world.robot.contacts, cut).len(), before, "{what}: the rod is out of reach");
    world.robot.move_rod(cut);
    let moved = world.robot.contacts.len();
    let found_s = until(&mut world, FOUND_S, &format!("{what}: a cut that is found"), |world| {
        conditions(world)[cut] == Condition::Trimmed
    });
    let applied = |effect: &Effect| matches!(effect, Effect::CommandState { state: CommandState::Applied, .. });
    let reached_s = until(&mut world, REACHED_S, &format!("{what}: a setpoint that is applied"), |world| {
        world.effects.iter().any(|(_, effect)| applied(effect))
    });
    let uncompensated = per_mm(&of(&world.robot.contacts[moved..], cut)[1..8]);
    let view = world.core.whisker(cut).unwrap();
    let (length_mm, setpoint_mpa) = (view.length.length.mm(), view.setpoint.mpa());
    assert!((length_mm - CUT_MM).abs() < 2.0, "{what}: {length_mm} mm");
    world.run_until_s(world.seconds() + 1.0);
    let compensated = world.robot.contacts.len();
    world.run_until_s(world.seconds() + 8.0);
    let setpoint_mpa = world.core.whisker(cut).map_or(setpoint_mpa, |view| view.setpoint.mpa());
    let chamber_mpa = world.robot.pressures_mpa[cut];
    assert!((chamber_mpa - setpoint_mpa).abs() < TOLERANCE_MPA, "{what}: {chamber_mpa} of {setpoint_mpa} MPa");
    let (target, after) = (per_mm(&of(&whole, cut)[10..]), per_mm(&of(&world.robot.contacts[compensated..], cut)));
    let (error_before, error_after) = (uncompensated / target - 1.0, after / target - 1.0);
    println!(
        "{what}: known after {known_s:.0} s, found after {found_s:.0} s as {length_mm:.1} mm, {setpoint_mpa:.3} MPa after \
         {reached_s:.0} s, reading off by {:.1} % before and {:.1} % after",
        100.0 * error_before,
        100.0 * error_after
    );
    assert!(error_before.abs() > 0.08, "{what}: {error_before}");
    assert!(error_after.abs() < 0.5 * error_before.abs(), "{what}: {error_before} before, {error_after} after");
    // A board that lost three orders in turn would vent its chamber.
    let mut lowest_mpa = world.robot.lowest_mpa.clone().expect("chambers that were filled");
    lowest_mpa.remove(cut);
    assert!(lowest_mpa.iter().all(|mpa| *mpa > 0.85 * NOMINAL_MPA), "{what}: {lowest_mpa:?} MPa");
    let others: BTreeMap<usize, Condition> =
        conditions(&world).into_iter().enumerate().filter(|one| one.0 != cut).collect();
    assert!(others.values().all(|one| *one == Condition::Healthy), "{what}: {others:?}");
}

#[test]
fn one_of_two_whiskers_of_an_uno_is_compensated_although_the_clock_is_set() {
    walk(&[(1.0, 0.006), (-1.0, 0.02)], Begin::at("uno", 0.8), Disturbance::ClockSet(3_600));
}

#[test]
fn a_board_that_restarts_is_served_again() {
    let Some(desk) = Desk::wire(&wired(&[(1.0, 0.006)]), Begin::at("uno", 0.1)) else { return };
    let mut world = World::of(desk, params());
    let touched = |world: &World<Desk>| world.robot.contacts.len();
    until(&mut world, 40.0, "touches", |world| touched(world) > 20);
    let before = touched(&world);
    world.robot.restart_board();
    let again_s = until(&mut world, 30.0, "touches after a restart", |world| touched(world) > before + 10);
    println!("a board that restarts: 11 touches after {again_s:.0} s");
    let after = &world.robot.contacts[before..];
    assert!(after.iter().all(|one| one.tip && one.strain > 0.0 && !one.saturated), "{after:?}");
    let off = per_mm(&of(after, 0)[5..]) / world.robot.per_mm(0, WHOLE_MM, NOMINAL_MPA) - 1.0;
    assert!(off.abs() < 0.1, "strains are off by {off}");
    // Its chamber is filled, and the agent has not given it up.
    let mpa = world.robot.pressures_mpa[0];
    assert!((mpa - NOMINAL_MPA).abs() < TOLERANCE_MPA && world.robot.restarts == 0, "{mpa} MPa");
}

#[test]
fn one_of_six_whiskers_of_a_mega_is_compensated() {
    walk(&MEGA, Begin::at("mega", 0.7), Disturbance::None);
}

/// The agent starts in the middle of a touch, of a hold or of a gap: ten seconds later each touch is right.
#[test]
fn an_agent_that_starts_in_a_touch_a_hold_or_a_gap_finds_each_touch_ten_seconds_later() {
    let at = |phase: f64| Begin::at("uno", phase);
    let mut last = None;
    for (begin, polarity) in [
        (at(0.1), 1.0),
        (Begin { hold_s: 32.0, ..at(0.15) }, -1.0),
        (Begin { gap_s: 0.7, ..at(0.1) }, 1.0),
        (Begin { gap_s: 2.0, hold_s: 3.0, ..at(0.12) }, -1.0),
    ] {
        let Some(desk) = Desk::wire(&wired(&[(polarity, 0.006)]), begin) else { return };
        let mut world = World::of(desk, params());
        world.run_until_s(begin.hold_s.max(begin.gap_s));
        are_right_in_ten_seconds(&mut world, &format!("{begin:?}, polarity {polarity}"));
        last = Some(world);
    }
    let mut world = last.unwrap();
    world.robot.lose_lines(0.45);
    are_right_in_ten_seconds(&mut world, "a gap later");
}

/// Each of the touches that come in ten seconds is found and right.
fn are_right_in_ten_seconds(world: &mut World<Desk>, what: &str) {
    world.run_until_s(world.seconds() + 10.0);
    let before = world.robot.contacts.len();
    world.run_until_s(world.seconds() + TOUCHES as f64 * CYCLE_S);
    let late: Vec<&Contact> = of(&world.robot.contacts[before..], 0);
    assert!(late.len() + 1 >= TOUCHES, "{what}: {} of {TOUCHES} touches", late.len());
    for contact in &late {
        assert!(contact.tip && contact.strain > 0.0 && !contact.saturated, "{what}: {contact:?}");
    }
    let off = per_mm(&late) / world.robot.per_mm(0, WHOLE_MM, NOMINAL_MPA) - 1.0;
    assert!(off.abs() < 0.1, "{what}: strains are off by {off}");
}

#[test]
fn an_amplifier_that_ends_below_the_touches_and_swapped_wires_are_told() {
    // With the sketch's default of 0.002 the converter ends at a strain of 0.005.
    let Some(desk) = Desk::wire(&wired(&[(1.0, 0.002)]), Begin::at("uno", 0.7)) else { return };
    let mut world = World::of(desk, params());
    let says = |world: &World<Desk>, words: &str| world.robot.warnings.iter().any(|text| text.contains(words));
    until(&mut world, 20.0, "a gauge at its end", |world| says(world, "amplify"));
    world.run_until_s(30.0);
    let shown = world.robot.snapshot().whiskers.remove(0);
    assert_eq!((shown.gauge, shown.segmenter), (Gauge::Saturated, Some(Segmenter::Clipped)), "{shown:?}");
    assert!(shown.advice.is_some_and(|advice| advice.contains("amplify the gauge less")));
    assert_eq!(conditions(&world), [Condition::Learning]);

    // Nobody has calibrated the board, and its gauge goes the other way.
    let Some(desk) = Desk::wire(&wired(&[(-1.0, 0.006)]), Begin { is_calibrated: false, ..Begin::at("uno", 0.9) })
    else {
        return;
    };
    let mut world = World::of(desk, params());
    until(&mut world, 40.0, "swapped wires", |world| says(world, "touches are compressions"));
    let shown = world.robot.snapshot().whiskers.remove(0);
    assert_eq!(shown.segmenter, Some(Segmenter::Inverted));
    assert!(shown.advice.is_some(), "{shown:?}");
}
