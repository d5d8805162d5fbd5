//! Stamps, strain and faults.

use ros2_client::builtin_interfaces::Time;
use serde_json::json;

use super::{bridge, contact, read, report, say, tick};
use crate::bridge::{Bridge, Input, Output};
use crate::messages::{Contact, Fault, FluidPressure, Header, Strain};
use crate::units::Pressures;

/// Seconds since 1970 UTC.
const NOW_S: i32 = 1_795_248_000;
const NOW_US: u64 = 1_795_248_000_000_000;

fn stamped(stamp: Time) -> Header {
    Header { stamp, frame_id: String::new() }
}

/// The lines that follow from an input at [`NOW_S`].
fn lines(bridge: &mut Bridge, input: Input) -> Vec<serde_json::Value> {
    let outputs = bridge.step(0.0, Time::new(NOW_S, 0), input);
    let line = |output: Output| {
        let Output::Line(line) = output else { panic!("{output:?}") };
        serde_json::to_value(line).expect("JSON")
    };
    outputs.into_iter().map(line).collect()
}

fn strain(count: usize, every_us: u32) -> Strain {
    Strain {
        header: stamped(Time::ZERO),
        strain: vec![0.01; count],
        strain_2: Vec::new(),
        every_us,
        deflection_m: Vec::new(),
        distance_m: Vec::new(),
        test_id: String::new(),
    }
}

#[test]
fn a_stamp_counts_if_it_can_be_a_time_of_this_clock() {
    let mut bridge = bridge(Pressures::Gauge);
    let cases = [
        (Time::new(NOW_S - 2, 500_000_000), Some(NOW_US - 1_500_000)),
        (Time::new(NOW_S - 10, 0), Some(NOW_US - 10_000_000)),
        (Time::new(NOW_S - 11, 0), None),
        (Time::new(NOW_S, 500_000_000), Some(NOW_US + 500_000)),
        (Time::new(NOW_S, 500_001_000), None),
        // Not set; the clock of a simulation; a clock before 1970.
        (Time::ZERO, None),
        (Time::new(12, 0), None),
        (Time::new(-5, 0), None),
    ];
    for (stamp, expected) in cases {
        let touch = Contact { header: stamped(stamp), ..contact() };
        let line = &lines(&mut bridge, Input::Contact(Ok(touch)))[0];
        assert_eq!(line["t_us"].as_u64(), expected, "{stamp:?}");
    }
    let reading = FluidPressure { header: stamped(Time::new(NOW_S - 1, 0)), fluid_pressure: 50_000.0, variance: 0.0 };
    assert_eq!(lines(&mut bridge, Input::Pressure(0, Ok(reading)))[0]["t_us"], json!(NOW_US - 1_000_000));
    let report = report(tick(&mut bridge, 0.1));
    let of_bridge = &report.status[0];
    let value = |key: &str| of_bridge.values.iter().find(|one| one.key == key).map(|one| one.value.as_str());
    assert_eq!((value("stamps_unset"), value("stamps_implausible")), (Some("1"), Some("4")));
    assert_eq!(
        (of_bridge.level, of_bridge.message.as_str()),
        (1, "4 messages with an implausible stamp since the start")
    );
}

