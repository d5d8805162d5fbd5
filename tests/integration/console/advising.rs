//! Approval of proposals in the console, from the cut to the robot's setpoint, with the real routes.

use serde_json::json;
use vibrissa_core::policy::{Mode, PolicyParams};
use vibrissa_protocol::{SetpointOutcome, SetpointReason};
use vibrissa_tests::actions::policy_body;
use vibrissa_tests::web::{ask, send};

use crate::stage::Stage;

const DIALOG: &str = "document.querySelector('dialog[open]')";

pub(crate) fn button(name: &str) -> String {
    format!("[...document.querySelectorAll('main button')].find((one) => one.textContent.startsWith('{name}'))")
}

/// Presses a button of the page, enters a reason in the dialog, and sends it.
pub(crate) async fn press(stage: &mut Stage, name: &str, reason: &str) {
    stage.browser.until(name, &button(name)).await;
    stage.browser.js(&format!("{}.focus()", button(name))).await;
    stage.browser.press("Enter").await;
    stage.browser.until("a dialog", DIALOG).await;
    stage.browser.js(&format!("{DIALOG}.querySelector('textarea').value = '{reason}'")).await;
    stage.browser.js(&format!("{DIALOG}.querySelector('form').requestSubmit()")).await;
    stage.browser.until("it is done", &format!("!{DIALOG}")).await;
}

#[tokio::test]
async fn a_proposal_is_shown_without_reload_and_approved_on_its_page() {
    let mut stage = Stage::start().await;
    let http = stage.service.http;
    let policy = policy_body(&PolicyParams { mode: Mode::Advise, ..PolicyParams::default() });
    let set = send(http, "PUT", "/v1/fleets/f/policy", &[("If-Match", "\"0\"")], Some(&policy)).await.unwrap();
    assert_eq!(set.status, 200, "{}", set.body);
    stage.open("#/fleets/f/robots/r").await;
    let live = "document.getElementById('connection').textContent.startsWith('live')";
    stage.browser.until("it is live", live).await;
    stage.cut().await;
    stage.browser.until("the proposal is shown", &button("Approve")).await;
    assert!(stage.robot.setpoints_left().is_empty(), "no setpoint may be sent before the approval");
    stage.picture("proposal").await;
    press(&mut stage, "Approve", "looks right").await;
    let (setpoint, _) = stage.robot.setpoint().await;
    assert!(!matches!(setpoint.reason, SetpointReason::Operator | SetpointReason::Release), "{:?}", setpoint.reason);
    stage.robot.answer(&setpoint, SetpointOutcome::Applied, None).await;
    stage.browser.until("no proposal is left", &format!("!({})", button("Approve"))).await;
    let audit = ask(http, "GET", "/v1/audit", &[]).await.unwrap().json();
    assert_eq!([&audit["items"][0]["kind"], &audit["items"][0]["reason"]], [&json!("APPROVE"), &json!("looks right")]);
    stage.is_clean();
    stage.stop().await;
}

#[tokio::test]
async fn a_whisker_is_held_and_released_on_its_page() {
    let mut stage = Stage::start().await;
    stage.open("#/fleets/f/robots/r/arrays/left/whiskers/1").await;
    let held = async |stage: &Stage| {
        let path = "/v1/fleets/f/robots/r/arrays/left/whiskers/1";
        ask(stage.service.http, "GET", path, &[]).await.unwrap().json()["held"].clone()
    };
    press(&mut stage, "Hold", "a look at it").await;
    assert_eq!(held(&stage).await, true);
    press(&mut stage, "Release", "done").await;
    assert_eq!(held(&stage).await, false);
    stage.is_clean();
    stage.stop().await;
}
