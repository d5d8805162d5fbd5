//! The console of a service that requires a token.

use serde_json::{Value, json};
use vibrissa_supervisor::http::access::token::{self, NewToken};
use vibrissa_supervisor::http::access::{Role, Scope};

use crate::checks::complaints;
use crate::stage::Stage;

/// Creates a token of all fleets.
pub(crate) async fn token(stage: &Stage, role: Role, expires_us: i64) -> String {
    let (name, created_by) = ("anna".to_owned(), "test".to_owned());
    let new = NewToken { name, role, scope: Scope::All, expires_us, created_by };
    token::create(&stage.service.store, &new, 0).await.unwrap().0
}

/// Types a token into the form, and sends it.
pub(crate) async fn sign_in(stage: &mut Stage, token: &str) {
    stage.browser.js("document.getElementById('token').focus(); document.getElementById('token').select()").await;
    stage.browser.type_text(token).await;
    stage.browser.press("Enter").await;
}

/// Name, `aria-disabled` and accessible description of each button of the page's content.
async fn buttons(stage: &mut Stage) -> Vec<(String, bool, String)> {
    let tree = stage.browser.call("Accessibility.getFullAXTree", json!({})).await;
    let text = |node: &Value, name: &str| node[name]["value"].as_str().unwrap_or_default().to_owned();
    let is_disabled = |node: &Value| {
        let properties = node["properties"].as_array().unwrap();
        properties.iter().any(|one| one["name"] == "disabled" && one["value"]["value"] == true)
    };
    let nodes = tree["nodes"].as_array().unwrap().iter();
    let buttons = nodes.filter(|node| node["ignored"] != true && node["role"]["value"] == "button");
    let all = buttons.map(|node| (text(node, "name"), is_disabled(node), text(node, "description")));
    // The others open no dialog.
    all.filter(|(name, ..)| name.ends_with('\u{2026}')).collect()
}

#[tokio::test]
async fn each_role_sees_its_name_and_which_actions_it_may_not_use() {
    let mut stage = Stage::closed().await;
    let viewer = token(&stage, Role::Viewer, i64::MAX).await;
    let whisker = "#/fleets/f/robots/r/arrays/left/whiskers/1";
    stage.open(whisker).await;
    sign_in(&mut stage, &viewer).await;
    let user = "document.getElementById('user').textContent";
    stage.browser.until("the user is shown", &format!("{user} === 'anna, viewer'")).await;
    let shown = buttons(&mut stage).await;
    assert!(shown.len() >= 5, "{shown:?}");
    for (name, is_disabled, description) in shown {
        let state = (is_disabled, description.as_str());
        assert_eq!(state, (true, "This requires the role operator. Your role is viewer."), "{name}");
    }
    assert_eq!(complaints(&mut stage.browser).await, Vec::<String>::new());
    stage.picture("viewer").await;
    stage.browser.js("document.querySelector('main button[aria-disabled=true]').focus()").await;
    stage.browser.press("Enter").await;
    let notice = "document.getElementById('notices').textContent";
    stage
        .browser
        .until("the reason is told", &format!("{notice}.startsWith('This requires the role operator.')"))
        .await;
    assert_eq!(stage.browser.js("document.querySelector('dialog')").await, Value::Null);

    stage.browser.click("document.getElementById('sign-out')").await;
    stage.browser.until("it asks for a token", "document.getElementById('token')").await;
    assert_eq!(stage.browser.js(user).await, "");
    let soon = vibrissa_edge::clock::wall_clock().0 as i64 + 86_400_000_000;
    let operator = token(&stage, Role::Operator, soon).await;
    sign_in(&mut stage, &operator).await;
    stage.browser.until("the user is shown", &format!("{user}.startsWith('anna, operator until ')")).await;
    let shown = buttons(&mut stage).await;
    assert!(shown.len() >= 5 && shown.iter().all(|(_, is_disabled, _)| !is_disabled), "{shown:?}");
    stage.open("#/policy/f").await;
    let shown = buttons(&mut stage).await;
    let of_engineers = ["Change the policy of f \u{2026}", "Roll a policy out in stages \u{2026}"];
    let reason = "This requires the role engineer. Your role is operator.";
    assert_eq!(shown, of_engineers.map(|button| (button.to_owned(), true, reason.to_owned())));
    stage.stop().await;
}

#[tokio::test]
async fn a_token_is_asked_for_kept_in_the_tab_and_forgotten_again() {
    let mut stage = Stage::closed().await;
    let token = token(&stage, Role::Viewer, i64::MAX).await;
    stage.open("#/fleets/f").await;
    let heading = "document.querySelector('h1').textContent";
    assert_eq!(stage.browser.js(heading).await, "Sign in");
    sign_in(&mut stage, "vbr_000000000000_wrong").await;
    stage
        .browser
        .until("it is refused", "document.querySelector('[role=alert]')?.textContent.includes('unknown')")
        .await;
    sign_in(&mut stage, &token).await;
    stage.browser.until("the fleet is shown", &format!("{heading} === 'Fleet f'")).await;
    assert_eq!(stage.browser.js("localStorage.length + document.cookie.length").await, json!(0));
    stage.browser.click("document.getElementById('sign-out')").await;
    stage.browser.until("it asks for a token again", &format!("{heading} === 'Sign in'")).await;
    assert_eq!(stage.browser.js("sessionStorage.length").await, json!(0));
    stage.stop().await;
}
