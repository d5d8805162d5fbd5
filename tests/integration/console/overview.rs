//! The overview of fleets, the page of questions "what if", calibrations, and keyboard shortcuts.

use serde_json::json;
use vibrissa_protocol::{ArrayType, SetpointOutcome};
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::web::ask;

use crate::checks::{complaints, overflow, sideways};
use crate::stage::Stage;

const CUT: &str = "#/what-if?fleet=f&robot=r&array=left&whisker=0&length_mm=64";

async fn with_a_compensation() -> Stage {
    let mut stage = Stage::start().await;
    stage.cut().await;
    let (setpoint, _) = stage.robot.setpoint().await;
    stage.robot.answer(&setpoint, SetpointOutcome::Applied, None).await;
    stage.robot.touch(setpoint.whisker, 400).await;
    stage.robot.receipted().await;
    let mut wide = HandRobot::born(stage.service.broker.port, "wide", array(ArrayType::Type1, &[70.0; 24])).await;
    wide.touch(23, 20).await;
    wide.receipted().await;
    stage
}

/// Readings that determine a curve.
pub(crate) const READINGS: &str = include_str!("../../../docs/calibration-example.csv");

/// Puts a file into the form and submits it.
pub(crate) async fn upload(stage: &mut Stage, model: &str, content: &str) {
    let script = format!(
        "(() => {{ const form = document.getElementById('upload'); \
         const data = new DataTransfer(); data.items.add(new File([{}], 'readings.csv')); \
         form.querySelector('[name=file]').files = data.files; \
         form.querySelector('[name=model]').value = '{model}'; form.requestSubmit(); }})()",
        json!(content)
    );
    stage.browser.js(&script).await;
}

#[tokio::test]
async fn the_board_shows_robots_errors_and_changes_with_links() {
    let mut stage = with_a_compensation().await;
    let overview = ask(stage.service.http, "GET", "/v1/overview", &[]).await.unwrap().json();
    for page in ["#/fleets", "#/fleets/f"] {
        stage.open(page).await;
        let links = "[...document.querySelectorAll('a.tile')].map((one) => one.getAttribute('href')).sort()";
        assert_eq!(stage.browser.js(links).await, json!(["#/fleets/f/robots/r", "#/fleets/f/robots/wide"]), "{page}");
        // Letter and colour of the robot with the cut whisker, and words that say the same.
        let tile = "document.querySelector('a.tile[href$=\"/r\"]')";
        assert_eq!(stage.browser.js(&format!("{tile}.querySelector('.letter').textContent")).await, "C", "{page}");
        let words = stage.browser.js(&format!("{tile}.title")).await;
        assert!(words.as_str().unwrap().contains("trimmed, compensated: 1 whisker"), "{page}: {words}");
        let counts = "[...document.querySelectorAll('.changes strong')].map((one) => Number(one.textContent))";
        let expected = ["trims", "alarms", "setpoints_applied", "whiskers_replaced"].map(|name| overview[name].clone());
        assert_eq!(stage.browser.js(counts).await, json!(expected), "{page}");
        let measured = "[...document.querySelectorAll('.histogram .many')].map((one) => one.textContent)";
        assert_eq!(stage.browser.js(measured).await, json!(["1"]), "{page}");
    }
    // Each number leads to as many rows.
    let targets = stage.browser.js("[...document.querySelectorAll('.changes a')].map((one) => one.hash)").await;
    let expected = [("trims", 0), ("setpoints_applied", 2)];
    for (name, at) in expected {
        stage.open(targets[at].as_str().unwrap()).await;
        let rows = "document.querySelectorAll('main tbody tr').length";
        assert_eq!(stage.browser.js(rows).await, overview[name], "{name}");
        assert_ne!(overview[name], 0, "{name}");
    }
    for at in [1, 3] {
        stage.open(targets[at].as_str().unwrap()).await;
        let chosen = "document.getElementById('filter-since').value";
        assert_eq!(stage.browser.js(chosen).await, "24h");
    }
    stage.is_clean();
    stage.stop().await;
}

