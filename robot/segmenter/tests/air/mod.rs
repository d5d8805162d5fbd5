//! Steps of air in which the pressure does not follow the setpoint as the segmenter expects.

use crate::stream::Random;
use vibrissa_segmenter::{Event, Params, Sample, Segmenter};

/// Strain that air adds, per MPa, and that a touch adds, per mm.
const PER_MPA: f64 = 0.02;
const PER_MM: f64 = 0.000_5;
const RATE_HZ: f64 = 100.0;
const NOISE: f64 = 0.000_003;
/// The pressure before the last step.
const BEFORE_MPA: f64 = 0.1;

/// A whisker that touches every 3 s until 50 s, with steps of air at 20 s and 40 s that are learned. At 60 s the setpoint
/// becomes `setpoint_mpa`, and the pressure is `pressure_mpa` of the time since then, which is read at `reading_hz`. Returns the
/// times of the onsets since then, and by how much the reference is off at the end.
fn last_step(setpoint_mpa: f64, reading_hz: f64, pressure_mpa: impl Fn(f64) -> f64) -> (Vec<f64>, f64) {
    let mut random = Random(7);
    let mut segmenter = Segmenter::new(Params { sign: 1.0, ..Params::default() });
    let (mut mpa, mut told_mpa, mut onsets) = (BEFORE_MPA, BEFORE_MPA, vec![]);
    for index in 0..(80.0 * RATE_HZ) as u32 {
        let t_s = f64::from(index) / RATE_HZ;
        let setpoint_mpa = match t_s {
            20.0..40.0 => 0.13,
            60.0.. => setpoint_mpa,
            _ => BEFORE_MPA,
        };
        mpa = if t_s < 60.0 { mpa + (setpoint_mpa - mpa) / RATE_HZ / 0.2 } else { pressure_mpa(t_s - 60.0) };
        if (t_s * reading_hz).fract() < reading_hz / RATE_HZ {
            told_mpa = mpa;
        }
        // 4 mm there and back in 1 s; the last 2 mm touch.
        let way_mm = if t_s < 50.0 { 4.0 * (1.0 - (2.0 * (t_s % 3.0) - 1.0).abs()).max(0.0) } else { 0.0 };
        let event = segmenter.push(Sample {
            t_us: 1_000_000 + u64::from(index) * (1e6 / RATE_HZ) as u64,
            strain: PER_MPA * mpa + PER_MM * (way_mm - 2.0).max(0.0) + NOISE * random.normal(),
            deflection_mm: Some(way_mm),
            pressure_mpa: Some(told_mpa),
            setpoint_mpa: Some(setpoint_mpa),
            ..Sample::default()
        });
        if t_s >= 60.0 && event.is_some_and(|event| matches!(event, Event::Onset { .. })) {
            onsets.push(t_s - 60.0);
        }
        if t_s < 60.0 && (t_s % 3.0) > 2.9 && t_s > 45.0 {
            assert!(
                (segmenter.reference().expect("it is known") - PER_MPA * mpa).abs() < 0.000_1,
                "the steps before are learned"
            );
        }
    }
    (onsets, segmenter.reference().expect("it is known") - PER_MPA * mpa)
}

#[test]
fn regress_readings_that_contradict_the_setpoint_count() {
    let to = |mpa: f64, mpa_per_s: f64| move |t_s: f64| BEFORE_MPA + (mpa - BEFORE_MPA).min(mpa_per_s * t_s);
    for (what, readings_hz, pressure_mpa) in [
        ("no supply", [1.0, 4.0, 20.0], to(BEFORE_MPA, 1.0)),
        ("it stalls", [1.0, 4.0, 20.0], to(0.12, 0.25)),
        ("a quick step", [1.0, 4.0, 20.0], to(0.15, 0.25)),
        ("a slew of 0.02 MPa/s", [1.0, 4.0, 20.0], to(0.15, 0.02)),
        ("a slew of 0.005 MPa/s", [4.0, 10.0, 20.0], to(0.15, 0.005)),
    ] {
        for reading_hz in readings_hz {
            let (onsets, off) = last_step(0.15, reading_hz, pressure_mpa);
            assert_eq!(onsets, [], "{what}, {reading_hz} readings a second: {off} off");
            // The pressure is known to 3 kPa.
            assert!(off.abs() < PER_MPA * 0.003, "{what}, {reading_hz} readings a second: {off} off");
        }
    }
}

#[test]
fn regress_a_leak_without_a_setpoint_makes_no_onset() {
    for mpa_per_s in [0.001, 0.003, 0.01, 0.03, 0.1] {
        for reading_hz in [4.0, 20.0] {
            let leaks = |t_s: f64| (BEFORE_MPA - mpa_per_s * t_s).max(0.02);
            let (onsets, off) = last_step(BEFORE_MPA, reading_hz, leaks);
            // Nothing tells of the leak before the first readings of it.
            assert!(
                onsets.iter().all(|at_s| *at_s < 1.0),
                "{mpa_per_s} MPa/s, {reading_hz} readings a second: {onsets:?}"
            );
            assert!(off.abs() < PER_MPA * 0.003, "{mpa_per_s} MPa/s, {reading_hz} readings a second: {off} off");
        }
    }
}
