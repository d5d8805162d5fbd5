//! Tests of the bridge without a network.

mod definitions;
mod lifecycle;
mod mapping;
mod messages;
mod ros_args;
mod touch;

use ros2_client::builtin_interfaces::Time;
use serde_json::json;

use crate::bridge::{Bridge, Input, Output, Settings};
use crate::lifecycle::Activity;
use crate::log::Limited;
use crate::messages::{Contact, DiagnosticArray, Float64, FluidPressure, Header, Level};
use crate::names::topics;
use crate::units::Pressures;
use crate::words::{Named, ToAgent};

const ATMOSPHERE_PA: f64 = 101_325.0;

fn bridge(pressures: Pressures) -> Bridge {
    let settings = Settings { robot: "crawler".to_owned(), pressures, activity: Activity::Active, mapping: None };
    let mut bridge = Bridge::new(settings);
    let hello = bridge.step(0.0, Time::new(1, 0), Input::Linked);
    let (name, software_version) = ("vibrissa-ros2".to_owned(), env!("CARGO_PKG_VERSION"));
    assert_eq!(hello, [Output::Line(ToAgent::Hello { version: 1, name, software_version })]);
    let whiskers = json!([{"array": "left", "whisker": 0, "pressure_mpa": 0.1, "pressure_max_mpa": 0.2}]);
    let opened = say(&mut bridge, 0.0, &json!({"type": "hello", "version": 1, "whiskers": whiskers}));
    assert!(matches!(&opened[..], [Output::Open(whiskers)] if whiskers.len() == 1));
    bridge
}

fn header() -> Header {
    Header { stamp: Time::new(1, 0), frame_id: String::new() }
}

fn say(bridge: &mut Bridge, now_s: f64, line: &serde_json::Value) -> Vec<Output> {
    bridge.step(now_s, Time::new(1, 0), Input::Line(Ok(line.to_string())))
}

fn read(bridge: &mut Bridge, now_s: f64, pa: f64) -> Vec<Output> {
    let reading = FluidPressure { header: header(), fluid_pressure: pa, variance: 0.0 };
    bridge.step(now_s, Time::new(1, 0), Input::Pressure(0, Ok(reading)))
}

fn tick(bridge: &mut Bridge, now_s: f64) -> Vec<Output> {
    bridge.step(now_s, Time::new(1, 0), Input::Tick)
}

fn command(bridge: &mut Bridge, now_s: f64, pressure_mpa: f64) -> Vec<Output> {
    let whisker = json!({"type": "set_pressure", "array": "left", "whisker": 0, "pressure_mpa": pressure_mpa});
    let mut line = whisker;
    line["slew_mpa_per_s"] = json!(0.1);
    say(bridge, now_s, &line)
}

fn setpoints_pa(outputs: &[Output]) -> Vec<f64> {
    let setpoint = |output: &Output| {
        let Output::Setpoint(0, setpoint) = output else { return None };
        Some(setpoint.fluid_pressure)
    };
    outputs.iter().filter_map(setpoint).collect()
}

fn report(outputs: Vec<Output>) -> DiagnosticArray {
    let found = outputs.into_iter().find_map(|output| {
        let Output::Report(report) = output else { return None };
        Some(report)
    });
    found.expect("a report")
}

fn contact() -> Contact {
    Contact {
        header: header(),
        array: "left".to_owned(),
        whisker: 0,
        deflection_m: 0.002,
        strain: 0.01,
        place: 1,
        distance_m: 0.05,
        distance_sd_m: 0.0005,
        ratio: 0.0,
        ratio_sd: 0.0,
        test_id: String::new(),
        missed: false,
        saturated: false,
    }
}

