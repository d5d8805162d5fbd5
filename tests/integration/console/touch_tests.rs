//! Touch tests on the pages of a whisker and of a robot, with a robot that answers by hand.

use serde_json::Value;
use vibrissa_core::policy::Mode;
use vibrissa_core::units::Micros;
use vibrissa_protocol::{Contact, TouchTestError, TouchTestKind, TouchTestOutcome, TouchTestReason};
use vibrissa_tests::web::ask;

use crate::advising::press;
use crate::checks::complaints;
use crate::stage::Stage;

const WHISKER: &str = "#/fleets/f/robots/r/arrays/left/whiskers/1";
const HISTORY: &str = "#/fleets/f/robots/r/arrays/left/whiskers/1?tab=history";

/// Waits until a row of the table of touch tests contains a text.
async fn row_says(stage: &mut Stage, text: &str) {
    stage.open(HISTORY).await;
    let rows = "[...document.querySelectorAll('[data-key^=test-]')]";
    stage.browser.until(text, &format!("{rows}.some((row) => row.innerText.includes('{text}'))")).await;
}

async fn listed(stage: &Stage, query: &str) -> Value {
    let path = format!("/v1/touch-tests?fleet=f&robot=r&array=left&whisker=1{query}");
    ask(stage.service.http, "GET", &path, &[]).await.unwrap().json()["items"].clone()
}

#[tokio::test]
async fn a_test_is_requested_followed_and_its_length_shown() {
    let mut stage = Stage::with(|params| params.touch_tests.zero_sd_mm = 0.0).await;
    stage.robot.touch_tests = vec![TouchTestKind::Wall];
    stage.robot.birth().await;
    stage.robot.settle().await;
    stage.open(HISTORY).await;
    let empty = "document.body.innerText.includes('No touch test was requested yet.')";
    stage.browser.until("no test", empty).await;
    stage.open(WHISKER).await;
    press(&mut stage, "Touch test", "a look at it").await;
    let test = stage.robot.touch_test().await;
    row_says(&mut stage, "not answered yet").await;
    row_says(&mut stage, "10 requested").await;

    // The audit log leads from the action to its test.
    let audit = ask(stage.service.http, "GET", "/v1/audit", &[]).await.unwrap().json();
    assert_eq!(audit["items"][0]["kind"], "TOUCH_TEST");
    assert_eq!(audit["items"][0]["test_id"], test.test_id.as_str());
    let found = listed(&stage, &format!("&test_id={}", test.test_id)).await;
    assert_eq!(found[0]["test_id"], test.test_id.as_str());
    assert_eq!(found[0]["state"], "PENDING");

    stage.robot.answer_test(&test, TouchTestOutcome::Accepted, None).await;
    row_says(&mut stage, "accepted").await;
    stage.robot.answer_test(&test, TouchTestOutcome::Running, None).await;
    stage.robot.touch_on_request(&test, (4, 60.0), (1, 69.5)).await;
    row_says(&mut stage, "5 of 10, 1 missed").await;
    row_says(&mut stage, "running").await;
    stage.picture("touch-test").await;
    stage.robot.answer_test(&test, TouchTestOutcome::Done, None).await;
    row_says(&mut stage, "done").await;
    row_says(&mut stage, "length ").await;
    let found = listed(&stage, "&state=DONE").await;
    assert_eq!((&found[0]["touches"], &found[0]["missed"]), (&4.into(), &1.into()));
    let length_mm = found[0]["length_mm"].as_f64().unwrap();
    assert!((length_mm - 68.0).abs() < 2.0, "{length_mm}");
    assert_eq!(complaints(&mut stage.browser).await, Vec::<String>::new());
    stage.is_clean();
    stage.stop().await;
}

