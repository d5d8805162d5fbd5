//! Dialogs of operator actions. A script in the page replaces the routes, so that tests can give any answer, including
//! rare ones.

use serde_json::{Value, json};

use crate::checks::complaints;
use crate::stage::Stage;

const WHISKER: &str = "#/fleets/f/robots/r/arrays/left/whiskers/1";
const DIALOG: &str = "document.querySelector('dialog[open]')";

/// A stage on the page of a healthy whisker, with the routes replaced.
async fn before_a_whisker() -> Stage {
    let mut stage = Stage::start().await;
    let source = json!({ "source": include_str!("acting.js") });
    stage.browser.call("Page.addScriptToEvaluateOnNewDocument", source).await;
    stage.open(WHISKER).await;
    stage
}

/// Opens the dialog of an action with the keyboard.
async fn ask(stage: &mut Stage, action: &str) {
    let button =
        format!("[...document.querySelectorAll('main button')].find((one) => one.textContent.startsWith('{action}'))");
    stage.browser.js(&format!("{button}.focus()")).await;
    stage.browser.press("Enter").await;
    stage.browser.until("a dialog", DIALOG).await;
}

async fn sent(stage: &mut Stage) -> Vec<Value> {
    let Value::Array(sent) = stage.browser.js("window.sent").await else { panic!("a list") };
    sent
}

#[tokio::test]
async fn a_manual_setpoint_is_explained_sent_once_and_its_result_told() {
    let mut stage = before_a_whisker().await;
    ask(&mut stage, "Set the pressure").await;
    assert_eq!(complaints(&mut stage.browser).await, Vec::<String>::new());
    let words = stage.browser.js(&format!("{DIALOG}.innerText")).await;
    for part in ["The robot moves the chamber", "From 0 to 0.2 MPa"] {
        assert!(words.as_str().unwrap().contains(part), "{part}: {words}");
    }
    // The first field has the focus, and its value is selected for typing.
    assert_eq!(stage.browser.js("document.activeElement.name").await, "pressure_mpa");
    stage.browser.js("document.activeElement.select()").await;
    stage.browser.type_text("0.12").await;
    stage.picture("dialog").await;
    stage.browser.press("Enter").await;
    stage
        .browser
        .until(
            "the notice is shown",
            "document.getElementById('notices').textContent.includes('no setpoint was necessary')",
        )
        .await;
    assert_eq!(stage.browser.js(DIALOG).await, Value::Null);
    let sent = sent(&mut stage).await;
    assert_eq!(sent.len(), 1);
    assert_eq!(sent[0]["path"], "v1/fleets/f/robots/r/arrays/left/whiskers/1/setpoint");
    assert_eq!(sent[0]["body"], json!({ "pressure_mpa": 0.12 }));
    assert_eq!(sent[0]["key"].as_str().unwrap().len(), 32);
    stage.is_clean();
    stage.stop().await;
}

#[tokio::test]
async fn what_is_out_of_range_is_not_sent() {
    let mut stage = before_a_whisker().await;
    ask(&mut stage, "Set the pressure").await;
    for pressure in ["0.21", "-0.1", ""] {
        stage.browser.js(&format!("document.querySelector('dialog input').value = '{pressure}'")).await;
        stage.browser.press("Enter").await;
        assert_eq!(stage.browser.js("document.querySelector('dialog form').checkValidity()").await, json!(false));
    }
    assert_eq!(sent(&mut stage).await, Vec::<Value>::new());
    stage.stop().await;
}

#[tokio::test]
async fn regress_a_refused_request_gets_a_new_key_and_one_without_an_answer_keeps_it() {
    let mut stage = before_a_whisker().await;
    let problem =
        json!({ "status": 409, "title": "Not possible in the current state", "detail": "the robot is offline" });
    stage.browser.js(&format!("window.answer = {}", json!({ "status": 409, "body": problem }))).await;
    ask(&mut stage, "Hold").await;
    stage.browser.js("document.querySelector('dialog textarea').value = 'a look at it'").await;
    let alert = format!("{DIALOG}.querySelector('[role=alert]').innerText");
    let send = "document.querySelector('dialog form').requestSubmit()";
    stage.browser.js(send).await;
    stage.browser.until("the problem is shown", &format!("{alert}.includes('the robot is offline')")).await;
    assert!(stage.browser.js(&alert).await.as_str().unwrap().contains("request-7"));
    stage.browser.js(&format!("{DIALOG}.querySelector('[role=alert]').replaceChildren(); {send}")).await;
    stage.browser.until("the problem is shown again", &format!("{alert}.includes('the robot is offline')")).await;
    for answer in [Value::Null, json!({ "status": 503, "body": {} })] {
        stage
            .browser
            .js(&format!("window.answer = {answer}; {DIALOG}.querySelector('[role=alert]').replaceChildren()"))
            .await;
        stage.browser.js(send).await;
        stage.browser.until("the problem is shown", &format!("{alert}.includes('answer')")).await;
    }
    stage.browser.js(&format!("{DIALOG}.querySelector('[role=alert]').replaceChildren(); {send}")).await;
    stage.browser.until("it is shown again", &format!("{alert}.includes('answer')")).await;
    stage.browser.js(&format!("document.querySelector('dialog textarea').value = ''; {send}")).await;
    stage.browser.until("another request", "window.sent.length === 6").await;
    let sent = sent(&mut stage).await;
    assert_eq!(sent[0]["body"], json!({ "reason": "a look at it" }));
    let keys: Vec<&Value> = sent.iter().map(|one| &one["key"]).collect();
    // The service would repeat its refusal for the key.
    assert!(keys[0] != keys[1] && keys[1] != keys[2], "{keys:?}");
    assert!(keys[2] == keys[3] && keys[3] == keys[4] && keys[4] != keys[5], "{keys:?}");
    stage.stop().await;
}

#[tokio::test]
async fn escape_closes_a_dialog_and_the_focus_goes_back_to_its_button() {
    let mut stage = before_a_whisker().await;
    for action in ["Set the pressure", "Hold", "Mark as replaced", "Relearn baseline"] {
        ask(&mut stage, action).await;
        stage.browser.press("Escape").await;
        stage.browser.until("it is closed", &format!("!{DIALOG}")).await;
        let focused = stage.browser.js("document.activeElement.textContent").await;
        assert!(focused.as_str().unwrap().starts_with(action), "{action}: {focused}");
    }
    ask(&mut stage, "Hold").await;
    stage.browser.js("location.hash = '#/alarms'").await;
    stage.browser.until("another page", "document.querySelector('h1').textContent === 'Alarms'").await;
    assert_eq!(stage.browser.js(DIALOG).await, Value::Null, "a dialog must close with its page");
    assert_eq!(sent(&mut stage).await, Vec::<Value>::new());
    stage.stop().await;
}
