//! Requests for actions: caller, reason, idempotency key, and the answer.

use axum::extract::{Extension, FromRequestParts};
use axum::http::request::Parts;
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Json, Response};
use serde::Deserialize;
use serde_json::Value;
use tokio::time::Duration;
use utoipa::ToSchema;
use vibrissa_protocol::Name;

use super::App;
use super::access::Caller;
use super::passage::RequestId;
use super::problem::{Kind, Problem};
use super::version::lists;
use vibrissa_edge::clock::wall_clock;
use vibrissa_store::actions::{Asked, NewAction};
use vibrissa_store::list::{Filter, Value as Sql};
use vibrissa_store::lists::actions::{ACTIONS, ActionRow};

/// Validity of a requested action. It is not executed later, because the circumstances may have changed.
const LIFETIME: Duration = Duration::from_secs(10);
/// Time to wait for the engine's answer before the response is 202 (still pending).
const PATIENCE: Duration = Duration::from_secs(5);
/// Maximum length of an idempotency key, in characters.
const KEY_CHARS_MAX: usize = 128;
/// Maximum length of a reason, in characters.
const REASON_CHARS_MAX: usize = 1000;

/// Optional reason of an action, stored in the audit log.
#[derive(Debug, Clone, Default, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Why {
    /// Reason in free text, at most 1000 characters.
    #[schema(max_length = 1000)]
    pub reason: Option<String>,
}

/// Checks the length and the characters of a reason.
///
/// # Errors
/// The reason is longer than 1000 characters, or contains a NUL character.
pub fn reason(reason: Option<String>) -> Result<Option<String>, Problem> {
    match &reason {
        Some(text) if text.chars().count() > REASON_CHARS_MAX => {
            Err(Problem::invalid("reason", format!("must have at most {REASON_CHARS_MAX} characters")))
        }
        // PostgreSQL cannot store NUL in a text.
        Some(text) if text.contains('\0') => Err(Problem::invalid("reason", "must not contain a NUL character")),
        _ => Ok(reason),
    }
}

/// The caller of an action, with the identifiers of the request for the audit log.
#[derive(Debug, Clone)]
pub struct Asker {
    /// Authenticated caller of the action.
    pub caller: Caller,
    /// Request ID (header `x-request-id`).
    pub request_id: String,
    /// Idempotency key: a repeated request with the same key returns the first action.
    pub idempotency_key: Option<String>,
}

impl<S: Send + Sync> FromRequestParts<S> for Asker {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Problem> {
        let absent = |_| Problem::new(Kind::Internal, "the request bypassed authentication");
        let Extension(caller) = Extension::<Caller>::from_request_parts(parts, state).await.map_err(absent)?;
        let Extension(RequestId(request_id)) = Extension::from_request_parts(parts, state).await.map_err(absent)?;
        let header = parts.headers.get("idempotency-key");
        let key = header.map(|header| header.to_str().ok().filter(|key| is_key(key)).map(ToOwned::to_owned));
        match key {
            Some(None) => Err(Problem::invalid(
                "Idempotency-Key",
                format!("must have 1 to {KEY_CHARS_MAX} visible ASCII characters"),
            )),
            key => Ok(Self { caller, request_id, idempotency_key: key.flatten() }),
        }
    }
}

fn is_key(text: &str) -> bool {
    (1..=KEY_CHARS_MAX).contains(&text.len()) && text.bytes().all(|byte| byte.is_ascii_graphic())
}

impl Asker {
    /// A new action of this caller. The handler fills in its subject (fleet, robot, whisker ...).
    #[must_use]
    pub fn action(self, kind: &str, parameters: &Value, reason: Option<String>) -> NewAction {
        let now_us = wall_clock().0 as i64;
        NewAction {
            fleet: None,
            robot: None,
            array: None,
            whisker: None,
            compensation_id: None,
            alarm_id: None,
            kind: kind.to_owned(),
            parameters: parameters.to_string(),
            reason,
            actor: self.caller.actor,
            role: self.caller.role.word().to_owned(),
            request_id: self.request_id,
            idempotency_key: self.idempotency_key,
            asked_us: now_us,
            expires_us: now_us + LIFETIME.as_micros() as i64,
        }
    }
}

