//! The factor on the readings, which a driver is told if it applies gains.

use vibrissa_protocol::{Estimate, OnSupervisorLoss, WhiskerCondition, WhiskerEstimate};

use super::*;

fn running(rule: OnSupervisorLoss) -> Bench {
    let mut bench = Bench::new(|config| {
        config.facts.applies_gain = true;
        config.facts.on_supervisor_loss = rule;
    });
    bench.step(Input::Connected);
    bench.step(Input::DriverStarted(0));
    bench.hold([0.1, 0.1], 0.2);
    bench
}

fn order(bench: &mut Bench, version: u64, pressure_mpa: f64, reading_gain: Option<f64>) {
    let setpoint = Setpoint { reading_gain, ..bench.setpoint(version, pressure_mpa) };
    bench.send(RobotTopic::Setpoint, &setpoint);
}

fn estimate(bench: &mut Bench, version: u64, pressure_mpa: f64, reading_gain: f64) {
    let whisker = WhiskerEstimate {
        array: left(),
        whisker: 0,
        length_mm: 65.0,
        length_low_mm: 64.5,
        length_high_mm: 65.5,
        condition: WhiskerCondition::Trimmed,
        pressure_mpa,
        gain: vec![],
        reading_gain: Some(reading_gain),
        response: Vec::new(),
    };
    let (boot_id, timestamp) = (supervisor(), Timestamp(START));
    let estimate = Estimate { boot_id, seq: version, epoch: 1, version, timestamp, whiskers: vec![whisker] };
    bench.send(RobotTopic::Estimate, &estimate);
}

/// The factors in lines for the first whisker.
fn factors(lines: &[ToDriver]) -> Vec<f64> {
    let factor = |line: &ToDriver| {
        let ToDriver::ReadingGain { whisker: 0, reading_gain, .. } = line else { return None };
        Some(*reading_gain)
    };
    lines.iter().filter_map(factor).collect()
}

/// The factors that the driver was told for the first whisker since the last call.
fn sent_gains(bench: &mut Bench) -> Vec<f64> {
    factors(&bench.take().1)
}

#[test]
fn the_driver_is_told_the_gain_when_the_setpoint_is_applied() {
    let mut bench = running(OnSupervisorLoss::Hold);
    assert_eq!(sent_gains(&mut bench), [1.0], "at its start");
    order(&mut bench, 1, 0.08, Some(0.887));
    assert_eq!(sent_gains(&mut bench), [1.0], "with the pressure, and not the new one");
    bench.hold([0.08, 0.1], 0.5);
    assert_eq!(sent_gains(&mut bench), [0.0; 0]);
    bench.hold([0.08, 0.1], 0.2);
    assert_eq!(sent_gains(&mut bench), [0.887]);
    bench.hold([0.08, 0.1], 4.05);
    assert_eq!(sent_gains(&mut bench), [0.887; 2], "a lost line does no harm");
    bench.step(Input::DriverEnded(0));
    bench.step(Input::DriverStarted(0));
    let lines: Vec<String> = bench.take().1.iter().map(|one| String::from_utf8(one.line()).unwrap()).collect();
    let line = r#"{"type":"reading_gain","array":"left","whisker":0,"reading_gain":0.887}"#;
    assert_eq!(lines[2].trim_end(), line, "{lines:?}");
    // A device that echoes sends the line back.
    bench.line(line);
    assert_eq!((bench.agent.counts().lines_echoed, bench.agent.counts().lines_refused), (1, 0));
}

#[test]
fn a_setpoint_that_is_superseded_or_fails_changes_no_gain() {
    let mut bench = running(OnSupervisorLoss::Hold);
    order(&mut bench, 1, 0.08, Some(0.887));
    bench.hold([0.08, 0.1], 1.0);
    order(&mut bench, 2, 0.15, Some(2.0));
    bench.hold([0.1, 0.1], 0.2);
    order(&mut bench, 3, 0.16, Some(3.0));
    bench.take();
    for _ in 0..150 {
        bench.hold([0.12, 0.1], 0.1);
    }
    let (messages, lines) = bench.take();
    let is_failed =
        |one: &Message| matches!(one, Message::SetpointState(state) if state.state == SetpointOutcome::Failed);
    assert!(messages.iter().any(is_failed), "{messages:?}");
    let factors = factors(&lines);
    assert!(factors.len() > 3 && factors.iter().all(|&factor| factor == 0.887), "{factors:?}");
}

#[test]
fn a_pressure_of_the_robots_own_has_the_gain_1() {
    for (rule, applied_mpa, factor) in [
        (OnSupervisorLoss::Hold, 0.08, 0.887),
        (OnSupervisorLoss::Nominal, 0.08, 1.0),
        (OnSupervisorLoss::Vent, 0.08, 1.0),
        (OnSupervisorLoss::Nominal, 0.1, 0.887),
    ] {
        let mut bench = running(rule);
        order(&mut bench, 1, applied_mpa, Some(0.887));
        bench.hold([applied_mpa, 0.1], 59.0);
        assert_eq!(sent_gains(&mut bench).last(), Some(&0.887), "{rule}");
        bench.hold([applied_mpa, 0.1], 5.0);
        assert_eq!(sent_gains(&mut bench).last(), Some(&factor), "{rule} {applied_mpa}");
    }
}

#[test]
fn before_the_first_setpoint_of_a_boot_the_estimates_gain_counts_for_the_pressure_held() {
    let mut bench = running(OnSupervisorLoss::Hold);
    bench.take();
    estimate(&mut bench, 1, 0.08, 0.887);
    assert_eq!(sent_gains(&mut bench), [0.0; 0]);
    estimate(&mut bench, 2, 0.1, 1.7);
    assert_eq!(sent_gains(&mut bench), [1.7]);
    order(&mut bench, 3, 0.1, Some(1.6));
    bench.hold([0.1, 0.1], 1.0);
    estimate(&mut bench, 4, 0.1, 1.7);
    assert_eq!(sent_gains(&mut bench).last(), Some(&1.6), "the robot knows what it applied");
}

#[test]
fn a_driver_that_applies_no_gain_hears_of_none() {
    let mut bench = Bench::running();
    estimate(&mut bench, 1, 0.1, 1.7);
    order(&mut bench, 2, 0.08, Some(0.887));
    bench.hold([0.08, 0.1], 6.0);
    assert_eq!(sent_gains(&mut bench), [0.0; 0]);
}
