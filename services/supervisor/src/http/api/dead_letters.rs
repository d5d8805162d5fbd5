//! Dead letters of webhooks: events that a target has not taken after all attempts.

use axum::extract::{Extension, State};
use axum::response::Json;
use serde::{Deserialize, Serialize};
use serde_json::json;
use utoipa::ToSchema;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::webhooks::{WebhookPath, audited, found, settings_of};
use crate::events::{Event, published};
use crate::http::App;
use crate::http::access::Caller;
use crate::http::asking::{Asker, number_of, reason};
use crate::http::extract::{OptionalBody, Path};
use crate::http::problem::Problem;
use vibrissa_edge::actions::RecordedKind;
use vibrissa_store::time::Time;
use vibrissa_store::webhooks::DEAD_LETTERS_MAX;
use vibrissa_store::webhooks::dead::{DeadLetterRow, Fate};

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new()
        .routes(routes!(list_dead_letters))
        .routes(routes!(redeliver_dead_letters))
        .routes(routes!(discard_dead_letters))
}

/// An event that a webhook has not taken after all attempts.
#[derive(Debug, Serialize, ToSchema)]
pub struct DeadLetter {
    /// Number of the event.
    #[schema(minimum = 1)]
    pub event_id: i64,
    /// Number of failed attempts.
    #[schema(minimum = 1)]
    pub attempts: i64,
    /// Time of the last attempt.
    pub dead_at: Time,
    /// HTTP status of the last answer; null without an answer.
    #[schema(minimum = 100, maximum = 999)]
    pub status: Option<i64>,
    /// Why the last attempt failed.
    pub problem: String,
    /// Whether it is about to be delivered again.
    pub again: bool,
    /// The event.
    #[schema(value_type = Event)]
    pub event: serde_json::Value,
}

/// Dead letters of a webhook.
#[derive(Debug, Serialize, ToSchema)]
pub struct DeadLetterList {
    /// The dead letters, in the order of their events. There are at most 1,000; the oldest ones beyond were removed.
    pub items: Vec<DeadLetter>,
}

/// Which dead letters.
#[derive(Debug, Default, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = WhichDeadLetters)]
pub struct Which {
    /// Numbers of their events; all if omitted.
    #[schema(max_items = 1000)]
    pub event_ids: Option<Vec<i64>>,
    /// Reason in free text, at most 1000 characters.
    #[schema(max_length = 1000)]
    pub reason: Option<String>,
}

/// How many dead letters were changed.
#[derive(Debug, Serialize, ToSchema)]
pub struct DeadLettersChanged {
    /// Number of dead letters; 0 if the request was repeated.
    #[schema(minimum = 0)]
    pub dead_letters: u64,
}

/// The dead letters of a webhook, each with its event.
#[utoipa::path(
    get, path = "/v1/webhooks/{webhook_id}/dead-letters", tag = "webhooks", params(WebhookPath),
    responses((status = 200, description = "The dead letters", body = DeadLetterList)),
    extensions(("x-required-role" = json!("OPERATOR")))
)]
async fn list_dead_letters(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    Path(at): Path<WebhookPath>,
) -> Result<Json<DeadLetterList>, Problem> {
    found(&app, &caller, &at).await?;
    let letter = |(row, event): (DeadLetterRow, _)| DeadLetter {
        event_id: row.event_id,
        attempts: row.attempts,
        dead_at: Time(row.dead_us),
        status: row.status,
        problem: row.problem,
        again: row.again,
        event: serde_json::from_str(&published(&event)).unwrap_or_default(),
    };
    let items = app.store.dead_letters(at.webhook_id).await?.into_iter().map(letter).collect();
    Ok(Json(DeadLetterList { items }))
}

async fn settle(
    (app, asker, at, which): (App, Asker, WebhookPath, Which),
    (kind, fate): (RecordedKind, Fate),
) -> Result<Json<DeadLettersChanged>, Problem> {
    let row = found(&app, &asker.caller, &at).await?;
    if which.event_ids.as_ref().is_some_and(|ids| ids.len() as i64 > DEAD_LETTERS_MAX) {
        return Err(Problem::invalid("event_ids", format!("must have at most {DEAD_LETTERS_MAX} numbers")));
    }
    let mut action = audited(asker, kind, (Some(at.webhook_id), &settings_of(&row)), reason(which.reason)?);
    let parameters = json!({ "webhook_id": at.webhook_id, "name": row.name, "event_ids": which.event_ids });
    action.parameters = parameters.to_string();
    let settled = app.store.settle_dead_letters(at.webhook_id, which.event_ids.as_deref(), fate, &action);
    let (asked, dead_letters) = settled.await?;
    number_of(asked)?;
    Ok(Json(DeadLettersChanged { dead_letters }))
}

/// Deliver dead letters again, in the order of their events and before waiting ones.
#[utoipa::path(
    post, path = "/v1/webhooks/{webhook_id}/dead-letters/redeliver", tag = "webhooks",
    params(WebhookPath, ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")),
    request_body = Option<Which>,
    responses((status = 200, description = "They are about to be delivered", body = DeadLettersChanged)),
    extensions(("x-required-role" = json!("OPERATOR")))
)]
async fn redeliver_dead_letters(
    State(app): State<App>,
    asker: Asker,
    Path(at): Path<WebhookPath>,
    OptionalBody(which): OptionalBody<Which>,
) -> Result<Json<DeadLettersChanged>, Problem> {
    settle((app, asker, at, which), (RecordedKind::WebhookRedeliver, Fate::Again)).await
}

/// Delete dead letters.
#[utoipa::path(
    post, path = "/v1/webhooks/{webhook_id}/dead-letters/discard", tag = "webhooks",
    params(WebhookPath, ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")),
    request_body = Option<Which>,
    responses((status = 200, description = "They are deleted", body = DeadLettersChanged)),
    extensions(("x-required-role" = json!("OPERATOR")))
)]
async fn discard_dead_letters(
    State(app): State<App>,
    asker: Asker,
    Path(at): Path<WebhookPath>,
    OptionalBody(which): OptionalBody<Which>,
) -> Result<Json<DeadLettersChanged>, Problem> {
    settle((app, asker, at, which), (RecordedKind::WebhookDiscard, Fate::Discarded)).await
}
