//! Actions on many in the console: from the filtered table over the dry run to the progress.

use serde_json::{Value, json};
use vibrissa_protocol::ArrayType;
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::web::{send, try_get};

use crate::checks::{complaints, overflow};
use crate::overview::{READINGS, upload};
use crate::stage::Stage;

const DIALOG: &str = "document.querySelector('dialog[open]')";
const ROBOTS: usize = 24;

/// 24 robots in hall 2 beside robot `r`.
async fn many() -> (Stage, Vec<HandRobot>) {
    let stage = Stage::start().await;
    let mut robots = Vec::new();
    for number in 0..ROBOTS {
        let name = format!("many-{number:03}");
        robots.push(HandRobot::born(stage.service.broker.port, &name, array(ArrayType::Type1, &[70.0, 68.0])).await);
        let path = format!("/v1/fleets/f/robots/{name}/labels/hall");
        let set = vibrissa_tests::wait::until("the robot is known", async || {
            let answer = send(stage.service.http, "PUT", &path, &[], Some(&json!({ "value": "2" }))).await.unwrap();
            Some(answer.status).filter(|status| *status != 404)
        });
        assert_eq!(set.await, 200);
    }
    (stage, robots)
}

async fn press(stage: &mut Stage, button: &str) {
    let find =
        format!("[...document.querySelectorAll('main button')].find((one) => one.textContent.startsWith('{button}'))");
    stage.browser.click(&find).await;
    stage.browser.until("a dialog", DIALOG).await;
}

async fn words(stage: &mut Stage, of: &str) -> String {
    stage.browser.js(&format!("{of}.innerText")).await.as_str().unwrap().to_owned()
}

async fn looks_right(stage: &mut Stage, name: &str) {
    for (width, scheme) in [(1280, "light"), (390, "dark")] {
        stage.browser.size(width, 844).await;
        stage.browser.prefers(scheme).await;
        assert_eq!(complaints(&mut stage.browser).await, Vec::<String>::new(), "{name} {width} {scheme}");
        assert_eq!(overflow(&mut stage.browser).await, Vec::<String>::new(), "{name} {width} {scheme}");
        stage.picture(&format!("bulk-{name}-{width}-{scheme}")).await;
    }
    stage.browser.size(1280, 900).await;
}

