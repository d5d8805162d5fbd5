//! Every page is readable on a phone, in dark colours, and with a screen reader.

use serde_json::json;
use vibrissa_protocol::SetpointOutcome;

use crate::checks::{complaints, least_contrast, overflow};
use crate::stage::Stage;

async fn with_a_compensation() -> Stage {
    let mut stage = Stage::start().await;
    stage.cut().await;
    let (setpoint, _) = stage.robot.setpoint().await;
    stage.robot.answer(&setpoint, SetpointOutcome::Applied, None).await;
    stage.robot.touch(setpoint.whisker, 400).await;
    stage.robot.receipted().await;
    stage
}

#[tokio::test]
async fn every_page_is_readable_in_light_and_dark() {
    let mut stage = with_a_compensation().await;
    for scheme in ["light", "dark"] {
        stage.browser.prefers(scheme).await;
        let mut least = f64::INFINITY;
        for (name, hash) in stage.pages().await {
            stage.open(&hash).await;
            assert_eq!(complaints(&mut stage.browser).await, Vec::<String>::new(), "{name}, {scheme}");
            least = least.min(least_contrast(&mut stage.browser).await);
            stage.picture(&format!("{name}-{scheme}")).await;
        }
        println!("least contrast of text, {scheme}: {least:.2}");
        let brightness = "getComputedStyle(document.body).backgroundColor.match(/\\d+/g).slice(0, 3).reduce((sum, one) => sum + Number(one), 0)";
        let is_dark = stage.browser.js(brightness).await.as_f64().unwrap() < 200.0;
        assert_eq!(is_dark, scheme == "dark");
    }
    stage.stop().await;
}

#[tokio::test]
async fn no_page_is_wider_than_a_phone() {
    let mut stage = with_a_compensation().await;
    stage.browser.size(360, 740).await;
    for (name, hash) in stage.pages().await {
        stage.open(&hash).await;
        assert_eq!(overflow(&mut stage.browser).await, Vec::<String>::new(), "{name}");
        stage.picture(&format!("{name}-phone")).await;
    }
    stage.stop().await;
}

#[tokio::test]
async fn the_drawing_is_to_scale_and_its_whiskers_are_links() {
    let mut stage = with_a_compensation().await;
    stage.open("#/fleets/f/robots/r").await;
    let heights =
        "[...document.querySelectorAll('svg.drawing .whole')].map((one) => Math.round(one.getBBox().height * 10) / 10)";
    assert_eq!(stage.browser.js(heights).await, json!([70, 68, 65]));
    let cut = stage.browser.js("document.querySelector('svg.drawing .body').getBBox().height").await.as_f64().unwrap();
    assert!((cut - 65.0).abs() < 1.5, "{cut}");
    let links = "[...document.querySelectorAll('svg.drawing a')].map((one) => one.getAttribute('href'))";
    let address = |whisker| format!("#/fleets/f/robots/r/arrays/left/whiskers/{whisker}");
    assert_eq!(stage.browser.js(links).await, json!([address(0), address(1), address(2)]));
    let marks = stage.browser.js("document.querySelector(\"tr[data-key='whisker-left-0'] .marks\").innerText").await;
    assert!(marks.as_str().unwrap().contains("trimmed, compensated"), "{marks}");
    assert_eq!(stage.browser.js("document.querySelectorAll('svg.drawing .refused').length").await, json!(0));
    let arrows = stage.browser.js("document.querySelectorAll('svg.drawing .arrow').length").await;
    assert_eq!(arrows, json!(1));
    stage.stop().await;
}
