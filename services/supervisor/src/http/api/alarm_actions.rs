//! Operators' actions on alarms.

use crate::http::App;
use crate::http::asking::{Asker, Why, answered, number_of, reason};
use crate::http::extract::{Body, OptionalBody, Path};
use crate::http::moment::Moment;
use crate::http::problem::{Kind, Problem};
use axum::extract::State;
use axum::http::StatusCode;
use axum::response::Response;
use serde::Deserialize;
use serde_json::json;
use utoipa::{IntoParams, ToSchema};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vibrissa_edge::actions::RecordedKind;
use vibrissa_edge::clock::wall_clock;
use vibrissa_edge::words::Word as _;
use vibrissa_store::alarms::{AlarmSubject, Said};
use vibrissa_store::lists::actions::ActionRow;
use vibrissa_store::time::Time;

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new()
        .routes(routes!(acknowledge_alarm))
        .routes(routes!(shelve_alarm))
        .routes(routes!(unshelve_alarm))
}

/// Longest time for which an alarm can be shelved, in µs (30 days), so that no alarm is forgotten.
const SHELF_US_MAX: i64 = 30 * 86_400 * 1_000_000;

/// Path parameters of an alarm.
#[derive(Debug, Clone, Deserialize, IntoParams)]
#[into_params(parameter_in = Path)]
pub struct AlarmPath {
    /// Number of the alarm.
    #[param(minimum = 0)]
    pub alarm_id: i64,
}

/// End and reason of the shelving.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = Shelf)]
pub struct ShelfBody {
    /// End of the shelving (RFC 3339), at most 30 days from now.
    #[schema(value_type = String, format = DateTime, example = "2026-11-22T08:00:00Z")]
    pub until: Moment,
    /// Reason in free text, 1 to 1000 characters.
    #[schema(min_length = 1, max_length = 1000)]
    pub reason: String,
}

/// Shelving until a time, for a reason.
///
/// # Errors
/// The time is not in the next 30 days, or the reason is empty.
pub(super) fn shelved(until: Moment, reason: &str) -> Result<Said, Problem> {
    let now_us = wall_clock().0 as i64;
    let Moment(Time(until_us)) = until;
    if until_us <= now_us || until_us.saturating_sub(now_us) > SHELF_US_MAX {
        return Err(Problem::invalid("until", "must be in the future, at most 30 days from now"));
    }
    if reason.trim().is_empty() {
        return Err(Problem::invalid("reason", "must not be empty: state why the alarm is shelved"));
    }
    Ok(Said::Shelved { until_us })
}

async fn subject(app: &App, at: &AlarmPath, asker: &Asker) -> Result<AlarmSubject, Problem> {
    let found = app.store.alarm_subject(at.alarm_id).await?;
    let found = found.filter(|subject| asker.caller.scope.covers(&subject.fleet));
    found.ok_or_else(|| Problem::not_found(format_args!("alarm {}", at.alarm_id)))
}

async fn say(
    app: &App,
    at: &AlarmPath,
    (asker, subject): (Asker, AlarmSubject),
    said: Said,
    why: Option<String>,
) -> Result<Response, Problem> {
    let (kind, parameters) = match said {
        Said::Acknowledged => (RecordedKind::AlarmAcknowledge, json!({})),
        Said::Shelved { until_us } => (RecordedKind::AlarmShelve, json!({ "until": Time(until_us) })),
        Said::Unshelved => (RecordedKind::AlarmUnshelve, json!({})),
    };
    let mut action = asker.action(kind.word(), &parameters, reason(why)?);
    action.fleet = Some(subject.fleet.clone());
    action.robot = Some(subject.robot.clone());
    action.array.clone_from(&subject.array);
    action.whisker = subject.whisker;
    action.alarm_id = Some(at.alarm_id);
    let Some(asked) = app.store.say_to_alarm(&subject, said, &action).await? else {
        return Err(nothing_to_change(subject.acknowledged_by.as_deref(), said));
    };
    let action_id = number_of(asked)?;
    app.action_notifier.changed();
    answered(app, action_id, StatusCode::OK).await
}

fn nothing_to_change(acknowledged_by: Option<&str>, said: Said) -> Problem {
    match said {
        Said::Acknowledged => {
            let by = acknowledged_by.unwrap_or("somebody");
            Problem::new(Kind::Refused, format!("{by} has already acknowledged the alarm"))
        }
        Said::Shelved { .. } | Said::Unshelved => Problem::new(
            Kind::Refused,
            "no person has shelved the alarm: a maintenance ends by itself, or with POST /v1/maintenance/NUMBER/end",
        ),
    }
}

/// Acknowledge an alarm.
#[utoipa::path(
    post, path = "/v1/alarms/{alarm_id}/acknowledge", tag = "alarms",
    params(AlarmPath, ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")),
    request_body = Option<Why>,
    responses((status = 200, description = "The alarm is acknowledged", body = ActionRow)),
    extensions(("x-required-role" = json!("OPERATOR")))
)]
async fn acknowledge_alarm(
    State(app): State<App>,
    Path(at): Path<AlarmPath>,
    asker: Asker,
    OptionalBody(why): OptionalBody<Why>,
) -> Result<Response, Problem> {
    let subject = subject(&app, &at, &asker).await?;
    say(&app, &at, (asker, subject), Said::Acknowledged, why.reason).await
}

/// Shelve an alarm: silence it, and others of its kind about the same whisker or robot, until a time.
#[utoipa::path(
    post, path = "/v1/alarms/{alarm_id}/shelve", tag = "alarms",
    params(AlarmPath, ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")),
    request_body = ShelfBody,
    responses((status = 200, description = "The alarm is shelved", body = ActionRow)),
    extensions(("x-required-role" = json!("OPERATOR")))
)]
async fn shelve_alarm(
    State(app): State<App>,
    Path(at): Path<AlarmPath>,
    asker: Asker,
    Body(shelf): Body<ShelfBody>,
) -> Result<Response, Problem> {
    let subject = subject(&app, &at, &asker).await?;
    let said = shelved(shelf.until, &shelf.reason)?;
    say(&app, &at, (asker, subject), said, Some(shelf.reason)).await
}

/// Unshelve an alarm, and others of its kind about the same whisker or robot.
#[utoipa::path(
    post, path = "/v1/alarms/{alarm_id}/unshelve", tag = "alarms",
    params(AlarmPath, ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")),
    request_body = Option<Why>,
    responses((status = 200, description = "The alarm is no longer shelved", body = ActionRow)),
    extensions(("x-required-role" = json!("OPERATOR")))
)]
async fn unshelve_alarm(
    State(app): State<App>,
    Path(at): Path<AlarmPath>,
    asker: Asker,
    OptionalBody(why): OptionalBody<Why>,
) -> Result<Response, Problem> {
    let subject = subject(&app, &at, &asker).await?;
    say(&app, &at, (asker, subject), Said::Unshelved, why.reason).await
}
