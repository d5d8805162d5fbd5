//! The rules of Grafana's dashboard-linter, under the linter's names. Exceptions with their reasons are in
//! `dashboards/.lint`, in the linter's own format.

use std::collections::BTreeSet;

use serde_json::Value;

use super::promql::selectors;
use super::{ALL, Dashboard, folder, list, targets, text};

/// Units in use, as Grafana names them in its `valueFormats/categories.ts`.
const UNITS: [&str; 16] = [
    "bool_yes_no",
    "bytes",
    "cpm",
    "cps",
    "dateTimeAsIso",
    "dateTimeFromNow",
    "dtdurations",
    "lengthmm",
    "locale",
    "none",
    "percentunit",
    "pressurepa",
    "reqps",
    "s",
    "short",
    "string",
];

/// A violation of a rule.
#[derive(Debug)]
struct Broken {
    rule: &'static str,
    dashboard: String,
    problem: String,
}

/// Violations of one dashboard.
struct Report<'a> {
    dashboard: &'a Dashboard,
    broken: Vec<Broken>,
}

impl Report<'_> {
    fn expect(&mut self, rule: &'static str, holds: bool, problem: impl Into<String>) {
        if !holds {
            let dashboard = self.dashboard.title().to_owned();
            self.broken.push(Broken { rule, dashboard, problem: problem.into() });
        }
    }
}

#[test]
fn dashboards_keep_the_linters_rules() {
    let broken: Vec<Broken> = ALL.iter().flat_map(lint).collect();
    let excepted: Value = serde_json::from_str(&std::fs::read_to_string(folder().join(".lint")).unwrap()).unwrap();
    let mut used = BTreeSet::new();
    let mut problems = Vec::new();
    for one in &broken {
        let exclusion = &excepted["exclusions"][one.rule];
        if list(&exclusion["entries"]).any(|entry| entry["dashboard"] == one.dashboard) {
            assert!(!text(&exclusion["reason"]).is_empty(), "{}: exception without a reason", one.rule);
            used.insert((one.rule, one.dashboard.clone()));
        } else {
            problems.push(format!("{}: {}: {}", one.rule, one.dashboard, one.problem));
        }
    }
    assert!(problems.is_empty(), "\n{}", problems.join("\n"));
    let entries = excepted["exclusions"].as_object().unwrap().values().map(|one| list(&one["entries"]).count());
    assert_eq!(entries.sum::<usize>(), used.len(), "unused exception; only these are needed: {used:?}");
}

fn lint(dashboard: &Dashboard) -> Vec<Broken> {
    let mut report = Report { dashboard, broken: Vec::new() };
    report.expect("uneditable-dashboard-rule", dashboard.json["editable"] == false, "can be edited");
    sources(&mut report);
    supervisors(&mut report, "template-job-rule", "job", "Job");
    supervisors(&mut report, "template-instance-rule", "instance", "Instance");
    variables(&mut report);
    for panel in dashboard.panels() {
        panel_rules(&mut report, panel);
    }
    for (panel, target) in dashboard.promql() {
        target_rules(&mut report, text(&panel["title"]), text(&target["expr"]));
    }
    report.broken
}

fn sources(report: &mut Report<'_>) {
    let sources: Vec<&Value> = report.dashboard.variables().filter(|one| one["type"] == "datasource").collect();
    report.expect("template-datasource-rule", !sources.is_empty(), "has no data source to choose");
    for source in sources {
        let query = text(&source["query"]);
        let capital = query[..1].to_uppercase() + &query[1..];
        let is_named =
            source["name"] == format!("{query}_datasource") && source["label"] == format!("{capital} data source");
        report.expect("template-datasource-rule", is_named, format!("a source of {query} is named {}", source["name"]));
    }
}

fn supervisors(report: &mut Report<'_>, rule: &'static str, name: &str, label: &str) {
    let Some(variable) = report.dashboard.variable(name) else {
        return report.expect(rule, false, "variable is missing");
    };
    report.expect(rule, variable["datasource"]["uid"] == "${prometheus_datasource}", "has another data source");
    report.expect(rule, variable["type"] == "query", "is not a query variable");
    report.expect(rule, variable["label"] == label, "has another label");
    report.expect(
        rule,
        variable["multi"] == true && variable["includeAll"] == true,
        "must allow several values and All",
    );
    report.expect(rule, variable["allValue"] == ".+", "must use .+ for All");
}

fn variables(report: &mut Report<'_>) {
    for variable in report.dashboard.variables().filter(|one| one["type"] == "query") {
        let query = variable["query"]["query"].as_str().unwrap_or(text(&variable["query"]));
        let is_promql =
            ["label_names(", "label_values(", "metrics(", "query_result("].iter().any(|f| query.starts_with(f));
        report.expect("template-label-promql-rule", is_promql, query);
        report.expect("template-on-time-change-reload-rule", variable["refresh"] == 2, text(&variable["name"]));
    }
}

fn panel_rules(report: &mut Report<'_>, panel: &Value) {
    let title = text(&panel["title"]);
    let known: Vec<String> = report
        .dashboard
        .variables()
        .filter(|one| one["type"] == "datasource")
        .map(|one| format!("${{{}}}", text(&one["name"])))
        .collect();
    let mut sources = targets(panel).map(|(_, target)| &target["datasource"]).chain([&panel["datasource"]]);
    let is_known = sources.all(|source| known.iter().any(|known| source["uid"] == **known));
    report.expect("panel-datasource-rule", is_known, title);
    let is_described = !title.is_empty() && !text(&panel["description"]).is_empty();
    report.expect("panel-title-description-rule", is_described, title);
    let overrides = list(&panel["fieldConfig"]["overrides"]).flat_map(|one| list(&one["properties"]));
    let units = overrides.filter(|property| property["id"] == "unit").map(|property| &property["value"]);
    for unit in units.chain([&panel["fieldConfig"]["defaults"]["unit"]]) {
        report.expect("panel-units-rule", UNITS.contains(&text(unit)), format!("{title}: {unit}"));
    }
    report.expect("panel-no-targets-rule", targets(panel).count() > 0, title);
}

/// The test with a real Prometheus checks that queries are valid PromQL.
fn target_rules(report: &mut Report<'_>, title: &str, expression: &str) {
    report.expect("target-promql-rule", !expression.trim().is_empty(), title);
    for selector in selectors(expression) {
        let place = || format!("{title}: {}", selector.metric);
        let has = |matcher: &str| selector.matchers.is_some_and(|all| all.split(',').any(|one| one == matcher));
        report.expect("target-job-rule", has(r#"job=~"$job""#), place());
        report.expect("target-instance-rule", has(r#"instance=~"$instance""#), place());
        let is_rate = ["rate", "irate"].contains(&selector.within);
        report.expect("target-rate-interval-rule", !is_rate || selector.range == Some("$__rate_interval"), place());
        // Stricter than the linter: parts of histograms are counters, too.
        let counts = ["_total", "_bucket", "_count", "_sum"].iter().any(|ending| selector.metric.ends_with(ending));
        let is_aggregated = is_rate || selector.within == "increase";
        report.expect("target-counter-agg-rule", !counts || is_aggregated && selector.range.is_some(), place());
    }
}
