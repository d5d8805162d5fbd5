//! The metrics as a Markdown document: `docs/metrics.md`, which `vibrissa metrics` prints.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::time::Duration;

use axum::http::{Method, StatusCode};
use prometheus::proto::{MetricFamily, MetricType};
use prometheus::{Error, Result};
use vibrissa_protocol::Name;

use super::clocks::CLOCKS;
use super::subjects::{SUBJECTS, subject};
use super::{Metrics, PUBLISHING, RECEIVING, RobotSample, WhiskerSample};

/// Most values of a label that are listed; of a label with more, only their number is shown.
const VALUES_SHOWN_MAX: usize = 32;
/// Labels whose values come from the configuration, from robots or from requests: their values are not listed.
const FREE: [&str; 12] = [
    "fleet",
    "robot",
    "array",
    "whisker",
    "version",
    "database",
    "broker",
    "node",
    "supervisor",
    "method",
    "route",
    "status",
];

const HEAD: &str = "\
# Metrics

The metrics that `/metrics` exports to Prometheus, in base units. `vibrissa metrics` prints this page. A histogram has
the series `_bucket`, `_sum` and `_count`. `fleet` is a fleet of the configuration. Counts of a fleet's robots,
whiskers, alarms and errors in force are exported by the supervisor that holds its lease, and are 0 or missing
elsewhere: take the sum or the maximum over supervisors. The values of labels are bounded: robots and clients cannot
add any, except in metrics marked with \u{b9}, which are exported with `metrics.series = \"whiskers\"` only.

The queries are examples for Prometheus and Grafana. The alert rules in `deploy/prometheus/rules` have more.
";

const TABLE: &str = "\n| metric | type | labels | meaning |\n| --- | --- | --- | --- |\n";

/// Lists all metrics by subject in Markdown tables, with example queries.
///
/// # Errors
/// A metric cannot be registered, or has no subject.
pub fn document() -> Result<String> {
    let families = everything()?.registry.gather();
    let mut text = HEAD.to_owned();
    for one in SUBJECTS {
        let is_of = |family: &&MetricFamily| subject(family.name()).is_some_and(|of| of.title == one.title);
        let failed = |problem: std::fmt::Error| Error::Msg(problem.to_string());
        write!(text, "\n## {}\n{TABLE}", one.title).map_err(failed)?;
        for family in families.iter().filter(is_of) {
            row(&mut text, family).map_err(failed)?;
        }
        for (title, query) in one.queries {
            write!(text, "\n{title}:\n\n```promql\n{query}\n```\n").map_err(failed)?;
        }
    }
    match families.iter().find(|family| subject(family.name()).is_none()) {
        Some(family) => Err(Error::Msg(format!("{} needs a subject in metrics/subjects.rs", family.name()))),
        None => Ok(text),
    }
}

/// Metrics with at least one series in each family: a family without series is not exported.
fn everything() -> Result<Metrics> {
    let metrics = Metrics::new(true)?;
    metrics.is("name", "SQLITE", "EMBEDDED");
    let fleet = metrics.of_fleet(&Name::new("fleet").map_err(|problem| Error::Msg(problem.to_string()))?);
    for quantities in fleet.quantities() {
        quantities.set_all(|_| Some(0.0));
    }
    for connection in [RECEIVING, PUBLISHING] {
        fleet.mqtt_node.set(connection, "broker:1883");
    }
    fleet.mqtt_node_failures.know("broker:1883");
    metrics.http.answered(&Method::GET, None, StatusCode::OK, Duration::ZERO);
    metrics.clocks.show(CLOCKS.map(|clock| (clock, Some(0))));
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
    let robot = RobotSample {
        robot: "robot".to_owned(),
        heard_s: Some(0.0),
        refused: vec![("topic", "reason", 0)],
        whiskers: vec![whisker],
    };
    if let Some(whiskers) = &metrics.whiskers {
        let fleet = Name::new("fleet").map_err(|problem| Error::Msg(problem.to_string()))?;
        whiskers.show(&fleet, vec![robot]);
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
    let names = first.into_iter().flat_map(|metric| metric.get_label()).map(|pair| pair.name().to_owned());
    names.collect()
}

/// A label with its values, if the program defines them.
fn label(family: &MetricFamily, name: &str) -> String {
    let pairs = family.get_metric().iter().flat_map(|metric| metric.get_label());
    let values: BTreeSet<&str> = pairs.filter(|pair| pair.name() == name).map(|pair| pair.value()).collect();
    match values.len() {
        _ if FREE.contains(&name) => format!("`{name}`"),
        // The only value is the example of `everything`.
        1 => format!("`{name}`"),
        count if count > VALUES_SHOWN_MAX => format!("`{name}` ({count})"),
        _ => format!("`{name}` ({})", values.into_iter().collect::<Vec<_>>().join(", ")),
    }
}
