//! Checks of the alerts: unit tests, runbooks, and queries that only use what exists.

mod grafana;
mod served;

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::process::Command;

use serde_json::Value;
use vibrissa::config::Key;

/// Each program of the runbooks, with its beginning in a command.
const PROGRAMS: [(&str, &str); 2] =
    [("vibrissa ", env!("CARGO_BIN_EXE_vibrissa-under-test")), ("vibrissa-lab ", env!("CARGO_BIN_EXE_lab-under-test"))];

fn project() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_owned()
}

fn read(path: &str) -> String {
    std::fs::read_to_string(project().join(path)).unwrap_or_else(|problem| panic!("{path}: {problem}"))
}

fn yaml(path: &str) -> Value {
    serde_saphyr::from_str(&read(path)).unwrap_or_else(|problem| panic!("{path}: {problem}"))
}

/// The files of a folder as sorted paths relative to the project.
fn files(folder: &str) -> Vec<String> {
    let entries = std::fs::read_dir(project().join(folder)).unwrap();
    let mut names: Vec<String> =
        entries.map(|entry| format!("{folder}/{}", entry.unwrap().file_name().to_str().unwrap())).collect();
    names.sort();
    names
}

fn list(value: &Value) -> impl Iterator<Item = &Value> {
    value.as_array().into_iter().flatten()
}

fn text(value: &Value) -> &str {
    value.as_str().unwrap_or_else(|| panic!("not a text: {value}"))
}

/// Every rule of Prometheus, recording rules included.
fn rules() -> Vec<Value> {
    let groups = yaml("deploy/prometheus/rules/vibrissa.yml");
    list(&groups["groups"]).flat_map(|group| list(&group["rules"])).cloned().collect()
}

/// Alerts of Prometheus by name.
fn alerts() -> BTreeMap<String, Value> {
    let rules = rules().into_iter();
    rules.filter_map(|rule| Some((rule["alert"].as_str()?.to_owned(), rule))).collect()
}

/// Alerts of Grafana by title.
pub(crate) fn named_alerts() -> BTreeMap<String, Value> {
    let groups = yaml("dashboards/provisioning/alerting/whiskers.yml");
    let rules = list(&groups["groups"]).flat_map(|group| list(&group["rules"]));
    rules.map(|rule| (text(&rule["title"]).to_owned(), rule.clone())).collect()
}

/// All runbooks, without the page that lists them.
fn runbooks() -> Vec<String> {
    files("docs/runbooks").into_iter().filter(|path| !path.ends_with("/README.md")).collect()
}

fn promtool(arguments: &[&str]) {
    let folder = project().join("deploy/prometheus");
    let ended = Command::new("promtool").args(arguments).current_dir(folder).output();
    let ended = ended.expect("promtool must be installed for this test: Debian's package prometheus has it");
    let said = [ended.stdout, ended.stderr].map(|said| String::from_utf8_lossy(&said).into_owned()).concat();
    assert!(ended.status.success(), "promtool {arguments:?}: {said}");
}

#[test]
fn prometheus_reads_its_configuration_and_the_rules_with_it() {
    promtool(&["check", "config", "prometheus.yml"]);
    promtool(&["check", "rules", "rules/vibrissa.yml"]);
    let jobs = yaml("deploy/prometheus/prometheus.yml");
    assert!(list(&jobs["scrape_configs"]).all(|job| job["job_name"] == "vibrissa"), "the alerts select that job");
    let compose = read("docker-compose.yml");
    for mounted in ["./deploy/prometheus/rules:/etc/prometheus/rules:ro", "./docs/runbooks:/etc/prometheus/consoles/"] {
        assert!(compose.contains(mounted), "{mounted}");
    }
}

#[test]
fn every_alert_does_what_its_unit_test_says() {
    let tests = files("deploy/prometheus/tests");
    let tests = tests.iter().map(|path| path.strip_prefix("deploy/prometheus/").unwrap());
    promtool(&["test", "rules"].into_iter().chain(tests).collect::<Vec<_>>());
}

