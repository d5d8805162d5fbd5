//! A page whose requests fail, or get given answers: its contents and messages. A script in the page gives the answers.

use serde_json::{Value, json};
use vibrissa_tests::wait::until;
use vibrissa_tests::web::ask;

use crate::stage::Stage;

const NOTICES: &str = "document.getElementById('notices')";

async fn start() -> Stage {
    let mut stage = Stage::start().await;
    let source = json!({ "source": include_str!("failing.js") });
    stage.browser.call("Page.addScriptToEvaluateOnNewDocument", source).await;
    stage
}

async fn answers(stage: &mut Stage, stubs: &Value) {
    stage.browser.js(&format!("window.stubs = {stubs}")).await;
}

/// Shows the page's data again, as an event of the service would.
async fn refresh(stage: &mut Stage) {
    let zone = "import('/console/zone.js').then((zone) => zone.setZone(zone.zoneChoice()))";
    stage.browser.js(zone).await;
}

/// Result of a function of a module, or the message of its error.
async fn called(stage: &mut Stage, module: &str, call: &str) -> Value {
    let script = format!("import('/console/{module}').then(async (it) => {call}).catch((problem) => problem.message)");
    stage.browser.js(&script).await
}

#[tokio::test]
async fn regress_a_failed_request_takes_nothing_from_the_page() {
    let mut stage = start().await;
    stage.open("#/calibrations").await;
    let field = "document.querySelector('#upload [name=model]')";
    stage.browser.js(&format!("{field}.value = 'mine'")).await;
    answers(&mut stage, &json!([["GET", "v1/alarms/counts", 200, { "items": [{ "alarms": 3 }] }]])).await;
    refresh(&mut stage).await;
    stage.browser.until("the number of alarms", "document.title.startsWith('(3) ')").await;
    for status in [429, 502, 503, 504] {
        let failing = json!([["GET", "v1/calibrations", status, { "detail": format!("failure {status}") }],
                             ["GET", "v1/alarms/counts", status, {}]]);
        answers(&mut stage, &failing).await;
        refresh(&mut stage).await;
        stage.browser.until("it is told", &format!("{NOTICES}.textContent.includes('failure {status}')")).await;
        assert_eq!(
            stage.browser.js(&format!("[document.querySelector('h1').textContent, {field}.value]")).await,
            json!(["Calibrations", "mine"])
        );
    }
    assert_eq!(stage.browser.js(&format!("{NOTICES}.children.length")).await, 1, "one message");
    answers(&mut stage, &json!([["GET", "v1/alarms/counts", 503, {}]])).await;
    refresh(&mut stage).await;
    stage.browser.until("the end is told", &format!("{NOTICES}.textContent.includes('up to date again')")).await;
    assert_eq!(stage.browser.js("document.title.startsWith('(3) ')").await, true, "the number is not known");

    // A sign-out that fails.
    answers(&mut stage, &json!([["POST", "auth/sign-out", 503, { "detail": "the database is away" }]])).await;
    assert_eq!(called(&mut stage, "session.js", "it.signOut(true)").await, "the database is away");
    answers(&mut stage, &json!([["POST", "auth/sign-out", 0, null]])).await;
    assert_eq!(called(&mut stage, "session.js", "it.signOut(true)").await, "the service does not answer");

    // An upload without an answer, and again.
    let file = "(() => { const held = new DataTransfer(); held.items.add(new File(['pressure_mpa,strain\\n0.1,0.01\\n'], 'a.csv')); \
                document.querySelector('#upload [name=file]').files = held.files; })()";
    stage.browser.js(file).await;
    stage.browser.js("void (window.sent = [])").await;
    let send = "document.querySelector('#upload').requestSubmit()";
    answers(&mut stage, &json!([["POST", "v1/calibrations", 0, null]])).await;
    stage.browser.js(send).await;
    let alert = "document.querySelector('#upload [role=alert]').textContent";
    stage.browser.until("the failure", &format!("{alert}.includes('does not answer')")).await;
    let stored = json!({ "version": 1, "model": "mine", "calibration_id": 9 });
    answers(&mut stage, &json!([["POST", "v1/calibrations", 201, stored]])).await;
    stage.browser.js(send).await;
    stage.browser.until("it is told", &format!("{NOTICES}.textContent.includes('Stored as version 1')")).await;
    let sent = stage.browser.js("window.sent.map(({ key }) => key)").await;
    assert!(sent[0].is_string() && sent[0] == sent[1] && sent.as_array().unwrap().len() == 2, "{sent}");

    // A dry run that is refused stays until it is dismissed.
    stage.open("#/whiskers").await;
    answers(&mut stage, &json!([["POST", "v1/whiskers/", 409, { "detail": "not now" }]])).await;
    stage
        .browser
        .click("[...document.querySelectorAll('.at-once button')].find((one) => one.textContent.startsWith('Hold'))")
        .await;
    let bad = format!("{NOTICES}.querySelector('.notice.bad')?.textContent.includes('not now')");
    stage.browser.until("the refusal", &bad).await;
    stage.stop().await;
}

