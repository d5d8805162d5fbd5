//! Recordings written by hand or damaged on purpose.

use std::path::PathBuf;

use serde_json::{Value, json};
use tempfile::TempDir;

use crate::program::{effects, errors, replay, run};

const START_US: u64 = 1_795_248_000_000_000;

fn line(at_us: u64, topic: &str, payload: &Value) -> String {
    json!({ "received_us": START_US + at_us, "topic": format!("whisker/v1/f/r/{topic}"), "payload": payload })
        .to_string()
}

fn birth(at_us: u64) -> Vec<String> {
    let whisker = json!({ "whisker": 0, "x_mm": 0.0, "y_mm": 0.0, "model": "nguyen-2021", "length_mm": 70.0,
        "pressure_mpa": 0.1, "pressure_max_mpa": 0.2, "neighbours": [] });
    let array = json!({ "array": "left", "type": "TYPE_2", "whiskers": [whisker] });
    let timestamp = "2026-11-21T08:00:00.000Z";
    vec![
        line(at_us, "connection", &json!({ "boot_id": "b", "seq": 0, "timestamp": timestamp, "state": "ONLINE" })),
        line(
            at_us + 1,
            "factsheet",
            &json!({ "boot_id": "b", "seq": 0, "timestamp": timestamp, "model": "m", "on_supervisor_loss": "HOLD",
                "arrays": [array] }),
        ),
    ]
}

fn status(at_us: u64, seq: u64) -> String {
    let whisker = json!({ "array": "left", "whisker": 0, "pressure_mpa": 0.1, "setpoint_mpa": 0.1, "regulator": "OK",
        "gauge": "OK" });
    line(at_us, "status", &json!({ "boot_id": "b", "seq": seq, "t_us": START_US + at_us, "whiskers": [whisker] }))
}

fn file(lines: &[String]) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("recording.jsonl");
    std::fs::write(&path, lines.join("\n")).unwrap();
    (folder, path)
}

#[test]
fn bad_lines_are_told_with_their_number_and_passed_over() {
    let mut lines = birth(0);
    lines.insert(1, "nonsense".to_owned());
    lines.push(String::new());
    lines.push(json!({ "received_us": START_US, "topic": "whisker/v1/f/r/status", "payload": 7 }).to_string());
    lines.push(status(1_000_000, 0));
    let (_folder, path) = file(&lines);
    let output = run(&["replay", path.to_str().unwrap()]);
    assert!(output.status.success());
    let log = errors(&output);
    let name = path.display();
    assert!(log.contains(&format!("{name}:2: not a recorded message: only the words true, false and null")), "{log}");
    assert!(log.contains(&format!("{name}:5: payload must be an object, or a text")), "{log}");
    assert!(log.contains("3 messages replayed, 2 bad lines"), "{log}");
    // Without its bad lines the recording gives the same output.
    let good: Vec<String> = [birth(0), vec![status(1_000_000, 0)]].concat();
    let (_other, good) = file(&good);
    assert_eq!(String::from_utf8(output.stdout).unwrap(), replay(&good, &[]));
}

#[test]
fn a_file_in_which_nothing_is_recorded_and_one_that_is_not_there_are_errors() {
    let (folder, path) = file(&["{}".to_owned(), "[".to_owned()]);
    let output = run(&["replay", path.to_str().unwrap()]);
    assert!(!output.status.success() && errors(&output).contains("contains no recorded message"), "{output:?}");
    let output = run(&["replay", folder.path().join("none").to_str().unwrap()]);
    assert!(!output.status.success() && errors(&output).contains("cannot be read"), "{output:?}");
}

