//! The panel of the demo, by which a newcomer lets incidents happen to simulated whiskers.

use serde_json::Value;
use vibrissa_tests::demo::LiveDemo;

use crate::advising::button;
use crate::browser::Browser;
use crate::checks::{complaints, overflow};
use crate::stage::Stage;

const PROGRAM: &str = env!("CARGO_BIN_EXE_lab-under-test");
const ROBOT: &str = "#/fleets/demo/robots/crawler-1";
const NAMES: [&str; 6] = ["Cut 5 mm", "Cut 22 mm", "Wear off", "Leak", "Heat by 10 K", "Replace"];

pub(crate) async fn press(browser: &mut Browser, name: &str, notice: &str) {
    browser.until(name, &button(name)).await;
    browser.js(&format!("{}.focus()", button(name))).await;
    browser.press("Enter").await;
    browser.until(notice, &format!("document.getElementById('notices').innerText.includes('{notice}')")).await;
}

pub(crate) fn picture(name: &str, width: u32, scheme: &str) -> Option<std::path::PathBuf> {
    let folder = std::env::var_os("VIBRISSA_PICTURES")?;
    Some(std::path::Path::new(&folder).join(format!("{name}-{width}-{scheme}.png")))
}

#[tokio::test(flavor = "multi_thread")]
async fn a_whisker_of_the_demo_is_cut_and_replaced_by_buttons() {
    let mut demo = LiveDemo::start(PROGRAM).await;
    let mut browser = Browser::start().await;
    browser.open(&format!("http://{}/{ROBOT}", demo.http)).await;
    browser.js("document.getElementById('demo-whisker').value = '2'").await;
    press(&mut browser, "Cut 5 mm", "Crawler-1/left/2 is cut by 5 mm to 65.0 mm.").await;
    demo.item("/v1/trims?robot=crawler-1&array=left&whisker=2", |_| true).await;
    let applied = |one: &Value| one["setpoint_state"] == "APPLIED";
    demo.item("/v1/compensations?robot=crawler-1&array=left&target_whisker=2", applied).await;
    browser.until("the cut is shown", "document.querySelector('main').innerText.includes('rimmed')").await;
    let chosen = browser.js("document.getElementById('demo-whisker').value").await;
    assert_eq!(chosen, "2", "the choice stays while the page is updated");

    for (width, scheme) in [(390, "light"), (1280, "dark"), (1920, "light")] {
        browser.size(width, 900).await;
        browser.prefers(scheme).await;
        for (name, hash) in [("demo-robot", ROBOT), ("demo-whisker", &format!("{ROBOT}/arrays/left/whiskers/2"))] {
            browser.open(&format!("http://{}/{hash}", demo.http)).await;
            browser.until("the panel", &button(NAMES[5])).await;
            assert_eq!(complaints(&mut browser).await, Vec::<String>::new(), "{name} {width} {scheme}");
            assert_eq!(overflow(&mut browser).await, Vec::<String>::new(), "{name} {width} {scheme}");
            if let Some(path) = picture(name, width, scheme) {
                browser.picture(&path).await;
            }
        }
    }
    press(&mut browser, "Replace", "Crawler-1/left/2 is new, and reported as replaced.").await;
    let learning = |one: &Value| one["whisker"] == 2 && one["condition"] == "LEARNING";
    demo.item("/v1/whiskers?robot=crawler-1&array=left", learning).await;
    press(&mut browser, "Heat by 10 K", "have 34.0").await;
    assert_eq!(browser.problems(), Vec::<String>::new());
    demo.type_line("quit");
    assert!(demo.ended().await.success());
}

#[tokio::test]
async fn other_services_have_no_panel() {
    let mut stage = Stage::start().await;
    for hash in ["#/fleets/f/robots/r", "#/fleets/f/robots/r/arrays/left/whiskers/1"] {
        stage.open(hash).await;
        for name in NAMES {
            assert_eq!(stage.browser.js(&format!("{} ?? null", button(name))).await, Value::Null, "{hash}: {name}");
        }
    }
    stage.stop().await;
}
