//! Changes appear without a reload.

use serde_json::json;
use vibrissa_protocol::SetpointOutcome;

use crate::stage::Stage;

const WHISKER: &str = "#/fleets/f/robots/r/arrays/left/whiskers/0";

#[tokio::test]
async fn a_trim_its_compensation_and_its_setpoint_appear_on_the_whiskers_page() {
    let mut stage = Stage::start().await;
    stage.open(WHISKER).await;
    let says = |words: &str| format!("document.querySelector('main').innerText.includes('{words}')");
    stage.browser.until("it is healthy", &says("healthy")).await;
    assert_eq!(stage.browser.js(&says("trimmed")).await, json!(false));
    // A reload would clear this variable.
    stage.browser.js("window.untouched = document.querySelector('h1')").await;

    stage.cut().await;
    stage.browser.until("the trim is shown", &says("trimmed")).await;
    // The event may appear on the page before the whisker itself is requested again.
    let length = "Math.abs(parseFloat(document.getElementById('length').textContent) - 65) < 1.5";
    stage.browser.until("the length that is left is shown", length).await;

    let (setpoint, _) = stage.robot.setpoint().await;
    stage.robot.answer(&setpoint, SetpointOutcome::Applied, None).await;
    let pressure = format!("{:.4}", setpoint.pressure_mpa);
    stage.browser.click("document.querySelector('.tabs a[href*=\"tab=history\"]')").await;
    let row = format!(
        "[...document.querySelectorAll('section[aria-labelledby=part-setpoints] tbody tr')].some((row) => \
         row.innerText.includes('{pressure}') && row.innerText.includes('applied'))"
    );
    stage.browser.until("the setpoint is applied", &row).await;
    stage.browser.click("document.querySelector('.tabs a[href*=\"tab=decisions\"]')").await;
    let chosen =
        "[...document.querySelectorAll('.alternatives > li')].filter((row) => row.innerText.includes('chosen')).length";
    stage.browser.until("a candidate was chosen", &format!("({chosen}) === 1")).await;
    assert_eq!(stage.browser.js("window.untouched === document.querySelector('h1')").await, json!(true));
    stage.is_clean();
    stage.stop().await;
}

#[tokio::test]
async fn a_service_that_is_gone_is_said_to_be_gone_and_what_was_seen_stays() {
    let mut stage = Stage::start().await;
    stage.open("#/fleets/f/robots/r").await;
    let state = "document.getElementById('connection').textContent";
    stage.browser.until("it is live", &format!("{state}.startsWith('live')")).await;
    let Stage { service, mut browser, .. } = stage;
    service.stop().await;
    browser.until("it is offline", &format!("{state}.startsWith('offline')")).await;
    assert_eq!(browser.js("document.querySelector('h1').textContent").await, "Robot r");
    assert_eq!(browser.js("document.getElementById('connection').getAttribute('aria-live')").await, "polite");
}

#[tokio::test]
async fn what_somebody_opened_and_focused_stays_so_when_news_come() {
    let mut stage = Stage::start().await;
    stage.cut().await;
    let (setpoint, _) = stage.robot.setpoint().await;
    stage.robot.answer(&setpoint, SetpointOutcome::Applied, None).await;
    stage.open(&format!("{WHISKER}?tab=history")).await;
    stage.browser.until("a history", "document.querySelector('main summary')").await;
    stage
        .browser
        .js("document.querySelector('main summary').click(); document.querySelector('main summary').focus()")
        .await;
    let shows = stage.browser.js("Number(main.dataset.shows)").await;
    stage.robot.touch(0, 40).await;
    stage.browser.until("it was looked at again", &format!("Number(main.dataset.shows) >= {shows} + 2")).await;
    let kept = "document.activeElement === document.querySelector('main summary') && document.querySelector('main details').open";
    assert_eq!(stage.browser.js(kept).await, json!(true));
    stage.stop().await;
}
