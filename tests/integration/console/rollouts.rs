//! Staged roll-outs in the console: begun on the page of the policy, followed, paused, advanced and completed.

use serde_json::{Value, json};
use vibrissa_tests::web::try_get;

use crate::checks::{complaints, overflow};
use crate::stage::Stage;

const DIALOG: &str = "document.querySelector('dialog[open]')";

async fn press(stage: &mut Stage, button: &str) {
    let find =
        format!("[...document.querySelectorAll('main button')].find((one) => one.textContent.startsWith('{button}'))");
    stage.browser.click(&find).await;
    stage.browser.until("a dialog", DIALOG).await;
}

async fn send(stage: &mut Stage, reason: &str) {
    stage.browser.js(&format!("{DIALOG}.querySelector('textarea').value = {}", json!(reason))).await;
    stage.browser.js(&format!("{DIALOG}.querySelector('form').requestSubmit()")).await;
    stage.browser.until("the dialog is closed", &format!("!{DIALOG}")).await;
}

async fn looks_right(stage: &mut Stage, name: &str) {
    for (width, scheme) in [(1280, "light"), (390, "dark"), (360, "light")] {
        stage.browser.size(width, 844).await;
        stage.browser.prefers(scheme).await;
        assert_eq!(complaints(&mut stage.browser).await, Vec::<String>::new(), "{name} {width} {scheme}");
        assert_eq!(overflow(&mut stage.browser).await, Vec::<String>::new(), "{name} {width} {scheme}");
        stage.picture(&format!("rollout-{name}-{width}-{scheme}")).await;
    }
    stage.browser.size(1280, 900).await;
}

async fn shows(stage: &mut Stage, words: &str) {
    let condition = format!("document.querySelector('main').innerText.includes({})", json!(words));
    stage.browser.until(words, &condition).await;
}

#[tokio::test]
async fn a_policy_is_rolled_out_in_stages_and_each_event_is_shown() {
    let mut stage = Stage::start().await;
    stage.open("#/policy").await;
    press(&mut stage, "Roll a policy out in stages").await;
    looks_right(&mut stage, "dialog").await;
    stage.browser.js(&format!("{DIALOG}.querySelector('[name=mode]').value = 'ADVISE'")).await;
    send(&mut stage, "people shall look first").await;
    stage.browser.until("it has begun", "document.getElementById('notices').textContent.includes('done')").await;
    stage.browser.click("document.querySelector('main .links a')").await;
    shows(&mut stage, "5 % of the robots").await;
    shows(&mut stage, "policy: advise").await;
    looks_right(&mut stage, "list").await;
    stage.browser.click("document.querySelector('main tbody a')").await;
    shows(&mut stage, "people shall look first").await;
    press(&mut stage, "Pause").await;
    send(&mut stage, "not at night").await;
    shows(&mut stage, "not at night").await;
    press(&mut stage, "Resume").await;
    send(&mut stage, "").await;
    shows(&mut stage, "running").await;
    press(&mut stage, "Advance").await;
    send(&mut stage, "").await;
    shows(&mut stage, "25 % of the robots").await;
    looks_right(&mut stage, "one").await;
    press(&mut stage, "Advance").await;
    send(&mut stage, "it works").await;
    shows(&mut stage, "in force everywhere").await;
    stage.browser.until("no more buttons", "document.querySelectorAll('main .buttons button').length === 0").await;
    let (_, policy) = try_get(stage.service.http, "/v1/fleets/f/policy").await.unwrap();
    let policy: Value = serde_json::from_str(&policy).unwrap();
    assert_eq!((&policy["mode"], &policy["version"]), (&json!("ADVISE"), &json!(1)));
    stage.is_clean();
    stage.stop().await;
}