#[tokio::test]
async fn regress_what_the_page_derives_from_answers() {
    let mut stage = start().await;
    stage.open("#/whiskers").await;

    // Views of two pages with the same name.
    for (page, name) in [("whiskers", "Whiskers"), ("alarms", "Alarms")] {
        stage.open(&format!("#/{page}")).await;
        stage.browser.until("the page", &format!("document.querySelector('h1').textContent === '{name}'")).await;
        stage.browser.js("document.getElementById('view-name').value = 'Hall 2'").await;
        stage.browser.click("document.querySelector('.saved button:not(.quiet)')").await;
        stage.browser.until("the view", "document.querySelector('.views a')?.textContent === 'Hall 2'").await;
    }
    let views = "JSON.parse(localStorage.getItem('vibrissa-views')).map(({ address }) => address)";
    assert_eq!(stage.browser.js(views).await, json!(["#/whiskers", "#/alarms"]));
    stage.browser.click("document.querySelector('.views button')").await;
    stage.browser.until("it is deleted", "!document.querySelector('.views a')").await;
    assert_eq!(stage.browser.js(views).await, json!(["#/whiskers"]));
    let many: Vec<Value> = (0..50).map(|n| json!({ "name": n.to_string(), "address": "#/trims" })).collect();
    stage.browser.js(&format!("localStorage.setItem('vibrissa-views', {})", json!(json!(many).to_string()))).await;
    stage.browser.js("document.getElementById('view-name').value = 'one more'").await;
    stage.browser.click("document.querySelector('.saved button:not(.quiet)')").await;
    stage
        .browser
        .until("the limit", "document.getElementById('notices').textContent.includes('delete one first')")
        .await;
    assert_eq!(stage.browser.js(&format!("{views}.length")).await, 50);

    // An hour whose minutes are stored from its 34th on.
    let history = "v1/fleets/f/robots/r/arrays/left/whiskers/1/history";
    let row = |start_at: &str, contacts: u32| {
        json!({ "start_at": start_at, "contacts_used": contacts, "contacts_learning": 0, "contacts_unused": 0,
                "residual_mean": null, "length_mm": null })
    };
    let items = json!({ "hour": [row("2026-11-21T12:00:00Z", 300), row("2026-11-21T10:00:00Z", 20)],
                        "minute": [row("2026-11-21T12:35:00Z", 200), row("2026-11-21T12:34:00Z", 100)] });
    let early = json!({ "hour": [row("2026-11-20T12:00:00Z", 300), row("2026-11-20T10:00:00Z", 20)], "minute": [] });
    stage
        .browser
        .js(&format!(
            "{{ const [real, items, early] = [window.fetch, {items}, {early}]; window.fetch = async (path, options) => {{ \
        if (path.includes('/contacts')) return new Response('{{\"items\":[]}}'); \
        if (!path.startsWith('{history}')) return real(path, options); \
        const query = new URLSearchParams(path.split('?')[1]), name = query.get('resolution'); \
        const found = query.get('to') < '2026-11-21' ? early : items; \
        return new Response(JSON.stringify({{ items: found[name], next_cursor: null }})); }}; }}"
        ))
        .await;
    let window = "{ from: Date.parse('2026-11-20T18:00Z'), to: Date.parse('2026-11-21T18:00Z') }";
    let whisker = "{ fleet: 'f', robot: 'r', array: 'left', whisker: 1 }";
    let rows = format!("(await it.rowsOf({whisker}, {window})).rows.map(({{ contacts }}) => contacts)");
    assert_eq!(called(&mut stage, "charts/data.js", &rows).await, json!([20, 100, 200]));
    // No minutes are stored any more, and the window ends within an hour.
    let window = "{ from: Date.parse('2026-11-20T08:00Z'), to: Date.parse('2026-11-20T12:30Z') }";
    let rows = format!("(await it.rowsOf({whisker}, {window})).rows.map(({{ contacts }}) => contacts)");
    assert_eq!(called(&mut stage, "charts/data.js", &rows).await, json!([20, 300]));

    // Version 1 by a person, version 2 by a roll-out, version 3 by a person.
    let version = |id: u32| json!({ "calibration_id": id, "model": "m", "version": id });
    let by_person = |id: u32, at: &str| json!({ "done_at": at, "parameters": { "calibration_id": id } });
    let rollouts = json!([{ "kind": "CALIBRATION", "updated_at": "2026-11-02T00:00:00Z", "change": { "calibration_id": 2 } },
                          { "kind": "POLICY", "updated_at": "2026-11-04T00:00:00Z", "change": {} }]);
    answers(
        &mut stage,
        &json!([
            ["GET", "v1/calibrations/3/use", 200, { "items": [{ "fleet": "f", "is_active": true }] }],
            ["GET", "v1/calibrations/3", 200, version(3)],
            ["GET", "v1/calibrations?", 200, { "items": [version(3), version(2), version(1)] }],
            ["GET", "v1/audit?", 200, { "items": [by_person(3, "2026-11-03T00:00:00Z"), by_person(1, "2026-11-01T00:00:00Z")] }],
            ["GET", "v1/rollouts?", 200, { "items": rollouts }],
        ]),
    )
    .await;
    let previous = "(await it.default.load({ id: 3 })).previous.get('f').version";
    assert_eq!(called(&mut stage, "pages/calibration.js", previous).await, 2);

    // Many fleets: the page asks for no policy but the one whose numbers the dialog of all fleets shows.
    let fleets: Vec<Value> = (0..11).map(|number| json!({ "fleet": format!("hall-{number}") })).collect();
    stage.browser.js("performance.clearResourceTimings()").await;
    answers(
        &mut stage,
        &json!([
            ["GET", "v1/fleets?", 200, { "items": fleets }],
            ["GET", "v1/fleets/hall-0/policy/history", 200, { "items": [] }],
            ["GET", "v1/fleets/hall-0/policy", 200, { "mode": "ADVISE" }],
        ]),
    )
    .await;
    let loaded = "await it.default.load({}, {}).then(({ policies, fleets }) => [policies.length, fleets.length])";
    assert_eq!(called(&mut stage, "pages/policy.js", loaded).await, json!([1, 11]));
    let asked = "performance.getEntriesByType('resource').filter(({ name }) => name.includes('/policy')).length";
    assert_eq!(stage.browser.js(asked).await, 0, "of the other fleets");

    // Sundays of 25 and of 23 hours.
    stage.browser.js("import('/console/zone.js').then((zone) => zone.setZone('Europe/Berlin'))").await;
    for (now, from, to) in [
        ("2026-10-25T22:30Z", "2026-10-23T22:00:00.000Z", "2026-10-24T22:00:00.000Z"),
        ("2026-03-29T22:30Z", "2026-03-28T23:00:00.000Z", "2026-03-29T22:00:00.000Z"),
    ] {
        stage.open("#/trims").await;
        stage.browser.js(&format!("void (Date.now = () => Date.parse('{now}'))")).await;
        stage.open("#/timeline").await;
        let link =
            "[...document.querySelectorAll('main .links a')].find((one) => one.textContent === 'Yesterday')?.href";
        let link = stage.browser.until("the link", link).await;
        let query = link.as_str().unwrap().split_once('?').unwrap().1;
        let told: std::collections::BTreeMap<_, _> = url::form_urlencoded::parse(query.as_bytes()).collect();
        assert_eq!((&*told["from"], &*told["to"]), (from, to), "{now}");
    }
    stage.stop().await;
}

