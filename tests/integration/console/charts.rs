//! The charts of a whisker: range, zoom, cursor, live tail, events, colours, and the model's curve.

use serde_json::{Value, json};
use vibrissa_protocol::SetpointOutcome;
use vibrissa_tests::web::ask;

use crate::checks::complaints;
use crate::stage::Stage;

const PATH: &str = "/v1/fleets/f/robots/r/arrays/left/whiskers/0";
const WHISKER: &str = "#/fleets/f/robots/r/arrays/left/whiskers/0?tab=charts";
/// Text of the chosen range.
const STATUS: &str = "document.querySelector('.toolbar .hint').textContent";
/// Plotting area of the chart of lengths.
const AREA: &str = "document.querySelector('[data-chart=length] .u-over')";

async fn with_a_compensation() -> Stage {
    let mut stage = Stage::start().await;
    stage.cut().await;
    let (setpoint, _) = stage.robot.setpoint().await;
    stage.robot.answer(&setpoint, SetpointOutcome::Applied, None).await;
    stage.robot.touch(0, 40).await;
    stage.robot.receipted().await;
    stage
}

async fn query(stage: &mut Stage) -> String {
    let hash = stage.browser.js("location.hash").await;
    // Without the tab, which every address of charts has.
    let hash = hash.as_str().unwrap().replace("tab=charts", "");
    hash.split_once('?').map_or_else(String::new, |(_, query)| query.trim_start_matches('&').to_owned())
}

/// A place in the chart of lengths, as parts of its width and height.
async fn place(stage: &mut Stage, across: f64, down: f64) -> (f64, f64) {
    stage.browser.js(&format!("{AREA}.scrollIntoView({{ block: 'center' }})")).await;
    let found = format!(
        "(() => {{ const box = {AREA}.getBoundingClientRect(); \
         return [box.x + box.width * {across}, box.y + box.height * {down}]; }})()"
    );
    let found = stage.browser.js(&found).await;
    (found[0].as_f64().unwrap(), found[1].as_f64().unwrap())
}

async fn drag(stage: &mut Stage, from: f64, to: f64) {
    let (begin, end) = (place(stage, from, 0.3).await, place(stage, to, 0.6).await);
    stage.browser.mouse("mouseMoved", begin, 0).await;
    stage.browser.mouse("mousePressed", begin, 1).await;
    for step in 1..=5 {
        let part = f64::from(step) / 5.0;
        let at = (begin.0 + part * (end.0 - begin.0), begin.1 + part * (end.1 - begin.1));
        stage.browser.mouse("mouseMoved", at, 1).await;
    }
    stage.browser.mouse("mouseReleased", end, 1).await;
}

#[tokio::test]
async fn a_range_is_chosen_zoomed_and_reset_and_is_part_of_the_address() {
    let mut stage = with_a_compensation().await;
    stage.open(WHISKER).await;
    let pressed =
        |name: &str| format!("document.querySelector('.toolbar [aria-pressed=true]')?.textContent === '{name}'");
    stage.browser.until("the newest", &pressed("Newest")).await;
    // All contacts are of one second: the window is the shortest one around them, and not an hour.
    let reach = "document.querySelector('.toolbar .hint').textContent";
    assert!(stage.browser.js(reach).await.as_str().unwrap().contains("follows new data"));
    assert_eq!(query(&mut stage).await, "");
    for (words, name) in [("24 hours", "24h"), ("7 days", "7d"), ("30 days", "30d"), ("1 hour", "1h")] {
        let button =
            format!("[...document.querySelectorAll('.toolbar button')].find((one) => one.textContent === '{words}')");
        stage.browser.click(&button).await;
        stage.browser.until(words, &pressed(words)).await;
        assert_eq!(query(&mut stage).await, format!("range={name}"));
    }
    // A drag zooms into its part of the hour, and the address names the new range.
    drag(&mut stage, 0.5, 0.9).await;
    stage.browser.until("the zoom", &format!("{STATUS}.includes('chosen range')")).await;
    let span = "(() => { const query = new URLSearchParams(location.hash.split('?')[1]); \
         return (Date.parse(query.get('to')) - Date.parse(query.get('from'))) / 60_000; })()";
    let minutes = stage.browser.js(span).await.as_f64().unwrap();
    assert!((minutes - 24.0).abs() < 0.5, "0.4 of an hour: {minutes} minutes");
    // The address gives the same range to somebody else.
    let (address, status) = (stage.browser.js("location.hash").await, stage.browser.js(STATUS).await);
    stage.browser.load("about:blank").await;
    stage.open(address.as_str().unwrap()).await;
    assert_eq!(stage.browser.js(STATUS).await.as_str().unwrap()[..20], status.as_str().unwrap()[..20]);
    // A double click resets, a step back in the history zooms again, and the button resets too.
    let middle = place(&mut stage, 0.5, 0.5).await;
    for clicks in [1, 2] {
        stage.browser.mouse("mousePressed", middle, clicks).await;
        stage.browser.mouse("mouseReleased", middle, clicks).await;
    }
    stage.browser.until("no zoom", &pressed("Newest")).await;
    assert_eq!(query(&mut stage).await, "");
    stage.browser.js("history.back()").await;
    stage.browser.until("the zoom again", &format!("{STATUS}.includes('chosen range')")).await;
    // + keeps the right end.
    let end = "new URLSearchParams(location.hash.split('?')[1]).get('to')";
    let before = stage.browser.js(end).await;
    stage.browser.click("document.querySelector('[aria-label=\"Zoom in\"]')").await;
    stage.browser.until("half of it", &format!("Math.abs(({span}) - {minutes} / 2) < 0.1")).await;
    assert_eq!(stage.browser.js(end).await, before);
    let newest = "[...document.querySelectorAll('.toolbar button')].find((one) => one.textContent === 'Newest')";
    stage.browser.click(newest).await;
    stage.browser.until("no zoom again", &pressed("Newest")).await;
    stage.is_clean();
    stage.stop().await;
}

