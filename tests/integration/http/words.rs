//! The served document and the served console have each word and each number of the policy that the code declares.

use serde_json::{Value, json};
use vibrissa_core::policy::{Case, PolicyParams, Refused};
use vibrissa_core::robot::effect::{
    AlarmKind, CommandState, Condition, EndReason, Fault, RefinementOutcome, TestKind, TestReason, TestState,
};
use vibrissa_edge::actions::AuditKind;
use vibrissa_edge::presence::Presence;
use vibrissa_edge::words::Words;

use crate::document::Document;
use crate::served::Served;

fn words<T: Words>() -> Vec<String> {
    T::all().into_iter().map(|one| one.word().to_owned()).collect()
}

#[tokio::test]
async fn filters_and_console_have_each_word() {
    let served = Served::sqlite().await;
    let document = Document::of(&served).await;
    let filters = [
        ("/v1/whiskers", "condition", words::<Condition>()),
        ("/v1/robots", "connection", words::<Presence>()),
        ("/v1/compensations", "case", words::<Case>()),
        ("/v1/setpoints", "state", words::<CommandState>()),
        ("/v1/touch-tests", "state", words::<TestState>()),
        ("/v1/alarms", "kind", words::<AlarmKind>()),
    ];
    for (path, filter, words) in filters {
        let operation = &document.0["paths"][path]["get"];
        assert_eq!(document.words(operation, filter), Some(words.clone()), "{path}: {filter}");
        for word in words {
            assert_eq!(served.get(&format!("{path}?{filter}={word}")).await.status, 200, "{path}: {filter}={word}");
        }
        let refused = served.get(&format!("{path}?{filter}=NOTHING")).await;
        assert_eq!(refused.status, 422, "{path}: {}", refused.body);
        assert!(refused.body.contains("NOTHING is not allowed; allowed are"), "{}", refused.body);
    }
    let module = served.get("/console/declared.js").await;
    assert_eq!((module.status, &module.headers["content-type"]), (200, &"text/javascript; charset=utf-8".to_owned()));
    let lists = [
        ("CONDITIONS", words::<Condition>()),
        ("FAULTS", words::<Fault>()),
        ("CONNECTIONS", words::<Presence>()),
        ("CASES", words::<Case>()),
        ("REFUSALS", words::<Refused>()),
        ("END_REASONS", words::<EndReason>()),
        ("SETPOINT_STATES", words::<CommandState>()),
        ("TEST_STATES", words::<TestState>()),
        ("TEST_KINDS", words::<TestKind>()),
        ("TEST_REASONS", words::<TestReason>()),
        ("LOOKS", words::<RefinementOutcome>()),
        ("ALARM_KINDS", words::<AlarmKind>()),
        ("AUDIT_KINDS", words::<AuditKind>()),
    ];
    for (list, words) in lists {
        let start = format!("export const {list} = ");
        let line = module.body.lines().find_map(|line| line.strip_prefix(&start)).expect(list);
        let declared: Value = serde_json::from_str(line.trim_end_matches(';')).unwrap();
        for word in words {
            assert!(!declared[&word].is_null(), "console/declared.js: {list} needs {word}");
        }
    }
}

#[tokio::test]
async fn the_document_declares_each_number_of_the_policy_with_label_unit_and_range() {
    let document = Document::of(&Served::sqlite().await).await.0;
    let [body, row] = ["NewPolicy", "Policy"].map(|name| &document["components"]["schemas"][name]);
    for number in PolicyParams::NUMBERS {
        let property = &body["properties"][number.name];
        let range = (property["minimum"].as_f64(), property["maximum"].as_f64());
        assert_eq!(range, (Some(number.min), Some(number.max)), "{property}");
        assert!(
            property["x-label"].is_string() && property["x-unit"].is_string() && property["description"].is_string(),
            "{property}"
        );
        assert!(body["required"].as_array().unwrap().contains(&json!(number.name)), "{body}");
        assert_eq!(row["properties"][number.name]["type"], "number", "{row}");
    }
    for choice in ["mode", "objective", "longer_for_shorter"] {
        assert!(body["properties"][choice].is_object(), "{body}");
    }
}
