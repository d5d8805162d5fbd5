//! The places that are written by hand and need each word of the core's closed enums, or each number of the policy. A
//! test names the place that lacks one. What the service serves derives from the declarations: see `http/words.rs`.

use std::fs::{read_dir, read_to_string};

use vibrissa::config::Key;
use vibrissa_core::policy::{Case, PolicyParams};
use vibrissa_core::robot::effect::{AlarmKind, Condition, Fault};
use vibrissa_edge::words::{Word, Words};

use crate::project;

fn words<T: Words>() -> Vec<&'static str> {
    T::all().into_iter().map(Word::word).collect()
}

/// Part of a file between two texts.
fn part(path: &str, from: &str, to: &str) -> String {
    let text = read_to_string(project().join(path)).unwrap();
    let (_, rest) = text.split_once(from).unwrap_or_else(|| panic!("{path}: {from}"));
    rest.split_once(to).unwrap_or_else(|| panic!("{path}: {to} after {from}")).0.to_owned()
}

#[test]
fn the_alert_of_faults_names_each_fault_but_silence() {
    let kinds = part("deploy/prometheus/rules/vibrissa.yml", "- alert: VibrissaWhiskerFault", "\"}");
    let kinds: Vec<&str> = kinds.split_once("kind=~\"").unwrap().1.split('|').collect();
    for fault in Fault::all().into_iter().filter(|&fault| fault != Fault::Stale) {
        assert!(kinds.contains(&fault.word()), "VibrissaWhiskerFault needs {}: {kinds:?}", fault.word());
    }
}

#[test]
fn the_dashboards_have_a_colour_for_each_condition_and_a_name_for_each_case() {
    let colours = part("dashboards/source/words.py", "HEALTH = {", "\n}");
    let cases = part("dashboards/source/words.py", "CASES = {", "\n}");
    for (words, part) in [(words::<Condition>(), colours), (words::<Case>(), cases)] {
        for word in words {
            assert!(part.contains(&format!("\"{word}\": ")), "dashboards/source/words.py needs {word}");
        }
    }
}

#[test]
fn the_glossary_names_each_condition_fault_alarm_and_case() {
    // An entry ends with an empty line.
    let entry = |term: &str| part("docs/glossary.md", &format!("**{term}.**"), "\n\n");
    let is_fault = |kind: &AlarmKind| matches!(kind, AlarmKind::Fault(_));
    let entries = [
        ("Condition", words::<Condition>()),
        ("Fault", words::<Fault>()),
        ("Compensation case", words::<Case>()),
        ("Alarm", AlarmKind::all().into_iter().filter(|kind| !is_fault(kind)).map(Word::word).collect()),
    ];
    for (term, words) in entries {
        let entry = entry(term);
        let named: Vec<&str> = entry.split(|c: char| c != '_' && !c.is_ascii_alphanumeric()).collect();
        for word in words {
            assert!(named.contains(&word), "docs/glossary.md: the entry {term} needs {word}");
        }
    }
}

#[test]
fn the_runbook_of_faults_names_each_fault_but_silence() {
    let meaning = part("docs/runbooks/VibrissaWhiskerFault.md", "## Meaning", "## Risk");
    for fault in Fault::all().into_iter().filter(|&fault| fault != Fault::Stale) {
        let named = meaning.split(|c: char| c != '_' && !c.is_ascii_alphanumeric()).any(|word| word == fault.word());
        assert!(named, "docs/runbooks/VibrissaWhiskerFault.md: the meaning needs {}", fault.word());
    }
}

#[test]
fn each_number_of_the_policy_is_a_setting_and_a_column_of_both_databases() {
    let example = read_to_string(project().join("deploy/vibrissa.example.toml")).unwrap();
    for (number, key) in PolicyParams::NUMBERS.iter().zip(Key::POLICY_NUMBERS) {
        assert_eq!(key.path(), format!("policy.{}", number.name));
        let setting = format!("#{} = ", number.name);
        assert!(example.contains(&setting), "deploy/vibrissa.example.toml needs {}", number.name);
        let default = key.default().and_then(|text| text.parse::<f64>().ok());
        assert_eq!(default, Some((number.of)(&PolicyParams::default())), "{key}");
        for folder in ["migrations/sqlite", "migrations/postgres"] {
            let files =
                read_dir(project().join(folder)).unwrap().map(|file| read_to_string(file.unwrap().path()).unwrap());
            let has_column = files.into_iter().any(|sql| sql.contains("policies") && sql.contains(number.name));
            assert!(has_column, "{folder}: the table policies needs a column {}", number.name);
        }
    }
}
