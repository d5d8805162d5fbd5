//! Signing in at the console with the identity provider: the authorisation code flow with PKCE, state and nonce. The
//! browser never sees a token: it gets a cookie that scripts cannot read, and other sites cannot use.

use axum::Router;
use axum::extract::{Query, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Json, Response};
use axum::routing::{get, post};
use base64::Engine as _;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;
use serde::Deserialize;
use serde_json::json;
use subtle::ConstantTimeEq as _;

use super::return_page::ReturnPage;
use super::session::{Attempt, Failure, SESSION_S, SignIn};
use crate::http::App;
use crate::http::access::Role;
use crate::http::access::cookies::{self, ATTEMPT, SESSION};
use crate::http::passage::RequestId;
use crate::http::problem::{Kind, Problem};
use vibrissa_edge::actions::RecordedKind;
use vibrissa_edge::clock::wall_clock;
use vibrissa_edge::words::Word as _;
use vibrissa_store::actions::NewAction;
use vibrissa_store::secret::Secret;

/// Time for a sign-in at the provider, s.
const ATTEMPT_S: i64 = 600;

/// Why a sign-in failed, as the console's address says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Cause {
    /// The person or the provider has cancelled it.
    Cancelled,
    /// It took too long, or was begun in another browser.
    Expired,
    /// The person has no role here.
    NoRole,
    /// The provider does not answer, or its answer is not valid.
    Provider,
}

impl Cause {
    const fn word(self) -> &'static str {
        match self {
            Self::Cancelled => "CANCELLED",
            Self::Expired => "EXPIRED",
            Self::NoRole => "NO_ROLE",
            Self::Provider => "PROVIDER",
        }
    }
}

/// The routes below `/auth`. They are open, because nobody is signed in yet.
pub(in crate::http) fn routes() -> Router<App> {
    Router::new()
        .route("/auth/options", get(options))
        .route("/auth/sign-in", get(sign_in))
        .route("/auth/callback", get(callback))
        .route("/auth/sign-out", post(sign_out))
}

/// Whether people can sign in with an identity provider.
async fn options(State(app): State<App>) -> Response {
    Json(json!({ "sign_in": app.access.sign_in().is_some() })).into_response()
}

/// The page to return to.
#[derive(Debug, Deserialize)]
struct To {
    to: Option<String>,
}

async fn sign_in(State(app): State<App>, Query(To { to }): Query<To>) -> Result<Response, Problem> {
    let sign_in = app.access.sign_in().ok_or_else(|| Problem::not_found("sign-in: no client is configured"))?;
    let attempt = Attempt::new(to.and_then(|to| to.parse().ok()).unwrap_or_default());
    let place = sign_in.authorization_url(&attempt).await?;
    let value = URL_SAFE_NO_PAD.encode(serde_json::to_vec(&attempt).unwrap_or_default());
    // Lax: the provider's page leads back here, from another site.
    let cookie = cookies::set(&ATTEMPT, &value, sign_in.site(), Some(ATTEMPT_S));
    go(&place, [cookie])
}

/// The provider's answer.
#[derive(Debug, Deserialize)]
struct CallbackQuery {
    code: Option<String>,
    state: Option<String>,
    iss: Option<String>,
    error: Option<String>,
    error_description: Option<String>,
}

