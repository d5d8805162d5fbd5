//! Labels in the console: set and removed on the page of a robot, shown in the list, and filtered by the address.

use serde_json::json;

use crate::checks::{complaints, overflow};
use crate::stage::Stage;

const DIALOG: &str = "document.querySelector('dialog[open]')";

async fn press(stage: &mut Stage, button: &str) {
    let find =
        format!("[...document.querySelectorAll('main button')].find((one) => one.textContent.startsWith('{button}'))");
    stage.browser.click(&find).await;
    stage.browser.until("a dialog", DIALOG).await;
}

async fn send(stage: &mut Stage, values: &[(&str, &str)]) {
    for (name, value) in values {
        stage.browser.js(&format!("{DIALOG}.querySelector('[name={name}]').value = {}", json!(value))).await;
    }
    stage.browser.js(&format!("{DIALOG}.querySelector('form').requestSubmit()")).await;
    stage.browser.until("the dialog is closed", &format!("!{DIALOG}")).await;
}

#[tokio::test]
async fn labels_are_set_shown_filtered_by_the_address_and_removed() {
    let mut stage = Stage::start().await;
    stage.open("#/fleets/f/robots/r").await;
    for (key, value) in [("hall", "2"), ("line", "north wing")] {
        press(&mut stage, "Set a label").await;
        send(&mut stage, &[("key", key), ("value", value)]).await;
        let shown = format!("document.querySelector('.of-labels').textContent.includes('{key}={value}')");
        stage.browser.until("the label", &shown).await;
    }
    for (width, scheme) in [(1280, "light"), (390, "dark")] {
        stage.browser.size(width, 844).await;
        stage.browser.prefers(scheme).await;
        for (name, hash) in [("robot", "#/fleets/f/robots/r"), ("fleet", "#/fleets/f?label=hall%3D2")] {
            stage.open(hash).await;
            stage.browser.until("the labels", "document.querySelectorAll('main .label').length === 2").await;
            assert_eq!(complaints(&mut stage.browser).await, Vec::<String>::new(), "{name} {width} {scheme}");
            assert_eq!(overflow(&mut stage.browser).await, Vec::<String>::new(), "{name} {width} {scheme}");
            stage.picture(&format!("labels-{name}-{width}-{scheme}")).await;
        }
    }
    // Another value finds nothing, and the field shows the filter of the address.
    stage.open("#/fleets/f?label=hall%3D3").await;
    stage.browser.until("no robot", "document.querySelector('main').textContent.includes('No robots match.')").await;
    assert_eq!(stage.browser.js("document.querySelector('#filter-label').value").await, json!("hall=3"));
    stage.open("#/whiskers?label=hall").await;
    stage.browser.until("its whiskers", "document.querySelectorAll('tbody tr').length === 3").await;
    stage.open("#/fleets/f/robots/r").await;
    press(&mut stage, "Remove a label").await;
    send(&mut stage, &[("key", "hall")]).await;
    stage.browser.until("one label", "document.querySelectorAll('.of-labels .label').length === 1").await;
    stage.is_clean();
    stage.stop().await;
}