#[test]
fn a_setpoint_moves_from_the_reading_no_faster_than_allowed() {
    let mut bridge = bridge(Pressures::Absolute(ATMOSPHERE_PA));
    command(&mut bridge, 0.0, 0.1);
    assert!(setpoints_pa(&tick(&mut bridge, 0.1)).is_empty(), "no reading yet");
    read(&mut bridge, 0.2, ATMOSPHERE_PA + 50_000.0);
    let mut last_pa = ATMOSPHERE_PA + 50_000.0;
    for step in 0..=8 {
        let got = setpoints_pa(&tick(&mut bridge, 0.2 + 0.1 * f64::from(step)));
        let expected_pa = (ATMOSPHERE_PA + 50_000.0 + 10_000.0 * f64::from(step)).min(ATMOSPHERE_PA + 100_000.0);
        // An unchanged setpoint is not repeated within a second.
        match got[..] {
            [pa] => last_pa = pa,
            _ => assert!(step > 5 && got.is_empty(), "{step}: {got:?}"),
        }
        assert!((last_pa - expected_pa).abs() < 1.0, "{step}: {last_pa} {expected_pa}");
    }
    read(&mut bridge, 1.9, ATMOSPHERE_PA + 100_000.0);
    assert_eq!(setpoints_pa(&tick(&mut bridge, 2.0)).len(), 1, "repeated after a second");
}

#[test]
fn no_setpoint_without_fresh_readings_and_commands() {
    let mut bridge = bridge(Pressures::Gauge);
    command(&mut bridge, 0.0, 0.1);
    read(&mut bridge, 0.0, 100_000.0);
    let is_held = |outputs: &[Output]| matches!(setpoints_pa(outputs)[..], [pa] if (pa - 100_000.0).abs() < 0.01);
    assert!(is_held(&tick(&mut bridge, 0.1)));
    assert!(setpoints_pa(&tick(&mut bridge, 3.2)).is_empty(), "the reading is old");
    read(&mut bridge, 10.2, 100_000.0);
    assert!(setpoints_pa(&tick(&mut bridge, 10.3)).is_empty(), "the command is old");
    command(&mut bridge, 10.4, 0.1);
    assert!(is_held(&tick(&mut bridge, 10.5)));
}

#[test]
fn bad_commands_change_nothing() {
    let mut bridge = bridge(Pressures::Gauge);
    read(&mut bridge, 0.0, 0.0);
    for pressure in [json!(0.21), json!(-0.01), json!(null), json!("0.1")] {
        let mut line = json!({"type": "set_pressure", "array": "left", "whisker": 0, "slew_mpa_per_s": 0.1});
        line["pressure_mpa"] = pressure.clone();
        assert!(matches!(&say(&mut bridge, 0.1, &line)[..], [Output::Log(_)]), "{pressure}");
    }
    for slew in [json!(0.0), json!(-1.0), json!(null)] {
        let mut line = json!({"type": "set_pressure", "array": "left", "whisker": 0, "pressure_mpa": 0.1});
        line["slew_mpa_per_s"] = slew.clone();
        assert!(matches!(&say(&mut bridge, 0.1, &line)[..], [Output::Log(_)]), "{slew}");
    }
    assert!(setpoints_pa(&tick(&mut bridge, 0.2)).is_empty());
}

#[test]
fn regress_the_newest_hello_tells_the_highest_pressure() {
    for (max_mpa, mpa, is_obeyed) in [(0.3, 0.25, true), (0.15, 0.18, false)] {
        let mut bridge = bridge(Pressures::Gauge);
        let whisker = json!({"array": "left", "whisker": 0, "pressure_mpa": 0.1, "pressure_max_mpa": max_mpa});
        say(&mut bridge, 1.0, &json!({"type": "hello", "version": 1, "whiskers": [whisker]}));
        read(&mut bridge, 1.0, mpa * 1e6);
        command(&mut bridge, 1.0, mpa);
        assert_eq!(!setpoints_pa(&tick(&mut bridge, 1.1)).is_empty(), is_obeyed, "{max_mpa}");
    }
}

