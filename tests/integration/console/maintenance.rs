//! The dialog of maintenance windows: a window is set, shown on the pages of alarms and of the robot, and ended.

use serde_json::{Value, json};
use vibrissa_tests::web::try_get;

use crate::checks::{complaints, overflow};
use crate::notes::{DIALOG, press, send};
use crate::stage::Stage;

const ROW: &str = "document.querySelector(\"tr[data-key^='maintenance-']\")";

async fn windows(stage: &Stage) -> Vec<Value> {
    let (_, text) = try_get(stage.service.http, "/v1/maintenance").await.unwrap();
    serde_json::from_str::<Value>(&text).unwrap()["items"].as_array().unwrap().clone()
}

async fn fill(stage: &mut Stage, field: &str, value: &str) {
    stage.browser.js(&format!("{DIALOG}.querySelector('#field-{field}').value = {}", json!(value))).await;
}

#[tokio::test]
async fn a_maintenance_is_set_shown_and_ended() {
    let mut stage = Stage::start().await;
    stage.open("#/alarms").await;
    press(&mut stage, "Set a maintenance").await;
    // The times are filled in: from now on, for two hours.
    let times = stage
        .browser
        .js(&format!("['from', 'until'].map((one) => Date.parse({DIALOG}.querySelector(`#field-${{one}}`).value))"))
        .await;
    assert_eq!(times[1].as_f64().unwrap() - times[0].as_f64().unwrap(), 2.0 * 3_600_000.0, "{times}");
    for (width, scheme) in [(1280, "light"), (390, "dark")] {
        stage.browser.size(width, 844).await;
        stage.browser.prefers(scheme).await;
        assert_eq!(complaints(&mut stage.browser).await, Vec::<String>::new(), "{width} {scheme}");
        assert_eq!(overflow(&mut stage.browser).await, Vec::<String>::new(), "{width} {scheme}");
        stage.picture(&format!("maintenance-{scheme}-{width}")).await;
    }
    stage.browser.size(1280, 844).await;
    // Without a reason the browser does not send it.
    fill(&mut stage, "robot", "r").await;
    fill(&mut stage, "repeats", "DAILY").await;
    stage.browser.js(&format!("{DIALOG}.querySelector('form').requestSubmit()")).await;
    assert_eq!(stage.browser.js(&format!("{DIALOG} !== null")).await, json!(true));
    assert_eq!(windows(&stage).await, Vec::<Value>::new());
    fill(&mut stage, "reason", "new belts").await;
    send(&mut stage).await;

    stage.browser.until("the window", &format!("{ROW}?.innerText.includes('new belts')")).await;
    let shown = stage.browser.js(&format!("{ROW}.innerText")).await.as_str().unwrap().to_owned();
    assert!(shown.contains("r of f") && shown.contains("every day"), "{shown}");
    let set = windows(&stage).await;
    let [one] = &set[..] else { panic!("one window: {set:?}") };
    assert_eq!((&one["robot"], &one["repeats"], &one["state"]), (&json!("r"), &json!("DAILY"), &json!("ACTIVE")));
    let begins = stage.browser.js(&format!("{ROW}.querySelector('time').dateTime")).await;
    assert_eq!(begins, one["begins_at"]);
    stage.open("#/fleets/f/robots/r").await;
    let line = "document.querySelector('main').innerText.includes('new belts')";
    stage.browser.until("the line of the robot", line).await;

    stage.open("#/alarms").await;
    stage.browser.until("the window again", ROW).await;
    press(&mut stage, "End").await;
    let dialog = stage.browser.js(&format!("{DIALOG}.innerText")).await.as_str().unwrap().to_owned();
    assert!(dialog.contains("End the maintenance of r of f"), "{dialog}");
    send(&mut stage).await;
    stage.browser.until("no window", &format!("!{ROW}")).await;
    assert_eq!(windows(&stage).await[0]["state"], "ENDED");
    stage.is_clean();
    stage.stop().await;
}
