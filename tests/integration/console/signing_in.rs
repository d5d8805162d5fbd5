//! The console of a service that requires a token.

use serde_json::json;
use vibrissa_supervisor::http::access::token::{self, NewToken};
use vibrissa_supervisor::http::access::{Role, Scope};

use crate::stage::Stage;

#[tokio::test]
async fn a_token_is_asked_for_kept_in_the_tab_and_forgotten_again() {
    let mut stage = Stage::closed().await;
    let new = NewToken {
        name: "console".to_owned(),
        role: Role::Viewer,
        scope: Scope::All,
        expires_us: i64::MAX,
        created_by: "test".to_owned(),
    };
    let (token, _) = token::create(&stage.service.store, &new, 0).await.unwrap();
    stage.open("#/fleets/f").await;
    let heading = "document.querySelector('h1').textContent";
    assert_eq!(stage.browser.js(heading).await, "Sign in");
    let typing = async |stage: &mut Stage, text: &str| {
        stage.browser.js("document.getElementById('token').focus(); document.getElementById('token').select()").await;
        stage.browser.type_text(text).await;
        stage.browser.press("Enter").await;
    };
    typing(&mut stage, "vbr_000000000000_wrong").await;
    stage
        .browser
        .until("it is refused", "document.querySelector('[role=alert]')?.textContent.includes('unknown')")
        .await;
    typing(&mut stage, &token).await;
    stage.browser.until("the fleet is shown", &format!("{heading} === 'Fleet f'")).await;
    assert_eq!(stage.browser.js("localStorage.length + document.cookie.length").await, json!(0));
    stage.browser.js("document.getElementById('sign-out').click()").await;
    stage.browser.until("it asks for a token again", &format!("{heading} === 'Sign in'")).await;
    assert_eq!(stage.browser.js("sessionStorage.length").await, json!(0));
    stage.stop().await;
}