#[test]
fn silent_whiskers_are_reported_again_and_again_and_their_return_once() {
    let mut bridge = bridge(Pressures::Gauge);
    let fault = |outputs: Vec<Output>| {
        outputs.iter().any(|one| matches!(one, Output::Line(ToAgent::Fault { regulator: Some("FAULT"), .. })))
    };
    assert!(!fault(tick(&mut bridge, 2.9)));
    assert!(fault(tick(&mut bridge, 3.1)));
    assert!(!fault(tick(&mut bridge, 3.2)));
    assert!(fault(tick(&mut bridge, 5.2)));
    let returned = read(&mut bridge, 5.3, 80_000.0);
    assert!(matches!(&returned[..], [Output::Line(ToAgent::Pressure { regulator: Some("OK"), .. })]), "{returned:?}");
    let next = read(&mut bridge, 5.4, 80_000.0);
    assert!(matches!(&next[..], [Output::Line(ToAgent::Pressure { regulator: None, .. })]), "{next:?}");
    assert!(read(&mut bridge, 5.41, 80_000.0).is_empty(), "at most 20 readings a second");
}

#[test]
fn the_wrong_kind_of_pressure_is_refused() {
    let mut bridge = bridge(Pressures::Absolute(ATMOSPHERE_PA));
    let outputs = read(&mut bridge, 0.0, 20_000.0);
    assert!(matches!(&outputs[..], [Output::Log(problem)] if problem.contains("--pressures gauge")), "{outputs:?}");
    for pa in [f64::NAN, f64::INFINITY, 5e6] {
        assert!(matches!(&read(&mut bridge, 0.0, pa)[..], [Output::Log(_)]), "{pa}");
    }
}

#[test]
fn contacts_become_lines_in_the_units_of_the_agent() {
    let mut bridge = bridge(Pressures::Gauge);
    let mut line = |contact: Contact| match &bridge.step(0.0, Time::new(1, 0), Input::Contact(Ok(contact)))[..] {
        [Output::Line(line)] => serde_json::to_value(line).expect("JSON"),
        other => panic!("{other:?}"),
    };
    let place = |value: &serde_json::Value, field: &str| value[field].as_f64().expect("a number");
    let at_distance = line(contact());
    assert!((place(&at_distance, "distance_mm") - 50.0).abs() < 1e-9, "{at_distance}");
    assert!((place(&at_distance, "distance_sd_mm") - 0.5).abs() < 1e-9, "{at_distance}");
    assert!((place(&at_distance, "deflection_mm") - 2.0).abs() < 1e-9, "{at_distance}");
    assert_eq!(at_distance["ratio"], json!(null));
    let at_ratio = line(Contact { place: 2, ratio: 0.8, ..contact() });
    assert_eq!((&at_ratio["ratio"], &at_ratio["distance_mm"]), (&json!(0.8), &json!(null)));
    let at_tip = line(Contact { place: 3, distance_m: 0.0, ..contact() });
    assert_eq!((&at_tip["tip"], &at_tip["distance_mm"]), (&json!(true), &json!(null)));
    let missed = line(Contact { missed: true, ..contact() });
    assert_eq!(missed["touched"], json!(false));
    let saturated = line(Contact { saturated: true, ..contact() });
    assert_eq!((&saturated["saturated"], &missed["saturated"]), (&json!(true), &json!(null)));
}

#[test]
fn bad_contacts_are_counted_and_the_reason_is_reported() {
    let mut bridge = bridge(Pressures::Gauge);
    read(&mut bridge, 0.0, 100_000.0);
    let bad = [
        Contact { strain: f64::NAN, ..contact() },
        Contact { place: 4, ..contact() },
        Contact { whisker: 1, ..contact() },
        Contact { test_id: "x".repeat(65), ..contact() },
    ];
    for contact in bad {
        let outputs = bridge.step(0.0, Time::new(1, 0), Input::Contact(Ok(contact)));
        assert!(matches!(&outputs[..], [Output::Log(_)]), "{outputs:?}");
    }
    bridge.step(0.0, Time::new(1, 0), Input::Contact(Err("too short".to_owned())));
    bridge.step(0.0, Time::new(1, 0), Input::Shed(3));
    let report = report(tick(&mut bridge, 0.1));
    let of_bridge = &report.status[0];
    assert_eq!((of_bridge.level, of_bridge.name.as_str()), (Level::Warn as u8, "vibrissa: bridge"));
    let value = |key: &str| of_bridge.values.iter().find(|one| one.key == key).map(|one| one.value.as_str());
    assert_eq!((value("refused"), value("shed")), (Some("5"), Some("3")));
    assert_eq!(
        value("last_problem"),
        Some("an unreadable contact: too short; are the vibrissa_msgs of this version built?")
    );
}