#[test]
fn what_the_service_refuses_is_told_by_its_label() {
    let mut lines = birth(0);
    let text = |topic: &str, payload: &str| json!({ "received_us": START_US + 5, "topic": topic, "payload": payload });
    lines.push(text("whisker/v1/f/r/contacts", "no JSON").to_string());
    lines.push(text("whisker/v2/f/r/contacts", "{}").to_string());
    lines.push(text("whisker/v1/f/stranger/contacts", r#"{"boot_id":"b","seq":0,"contacts":[]}"#).to_string());
    lines.push(
        json!({ "received_us": START_US + 6, "topic": "whisker/v1/f/r/status", "payload_base64": "/w==" }).to_string(),
    );
    // A refused message with a readable number is counted as received, as in the service.
    let seq =
        |seq: u64, contacts: Value| line(7, "contacts", &json!({ "boot_id": "b", "seq": seq, "contacts": contacts }));
    lines.extend([seq(0, json!([{ "array": 7 }])), seq(0, json!([]))]);
    // Messages of a supervisor are not inputs, so even invalid ones are ignored.
    lines.push(text("whisker/v1/f/r/receipt", "no JSON").to_string());
    lines.push(text("whisker/v1/f/supervisor/state", "no JSON").to_string());
    let (_folder, path) = file(&lines);
    let refused = effects(&replay(&path, &[]), "REFUSED");
    let reasons: Vec<&str> = refused.iter().map(|line| line["reason"].as_str().unwrap()).collect();
    assert_eq!(reasons, ["not_json", "unknown_topic", "unknown_robot", "not_json", "malformed", "duplicate"]);
    assert_eq!((&refused[0]["robot"], &refused[1]["robot"]), (&json!("r"), &Value::Null));
}

/// Contacts of a boot, with the numbers 0 and 1.
fn contacts(at_us: u64, boot_id: &str) -> Vec<String> {
    let contact = |at_us: u64| {
        json!({ "array": "left", "whisker": 0, "t_us": START_US + at_us, "ratio": 0.85, "deflection_mm": 2.4,
            "strain": 0.0117, "pressure_mpa": 0.1, "temperature_c": 24.0 })
    };
    let message = |seq: u64| {
        let at_us = at_us + seq;
        line(at_us, "contacts", &json!({ "boot_id": boot_id, "seq": seq, "contacts": [contact(at_us)] }))
    };
    vec![message(0), message(1)]
}

/// Brokers send retained messages in any order.
#[test]
fn regress_a_factsheet_may_come_before_the_birth_of_its_boot() {
    let [connection, factsheet] = birth(0).try_into().unwrap();
    let renewed = |line: &str| line.replace(r#""boot_id":"b""#, r#""boot_id":"c""#);
    let second = [renewed(&factsheet), renewed(&connection)].to_vec();
    let in_order = [vec![connection.clone(), factsheet.clone()], contacts(10, "b")].concat();
    let reversed = [vec![factsheet, connection], contacts(10, "b"), second, contacts(20, "c")].concat();
    for (lines, expected) in [(in_order, 2), (reversed, 4)] {
        let (_folder, path) = file(&lines);
        let output = run(&["replay", path.to_str().unwrap()]);
        let text = String::from_utf8(output.stdout.clone()).unwrap();
        assert_eq!(effects(&text, "CONTACT").len(), expected, "{text}");
        assert!(!errors(&output).contains("refused"), "{}", errors(&output));
    }
}

#[test]
fn what_was_refused_is_told_at_the_end_by_robot_with_one_policy_and_with_two() {
    let request = json!({ "boot_id": "s", "seq": 0, "epoch": 1, "timestamp": "2026-11-21T08:00:00.000Z",
        "request": "BIRTH" });
    let to_all = json!({ "received_us": START_US, "topic": "whisker/v1/f/supervisor/request", "payload": request });
    let of_stranger = |line: String| line.replace("/f/r/", "/f/stranger/");
    let lines = [
        vec![to_all.to_string()],
        birth(0),
        contacts(10, "never announced"),
        contacts(20, "b"),
        contacts(30, "b").into_iter().take(1).collect(),
        contacts(40, "b").into_iter().map(of_stranger).collect(),
        vec![line(50, "contacts", &json!({ "boot_id": "b", "seq": 2, "contacts": [] }))],
    ]
    .concat();
    let (folder, path) = file(&lines);
    let other = folder.path().join("other.toml");
    std::fs::write(&other, "[policy]\nobjective = \"mean\"\n").unwrap();
    for more in [&[][..], &["--policy", other.to_str().unwrap()]] {
        let output = run(&[&["replay", path.to_str().unwrap()], more].concat());
        assert!(output.status.success(), "{output:?}");
        let log = errors(&output);
        let refused: Vec<&str> = log.lines().filter(|line| line.contains("refused")).collect();
        let expected = [
            "vibrissa: refused of f/r: 3 (duplicate 1, unknown_boot 2)",
            "vibrissa: refused of f/stranger: 2 (unknown_robot 2)",
        ];
        assert_eq!(refused, expected, "the request to all robots is no input");
    }
}

#[test]
fn time_passes_between_messages_and_a_long_silence_takes_no_time() {
    let hours = 1_000 * 3_600_000_000;
    let lines = [birth(0), vec![status(1_000_000, 0), status(40_000_000, 1), status(40_000_000 + hours, 2)]].concat();
    let (_folder, path) = file(&lines);
    let faults = effects(&replay(&path, &[]), "FAULT");
    let changes: Vec<(u64, &Value)> =
        faults.iter().map(|line| (line["received_us"].as_u64().unwrap() - START_US, &line["becomes"])).collect();
    // The fault begins at the first tick (every 0.25 s) after 15 s of silence, and ends with the next status.
    let expected = [(16_250_000, json!("STALE")), (40_000_000, Value::Null), (55_250_000, json!("STALE"))];
    assert_eq!(changes.len(), 4, "{changes:?}");
    for ((at_us, becomes), (expected_us, expected)) in changes.iter().zip(&expected) {
        assert!(at_us.abs_diff(*expected_us) <= 250_000 && *becomes == expected, "{changes:?}");
    }
}

#[test]
fn a_policy_with_other_keys_is_refused_by_name() {
    let (folder, path) = file(&birth(0));
    let other = folder.path().join("other.toml");
    std::fs::write(&other, "fleets = [\"f\"]\n[policy]\nmargin = 1\n").unwrap();
    let output = run(&["replay", path.to_str().unwrap(), "--policy", other.to_str().unwrap()]);
    let message = errors(&output);
    assert!(
        !output.status.success() && message.contains("policy.margin") && message.contains("not a policy key"),
        "{message}"
    );
}
