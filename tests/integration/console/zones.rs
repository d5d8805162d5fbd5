//! One time zone for all times of the console: the browser's, UTC, or a named one.

use serde_json::json;
use vibrissa_core::policy::Mode;
use vibrissa_tests::web::ask;

use crate::advising::button;
use crate::stage::Stage;

const HISTORY: &str = "#/fleets/f/robots/r/arrays/left/whiskers/0?tab=history";
const CHARTS: &str = "#/fleets/f/robots/r/arrays/left/whiskers/0?tab=charts";

/// Chooses a time zone, and waits until the page is shown again with it.
async fn choose(stage: &mut Stage, zone: &str) {
    let shows = stage.browser.js("Number(main.dataset.shows)").await;
    stage
        .browser
        .js(&format!(
            "(() => {{ const field = document.getElementById('zone'); field.value = '{zone}'; \
             field.dispatchEvent(new Event('change')); }})()"
        ))
        .await;
    assert_eq!(stage.browser.js("document.getElementById('zone').value").await, zone, "a choice");
    stage.browser.until("the page is shown again", &format!("Number(main.dataset.shows) > {shows}")).await;
}

/// Waits until every time on the page names the zone in its tooltip.
async fn all_name(stage: &mut Stage, name: &str) {
    let times = "[...document.querySelectorAll('main time')]";
    let texts = format!("{times}.length > 2 && {times}.every((one) => one.title.includes('{name}'))");
    stage.browser.until(name, &texts).await;
}

#[tokio::test]
async fn all_times_are_in_one_named_zone_that_is_chosen_and_remembered() {
    let mut stage = Stage::start().await;
    stage.cut().await;
    stage.robot.setpoint().await;
    stage.browser.call("Emulation.setTimezoneOverride", json!({ "timezoneId": "Asia/Kolkata" })).await;
    stage.open(HISTORY).await;
    all_name(&mut stage, "GMT+5:30").await;
    assert_eq!(stage.browser.js("document.getElementById('zone').value").await, "browser");
    assert_eq!(stage.browser.js("localStorage.length").await, 0, "the browser's zone is not stored");
    for (zone, name) in [("UTC", "UTC"), ("Asia/Tokyo", "GMT+9"), ("browser", "GMT+5:30"), ("UTC", "UTC")] {
        choose(&mut stage, zone).await;
        all_name(&mut stage, name).await;
    }
    // A text without the zone's name would not reveal a wrong hour.
    let time = "document.querySelector('main time')";
    let hour = format!("{time}.textContent.includes({time}.getAttribute('datetime').slice(11, 16))");
    assert_eq!(stage.browser.js(&hour).await, true);
    // The choice survives when the page is loaded anew.
    stage.browser.load("about:blank").await;
    stage.open(HISTORY).await;
    all_name(&mut stage, "UTC").await;
    // The range of the charts names it, too, and so does each day of the timeline.
    stage.open(CHARTS).await;
    let range = "document.querySelector('.toolbar .hint').textContent.includes('UTC to ')";
    stage.browser.until("the range", range).await;
    stage.open("#/timeline").await;
    stage.browser.until("a day", "document.querySelector('.entries .day')?.textContent.endsWith(', UTC')").await;
    stage.is_clean();
    stage.stop().await;
}

#[tokio::test]
async fn the_axis_of_time_is_in_the_zone_and_names_the_day() {
    let mut stage = Stage::start().await;
    stage.open("#/fleets").await;
    choose(&mut stage, "America/New_York").await;
    // 3:30, 4:00 and 4:30 UTC: midnight is at 4:00 in summer.
    let labels = "import('/console/charts/scale.js').then(({ labels }) => labels.times(null, \
         ['03:30', '04:00', '04:30'].map((clock) => Date.parse(`2026-07-02T${clock}Z`)), 0, 0, 1_800_000))";
    assert_eq!(stage.browser.js(labels).await, json!(["23:30\n1 Jul", "00:00\n2 Jul", "00:30"]));
    let days = "import('/console/charts/scale.js').then(({ labels }) => labels.times(null, \
         [Date.parse('2026-07-02T04:00Z')], 0, 0, 86_400_000))";
    assert_eq!(stage.browser.js(days).await, json!(["2 Jul"]));
    stage.stop().await;
}

