//! Operators' actions on all alarms that meet conditions.

use axum::extract::State;
use axum::response::Json;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use utoipa::ToSchema;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vibrissa_edge::actions::RecordedKind;
use vibrissa_edge::words::Word;
use vibrissa_store::alarms::Said;
use vibrissa_store::alarms_at_once::AT_ONCE_MAX;
use vibrissa_store::list::{Filter, Value as Sql};
use vibrissa_store::time::Time;

use super::alarm_actions::shelved;
use super::alarms::{Alarm, AlarmFilter};
use crate::http::App;
use crate::http::asking::{Asker, number_of, reason};
use crate::http::extract::Body;
use crate::http::moment::Moment;
use crate::http::problem::Problem;

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new()
        .routes(routes!(acknowledge_alarms))
        .routes(routes!(shelve_alarms))
        .routes(routes!(unshelve_alarms))
}

/// The alarms that a request concerns.
#[derive(Debug, Clone, Default, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Which {
    /// Conditions on the alarms.
    #[serde(default)]
    pub filter: AlarmFilter,
    /// Greatest number of an alarm that it may concern, such as `newest_alarm_id` of the dry run: alarms that were raised
    /// later are left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 0)]
    pub up_to_alarm_id: Option<i64>,
}

/// Alarms to acknowledge or unshelve.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct AlarmsAtOnce {
    /// Alarms that the request concerns.
    #[serde(default)]
    pub which: Which,
    /// True: only list the alarms, and change nothing.
    #[serde(default)]
    pub dry_run: bool,
    /// Reason in free text, at most 1000 characters.
    #[schema(max_length = 1000)]
    pub reason: Option<String>,
}

/// Alarms to shelve.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ShelfAtOnce {
    /// Alarms that the request concerns.
    #[serde(default)]
    pub which: Which,
    /// True: only list the alarms, and change nothing.
    #[serde(default)]
    pub dry_run: bool,
    /// End of the shelving (RFC 3339), at most 30 days from now.
    #[schema(value_type = String, format = DateTime, example = "2026-11-22T08:00:00Z")]
    pub until: Moment,
    /// Reason in free text, 1 to 1000 characters.
    #[schema(min_length = 1, max_length = 1000)]
    pub reason: String,
}

/// Alarms that a request would change, or has changed.
#[derive(Debug, Serialize, ToSchema)]
pub struct AlarmsChanged {
    /// Whether nothing was changed.
    pub dry_run: bool,
    /// Number of alarms, at most 1000. An alarm that changed meanwhile is not counted.
    #[schema(minimum = 0, maximum = 1000)]
    pub alarms: i64,
    /// Whether further alarms meet the conditions: repeat the request for them.
    pub more: bool,
    /// Greatest number of these alarms, for `up_to_alarm_id`; null without alarms and after a repeated request.
    pub newest_alarm_id: Option<i64>,
    /// Number of the action in the audit log that stands for the request; each alarm has its own action beside it. Null in a
    /// dry run.
    pub action_id: Option<i64>,
    /// The alarms, the most urgent first, in a dry run only.
    pub items: Vec<Alarm>,
}

/// A request about many alarms.
struct Request {
    which: Which,
    dry_run: bool,
    said: Said,
    reason: Option<String>,
}

/// Name of the action for the whole request, of that for each alarm, and parameters of both.
fn kinds(said: Said) -> (RecordedKind, RecordedKind, Value) {
    match said {
        Said::Acknowledged => (RecordedKind::AlarmsAcknowledge, RecordedKind::AlarmAcknowledge, json!({})),
        Said::Shelved { until_us } => {
            (RecordedKind::AlarmsShelve, RecordedKind::AlarmShelve, json!({ "until": Time(until_us) }))
        }
        Said::Unshelved => (RecordedKind::AlarmsUnshelve, RecordedKind::AlarmUnshelve, json!({})),
    }
}