#[tokio::test]
async fn the_resolution_follows_the_range() {
    let mut stage = with_a_compensation().await;
    for (range, wanted, unwanted) in [
        ("1h", "/contacts?from=", "resolution="),
        ("24h", "resolution=minute", "resolution=none"),
        ("7d", "resolution=hour", "resolution=minute"),
        ("30d", "resolution=hour", "resolution=minute"),
    ] {
        stage.browser.load("about:blank").await;
        let before = stage.browser.asked().len();
        stage.open(&format!("{WHISKER}&range={range}")).await;
        let asked = stage.browser.asked();
        let asked = &asked[before..];
        assert!(asked.iter().any(|url| url.contains(PATH) && url.contains(wanted)), "{range}: {asked:?}");
        assert!(!asked.iter().any(|url| url.contains(unwanted)), "{range}: {asked:?}");
        // Contacts since the last complete minute or hour are shown too.
        assert!(stage.browser.js(STATUS).await.as_str().unwrap().contains("contact"), "{range}");
        let newest = "document.querySelector('[data-chart=length] b').textContent";
        assert!(stage.browser.js(newest).await.as_str().unwrap().contains("mm ("), "{range}");
    }
    stage.is_clean();
    stage.stop().await;
}

#[tokio::test]
async fn the_cursor_tells_the_values_with_the_mouse_and_with_the_keyboard() {
    let mut stage = with_a_compensation().await;
    // The contacts lie within a second: only a short range separates them.
    let newest = ask(stage.service.http, "GET", &format!("{PATH}/lengths?points=1"), &[]).await.unwrap().json();
    let newest = format!("Date.parse('{}')", newest["items"][0]["at"].as_str().unwrap());
    stage.open("#/fleets").await;
    let end = |by: i32| format!("encodeURIComponent(new Date({newest} + {by}).toISOString())");
    let range = stage.browser.js(&format!("`from=${{{}}}&to=${{{}}}`", end(-1_000), end(200))).await;
    stage.open(&format!("{WHISKER}&{}", range.as_str().unwrap())).await;
    // Without a cursor the chart names the newest values.
    let lengths = ask(stage.service.http, "GET", &format!("{PATH}/lengths"), &[]).await.unwrap().json();
    let lengths = lengths["items"].as_array().unwrap().clone();
    let shown_length = |row: &Value| format!("{:.2}\u{a0}mm", row["length_mm"].as_f64().unwrap());
    let value = "document.querySelector('[data-chart=length] b').textContent";
    assert!(stage.browser.js(value).await.as_str().unwrap().starts_with(&shown_length(lengths.last().unwrap())));
    // Home goes to the first contact, the arrow to the second one; a live text tells time and values.
    stage.browser.js("document.querySelector('[data-chart=length] .plot').focus()").await;
    stage.browser.press("Home").await;
    stage.browser.press("ArrowRight").await;
    assert!(stage.browser.js(value).await.as_str().unwrap().starts_with(&shown_length(&lengths[1])));
    let live = stage.browser.js("document.querySelector('whisker-charts .unseen[aria-live=polite]').textContent").await;
    let live = live.as_str().unwrap();
    assert!(live.contains("Estimated length") && live.contains(&shown_length(&lengths[1])), "{live}");
    // All charts show the same moment.
    let moments =
        "new Set([...document.querySelectorAll('whisker-charts .values .at')].map((one) => one.textContent)).size";
    assert_eq!(stage.browser.js(moments).await, 1);
    // The mouse shows the values below it.
    stage.browser.press("Home").await;
    let left = "(() => { const line = document.querySelector('[data-chart=length] .u-cursor-x').getBoundingClientRect(); \
         const box = document.querySelector('[data-chart=length] .u-over').getBoundingClientRect(); \
         return (line.right - box.x) / box.width; })()";
    let across = stage.browser.js(left).await.as_f64().unwrap();
    stage.browser.press("End").await;
    let at = place(&mut stage, across, 0.5).await;
    stage.browser.mouse("mouseMoved", at, 0).await;
    // Several contacts may share a pixel; all of them were before the cut.
    let first = format!("Math.abs(parseFloat({value}) - {}) < 0.5", lengths[0]["length_mm"]);
    stage.browser.until("the first contacts' length", &first).await;
    let before = query(&mut stage).await;
    stage.browser.press("+").await;
    let nearer = query(&mut stage).await;
    assert!(nearer.starts_with("from=") && nearer != before, "{nearer}");
    stage.browser.press("0").await;
    stage.browser.until("no zoom", &format!("{STATUS}.includes('follows new data')")).await;
    // The same values in a table.
    stage.browser.click("document.querySelector('.value-tables summary')").await;
    let newest = "document.querySelector('.value-tables tbody tr')?.innerText";
    stage.browser.until("a table", newest).await;
    assert!(stage.browser.js(newest).await.as_str().unwrap().contains(&shown_length(lengths.last().unwrap())));
    assert_eq!(complaints(&mut stage.browser).await, Vec::<String>::new());
    stage.is_clean();
    stage.stop().await;
}

