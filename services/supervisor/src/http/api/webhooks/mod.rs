//! Webhooks: targets that get events, their secrets, and tests.

use axum::extract::{Extension, State};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Json, Response};
use serde::{Deserialize, Serialize};
use serde_json::json;
use utoipa::{IntoParams, ToSchema};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use crate::events::Event;
use crate::http::App;
use crate::http::access::Caller;
use crate::http::asking::{Asker, Why, answered, number_of, reason};
use crate::http::extract::{Body, OptionalBody, Path};
use crate::http::problem::{Kind, Problem};
use crate::webhooks::signature::{new_secret, shown};
use crate::webhooks::{Letter, Message};
use vibrissa_edge::actions::RecordedKind;
use vibrissa_edge::clock::wall_clock;
use vibrissa_edge::fleets::FleetSelection;
use vibrissa_edge::words::Word as _;
use vibrissa_store::actions::{Asked, NewAction};
use vibrissa_store::lists::actions::ActionRow;
use vibrissa_store::webhooks::manage::{Set, WebhookSettings};
use vibrissa_store::webhooks::{WEBHOOKS_MAX, WEBHOOKS_PER_FLEET_MAX, WebhookRow};

mod document;

pub use document::{Webhook, WebhookBody, WebhookList, WebhookState, WebhookWithSecret};
use document::{is_covered, origin};

/// Default and maximum of the time for which the previous secret stays valid, in s.
const OVERLAP_S: u32 = 86_400;
const OVERLAP_S_MAX: u32 = 7 * 86_400;

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new()
        .routes(routes!(list_webhooks, create_webhook))
        .routes(routes!(get_webhook, change_webhook, remove_webhook))
        .routes(routes!(renew_secret))
        .routes(routes!(test_webhook))
}

/// Path parameters of a webhook.
#[derive(Debug, Clone, Deserialize, IntoParams)]
#[into_params(parameter_in = Path)]
pub struct WebhookPath {
    /// Number of the webhook.
    #[param(minimum = 0)]
    pub webhook_id: i64,
}

/// The webhook of a path, if the caller may see it.
pub(super) async fn found(app: &App, caller: &Caller, at: &WebhookPath) -> Result<WebhookRow, Problem> {
    let row = app.store.webhook(at.webhook_id).await?.filter(|row| is_covered(caller, row.fleets.as_deref()));
    row.ok_or_else(|| {
        let problem = format!("there is no webhook {}, or your token does not cover all its fleets", at.webhook_id);
        Problem::unknown(problem)
    })
}

async fn detail(app: &App, caller: &Caller, row: &WebhookRow) -> Result<Webhook, Problem> {
    let queue = app.store.webhook_queues(std::slice::from_ref(row)).await?.pop().unwrap_or_default();
    Ok(Webhook::of(row, queue, caller))
}

/// The entry in the audit log. Neither secrets nor paths of URLs are logged.
pub(super) fn audited(
    asker: Asker,
    kind: RecordedKind,
    (webhook_id, settings): (Option<i64>, &WebhookSettings),
    why: Option<String>,
) -> NewAction {
    let WebhookSettings { name, url, fleets, kinds, level, enabled } = settings;
    let parameters = json!({
        "webhook_id": webhook_id, "name": name, "origin": origin(url), "fleets": fleets, "kinds": kinds, "level": level,
        "enabled": enabled,
        // Tells a repeated request from one with another path.
        "url_hash": blake3::hash(url.as_bytes()).to_hex()[..16],
    });
    let mut action = asker.action(kind.word(), &parameters, why);
    let fleets = fleets.as_ref().and_then(|fleets| fleets.parse::<FleetSelection>().ok());
    action.fleet = fleets.and_then(|fleets| fleets.only().map(ToOwned::to_owned));
    action
}

pub(super) fn settings_of(row: &WebhookRow) -> WebhookSettings {
    WebhookSettings {
        name: row.name.clone(),
        url: row.url.clone(),
        fleets: row.fleets.clone(),
        kinds: row.kinds.clone(),
        level: row.level.clone(),
        enabled: row.enabled,
    }
}

/// Why there is no place for a webhook of these fleets; `None` for the service as a whole.
fn full(fleet: Option<&str>) -> String {
    match fleet {
        Some(fleet) => format!("fleet {fleet} has {WEBHOOKS_PER_FLEET_MAX} webhooks already: remove one"),
        None => format!(
            "there are {WEBHOOKS_MAX} webhooks already, or {WEBHOOKS_PER_FLEET_MAX} for all fleets or \
             patterns: remove one"
        ),
    }
}

fn unset(set: Set, name: &str, webhook_id: i64) -> Problem {
    match set {
        Set::NameTaken => Problem::invalid("name", format!("another webhook is called {name:?}")),
        Set::Full(fleet) => Problem::new(Kind::Refused, full(fleet.as_deref())),
        Set::Absent | Set::Done(_) | Set::Known(_) => Problem::unknown(format!("there is no webhook {webhook_id}")),
    }
}

