//! The tour: three steps from the board to a decision, which ends with Escape and is remembered.

use serde_json::json;

use crate::checks::{complaints, overflow};
use crate::stage::Stage;

const TOUR: &str = "document.getElementById('tour')";

/// Waits until the tour shows a step.
async fn step(stage: &mut Stage, number: u32) {
    let shown = format!("!{TOUR}.hidden && {TOUR}.textContent.includes('step {number} of 3')");
    stage.browser.until(&format!("step {number}"), &shown).await;
}

/// Presses the first button of the tour by the keyboard.
async fn go_on(stage: &mut Stage) {
    stage.browser.js(&format!("{TOUR}.querySelector('button').focus()")).await;
    stage.browser.press("Enter").await;
}

#[tokio::test]
async fn three_steps_lead_from_the_board_over_the_worst_whisker_to_its_decision() {
    let mut stage = Stage::start().await;
    stage.open("#/fleets").await;
    stage.browser.click("document.getElementById('tour-button')").await;
    step(&mut stage, 1).await;
    go_on(&mut stage).await;
    stage.browser.until("nothing is cut yet", &format!("{TOUR}.textContent.includes('No whisker is cut')")).await;
    stage.cut().await;
    for (width, scheme) in [(1280, "light"), (390, "dark")] {
        stage.browser.size(width, 844).await;
        stage.browser.prefers(scheme).await;
        assert_eq!(complaints(&mut stage.browser).await, Vec::<String>::new(), "{width} {scheme}");
        assert_eq!(overflow(&mut stage.browser).await, Vec::<String>::new(), "{width} {scheme}");
        stage.picture(&format!("tour-{width}-{scheme}")).await;
    }
    go_on(&mut stage).await;
    step(&mut stage, 2).await;
    stage.browser.until("the story", "document.querySelector('h1').textContent === 'Whisker left 0 of r'").await;
    // A reload keeps the step.
    stage.browser.js("void (window.old = true)").await;
    stage.browser.call("Page.reload", json!({})).await;
    stage.browser.until("the page again", "!window.old && document.getElementById('story')").await;
    step(&mut stage, 2).await;
    go_on(&mut stage).await;
    step(&mut stage, 3).await;
    stage
        .browser
        .until("the decision", "document.querySelector('h1').textContent.startsWith('Compensation for')")
        .await;
    go_on(&mut stage).await;
    stage.browser.until("the end", &format!("{TOUR}.hidden")).await;
    stage.is_clean();
    stage.stop().await;
}

#[tokio::test]
async fn an_installation_without_robots_is_offered_the_tour_once_and_escape_ends_it() {
    let mut stage = Stage::without_robots().await;
    stage.open("#/fleets").await;
    step(&mut stage, 1).await;
    stage.browser.press("Escape").await;
    stage.browser.until("the end", &format!("{TOUR}.hidden")).await;
    stage.browser.js("void (window.old = true)").await;
    stage.browser.call("Page.reload", json!({})).await;
    let shown = "!window.old && document.getElementById('main')?.dataset.shows >= 1";
    stage.browser.until("the page again", shown).await;
    assert_eq!(stage.browser.js("localStorage.getItem('vibrissa-tour')").await, "ended");
    assert_eq!(stage.browser.js(&format!("{TOUR}.hidden")).await, true);
    stage.is_clean();
    stage.stop().await;
}
