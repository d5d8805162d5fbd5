use std::time::Duration;

use axum::http::{Method, StatusCode};
use prometheus::core::Collector;
use vibrissa_edge::invariants::{Checker, Invariant};

use super::*;

fn shown(metrics: &Metrics) -> String {
    String::from_utf8(metrics.text().unwrap()).unwrap()
}

fn fleet() -> Name {
    Name::new("f").unwrap()
}

#[test]
fn every_series_of_a_fleet_is_there_from_the_start() {
    let metrics = Metrics::new(false).unwrap();
    assert!(!shown(&metrics).contains("fleet="));
    let of_fleet = metrics.of_fleet(&fleet());
    let before = shown(&metrics);
    assert!(before.contains("vibrissa_messages_refused_total{fleet=\"f\",reason=\"unknown_topic\"} 0"), "{before}");
    assert!(
        before.contains("vibrissa_compensations_total{case=\"NONE\",fleet=\"f\",outcome=\"UNSERVED\"} 0"),
        "{before}"
    );
    assert!(before.contains("vibrissa_setpoints_total{fleet=\"f\",state=\"APPLIED\"} 0"), "{before}");
    of_fleet.messages_refused.count(["unknown_topic"]);
    of_fleet.compensations.count(["SELF_COMPENSATION", "STARTED"]);
    assert_eq!(shown(&metrics).lines().count(), before.lines().count());
    assert_eq!(metrics.of_fleet(&fleet()).messages_refused.of(["unknown_topic"]).get(), 1);
}

#[test]
fn every_invariant_that_the_supervisor_checks_is_there_from_the_start_and_its_violations_are_counted() {
    let metrics = Metrics::new(false).unwrap();
    let before = shown(&metrics);
    let series =
        |text: &str| text.lines().filter(|line| line.starts_with("vibrissa_invariant_violations_total{")).count();
    let checked = Invariant::ALL.iter().filter(|one| one.is_checked_by(Checker::Production));
    for invariant in checked.clone() {
        let line = format!("vibrissa_invariant_violations_total{{invariant=\"{}\"}} 0\n", invariant.word());
        assert!(before.contains(&line), "{before}");
        metrics.of_fleet(&fleet()).violations.count(*invariant, &fleet(), &"planted");
    }
    let after = shown(&metrics);
    assert_eq!((series(&before), series(&after)), (checked.clone().count(), checked.count()));
    assert!(after.contains("vibrissa_invariant_violations_total{invariant=\"EPOCH_ONCE\"} 1\n"), "{after}");
}

#[test]
fn a_fleet_that_is_elsewhere_has_nothing_here_and_its_quantities_are_not_shown() {
    let metrics = Metrics::new(false).unwrap();
    let of_fleet = metrics.of_fleet(&fleet());
    of_fleet.whiskers.set_all(|health| i64::from(health == "HEALTHY") * 7);
    of_fleet.compensation_error_mean_ratio.set_all(|case| (case == "SELF_COMPENSATION").then_some(0.16));
    let text = shown(&metrics);
    assert!(text.contains("vibrissa_whiskers{fleet=\"f\",health=\"HEALTHY\"} 7"), "{text}");
    assert!(
        text.contains("vibrissa_compensation_error_mean_ratio{case=\"SELF_COMPENSATION\",fleet=\"f\"} 0.16"),
        "{text}"
    );
    assert!(!text.contains("vibrissa_compensation_error_mean_ratio{case=\"SHORTER"), "{text}");
    of_fleet.log_ingest.set(1);
    of_fleet.rollout_stage.set(2);
    of_fleet.archive_position_timestamp_seconds.set(3.0);
    of_fleet.forget();
    let text = shown(&metrics);
    for gauge in ["vibrissa_kafka_ingest", "vibrissa_rollout_stage", "vibrissa_archive_position_timestamp_seconds"] {
        assert!(text.contains(&format!("{gauge}{{fleet=\"f\"}} 0")), "{text}");
    }
    assert!(text.contains("vibrissa_whiskers{fleet=\"f\",health=\"HEALTHY\"} 0"), "{text}");
    assert!(!text.contains("vibrissa_compensation_error_mean_ratio{"), "{text}");
}