/// All webhooks, each with its queue and its last answer.
#[utoipa::path(
    get, path = "/v1/webhooks", tag = "webhooks",
    responses((status = 200, description = "The webhooks", body = WebhookList)),
    extensions(("x-required-role" = json!("OPERATOR")))
)]
async fn list_webhooks(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
) -> Result<Json<WebhookList>, Problem> {
    let mut rows = app.store.webhooks().await?;
    rows.retain(|row| is_covered(&caller, row.fleets.as_deref()));
    let queues = app.store.webhook_queues(&rows).await?;
    let items = rows.iter().zip(queues).map(|(row, queue)| Webhook::of(row, queue, &caller)).collect();
    Ok(Json(WebhookList { items }))
}

/// Create a webhook. It gets the events from now on. Its secret is shown only in this answer.
#[utoipa::path(
    post, path = "/v1/webhooks", tag = "webhooks",
    params(("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")),
    request_body = WebhookBody,
    responses((status = 201, description = "The webhook is created", body = WebhookWithSecret)),
    extensions(("x-required-role" = json!("ADMIN")))
)]
async fn create_webhook(
    State(app): State<App>,
    asker: Asker,
    Body(body): Body<WebhookBody>,
) -> Result<Response, Problem> {
    let caller = asker.caller.clone();
    let (settings, why) = (body.settings(&app, &caller)?, reason(body.reason)?);
    let secret = new_secret();
    let action = audited(asker, RecordedKind::WebhookCreate, (None, &settings), why);
    let (row, secret) = match app.store.add_webhook(&settings, &secret, &action).await? {
        Set::Done(webhook_id) => {
            let row = app.store.webhook(webhook_id).await?;
            let secret = row.as_ref().is_some_and(|row| !row.is_mail()).then(|| shown(&secret));
            (row, secret)
        }
        Set::Known(asked) => {
            number_of(*asked)?;
            (app.store.webhooks().await?.into_iter().find(|row| row.name == settings.name), None)
        }
        other @ (Set::Absent | Set::NameTaken | Set::Full(_)) => return Err(unset(other, &settings.name, 0)),
    };
    let row = row.ok_or_else(|| Problem::unknown("the webhook was removed meanwhile"))?;
    let place = [(header::LOCATION, format!("/v1/webhooks/{}", row.webhook_id))];
    let webhook = detail(&app, &caller, &row).await?;
    Ok((StatusCode::CREATED, place, Json(WebhookWithSecret { webhook, secret })).into_response())
}

/// One webhook with its queue and its last answer.
#[utoipa::path(
    get, path = "/v1/webhooks/{webhook_id}", tag = "webhooks", params(WebhookPath),
    responses((status = 200, description = "The webhook", body = Webhook)),
    extensions(("x-required-role" = json!("OPERATOR")))
)]
async fn get_webhook(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    Path(at): Path<WebhookPath>,
) -> Result<Json<Webhook>, Problem> {
    let row = found(&app, &caller, &at).await?;
    Ok(Json(detail(&app, &caller, &row).await?))
}

/// Change a webhook. Fields that are omitted get their defaults. Waiting events are tried at once.
#[utoipa::path(
    put, path = "/v1/webhooks/{webhook_id}", tag = "webhooks",
    params(WebhookPath, ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")),
    request_body = WebhookBody,
    responses((status = 200, description = "The webhook is changed", body = Webhook)),
    extensions(("x-required-role" = json!("ADMIN")))
)]
async fn change_webhook(
    State(app): State<App>,
    asker: Asker,
    Path(at): Path<WebhookPath>,
    Body(body): Body<WebhookBody>,
) -> Result<Json<Webhook>, Problem> {
    let caller = asker.caller.clone();
    found(&app, &caller, &at).await?;
    let (settings, why) = (body.settings(&app, &caller)?, reason(body.reason)?);
    let action = audited(asker, RecordedKind::WebhookChange, (Some(at.webhook_id), &settings), why);
    match app.store.change_webhook(at.webhook_id, &settings, &action).await? {
        Set::Done(_) => {}
        Set::Known(asked) => drop(number_of(*asked)?),
        other @ (Set::Absent | Set::NameTaken | Set::Full(_)) => {
            return Err(unset(other, &settings.name, at.webhook_id));
        }
    }
    let row = found(&app, &caller, &at).await?;
    Ok(Json(detail(&app, &caller, &row).await?))
}

/// Remove a webhook with its waiting events and dead letters.
#[utoipa::path(
    delete, path = "/v1/webhooks/{webhook_id}", tag = "webhooks",
    params(WebhookPath, ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")),
    request_body = Option<Why>,
    responses((status = 200, description = "The webhook is removed", body = ActionRow)),
    extensions(("x-required-role" = json!("ADMIN")))
)]
async fn remove_webhook(
    State(app): State<App>,
    asker: Asker,
    Path(at): Path<WebhookPath>,
    OptionalBody(why): OptionalBody<Why>,
) -> Result<Response, Problem> {
    let row = found(&app, &asker.caller, &at).await?;
    let of = (Some(at.webhook_id), &settings_of(&row));
    let action = audited(asker, RecordedKind::WebhookRemove, of, reason(why.reason)?);
    let action_id = number_of(app.store.remove_webhook(at.webhook_id, &action).await?)?;
    answered(&app, action_id, StatusCode::OK).await
}

