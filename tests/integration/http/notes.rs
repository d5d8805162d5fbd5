//! Notes on robots: added, listed, removed, recorded and limited, on both databases.

use std::collections::BTreeMap;

use futures_util::future::join_all;
use serde_json::{Value, json};
use vibrissa_store::notes::{NOTES_MAX, NoteChange, Noted};
use vibrissa_supervisor::http::access::token::{NewToken, create};
use vibrissa_supervisor::http::access::{AccessOptions, Role, Scope};
use vibrissa_tests::actions::asks;
use vibrissa_tests::wait::until;
use vibrissa_tests::web::{Answer, send};

use crate::served::Served;

const OF_R1: &str = "/v1/fleets/f/robots/r1/notes";

/// The answer, asked again while the rate limit refuses it.
async fn asked(served: &Served, method: &str, path: &str, headers: &[(&str, &str)], body: Option<Value>) -> Answer {
    until("an answer", async || {
        let answer = send(served.http, method, path, headers, body.as_ref()).await.unwrap();
        Some(answer).filter(|answer| answer.status != 429)
    })
    .await
}

async fn add(served: &Served, path: &str, text: &str) -> Answer {
    asked(served, "POST", path, &[], Some(json!({ "text": text }))).await
}

async fn notes_are_added_listed_and_removed(served: &Served) {
    assert_eq!(served.items(OF_R1).await, Vec::<Value>::new());
    let first = add(served, OF_R1, "  Hose <b>replaced</b>,\r\nsee \"ticket\" 12 \u{fc}\n").await;
    assert_eq!(first.status, 201, "{}", first.body);
    let note = first.json();
    assert_eq!((&note["fleet"], &note["robot"]), (&json!("f"), &json!("r1")));
    assert_eq!(note["text"], "Hose <b>replaced</b>,\nsee \"ticket\" 12 \u{fc}");
    assert_eq!(served.json(&first.headers["location"]).await, note);
    let second = add(served, OF_R1, "Second").await.json();
    assert_eq!(add(served, "/v1/fleets/g/robots/r1/notes", "Of another robot").await.status, 201);
    assert_eq!(served.items(OF_R1).await, [second.clone(), note.clone()]);
    assert_eq!(served.all(&format!("{OF_R1}?limit=1&order=ascending")).await, [note.clone(), second.clone()]);
    let csv = served.get(&format!("{OF_R1}?format=csv")).await.body;
    assert!(csv.contains("\"Hose <b>replaced</b>,\nsee \"\"ticket\"\" 12 \u{fc}\""), "{csv}");
    // The same request again gives the same note, and another one with its key is refused.
    let key = [("Idempotency-Key", "once")];
    let once = asked(served, "POST", OF_R1, &key, Some(json!({ "text": "Once" }))).await;
    assert_eq!(once.status, 201, "{}", once.body);
    let again = asked(served, "POST", OF_R1, &key, Some(json!({ "text": "Once" }))).await;
    assert_eq!((again.status, again.json()), (201, once.json()));
    let other = asked(served, "POST", OF_R1, &key, Some(json!({ "text": "Twice" }))).await;
    assert_eq!((other.status, &other.json()["type"]), (409, &json!("/problems/key-reused")));
    assert_eq!(served.items(OF_R1).await.len(), 3);
    // Only at its own robot a note is found and removed.
    let at = |robot: &str| format!("/v1/fleets/{robot}/notes/{}", note["note_id"]);
    for wrong in ["f/robots/r2", "g/robots/r1", "f/robots/none"] {
        assert_eq!(served.get(&at(wrong)).await.status, 404, "{wrong}");
        assert_eq!(asked(served, "DELETE", &at(wrong), &[], None).await.status, 404, "{wrong}");
    }
    let removed = asked(served, "DELETE", &at("f/robots/r1"), &[], Some(json!({ "reason": "done" }))).await;
    assert_eq!((removed.status, &removed.json()["reason"]), (200, &json!("done")), "{}", removed.body);
    assert_eq!(served.get(&at("f/robots/r1")).await.status, 404);
    assert_eq!(asked(served, "DELETE", &at("f/robots/r1"), &[], None).await.status, 404);
    assert_eq!(served.items(OF_R1).await, [once.json(), second]);
    // The audit log has each change once, with the text; refused requests leave no trace.
    let added = served.items("/v1/audit?kind=NOTE_ADD&robot=r1&fleet=f&order=ascending").await;
    let texts: Vec<&Value> = added.iter().map(|one| &one["parameters"]["text"]).collect();
    assert_eq!(texts, [&note["text"], &json!("Second"), &json!("Once")]);
    assert!(added.iter().all(|one| one["state"] == "DONE" && one["actor"] == note["author"]), "{added:?}");
    let removals = served.items("/v1/audit?kind=NOTE_REMOVE").await;
    assert_eq!(removals.len(), 1);
    assert_eq!(removals[0]["parameters"], json!({ "note_id": note["note_id"] }));
}

