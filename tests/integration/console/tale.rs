//! The story of a whisker in one sentence, for each kind of history, and the words of the timeline.

use serde_json::{Value, json};
use vibrissa_protocol::SetpointOutcome;

use crate::advising::{button, press};
use crate::stage::Stage;

/// A whisker in a condition, with changes.
fn whisker(condition: &str, changes: &Value) -> Value {
    let mut row = json!({
        "array": "left", "whisker": 0, "condition": condition, "fault": null, "held": false, "contacts": 1234,
        "length_mm": 69.9, "length_low_mm": 69.5, "length_high_mm": 70.3, "whole_length_mm": 70.0,
        "pressure_mpa": 0.1, "setpoint_mpa": 0.1, "nominal_pressure_mpa": 0.1, "contacts_left": null,
        "leak_per_s": null, "leak_low_per_s": null, "leak_high_per_s": null,
    });
    with(&mut row, changes);
    row
}

fn with(row: &mut Value, changes: &Value) {
    for (name, value) in changes.as_object().unwrap() {
        row[name] = value.clone();
    }
}

fn cut() -> Value {
    whisker("TRIMMED", &json!({ "length_mm": 60.4, "length_low_mm": 60.0, "length_high_mm": 60.8 }))
}

fn trim() -> Value {
    json!({ "detected_at": "2026-11-21T00:40:32.000Z", "length_before_mm": 70.0, "length_after_mm": 60.4, "contacts_to_detect": 22 })
}

/// A decision that the whisker serves for itself, with changes.
fn decision(changes: &Value) -> Value {
    let mut row = json!({
        "array": "left", "target_whisker": 0, "compensator_whisker": 0, "approval": "AUTOMATIC", "ended_at": null,
        "end_reason": null, "setpoint_state": "APPLIED", "pressure_before_mpa": 0.1, "pressure_mpa": 0.0064,
        "held_pressure_mpa": null, "predicted_error": 0.013, "predicted_error_low": 0.0, "predicted_error_high": 0.05,
        "measured_error": 0.021, "measured_contacts": 400, "candidates": [],
    });
    with(&mut row, changes);
    row
}

fn refused(whisker: u16, reason: &str) -> Value {
    json!({ "whisker": whisker, "refused": reason })
}

const CUT: &str = "Cut 9.6\u{a0}mm at 21 Nov 2026, 00:40:32 UTC, found after 22 contacts; ";