/// For how long the previous secret stays valid.
#[derive(Debug, Default, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = NewWebhookSecret)]
pub struct SecretBody {
    /// Seconds for which the previous secret signs requests, too; a day if omitted. 0 ends it at once.
    #[schema(maximum = 604_800)]
    pub overlap_s: Option<u32>,
    /// Reason in free text, at most 1000 characters.
    #[schema(max_length = 1000)]
    pub reason: Option<String>,
}

/// Give a webhook a new secret, which is shown only in this answer.
///
/// Requests carry the signatures of the new and of the previous secret until the overlap ends, so that the receiver can
/// change its secret meanwhile.
#[utoipa::path(
    post, path = "/v1/webhooks/{webhook_id}/secret", tag = "webhooks",
    params(WebhookPath, ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")),
    request_body = Option<SecretBody>,
    responses((status = 200, description = "The webhook has a new secret", body = WebhookWithSecret)),
    extensions(("x-required-role" = json!("ADMIN")))
)]
async fn renew_secret(
    State(app): State<App>,
    asker: Asker,
    Path(at): Path<WebhookPath>,
    OptionalBody(body): OptionalBody<SecretBody>,
) -> Result<Json<WebhookWithSecret>, Problem> {
    let caller = asker.caller.clone();
    let row = found(&app, &caller, &at).await?;
    let overlap_s = body.overlap_s.unwrap_or(OVERLAP_S);
    if overlap_s > OVERLAP_S_MAX {
        return Err(Problem::invalid("overlap_s", format!("must be at most {OVERLAP_S_MAX} (a week)")));
    }
    let secret = new_secret();
    let of = (Some(at.webhook_id), &settings_of(&row));
    let action = audited(asker, RecordedKind::WebhookSecret, of, reason(body.reason)?);
    let until_us = wall_clock().0 as i64 + i64::from(overlap_s) * 1_000_000;
    let asked = app.store.renew_webhook_secret(at.webhook_id, &secret, until_us, &action).await?;
    let secret = matches!(asked, Asked::New(_)).then(|| shown(&secret));
    number_of(asked)?;
    let row = found(&app, &caller, &at).await?;
    Ok(Json(WebhookWithSecret { webhook: detail(&app, &caller, &row).await?, secret }))
}

/// Result of a test.
#[derive(Debug, Serialize, ToSchema)]
pub struct WebhookTest {
    /// Whether the target took the test.
    pub delivered: bool,
    /// Status of its answer, of HTTP or SMTP; null without an answer.
    #[schema(minimum = 100, maximum = 999)]
    pub status: Option<u16>,
    /// Why it did not take the test; null if it did.
    pub problem: Option<String>,
    /// Time until the answer, in ms.
    #[schema(minimum = 0)]
    pub duration_ms: u64,
}

/// Send a test to a webhook and wait for its answer, for at most 10 s.
///
/// The test is an event of type `TEST`. It passes the waiting events, and is sent to disabled webhooks, too. A caller may
/// have two tests under way, the callers of a fleet four, a service sixteen; beyond that the answer is 429.
#[utoipa::path(
    post, path = "/v1/webhooks/{webhook_id}/test", tag = "webhooks",
    params(WebhookPath, ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")),
    request_body = Option<Why>,
    responses((status = 200, description = "The answer of the target", body = WebhookTest)),
    extensions(("x-required-role" = json!("OPERATOR")))
)]
async fn test_webhook(
    State(app): State<App>,
    asker: Asker,
    Path(at): Path<WebhookPath>,
    OptionalBody(why): OptionalBody<Why>,
) -> Result<Json<WebhookTest>, Problem> {
    let row = found(&app, &asker.caller, &at).await?;
    // A pattern stands for several fleets.
    let fleets = row.fleets.iter().flat_map(|fleets| fleets.split(',')).filter(|fleet| !fleet.contains('*'));
    let _place = app.webhook_tests.take(&asker.caller.actor, fleets)?;
    let of = (Some(at.webhook_id), &settings_of(&row));
    let action = audited(asker, RecordedKind::WebhookTest, of, reason(why.reason)?);
    let action_id = number_of(app.store.record_webhook_action(&action).await?)?;
    let id = format!("vibrissa-{}-test-{action_id}", at.webhook_id);
    let secrets = app.store.webhook_secrets(at.webhook_id).await?;
    let (sender, begun) = (app.webhooks.sender(), tokio::time::Instant::now());
    let answer = if row.is_mail() {
        sender.send_mail(|mail| Letter::test(&row, id, mail)).await
    } else {
        let body = serde_json::to_vec(&Event::test()).unwrap_or_default();
        sender.send(Message { url: row.url, id, body, secrets }).await
    };
    let problem = answer.problem();
    let duration_ms = u64::try_from(begun.elapsed().as_millis()).unwrap_or(u64::MAX);
    Ok(Json(WebhookTest { delivered: problem.is_none(), status: answer.status, problem, duration_ms }))
}
