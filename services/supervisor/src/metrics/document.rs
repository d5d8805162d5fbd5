//! The metrics as a document for people: `docs/metrics.md`, which `vibrissa metrics` prints.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::time::Duration;

use axum::http::{Method, StatusCode};
use prometheus::proto::{MetricFamily, MetricType};
use prometheus::{Error, Result};
use vibrissa_protocol::Name;

use super::{Metrics, RobotSample, WhiskerSample};

/// A label with more values than this is said to have so many, without their names.
const VALUES_SHOWN_MAX: usize = 32;
/// Labels whose values are not the program's.
const FREE: [&str; 11] =
    ["fleet", "robot", "array", "whisker", "version", "database", "broker", "supervisor", "method", "route", "status"];

const HEAD: &str = "\
# Metrics

What `/metrics` has for Prometheus, in base units. `vibrissa metrics` prints this page. A histogram has `_bucket`, `_sum` and `_count`.
`fleet` is one of the configuration's fleets. What a fleet contains (robots, whiskers, alarms, errors in force) is told by the supervisor
that holds its lease, and is 0 or missing elsewhere: take the sum or the maximum over supervisors. No label has a value that
robots or callers could make up, except in those marked with \u{b9}, which are shown with `metrics.series = \"whiskers\"` only.

| metric | type | labels | meaning |
| --- | --- | --- | --- |
";

/// All metrics as a table in Markdown.
///
/// # Errors
/// A metric cannot be declared.
pub fn document() -> Result<String> {
    let mut text = HEAD.to_owned();
    for family in everything()?.registry.gather() {
        row(&mut text, &family).map_err(|problem| Error::Msg(problem.to_string()))?;
    }
    Ok(text)
}

/// Metrics of which every one is shown: a family without a series would not be.
fn everything() -> Result<Metrics> {
    let metrics = Metrics::new(true)?;
    metrics.is("name", "SQLITE", "EMBEDDED");
    let fleet = metrics.of_fleet(&Name::new("fleet").map_err(|problem| Error::Msg(problem.to_string()))?);
    for quantities in fleet.quantities() {
        quantities.set_all(|_| Some(0.0));
    }
    metrics.http.answered(&Method::GET, None, StatusCode::OK, Duration::ZERO);
    for listener in ["main", "monitoring"] {
        let _ = metrics.http.connections(listener);
    }
    let whisker = WhiskerSample {
        array: "array".to_owned(),
        whisker: 0,
        length_m: 0.0,
        pressure_pa: Some(0.0),
        setpoint_pa: 0.0,
        health: "HEALTHY",
    };
    let robot = RobotSample { robot: "robot".to_owned(), heard_s: Some(0.0), whiskers: vec![whisker] };
    if let Some(whiskers) = &metrics.whiskers {
        whiskers.show("fleet", vec![robot]);
    }
    Ok(metrics)
}

fn row(text: &mut String, family: &MetricFamily) -> std::fmt::Result {
    let kind = match family.get_field_type() {
        MetricType::COUNTER => "counter",
        MetricType::GAUGE => "gauge",
        MetricType::HISTOGRAM => "histogram",
        MetricType::SUMMARY => "summary",
        MetricType::UNTYPED => "untyped",
    };
    let names = labels(family);
    let mark = if names.iter().any(|name| name == "robot") { " \u{b9}" } else { "" };
    let labels: Vec<String> = names.iter().map(|name| label(family, name)).collect();
    writeln!(text, "| `{}`{mark} | {kind} | {} | {} |", family.name(), labels.join(", "), family.help())
}

fn labels(family: &MetricFamily) -> Vec<String> {
    let first = family.get_metric().first();
    first.into_iter().flat_map(|metric| metric.get_label()).map(|pair| pair.name().to_owned()).collect()
}

/// A label, with its values where they are the program's.
fn label(family: &MetricFamily, name: &str) -> String {
    let pairs = family.get_metric().iter().flat_map(|metric| metric.get_label());
    let values: BTreeSet<&str> = pairs.filter(|pair| pair.name() == name).map(|pair| pair.value()).collect();
    match values.len() {
        _ if FREE.contains(&name) => format!("`{name}`"),
        // One was shown as an example.
        1 => format!("`{name}`"),
        count if count > VALUES_SHOWN_MAX => format!("`{name}` ({count})"),
        _ => format!("`{name}` ({})", values.into_iter().collect::<Vec<_>>().join(", ")),
    }
}