/// The name of each history, its facts, and the sentence with its tone.
fn histories() -> Vec<(&'static str, Value, &'static str, String)> {
    let after = |rest: &str| format!("{CUT}{rest}");
    let compensated = |name, changes: Value, tone, rest: &str| {
        (name, json!({ "whisker": cut(), "trim": trim(), "decision": decision(&changes) }), tone, after(rest))
    };
    let nobody = json!({
        "compensator_whisker": null, "approval": "AUTOMATIC", "setpoint_state": null, "measured_error": null,
        "candidates": [refused(0, "NEEDS_BELOW_RANGE"), refused(1, "HELD"), refused(2, "HELD")],
    });
    let waiting = json!({ "approval": "PROPOSED", "setpoint_state": null, "measured_error": null });
    let gain = json!({ "pressure_mpa": 0.1, "measured_error": 0.02 });
    let replaced = json!({ "ended_at": "2026-11-22T08:00:00.000Z", "end_reason": "REPLACED" });
    vec![
        (
            "healthy",
            json!({ "whisker": whisker("HEALTHY", &json!({})) }),
            "good",
            "Healthy: its length is 69.9\u{a0}mm of 70.0\u{a0}mm after 1,234 contacts, and no cut was found.".to_owned(),
        ),
        (
            "learned",
            json!({ "whisker": whisker("LEARNING", &json!({ "contacts": 40 })) }),
            "info",
            "Being learned: 40 contacts so far, a cut is not detected yet.".to_owned(),
        ),
        (
            "suspected",
            json!({ "whisker": whisker("SUSPECTED", &json!({})) }),
            "warn",
            "Perhaps cut: its length is 69.9\u{a0}mm of 70.0\u{a0}mm; more contacts or a touch test decide.".to_owned(),
        ),
        (
            "suspected of a doubtful length",
            json!({ "whisker": whisker("SUSPECTED", &json!({ "length_low_mm": 61.0 })) }),
            "warn",
            "Perhaps cut: its length is in doubt: between 61.0\u{a0}mm and 70.3\u{a0}mm; readings do not tell a cut from another \
             gain or a turn of the contacts, so measure it by a touch test, or let contacts state angle_deg."
                .to_owned(),
        ),
        (
            "doubtful",
            json!({ "whisker": whisker("HEALTHY", &json!({ "length_low_mm": 61.0 })) }),
            "warn",
            "Healthy: its length is in doubt: between 61.0\u{a0}mm and 70.3\u{a0}mm after 1,234 contacts, and no cut was found."
                .to_owned(),
        ),
        (
            "wearing",
            json!({ "whisker": whisker("ERODING", &json!({ "contacts_left": 2300.4 })) }),
            "warn",
            "Wearing off: its length is 69.9\u{a0}mm of 70.0\u{a0}mm, too short in about 2,300 contacts.".to_owned(),
        ),
        (
            "undecided",
            json!({ "whisker": cut(), "trim": trim() }),
            "bad",
            after("not decided yet."),
        ),
        compensated(
            "nobody",
            nobody,
            "bad",
            "not compensated: left 1, left 2: an operator holds it; left 0: it would need less than 0 MPa.",
        ),
        compensated(
            "waiting",
            waiting,
            "warn",
            "waiting for approval: own pressure 0.1000 to 0.0064\u{a0}MPa, predicted reading error 1.3\u{a0}% (0.0\u{a0}to\u{a0}5.0).",
        ),
        compensated(
            "by itself",
            json!({}),
            "good",
            "own pressure 0.1000 to 0.0064\u{a0}MPa, reading error 100 to 2.1\u{a0}%, measured over 400 contacts.",
        ),
        compensated(
            "by a neighbour",
            json!({ "compensator_whisker": 1, "held_pressure_mpa": 0.05, "measured_error": 0.7 }),
            "warn",
            "left 1 serves for it, its pressure 0.1000 to 0.0500\u{a0}MPa, reading error 100 to 70.0\u{a0}%, measured over 400 contacts.",
        ),
        compensated(
            "by gain alone",
            gain,
            "good",
            "the gain on the readings alone, own pressure stays 0.1000\u{a0}MPa, reading error 100 to 2.0\u{a0}%, measured over 400 contacts.",
        ),
        compensated(
            "not set",
            json!({ "setpoint_state": "EXPIRED", "measured_error": null }),
            "bad",
            "pressure not set, expired: own pressure 0.1000 to 0.0064\u{a0}MPa.",
        ),
        compensated(
            "in a task",
            json!({ "setpoint_state": "REJECTED", "setpoint_error": "IN_TASK", "measured_error": null }),
            "warn",
            "waits: the robot is in a task: own pressure 0.1000 to 0.0064\u{a0}MPa.",
        ),
        compensated(
            "refused",
            json!({ "approval": "REFUSED", "ended_at": "2026-11-21T01:00:00.000Z", "end_reason": "REFUSED" }),
            "bad",
            "not compensated: an operator refused own pressure 0.1000 to 0.0064\u{a0}MPa.",
        ),
        (
            "vented",
            json!({
                "whisker": whisker("HEALTHY", &json!({ "pressure_mpa": 0.0 })),
                "alarms": [{ "kind": "VENTED" }],
            }),
            "bad",
            "Vented by its robot and not filled again: the chamber has 0.0000\u{a0}MPa instead of 0.1000\u{a0}MPa. Healthy: its \
             length is 69.9\u{a0}mm of 70.0\u{a0}mm after 1,234 contacts, and no cut was found."
                .to_owned(),
        ),
        (
            "leaking",
            json!({ "whisker": whisker("HEALTHY", &json!({
                "fault": "LEAK", "leak_per_s": 0.0001, "leak_low_per_s": 0.00005, "leak_high_per_s": 0.00015,
            })) }),
            "bad",
            "Leaking: it loses 36.0\u{a0}% (18.0\u{a0}to\u{a0}54.0) of its pressure in an hour. Healthy: its length is 69.9\u{a0}mm \
             of 70.0\u{a0}mm after 1,234 contacts, and no cut was found."
                .to_owned(),
        ),
        (
            "replaced",
            json!({ "whisker": whisker("LEARNING", &json!({ "contacts": 12 })), "trim": trim(), "decision": decision(&replaced) }),
            "info",
            "Replaced at 22 Nov 2026, 08:00:00 UTC: the new whisker is being learned, 12 contacts so far.".to_owned(),
        ),
        (
            "held",
            json!({ "whisker": whisker("HEALTHY", &json!({ "held": true })) }),
            "good",
            "Healthy: its length is 69.9\u{a0}mm of 70.0\u{a0}mm after 1,234 contacts, and no cut was found. An operator holds it: \
             nothing changes by itself."
                .to_owned(),
        ),
    ]
}

