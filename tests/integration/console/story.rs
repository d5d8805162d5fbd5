//! The whole story of a cut, by the buttons of the demo in a fleet of a thousand robots: trim, decision, error; alarm with
//! hint; black box, and its replay.

use std::path::{Path, PathBuf};
use std::process::Command;

use clap::Parser;
use serde_json::{Value, json};
use tokio::sync::oneshot;
use tokio::time::{Duration, Instant, sleep};
use vibrissa_simulator::load::{self, LoadPlan};
use vibrissa_tests::demo::LiveDemo;
use vibrissa_tests::wait::{until, until_true};
use vibrissa_tests::web::ask;

use crate::advising::button;
use crate::axe;
use crate::browser::Browser;
use crate::checks::overflow;
use crate::incidents::{picture, press};
use crate::stage::Stage;

const PROGRAM: &str = env!("CARGO_BIN_EXE_lab-under-test");
const ROBOTS: usize = 1000;
const WHISKERS: usize = 6;
const CRAWLER: &str = "#/fleets/demo/robots/crawler-1";
const TARGET: &str = "#/fleets/demo/robots/crawler-1/arrays/left/whiskers/2";
const ALARMS: &str = "#/alarms?robot=crawler-1";

#[derive(Parser)]
struct Line {
    #[command(flatten)]
    plan: LoadPlan,
}

/// A running load.
struct Crowd {
    stop: oneshot::Sender<()>,
    thread: std::thread::JoinHandle<()>,
}

/// Begins to send contacts of a thousand robots; waits until the supervisor knows them all.
async fn crowd(demo: &LiveDemo) -> Crowd {
    let (robots, whiskers) = (ROBOTS.to_string(), WHISKERS.to_string());
    let plan = Line::parse_from([
        "load",
        "--mqtt-url",
        &demo.mqtt,
        "--fleet",
        "demo",
        "--robots",
        &robots,
        "--whiskers",
        &whiskers,
        "--array-whiskers",
        "6",
        "--rate",
        "100",
        "--messages",
        "100000",
    ]);
    // A thread of its own, because the load generator works in one thread.
    let (stop, stopped) = oneshot::channel();
    let thread = std::thread::spawn(move || {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        runtime.block_on(async {
            tokio::select! {
                ended = load::run(plan.plan, || ()) => panic!("the load must not end before the story: {ended:?}"),
                _ = stopped => {}
            }
        });
    });
    let known = async || {
        let answer = ask(demo.http, "GET", "/v1/fleets/demo", &[]).await.ok()?.json();
        // Two robots and ten whiskers are the demo's own.
        let known = [answer["robots"].as_u64()?, answer["whiskers"].as_u64()?];
        (known == [ROBOTS as u64 + 2, (ROBOTS * WHISKERS) as u64 + 10]).then_some(())
    };
    patiently("all robots are known", known).await;
    Crowd { stop, thread }
}

