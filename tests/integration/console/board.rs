//! The board of robots: all of them on one screen, the worst whisker first, and how many alarms are open.

use serde_json::json;
use vibrissa_core::policy::Mode;

use crate::axe;
use crate::checks::{complaints, overflow, sideways};
use crate::stage::Stage;

/// Robots of the crowd, besides robot `r`.
const CROWD: u32 = 999;
/// Robots that are too many for tiles.
const TOO_MANY: u32 = 2_001;

const TILES: &str = "document.querySelectorAll('.tiles a.tile').length";

/// Opens the worst whisker with one click.
async fn opens_the_worst(stage: &mut Stage) {
    stage.browser.click("document.querySelector('.worst a')").await;
    let led = "document.querySelector('h1').textContent === 'Whisker left 0 of r'";
    stage.browser.until("the worst whisker", led).await;
}

#[tokio::test]
async fn a_thousand_robots_are_on_one_screen_and_the_worst_whisker_is_one_click_away() {
    let mut stage = Stage::start().await;
    stage.cut().await;
    stage.crowd(CROWD).await;
    stage.browser.size(1920, 1080).await;
    stage.open("#/fleets?by=hall").await;
    assert_eq!(stage.browser.js(TILES).await, json!(CROWD + 1));
    let groups = "document.querySelectorAll('.tile-groups h2').length";
    assert_eq!(stage.browser.js(groups).await, 11, "ten halls, and the robot without a label");
    let boxes = "[...document.querySelectorAll('.tiles a.tile')].map((one) => one.getBoundingClientRect())";
    let seen = format!("{boxes}.every((one) => one.bottom <= innerHeight && one.width >= 24 && one.height >= 24)");
    assert_eq!(stage.browser.js(&seen).await, true, "each tile is seen without scrolling, and a finger can press it");
    let worst = "document.querySelector('.worst a').getBoundingClientRect().bottom <= innerHeight";
    assert_eq!(stage.browser.js(worst).await, true);
    assert_eq!(complaints(&mut stage.browser).await, Vec::<String>::new());
    stage.picture("board-1000-1920").await;
    for (width, height) in [(1280, 900), (390, 844)] {
        stage.browser.size(width, height).await;
        stage.open("#/fleets").await;
        assert_eq!(stage.browser.js(TILES).await, json!(CROWD + 1));
        assert_eq!(overflow(&mut stage.browser).await, Vec::<String>::new(), "{width}");
        assert_eq!(sideways(&mut stage.browser).await, Vec::<String>::new(), "{width}");
        assert_eq!(stage.browser.js(worst).await, true, "{width}: the worst whisker is on the first screen");
        stage.picture(&format!("board-1000-{width}")).await;
    }
    opens_the_worst(&mut stage).await;
    stage.is_clean();
    stage.stop().await;
}

#[tokio::test]
async fn very_many_robots_fold_into_groups_and_a_state_names_them() {
    let mut stage = Stage::start().await;
    stage.cut().await;
    stage.crowd(TOO_MANY).await;
    stage.open("#/fleets?by=hall").await;
    assert_eq!(stage.browser.js(TILES).await, 0);
    assert_eq!(stage.browser.js("document.querySelectorAll('.folded > li').length").await, 11);
    assert_eq!(complaints(&mut stage.browser).await, Vec::<String>::new());
    stage.picture("board-folded").await;
    // Few robots are in this state, and each of them has a tile again.
    let chip =
        "[...document.querySelectorAll('.chip')].find((one) => one.textContent.includes('trimmed, compensated'))";
    stage.browser.click(chip).await;
    stage.browser.until("the tile", &format!("{TILES} === 1")).await;
    assert_eq!(stage.browser.js("document.querySelector('.chip[aria-current] strong').textContent").await, "1");
    stage.open("#/fleets?by=hall").await;
    stage.browser.click("document.querySelector('.folded h2 a')").await;
    stage.browser.until("the robots of a hall", &format!("{TILES} === 201 || {TILES} === 200")).await;
    stage.open("#/fleets").await;
    opens_the_worst(&mut stage).await;
    stage.is_clean();
    stage.stop().await;
}