#[tokio::test]
async fn a_refusal_of_the_robot_is_told_in_plain_words() {
    let mut stage = Stage::with(|params| params.touch_tests.zero_sd_mm = 0.0).await;
    stage.robot.touch_tests = vec![TouchTestKind::Tip];
    stage.robot.birth().await;
    stage.robot.settle().await;
    stage.open(WHISKER).await;
    press(&mut stage, "Touch test", "a look at it").await;
    let test = stage.robot.touch_test().await;
    stage.robot.answer_test(&test, TouchTestOutcome::Rejected, Some(TouchTestError::NotReady)).await;
    row_says(&mut stage, "rejected by the robot").await;
    row_says(&mut stage, "the robot cannot do it at the moment").await;
    stage.is_clean();
    stage.stop().await;
}

#[tokio::test]
async fn a_proposed_test_is_shown_and_started_by_an_operator() {
    let mut stage = Stage::with(|params| {
        params.touch_tests.zero_sd_mm = 0.0;
        params.policy.mode = Mode::Advise;
        params.touch_tests.every = Micros::from_s(1.0);
    })
    .await;
    stage.robot.touch_tests = vec![TouchTestKind::Tip];
    stage.robot.birth().await;
    stage.robot.settle().await;
    stage.open("#/fleets/f/robots/r").await;
    // A whisker whose contacts state distances is due by the schedule.
    let contact = stage.robot.contact(1);
    stage.robot.send(vec![Contact { ratio: None, distance_mm: Some(60.0), ..contact }]).await;
    let shown = "document.body.innerText.includes('Measure whisker left 1 by touches')";
    stage.browser.until("the proposal", shown).await;
    stage.picture("proposed-test").await;
    let proposed = listed(&stage, "&state=PROPOSED").await;
    assert_eq!((&proposed[0]["reason"], &proposed[0]["ended_at"]), (&"SCHEDULE".into(), &Value::Null));
    stage.open(WHISKER).await;
    row_says(&mut stage, "waits for an operator").await;
    stage.open(WHISKER).await;
    press(&mut stage, "Touch test", "go ahead").await;
    let test = stage.robot.touch_test().await;
    assert_eq!((test.whisker, test.reason), (1, TouchTestReason::Schedule));
    row_says(&mut stage, "withdrawn").await;
    assert_eq!(listed(&stage, "&state=PROPOSED").await, Value::Array(Vec::new()));
    stage.is_clean();
    stage.stop().await;
}

#[tokio::test]
async fn a_proposed_test_is_refused_where_it_is_listed() {
    let mut stage = Stage::with(|params| {
        params.touch_tests.zero_sd_mm = 0.0;
        params.policy.mode = Mode::Advise;
        params.touch_tests.every = Micros::from_s(1.0);
    })
    .await;
    stage.robot.touch_tests = vec![TouchTestKind::Wall];
    stage.robot.birth().await;
    stage.robot.settle().await;
    stage.open("#/fleets/f/robots/r").await;
    let contact = stage.robot.contact(1);
    stage.robot.send(vec![Contact { ratio: None, distance_mm: Some(60.0), ..contact }]).await;
    stage.browser.until("the proposal", "document.body.innerText.includes('Refuse the test')").await;
    let first = listed(&stage, "&state=PROPOSED").await[0]["test_id"].clone();
    stage.picture("refused-test").await;
    press(&mut stage, "Refuse the test", "the wall is hot").await;
    stage.open(WHISKER).await;
    row_says(&mut stage, "refused by an operator").await;
    let audit = ask(stage.service.http, "GET", "/v1/audit", &[]).await.unwrap().json();
    let refusal = &audit["items"][0];
    assert_eq!((&refusal["kind"], &refusal["state"]), (&"REFUSE_TOUCH_TEST".into(), &"DONE".into()));
    assert_eq!(refusal["reason"], "the wall is hot");
    let ended = listed(&stage, "&state=REFUSED").await;
    assert_eq!(ended[0]["test_id"], first);
    assert_eq!(complaints(&mut stage.browser).await, Vec::<String>::new());
    stage.is_clean();
    stage.stop().await;
}