#[tokio::test]
async fn a_question_what_if_is_in_the_address_and_shows_candidates_and_curve() {
    let mut stage = with_a_compensation().await;
    stage.open("#/fleets/f/robots/r/arrays/left/whiskers/0").await;
    stage.browser.click("document.querySelector('main a[href*=what-if]')").await;
    stage.browser.until("the question", "document.querySelector('h1').textContent === 'What if'").await;
    stage.open(CUT).await;
    let path = "/v1/fleets/f/robots/r/arrays/left/whiskers/0/what-if?length_mm=64";
    let answer = ask(stage.service.http, "GET", path, &[]).await.unwrap().json();
    let candidates = answer["decisions"][0]["candidates"].as_array().unwrap().len();
    assert!(candidates > 1, "{answer}");
    let rows = "document.querySelectorAll('[id^=part-candidates] + .table tbody tr').length";
    assert_eq!(stage.browser.js(rows).await, json!(candidates));
    // The objectives beside one another; the robot applies no gain, so the paper's is in force.
    let objectives = answer["by_objective"].as_array().unwrap();
    assert_eq!(objectives.len(), 3, "{answer}");
    let in_force: Vec<_> = objectives.iter().filter(|one| one["in_force"] == true).collect();
    assert!(in_force.len() == 1 && in_force[0]["objective"] == "TIP", "{answer}");
    let of = |objective: &str| objectives.iter().find(|one| one["objective"] == objective).unwrap();
    assert!(of("SHAPE")["predicted_error"].as_f64() < of("MEAN")["predicted_error"].as_f64(), "{answer}");
    assert!(of("SHAPE")["reading_gain"].is_f64() && of("TIP")["reading_gain"].is_null(), "{answer}");
    let rows = "[...document.querySelectorAll('main table')]\
                .find((one) => one.caption?.textContent.includes('Objectives of the policy'))?.tBodies[0].rows.length";
    assert_eq!(stage.browser.js(rows).await, json!(3));
    stage.browser.until("the curve", "document.querySelector('what-if-chart [data-state=drawn]')").await;
    let curve = "document.querySelectorAll('what-if-chart tbody tr').length";
    assert_eq!(stage.browser.js(curve).await, json!(12));
    // A shorter whisker is more sensitive; the compensator comes nearer to the whole one.
    let at = |name: &str| answer["by_ratio"][6][name].as_f64().unwrap();
    let (before, after, compensated) = (at("before_per_mm"), at("after_per_mm"), at("compensated_per_mm"));
    assert!(after > before, "{answer}");
    assert!((compensated - before).abs() < (after - before).abs(), "{answer}");
    // Another length changes the address. An impossible length leads to an error in plain words.
    let length = "{ const field = document.getElementById('what-if-length_mm'); field.value = '200'; \
                  field.dispatchEvent(new Event('change')); }";
    stage.browser.js(length).await;
    let problem = "document.querySelector('main .problem')?.textContent.includes('does not shorten the whisker')";
    stage.browser.until("the refusal", problem).await;
    assert_eq!(stage.browser.js("location.hash.includes('length_mm=200')").await, true);
    stage.stop().await;
}

#[tokio::test]
async fn a_calibration_is_uploaded_activated_and_the_previous_one_restored() {
    let mut stage = Stage::start().await;
    let whiskers = ask(stage.service.http, "GET", "/v1/whiskers", &[]).await.unwrap().json();
    let model = whiskers["items"][0]["model"].as_str().unwrap().to_owned();
    stage.open("#/calibrations").await;
    let problem = "document.querySelector('upload-form .problem')?.textContent ?? ''";
    for (content, cause) in [
        ("pressure_mpa;strain\n0,05;0,01\n", "separated by semicolons"),
        ("pressure_kpa,strain\n50,0.01\n", "100 kPa are 0.1 MPa"),
        ("pressure_mpa,strain\n50,0.01\n", "Line 2: a pressure of 50 MPa is too high; if it is in kPa, write 0.05 MPa"),
        ("# comment\npressure_mpa,strain\n0.01,-0.01\n0.02,0.01\n", "Line 3, column strain"),
    ] {
        upload(&mut stage, &model, content).await;
        stage.browser.until(cause, &format!("({problem}).includes({})", json!(cause))).await;
    }
    for version in 1..=2 {
        stage.open("#/calibrations").await;
        upload(&mut stage, &model, READINGS).await;
        let heading = format!("document.querySelector('h1').textContent === 'Calibration {model}, version {version}'");
        stage.browser.until("the stored calibration", &heading).await;
        stage.browser.until("its curve", "document.querySelector('calibration-chart [data-state=drawn]')").await;
        let uses = "document.querySelector('tr[data-key=use-f]').innerText";
        assert!(stage.browser.js(uses).await.as_str().unwrap().contains("not active"));
        press(&mut stage, "Activate").await;
        stage.browser.until("active", &format!("!{uses}.includes('not active')")).await;
    }
    let restore = "document.querySelector('tr[data-key=use-f] button').textContent";
    assert_eq!(stage.browser.js(restore).await, "Restore version 1 \u{2026}");
    press(&mut stage, "Restore version 1").await;
    let inactive = "document.querySelector('tr[data-key=use-f]').innerText.includes('not active')";
    stage.browser.until("version 2 is not active", inactive).await;
    let list = ask(stage.service.http, "GET", "/v1/calibrations", &[]).await.unwrap().json();
    let active: Vec<_> = list["items"].as_array().unwrap().iter().filter(|one| one["active_in"] == "f").collect();
    assert_eq!(active.len(), 1, "{list}");
    assert_eq!(active[0]["version"], 1, "{list}");
    stage.stop().await;
}