#[tokio::test]
async fn arrow_keys_move_between_the_tiles_which_are_one_stop_of_tab() {
    let mut stage = Stage::start().await;
    stage.crowd(99).await;
    stage.open("#/fleets").await;
    stage.browser.until("all tiles", &format!("{TILES} === 100")).await;
    assert_eq!(stage.browser.js("document.querySelectorAll('.tiles a.tile[tabindex=\"0\"]').length").await, 1);
    stage.browser.js("document.querySelector('.tiles a.tile').focus()").await;
    let at = "[...document.querySelectorAll('.tiles a.tile')].indexOf(document.activeElement)";
    for (key, expected) in [("ArrowRight", 1), ("ArrowRight", 2), ("ArrowLeft", 1), ("End", 99), ("Home", 0)] {
        stage.browser.press(key).await;
        assert_eq!(stage.browser.js(at).await, expected, "{key}");
    }
    stage.browser.press("Enter").await;
    stage.browser.until("its page", "document.querySelector('h1').textContent === 'Robot more-1'").await;
    stage.is_clean();
    stage.stop().await;
}

#[tokio::test]
async fn open_alarms_are_counted_in_the_menu_and_in_the_title_of_the_window() {
    // A proposal raises an alarm.
    let mut stage = Stage::with(|params| params.policy.mode = Mode::Advise).await;
    stage.open("#/whiskers").await;
    assert_eq!(stage.browser.js("document.title").await, "Whiskers \u{2013} vibrissa");
    assert_eq!(stage.browser.js("document.querySelector('#nav .count')").await, json!(null));
    stage.cut().await;
    stage.browser.until("the title", "document.title === '(1) Whiskers \u{2013} vibrissa'").await;
    let menu = "[...document.querySelectorAll('#nav a')].find((one) => one.hash === '#/alarms').innerText.trim()";
    assert_eq!(
        stage.browser.js(menu).await.as_str().unwrap().split_whitespace().collect::<Vec<_>>()[..2],
        ["Alarms", "1"]
    );
    stage.is_clean();
    stage.stop().await;
}

#[tokio::test]
async fn the_header_of_a_phone_is_one_row_that_stays() {
    let mut stage = Stage::start().await;
    stage.cut().await;
    stage.browser.size(390, 844).await;
    stage.open("#/fleets/f/robots/r").await;
    let header = "document.querySelector('.top').getBoundingClientRect()";
    let height = stage.browser.js(&format!("{header}.height")).await.as_f64().unwrap();
    assert!(height <= 56.0, "{height} px");
    stage.browser.js("scrollTo(0, document.documentElement.scrollHeight)").await;
    assert_eq!(stage.browser.js("scrollY > 500").await, true);
    assert_eq!(stage.browser.js(&format!("{header}.top")).await, 0);
    let state = "(() => { const { top, bottom } = document.getElementById('connection').getBoundingClientRect(); \
                 return top >= 0 && bottom <= 56; })()";
    assert_eq!(stage.browser.js(state).await, true, "the connection is seen");
    // The menu opens, leads to a page, and closes.
    assert_eq!(stage.browser.js("document.getElementById('nav').checkVisibility()").await, false);
    stage.browser.click("document.getElementById('menu')").await;
    assert_eq!(stage.browser.js("document.getElementById('nav').checkVisibility()").await, true);
    assert_eq!(complaints(&mut stage.browser).await, Vec::<String>::new());
    stage.browser.press("Escape").await;
    assert_eq!(stage.browser.js("document.getElementById('nav').checkVisibility()").await, false);
    assert_eq!(stage.browser.js("document.activeElement.id").await, "menu");
    stage.browser.click("document.getElementById('menu')").await;
    stage.browser.click("document.querySelector('#nav a[href=\"#/alarms\"]')").await;
    stage.browser.until("the page", "document.querySelector('h1').textContent === 'Alarms'").await;
    assert_eq!(stage.browser.js("document.getElementById('nav').checkVisibility()").await, false);
    stage.is_clean();
    stage.stop().await;
}

#[tokio::test]
async fn axe_finds_nothing_on_boards_of_tiles_and_of_groups() {
    let Some(script) = axe::script() else { return };
    let mut stage = Stage::start().await;
    stage.cut().await;
    stage.crowd(TOO_MANY).await;
    for scheme in ["light", "dark"] {
        stage.browser.prefers(scheme).await;
        for hash in ["#/fleets", "#/fleets?by=hall", "#/fleets?by=hall&label=hall%3D2", "#/fleets/f", "#/design"] {
            stage.open(hash).await;
            assert_eq!(axe::violations(&mut stage.browser, &script).await, Vec::<String>::new(), "{hash} {scheme}");
        }
    }
    stage.stop().await;
}
