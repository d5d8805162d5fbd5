//! The console says what it leaves out, and shows nothing that is outdated, twice, or not so.

use serde_json::{Value, json};
use vibrissa_supervisor::http::access::Role;

use crate::signing_in::{sign_in, token};
use crate::stage::Stage;

const WHISKER: &str = "#/fleets/f/robots/r/arrays/left/whiskers/0";
/// Whisker 0 of array `left` of robot `r` in the database.
const ITS: &str =
    "(SELECT w.whisker_id FROM whiskers w JOIN robots USING (robot_id) WHERE robot = 'r' AND whisker = 0)";
/// Numbers from 1 to `i`.
const NUMBERS: &str = "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i <";
const TEXT: &str = "document.getElementById('main').innerText";

fn now_us() -> i64 {
    vibrissa_edge::clock::wall_clock().0 as i64
}

/// Text of the section with this heading.
fn part(heading: &str) -> String {
    format!("document.getElementById('part-{heading}').parentElement.innerText")
}

/// The lists of a whisker ended after 20 rows.
#[tokio::test]
async fn regress_a_list_of_a_whisker_says_that_it_has_more_rows_and_shows_them() {
    let mut stage = Stage::start().await;
    let added = format!(
        "{NUMBERS} 25) INSERT INTO health_changes (whisker_id, recorded_us, kind, was, becomes) \
         SELECT {ITS}, {} + i, 'CONDITION', 'HEALTHY', 'WORN' FROM n",
        now_us()
    );
    stage.run(&added).await;
    stage.open(&format!("{WHISKER}?tab=history")).await;
    let rows = "document.querySelectorAll('tr[data-key^=change-]').length";
    assert_eq!(stage.browser.js(rows).await, 20);
    let text = stage.browser.js(&part("changes-of-health")).await;
    assert!(text.as_str().unwrap().contains("Only the newest 20 are shown."), "{text}");
    let setpoints = stage.browser.js(&part("setpoints")).await;
    assert!(!setpoints.as_str().unwrap().contains("Only the newest"), "{setpoints}");
    stage
        .browser
        .click("[...document.querySelectorAll('main a')].find((one) => one.textContent === 'Show up to 100')")
        .await;
    stage.browser.until("all rows", &format!("{rows} >= 25")).await;
    assert_eq!(stage.browser.js(&format!("{TEXT}.includes('Only the newest')")).await, false);
    stage.is_clean();
    stage.stop().await;
}

/// Only the newest 200 alarms had marks, in whatever range.
#[tokio::test]
async fn regress_charts_say_which_events_have_no_marks() {
    let mut stage = Stage::start().await;
    let told = "document.querySelector('.told').textContent";
    stage.open(&format!("{WHISKER}?tab=charts&range=1h")).await;
    assert_eq!(stage.browser.js(&format!("{told}.includes('Only the newest')")).await, false);
    // An old one, and then many newer ones.
    let now_us = now_us();
    let alarms = |first: usize, last: usize, at_us: i64| {
        format!(
            "{NUMBERS} {last}) INSERT INTO alarms (whisker_id, raised_us, kind, cleared_us) \
             SELECT {ITS}, {at_us} + i, 'LEAK', {at_us} + i + 1 FROM n WHERE i >= {first}"
        )
    };
    stage.run(&alarms(1, 1, now_us - 5 * 3_600_000_000)).await;
    stage.run(&alarms(1, 250, now_us - 60_000_000)).await;
    stage.browser.load("about:blank").await;
    stage.open(&format!("{WHISKER}?tab=charts&range=1h")).await;
    let words = stage.browser.js(told).await;
    assert!(words.as_str().unwrap().contains("Only the newest have marks: alarm."), "{words}");
    // In the range of the old one are no others.
    let end = |by: i64| format!("encodeURIComponent(new Date({} + {by}).toISOString())", now_us / 1000 - 5 * 3_600_000);
    let range = stage.browser.js(&format!("`from=${{{}}}&to=${{{}}}`", end(-600_000), end(600_000))).await;
    stage.open(&format!("{WHISKER}?tab=charts&{}", range.as_str().unwrap())).await;
    let words = stage.browser.until("its mark", &format!("{told}.includes('2 events') && {told}")).await;
    assert!(!words.as_str().unwrap().contains("Only the newest"), "{words}");
    stage.is_clean();
    stage.stop().await;
}