/// Many at once pass the limit no more than one by one.
async fn the_number_of_notes_is_limited(served: &Served) {
    let many = (0..NOTES_MAX + 20).map(|_| async {
        let action = asks("NOTE_ADD", "{}");
        let found = served.store.change_notes(("f", "r1"), NoteChange::Add("x"), &action).await.unwrap();
        match found {
            Noted::Done(_) => "done",
            Noted::TooMany => "too many",
            Noted::NoRobot | Noted::NoNote => "unknown",
        }
    });
    let mut counts = BTreeMap::new();
    for status in join_all(many).await {
        *counts.entry(status).or_insert(0_i64) += 1;
    }
    assert_eq!(counts, BTreeMap::from([("done", NOTES_MAX), ("too many", 20)]));
    let full = add(served, OF_R1, "One more").await;
    assert_eq!((full.status, &full.json()["type"]), (409, &json!("/problems/refused")));
    assert!(full.body.contains("100 notes"), "{}", full.body);
    assert_eq!(add(served, "/v1/fleets/f/robots/r2/notes", "Another robot").await.status, 201);
    assert_eq!(served.items("/v1/audit?kind=NOTE_ADD&robot=r1&limit=1000").await.len(), 0, "the actions name no robot");
    assert_eq!(served.items("/v1/audit?kind=NOTE_ADD&limit=1000").await.len(), NOTES_MAX as usize + 1);
}

#[tokio::test]
async fn notes_are_added_listed_and_removed_on_sqlite() {
    notes_are_added_listed_and_removed(&Served::sqlite().await).await;
}

#[tokio::test]
async fn notes_are_added_listed_and_removed_on_postgres() {
    notes_are_added_listed_and_removed(&Served::postgres().await).await;
}

#[tokio::test]
async fn the_number_of_notes_is_limited_on_sqlite() {
    the_number_of_notes_is_limited(&Served::sqlite().await).await;
}

#[tokio::test]
async fn the_number_of_notes_is_limited_on_postgres() {
    the_number_of_notes_is_limited(&Served::postgres().await).await;
}

#[tokio::test]
async fn a_text_that_is_empty_or_long_or_has_control_characters_is_refused() {
    let served = Served::to(&AccessOptions::default()).await;
    for text in ["", " \n", &"x".repeat(2001), "a\u{7}b", "a\rb"] {
        let answer = add(&served, OF_R1, text).await;
        assert_eq!((answer.status, &answer.json()["errors"][0]["field"]), (422, &json!("text")), "{text:?}");
    }
    assert_eq!(add(&served, OF_R1, &"\u{fc}".repeat(2000)).await.status, 201);
    assert_eq!(add(&served, "/v1/fleets/f/robots/none/notes", "x").await.status, 404);
    assert_eq!(served.items("/v1/audit?kind=NOTE_ADD").await.len(), 1);
}

#[tokio::test]
async fn an_operator_of_the_fleet_writes_notes_and_a_viewer_reads_them() {
    let served = Served::sqlite().await;
    let mut answers = Vec::new();
    for (name, role, fleet) in
        [("olga", Role::Operator, "f"), ("vera", Role::Viewer, "f"), ("otto", Role::Operator, "g")]
    {
        let (name, scope, created_by) = (name.to_owned(), Scope::of([fleet.parse().unwrap()]), "test".to_owned());
        let new = NewToken { name, role, scope, expires_us: i64::MAX, created_by };
        let bearer = format!("Bearer {}", create(&served.store, &new, 0).await.unwrap().0);
        let headers = [("Authorization", bearer.as_str())];
        let added = asked(&served, "POST", OF_R1, &headers, Some(json!({ "text": "x" }))).await;
        let read = asked(&served, "GET", OF_R1, &headers, None).await;
        answers.push((added.status, read.status));
        if fleet == "f" {
            let author = read.json()["items"][0]["author"].as_str().unwrap().to_owned();
            assert!(author.contains("olga"), "{author}");
        }
    }
    assert_eq!(answers, [(201, 200), (403, 200), (403, 403)]);
}