#[tokio::test(flavor = "multi_thread")]
async fn from_the_cut_on_the_page_to_the_replay_of_its_black_box() {
    let folder = tempfile::tempdir().unwrap();
    let mut demo = LiveDemo::start(PROGRAM).await;
    let load = crowd(&demo).await;
    let mut browser = Browser::start().await;
    let downloads = json!({ "behavior": "allow", "downloadPath": folder.path() });
    browser.call("Browser.setDownloadBehavior", downloads).await;
    let url = |hash: &str| format!("http://{}/{hash}", demo.http);

    browser.open(&url("#/fleets")).await;
    browser.until("the number of robots", "document.querySelector('main').innerText.includes('1,002')").await;

    // A cut that the whisker itself compensates for. A cut while the whisker is learned would be called later.
    let of_crawler = "/v1/whiskers?robot=crawler-1&array=left";
    demo.item(of_crawler, |one| one["whisker"] == 2 && one["condition"] == "HEALTHY").await;
    browser.open(&url(CRAWLER)).await;
    browser.js("document.getElementById('demo-whisker').value = '2'").await;
    press(&mut browser, "Cut 5 mm", "Crawler-1/left/2 is cut by 5 mm to 65.0 mm.").await;
    let trims = "/v1/trims?robot=crawler-1&array=left&whisker=2";
    let trim = demo.item(trims, |one| one["black_box_id"].is_i64()).await;
    browser.open(&url(TARGET)).await;
    let decided = "/v1/compensations?robot=crawler-1&array=left&target_whisker=2";
    let compensation = demo.item(decided, |one| one["setpoint_state"] == "APPLIED").await;
    let decision = format!("#/compensations/{}", compensation["compensation_id"]);
    browser.until("the cut on the page", "document.querySelector('main').innerText.includes('rimmed')").await;

    // A cut that no whisker can compensate for raises an alarm, with a hint.
    browser.open(&url("#/fleets/demo/robots/crawler-1/arrays/tail/whiskers/0")).await;
    press(&mut browser, "Cut 22 mm", "Crawler-1/tail/0 is cut by 22 mm to 48.0 mm.").await;
    let alarm = demo.item("/v1/alarms?robot=crawler-1&kind=UNCOMPENSATED", |one| one["black_box_id"].is_i64()).await;
    let hint = alarm["hint"].as_str().unwrap();
    browser.open(&url(ALARMS)).await;
    let says_hint = format!("document.querySelector('main').innerText.includes({})", json!(hint));
    browser.until("the hint", &says_hint).await;

    // The black boxes end some seconds later. They are saved from the alarm's card and the robot's page.
    for one in [&trim, &alarm] {
        let ended = |found: &Value| found["black_box_id"] == one["black_box_id"] && found["state"] != "RECORDING";
        let ended = demo.item("/v1/black-boxes", ended).await;
        // It may be PARTIAL, and may leave messages after the event out: a robot whose receipts are late repeats messages, so
        // that a thousandth of the memory holds less than ten seconds. It still begins with a state.
        assert_eq!(ended["has_state"], true, "{ended}");
    }
    save(&mut browser, &url(ALARMS), &alarm).await;
    save(&mut browser, &url(CRAWLER), &trim).await;
    let found = replayed(&file(folder.path(), &alarm).await, "TRIM");
    assert!(found.iter().any(|one| one["array"] == "tail" && one["whisker"] == 0), "{found:?}");
    let found = replayed(&file(folder.path(), &trim).await, "TRIM");
    let names = ["length_before_mm", "length_after_mm", "contacts_to_detect"];
    let same = |one: &&Value| names.iter().all(|name| one[name] == trim[name]);
    assert_eq!(
        found.iter().filter(same).count(),
        1,
        "the replay finds the cut as the supervisor did: {found:?}, {trim}"
    );

    // The error is known after some hundred contacts of the compensator. The page of the decision shows it.
    browser.open(&url(&decision)).await;
    let measured = async || {
        let answer = ask(demo.http, "GET", decided, &[]).await.ok()?.json();
        answer["items"][0]["measured_error"].as_f64()
    };
    let error = patiently("a measured error", measured).await;
    let percent = format!("document.querySelector('main').innerText.includes('{:.1}\u{a0}%')", 100.0 * error);
    browser.until("the measured error", &percent).await;

    let script = axe::script();
    let pages = [
        ("fleets", "#/fleets"),
        ("fleet", "#/fleets/demo"),
        ("robot", CRAWLER),
        ("whisker", TARGET),
        ("decision", &decision),
        ("alarms", ALARMS),
    ];
    for (width, scheme) in [(390, "light"), (1280, "dark"), (1920, "light")] {
        browser.size(width, 900).await;
        browser.prefers(scheme).await;
        for (name, hash) in pages {
            browser.open(&url(hash)).await;
            assert_eq!(overflow(&mut browser).await, Vec::<String>::new(), "{name} {width}");
            let found = match &script {
                Some(script) => axe::violations(&mut browser, script).await,
                None => Vec::new(),
            };
            assert_eq!(found, Vec::<String>::new(), "{name} {width} {scheme}");
            if let Some(path) = picture(&format!("story-{name}"), width, scheme) {
                browser.picture(&path).await;
            }
        }
    }
    let mut problems = browser.problems();
    // On a busy machine the service may be unready for a moment.
    problems.retain(|problem| !(problem.contains("503") && problem.contains("/readyz")));
    assert_eq!(problems, Vec::<String>::new());
    // An error means that the load has failed, which the thread tells.
    let _ = load.stop.send(());
    load.thread.join().unwrap();
    demo.type_line("quit");
    assert!(demo.ended().await.success());
}

