//! The alarms page during a storm: one alarm for each silent robot, one row for all of them, and one request about them.

use serde_json::{Value, json};
use vibrissa_protocol::{ArrayType, ConnectionState, RobotTopic, SetpointError, SetpointOutcome};
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::until_true;
use vibrissa_tests::web::{send, try_get};

use crate::checks::{complaints, overflow};
use crate::stage::Stage;

/// Robots beside robot `r`, each with three whiskers.
const ROBOTS: usize = 119;
const ALL: usize = ROBOTS + 1;

async fn items(stage: &Stage, path: &str) -> Vec<Value> {
    let (status, body) = try_get(stage.service.http, path).await.unwrap();
    assert_eq!(status, 200, "{body}");
    serde_json::from_str::<Value>(&body).unwrap()["items"].as_array().unwrap().clone()
}

/// Stops all robots: 120 with three whiskers each.
async fn silenced() -> Stage {
    let mut stage = Stage::start().await;
    for number in 0..ROBOTS {
        let sheet = array(ArrayType::Type1, &[70.0, 68.0, 65.0]);
        let mut robot = HandRobot::connect(stage.service.broker.port, &format!("many-{number:03}"), sheet).await;
        robot.birth().await;
        robot.settle().await;
        robot.connection(ConnectionState::ConnectionBroken).await;
    }
    stage.robot.connection(ConnectionState::ConnectionBroken).await;
    let standing = "/v1/alarms?standing=true&limit=1000";
    until_true("an alarm for each robot", async || items(&stage, standing).await.len() >= ALL).await;
    stage
}

async fn text(stage: &mut Stage, selector: &str) -> String {
    let text = stage.browser.js(&format!("document.querySelector({})?.innerText ?? ''", json!(selector))).await;
    text.as_str().unwrap().to_owned()
}

#[tokio::test]
async fn a_hundred_and_twenty_silent_robots_are_one_row_that_unfolds_and_is_acknowledged_at_once() {
    let mut stage = silenced().await;
    let standing = items(&stage, "/v1/alarms?standing=true&limit=1000").await;
    assert_eq!(standing.len(), ALL, "one for each robot, and none for a whisker");
    assert!(standing.iter().all(|alarm| alarm["kind"] == "ROBOT_SILENT" && alarm["whisker"].is_null()));

    stage.open("#/alarms").await;
    assert_eq!(stage.browser.js("document.querySelectorAll('.groups > li').length").await, json!(1));
    let storm = text(&mut stage, ".storm").await;
    for part in ["urgent", "silent or not connected", "120 not acknowledged", "Check the robot's power"] {
        assert!(storm.contains(part), "{part}: {storm}");
    }
    assert!(text(&mut stage, ".summary").await.starts_with("120 alarms"));
    for (width, scheme) in [(1280, "light"), (1280, "dark"), (390, "light"), (390, "dark")] {
        stage.browser.size(width, 844).await;
        stage.browser.prefers(scheme).await;
        stage.open("#/alarms").await;
        assert_eq!(complaints(&mut stage.browser).await, Vec::<String>::new(), "{width} {scheme}");
        assert_eq!(overflow(&mut stage.browser).await, Vec::<String>::new(), "{width} {scheme}");
        stage.picture(&format!("storm-{width}-{scheme}")).await;
    }
    let height = stage.browser.js("document.documentElement.scrollHeight").await.as_f64().unwrap();
    assert!(height < 2500.0, "{height} px on a phone");

    // The runbook opens from the alarm.
    let runbook = stage.browser.js("new URL(document.querySelector('.storm details a').href).pathname").await;
    let (status, words) = try_get(stage.service.http, runbook.as_str().unwrap()).await.unwrap();
    assert_eq!((status, words.contains("ROBOT_SILENT")), (200, true), "{words}");

    // Unfolded, it shows a bounded number of alarms, and a reload keeps it unfolded.
    stage.browser.click("document.querySelector('.storm a[aria-expanded]')").await;
    stage.browser.until("its alarms", "document.querySelectorAll('.members > li').length === 50").await;
    stage.browser.js("void (window.old = true)").await;
    stage.browser.call("Page.reload", json!({})).await;
    stage.browser.until("the same", "!window.old && document.querySelectorAll('.members > li').length === 50").await;
    stage.picture("storm-unfolded").await;

    // The dialog lists the alarms before it acknowledges them.
    stage.browser.size(1280, 900).await;
    stage.open("#/alarms").await;
    let button = "[...document.querySelectorAll('main button')].find((one) => one.textContent.startsWith('Acknowledge all 120'))";
    stage.browser.click(button).await;
    stage.browser.until("the list", "document.querySelectorAll('dialog[open] .concerned li').length === 120").await;
    assert_eq!(complaints(&mut stage.browser).await, Vec::<String>::new());
    stage.picture("storm-dialog").await;
    assert_eq!(items(&stage, "/v1/alarms?state=ACKNOWLEDGED").await.len(), 0, "nothing has changed yet");
    stage.browser.js("document.querySelector('dialog textarea').value = 'the switch of hall 2'").await;
    stage.browser.js("document.querySelector('dialog form').requestSubmit()").await;
    stage
        .browser
        .until("all are acknowledged", "document.querySelector('.summary').textContent.includes('all acknowledged')")
        .await;
    let acknowledged = items(&stage, "/v1/alarms?state=ACKNOWLEDGED&limit=1000").await;
    assert_eq!(acknowledged.len(), ALL);
    assert!(acknowledged.iter().all(|alarm| alarm["acknowledged_reason"] == "the switch of hall 2"));
    // The statistics call so many at once a flood.
    stage.open("#/alarm-statistics").await;
    let verdict = text(&mut stage, ".summary").await;
    assert!(verdict.starts_with("120 alarms") && verdict.contains("flood"), "{verdict}");
    assert_eq!(items(&stage, "/v1/audit?kind=ALARM_ACKNOWLEDGE&limit=1000").await.len(), ALL);
    stage.is_clean();
    stage.stop().await;
}

