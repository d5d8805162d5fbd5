//! Nothing on a page scrolls sideways, from a phone to a large screen.

use vibrissa_protocol::{ArrayType, SetpointOutcome};
use vibrissa_tests::robot::{HandRobot, array};

use crate::checks::{overflow, sideways};
use crate::stage::Stage;

const WIDTHS: [u32; 8] = [360, 390, 768, 1024, 1280, 1440, 1920, 2560];

#[tokio::test]
async fn nothing_scrolls_sideways_at_any_width() {
    let mut stage = Stage::start().await;
    stage.cut().await;
    let (setpoint, _) = stage.robot.setpoint().await;
    stage.robot.answer(&setpoint, SetpointOutcome::Applied, None).await;
    stage.robot.touch(setpoint.whisker, 400).await;
    stage.robot.receipted().await;
    // An array that is wider than most screens.
    let mut wide = HandRobot::born(stage.service.broker.port, "wide", array(ArrayType::Type1, &[70.0; 24])).await;
    wide.touch(23, 20).await;
    wide.receipted().await;
    let mut pages = stage.pages().await;
    pages.push(("wide", "#/fleets/f/robots/wide".to_owned()));
    for width in WIDTHS {
        stage.browser.size(width, 900).await;
        for (name, hash) in &pages {
            stage.open(hash).await;
            assert_eq!(sideways(&mut stage.browser).await, Vec::<String>::new(), "{name} at {width} px");
            assert_eq!(overflow(&mut stage.browser).await, Vec::<String>::new(), "{name} at {width} px");
            if [390, 1920].contains(&width) {
                stage.picture(&format!("{name}-{width}")).await;
            }
        }
    }
    stage.is_clean();
    stage.stop().await;
}

#[tokio::test]
async fn a_wide_array_is_drawn_completely_on_a_phone_and_again_when_the_window_grows() {
    let mut stage = Stage::start().await;
    let mut wide = HandRobot::born(stage.service.broker.port, "wide", array(ArrayType::Type1, &[70.0; 24])).await;
    wide.touch(23, 20).await;
    wide.receipted().await;
    stage.browser.size(360, 740).await;
    stage.open("#/fleets/f/robots/wide").await;
    let whiskers = "document.querySelectorAll('svg.drawing .whisker').length === 24";
    stage.browser.until("all whiskers", whiskers).await;
    let rows = "document.querySelectorAll('svg.drawing').length";
    assert!(stage.browser.js(rows).await.as_u64().unwrap() >= 3, "several rows");
    // The smallest text is at least 10 px high.
    let scale = "document.querySelector('svg.drawing').getScreenCTM().a * 4.6";
    assert!(stage.browser.js(scale).await.as_f64().unwrap() > 10.0);
    stage.browser.size(1920, 900).await;
    stage.browser.until("fewer rows", &format!("{rows} <= 2 && {whiskers}")).await;
    stage.stop().await;
}
