//! A whisker vented by its own robot: Release beside its alarm, on its page, and for all at once.

use serde_json::{Value, json};
use vibrissa_protocol::{Gauge, Regulator, RobotTopic, SetpointOutcome, Status, WhiskerStatus, encode};
use vibrissa_tests::wait::until_true;
use vibrissa_tests::web::try_get;

use crate::stage::Stage;

/// A status of all whiskers, empty and with a faulty regulator: the supervisor does not fill them again by itself.
async fn vent(stage: &mut Stage) {
    let robot = &mut stage.robot;
    let whiskers = (0..3).map(|whisker| WhiskerStatus {
        array: robot.array.array.clone(),
        whisker,
        pressure_mpa: 0.0,
        setpoint_mpa: 0.0,
        regulator: Regulator::Fault,
        gauge: Gauge::Ok,
        segmenter: None,
    });
    let whiskers = whiskers.collect();
    let seq = robot.next_seq(RobotTopic::Status);
    let status = Status { boot_id: robot.boot_id.clone(), seq, t_us: robot.clock_us, whiskers, contacts_dropped: None };
    robot.say(RobotTopic::Status, encode(&status)).await;
}

async fn vented(stage: &Stage) -> usize {
    let (status, body) = try_get(stage.service.http, "/v1/alarms?kind=VENTED&standing=true").await.unwrap();
    assert_eq!(status, 200, "{body}");
    serde_json::from_str::<Value>(&body).unwrap()["items"].as_array().unwrap().len()
}

#[tokio::test]
async fn regress_a_vented_whisker_that_is_not_held_is_released_beside_its_alarm() {
    let mut stage = Stage::start().await;
    stage.robot.status().await;
    vent(&mut stage).await;
    until_true("three alarms", async || vented(&stage).await == 3).await;
    let button =
        |of: &str| format!("[...{of}.querySelectorAll('button')].find((one) => one.textContent.startsWith('Release'))");
    stage.open("#/fleets/f/robots/r/arrays/left/whiskers/0").await;
    stage.browser.until("a button on its page", &format!("!!({})", button("document"))).await;
    stage.open("#/alarms?kind=VENTED&fold=no").await;
    let card = "document.querySelector('.alarm[data-kind=VENTED]')";
    stage.browser.click(&button(card)).await;
    stage.browser.until("a dialog", "document.querySelector('dialog[open]')").await;
    stage.browser.js("document.querySelector('dialog[open] form').requestSubmit()").await;
    let (setpoint, _) = stage.robot.setpoint().await;
    assert_eq!(setpoint.pressure_mpa, 0.1);
    stage.robot.answer(&setpoint, SetpointOutcome::Applied, None).await;
    until_true("two are left", async || vented(&stage).await == 2).await;
    // The others at once.
    stage.open("#/alarms?kind=VENTED&fold=no").await;
    let all =
        "[...document.querySelectorAll('main button')].find((one) => one.textContent.startsWith('Release all vented'))";
    stage.browser.click(all).await;
    stage.browser.until("a dialog", "document.querySelector('dialog[open]')").await;
    let dialog = stage.browser.js("document.querySelector('dialog[open]').innerText").await;
    assert!(dialog.as_str().unwrap().contains("Release 2 whiskers"), "{dialog}");
    stage.browser.js("document.querySelector('dialog[open] form').requestSubmit()").await;
    for _ in 0..2 {
        let (setpoint, _) = stage.robot.setpoint().await;
        stage.robot.answer(&setpoint, SetpointOutcome::Applied, None).await;
    }
    until_true("none is left", async || vented(&stage).await == 0).await;
    assert_eq!(
        stage.browser.js("document.querySelectorAll('.alarm[data-kind=SETPOINT_FAILED]').length").await,
        json!(0)
    );
    stage.is_clean();
    stage.stop().await;
}