#[tokio::test]
async fn filters_of_alarms_are_in_the_address_and_buttons_are_visible_on_a_phone() {
    // No compensation is good enough.
    let mut stage = Stage::with(|params| params.policy.predicted_error_max = 1e-6).await;
    stage.cut().await;
    let standing = "/v1/alarms?standing=true";
    until_true("the alarm", async || items(&stage, standing).await.iter().any(|one| one["kind"] == "UNCOMPENSATED"))
        .await;
    stage.browser.size(390, 844).await;
    stage.open("#/alarms").await;
    let card = "document.querySelector('.alarm[data-kind=UNCOMPENSATED]')";
    let place = text(&mut stage, ".group h2").await;
    assert!(place.contains("f") && place.contains("r, array left"), "{place}");
    let buttons = format!(
        "[...{card}.querySelectorAll('button')].map((one) => one.getBoundingClientRect()).every((one) => \
         one.width > 40 && one.height >= 44 && one.left >= 0 && one.right <= innerWidth)"
    );
    assert_eq!(stage.browser.js(&buttons).await, json!(true));
    // A touch test and a replacement mend it; it may be acknowledged and shelved.
    assert_eq!(stage.browser.js(&format!("{card}.querySelectorAll('.mend button').length")).await, json!(2));
    assert_eq!(stage.browser.js(&format!("{card}.querySelectorAll('.about-it button').length")).await, json!(2));
    let how_bad = stage.browser.js(&format!("{card}.querySelector('.how-bad').innerText")).await;
    let how_bad = how_bad.as_str().unwrap();
    assert!(how_bad.ends_with("mm lost") && how_bad.starts_with(['4', '5']), "{how_bad}");
    let why = stage.browser.js(&format!("{card}.querySelector('.why').innerText")).await;
    assert!(why.as_str().unwrap().contains("refused: the predicted error is above the policy's limit"), "{why}");
    let runbook = stage.browser.js(&format!("{card}.querySelector('details a').href")).await;
    let runbook = runbook.as_str().unwrap().split_once("/runbooks/").unwrap().1.to_owned();
    assert!(runbook.ends_with("?fleet=f&robot=r&array=left&whisker=0"), "{runbook}");
    let (status, words) = try_get(stage.service.http, &format!("/runbooks/{runbook}")).await.unwrap();
    assert_eq!(
        (status, words.contains("/v1/fleets/f/robots/r/arrays/left/whiskers/0/replaced")),
        (200, true),
        "{words}"
    );
    for scheme in ["light", "dark"] {
        stage.browser.prefers(scheme).await;
        assert_eq!(complaints(&mut stage.browser).await, Vec::<String>::new(), "{scheme}");
        assert_eq!(overflow(&mut stage.browser).await, Vec::<String>::new(), "{scheme}");
        stage.picture(&format!("alarm-card-{scheme}")).await;
    }
    stage.browser.size(1280, 900).await;
    stage.picture("alarm-card-wide").await;

    let choose = |name: &str, value: &str| {
        format!(
            "{{ const field = document.getElementById('filter-{name}'); field.value = '{value}'; \
             field.dispatchEvent(new Event('change')); }}"
        )
    };
    stage.browser.js(&choose("level", "CRITICAL")).await;
    stage.browser.until("no critical alarm", &format!("!{card} && !!document.querySelector('main .empty')")).await;
    stage.browser.js(&choose("level", "URGENT")).await;
    stage.browser.until("the alarm again", card).await;
    stage.browser.js(&choose("state", "UNACKNOWLEDGED")).await;
    stage.browser.until("the address", "location.hash === '#/alarms?level=URGENT&state=UNACKNOWLEDGED'").await;
    stage.browser.js("void (window.old = true)").await;
    stage.browser.call("Page.reload", json!({})).await;
    stage.browser.until("the page after a reload", &format!("!window.old && !!{card}")).await;
    assert_eq!(stage.browser.js("document.getElementById('filter-level').value").await, "URGENT");
    assert_eq!(stage.browser.js("document.getElementById('filter-state').value").await, "UNACKNOWLEDGED");

    // A trimmed whisker without compensation has its own mark and its own drawing, which are no colour.
    stage.open("#/fleets/f/robots/r").await;
    let marks = text(&mut stage, "tr[data-key='whisker-left-0'] .marks").await;
    assert!(marks.contains("trimmed, not compensated"), "{marks}");
    assert_eq!(stage.browser.js("document.querySelectorAll('svg.drawing .refused').length").await, json!(1));
    let summary = text(&mut stage, "main > .marks").await;
    assert!(summary.contains("1 trimmed, not compensated") && !summary.contains("needs attention"), "{summary}");
    assert!(!text(&mut stage, "main").await.contains("nobody"));
    stage.picture("uncompensated").await;
    // A robot that is not connected is no robot that needs nothing.
    stage.robot.connection(ConnectionState::Offline).await;
    stage.open("#/fleets/f").await;
    stage.browser.until("it is offline", "document.querySelector('main tbody').innerText.includes('offline')").await;
    assert!(!text(&mut stage, "main tbody").await.contains("nothing needs attention"));

    // A shelved alarm stays visible, with the end of the silence and the reason.
    let alarm = items(&stage, "/v1/alarms?standing=true&kind=UNCOMPENSATED").await[0]["alarm_id"].clone();
    let until = stage.browser.js("new Date(Date.now() + 3_600_000).toISOString()").await;
    let body = json!({ "until": until, "reason": "a new one is ordered" });
    let shelve = format!("/v1/alarms/{alarm}/shelve");
    let shelved = send(stage.service.http, "POST", &shelve, &[], Some(&body)).await.unwrap();
    assert_eq!(shelved.status, 200, "{}", shelved.body);
    stage.open("#/alarms").await;
    stage.browser.until("it is shelved", "!!document.querySelector('.alarms.shelved')").await;
    let shelved = text(&mut stage, ".alarms.shelved").await;
    for part in ["trimmed, not compensated", "until", "a new one is ordered", "Unshelve"] {
        assert!(shelved.contains(part), "{part}: {shelved}");
    }
    assert_eq!(complaints(&mut stage.browser).await, Vec::<String>::new());
    stage.is_clean();
    stage.stop().await;
}