#[tokio::test]
async fn new_contacts_appear_without_a_reload_and_without_losing_the_zoom() {
    let mut stage = with_a_compensation().await;
    let now = "(() => { const ends = [-600_000, 600_000].map((by) => new Date(Date.now() + by).toISOString()); \
         return `from=${encodeURIComponent(ends[0])}&to=${encodeURIComponent(ends[1])}`; })()";
    stage.open("#/fleets").await;
    let range = stage.browser.js(now).await;
    stage.open(&format!("{WHISKER}&{}", range.as_str().unwrap())).await;
    stage.browser.js("window.untouched = document.querySelector('[data-chart=length] canvas')").await;
    let contacts = format!("Number({STATUS}.match(/([\\d,]+) contact/)[1].replace(',', ''))");
    let before = stage.browser.js(&contacts).await.as_u64().unwrap();
    let zoom = query(&mut stage).await;
    let shown = stage.browser.js(&format!("{STATUS}.slice(0, 30)")).await;
    stage.robot.touch(0, 40).await;
    stage.robot.receipted().await;
    stage.browser.until("the new contacts", &format!("{contacts} === {}", before + 40)).await;
    assert_eq!(query(&mut stage).await, zoom);
    assert_eq!(stage.browser.js(&format!("{STATUS}.slice(0, 30)")).await, shown);
    let same = "window.untouched === document.querySelector('[data-chart=length] canvas')";
    assert_eq!(stage.browser.js(same).await, true, "the chart is not built again");
    stage.is_clean();
    stage.stop().await;
}

#[tokio::test]
async fn events_are_marked_and_lead_to_their_decision_and_alarm() {
    let mut stage = with_a_compensation().await;
    let held =
        vibrissa_tests::web::send(stage.service.http, "POST", &format!("{PATH}/hold"), &[], Some(&json!({}))).await;
    assert_eq!(held.unwrap().status, 200);
    stage.open(&format!("{WHISKER}&range=1h")).await;
    let words =
        "[...document.querySelectorAll('.lane button')].map((one) => one.getAttribute('aria-label')).join('; ')";
    stage.browser.until("marks", "document.querySelector('.lane button')").await;
    // In an hour the marks of one moment overlap and become one, which tells all its events.
    stage.browser.js("document.querySelector('.lane button').focus()").await;
    stage.browser.press("Enter").await;
    let description = stage
        .browser
        .until("events", "document.querySelector('.told li') && document.querySelector('.told').innerText")
        .await;
    for part in ["trim detected: 70.0", "setpoint ", "hold", "by local"] {
        assert!(
            description.as_str().unwrap().contains(part),
            "{part}: {description}; marks: {}",
            stage.browser.js(words).await
        );
    }
    let pressed = "document.activeElement.matches('.lane button[aria-pressed=true]')";
    assert_eq!(stage.browser.js(pressed).await, true, "the mark keeps the focus");
    let decisions = ask(stage.service.http, "GET", "/v1/compensations", &[]).await.unwrap().json();
    let decision = &decisions["items"][0]["compensation_id"];
    stage.browser.click("[...document.querySelectorAll('.told li')].find((one) => one.innerText.includes('trim'))?.querySelector('a')").await;
    let heading = format!("location.hash === '#/compensations/{decision}'");
    stage.browser.until("the decision", &heading).await;
    stage.is_clean();
    stage.stop().await;
}

