//! All functions can be used with the keyboard alone, and the focus is visible.

use std::collections::BTreeSet;

use serde_json::json;

use crate::stage::Stage;

/// Names of all usable elements, of which a board of tiles is one. A name stays the same when news draw the element again, or add others with other texts.
const USABLE: &str = "(() => { \
    window.named = () => { const seen = new Map(); return [...document.querySelectorAll('a[href], button, input, select, textarea, summary')] \
    .filter((one) => one.tabIndex >= 0 && one.getClientRects().length && one.checkVisibility() && !one.disabled) \
    .map((one) => { const kind = [one.localName, one.id, one.getAttribute('href'), one.name, one.type, \
            one.localName === 'button' ? one.textContent : ''].join(' '); \
        seen.set(kind, (seen.get(kind) ?? 0) + 1); return [`${kind} ${seen.get(kind)}`, one]; }); }; \
    return named().map(([name]) => name); })()";
/// Name of the focused element, and whether the focus is visible.
const FOCUSED: &str = "(() => { const one = document.activeElement; \
    const inside = one.querySelector?.('.target'); \
    const isSeen = getComputedStyle(one).outlineStyle !== 'none' || (inside && getComputedStyle(inside).stroke !== 'none'); \
    const name = named().find(([, other]) => other === one)?.[0] ?? null; \
    return { name, isBody: one === document.body, isSeen, html: one.outerHTML.slice(0, 120) }; })()";

#[tokio::test]
async fn tab_reaches_everything_that_can_be_used_and_shows_where_it_is() {
    let mut stage = Stage::start().await;
    stage.cut().await;
    stage.robot.setpoint().await;
    for (name, hash) in stage.pages().await {
        stage.open(&hash).await;
        let expected: BTreeSet<String> = serde_json::from_value(stage.browser.js(USABLE).await).unwrap();
        // Tab begins at the first element.
        stage.browser.js("document.getElementById('skip').focus()").await;
        let first = stage.browser.js(FOCUSED).await;
        let mut reached = BTreeSet::from([first["name"].as_str().unwrap().to_owned()]);
        for _ in 0..expected.len() * 2 + 20 {
            stage.browser.press("Tab").await;
            let focused = stage.browser.js(FOCUSED).await;
            if focused["isBody"] == json!(true) {
                break;
            }
            assert_eq!(focused["isSeen"], json!(true), "{name}: the focus cannot be seen: {focused}");
            reached.extend(focused["name"].as_str().map(ToOwned::to_owned));
        }
        // News may have taken an element away meanwhile.
        let present: BTreeSet<String> = serde_json::from_value(stage.browser.js(USABLE).await).unwrap();
        let missed: Vec<&String> = expected.difference(&reached).filter(|name| present.contains(*name)).collect();
        assert!(missed.is_empty(), "{name}: Tab does not reach {missed:?} of {}", expected.len());
    }
    stage.stop().await;
}

#[tokio::test]
async fn enter_follows_a_link_and_the_focus_moves_to_where_it_led() {
    let mut stage = Stage::start().await;
    stage.open("#/fleets").await;
    for (link, heading) in [("a[href=\"#/fleets/f\"]", "Fleet f"), ("a[href=\"#/fleets/f/robots/r\"]", "Robot r")] {
        stage.browser.js(&format!("document.querySelector('main {}').focus()", link.replace('\'', "\""))).await;
        stage.browser.press("Enter").await;
        let led =
            format!("document.activeElement.localName === 'h1' && document.activeElement.textContent === '{heading}'");
        stage.browser.until(heading, &led).await;
        assert_eq!(stage.browser.js(&format!("document.title.startsWith('{heading}')")).await, json!(true));
    }
    stage.browser.js("document.querySelector('svg.drawing a').focus()").await;
    stage.browser.press("Enter").await;
    stage.browser.until("a whisker", "document.activeElement.textContent === 'Whisker left 0 of r'").await;
    stage.is_clean();
    stage.stop().await;
}

/// Holds the answers to a refresh until `window.release()`. Then they arrive without a pause between them.
const HOLD: &str = "(() => { \
    const [real, gate] = [window.fetch, Promise.withResolvers()]; \
    const seen = document.body.dataset; \
    [seen.asked, seen.held] = [0, 0]; \
    window.release = () => { window.fetch = real; gate.resolve(); }; \
    window.fetch = async (...asked) => { \
        seen.asked = Number(seen.asked) + 1; \
        const answer = await real(...asked); \
        const told = await answer.json(); \
        seen.held = Number(seen.held) + 1; \
        await gate.promise; \
        return { ok: answer.ok, status: answer.status, headers: answer.headers, json: async () => told }; }; \
    document.getElementById('zone').dispatchEvent(new Event('change')); })()";

/// The address changes before its event. An answer between the two was shown under the name of the next page, which then
/// did not get the focus.
#[tokio::test]
async fn regress_a_late_answer_of_the_last_page_does_not_take_the_focus_from_the_next() {
    let mut stage = Stage::start().await;
    stage.open("#/fleets").await;
    stage.browser.js(HOLD).await;
    let held = "document.body.dataset.held !== '0' && document.body.dataset.held === document.body.dataset.asked";
    stage.browser.until("the answers are held", held).await;
    let shows = "Number(document.querySelector('main').dataset.shows)";
    let before = stage.browser.js(shows).await.as_i64().unwrap();
    let follow = format!(
        "new Promise((done) => {{ \
            addEventListener('hashchange', () => done({shows}), {{ capture: true, once: true }}); \
            location.hash = '#/whiskers'; window.release(); }})"
    );
    assert_eq!(stage.browser.js(&follow).await, before + 1, "the late answer came before the event");
    let led = "document.activeElement.localName === 'h1' && document.activeElement.textContent === 'Whiskers'";
    stage.browser.until("the focus on the heading", led).await;
    stage.is_clean();
    stage.stop().await;
}

/// A refresh may show the next page before the answer to the link comes. The heading then did not get the focus.
#[tokio::test]
async fn regress_a_refresh_that_shows_the_next_page_first_gives_it_the_focus() {
    let mut stage = Stage::start().await;
    stage.open("#/fleets").await;
    // The answer to the link waits, and those to the refresh do not.
    let follow = "(() => { \
        const [real, gate] = [window.fetch, Promise.withResolvers()]; \
        window.release = gate.resolve; \
        window.fetch = async (...asked) => { \
            window.fetch = real; \
            document.getElementById('zone').dispatchEvent(new Event('change')); \
            await gate.promise; \
            return real(...asked); }; \
        location.hash = '#/whiskers'; })()";
    stage.browser.js(follow).await;
    stage.browser.until("the refresh", "document.querySelector('h1')?.textContent === 'Whiskers'").await;
    stage.browser.js("window.release()").await;
    let led = "document.activeElement.localName === 'h1' && document.activeElement.textContent === 'Whiskers'";
    stage.browser.until("the focus on the heading", led).await;
    stage.is_clean();
    stage.stop().await;
}

#[tokio::test]
async fn the_skip_link_leads_past_the_navigation() {
    let mut stage = Stage::start().await;
    stage.open("#/fleets").await;
    stage.browser.press("Tab").await;
    assert_eq!(stage.browser.js("document.activeElement.id").await, "skip");
    stage.browser.press("Enter").await;
    assert_eq!(stage.browser.js("document.activeElement.id").await, "main");
    assert_eq!(stage.browser.js("location.hash").await, "#/fleets");
    stage.stop().await;
}
