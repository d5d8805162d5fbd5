//! The regulator on simulated chambers whose volume, valves, sensor and faults vary at random.

mod chamber;
mod vectors;

use chamber::{Random, Rig, STEP_MPA, Sensor};
use vibrissa_regulator::{Condition, Fault, Params};

const SEEDS: u64 = 120;

fn rig(seed: u64) -> Rig {
    Rig::new(Params::default(), seed)
}

#[test]
fn property_it_holds_each_setpoint_within_a_step_and_seldom_switches() {
    for seed in 0..SEEDS {
        let mut rig = rig(seed);
        let mut random = Random(seed + 1_000);
        for _ in 0..4 {
            let target = random.between(0.01, 0.2);
            rig.regulator.set_target(target as f32, 0.0);
            let before = rig.pulses;
            rig.run(12.0, |_| {});
            assert!(rig.pulses - before < 40, "seed {seed}: {} pulses on the way", rig.pulses - before);
            let (before, mut worst, mut samples, mut beyond) = (rig.pulses, 0.0f64, 0u32, 0u32);
            rig.run(20.0, |rig| {
                let error = (rig.true_mpa - target).abs() / STEP_MPA;
                worst = worst.max(error);
                samples += 1;
                beyond += u32::from(error > 1.0);
                assert_eq!(
                    rig.regulator.condition(),
                    Condition::Ok,
                    "seed {seed} at {target}: {:?}",
                    rig.regulator.fault()
                );
            });
            assert!(
                worst < 1.6,
                "seed {seed}, {target}: {worst} steps away (tau {}, noise {})",
                rig.tau_s,
                rig.noise_steps
            );
            assert!(
                f64::from(beyond) < 0.12 * f64::from(samples),
                "seed {seed}, {target}: {beyond} of {samples} beyond a step (tau {}, noise {}, reading {})",
                rig.tau_s,
                rig.noise_steps,
                rig.reading_us
            );
            assert!(rig.pulses - before <= 8, "seed {seed}: {} pulses in 20 s of hold", rig.pulses - before);
        }
        assert!(rig.highest_mpa < 0.2 + STEP_MPA, "seed {seed}: {}", rig.highest_mpa);
    }
}

#[test]
fn property_a_slew_limit_is_kept() {
    for seed in 0..SEEDS / 2 {
        let mut rig = rig(seed);
        rig.regulator.set_target(0.1, 0.01);
        let mut ahead = 0.0f64;
        rig.run(10.0, |rig| ahead = ahead.max(rig.true_mpa - rig.now_us as f64 * 0.01e-6));
        assert!(ahead < 4.0 * STEP_MPA, "seed {seed}: {} steps ahead of the ramp", ahead / STEP_MPA);
        rig.run(5.0, |_| {});
        assert!((rig.true_mpa - 0.1).abs() < 1.3 * STEP_MPA, "seed {seed}: {}", rig.true_mpa);
    }
}

#[test]
fn property_leaks_are_reported_and_refilled() {
    for seed in 0..SEEDS {
        let mut rig = rig(seed);
        rig.regulator.set_target(0.1, 0.0);
        rig.run(12.0, |_| {});
        let leak = 0.0001 * 40f64.powf(seed as f64 / (SEEDS - 1) as f64);
        rig.leak_mpa_per_s = leak;
        let limit_s = 20.0 + 4.0 * STEP_MPA / leak;
        rig.run(limit_s, |_| {});
        assert_eq!(rig.regulator.condition(), Condition::Leak, "seed {seed}: {leak}");
        let mut worst = 0.0f64;
        let before = rig.pulses;
        rig.run(20.0, |rig| worst = worst.max((rig.true_mpa - 0.1).abs() / STEP_MPA));
        assert!(worst < 2.0, "seed {seed}: {worst} steps away with a leak of {leak} (tau {})", rig.tau_s);
        assert!(rig.pulses - before <= 80, "{}", rig.pulses - before);
        let measured = f64::from(rig.regulator.leak_mpa_per_s());
        assert!((0.4..2.2).contains(&(measured / leak)), "seed {seed}: {measured} measured of {leak}");
        rig.leak_mpa_per_s = 0.0;
        rig.run(240.0, |_| {});
        assert_eq!(rig.regulator.condition(), Condition::Ok, "seed {seed}: after the leak");
    }
}

