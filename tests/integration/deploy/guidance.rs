//! The guidance about alarms agrees with the files that are written by hand: alert rules, runbooks and docs/operators.md.

use std::fs::read_to_string;

use vibrissa_edge::guidance::{BY_URGENCY, Level, of};
use vibrissa_edge::words::{Word, Words};

use crate::project;

#[test]
fn each_kind_of_alarm_has_guidance_and_a_runbook_that_exists_and_names_it() {
    for kind in BY_URGENCY {
        let guidance = of(kind);
        assert!(guidance.hint.len() > 30 && guidance.causes.len() >= 2, "{}", kind.word());
        let path = project().join("docs/runbooks").join(guidance.runbook);
        let page = read_to_string(&path).unwrap_or_else(|problem| panic!("{}: {problem}", path.display()));
        let is_named = page.split(|c: char| c != '_' && !c.is_ascii_alphanumeric()).any(|word| word == kind.word());
        assert!(is_named, "docs/runbooks/{} needs {}", guidance.runbook, kind.word());
    }
}

/// An alert about kinds of alarms has the severity of their level, and leads to their runbook.
#[test]
fn alerts_about_alarms_have_the_severity_of_their_level() {
    let rules = read_to_string(project().join("deploy/prometheus/rules/vibrissa.yml")).unwrap();
    let mut of_alarms = 0;
    for rule in rules.split("- alert: ").skip(1) {
        let (name, _) = rule.split_once('\n').unwrap();
        let kinds = match rule.split_once("vibrissa_alarms_standing{kind=") {
            Some((_, rest)) => rest.split('"').nth(1).unwrap(),
            // It counts robots: the alarm stands for robots that are not connected, too.
            None if rule.contains("vibrissa_robots{connection=\"SILENT\"}") => "ROBOT_SILENT",
            None => continue,
        };
        for word in kinds.split('|') {
            let kind =
                BY_URGENCY.into_iter().find(|kind| kind.word() == word).unwrap_or_else(|| panic!("{name}: {word}"));
            let guidance = of(kind);
            let severity = format!("severity: {}\n", guidance.level.prometheus());
            assert!(rule.contains(&severity), "{name}: {word} is {}, so {severity}", guidance.level.word());
            let runbook = format!("runbook: docs/runbooks/{}\n", guidance.runbook);
            assert!(rule.contains(&runbook), "{name}: {word} needs {runbook}");
            of_alarms += 1;
        }
    }
    assert!(of_alarms >= BY_URGENCY.len() - 1, "{of_alarms}: all kinds but STALE have an alert");
}

#[test]
fn the_table_of_levels_has_each_kind_in_order_at_its_level() {
    let page = read_to_string(project().join("docs/operators.md")).unwrap();
    for level in Level::all() {
        let start = format!("| {} | ", level.word());
        let row = page.lines().find(|line| line.starts_with(&start)).unwrap_or_else(|| panic!("{start}"));
        let cells: Vec<&str> = row.trim_matches('|').split('|').map(str::trim).collect();
        let kinds: Vec<&str> = BY_URGENCY.into_iter().filter(|&kind| of(kind).level == level).map(Word::word).collect();
        assert_eq!(cells[2..], [level.prometheus(), &kinds.join(", ")], "docs/operators.md");
    }
}