#[tokio::test]
async fn each_kind_of_history_is_one_sentence_of_recorded_facts() {
    let mut stage = Stage::start().await;
    stage.open("#/fleets").await;
    stage.browser.js("import('/console/zone.js').then((zone) => zone.setZone('UTC'))").await;
    for (name, facts, tone, text) in histories() {
        let told = format!("import('/console/parts/story.js').then(({{ storyOf }}) => storyOf({facts}))");
        assert_eq!(stage.browser.js(&told).await, json!({ "tone": tone, "text": text }), "{name}");
    }
    stage.is_clean();
    stage.stop().await;
}

/// An entry of the timeline about whisker left 0.
fn entry(id: u32, second: u32, kind: &str, data: &Value) -> Value {
    json!({
        "entry_id": id, "at": format!("2026-11-21T00:00:{second:02}.000Z"), "kind": kind, "word": null, "fleet": "f", "robot": "r",
        "array": "left", "whisker": 0, "actor": null, "reason": null, "state": null, "action_id": null, "data": data,
    })
}

#[tokio::test]
async fn the_steps_of_a_setpoint_and_repeated_measurements_are_one_line() {
    let mut stage = Stage::start().await;
    stage.open("#/fleets").await;
    let setpoint = |state: &str, reason: Value| {
        json!({ "setpoint": {
        "command_id": "c", "state": state, "pressure_mpa": 0.0064, "reached_mpa": null, "rejection": null,
        "compensation_id": null, "reason": reason,
    } })
    };
    let error = |value: f64| json!({ "error": { "compensation_id": 7, "error": value, "pressure_mpa": 0.0064 } });
    let entries = json!([
        entry(9, 9, "ERROR", &error(0.02)),
        entry(8, 8, "ERROR", &error(0.03)),
        entry(7, 5, "SETPOINT_STATE", &setpoint("APPLIED", Value::Null)),
        entry(6, 4, "CONDITION_CHANGED", &json!({ "condition": { "was": "SUSPECTED", "becomes": "TRIMMED" } })),
        entry(5, 3, "SETPOINT_STATE", &setpoint("RECEIVED", Value::Null)),
        entry(4, 2, "SETPOINT", &setpoint("PENDING", json!("SELF_COMPENSATION"))),
        entry(3, 1, "ERROR", &error(0.04)),
        entry(2, 0, "OF_TOMORROW", &json!({})),
    ]);
    let told = format!(
        "import('/console/parts/entries.js').then(({{ folded, toldOf }}) => folded({entries}).map((one) => toldOf(one).words))"
    );
    let words = stage.browser.js(&told).await;
    let expected = [
        "reading error 2.0\u{a0}% at 0.0064\u{a0}MPa, measured 2 times",
        "setpoint 0.0064\u{a0}MPa applied after 3.0\u{a0}s, compensates for itself",
        "suspected to trimmed",
        "reading error 4.0\u{a0}% at 0.0064\u{a0}MPa",
        "of tomorrow",
    ];
    assert_eq!(words, json!(expected));
    stage.is_clean();
    stage.stop().await;
}