async fn callback(
    State(app): State<App>,
    axum::Extension(RequestId(request_id)): axum::Extension<RequestId>,
    headers: HeaderMap,
    Query(answer): Query<CallbackQuery>,
) -> Result<Response, Problem> {
    let sign_in = app.access.sign_in().ok_or_else(|| Problem::not_found("sign-in: no client is configured"))?;
    let attempt = cookies::value(&headers, &ATTEMPT, sign_in.site());
    let attempt = attempt.and_then(|value| URL_SAFE_NO_PAD.decode(value).ok());
    let attempt: Option<Attempt> = attempt.and_then(|json| serde_json::from_slice(&json).ok());
    let over = cookies::clear(&ATTEMPT, sign_in.site());
    let failed = |cause: Cause, what: &str| {
        tracing::warn!(cause = cause.word(), what, "sign-in at the console failed");
        go(&format!("/{}?sign_in={}", ReturnPage::default(), cause.word()), [over.clone()])
    };
    let Some(attempt) = attempt else { return failed(Cause::Expired, "no attempt of this browser") };
    let is_same = |state: &String| bool::from(state.as_bytes().ct_eq(attempt.state.as_bytes()));
    if !answer.state.as_ref().is_some_and(is_same) {
        return failed(Cause::Expired, "the answer belongs to another attempt (state)");
    }
    if !sign_in.is_of_provider(answer.iss.as_deref()) {
        return failed(Cause::Provider, "the answer comes from another provider (iss)");
    }
    let Some(code) = answer.code.filter(|_| answer.error.is_none()) else {
        let what = [answer.error, answer.error_description].into_iter().flatten().collect::<Vec<_>>().join(": ");
        return failed(Cause::Cancelled, &what.chars().take(300).collect::<String>());
    };
    let begun = match sign_in.begin(&attempt, code).await {
        Ok(begun) => begun,
        Err(Failure::NoRole(what)) => return failed(Cause::NoRole, &what),
        Err(Failure::Provider(what)) => return failed(Cause::Provider, &what),
    };
    let action = audited(RecordedKind::SignIn, &begun.caller.name, &begun.caller.actor, begun.caller.role, request_id);
    app.store.add_session(&begun.row, &action).await?;
    // Strict: requests from other sites come without it. It ends with the browser, or with the session.
    let session = cookies::set(&SESSION, begun.cookie.reveal(), sign_in.site(), Some(SESSION_S));
    go(&format!("/{}", attempt.to), [over, session])
}

async fn sign_out(
    State(app): State<App>,
    axum::Extension(RequestId(request_id)): axum::Extension<RequestId>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let sign_in: &SignIn =
        app.access.sign_in().ok_or_else(|| Problem::not_found("sign-in: no client is configured"))?;
    cookies::require_own_page(&headers)?;
    let mut place = None;
    if let Some(cookie) = cookies::value(&headers, &SESSION, sign_in.site())
        && let Some(ending) = sign_in.ending(&app.store, &Secret::new(cookie)).await?
    {
        let action = audited(RecordedKind::SignOut, &ending.name, &ending.actor, ending.role, request_id);
        app.store.end_session(&ending.session_id, &action).await?;
        place = sign_in.end_session_url(&ending).await;
    }
    let mut response = (StatusCode::OK, Json(json!({ "end_session_url": place }))).into_response();
    add(&mut response, &cookies::clear(&SESSION, sign_in.site()))?;
    Ok(response)
}

/// The entry in the audit log.
fn audited(kind: RecordedKind, name: &str, actor: &str, role: Role, request_id: String) -> NewAction {
    let now_us = wall_clock().0 as i64;
    NewAction {
        fleet: None,
        robot: None,
        array: None,
        whisker: None,
        compensation_id: None,
        alarm_id: None,
        kind: kind.word().to_owned(),
        parameters: json!({ "name": name }).to_string(),
        reason: None,
        actor: actor.to_owned(),
        role: role.word().to_owned(),
        request_id,
        idempotency_key: None,
        asked_us: now_us,
        expires_us: now_us,
    }
}

fn add(response: &mut Response, cookie: &str) -> Result<(), Problem> {
    let value = HeaderValue::from_str(cookie).map_err(|problem| Problem::new(Kind::Internal, problem.to_string()))?;
    response.headers_mut().append(header::SET_COOKIE, value);
    Ok(())
}

/// Sends the browser to another page.
fn go<const COOKIES: usize>(place: &str, cookies: [String; COOKIES]) -> Result<Response, Problem> {
    let place = HeaderValue::from_str(place).map_err(|problem| Problem::new(Kind::Internal, problem.to_string()))?;
    let mut response = (StatusCode::SEE_OTHER, [(header::LOCATION, place)]).into_response();
    cookies.iter().try_for_each(|cookie| add(&mut response, cookie))?;
    Ok(response)
}