#[test]
fn paths_and_methods_that_somebody_made_up_are_one_series() {
    let metrics = Metrics::new(false).unwrap();
    let made_up = |number: u32| {
        let method = Method::from_bytes(format!("M{number}").as_bytes()).unwrap();
        metrics.http.answered(&method, None, StatusCode::NOT_FOUND, Duration::from_millis(1));
    };
    made_up(0);
    let before = shown(&metrics).lines().count();
    (1..1000).for_each(made_up);
    let text = shown(&metrics);
    assert_eq!(text.lines().count(), before);
    assert!(
        text.contains("vibrissa_http_requests_total{method=\"other\",route=\"other\",status=\"404\"} 1000"),
        "{text}"
    );
}

#[test]
fn single_whiskers_are_shown_only_if_they_are_wanted_and_vanish_with_their_robot() {
    assert!(Metrics::new(false).unwrap().whiskers.is_none());
    let metrics = Metrics::new(true).unwrap();
    let whiskers = metrics.whiskers.clone().unwrap();
    let sample = RobotSample {
        robot: "r".to_owned(),
        heard_s: Some(12.5),
        refused: vec![("contacts", "malformed", 3)],
        whiskers: vec![WhiskerSample {
            array: "left".to_owned(),
            whisker: 3,
            length_m: 0.065,
            pressure_pa: None,
            setpoint_pa: 100_000.0,
            health: "TRIMMED",
        }],
    };
    whiskers.show(&fleet(), vec![sample]);
    let text = shown(&metrics);
    let place = "{array=\"left\",fleet=\"f\",robot=\"r\",whisker=\"3\"}";
    assert!(text.contains(&format!("vibrissa_whisker_length_meters{place} 0.065\n")), "{text}");
    assert!(text.contains(&format!("vibrissa_whisker_setpoint_pascals{place} 100000\n")), "{text}");
    assert!(text.contains("vibrissa_robot_heard_timestamp_seconds{fleet=\"f\",robot=\"r\"} 12.5\n"), "{text}");
    let refused = "{fleet=\"f\",reason=\"malformed\",robot=\"r\",topic=\"contacts\"} 3\n";
    assert!(text.contains(&format!("vibrissa_robot_refused_total{refused}")), "{text}");
    assert!(
        !text.contains("vibrissa_whisker_pressure_pascals{"),
        "a pressure that was not measured is not exported: {text}"
    );
    whiskers.show(&fleet(), Vec::new());
    assert!(!shown(&metrics).contains("robot="));
    assert_eq!(whiskers.desc().len(), 6);
}

#[test]
fn the_document_of_the_metrics_is_what_they_are() {
    let written = include_str!("../../../../docs/metrics.md");
    assert_eq!(written, document().unwrap(), "regenerate it: vibrissa metrics > docs/metrics.md");
}

#[test]
fn the_queries_of_the_document_name_metrics_that_exist() {
    let text = document().unwrap();
    let rows: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix("| `")?.split('`').next()).collect();
    let mut sorted = rows.clone();
    sorted.sort_unstable();
    sorted.dedup();
    assert_eq!(sorted.len(), rows.len(), "each metric has one subject");
    let queries = text.split("```promql\n").skip(1).map(|rest| rest.split("\n```").next().unwrap());
    let mut named = 0;
    for query in queries {
        let words = query.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_'));
        for metric in words.filter(|word| word.starts_with("vibrissa_") || word.starts_with("process_")) {
            let base = metric.strip_suffix("_bucket").unwrap_or(metric);
            assert!(rows.contains(&base), "{metric} in {query}");
            named += 1;
        }
    }
    assert!(named > 20, "{named} metrics in queries");
}
