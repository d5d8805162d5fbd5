//! How many clicks common work takes, from the board on. The table in docs/operators.md has the same numbers.

use serde_json::json;
use tokio::time::Instant;
use vibrissa_core::policy::{Mode, PolicyParams};
use vibrissa_protocol::{ArrayType, SetpointOutcome};
use vibrissa_tests::actions::policy_body;
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::until_true;
use vibrissa_tests::web::{ask, send};

use crate::stage::Stage;

/// Robots that are held at once.
const TEN: usize = 10;

/// Somebody at the browser, whose clicks are counted.
struct Person {
    stage: Stage,
    clicks: usize,
    begun: Instant,
}

impl Person {
    /// Opens the board in a window of this size.
    async fn at_the_board(mut stage: Stage, (width, height): (u32, u32)) -> Self {
        stage.browser.size(width, height).await;
        stage.open("#/fleets").await;
        Self { stage, clicks: 0, begun: Instant::now() }
    }

    /// Clicks an element that can be seen; `element` is a JavaScript expression.
    async fn click(&mut self, element: &str) {
        let seen = format!("((one) => one?.checkVisibility() && (one.click(), true))({element})");
        self.stage.browser.until(element, &seen).await;
        self.clicks += 1;
    }

    /// Clicks a link or a button by the beginning of its words.
    async fn press(&mut self, words: &str) {
        let among = "[...document.querySelectorAll('a, button, summary')]";
        let is_it = format!("one.checkVisibility() && one.innerText.trim().startsWith({})", json!(words));
        self.click(&format!("{among}.find((one) => {is_it})")).await;
    }

    /// Sends the open dialog by its own button.
    async fn confirm(&mut self) {
        self.click("document.querySelector('dialog[open] button[type=submit]')").await;
        self.sees("the dialog is closed", "!document.querySelector('dialog[open]')").await;
    }

    async fn sees(&mut self, what: &str, expression: &str) {
        self.stage.browser.until(what, expression).await;
    }

    /// Checks the number of clicks and its row in the document, and ends.
    async fn took(self, work: &str, clicks: usize) {
        println!("{work}: {} clicks, {:.1} s of the machine", self.clicks, self.begun.elapsed().as_secs_f64());
        assert_eq!(self.clicks, clicks, "{work}");
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/operators.md");
        let row = format!("| {work} | {clicks} |");
        assert!(std::fs::read_to_string(path).unwrap().contains(&row), "docs/operators.md needs {row}");
        self.stage.is_clean();
        self.stage.stop().await;
    }
}

const WIDE: (u32, u32) = (1280, 900);
const PHONE: (u32, u32) = (390, 844);

/// An expression that is true if an element is on the first screen.
fn on_the_first_screen(selector: &str) -> String {
    format!("((one) => one && one.getBoundingClientRect().bottom <= innerHeight)(document.querySelector('{selector}'))")
}

#[tokio::test]
async fn the_worst_whisker_is_one_click_away_and_its_page_says_why() {
    let mut stage = Stage::start().await;
    stage.cut().await;
    let mut person = Person::at_the_board(stage, WIDE).await;
    person.click("document.querySelector('.worst a')").await;
    person.sees("its page", "document.querySelector('h1').textContent === 'Whisker left 0 of r'").await;
    person.sees("the reason", &on_the_first_screen("#story")).await;
    person.sees("in words", "document.getElementById('story').textContent.includes('found after')").await;
    person.took("Find the worst whisker", 1).await;
}

#[tokio::test]
async fn the_reasons_of_the_decision_about_the_worst_whisker_take_two_clicks() {
    let mut stage = Stage::start().await;
    stage.cut().await;
    let mut person = Person::at_the_board(stage, WIDE).await;
    person.click("document.querySelector('.worst a')").await;
    person.click("document.querySelector('.entries a.to[href^=\"#/compensations/\"]')").await;
    person.sees("the alternatives", "document.getElementById('part-alternatives')").await;
    person.took("See why it was decided so", 2).await;
}

#[tokio::test]
async fn a_whisker_that_was_replaced_is_mended_in_three_clicks() {
    // No compensation is good enough.
    let mut stage = Stage::with(|params| params.policy.predicted_error_max = 1e-6).await;
    stage.cut().await;
    let http = stage.service.http;
    until_true("the alarm", async || {
        ask(http, "GET", "/v1/alarms?kind=UNCOMPENSATED&standing=true", &[]).await.unwrap().body.contains("alarm_id")
    })
    .await;
    let mut person = Person::at_the_board(stage, WIDE).await;
    person.press("Alarms").await;
    person.click("document.querySelector('.alarm[data-kind=UNCOMPENSATED] .mend button:last-child')").await;
    person.confirm().await;
    until_true("it is replaced", async || {
        ask(http, "GET", "/v1/audit?kind=REPLACED&state=DONE", &[]).await.unwrap().body.contains("REPLACED")
    })
    .await;
    person.took("Tell that it was replaced", 3).await;
}

#[tokio::test]
async fn ten_robots_are_held_in_four_clicks() {
    let stage = Stage::start().await;
    let http = stage.service.http;
    let mut robots = Vec::new();
    for number in 1..TEN {
        let name = format!("more-{number}");
        robots.push(HandRobot::born(stage.service.broker.port, &name, array(ArrayType::Type1, &[70.0])).await);
    }
    let known = async || ask(http, "GET", "/v1/robots", &[]).await.unwrap().json()["items"].as_array().unwrap().len();
    until_true("all robots are known", async || known().await == TEN).await;
    let mut person = Person::at_the_board(stage, WIDE).await;
    person.click("document.querySelector('.tile-groups h2 a')").await;
    person.press("Bulk actions").await;
    person.press(&format!("Hold {TEN} robots")).await;
    person.confirm().await;
    let held =
        async || ask(http, "GET", "/v1/robots?held=true", &[]).await.unwrap().json()["items"].as_array().unwrap().len();
    until_true("all robots are held", async || held().await == TEN).await;
    person.took("Hold ten robots", 4).await;
}

#[tokio::test]
async fn a_proposal_is_answered_on_a_phone_in_two_clicks() {
    let mut stage = Stage::start().await;
    let http = stage.service.http;
    let policy = policy_body(&PolicyParams { mode: Mode::Advise, ..PolicyParams::default() });
    let set = send(http, "PUT", "/v1/fleets/f/policy", &[("If-Match", "\"0\"")], Some(&policy)).await.unwrap();
    assert_eq!(set.status, 200, "{}", set.body);
    stage.cut().await;
    // An action on a robot that is silent by now would be refused.
    stage.robot.touch(1, 5).await;
    stage.robot.receipted().await;
    let mut person = Person::at_the_board(stage, PHONE).await;
    person.press("Approve").await;
    person.confirm().await;
    let (setpoint, _) = person.stage.robot.setpoint().await;
    person.stage.robot.answer(&setpoint, SetpointOutcome::Applied, None).await;
    person.took("Answer a proposal on a phone", 2).await;
}

#[tokio::test]
async fn what_happened_last_night_takes_two_clicks() {
    let mut stage = Stage::start().await;
    stage.cut().await;
    let mut person = Person::at_the_board(stage, WIDE).await;
    person.press("Timeline").await;
    person.press("Last night").await;
    person.sees("a span of the night", "/[?&]from=/.test(location.hash) && /[?&]to=/.test(location.hash)").await;
    person
        .sees("its answer", "/^What happened from .* to /.test(document.querySelector('.summary')?.textContent)")
        .await;
    person.took("See what happened last night", 2).await;
}
