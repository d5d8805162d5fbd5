//! Signing in at the console with a real identity provider, in a real browser.

use std::time::{Duration, Instant};

use serde_json::{Value, json};
use vibrissa_store::secret::Secret;
use vibrissa_supervisor::http::access::AccessOptions;
use vibrissa_supervisor::http::access::OidcOptions;
use vibrissa_supervisor::http::access::SignInOptions;
use vibrissa_tests::mosquitto::free_port;
use vibrissa_tests::web::ask;

use crate::checks::complaints;
use crate::keycloak::Keycloak;
use crate::stage::Stage;

/// The provider answers slowly on a busy machine.
const PATIENCE: Duration = Duration::from_secs(90);

/// Waits until an expression is true, also while the browser goes from page to page.
async fn comes(stage: &mut Stage, what: &str, expression: &str) {
    let deadline = Instant::now() + PATIENCE;
    while stage.browser.js(&format!("Boolean({expression})")).await != json!(true) {
        let shown = "location.href + ' ' + document.body?.innerText";
        assert!(Instant::now() < deadline, "{what}: {}", stage.browser.js(shown).await);
        tokio::time::sleep(Duration::from_millis(200)).await;
    }
}

const OFFERED: &str = "document.querySelector('#sign-in a') && document.querySelector('h1').textContent === 'Sign in'";
const ASKED: &str = "document.getElementById('kc-login') && document.getElementById('username')";

/// Follows the console's link, and signs in at the provider.
async fn sign_in(stage: &mut Stage, user: &str) {
    comes(stage, "the sign-in is offered", OFFERED).await;
    stage.browser.click("document.querySelector('#sign-in a')").await;
    comes(stage, "the provider asks for the password", ASKED).await;
    for (field, value) in [("username", user.to_owned()), ("password", format!("{user}-of-this-test"))] {
        stage.browser.js(&format!("document.getElementById('{field}').focus()")).await;
        stage.browser.type_text(&value).await;
    }
    stage.browser.click("document.getElementById('kc-login')").await;
}

/// Status and JSON of a request that the console's page sends.
async fn fetched(stage: &mut Stage, method: &str, path: &str) -> (Value, Value) {
    let script = format!(
        "fetch('{path}', {{ method: '{method}' }}).then(async (answer) => [answer.status, await answer.json().catch(() => null)])"
    );
    let result = stage.browser.js(&script).await;
    (result[0].clone(), result[1].clone())
}

async fn cookies(stage: &mut Stage) -> Vec<Value> {
    let result = stage.browser.call("Network.getCookies", json!({})).await;
    result["cookies"].as_array().unwrap().iter().filter(|one| one["name"] == "vibrissa-session").cloned().collect()
}

