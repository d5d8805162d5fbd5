//! Tables are searched, filtered, sorted and paged by the service, and the address keeps all of it.

use serde_json::json;
use vibrissa_protocol::ArrayType;
use vibrissa_tests::robot::{HandRobot, array};

use crate::stage::Stage;

/// Rows of the shown table.
const NAMES: &str = "[...document.querySelectorAll('main tbody th')].map((cell) => cell.textContent)";

/// Robots of the fleet: more than one page shows.
const ROBOTS: usize = 55;
/// Rows of a page.
const ROWS: usize = 50;

/// A fleet of robots `r` (with learned whiskers) and `many-00` to `many-53`.
async fn crowded() -> Stage {
    let stage = Stage::start().await;
    for number in 0..ROBOTS - 1 {
        let name = format!("many-{number:02}");
        let mut robot = HandRobot::born(stage.service.broker.port, &name, array(ArrayType::Type2, &[70.0])).await;
        robot.touch(0, 1).await;
        robot.receipted().await;
    }
    stage
}

fn numbered(range: impl Iterator<Item = usize>) -> Vec<String> {
    range.map(|number| format!("many-{number:02}")).collect()
}

#[tokio::test]
async fn robots_are_searched_sorted_and_paged_and_a_reload_keeps_it() {
    let mut stage = crowded().await;
    stage.open("#/fleets/f?sort=robot").await;
    assert_eq!(stage.browser.js(NAMES).await, json!(numbered(0..ROWS)), "the first page");
    stage.browser.click("[...document.querySelectorAll('.pager a')].at(-1)").await;
    let mut last = numbered(ROWS..ROBOTS - 1);
    last.push("r".to_owned());
    stage.browser.until("the last page", &format!("JSON.stringify({NAMES}) === '{}'", json!(last))).await;
    assert_eq!(stage.browser.js("document.querySelectorAll('.pager a').length").await, json!(1), "no next page");
    stage.browser.js("history.back()").await;
    stage.browser.until("the first page", &format!("{NAMES}.length === {ROWS}")).await;

    // Typing searches at once, keeps the focus, and starts at the first page.
    stage.browser.js("document.getElementById('search').focus()").await;
    stage.browser.type_text("NY-1").await;
    let found = json!(numbered(10..20));
    stage.browser.until("the found robots", &format!("JSON.stringify({NAMES}) === '{found}'")).await;
    assert_eq!(stage.browser.js("document.activeElement.id").await, "search");
    assert_eq!(stage.browser.js("location.hash").await, "#/fleets/f?sort=robot&q=NY-1");

    // The heading turns the order round and says so to screen readers.
    let heading = "[...document.querySelectorAll('main thead th')].find((one) => one.textContent.startsWith('Robot'))";
    assert_eq!(stage.browser.js(&format!("{heading}.getAttribute('aria-sort')")).await, "ascending");
    stage.browser.click(&format!("{heading}?.querySelector('a')")).await;
    let reversed: Vec<String> = numbered(10..20).into_iter().rev().collect();
    let reversed = json!(reversed);
    stage.browser.until("the other order", &format!("JSON.stringify({NAMES}) === '{reversed}'")).await;
    assert_eq!(stage.browser.js(&format!("{heading}.getAttribute('aria-sort')")).await, "descending");

    stage.browser.js("void (window.old = true)").await;
    stage.browser.call("Page.reload", json!({})).await;
    let reloaded = format!("!window.old && JSON.stringify({NAMES}) === '{reversed}'");
    stage.browser.until("the same after a reload", &reloaded).await;
    assert_eq!(stage.browser.js("document.getElementById('search').value").await, "NY-1");

    // A search without results says so, and leads back.
    stage.open("#/fleets/f?q=nobody").await;
    let nothing = "[...document.querySelectorAll('main .empty')].at(-1).textContent";
    assert_eq!(stage.browser.js(nothing).await, "No robots match.");
    stage.browser.click("document.querySelector('.tools a')").await;
    stage.browser.until("all robots", &format!("{NAMES}.length === {ROWS}")).await;
    stage.is_clean();
    stage.stop().await;
}

#[tokio::test]
async fn whiskers_are_filtered_by_condition_and_views_are_saved() {
    let mut stage = Stage::start().await;
    stage.cut().await;
    stage.open("#/whiskers").await;
    stage.browser.until("all whiskers", &format!("{NAMES}.length === 3")).await;
    let choose = "{ const field = document.getElementById('filter-condition'); field.value = 'TRIMMED'; \
                  field.dispatchEvent(new Event('change')); }";
    stage.browser.js(choose).await;
    stage.browser.until("the trimmed one", &format!("JSON.stringify({NAMES}) === '[\"left 0\"]'")).await;
    assert_eq!(stage.browser.js("location.hash").await, "#/whiskers?condition=TRIMMED");

    stage.browser.js("document.querySelector('.saved').open = true").await;
    stage.browser.js("document.getElementById('view-name').focus()").await;
    stage.browser.type_text("Cut ones").await;
    stage.browser.press("Enter").await;
    let saved = "document.querySelector('.views a')?.textContent";
    stage.browser.until("the view is saved", &format!("{saved} === 'Cut ones'")).await;
    stage.open("#/whiskers").await;
    stage.browser.until("all whiskers", &format!("{NAMES}.length === 3")).await;
    stage.browser.click("document.querySelector('.views a')").await;
    stage.browser.until("the view", &format!("JSON.stringify({NAMES}) === '[\"left 0\"]'")).await;
    assert_eq!(stage.browser.js("document.getElementById('filter-condition').value").await, "TRIMMED");
    stage.browser.click("document.querySelector('.views button')").await;
    stage.browser.until("the view is deleted", "!document.querySelector('.views a')").await;
    stage.is_clean();
    stage.stop().await;
}
