//! The gain of the readings: it goes with the pressure of its setpoint.

use vibrissa_protocol::{Estimate, WhiskerCondition, WhiskerEstimate};

use super::*;
use crate::scenario::Misbehaviour;

fn applying(edit: impl FnOnce(&mut Scenario)) -> Bench {
    Bench::connected(|scenario| {
        scenario.robots[0].applies_gain = true;
        edit(scenario);
    })
}

fn estimate(bench: &mut Bench, version: u64, pressure_mpa: f64, reading_gain: Option<f64>) {
    let whisker = WhiskerEstimate {
        array: left(),
        whisker: 0,
        length_mm: 65.0,
        length_low_mm: 64.5,
        length_high_mm: 65.5,
        condition: WhiskerCondition::Trimmed,
        pressure_mpa,
        gain: Vec::new(),
        reading_gain,
        response: Vec::new(),
    };
    let (boot_id, timestamp) = (supervisor(), Timestamp(bench.now_us));
    let estimate = Estimate { boot_id, seq: version, epoch: 1, version, timestamp, whiskers: vec![whisker] };
    bench.send(RobotTopic::Estimate, &encode(&estimate));
}

/// Moves the time until the setpoint has this outcome, and returns the gain just before and just after that.
fn gain_around(bench: &mut Bench, outcome: SetpointOutcome) -> (f64, f64) {
    bench.sent();
    for _ in 0..1_000 {
        let before = bench.first().reading_gain();
        bench.run(0.05);
        if bench.states().iter().any(|state| state.state == outcome) {
            return (before, bench.first().reading_gain());
        }
    }
    panic!("no {outcome}");
}

#[test]
fn the_factsheet_says_whether_gains_are_applied() {
    for applies in [false, true] {
        let mut bench = Bench::connected(|scenario| scenario.robots[0].applies_gain = applies);
        let sheets = bench.sent().into_iter();
        let flags =
            sheets.filter_map(|one| if let Message::Factsheet(sheet) = one { Some(sheet.applies_gain) } else { None });
        assert_eq!(flags.collect::<Vec<_>>(), [applies]);
    }
}

#[test]
fn the_gain_changes_when_its_setpoint_is_reported_applied_and_not_before() {
    let mut bench = applying(|_| {});
    assert_eq!(bench.first().reading_gain(), 1.0);
    bench.setpoint_with_gain(5, 0.08, Some(0.887));
    assert_eq!(gain_around(&mut bench, SetpointOutcome::Applied), (1.0, 0.887));
    // The next one is superseded on its way, and changes nothing.
    bench.setpoint_with_gain(6, 0.15, Some(2.0));
    bench.run(0.5);
    bench.setpoint_with_gain(7, 0.1, Some(0.95));
    assert_eq!(gain_around(&mut bench, SetpointOutcome::Applied), (0.887, 0.95));
    bench.setpoint_with_gain(7, 0.1, Some(3.0));
    bench.run(3.0);
    assert_eq!(bench.first().reading_gain(), 0.95, "a repeated command is not applied again");
    bench.setpoint(8, 0.1);
    assert_eq!(gain_around(&mut bench, SetpointOutcome::Applied), (0.95, 1.0), "absent is 1");
}

#[test]
fn a_setpoint_that_fails_or_is_rejected_changes_no_gain() {
    let mut bench = applying(|_| {});
    bench.setpoint_with_gain(5, 0.08, Some(0.887));
    gain_around(&mut bench, SetpointOutcome::Applied);
    bench.setpoint_with_gain(6, 0.3, Some(2.0));
    assert!(bench.outcomes().iter().any(|(_, outcome, _)| *outcome == SetpointOutcome::Rejected));
    assert_eq!(bench.first().reading_gain(), 0.887);
    let leak = Change::Leak { rate_mpa_per_s: 0.5 };
    bench.robot.happen_soon(Some(left()), Some(0), leak, bench.now_us).unwrap();
    bench.setpoint_with_gain(7, 0.15, Some(2.0));
    assert_eq!(gain_around(&mut bench, SetpointOutcome::Failed), (0.887, 0.887));
}

#[test]
fn a_pressure_of_the_robots_own_has_the_gain_1() {
    for (loss, applied_mpa, gain) in [
        (OnSupervisorLoss::Hold, 0.08, 0.887),
        (OnSupervisorLoss::Nominal, 0.08, 1.0),
        (OnSupervisorLoss::Vent, 0.08, 1.0),
        // The pressure stays, and with it the gain.
        (OnSupervisorLoss::Nominal, 0.1, 0.887),
    ] {
        let mut bench = applying(|scenario| {
            scenario.behaviour.supervisor_lost_after_s = 20.0;
            scenario.robots[0].on_supervisor_loss = loss;
        });
        bench.setpoint_with_gain(5, applied_mpa, Some(0.887));
        gain_around(&mut bench, SetpointOutcome::Applied);
        bench.run(25.0);
        assert_eq!(bench.first().reading_gain(), gain, "{loss} {applied_mpa}");
        bench.setpoint_with_gain(6, 0.08, Some(0.9));
        gain_around(&mut bench, SetpointOutcome::Applied);
        assert_eq!(bench.first().reading_gain(), 0.9);
    }
}

#[test]
fn after_a_restart_the_estimates_gain_counts_for_the_pressure_that_the_robot_holds() {
    let mut bench = applying(|_| {});
    bench.setpoint_with_gain(5, 0.08, Some(0.887));
    gain_around(&mut bench, SetpointOutcome::Applied);
    estimate(&mut bench, 6, 0.08, Some(0.9));
    assert_eq!(bench.first().reading_gain(), 0.887, "the robot knows what it applied");
    bench.robot.restart_soon();
    bench.run(1.0);
    bench.connect();
    assert_eq!(bench.first().reading_gain(), 1.0);
    estimate(&mut bench, 7, 0.08, Some(0.887));
    assert_eq!(bench.first().reading_gain(), 1.0, "the chamber returns to its nominal pressure");
    estimate(&mut bench, 8, 0.1, Some(1.7));
    assert_eq!(bench.first().reading_gain(), 1.7);
}

#[test]
fn a_robot_that_applies_no_gain_has_the_gain_1_and_contacts_never_have_it() {
    let strains = |edit: fn(&mut Scenario)| {
        let mut bench = Bench::connected(edit);
        bench.setpoint_with_gain(5, 0.1, Some(0.5));
        bench.run(20.0);
        let gain = bench.first().reading_gain();
        let contacts = bench.contacts().into_iter().flat_map(|message| message.contacts);
        (gain, contacts.filter(|one| one.whisker == 0).map(|one| one.strain).collect::<Vec<_>>())
    };
    let (none, as_measured) = strains(|_| {});
    let (half, of_applying) = strains(|scenario| scenario.robots[0].applies_gain = true);
    assert_eq!((none, half), (1.0, 0.5));
    assert_eq!(as_measured, of_applying);
    let (_, multiplied) = strains(|scenario| {
        scenario.robots[0].applies_gain = true;
        scenario.behaviour.misbehaviour = Some(Misbehaviour::MultipliesStrain);
    });
    let halved = as_measured.iter().zip(&multiplied).filter(|(right, wrong)| **wrong == 0.5 * **right).count();
    assert!(halved > 10 && as_measured.len() == multiplied.len(), "{halved} of {}", multiplied.len());
}