async fn say(app: &App, asker: Asker, request: Request) -> Result<Json<AlarmsChanged>, Problem> {
    let reason = reason(request.reason)?;
    let (of_all, of_each, parameters) = kinds(request.said);
    let mut all = parameters.clone();
    if let Value::Object(all) = &mut all {
        all.insert("which".to_owned(), json!(request.which));
    }
    let fleet = request.which.filter.fleet.as_ref().and_then(|fleets| fleets.only()).map(ToOwned::to_owned);
    let mut filters = request.which.filter.conditions(&asker.caller.scope)?;
    if let Some(id) = request.which.up_to_alarm_id {
        if id < 0 {
            return Err(Problem::invalid("which.up_to_alarm_id", format!("must be at least 0, not {id}")));
        }
        filters.push(Filter::Below("alarm_id", Sql::Whole(id.saturating_add(1))));
    }
    let concerned = app.store.alarms_concerned(filters, request.said).await?;
    let newest_alarm_id = concerned.alarms.iter().map(|one| one.alarm_id).max();
    let more = concerned.more;
    if request.dry_run {
        let alarms = concerned.alarms.len() as i64;
        let items = concerned.alarms.into_iter().map(|row| Alarm::of(row, app)).collect();
        let changed = AlarmsChanged { dry_run: true, alarms, more, newest_alarm_id, action_id: None, items };
        return Ok(Json(changed));
    }
    let mut each = asker.clone().action(of_each.word(), &parameters, reason.clone());
    each.idempotency_key = None;
    let mut all = asker.action(of_all.word(), &all, reason);
    all.fleet = fleet;
    let done = app.store.say_to_alarms(&concerned.alarms, request.said, &all, &each).await?;
    let action_id = Some(number_of(done.asked)?);
    app.action_notifier.changed();
    let (alarms, items) = (done.alarms, Vec::new());
    Ok(Json(AlarmsChanged { dry_run: false, alarms, more, newest_alarm_id, action_id, items }))
}

/// Acknowledge all alarms that meet the conditions and are not acknowledged, at most 1000, the most urgent first.
///
/// With `dry_run` it lists them and changes nothing. Each alarm gets its own entry in the audit log.
#[utoipa::path(
    post, path = "/v1/alarms/acknowledge", tag = "alarms",
    params(("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")),
    request_body = AlarmsAtOnce,
    responses((status = 200, description = "The alarms", body = AlarmsChanged)),
    extensions(("x-required-role" = json!("OPERATOR")))
)]
async fn acknowledge_alarms(
    State(app): State<App>,
    asker: Asker,
    Body(body): Body<AlarmsAtOnce>,
) -> Result<Json<AlarmsChanged>, Problem> {
    let AlarmsAtOnce { which, dry_run, reason } = body;
    say(&app, asker, Request { which, dry_run, said: Said::Acknowledged, reason }).await
}

/// Shelve all alarms that meet the conditions and are not shelved, at most 1000, the most urgent first.
///
/// With `dry_run` it lists them and changes nothing. Each alarm gets its own entry in the audit log.
#[utoipa::path(
    post, path = "/v1/alarms/shelve", tag = "alarms",
    params(("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")),
    request_body = ShelfAtOnce,
    responses((status = 200, description = "The alarms", body = AlarmsChanged)),
    extensions(("x-required-role" = json!("OPERATOR")))
)]
async fn shelve_alarms(
    State(app): State<App>,
    asker: Asker,
    Body(body): Body<ShelfAtOnce>,
) -> Result<Json<AlarmsChanged>, Problem> {
    let ShelfAtOnce { which, dry_run, until, reason } = body;
    let said = shelved(until, &reason)?;
    say(&app, asker, Request { which, dry_run, said, reason: Some(reason) }).await
}

/// Unshelve all shelved alarms that meet the conditions, at most 1000, the most urgent first.
///
/// With `dry_run` it lists them and changes nothing. Each alarm gets its own entry in the audit log.
#[utoipa::path(
    post, path = "/v1/alarms/unshelve", tag = "alarms",
    params(("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")),
    request_body = AlarmsAtOnce,
    responses((status = 200, description = "The alarms", body = AlarmsChanged)),
    extensions(("x-required-role" = json!("OPERATOR")))
)]
async fn unshelve_alarms(
    State(app): State<App>,
    asker: Asker,
    Body(body): Body<AlarmsAtOnce>,
) -> Result<Json<AlarmsChanged>, Problem> {
    let AlarmsAtOnce { which, dry_run, reason } = body;
    say(&app, asker, Request { which, dry_run, said: Said::Unshelved, reason }).await
}

const _: () = assert!(AT_ONCE_MAX == 1000, "the texts above name the limit");
