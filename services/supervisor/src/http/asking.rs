//! Asking for actions: who, why, under which key; and the answer.

use axum::extract::{Extension, FromRequestParts};
use axum::http::request::Parts;
use axum::http::{HeaderValue, StatusCode, header};
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
use vibrissa_edge::clock::wall_clock;
use vibrissa_store::actions::{Asked, NewAction};
use vibrissa_store::list::{Filter, Value as Sql};
use vibrissa_store::lists::actions::{ACTIONS, ActionRow};

/// An action that was not carried out by then is not carried out any more: what was right when it was asked may be
/// wrong later.
const LIFETIME: Duration = Duration::from_secs(10);
/// How long an answer is waited for before the caller is told to look later.
const PATIENCE: Duration = Duration::from_secs(5);
/// Characters of a key at the most.
const KEY_CHARS_MAX: usize = 128;
/// Characters of a reason at the most.
const REASON_CHARS_MAX: usize = 1000;

/// Why, for those who read the audit log.
#[derive(Debug, Clone, Default, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Why {
    /// In your words; at most 1000 characters.
    #[schema(max_length = 1000)]
    pub reason: Option<String>,
}

/// Checks a reason.
///
/// # Errors
/// It is too long, or has characters that no text has.
pub fn reason(reason: Option<String>) -> Result<Option<String>, Problem> {
    match &reason {
        Some(text) if text.chars().count() > REASON_CHARS_MAX => {
            Err(Problem::invalid("reason", format!("must have at most {REASON_CHARS_MAX} characters")))
        }
        // PostgreSQL cannot keep it.
        Some(text) if text.contains('\0') => Err(Problem::invalid("reason", "must not contain a NUL character")),
        _ => Ok(reason),
    }
}

/// Who asks, with what is needed to write it down.
#[derive(Debug, Clone)]
pub struct Asker {
    /// Who.
    pub caller: Caller,
    /// The request's name.
    pub request_id: String,
    /// What names the action if it is sent again.
    pub idempotency_key: Option<String>,
}

impl<S: Send + Sync> FromRequestParts<S> for Asker {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Problem> {
        let absent = |_| Problem::new(Kind::Internal, "the request came past the gate");
        let Extension(caller) = Extension::<Caller>::from_request_parts(parts, state).await.map_err(absent)?;
        let Extension(RequestId(request_id)) = Extension::from_request_parts(parts, state).await.map_err(absent)?;
        let told = parts.headers.get("idempotency-key");
        let key = told.map(|told| told.to_str().ok().filter(|key| is_key(key)).map(ToOwned::to_owned));
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
    /// An action of theirs; what it is about is filled in by the caller.
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

/// What was asked, or was asked before under the same key.
///
/// # Errors
/// The key names something else.
pub fn number_of(asked: Asked) -> Result<i64, Problem> {
    match asked {
        Asked::New(action_id) => Ok(action_id),
        Asked::Again(action) => Ok(action.action_id),
        Asked::Different(action) => Err(Problem::new(
            Kind::KeyReused,
            format!("the Idempotency-Key names action {} ({}): take another key", action.action_id, action.kind),
        )),
    }
}

/// Asks the fleet's engine and waits for its answer: done, refused, or not answered yet.
///
/// # Errors
/// It is refused, too late, or the database does not answer.
pub async fn ask(app: &App, fleet: &Name, action: &NewAction) -> Result<Response, Problem> {
    let action_id = number_of(app.store.ask(action).await?)?;
    app.mailroom.ring(fleet);
    let answer = app.mailroom.answer(&app.store, action_id, PATIENCE).await?;
    let state = answer.as_ref().map_or("PENDING", |answer| answer.state.as_str());
    if let Some((word, told)) = answer.as_ref().and_then(|answer| answer.refusal()) {
        let kind = match word {
            "UNKNOWN_ROBOT" | "UNKNOWN_WHISKER" => Kind::NotFound,
            "VERSION" => Kind::VersionChanged,
            "PRESSURE_OUT_OF_RANGE" => return Err(Problem::invalid("pressure_mpa", told)),
            "MALFORMED" => Kind::Invalid,
            _ => Kind::Refused,
        };
        return Err(Problem::new(kind, format!("{told} (action {action_id})")));
    }
    if state == "EXPIRED" {
        let told = format!("nobody supervises the fleet {fleet} now: action {action_id} has expired, nothing was done");
        return Err(Problem::new(Kind::NotSupervised, told));
    }
    answered(app, action_id, if state == "PENDING" { StatusCode::ACCEPTED } else { StatusCode::OK }).await
}

/// The action as the answer, with where to look for it later.
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