/// Number of the action, new or stored earlier under the same idempotency key.
///
/// # Errors
/// The key belongs to a different action.
pub fn number_of(asked: Asked) -> Result<i64, Problem> {
    match asked {
        Asked::New(action_id) => Ok(action_id),
        Asked::Again(action) => Ok(action.action_id),
        Asked::Different(action) => Err(Problem::new(
            Kind::KeyReused,
            format!("Idempotency-Key already used for action {} ({}): take a new key", action.action_id, action.kind),
        )),
    }
}

/// The version that a request with the same idempotency key has replaced, if `If-Match` names it. The version in force
/// follows from that request, so it does not tell whether a repeated one is late.
///
/// # Errors
/// The database cannot be read.
pub async fn replaced_before(
    app: &App,
    asker: &Asker,
    kind: &str,
    fleet: &Name,
    headers: &HeaderMap,
) -> Result<Option<i64>, Problem> {
    if asker.idempotency_key.is_none() {
        return Ok(None);
    }
    let before = app.store.action_of_key(&asker.caller.actor, asker.idempotency_key.as_deref()).await?;
    let before = before.filter(|before| before.kind == kind && before.fleet.as_deref() == Some(fleet.as_str()));
    let parameters = before.and_then(|before| serde_json::from_str::<Value>(&before.parameters).ok());
    let version = parameters.and_then(|parameters| parameters["expected_version"].as_i64());
    Ok(version.filter(|version| lists(headers, header::IF_MATCH, *version)))
}

/// Sends an action to the fleet's engine and waits for its result: done, refused, or still pending.
///
/// # Errors
/// The action was refused or expired, or the database does not answer.
pub async fn ask(app: &App, fleet: &Name, action: &NewAction) -> Result<Response, Problem> {
    let action_id = number_of(app.store.ask(action).await?)?;
    app.action_notifier.notify(fleet);
    let answer = app.action_notifier.answer(&app.store, action_id, PATIENCE).await?;
    let state = answer.as_ref().map_or("PENDING", |answer| answer.state.as_str());
    if let Some((word, text)) = answer.as_ref().and_then(|answer| answer.refusal()) {
        let kind = match word {
            "UNKNOWN_ROBOT" | "UNKNOWN_WHISKER" => Kind::NotFound,
            "VERSION" => Kind::VersionChanged,
            "PRESSURE_OUT_OF_RANGE" => return Err(Problem::invalid("pressure_mpa", text)),
            "MALFORMED" => Kind::Invalid,
            _ => Kind::Refused,
        };
        return Err(Problem::new(kind, format!("{text} (action {action_id})")));
    }
    if state == "EXPIRED" {
        let problem = format!("no supervisor owns the fleet {fleet}: action {action_id} expired without effect");
        return Err(Problem::new(Kind::NotSupervised, problem));
    }
    answered(app, action_id, if state == "PENDING" { StatusCode::ACCEPTED } else { StatusCode::OK }).await
}

/// Responds with the row of the action; the header `Location` has the path for polling it.
///
/// # Errors
/// The database does not answer.
pub async fn answered(app: &App, action_id: i64, status: StatusCode) -> Result<Response, Problem> {
    let row: Option<ActionRow> =
        app.store.first(&ACTIONS, vec![Filter::Is("action_id", Sql::Whole(action_id))]).await?;
    let row = row.ok_or_else(|| Problem::not_found(format_args!("action {action_id}")))?;
    let mut response = (status, Json(row)).into_response();
    if let Ok(place) = HeaderValue::from_str(&format!("/v1/actions/{action_id}")) {
        response.headers_mut().insert(header::LOCATION, place);
    }
    Ok(response)
}