#[tokio::test]
async fn whiskers_that_change_together_and_a_fault_that_flaps_are_one_line() {
    let mut stage = Stage::start().await;
    stage.open("#/fleets").await;
    let of = |mut entry: Value, robot: &str, whisker: u16| {
        entry["robot"] = json!(robot);
        entry["whisker"] = json!(whisker);
        entry
    };
    let learned =
        |id| entry(id, 9, "CONDITION_CHANGED", &json!({ "condition": { "was": "LEARNING", "becomes": "HEALTHY" } }));
    let fault = |was: Value, becomes: Value| json!({ "fault": { "was": was, "becomes": becomes } });
    let entries = json!([
        of(learned(9), "r", 0),
        of(learned(8), "r", 1),
        of(learned(7), "other", 0),
        entry(6, 5, "FAULT_CHANGED", &fault(Value::Null, json!("LEAK"))),
        entry(5, 4, "FAULT_CHANGED", &fault(json!("LEAK"), Value::Null)),
        entry(4, 3, "FAULT_CHANGED", &fault(Value::Null, json!("LEAK"))),
        of(entry(3, 2, "FAULT_CHANGED", &fault(json!("LEAK"), Value::Null)), "other", 0),
    ]);
    let told = format!(
        "import('/console/parts/entries.js').then(({{ entriesList }}) => \
         [...entriesList({entries}, {{ empty: '' }}).querySelectorAll('.what')] \
         .map((one) => [one.firstChild.textContent, one.lastChild.textContent]))"
    );
    let expected = json!([
        ["2 robots, 3 whiskers", "learning to healthy"],
        ["rwhisker left 0", "found: leaking, after 2 changes"],
        ["otherwhisker left 0", "over: leaking"],
    ]);
    assert_eq!(stage.browser.js(&told).await, expected);
    stage.is_clean();
    stage.stop().await;
}

#[tokio::test]
async fn a_cut_is_told_at_the_top_of_its_page_and_in_the_timeline() {
    let mut stage = Stage::start().await;
    stage.cut().await;
    let (setpoint, _) = stage.robot.setpoint().await;
    stage.robot.answer(&setpoint, SetpointOutcome::Applied, None).await;
    stage.open("#/fleets/f/robots/r/arrays/left/whiskers/0").await;
    let story = "document.getElementById('story')";
    let told = stage
        .browser
        .until("the story", &format!("{story}?.innerText.includes('found after') && {story}.innerText"))
        .await;
    let told = told.as_str().unwrap();
    assert!(told.contains("Cut ") && told.contains("own pressure 0.1000 to "), "{told}");
    assert_eq!(
        stage.browser.js(&format!("{story}.getBoundingClientRect().bottom < innerHeight / 2")).await,
        json!(true)
    );
    let kinds = "[...document.querySelectorAll('.entries li[data-kind]')].map((one) => one.dataset.kind)";
    stage.browser.until("its events", &format!("{kinds}.includes('TRIM') && {kinds}.includes('DECISION')")).await;
    for (tab, part) in [("charts", "whisker-charts"), ("decisions", ".alternatives"), ("history", "#part-setpoints")] {
        stage.browser.click(&format!("document.querySelector('.tabs a[href*=\"tab={tab}\"]')")).await;
        stage
            .browser
            .until(tab, &format!("document.querySelector('{part}') && location.hash.includes('tab={tab}')"))
            .await;
    }
    // The timeline names the whisker in full, and its filters are those of the address.
    stage.open("#/timeline?robot=r&kind=TRIM").await;
    let line = "document.querySelector('.entries li[data-kind]')?.innerText";
    let line = stage.browser.until("the cut", &format!("{line}?.includes('whisker left 0') && {line}")).await;
    assert!(line.as_str().unwrap().contains("cut found"), "{line}");
    assert_eq!(stage.browser.js("document.querySelectorAll('.entries li[data-kind]').length").await, json!(1));
    stage.open("#/timeline?robot=r&to=2020-01-01T00:00:00.000Z").await;
    stage.browser.until("nothing before", "document.querySelector('main .empty')").await;
    stage.is_clean();
    stage.stop().await;
}

#[tokio::test]
async fn a_compensation_is_taken_back_and_the_story_says_so() {
    let mut stage = Stage::start().await;
    stage.cut().await;
    let (setpoint, _) = stage.robot.setpoint().await;
    stage.robot.answer(&setpoint, SetpointOutcome::Applied, None).await;
    stage.open("#/fleets/f/robots/r/arrays/left/whiskers/0?tab=decisions").await;
    stage.browser.until("the button", &button("Undo")).await;
    // An action on a robot that is silent by now would be refused.
    for whisker in 0..3 {
        stage.robot.touch(whisker, 5).await;
    }
    stage.robot.receipted().await;
    press(&mut stage, "Undo", "not now").await;
    let (back, _) = stage.robot.setpoint().await;
    assert_eq!((back.pressure_mpa, back.whisker), (0.1, setpoint.whisker));
    stage.robot.answer(&back, SetpointOutcome::Applied, None).await;
    let story = "document.getElementById('story')?.innerText";
    let ended = format!("{story}?.includes('not compensated any more: an operator set the pressure')");
    stage.browser.until("the end", &ended).await;
    stage.is_clean();
    stage.stop().await;
}
