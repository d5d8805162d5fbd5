//! Each word of the core's closed enums must appear in every list that people see, so that a new word is added
//! everywhere.

use std::fs::read_to_string;

use vibrissa_core::policy::{Case, Refused};
use vibrissa_core::robot::effect::{AlarmKind, CommandState, Condition, EndReason, Fault, RefinementOutcome};
use vibrissa_core::robot::event::Link;
use vibrissa_edge::actions::ActionKind;
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
fn the_console_has_a_text_for_each_word() {
    let lists = [
        ("CONDITIONS", words::<Condition>()),
        ("FAULTS", words::<Fault>()),
        ("CONNECTIONS", words::<Link>()),
        ("CASES", words::<Case>()),
        ("REFUSALS", words::<Refused>()),
        ("END_REASONS", words::<EndReason>()),
        ("SETPOINT_STATES", words::<CommandState>()),
        // The words of cases are included from another list.
        ("SETPOINT_REASONS", vec!["REFINEMENT", "RELEASE", "OPERATOR"]),
        ("LOOKS", words::<RefinementOutcome>()),
        ("ACTION_KINDS", words::<ActionKind>()),
    ];
    for (list, words) in lists {
        let part = part("services/supervisor/console/words.js", &format!("export const {list} = {{"), "\n};");
        for word in words {
            assert!(part.contains(&format!("\n  {word}: ")), "console/words.js: {list} needs {word}");
        }
    }
}

#[test]
fn the_api_names_each_word() {
    let lists = [
        ("ConditionWord", words::<Condition>()),
        ("ConnectionWord", words::<Link>()),
        ("CaseWord", words::<Case>()),
        ("SetpointStateWord", words::<CommandState>()),
        ("AlarmKindWord", words::<AlarmKind>()),
    ];
    for (list, words) in lists {
        let part = part("services/supervisor/src/http/words.rs", &format!("pub enum {list} {{"), "\n    }");
        for word in &words {
            assert!(part.contains(&format!(" = \"{word}\",")), "http/words.rs: {list} needs {word}");
        }
        assert_eq!(
            part.matches(" = \"").count(),
            words.len(),
            "http/words.rs: {list} has a word that the core does not have"
        );
    }
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