#[test]
fn property_a_burst_chamber_is_a_fault() {
    for seed in 0..SEEDS / 2 {
        let mut rig = rig(seed);
        rig.regulator.set_target(0.1, 0.0);
        rig.run(12.0, |_| {});
        rig.leak_mpa_per_s = 0.2;
        rig.run(20.0, |_| {});
        assert_eq!(rig.regulator.fault(), Some(Fault::Burst), "seed {seed}");
    }
}

#[test]
fn property_a_lost_supply_is_reported_and_its_return_is_seen() {
    for seed in 0..SEEDS {
        let mut rig = rig(seed);
        rig.supply_sensor = seed % 2 == 0;
        rig.regulator.set_target(0.06, 0.0);
        rig.run(12.0, |_| {});
        // A supply that is lost behind a check valve neither fills nor empties the chamber.
        let supply = rig.supply_mpa;
        if rig.supply_sensor {
            rig.supply_mpa = 0.03;
        } else {
            rig.fill_stuck = Some(0.0);
        }
        rig.regulator.set_target(0.12, 0.0);
        rig.run(10.0, |_| {});
        assert_eq!(rig.regulator.condition(), Condition::SupplyLow, "seed {seed}: {:?}", rig.regulator.fault());
        rig.supply_mpa = supply;
        rig.fill_stuck = None;
        rig.run(40.0, |_| {});
        assert_eq!(rig.regulator.condition(), Condition::Ok, "seed {seed}: {:?}", rig.regulator.fault());
        assert!((rig.true_mpa - 0.12).abs() < 1.6 * STEP_MPA, "seed {seed}: {}", rig.true_mpa);
    }
}

#[test]
fn property_a_supply_that_is_away_at_the_start_is_reported() {
    for seed in 0..SEEDS / 2 {
        let mut rig = rig(seed);
        rig.supply_mpa = 0.0;
        rig.regulator.set_target(0.1, 0.0);
        rig.run(12.0, |_| {});
        assert_eq!(rig.regulator.condition(), Condition::SupplyLow, "seed {seed}: {:?}", rig.regulator.fault());
        rig.run(200.0, |_| {});
        assert_eq!(rig.regulator.condition(), Condition::Fault, "seed {seed}");
        let before = rig.pulses;
        rig.run(60.0, |_| {});
        assert_eq!(rig.pulses, before, "seed {seed}: it goes on");
    }
}

#[test]
fn property_a_stuck_valve_is_a_fault() {
    for seed in 0..SEEDS {
        let mut rig = rig(seed);
        rig.supply_sensor = true;
        rig.regulator.set_target(0.08, 0.0);
        rig.run(12.0, |_| {});
        match seed % 3 {
            0 => rig.fill_stuck = Some(0.0),
            1 => rig.vent_stuck = Some(0.0),
            // Does not close completely.
            _ => rig.fill_stuck = Some(0.05),
        }
        rig.regulator.set_target(if seed % 3 == 1 { 0.03 } else { 0.12 }, 0.0);
        rig.run(40.0, |_| {});
        assert_eq!(rig.regulator.condition(), Condition::Fault, "seed {seed}: {} tau {}", rig.true_mpa, rig.tau_s);
        let expected = if seed % 3 == 1 { Fault::NoResponse } else { Fault::FillValve };
        if seed % 3 != 2 {
            assert_eq!(rig.regulator.fault(), Some(expected), "seed {seed}");
        }
        if seed % 3 != 1 {
            assert!(rig.highest_mpa < 0.2 + STEP_MPA, "seed {seed}: {}", rig.highest_mpa);
        }
    }
}

#[test]
fn property_a_dead_sensor_ends_in_a_fault_and_an_empty_chamber() {
    for seed in 0..SEEDS {
        let mut rig = rig(seed);
        rig.regulator.set_target(0.1, 0.0);
        rig.run(if seed % 2 == 0 { 12.0 } else { 0.15 }, |_| {});
        rig.sensor = [Sensor::Dead, Sensor::Saturated, Sensor::NotANumber][seed as usize % 3];
        let before = rig.true_mpa;
        rig.run(0.5, |_| {});
        assert_eq!(rig.regulator.fault(), Some(Fault::Sensor), "seed {seed}");
        rig.run(25.0, |_| {});
        assert!(rig.true_mpa < 0.001, "seed {seed}: {before} before, {} after", rig.true_mpa);
        let pulses = rig.pulses;
        rig.run(10.0, |_| {});
        assert_eq!(rig.pulses, pulses, "seed {seed}: it goes on");
        rig.sensor = Sensor::Good;
        rig.run(15.0, |_| {});
        assert_eq!(
            rig.regulator.condition(),
            Condition::Ok,
            "seed {seed}: after the sensor came back: {:?}",
            rig.regulator.fault()
        );
        assert!((rig.true_mpa - 0.1).abs() < 1.6 * STEP_MPA, "seed {seed}: {}", rig.true_mpa);
    }
}