/// Colours of the pixels of the chart of lengths.
const COLOURS: &str = "(() => { const canvas = document.querySelector('[data-chart=length] canvas'); \
    const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height); \
    const seen = new Set(); for (let at = 0; at < data.length; at += 4) \
    if (data[at + 3] === 255) seen.add(`${data[at]},${data[at + 1]},${data[at + 2]}`); return [...seen]; })()";

#[tokio::test]
async fn charts_are_drawn_in_the_pages_colours_and_again_when_the_scheme_changes() {
    let mut stage = with_a_compensation().await;
    stage.open(WHISKER).await;
    for (scheme, colour) in [("light", "11,92,173"), ("dark", "121,184,255"), ("light", "11,92,173")] {
        stage.browser.prefers(scheme).await;
        // A canvas changes without a mutation of the document.
        let drawn = format!(
            "new Promise((done) => {{ const look = () => ({COLOURS}).includes('{colour}') ? done(true) : requestAnimationFrame(look); look(); }})"
        );
        assert_eq!(stage.browser.js(&drawn).await, true, "{scheme}");
    }
    stage.is_clean();
    stage.stop().await;
}

#[tokio::test]
async fn the_models_curve_is_shown_with_recent_contacts_and_the_unbroken_whisker() {
    let mut stage = with_a_compensation().await;
    stage.robot.touch(0, 40).await;
    stage.robot.receipted().await;
    let model = ask(stage.service.http, "GET", &format!("{PATH}/model"), &[]).await.unwrap().json();
    // The recent contacts are those of the list that are at the present length and pressure.
    let contacts = ask(stage.service.http, "GET", &format!("{PATH}/contacts?points=2000"), &[]).await.unwrap().json();
    let near = |row: &Value, name: &str, within: f64| {
        (row[name].as_f64().unwrap() - model[name].as_f64().unwrap()).abs() <= within
    };
    let expected: Vec<&Value> = contacts["items"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|row| !row["residual"].is_null() && near(row, "pressure_mpa", 0.005) && near(row, "length_mm", 1.0))
        .map(|row| &row["sensitivity_per_mm"])
        .collect();
    let recent: Vec<&Value> =
        model["recent"].as_array().unwrap().iter().map(|row| &row["sensitivity_per_mm"]).collect();
    assert!(!recent.is_empty());
    assert_eq!(recent, expected[expected.len().saturating_sub(200)..]);
    // A shorter whisker is more sensitive at the same ratio.
    let last = &model["by_ratio"][11];
    assert_eq!(last["ratio"], json!(1.0));
    stage.open(WHISKER).await;
    stage.browser.js("document.querySelector('model-chart .plot').focus()").await;
    stage.browser.press("End").await;
    let spoken = stage.browser.js("document.querySelector('model-chart .unseen').textContent").await;
    let spoken = spoken.as_str().unwrap();
    for (name, of) in [("this whisker now, 6", "own_per_mm"), ("model of the unbroken whisker, 70.0", "whole_per_mm")] {
        let value = format!("{:.5}", last[of].as_f64().unwrap());
        assert!(spoken.contains(name) && spoken.contains(&value), "{name} {value}: {spoken}");
    }
    assert!(spoken.contains("contact ratio 1.00"), "{spoken}");
    stage.is_clean();
    stage.stop().await;
}

#[tokio::test]
async fn regress_a_closed_chart_draws_nothing_and_moves_no_cursor() {
    let mut stage = Stage::start().await;
    stage.open("#/fleets").await;
    let closed = |when: &str| {
        format!(
            "import('/console/charts/plot.js').then(async ({{ Plot }}) => {{ \
               let moves = 0; \
               const spec = {{ key: 'k', title: 't', isTime: false, atLeast: [0, 1], cursorWords: String, \
                 series: [{{ name: 's', tone: 'a', look: 'line', say: String }}] }}; \
               const plot = new Plot(spec, {{ cursor: () => (moves += 1), spoken: () => {{}} }}); \
               document.body.append(plot.element); \
               const drawn = plot.set([{{ x: [0, 1], y: [0, 1] }}], {{ from: 0, to: 1 }}); \
               {when} \
               await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))); \
               const charts = plot.element.querySelectorAll('.uplot').length; \
               plot.element.remove(); \
               return [charts, moves]; \
             }})"
        )
    };
    let open = stage.browser.js(&closed("await drawn;")).await;
    assert!(open[0] == 1 && open[1].as_u64() > Some(0), "an open chart is drawn, and its cursor is told: {open}");
    for when in ["plot.close(); await drawn;", "await drawn; moves = 0; plot.redraw(); plot.close();"] {
        assert_eq!(stage.browser.js(&closed(when)).await, json!([0, 0]), "{when}");
    }
    stage.is_clean();
    stage.stop().await;
}
