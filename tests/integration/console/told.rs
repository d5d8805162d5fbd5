//! The programs of a robot on its page, and the state of a segmenter with advice on the whisker's page.

use vibrissa_core::units::Micros;
use vibrissa_protocol::{Segmenter, Software, SoftwareKind};
use vibrissa_tests::wait::until_true;
use vibrissa_tests::web::try_get;

use crate::stage::Stage;

#[tokio::test]
async fn programs_of_a_robot_and_the_state_of_its_segmenters_are_shown() {
    let mut stage = Stage::start().await;
    let says = |words: &str| format!("document.querySelector('main').innerText.includes('{words}')");
    stage.open("#/fleets/f/robots/r").await;
    stage.browser.until("the robot", &says("Array left")).await;
    let shown = stage.browser.js("document.querySelector('main').innerText").await;
    assert!(!shown.as_str().unwrap().contains("Programs"), "a robot that names none: {shown}");

    let (kind, name, version) = (SoftwareKind::Agent, "vibrissa-robot".to_owned(), "0.2.0".to_owned());
    stage.robot.software = vec![Software { kind, name, version }];
    stage.robot.segmenter = Some(Segmenter::Noisy);
    stage.robot.restart();
    stage.robot.birth().await;
    stage.robot.settle().await;
    let told = async |stage: &Stage| try_get(stage.service.http, "/v1/whiskers").await.unwrap().1.contains("NOISY");
    until_true("the state of a segmenter", async || told(&stage).await).await;
    stage.open("#/fleets/f/robots/r").await;
    stage.browser.until("its programs", &says("vibrissa-robot 0.2.0 (agent)")).await;
    stage.browser.until("its segmenters", &says("noisy strain")).await;

    stage.open("#/fleets/f/robots/r/arrays/left/whiskers/1").await;
    stage.browser.until("the state", &says("noisy strain")).await;
    stage.browser.until("the advice", &says("Check the wires and the supply of the converter")).await;
    stage.is_clean();
    stage.stop().await;
}

/// The words below the whiskers of a drawing stood over one another.
#[tokio::test]
async fn regress_the_words_below_silent_whiskers_stand_apart() {
    let mut stage = Stage::with(|params| params.health.stale_after = Micros::from_s(1.0)).await;
    stage.open("#/fleets/f/robots/r").await;
    let words = "[...document.querySelectorAll('.drawing text.state:nth-last-of-type(2)')]";
    let are_silent = format!("{words}.length === 3 && {words}.every((one) => one.textContent.includes('silent'))");
    stage.browser.until("silent whiskers", &are_silent).await;
    let boxes = format!("{words}.map((one) => one.getBoundingClientRect()).sort((a, b) => a.left - b.left)");
    let are_apart = format!("{boxes}.every((one, at, all) => at === 0 || all[at - 1].right < one.left)");
    assert_eq!(stage.browser.js(&are_apart).await, true);
    stage.is_clean();
    stage.stop().await;
}