/// Waits for a value for five minutes: a thousand robots and their browser share two cores with other tests.
async fn patiently<T>(what: &str, look: impl AsyncFn() -> Option<T>) -> T {
    let deadline = Instant::now() + Duration::from_secs(300);
    loop {
        if let Some(found) = look().await {
            return found;
        }
        assert!(Instant::now() < deadline, "timed out waiting for: {what}");
        sleep(Duration::from_millis(250)).await;
    }
}

/// Clicks the link to a black box.
async fn save(browser: &mut Browser, url: &str, of: &Value) {
    browser.open(url).await;
    let link = format!("document.querySelector('a[download=\"black-box-{}.jsonl\"]')", of["black_box_id"]);
    browser.click(&link).await;
}

/// The saved file of a black box.
async fn file(folder: &Path, of: &Value) -> PathBuf {
    let begins = format!("black-box-{}", of["black_box_id"]);
    let saved = async || {
        let files = std::fs::read_dir(folder).unwrap().map(|file| file.unwrap().path());
        files.into_iter().find(|path| {
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            name.strip_prefix(&begins).is_some_and(|rest| rest.starts_with(['.', '-'])) && name.ends_with(".jsonl")
        })
    };
    until("the saved file", saved).await
}

/// Effects of one kind that a replay of a file prints.
fn replayed(file: &Path, effect: &str) -> Vec<Value> {
    let output = Command::new(PROGRAM).arg("replay").arg(file).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let lines = String::from_utf8(output.stdout).unwrap();
    let lines = lines.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
    lines.filter(|line| line["effect"] == effect).collect()
}

#[tokio::test]
async fn axe_finds_nothing_on_any_page() {
    let Some(script) = axe::script() else { return };
    let mut stage = Stage::start().await;
    stage.cut().await;
    let decided = async || !stage.service.store.setpoint_states().await.unwrap().is_empty();
    until_true("a decision", decided).await;
    let pages = stage.pages().await;
    for (width, scheme) in [(390, "dark"), (1280, "light")] {
        stage.browser.size(width, 900).await;
        stage.browser.prefers(scheme).await;
        for (name, hash) in &pages {
            stage.open(hash).await;
            let found = axe::violations(&mut stage.browser, &script).await;
            assert_eq!(found, Vec::<String>::new(), "{name} {width} {scheme}");
        }
    }
    // The dialogs of the actions are parts of pages.
    stage.open("#/fleets/f/robots/r").await;
    stage.browser.until("a button", &button("Hold")).await;
    stage.browser.click(&button("Hold")).await;
    let found = axe::violations(&mut stage.browser, &script).await;
    assert_eq!(found, Vec::<String>::new(), "dialog");
    // The rules do find something if there is something.
    stage.browser.js("document.querySelector('dialog').append(new Image(9, 9))").await;
    let found = axe::violations(&mut stage.browser, &script).await;
    assert!(found.iter().any(|one| one.starts_with("image-alt")), "{found:?}");
    // Runbooks are pages without scripts.
    for (width, scheme) in [(360, "dark"), (1280, "light")] {
        stage.browser.size(width, 900).await;
        stage.browser.prefers(scheme).await;
        for page in ["README.md", "VibrissaWhiskerUncompensated.md"] {
            stage.browser.load(&format!("http://127.0.0.1:{}/runbooks/{page}", stage.service.http.port())).await;
            stage.browser.until("the runbook", "document.querySelector('main.runbook h1') !== null").await;
            let found = axe::violations(&mut stage.browser, &script).await;
            assert_eq!(found, Vec::<String>::new(), "{page} {width} {scheme}");
            assert_eq!(overflow(&mut stage.browser).await, Vec::<String>::new(), "{page} {width}");
            if let Some(path) = picture(&format!("runbook-{page}"), width, scheme) {
                stage.browser.picture(&path).await;
            }
        }
    }
    stage.stop().await;
}
