//! The console's module with the words of the API and their labels, from the declaration in `vibrissa_edge::words`.

use std::fmt::Write as _;
use std::sync::LazyLock;

use serde_json::{Value, json};
use vibrissa_core::mechanics::Objective;
use vibrissa_core::policy::{Case, LongerForShorter, Mode, Refused};
use vibrissa_core::robot::effect::{
    AlarmKind, CommandState, Condition, EndReason, Fault, Reason, RefinementOutcome, TestKind, TestReason, TestState,
};
use vibrissa_core::robot::event::ArrayKind;
use vibrissa_core::rollout::Stage;
use vibrissa_edge::actions::AuditKind;
use vibrissa_edge::events::{Audience, EventKind, webhook_kinds};
use vibrissa_edge::guidance::Level;
use vibrissa_edge::presence::Presence;
use vibrissa_edge::words::Words;
use vibrissa_protocol::Segmenter;

/// Path of the module below `/console/`.
pub(super) const PATH: &str = "declared.js";

/// Text of the module: for each enum a constant that maps its words to their labels, or to `[label, severity]`.
pub(super) static MODULE: LazyLock<String> = LazyLock::new(|| {
    let lists = [
        ("CONDITIONS", words::<Condition>()),
        ("FAULTS", words::<Fault>()),
        ("SEGMENTERS", words::<Segmenter>()),
        ("CONNECTIONS", words::<Presence>()),
        ("CASES", words::<Case>()),
        ("REFUSALS", words::<Refused>()),
        ("END_REASONS", words::<EndReason>()),
        ("SETPOINT_STATES", words::<CommandState>()),
        ("SETPOINT_REASONS", words::<Reason>()),
        ("TEST_STATES", words::<TestState>()),
        ("TEST_KINDS", words::<TestKind>()),
        ("TEST_REASONS", words::<TestReason>()),
        ("LOOKS", words::<RefinementOutcome>()),
        ("ALARM_KINDS", labels::<AlarmKind>()),
        ("ALARM_LEVELS", words::<Level>()),
        ("AUDIT_KINDS", words::<AuditKind>()),
        ("EVENT_KINDS", told_of(webhook_kinds().into_iter().chain([EventKind::Test]))),
        ("TIMELINE_KINDS", told_of(EventKind::all().into_iter().filter(|kind| is_in_timeline(*kind)))),
        ("ARRAY_TYPES", words::<ArrayKind>()),
        ("ROLLOUT_STAGES", words::<Stage>()),
        ("MODES", words::<Mode>()),
        ("OBJECTIVES", words::<Objective>()),
        ("LONGER_FOR_SHORTER", words::<LongerForShorter>()),
    ];
    lists.into_iter().fold(String::new(), |mut module, (name, words)| {
        let _ = writeln!(module, "export const {name} = {words};");
        module
    })
});

/// Whether the timeline has events of this kind. It shows the decisions of people about alarms as their actions.
fn is_in_timeline(kind: EventKind) -> bool {
    kind.audience() != Audience::Kafka && !matches!(kind, EventKind::AlarmHandled | EventKind::Test)
}

fn words<T: Words + Copy>() -> Value {
    told_of(T::all())
}

fn told_of<T: Words + Copy>(values: impl IntoIterator<Item = T>) -> Value {
    let entry = |one: T| one.severity().map_or(json!(one.label()), |severity| json!([one.label(), severity.as_str()]));
    values.into_iter().map(|one| (one.word().to_owned(), entry(one))).collect()
}

/// Only the labels, of an enum of which some values have a severity.
fn labels<T: Words + Copy>() -> Value {
    T::all().into_iter().map(|one| (one.word().to_owned(), json!(one.label()))).collect()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    #[test]
    fn each_word_has_a_label_and_each_list_severities_for_all_words_or_none() {
        for line in MODULE.lines() {
            let (name, words) = line.trim_end_matches(';').split_once(" = ").unwrap();
            let words: BTreeMap<String, Value> = serde_json::from_str(words).unwrap();
            let is_marked = words.values().next().unwrap().is_array();
            for (word, entry) in &words {
                assert_eq!(entry.is_array(), is_marked, "{name} in edge/src/words: severity of {word}");
                let label = if is_marked { &entry[0] } else { entry };
                assert!(label.is_string(), "{name} in edge/src/words: {word} needs a label");
            }
        }
    }
}