#[tokio::test]
async fn regress_a_link_to_an_alarm_shows_it_beside_any_list() {
    // No compensation is good enough.
    let mut stage = Stage::with(|params| params.policy.predicted_error_max = 1e-6).await;
    stage.cut().await;
    let first = async || {
        let answer = ask(stage.service.http, "GET", "/v1/alarms", &[]).await.unwrap();
        answer.json()["items"].get(0).map(|alarm| alarm["alarm_id"].clone())
    };
    let id = until("an alarm", first).await;
    stage.open(&format!("#/alarms?state=CLEARED&alarm_id={id}")).await;
    stage.browser.until("its card", &format!("document.querySelector('main [data-key=\"alarm-{id}\"]')")).await;
    stage.is_clean();
    stage.open("#/alarms?alarm_id=999999").await;
    let gone = "document.querySelector('main').textContent.includes('Alarm 999999 is not stored')";
    stage.browser.until("that it is gone", gone).await;
    stage.stop().await;
}

/// The stream ended for ever after one refusal, and a hidden page told nobody.
#[tokio::test]
async fn regress_the_stream_of_events_comes_back_after_a_refusal() {
    let mut stage = start().await;
    stage.open("#/fleets").await;
    let again = "new Promise((done) => { let asked = 0; \
                 const live = new it.Live(() => { asked += 1; window.stubs = []; }, \
                                          (state) => { if (state === 'live') { live.stop(); done(asked); } }, () => {}); \
                 window.stubs = [['GET', 'v1/events', 401, {}]]; live.start(); })";
    assert_eq!(called(&mut stage, "live.js", again).await, 1, "the page is asked for a sign-in");
    let signed_in = "new Promise((done) => { \
                     const live = new it.Live(() => {}, (state) => { if (state === 'live') { live.stop(); done(true); } }, () => {}); \
                     live.start(); live.stop(); live.told(true); })";
    assert_eq!(called(&mut stage, "live.js", signed_in).await, true, "somebody has signed in in another tab");
    // Six streams would take all connections that a browser has to a host.
    let hidden = "new Promise((done) => { const said = []; const real = window.fetch; \
                  window.fetch = (path, options) => { if (String(path).startsWith('v1/events')) { said.push('opened'); \
                    options.signal.addEventListener('abort', () => said.push('closed')); \
                    if (said.length === 3) { live.stop(); window.fetch = real; done(said.slice(0, 3)); } } return real(path, options); }; \
                  const live = new it.Live(() => {}, (state) => { if (state === 'live') { live.rest(); live.told(true); } }, () => {}); \
                  live.start(); })";
    assert_eq!(called(&mut stage, "live.js", hidden).await, json!(["opened", "closed", "opened"]));
    stage.stop().await;
}