#[tokio::test]
async fn all_24_robots_shown_are_held_after_a_dry_run_and_their_progress_is_shown() {
    let (mut stage, _robots) = many().await;
    stage.open("#/fleets/f?label=hall%3D2").await;
    press(&mut stage, "Hold 24 robots").await;
    let text = words(&mut stage, DIALOG).await;
    for part in ["Hold 24 robots", "f, many-000", "f, many-023", "Pressures do not change"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    assert!(!text.contains("f, r\n"), "robot r has no such label: {text}");
    looks_right(&mut stage, "dialog").await;
    stage.browser.js(&format!("{DIALOG}.querySelector('textarea').value = 'work in hall 2'")).await;
    stage.browser.js(&format!("{DIALOG}.querySelector('form').requestSubmit()")).await;
    let notice = "document.getElementById('notices').textContent";
    stage.browser.until("all are done", &format!("{notice}.includes(': 24 done')")).await;
    let (_, robots) = try_get(stage.service.http, "/v1/robots?held=true&limit=1000").await.unwrap();
    let robots: Value = serde_json::from_str(&robots).unwrap();
    assert_eq!(robots["items"].as_array().unwrap().len(), ROBOTS);
    // The same question again finds nothing more to hold.
    press(&mut stage, "Hold 24 robots").await;
    assert!(words(&mut stage, DIALOG).await.contains("Hold no robots"));
    stage.browser.press("Escape").await;
    // A whisker of a held robot cannot be released alone, and the page says so.
    stage.open("#/whiskers?label=hall&q=many-003").await;
    stage.browser.until("the page", "document.querySelector('h1').textContent === 'Whiskers'").await;
    press(&mut stage, "Release 2 whiskers").await;
    assert!(words(&mut stage, DIALOG).await.contains("Release 2 whiskers"));
    stage.browser.js(&format!("{DIALOG}.querySelector('form').requestSubmit()")).await;
    stage.browser.until("they are refused", &format!("{notice}.includes('0 of 2 done, 2 refused: ROBOT_HELD')")).await;
    looks_right(&mut stage, "whiskers").await;
    stage.open("#/audit").await;
    stage.browser.click("document.querySelector('main .links a')").await;
    stage.browser.until("the list", "document.querySelectorAll('main tbody tr').length === 2").await;
    looks_right(&mut stage, "list").await;
    stage.browser.click("document.querySelector('main tbody a')").await;
    stage.browser.until("the request", "document.querySelector('h1').textContent.startsWith('Action ')").await;
    stage.browser.until("its subjects", "document.querySelectorAll('main tbody tr').length === 3").await;
    let text = words(&mut stage, "document.querySelector('main')").await;
    for part in ["release many whiskers", "0 of 2 done, 2 refused", "ROBOT_HELD", "label: hall"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    looks_right(&mut stage, "one").await;
    stage.is_clean();
    stage.stop().await;
}

/// Presses a button of the page that opens a dialog, checks the dry run, fills the dialog in with a script, and confirms.
async fn confirm(stage: &mut Stage, button: &str, parts: &[&str], script: &str, picture: &str) {
    press(stage, button).await;
    let text = words(stage, DIALOG).await;
    for part in parts {
        assert!(text.contains(part), "{part}: {text}");
    }
    looks_right(stage, picture).await;
    stage.browser.js(script).await;
    stage.browser.js(&format!("{DIALOG}.querySelector('form').requestSubmit()")).await;
    let notice = "document.getElementById('notices').textContent";
    stage.browser.until("all are done", &format!("{notice}.includes(': 2 done')")).await;
    stage.browser.js("document.querySelectorAll('#notices button').forEach((one) => one.click())").await;
}

async fn read(stage: &Stage, path: &str) -> Value {
    let (status, text) = try_get(stage.service.http, path).await.unwrap();
    assert_eq!(status, 200, "{text}");
    serde_json::from_str(&text).unwrap()
}

#[tokio::test]
async fn a_policy_and_a_calibration_are_set_in_all_fleets_after_a_dry_run() {
    let (mut stage, _robot) = Stage::of_two_fleets().await;
    stage.open("#/policy").await;
    let heads = "[...document.querySelectorAll('h2')].map((one) => one.textContent).join()";
    stage.browser.until("both fleets", &format!("{heads} === 'Fleet f,Fleet g'")).await;
    press(&mut stage, "Change the policy of all fleets").await;
    assert!(read(&stage, "/v1/audit?kind=POLICIES").await["items"].as_array().unwrap().is_empty(), "only a dry run");
    stage.browser.press("Escape").await;
    stage.browser.until("no dialog", &format!("!{DIALOG}")).await;
    let parts = ["Change the policy of 2 fleets", "f\n", "g\n", "still wait for approval"];
    let advise = format!("{DIALOG}.querySelector('[name=mode]').value = 'ADVISE'");
    confirm(&mut stage, "Change the policy of all fleets", &parts, &advise, "policies").await;
    for fleet in ["f", "g"] {
        assert_eq!(read(&stage, &format!("/v1/fleets/{fleet}/policy")).await["mode"], "ADVISE", "{fleet}");
    }

    let model = read(&stage, "/v1/whiskers?fleet=g").await["items"][0]["model"].as_str().unwrap().to_owned();
    stage.open("#/calibrations").await;
    upload(&mut stage, &model, READINGS).await;
    let heading = format!("document.querySelector('h1').textContent === 'Calibration {model}, version 1'");
    stage.browser.until("the calibration", &heading).await;
    let uses = "[...document.querySelectorAll('tr[data-key^=use-]')].map((one) => one.innerText)";
    stage
        .browser
        .until("both fleets", &format!("{uses}.filter((one) => one.includes('not active')).length === 2"))
        .await;
    let parts = ["Activate in 2 fleets", "f\n", "g\n", "baselines are relearned"];
    confirm(&mut stage, "Activate in all fleets", &parts, "null", "calibrations").await;
    stage.browser.until("active in both", &format!("!{uses}.some((one) => one.includes('not active'))")).await;
    let requests = read(&stage, "/v1/bulk-actions").await;
    let kinds: Vec<&Value> = requests["items"].as_array().unwrap().iter().map(|one| &one["kind"]).collect();
    assert_eq!(kinds, ["CALIBRATIONS", "POLICIES"]);
    stage.is_clean();
    stage.stop().await;
}