#[tokio::test]
async fn fields_of_times_are_read_in_the_zone_also_when_clocks_change() {
    let mut stage = Stage::start().await;
    stage.open("#/fleets").await;
    // Zone, what the field says, and the moment. In the second hour of 25 October 2026 the clocks of Berlin repeat an
    // hour, and on 29 March they skip one: the next existing time is taken.
    for (zone, text, expected) in [
        ("UTC", "2026-11-24T10:15", "2026-11-24T10:15:00.000Z"),
        ("Australia/Adelaide", "2026-11-24T10:15", "2026-11-23T23:45:00.000Z"),
        ("America/New_York", "2026-07-01T23:30", "2026-07-02T03:30:00.000Z"),
        ("Europe/Berlin", "2026-03-29T01:59", "2026-03-29T00:59:00.000Z"),
        ("Europe/Berlin", "2026-03-29T02:30", "2026-03-29T01:30:00.000Z"),
        ("Europe/Berlin", "2026-03-29T03:30", "2026-03-29T01:30:00.000Z"),
        ("Europe/Berlin", "2026-10-25T03:30", "2026-10-25T02:30:00.000Z"),
    ] {
        choose(&mut stage, zone).await;
        let read =
            format!("import('/console/zone.js').then((zone) => new Date(zone.fromField('{text}')).toISOString())");
        assert_eq!(stage.browser.js(&read).await, expected, "{text} in {zone}");
        let written = format!("import('/console/zone.js').then((zone) => zone.toField(Date.parse('{expected}')))");
        if text != "2026-03-29T02:30" {
            assert_eq!(stage.browser.js(&written).await, text, "{expected} in {zone}");
        }
    }
    stage.stop().await;
}

#[tokio::test]
async fn an_alarm_is_shelved_until_a_time_in_the_zone() {
    // A proposal raises an alarm.
    let mut stage = Stage::with(|params| params.policy.mode = Mode::Advise).await;
    stage.cut().await;
    stage.open("#/alarms").await;
    choose(&mut stage, "Asia/Tokyo").await;
    stage.browser.until("an alarm", &button("Shelve")).await;
    stage.browser.click(&button("Shelve")).await;
    let field = "document.querySelector('dialog[open] input[type=datetime-local]')";
    stage.browser.until("the field", field).await;
    let hint = "document.querySelector('dialog[open]').innerText.includes('Asia/Tokyo')";
    assert_eq!(stage.browser.js(hint).await, true);
    // Tomorrow, by the clock of Tokyo, which is nine hours ahead of UTC.
    let tomorrow = |hours: u32| {
        format!(
            "new Date(Math.floor(Date.now() / 3_600_000) * 3_600_000 + {hours} * 3_600_000).toISOString().slice(0, 16)"
        )
    };
    let until = stage.browser.js(&tomorrow(24)).await;
    let send = format!(
        "(() => {{ {field}.value = {}; document.querySelector('dialog textarea').value = 'spare part'; \
         document.querySelector('dialog form').requestSubmit(); }})()",
        tomorrow(24 + 9)
    );
    stage.browser.js(&send).await;
    stage.browser.until("it is done", "!document.querySelector('dialog[open]')").await;
    let alarms = ask(stage.service.http, "GET", "/v1/alarms?state=SHELVED", &[]).await.unwrap().json();
    let shelved = alarms["items"][0]["shelved_until"].as_str().unwrap();
    assert!(shelved.starts_with(until.as_str().unwrap()), "{shelved} is not {until}");
    stage.stop().await;
}