#[test]
fn the_factor_on_readings_is_published_and_appears_in_the_report() {
    let mut bridge = bridge(Pressures::Gauge);
    read(&mut bridge, 0.0, 100_000.0);
    let line = |factor: f64| json!({"type": "reading_gain", "array": "left", "whisker": 0, "reading_gain": factor});
    let outputs = say(&mut bridge, 0.1, &line(0.887));
    assert_eq!(outputs, [Output::ReadingGain(0, Float64 { data: 0.887 })]);
    for wrong in [0.0, -1.0, 21.0] {
        assert!(matches!(&say(&mut bridge, 0.1, &line(wrong))[..], [Output::Log(_)]), "{wrong}");
    }
    let report = report(tick(&mut bridge, 0.2));
    let values = &report.status[1].values;
    assert!(values.iter().any(|pair| pair.key == "reading_gain" && pair.value == "0.8870"), "{values:?}");
}

#[test]
fn an_estimate_is_published_and_appears_in_the_report() {
    let mut bridge = bridge(Pressures::Gauge);
    read(&mut bridge, 0.0, 100_000.0);
    let estimate = json!({"type": "estimate", "array": "left", "whisker": 0, "length_mm": 54.2, "length_low_mm": 53.1,
        "length_high_mm": 55.3, "condition": "TRIMMED", "gain": [[0.5, 1.1]]});
    let outputs = say(&mut bridge, 0.0, &estimate);
    let [Output::Estimate(0, message)] = &outputs[..] else { panic!("{outputs:?}") };
    assert!((message.length_m - 0.0542).abs() < 1e-9 && (message.length_low_m - 0.0531).abs() < 1e-9, "{message:?}");
    assert_eq!((message.array.as_str(), message.whisker, message.condition.as_str()), ("left", 0, "TRIMMED"));
    assert_eq!((&message.gain_ratio[..], &message.gain[..]), (&[0.5][..], &[1.1][..]));
    let report = report(tick(&mut bridge, 0.1));
    let whisker = &report.status[1];
    assert_eq!((whisker.level, whisker.message.as_str()), (Level::Warn as u8, "trimmed"));
    assert!(whisker.values.iter().any(|one| one.key == "length_mm" && one.value == "54.2000"));
}

#[test]
fn an_agent_of_another_version_or_with_other_whiskers_ends_the_program() {
    let mut bridge = bridge(Pressures::Gauge);
    let hello = |version: u32, array: &str| {
        let whisker = json!({"array": array, "whisker": 0, "pressure_mpa": 0.1, "pressure_max_mpa": 0.2});
        json!({"type": "hello", "version": version, "whiskers": [whisker]})
    };
    assert!(say(&mut bridge, 0.0, &hello(1, "left")).is_empty());
    assert!(matches!(&say(&mut bridge, 0.0, &hello(1, "right"))[..], [Output::Stop(_)]));
    assert!(matches!(&say(&mut bridge, 0.0, &hello(2, "left"))[..], [Output::Stop(_)]));
}

#[test]
fn names_of_topics_fit_ros_and_differ() {
    let named = |array: &str| Named { array: array.to_owned(), whisker: 3, pressure_max_mpa: 0.2 };
    let of = |array: &str| topics(&[named(array)]).map(|all| all[0].clone());
    assert_eq!(of("left-front"), Ok("left_front/whisker_3".to_owned()));
    assert_eq!(of("2--top"), Ok("array_2_top/whisker_3".to_owned()));
    assert!(topics(&[named("a-b"), named("a_b")]).is_err());
}

#[test]
fn a_flood_of_problems_is_not_logged() {
    let mut limited = Limited::default();
    let logged = (0..10_000).filter_map(|step| limited.line(f64::from(step) / 1000.0, "bad"));
    let logged: Vec<String> = logged.collect();
    assert!((20..=30).contains(&logged.len()), "{}", logged.len());
    assert!(logged.last().expect("a line").contains("problems left out"), "{logged:?}");
}
