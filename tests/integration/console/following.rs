//! A pressure set by hand is followed to the robot's answer, with the real routes.

use serde_json::json;
use vibrissa_protocol::{SetpointError, SetpointOutcome};

use crate::advising::button;
use crate::stage::Stage;

const WHISKER: &str = "#/fleets/f/robots/r/arrays/left/whiskers/1";
const NOTICE: &str = "document.querySelector('.notice:last-child span')?.textContent";

fn says(words: &str) -> String {
    format!("{NOTICE}?.includes({})", json!(words))
}

/// Sets the pressure in the dialog.
async fn set_pressure(stage: &mut Stage, pressure_mpa: f64) {
    stage.browser.click(&button("Set the pressure")).await;
    stage.browser.js(&format!("document.querySelector('dialog input').value = '{pressure_mpa}'")).await;
    stage.browser.js("document.querySelector('dialog form').requestSubmit()").await;
    let sent =
        format!("Set the pressure of whisker left 1 of r: {pressure_mpa:.4}\u{a0}MPa sent, waiting for the robot.");
    stage.browser.until("it is sent", &says(&sent)).await;
}

#[tokio::test]
async fn a_pressure_is_sent_first_and_called_applied_only_by_the_robot() {
    let mut stage = Stage::start().await;
    stage.open(WHISKER).await;
    set_pressure(&mut stage, 0.12).await;
    stage.picture("notice-sent").await;
    let (setpoint, _) = stage.robot.setpoint().await;
    stage.robot.answer(&setpoint, SetpointOutcome::Received, None).await;
    stage.browser.until("it is received", &says("0.1200\u{a0}MPa: received")).await;
    stage.robot.answer(&setpoint, SetpointOutcome::Applied, None).await;
    stage.browser.until("it is applied", &says("the robot applied 0.1200\u{a0}MPa")).await;

    set_pressure(&mut stage, 0.05).await;
    let (setpoint, _) = stage.robot.setpoint().await;
    stage.robot.answer(&setpoint, SetpointOutcome::Rejected, Some(SetpointError::NotReady)).await;
    let refused =
        "0.0500\u{a0}MPa not applied, rejected by the robot: the robot cannot change the pressure at the moment";
    stage.browser.until("it is rejected", &says(refused)).await;
    assert_eq!(stage.browser.js("document.querySelectorAll('.notice.bad').length").await, json!(1));
    stage.picture("notice-rejected").await;
    stage.is_clean();
    stage.stop().await;
}