#[tokio::test]
async fn a_failed_setpoint_is_tried_again_with_the_button_of_its_alarm() {
    let mut stage = Stage::start().await;
    stage.cut().await;
    let (setpoint, _) = stage.robot.setpoint().await;
    stage.robot.answer(&setpoint, SetpointOutcome::Rejected, Some(SetpointError::Stale)).await;
    let is_failed = |alarm: &Value| alarm["kind"] == "SETPOINT_FAILED";
    let standing = "/v1/alarms?standing=true";
    until_true("the alarm", async || items(&stage, standing).await.iter().any(is_failed)).await;
    stage.open("#/alarms").await;
    let button = "[...document.querySelectorAll('main button')].find((one) => one.textContent.startsWith('Try again'))";
    stage.browser.until("the button", &format!("!!{button}")).await;
    let why = text(&mut stage, ".alarm[data-kind=SETPOINT_FAILED] .why").await;
    assert!(why.contains("not set: 1 attempt rejected by the robot: the robot has a newer setpoint"), "{why}");
    stage.browser.js(&format!("{button}.click()")).await;
    stage.browser.until("a dialog", "document.querySelector('dialog[open]')").await;
    assert_eq!(complaints(&mut stage.browser).await, Vec::<String>::new());
    stage.browser.js("document.querySelector('dialog form').requestSubmit()").await;
    let is_done = |action: &Value| {
        action["kind"] == "RETRY" && action["state"] == "DONE" && action["whisker"] == setpoint.whisker
    };
    until_true("the action", async || items(&stage, "/v1/audit").await.iter().any(is_done)).await;
    stage.browser.until("the dialog is closed", "!document.querySelector('dialog[open]')").await;
    stage.is_clean();
    stage.stop().await;
}

#[tokio::test]
async fn what_was_refused_of_a_robot_is_on_its_page_with_its_reason_in_words() {
    let mut stage = Stage::start().await;
    stage.open("#/fleets/f/robots/r").await;
    let row = "document.querySelector(\"tr[data-key='refusal-status-not_json']\")";
    assert_eq!(stage.browser.js(&format!("!!{row}")).await, json!(false), "nothing was refused yet");
    stage.robot.say(RobotTopic::Status, "{").await;
    let refusals = "/v1/fleets/f/robots/r/refusals";
    until_true("the refusal", async || !items(&stage, refusals).await.is_empty()).await;
    stage.open("#/fleets/f/robots/r").await;
    stage.browser.until("the refusal", &format!("!!{row}")).await;
    let text = text(&mut stage, "tr[data-key='refusal-status-not_json']").await;
    for part in ["status", "not_json", "1", "the payload is not JSON", "send all of it"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    assert_eq!(complaints(&mut stage.browser).await, Vec::<String>::new());
    stage.is_clean();
    stage.stop().await;
}