#[tokio::test]
async fn regress_a_part_that_disappears_takes_no_focus_from_others() {
    let mut stage = start().await;
    stage.open("#/fleets").await;
    let after = "{ const { h } = it; const part = (key) => h('section', { 'data-key': key }, h('button', { id: `b-${key}` }, key)); \
                 const form = () => h('form', {}, h('input', { id: 'typed' })); \
                 const lines = (...all) => all.map((name) => h('p', { class: name }, name)); \
                 const old = h('div', {}, lines('summary', 'marks'), form(), part('one'), lines('hint'), part('two')); \
                 document.body.append(old); const kept = []; \
                 for (const [id, next] of [['typed', [lines('summary'), form(), part('one'), lines('hint'), part('two')]], \
                                           ['b-two', [lines('summary'), form(), part('two')]], \
                                           ['typed', [lines('summary', 'marks'), form(), part('three'), part('two')]]]) { \
                   document.getElementById(id).focus(); it.morphChildren(old, h('div', {}, next)); \
                   kept.push(document.activeElement.id, old.textContent); } \
                 old.remove(); return kept; }";
    let kept = called(&mut stage, "dom.js", after).await;
    let expected = json!(["typed", "summaryonehinttwo", "b-two", "summarytwo", "typed", "summarymarksthreetwo"]);
    assert_eq!(kept, expected);
    stage.stop().await;
}

/// The refusal was written into a dialog that was closed already.
#[tokio::test]
async fn regress_a_refusal_after_the_dialog_was_closed_is_told() {
    let mut stage = start().await;
    stage.open("#/fleets/f/robots/r").await;
    stage
        .browser
        .click("[...document.querySelectorAll('main button')].find((one) => one.textContent.startsWith('Hold'))")
        .await;
    stage.browser.until("the dialog", "document.querySelector('dialog form') !== null").await;
    let refused = json!([["POST", "v1/", 202, { "state": "PENDING", "action_id": 9 }],
                         ["GET", "v1/actions/9", 200, { "state": "REJECTED", "problem": "the robot is away" }]]);
    answers(&mut stage, &refused).await;
    let leave = "{ document.querySelector('dialog [name=reason]').value = 'x'; document.querySelector('dialog form').requestSubmit(); \
                 document.querySelector('dialog').close(); }";
    stage.browser.js(leave).await;
    let bad = format!("{NOTICES}.querySelector('.notice.bad')?.textContent.includes('the robot is away')");
    stage.browser.until("the refusal", &bad).await;
    stage.stop().await;
}