#[test]
fn every_alert_has_a_unit_test_in_which_it_begins_and_ends() {
    let mut tested: BTreeMap<String, Vec<Vec<bool>>> = BTreeMap::new();
    for file in files("deploy/prometheus/tests") {
        for test in list(&yaml(&file)["tests"]) {
            let mut fires: BTreeMap<&str, Vec<bool>> = BTreeMap::new();
            for look in list(&test["alert_rule_test"]) {
                fires.entry(text(&look["alertname"])).or_default().push(list(&look["exp_alerts"]).count() > 0);
            }
            for (alert, looks) in fires {
                tested.entry(alert.to_owned()).or_default().push(looks);
            }
        }
    }
    for alert in alerts().keys() {
        let looks = tested.get(alert).unwrap_or_else(|| panic!("{alert} has no unit test"));
        let begins_and_ends = |looks: &Vec<bool>| {
            let begins = looks.iter().position(|fires| *fires);
            begins.is_some_and(|begins| begins > 0) && looks.last() == Some(&false)
        };
        assert!(looks.iter().any(begins_and_ends), "no unit test in which {alert} begins and ends: {looks:?}");
    }
}

#[test]
fn every_alert_says_what_is_wrong_and_leads_to_its_runbook() {
    let mut led_to = BTreeSet::new();
    for (alert, rule) in alerts().into_iter().chain(named_alerts()) {
        let said = |name: &str| text(&rule["annotations"][name]).to_owned();
        assert!(said("summary").len() > 10 && said("description").len() > 40, "{alert}");
        assert!(["page", "warning", "info"].contains(&text(&rule["labels"]["severity"])), "{alert}");
        let runbook = said("runbook");
        let page = runbook.strip_prefix("docs/runbooks/").unwrap_or_else(|| panic!("{alert}: {runbook}"));
        assert!(said("runbook_url").ends_with(&format!("/consoles/runbooks/{page}")), "{alert}");
        assert!(read("docs/runbooks/README.md").contains(&format!("]({page})")), "{page} is missing in the table");
        led_to.insert(runbook);
    }
    assert_eq!(led_to.into_iter().collect::<Vec<_>>(), runbooks(), "each runbook must belong to an alert");
}

#[test]
fn every_runbook_has_the_same_parts_and_can_be_served_by_prometheus() {
    let parts = [
        "Meaning",
        "Risk",
        "First checks",
        "Likely causes, most likely first",
        "Actions",
        "Escalation",
        "End of the alert",
    ];
    for path in runbooks() {
        let page = read(&path);
        let heads: Vec<&str> = page.lines().filter_map(|line| line.strip_prefix("## ")).collect();
        assert_eq!(heads, parts, "{path}");
        let name = path.rsplit('/').next().unwrap().strip_suffix(".md").unwrap();
        assert!(page.starts_with(&format!("# {name}\n")), "{path}");
        for link in page.split("](").skip(1).map(|rest| rest.split_once(')').unwrap().0) {
            assert!(project().join("docs/runbooks").join(link).exists(), "{path}: {link}");
        }
    }
    for path in files("docs/runbooks") {
        assert!(!read(&path).contains("{{"), "{path}: Prometheus would expand that as a template");
    }
}

/// All text between backquotes.
fn code(page: &str) -> impl Iterator<Item = &str> {
    page.split('`').skip(1).step_by(2)
}

#[test]
fn every_command_of_the_runbooks_is_one_of_the_programs() {
    let help = |program: &str, arguments: &[&str]| {
        let ended = Command::new(program).args(arguments).arg("--help").output().unwrap();
        assert!(ended.status.success(), "{program} {arguments:?}");
        String::from_utf8(ended.stdout).unwrap()
    };
    let mut commands = 0;
    for path in runbooks() {
        let page = read(&path);
        let of = |code| PROGRAMS.iter().find_map(|(begin, program)| Some((*program, str::strip_prefix(code, *begin)?)));
        for (program, command) in code(&page).filter_map(of) {
            let mut words = command.split_whitespace().peekable();
            let known = help(program, words.next_if(|word| !word.starts_with('-')).as_slice());
            for flag in words.filter_map(|word| word.strip_prefix("--")) {
                let is_alias = Key::ALL.iter().any(|key| key.flag_alias() == Some(flag));
                assert!(is_alias || known.contains(&format!("--{flag}")), "{path}: {command}: unknown flag --{flag}");
            }
            commands += 1;
        }
    }
    assert!(commands > 20, "{commands}");
}
