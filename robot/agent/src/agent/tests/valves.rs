//! The agent regulates a chamber of the test: it has a supply of 0.25 MPa, and a sensor with steps of 1.22 kPa.

use vibrissa_protocol::Regulator;

use super::*;
use crate::driver::Opening;

const STEP_MPA: f64 = 0.001_220_7;

/// What the driver sends of the pressure.
#[derive(Clone, Copy, PartialEq)]
enum Sensor {
    Works,
    /// 0 V of a sensor with MPa = (V - 1) / 4.
    ShortCircuit,
    /// The driver sends other lines only.
    Missing,
    /// It stands at a reading.
    Frozen(f64),
}

struct Air {
    bench: Bench,
    pressure_mpa: f64,
    open: Option<(Opening, u64)>,
    pulses: usize,
    sensor: Sensor,
    leak_mpa_per_s: f64,
}

impl Air {
    fn new() -> Self {
        let mut bench = Bench::new(|config| config.drivers[0].limits.regulate = true);
        bench.step(Input::Connected);
        bench.step(Input::DriverStarted(0));
        Self { bench, pressure_mpa: 0.1, open: None, pulses: 0, sensor: Sensor::Works, leak_mpa_per_s: 0.0 }
    }

    /// Lets time pass, with readings each 10 ms.
    fn pass(&mut self, seconds: f64) {
        for _ in 0..(seconds * 100.0) as usize {
            for _ in 0..10 {
                self.bench.now_us += 1_000;
                self.move_air();
            }
            let before = self.bench.to_driver.len();
            self.bench.step(Input::Tick);
            match self.sensor {
                Sensor::Works => self.bench.read(0, (self.pressure_mpa / STEP_MPA).round() * STEP_MPA),
                Sensor::ShortCircuit => self.bench.read(0, -0.25),
                Sensor::Frozen(mpa) => self.bench.read(0, mpa),
                Sensor::Missing => self.bench.line(r#"{"type":"driving","driving":false}"#),
            }
            for line in &self.bench.to_driver[before..] {
                let ToDriver::Valve { whisker: 0, open, for_ms, .. } = line else { continue };
                assert!((0.0..=1000.0).contains(for_ms), "{line:?}");
                self.open = Some((*open, self.bench.now_us + (for_ms * 1000.0) as u64));
                self.pulses += 1;
            }
        }
    }

    fn move_air(&mut self) {
        let open = self.open.filter(|(_, until_us)| self.bench.now_us < *until_us).map(|(open, _)| open);
        self.pressure_mpa += match open {
            Some(Opening::Fill) => 2.0 * (0.25 - self.pressure_mpa) * 1e-3,
            Some(Opening::Vent) => -2.0 * self.pressure_mpa * 1e-3,
            Some(Opening::Close) | None => 0.0,
        } - self.leak_mpa_per_s * 1e-3;
    }
}

#[test]
fn a_setpoint_is_reached_within_a_step_by_pulses_and_held_with_few() {
    for (version, mpa) in [(1, 0.048), (2, 0.16)] {
        let mut air = Air::new();
        air.pass(1.0);
        air.bench.order(version, mpa);
        air.pass(15.0);
        let outcomes = air.bench.outcomes();
        assert_eq!(outcomes.last(), Some(&(SetpointOutcome::Applied, None)), "{outcomes:?}");
        assert!((air.pressure_mpa - mpa).abs() < 1.3 * STEP_MPA, "{} instead of {mpa}", air.pressure_mpa);
        let before = air.pulses;
        air.pass(20.0);
        assert!(air.pulses - before < 20, "{} pulses in 20 s of holding", air.pulses - before);
    }
}

#[test]
fn a_leak_that_the_regulator_finds_is_in_the_status() {
    let mut air = Air::new();
    air.leak_mpa_per_s = 0.001;
    air.pass(60.0);
    let status = air.bench.statuses().pop().unwrap();
    assert_eq!(status.whiskers[0].regulator, Regulator::Leak);
}

#[test]
fn regress_a_chamber_whose_pressure_is_not_known_is_vented() {
    for sensor in [Sensor::ShortCircuit, Sensor::Missing] {
        for is_known_at_first in [true, false] {
            let mut air = Air::new();
            if is_known_at_first {
                air.pass(1.0);
            }
            air.sensor = sensor;
            air.pass(30.0);
            assert!(air.pressure_mpa < 0.001, "{}", air.pressure_mpa);
            let status = air.bench.statuses().pop().unwrap();
            assert_eq!(status.whiskers[0].regulator, Regulator::Fault);
            // It ends by itself.
            air.sensor = Sensor::Works;
            air.pass(15.0);
            assert!((air.pressure_mpa - 0.1).abs() < 2.0 * STEP_MPA, "{}", air.pressure_mpa);
        }
    }
}

#[test]
fn regress_a_fault_ends_with_the_next_setpoint_or_start_of_the_driver() {
    for is_ordered in [true, false] {
        let mut air = Air::new();
        air.pass(10.0);
        air.sensor = Sensor::Frozen(0.1);
        air.bench.order(1, 0.15);
        air.pass(60.0);
        assert_eq!(air.bench.statuses().pop().unwrap().whiskers[0].regulator, Regulator::Fault);
        assert!(air.pressure_mpa < 0.001, "{}", air.pressure_mpa);
        air.sensor = Sensor::Works;
        air.pass(10.0);
        assert_eq!(air.bench.statuses().pop().unwrap().whiskers[0].regulator, Regulator::Fault);
        assert!(air.pressure_mpa < 0.001, "only a setpoint or a start ends it: {}", air.pressure_mpa);
        if is_ordered {
            air.bench.order(2, 0.15);
        } else {
            air.bench.step(Input::DriverEnded(0));
            air.bench.step(Input::DriverStarted(0));
        }
        air.pass(15.0);
        assert!((air.pressure_mpa - 0.15).abs() < 2.0 * STEP_MPA, "{}", air.pressure_mpa);
        if is_ordered {
            assert_eq!(air.bench.outcomes().last(), Some(&(SetpointOutcome::Applied, None)));
        }
    }
}

#[test]
fn a_pause_between_two_readings_is_no_fault() {
    let mut air = Air::new();
    air.pass(10.0);
    for _ in 0..20 {
        air.sensor = Sensor::Missing;
        air.pass(0.7);
        air.sensor = Sensor::Works;
        air.pass(0.1);
    }
    assert!((air.pressure_mpa - 0.1).abs() < 2.0 * STEP_MPA, "{}", air.pressure_mpa);
    // Nor is a first reading that is refused.
    air.bench.step(Input::DriverEnded(0));
    air.bench.run(3.0);
    air.bench.step(Input::DriverStarted(0));
    air.sensor = Sensor::ShortCircuit;
    air.pass(0.05);
    air.sensor = Sensor::Works;
    air.pass(0.2);
    assert!((air.pressure_mpa - 0.1).abs() < 2.0 * STEP_MPA, "{}", air.pressure_mpa);
}

#[test]
fn without_regulate_no_valve_is_opened() {
    let mut bench = Bench::running();
    bench.order(1, 0.05);
    bench.hold([0.1, 0.1], 5.0);
    assert!(!bench.to_driver.iter().any(|line| matches!(line, ToDriver::Valve { .. })));
}