#[test]
fn strain_becomes_lines_for_the_segmenter() {
    let mut bridge = bridge(Pressures::Gauge);
    let one = Strain { deflection_m: vec![0.002], distance_m: vec![0.05], ..strain(1, 0) };
    let line = &lines(&mut bridge, Input::Strain(0, Ok(one)))[0];
    let expected = json!({"type": "strain", "array": "left", "whisker": 0, "t_us": NOW_US, "strain": 0.01,
        "deflection_mm": 2.0, "distance_mm": 50.0});
    assert_eq!(line, &expected);
    // Without a stamp the last sample has been taken now.
    let many =
        Strain { strain_2: vec![0.02; 100], deflection_m: vec![0.002], test_id: "t".to_owned(), ..strain(100, 1000) };
    let line = &lines(&mut bridge, Input::Strain(0, Ok(many)))[0];
    assert_eq!((&line["t_us"], &line["every_us"]), (&json!(NOW_US - 99_000), &json!(1000)));
    assert_eq!((&line["deflection_mm"], &line["test_id"]), (&json!(2.0), &json!("t")));
    assert_eq!(
        (line["strain"].as_array().map(Vec::len), line["strain_2"].as_array().map(Vec::len)),
        (Some(100), Some(100))
    );
    // The first of many samples may be older than the greatest age of a stamp.
    let long = Strain { header: stamped(Time::new(NOW_S - 60, 0)), ..strain(600, 100_000) };
    assert_eq!(lines(&mut bridge, Input::Strain(0, Ok(long)))[0]["t_us"], json!(NOW_US - 60_000_000));
}

#[test]
fn bad_strain_is_refused() {
    let mut bridge = bridge(Pressures::Gauge);
    let bad = [
        (strain(0, 0), "1 to 1000"),
        (strain(1001, 1000), "1 to 1000"),
        (strain(2, 0), "every_us is 0"),
        (strain(2, 100_001), "every_us is 100001"),
        (Strain { strain: vec![f64::NAN], ..strain(1, 0) }, "strain has a number that is not finite"),
        (Strain { strain_2: vec![0.1], ..strain(2, 1000) }, "strain_2 has 1 numbers for 2 samples"),
        (Strain { deflection_m: vec![0.1; 3], ..strain(2, 1000) }, "deflection_m has 3 numbers"),
        (Strain { test_id: "x".repeat(65), ..strain(1, 0) }, "test_id"),
    ];
    for (samples, expected) in bad {
        let outputs = bridge.step(0.0, Time::new(NOW_S, 0), Input::Strain(0, Ok(samples)));
        assert!(
            matches!(&outputs[..], [Output::Log(problem)] if problem.contains(expected)),
            "{expected}: {outputs:?}"
        );
    }
}

#[test]
fn reported_states_reach_the_agent_and_stay() {
    let mut bridge = bridge(Pressures::Gauge);
    let fault = |gauge: &str, regulator: &str| {
        let (gauge, regulator) = (gauge.to_owned(), regulator.to_owned());
        Input::Fault(Ok(Fault { header: stamped(Time::ZERO), array: "left".to_owned(), whisker: 0, gauge, regulator }))
    };
    let broken = lines(&mut bridge, fault("OPEN", ""));
    assert_eq!(broken, [json!({"type": "fault", "array": "left", "whisker": 0, "gauge": "OPEN"})]);
    let leaks = lines(&mut bridge, fault("", "LEAK"));
    assert_eq!(leaks, [json!({"type": "fault", "array": "left", "whisker": 0, "regulator": "LEAK"})]);
    // A reading without a state would make the agent conclude one.
    let reading = read(&mut bridge, 0.1, 50_000.0);
    assert!(
        matches!(&reading[..], [Output::Line(line)] if serde_json::to_value(line).expect("JSON")["regulator"] == "LEAK")
    );
    // An agent that has started again knows nothing.
    let whiskers = json!([{"array": "left", "whisker": 0, "pressure_mpa": 0.1, "pressure_max_mpa": 0.2}]);
    let outputs = say(&mut bridge, 0.2, &json!({"type": "hello", "version": 1, "whiskers": whiskers}));
    assert!(
        matches!(&outputs[..], [Output::Line(line)]
        if serde_json::to_value(line).expect("JSON")["gauge"] == "OPEN"),
        "{outputs:?}"
    );
    for bad in [fault("", ""), fault("BROKEN", ""), fault("", "ok")] {
        let outputs = bridge.step(0.0, Time::new(NOW_S, 0), bad);
        assert!(matches!(&outputs[..], [Output::Log(_)]), "{outputs:?}");
    }
}