/// A line led from the last error before a pause to the first one after it, and from one compensation to the next.
#[tokio::test]
async fn regress_a_line_has_a_gap_where_nothing_was_measured() {
    let mut stage = Stage::without_robots().await;
    stage.open("#/fleets").await;
    let gaps = "import('/console/charts/gaps.js').then(({ broken, isAlone }) => [ \
        broken({ x: [0, 1, 9, 10], y: [1, 2, 3, 4], low: [0, 1, 2, 3], high: [2, 3, 4, 5] }, 5), \
        broken({ x: [0, 1, 2], y: [1, 2, 3], of: [7, 7, 8] }, 5).y, broken({ x: [0, 5], y: [1, 2], of: [7, 7] }, 5).y, \
        isAlone([undefined, 1, null, 2, undefined, 3, null, 4])])";
    let spread = json!({
        "x": [0, 1, 5, 9, 10], "y": [1, 2, null, 3, 4], "low": [0, 1, null, 2, 3], "high": [2, 3, null, 4, 5]
    });
    assert_eq!(stage.browser.js(gaps).await, json!([spread, [1, 2, null, 3], [1, 2], [1, 7]]));
    // Parts of the width with the colour of the line.
    let drawn = "import('/console/charts/plot.js').then(async ({ Plot }) => { \
        const spec = { key: 'k', title: 't', isTime: true, atLeast: [0, 2], cursorWords: String, \
          series: [{ name: 's', tone: 'a', look: 'line', say: String }] }; \
        const plot = new Plot(spec, { cursor: () => {}, spoken: () => {} }); \
        document.body.append(plot.element); \
        const many = Array.from({ length: 41 }, (_, at) => 500 * at); \
        const x = [...many, 50_000, ...many.map((at) => 80_000 + at)]; \
        await plot.set([{ x, y: x.map(() => 1) }], { from: 0, to: 100_000 }); \
        await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))); \
        const canvas = plot.element.querySelector('canvas'); \
        const { data, width } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height); \
        const seen = new Set(); \
        for (let at = 0; at < data.length; at += 4) \
          if (data[at] === 11 && data[at + 1] === 92 && data[at + 2] === 173) seen.add(Math.floor(20 * ((at / 4) % width) / width)); \
        plot.element.remove(); \
        return [...seen].sort((one, other) => one - other); })";
    stage.browser.prefers("light").await;
    let parts = stage.browser.js(drawn).await;
    let parts: Vec<u64> = parts.as_array().unwrap().iter().map(|one| one.as_u64().unwrap()).collect();
    let has = |within: std::ops::RangeInclusive<u64>| parts.iter().any(|part| within.contains(part));
    assert!(has(1..=3) && has(16..=18), "both lines: {parts:?}");
    assert!(has(9..=11), "the point between them: {parts:?}");
    assert!(!has(6..=8) && !has(12..=13), "no line between them: {parts:?}");
    stage.is_clean();
    stage.stop().await;
}

/// The number of contacts was that of all loaded rows, also of those beside the range.
#[tokio::test]
async fn regress_the_number_beside_a_range_is_of_its_contacts() {
    let mut stage = Stage::without_robots().await;
    stage.open("#/fleets").await;
    let shown = "import('/console/charts/toolbar.js').then(({ Toolbar }) => { \
        const toolbar = new Toolbar({}); \
        const rows = [[5, 3], [15, 4], [20, 5], [25, 6]].map(([at, contacts]) => ({ at, contacts })); \
        toolbar.show(null, { from: 10, to: 20 }, { rows, resolution: 'minute' }); \
        return toolbar.element.querySelector('.hint').textContent; })";
    let words = stage.browser.js(shown).await;
    assert!(words.as_str().unwrap().contains(" 9 contacts, "), "{words}");
    stage.stop().await;
}

/// The charts of a whisker that was replaced kept the whole length of the one before.
#[tokio::test]
async fn regress_charts_show_the_whole_length_of_a_new_whisker() {
    let mut stage = Stage::start().await;
    stage.open(&format!("{WHISKER}?tab=charts")).await;
    let level = "document.querySelector('[data-chart=length]').innerText";
    assert_eq!(stage.browser.js(&format!("{level}.includes('whole 70.0')")).await, true);
    stage.browser.js("document.querySelector('whisker-charts').setAttribute('whole', '55')").await;
    stage.browser.until("the new level", &format!("{level}.includes('whole 55.0')")).await;
    stage.is_clean();
    stage.stop().await;
}

/// A tab asked for the role once. Messages about a refusal had the colour of success.
#[tokio::test]
async fn regress_a_changed_role_is_noticed_and_a_refusal_is_no_success() {
    let mut stage = Stage::closed().await;
    let engineer = token(&stage, Role::Engineer, i64::MAX).await;
    stage.open("#/calibrations").await;
    sign_in(&mut stage, &engineer).await;
    let user = "document.getElementById('user').textContent";
    stage.browser.until("the user", &format!("{user} === 'anna, engineer'")).await;
    stage.run("UPDATE api_tokens SET role = 'VIEWER'").await;
    let later = "const now = Date.now.bind(Date); Date.now = () => now() + 61_000; dispatchEvent(new Event('online'))";
    stage.browser.js(&format!("(() => {{ {later} }})()")).await;
    stage.browser.until("the new role", &format!("{user} === 'anna, viewer'")).await;
    stage
        .browser
        .js("document.getElementById('upload').dispatchEvent(new Event('submit', { cancelable: true }))")
        .await;
    let notice = stage.browser.until("the reason", "document.querySelector('.notice')?.className").await;
    assert_eq!(notice, "notice warn");
    stage.stop().await;
}

/// With a search the page said that nothing needed attention, and meant the robots that were found.
#[tokio::test]
async fn regress_the_verdict_of_some_robots_is_not_that_of_all() {
    let mut stage = Stage::start().await;
    stage.crowd(20).await;
    stage.open("#/fleets?q=more").await;
    let summary = "document.querySelector('.summary').textContent";
    let words: Value = stage.browser.js(summary).await;
    let words = words.as_str().unwrap();
    assert!(words.contains("of 20 robots that match") && words.ends_with(" in all."), "{words}");
    stage.browser.load("about:blank").await;
    stage.open("#/fleets").await;
    let words = stage.browser.js(summary).await;
    assert!(!words.as_str().unwrap().contains("that match"), "{words}");
    stage.is_clean();
    stage.stop().await;
}