#[tokio::test]
async fn people_sign_in_with_keycloak_and_out_again() {
    let folder = tempfile::tempdir().unwrap();
    let keycloak = match Keycloak::start(folder.path()).await {
        Ok(keycloak) => keycloak,
        Err(why) => {
            eprintln!("skipped: sign-in with a real identity provider: {why}");
            return;
        }
    };
    let port = free_port();
    let oidc = OidcOptions {
        issuer: keycloak.issuer(),
        audience: "vibrissa".to_owned(),
        jwks_url: None,
        role_claim: "vibrissa_role".to_owned(),
        fleets_claim: "vibrissa_fleets".to_owned(),
        sign_in: Some(SignInOptions {
            client_id: "vibrissa".to_owned(),
            client_secret: Some(Secret::new("a-secret-of-this-test-only")),
            scopes: vec!["profile".to_owned()],
            public_url: format!("http://127.0.0.1:{port}"),
        }),
    };
    let mut stage = Stage::at(port, AccessOptions { token: None, oidc: Some(oidc) }).await;
    stage.open("#/fleets/f").await;
    comes(&mut stage, "the sign-in is offered", OFFERED).await;
    assert_eq!(complaints(&mut stage.browser).await, Vec::<String>::new());
    stage.picture("sign-in").await;

    // With a role: back to the page that was asked for, with a session that no script can read.
    sign_in(&mut stage, "ann").await;
    comes(&mut stage, "the fleet", "document.querySelector('h1')?.textContent === 'Fleet f'").await;
    let user = "document.getElementById('user')?.textContent.startsWith('Ann Bell, operator')";
    comes(&mut stage, "the user", user).await;
    assert_eq!(stage.browser.js("document.cookie + sessionStorage.length + localStorage.length").await, json!("00"));
    let session = cookies(&mut stage).await;
    assert_eq!((&session[0]["httpOnly"], &session[0]["sameSite"]), (&json!(true), &json!("Strict")));
    let (_, me) = fetched(&mut stage, "GET", "v1/me").await;
    assert_eq!(
        (&me["authentication"], &me["role"], &me["fleets"]),
        (&json!("SESSION"), &json!("OPERATOR"), &Value::Null)
    );
    let hold = "v1/fleets/f/robots/r/hold";
    assert_eq!(fetched(&mut stage, "POST", hold).await.0, json!(200));
    let (_, audit) = fetched(&mut stage, "GET", "v1/audit").await;
    let actors: Vec<String> = audit["items"].as_array().unwrap().iter().map(|one| one["actor"].to_string()).collect();
    assert!(actors.len() == 2 && actors.iter().all(|actor| actor.starts_with("\"oidc:Ann Bell#")), "{actors:?}");
    assert_eq!(audit["items"][1]["kind"], "SIGN_IN");
    assert!(!audit.to_string().contains(session[0]["value"].as_str().unwrap()));
    stage.picture("signed-in").await;

    // The cookie alone changes nothing from elsewhere, and a stranger's callback begins no session.
    let cookie = format!("vibrissa-session={}", session[0]["value"].as_str().unwrap());
    let from = |origin: &'static str| [("Cookie".to_owned(), cookie.clone()), ("Origin".to_owned(), origin.to_owned())];
    for headers in [from("http://localhost:1").to_vec(), vec![("Cookie".to_owned(), cookie.clone())]] {
        let headers: Vec<(&str, &str)> = headers.iter().map(|(name, value)| (name.as_str(), value.as_str())).collect();
        let answer = ask(stage.service.http, "POST", "/v1/fleets/f/robots/r/release", &headers).await.unwrap();
        assert_eq!(answer.status, 403, "{}", answer.body);
    }
    let answer = ask(stage.service.http, "GET", "/auth/callback?code=a&state=b", &[]).await.unwrap();
    assert_eq!((answer.status, answer.headers["location"].as_str()), (303, "/#/fleets?sign_in=EXPIRED"));
    let answer = ask(stage.service.http, "GET", "/auth/sign-in?to=//evil.example", &[]).await.unwrap();
    assert!(answer.headers["location"].starts_with(&keycloak.issuer()), "{answer:?}");
    assert!(answer.headers["location"].contains("code_challenge_method=S256"), "{answer:?}");

    // Tokens are renewed: they last for 30 s here, and are renewed 20 s before.
    let before = stage.sealed().await;
    let deadline = Instant::now() + PATIENCE;
    while stage.sealed().await == before {
        assert!(Instant::now() < deadline, "no renewal");
        assert_eq!(fetched(&mut stage, "GET", "v1/me").await.0, json!(200));
        tokio::time::sleep(Duration::from_secs(1)).await;
    }

    // Signed out: here and at the provider, which asks for a password again.
    stage.browser.click("document.getElementById('sign-out')").await;
    comes(&mut stage, "it is offered again", OFFERED).await;
    assert_eq!(cookies(&mut stage).await, Vec::<Value>::new());
    let headers = [("Cookie", cookie.as_str())];
    let answer = ask(stage.service.http, "GET", "/v1/me", &headers).await.unwrap();
    assert!(answer.status == 401 && answer.body.contains("the session has ended"), "{}", answer.body);

    // Without a role nobody is let in, and the page says why.
    sign_in(&mut stage, "bob").await;
    let condition = "document.querySelector('[role=alert]')?.textContent.includes('no role')";
    comes(&mut stage, "the reason", condition).await;
    stage.picture("sign-in-no-role").await;

    // The provider ends the session: the page says so.
    keycloak.end_all_sessions();
    stage.open("#/fleets").await;
    sign_in(&mut stage, "ann").await;
    comes(&mut stage, "the user", user).await;
    keycloak.end_all_sessions();
    let condition = "document.querySelector('[role=alert]')?.textContent.includes('session has ended')";
    comes(&mut stage, "the end of the session", condition).await;
    stage.picture("session-ended").await;
    stage.stop().await;
}
