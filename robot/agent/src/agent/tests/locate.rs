//! Questions for the place of a touch, and lines of a board that somebody configures.

use vibrissa_protocol::{Estimate, Segmenter, WhiskerCondition, WhiskerEstimate};

use super::*;

/// An estimate of whisker 0 at this pressure.
fn estimate(bench: &mut Bench, version: u64, pressure_mpa: f64, response: &[(f64, f64, f64)]) {
    let whisker = WhiskerEstimate {
        array: left(),
        whisker: 0,
        length_mm: 62.0,
        length_low_mm: 61.5,
        length_high_mm: 62.5,
        condition: WhiskerCondition::Trimmed,
        pressure_mpa,
        gain: Vec::new(),
        reading_gain: None,
        response: response.to_vec(),
    };
    let (boot_id, timestamp) = (supervisor(), Timestamp(START));
    let estimate = Estimate { boot_id, seq: version, epoch: 1, version, timestamp, whiskers: vec![whisker] };
    bench.send(RobotTopic::Estimate, &estimate);
    bench.take();
}

const RESPONSE: [(f64, f64, f64); 3] = [(20.0, 0.01, 0.0004), (40.0, 0.007, 0.00028), (62.0, 0.005, 0.0002)];

/// The answers to a line.
fn asked(bench: &mut Bench, line: &str) -> Vec<String> {
    bench.line(line);
    bench.take().1.iter().map(|line| String::from_utf8(line.line()).unwrap().trim_end().to_owned()).collect()
}

#[test]
fn a_touch_is_located_by_the_response_of_the_estimate() {
    let mut bench = Bench::running();
    estimate(&mut bench, 1, 0.1, &RESPONSE);
    let answers = asked(
        &mut bench,
        r#"{"type":"locate","id":"7","array":"left","whisker":0,"strain":0.014,"deflection_mm":2.0}"#,
    );
    assert_eq!(answers.len(), 1);
    let start = r#"{"type":"place","id":"7","array":"left","whisker":0,"distance_mm":40.0,"distance_low_mm":35."#;
    assert!(answers[0].starts_with(start) && answers[0].contains(r#""distance_high_mm":45."#), "{answers:?}");
    assert_eq!(bench.agent.counts().lines_refused, 0);
}

#[test]
fn a_touch_without_a_place_is_answered_with_the_reason() {
    let mut bench = Bench::running();
    let locate = r#"{"type":"locate","whisker":0,"strain":0.014,"deflection_mm":2.0}"#;
    let reason = |bench: &mut Bench, line: &str| {
        let answers = asked(bench, line);
        assert!(answers.len() == 1 && answers[0].starts_with(r#"{"type":"place","whisker":"#), "{answers:?}");
        answers[0].split(r#""problem":""#).nth(1).unwrap_or("none").to_owned()
    };
    assert!(reason(&mut bench, locate).starts_with("the supervisor has not told"));
    estimate(&mut bench, 1, 0.1, &RESPONSE);
    assert_eq!(reason(&mut bench, locate), "none");
    assert!(reason(&mut bench, &locate.replace("0.014", "0.1")).contains("on the chamber"));
    assert!(reason(&mut bench, &locate.replace("0.014", "0.001")).contains("check the deflection"));
    assert!(reason(&mut bench, &locate.replace("0.014", "-0.014")).contains("must be positive"));
    assert!(reason(&mut bench, &locate.replace("2.0", "0")).contains("deflection"));
    assert!(reason(&mut bench, &locate.replace("\"whisker\":0", "\"whisker\":9")).contains("no whisker left/9"));
    // On its way to another pressure, the whisker responds in another way.
    bench.read(0, 0.08);
    assert!(reason(&mut bench, locate).contains("0.0800 MPa, and the response is known at 0.1000 MPa"));
    estimate(&mut bench, 2, 0.08, &RESPONSE);
    assert_eq!(reason(&mut bench, locate), "none");
    // The next estimate has no room for the response.
    estimate(&mut bench, 3, 0.08, &[]);
    assert!(reason(&mut bench, locate).starts_with("the supervisor has not told"));
}

#[test]
fn a_board_that_somebody_configures_is_understood() {
    let mut bench = Bench::running();
    for line in [
        r#"{"type":"configuration","record":"STORED","slots":2,"baud":115200}"#,
        r#"{"type":"configuration","slot":0,"array":"left","whisker":0}"#,
        r#"{"type":"configured","changes":"UNSAVED"}"#,
        r#"{"type":"configured","changes":"UNSAVED"}"#,
        r#"{"type":"error","slot":0,"key":"limit_mpa","problem":"0.3 is not allowed","do":"send a number"}"#,
        r#"{"type":"configured","changes":"SAVED"}"#,
        r#"{"type":"configured","changes":"UNSAVED"}"#,
        r#"{"type":"hello","version":1,"name":"vibrissa_board","firmware_version":"3","configuration":"BROKEN"}"#,
    ] {
        bench.line(line);
    }
    assert_eq!(bench.agent.counts().lines_refused, 0);
    let told: Vec<&str> = bench.warnings.iter().map(|text| text.strip_prefix("the driver ").unwrap_or(text)).collect();
    assert_eq!(told.len(), 4, "{told:?}");
    assert!(told[0].starts_with("is being configured") && told[2] == told[0], "{told:?}");
    assert!(told[1].ends_with("has refused a line: 0.3 is not allowed"), "{told:?}");
    assert!(told[3].contains("damaged configuration"), "{told:?}");
}

#[test]
fn a_gauge_that_its_driver_reports_is_told_with_the_remedy() {
    let mut bench = Bench::running();
    for gauge in ["SATURATED", "SATURATED", "OK", "OPEN"] {
        bench.line(&format!(r#"{{"type":"fault","whisker":0,"gauge":"{gauge}"}}"#));
    }
    assert_eq!(bench.warnings.len(), 2, "{:?}", bench.warnings);
    assert!(bench.warnings[0].contains("the gauge SATURATED: amplify the gauge less"), "{:?}", bench.warnings);
    assert!(bench.warnings[1].contains("the gauge OPEN: check the wires"), "{:?}", bench.warnings);
    let shown = bench.agent.snapshot(Now::of_us(bench.now_us)).whiskers.remove(0);
    assert!(shown.advice.is_some_and(|advice| advice.contains("does not answer")));
}

#[test]
fn the_status_has_the_state_of_the_segmenter_if_a_driver_sends_samples() {
    let mut bench = Bench::new(|config| {
        config.facts.arrays[0].whiskers.iter_mut().for_each(|one| one.place = Some(vibrissa_protocol::PlaceKind::Tip));
    });
    bench.step(Input::Connected);
    bench.step(Input::DriverStarted(0));
    bench.read(0, 0.1);
    bench.read(1, 0.1);
    bench.line(r#"{"type":"strain","whisker":1,"every_us":10000,"strain":[0.001,0.001],"deflection_mm":[1,1]}"#);
    bench.take();
    bench.hold([0.1, 0.1], 3.0);
    let status = bench.statuses().pop().unwrap();
    let states: Vec<Option<Segmenter>> = status.whiskers.iter().map(|one| one.segmenter).collect();
    assert_eq!(states, [None, Some(Segmenter::Learning)]);
}