/// Presses the button of the fleet, and then the one of its dialog.
async fn press(stage: &mut Stage, words: &str) {
    stage.browser.click("document.querySelector('tr[data-key=use-f] button')").await;
    let title = format!("document.querySelector('dialog h2')?.textContent.startsWith('{words}')");
    stage.browser.until("the dialog", &title).await;
    stage.browser.click("document.querySelector('dialog button[type=submit]')").await;
}

#[tokio::test]
async fn keys_lead_to_pages_and_to_the_search_but_not_while_typing() {
    let mut stage = Stage::start().await;
    stage.open("#/fleets").await;
    for (key, hash) in [("a", "#/alarms"), ("w", "#/whiskers"), ("k", "#/calibrations"), ("f", "#/fleets")] {
        stage.browser.press("g").await;
        stage.browser.press(key).await;
        stage.browser.until(hash, &format!("location.hash === '{hash}'")).await;
    }
    // Each page of the menu has a key, and the list of shortcuts names it.
    let keys = "import('/console/menu.js').then(({ BY_KEY }) => Object.values(BY_KEY).map(([, address]) => address))";
    let known = stage.browser.js(keys).await;
    let menu = stage.browser.js("[...document.querySelectorAll('#nav a')].map((one) => one.hash)").await;
    let menu = menu.as_array().unwrap();
    assert!(menu.len() > 8 && menu.iter().all(|page| known.as_array().unwrap().contains(page)), "{menu:?} {known}");
    stage.open("#/whiskers").await;
    stage.browser.press("/").await;
    assert_eq!(stage.browser.js("document.activeElement.id").await, "search");
    // Esc leaves the field, and keeps its text.
    stage.browser.press("Escape").await;
    assert_eq!(stage.browser.js("document.activeElement === document.body").await, true);
    stage.browser.press("/").await;
    // In the field the same keys are text.
    stage.browser.press("g").await;
    stage.browser.press("a").await;
    stage.browser.press("?").await;
    assert_eq!(stage.browser.js("document.activeElement.id").await, "search");
    assert_eq!(stage.browser.js("location.hash.startsWith('#/whiskers')").await, true);
    assert_eq!(stage.browser.js("document.querySelector('dialog')").await, json!(null));
    // The search may begin before or after the list opens. It is the same page, so the list stays open.
    stage.browser.js("document.activeElement.blur()").await;
    stage.browser.press("?").await;
    stage.browser.until("the list", "document.querySelectorAll('dialog .shortcuts dt').length >= 10").await;
    let found = "document.querySelector('main').dataset.address.includes('q=ga%3F')";
    stage.browser.until("the search", found).await;
    assert_eq!(stage.browser.js("document.querySelectorAll('dialog .shortcuts').length").await, json!(1));
    assert_eq!(complaints(&mut stage.browser).await, Vec::<String>::new());
    // Switched off, they do nothing; the button still shows the list.
    stage.browser.click("document.querySelector('dialog input')").await;
    stage.browser.press("Escape").await;
    stage.browser.until("closed", "!document.querySelector('dialog')").await;
    stage.browser.press("?").await;
    assert_eq!(stage.browser.js("document.querySelector('dialog')").await, json!(null));
    stage.browser.click("document.getElementById('shortcuts')").await;
    stage.browser.until("the list again", "document.querySelector('dialog .shortcuts')").await;
    stage.is_clean();
    stage.stop().await;
}

#[tokio::test]
async fn new_pages_fit_every_width_in_light_and_dark() {
    let mut stage = with_a_compensation().await;
    stage.open("#/calibrations").await;
    upload(&mut stage, "other", READINGS).await;
    stage.browser.until("stored", "location.hash.startsWith('#/calibrations/')").await;
    let stored = stage.browser.js("location.hash").await;
    let pages = [
        ("overview", "#/fleets"),
        ("overview-fleet", "#/fleets/f"),
        ("what-if", CUT),
        ("calibrations", "#/calibrations"),
        ("calibration", stored.as_str().unwrap()),
        ("trims", "#/trims?since=24h"),
        ("setpoints", "#/setpoints"),
    ];
    for scheme in ["light", "dark"] {
        stage.browser.prefers(scheme).await;
        for width in [390, 1280, 1920] {
            stage.browser.size(width, 900).await;
            for (name, hash) in pages {
                stage.open(hash).await;
                assert_eq!(complaints(&mut stage.browser).await, Vec::<String>::new(), "{name}, {scheme}, {width}");
                assert_eq!(sideways(&mut stage.browser).await, Vec::<String>::new(), "{name} at {width} px");
                assert_eq!(overflow(&mut stage.browser).await, Vec::<String>::new(), "{name} at {width} px");
                stage.picture(&format!("{name}-{width}-{scheme}")).await;
            }
        }
    }
    stage.stop().await;
}
