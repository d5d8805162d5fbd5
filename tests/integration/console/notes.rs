//! Notes in the console: added, shown as they were written, and removed on the page of a robot.

use serde_json::{Value, json};
use vibrissa_tests::web::try_get;

use crate::checks::{complaints, overflow};
use crate::stage::Stage;

pub(crate) const DIALOG: &str = "document.querySelector('dialog[open]')";
const NOTES: &str = "document.querySelectorAll('[aria-labelledby=part-notes] tbody tr')";

pub(crate) async fn press(stage: &mut Stage, button: &str) {
    let find =
        format!("[...document.querySelectorAll('main button')].find((one) => one.textContent.startsWith('{button}'))");
    stage.browser.click(&find).await;
    stage.browser.until("a dialog", DIALOG).await;
}

pub(crate) async fn send(stage: &mut Stage) {
    stage.browser.js(&format!("{DIALOG}.querySelector('form').requestSubmit()")).await;
    stage.browser.until("the dialog is closed", &format!("!{DIALOG}")).await;
}

async fn notes(stage: &Stage) -> Vec<Value> {
    let (_, text) = try_get(stage.service.http, "/v1/fleets/f/robots/r/notes").await.unwrap();
    serde_json::from_str::<Value>(&text).unwrap()["items"].as_array().unwrap().clone()
}

#[tokio::test]
async fn notes_are_added_shown_as_they_were_written_and_removed() {
    let mut stage = Stage::start().await;
    stage.open("#/fleets/f/robots/r").await;
    stage.browser.until("no notes", "document.querySelector('main').textContent.includes('No notes.')").await;
    let texts =
        ["Hose replaced.\nSee <b>ticket</b> & <img src=x onerror=\"document.title='run'\">", "Left array: keep"];
    for (number, text) in texts.iter().enumerate() {
        press(&mut stage, "Add a note").await;
        stage.browser.js(&format!("{DIALOG}.querySelector('textarea').value = {}", json!(text))).await;
        send(&mut stage).await;
        stage.browser.until("the note", &format!("{NOTES}.length === {}", number + 1)).await;
    }
    let shown = stage.browser.js(&format!("[...{NOTES}].map((one) => one.querySelector('.note').textContent)")).await;
    assert_eq!(shown, json!([texts[1], texts[0]]), "the newest first, and no markup");
    assert_eq!(stage.browser.js("document.querySelectorAll('.note *').length").await, json!(0));
    let stored = notes(&stage).await;
    let row = stage.browser.js(&format!("{NOTES}[0].innerText")).await.as_str().unwrap().to_owned();
    assert!(row.contains(stored[0]["author"].as_str().unwrap()), "{row}");
    let written = stage.browser.js(&format!("{NOTES}[0].querySelector('time').dateTime")).await;
    assert_eq!(written, stored[0]["written_at"]);
    for (width, scheme) in [(1280, "light"), (390, "dark")] {
        stage.browser.size(width, 844).await;
        stage.browser.prefers(scheme).await;
        for hash in ["#/fleets/f/robots/r", "#/audit"] {
            stage.open(hash).await;
            assert_eq!(complaints(&mut stage.browser).await, Vec::<String>::new(), "{hash} {width} {scheme}");
            assert_eq!(overflow(&mut stage.browser).await, Vec::<String>::new(), "{hash} {width} {scheme}");
        }
    }
    stage.browser.size(1280, 844).await;
    stage.open("#/fleets/f/robots/r").await;
    press(&mut stage, "Remove \u{2026}").await;
    let dialog = stage.browser.js(&format!("{DIALOG}.innerText")).await.as_str().unwrap().to_owned();
    assert!(dialog.contains(texts[1]), "{dialog}");
    send(&mut stage).await;
    stage.browser.until("one note", &format!("{NOTES}.length === 1")).await;
    assert_eq!(notes(&stage).await, [stored[1].clone()]);
    stage.is_clean();
    stage.stop().await;
}