#[test]
fn property_a_frozen_sensor_ends_in_a_fault_at_the_next_move() {
    let mut highest = 0.0f64;
    for seed in 0..SEEDS {
        let mut rig = rig(seed);
        let start = if seed % 2 == 0 {
            rig.regulator.set_target(0.06, 0.0);
            rig.run(12.0, |_| {});
            0.06
        } else {
            0.0
        };
        rig.sensor = Sensor::Frozen(start);
        rig.regulator.set_target(if seed % 4 == 2 { 0.03 } else { 0.1 }, 0.0);
        rig.run(90.0, |_| {});
        assert_eq!(rig.regulator.condition(), Condition::Fault, "seed {seed}");
        assert!(rig.true_mpa < 0.001, "seed {seed}: {}", rig.true_mpa);
        highest = highest.max(rig.highest_mpa);
        let pulses = rig.pulses;
        rig.run(30.0, |_| {});
        assert_eq!(rig.pulses, pulses, "seed {seed}: it goes on");
    }
    println!("frozen sensor: up to {highest:.3} MPa before the fault");
    assert!(highest < 0.2, "{highest}");
}

#[test]
fn a_zero_error_of_the_sensor_is_no_fault() {
    let mut rig = rig(5);
    rig.regulator.set_target(0.05, 0.0);
    rig.run(10.0, |_| {});
    rig.sensor = Sensor::Frozen(0.005);
    rig.true_mpa = 0.0;
    rig.regulator.set_target(0.0, 0.0);
    rig.run(60.0, |_| {});
    assert_eq!(rig.regulator.condition(), Condition::Ok, "{:?}", rig.regulator.fault());
}

#[test]
fn a_setpoint_is_cut_to_the_limits_and_a_nan_is_ignored() {
    let mut rig = rig(7);
    rig.regulator.set_target(0.9, 0.0);
    assert_eq!(rig.regulator.target_mpa(), Some(0.2));
    rig.regulator.set_target(f32::NAN, 0.0);
    assert_eq!(rig.regulator.target_mpa(), Some(0.2));
    rig.regulator.set_target(-1.0, f32::NAN);
    assert_eq!(rig.regulator.target_mpa(), Some(0.0));
}

#[test]
fn valves_close_at_the_end_of_a_pulse_even_if_nobody_steps_any_more() {
    let mut valves = vibrissa_regulator::Valves::new();
    valves.apply(1_000, vibrissa_regulator::Command::Fill(u32::MAX));
    assert_eq!(valves.outputs(1_000), (true, false));
    assert_eq!(valves.outputs(1_000_999), (true, false));
    assert_eq!(valves.outputs(1_001_000), (false, false), "no pulse is longer than a second");
    valves.apply(5_000_000, vibrissa_regulator::Command::Vent(10));
    valves.apply(5_000_001, vibrissa_regulator::Command::Fill(10));
    assert_eq!(valves.outputs(5_000_002), (true, false), "never both");
    valves.apply(5_000_003, vibrissa_regulator::Command::Close);
    assert_eq!(valves.outputs(5_000_003), (false, false));
}

#[test]
fn readings_four_times_a_second_suffice_for_a_large_chamber() {
    for seed in 0..SEEDS / 4 {
        let mut rig = rig(seed);
        rig.tau_s = 2.0;
        rig.reading_us = 250_000;
        rig.regulator.set_target(0.1, 0.0);
        rig.run(60.0, |_| {});
        let (before, mut worst) = (rig.pulses, 0.0f64);
        rig.run(60.0, |rig| worst = worst.max((rig.true_mpa - 0.1).abs() / STEP_MPA));
        assert_eq!(rig.regulator.condition(), Condition::Ok, "seed {seed}: {:?}", rig.regulator.fault());
        assert!(worst < 1.6, "seed {seed}: {worst} steps away");
        assert!(rig.pulses - before < 30, "seed {seed}: {} pulses", rig.pulses - before);
        assert!(rig.highest_mpa < 0.13, "seed {seed}: {}", rig.highest_mpa);
    }
}
