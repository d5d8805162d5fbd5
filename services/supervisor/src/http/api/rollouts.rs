//! Staged roll-outs of policies and calibrations.

use axum::extract::{Extension, State};
use axum::response::{Json, Response};
use serde::{Deserialize, Serialize};
use serde_json::{Value as Parameters, json};
use utoipa::{IntoParams, ToSchema};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vibrissa_core::rollout::Rules;
use vibrissa_edge::actions::RecordedKind;
use vibrissa_edge::words::Word as _;
use vibrissa_protocol::Name;
use vibrissa_store::list::{Filter, Value};
use vibrissa_store::lists::actions::ActionRow;
use vibrissa_store::lists::rollouts::{ROLLOUTS, Rollout, RolloutSort};
use vibrissa_store::rollouts::RolloutEventReading;

use super::calibrations::numbers_of;
use super::paths::FleetPath;
use super::policy::{PolicyBody, version_of};
use crate::http::App;
use crate::http::access::Caller;
use crate::http::asking::{Asker, Why, ask, reason};
use crate::http::extract::{Body, OptionalBody, Path, Query};
use crate::http::fleets::FleetFilter;
use crate::http::listing::Listing;
use crate::http::page::{Page, list_query};
use crate::http::problem::Problem;
use crate::http::words::words;

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new()
        .routes(routes!(start_rollout))
        .routes(routes!(list_rollouts))
        .routes(routes!(get_rollout))
        .routes(routes!(pause_rollout))
        .routes(routes!(resume_rollout))
        .routes(routes!(advance_rollout))
        .routes(routes!(roll_back_rollout))
}

/// Level if the request states none.
const LEVEL: f64 = 0.05;
/// Number of changed robots that complete a stage, if the request states none.
const ROBOTS: u32 = 20;

words! {
    /// State of a roll-out.
    pub enum RolloutState {
        /// Its errors are compared, and its stages follow.
        Running = "RUNNING",
        /// It waits for a person.
        Paused = "PAUSED",
        /// The change was taken back.
        RolledBack = "ROLLED_BACK",
        /// The change is in force in the whole fleet.
        Completed = "COMPLETED",
    }
}

/// A roll-out to begin: either a policy or a calibration.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NewRollout {
    /// The policy to roll out. Its own `reason` is ignored.
    pub policy: Option<PolicyBody>,
    /// Number of the calibration to roll out.
    #[schema(minimum = 0)]
    pub calibration_id: Option<i64>,
    /// Probability that a change without an effect is rolled back, at most; by default 0.05.
    #[schema(minimum = 0.001, maximum = 0.2)]
    pub level: Option<f64>,
    /// Number of changed robots with an error that complete a stage; by default 20.
    #[schema(minimum = 4, maximum = 1000)]
    pub robots: Option<u32>,
    /// Reason in free text, at most 1000 characters.
    #[schema(max_length = 1000)]
    pub reason: Option<String>,
}

/// Kind and content of a change.
async fn change(app: &App, at: &FleetPath, body: &mut NewRollout) -> Result<(&'static str, Parameters), Problem> {
    match (&mut body.policy, body.calibration_id) {
        (Some(policy), None) => {
            policy.check().map_err(|problem| problem.within("policy"))?;
            policy.reason = None;
            let mut change = json!(policy);
            if let Parameters::Object(all) = &mut change {
                all.insert("expected_version".to_owned(), json!(version_of(app, at.fleet.as_str()).await?));
            }
            Ok(("POLICY", change))
        }
        (None, Some(id)) => {
            Ok(("CALIBRATION", json!({ "calibration_id": id, "calibration": numbers_of(app, id).await? })))
        }
        (Some(_), Some(_)) | (None, None) => Err(Problem::invalid("policy", "state either policy or calibration_id")),
    }
}

/// Begin a staged roll-out: 5 % of the robots get the change, then 25 %, then all.
///
/// The stages follow automatically after enough measured compensation errors. If the changed robots are worse, the change is
/// taken back. A fleet has one roll-out at a time; meanwhile its policy and calibrations cannot be changed otherwise.
#[utoipa::path(
    post, path = "/v1/fleets/{fleet}/rollouts", tag = "rollouts",
    params(FleetPath, ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")),
    request_body = NewRollout,
    responses(
        (status = 200, description = "The roll-out has begun; its number is that of the action", body = ActionRow),
        (status = 202, description = "Pending; poll the action", body = ActionRow)
    ),
    extensions(("x-required-role" = json!("ENGINEER")))
)]
async fn start_rollout(
    State(app): State<App>,
    Path(at): Path<FleetPath>,
    asker: Asker,
    Body(mut body): Body<NewRollout>,
) -> Result<Response, Problem> {
    let why = reason(body.reason.take())?;
    let (level, robots) = (body.level.unwrap_or(LEVEL), body.robots.unwrap_or(ROBOTS));
    let ((level_min, level_max), (robots_min, robots_max)) = (Rules::LEVELS, Rules::ROBOTS);
    if !(level_min..=level_max).contains(&level) {
        return Err(Problem::invalid("level", format!("must be from {level_min} to {level_max}, not {level}")));
    }
    if !(robots_min..=robots_max).contains(&robots) {
        return Err(Problem::invalid("robots", format!("must be {robots_min} to {robots_max}, not {robots}")));
    }
    if !app.store.has_fleet(at.fleet.as_str()).await? {
        return Err(Problem::not_found(&at));
    }
    let (kind, change) = change(&app, &at, &mut body).await?;
    let parameters = json!({ "kind": kind, "change": change, "level": level, "robots": robots });
    let mut action = asker.action(RecordedKind::RolloutStart.word(), &parameters, why);
    action.fleet = Some(at.fleet.to_string());
    ask(&app, &at.fleet, &action).await
}

list_query! {
    /// Filters for the list of roll-outs.
    pub struct RolloutsQuery by RolloutSort {
        /// Fleets: names or patterns such as `hall-*`, separated by commas.
        pub fleet: Option<FleetFilter>,
        /// State of the roll-out.
        #[param(inline)]
        pub state: Option<RolloutState>,
    }
}

/// All roll-outs, the newest first.
#[utoipa::path(
    get, path = "/v1/rollouts", tag = "rollouts", params(RolloutsQuery),
    responses((status = 200, description = "A page of roll-outs", body = Page<Rollout>))
)]
async fn list_rollouts(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    listing: Listing,
    Query(query): Query<RolloutsQuery>,
) -> Result<Response, Problem> {
    let mut selection = query.page()?;
    selection.filters.extend(caller.scope.filter("fleet"));
    selection.of_fleets(query.fleet.as_deref());
    selection.is("state", query.state);
    listing.answer::<Rollout>(&app, &ROLLOUTS, selection).await
}

/// Path parameters of a roll-out.
#[derive(Debug, Clone, Deserialize, IntoParams)]
#[into_params(parameter_in = Path)]
pub struct RolloutPath {
    /// Number of the roll-out.
    #[param(minimum = 0)]
    pub rollout_id: i64,
}

/// A roll-out with its events.
#[derive(Debug, Serialize, ToSchema)]
pub struct RolloutDetail {
    /// State of the roll-out.
    pub rollout: Rollout,
    /// Its events, the newest first, at most 200.
    pub events: Vec<RolloutEventReading>,
}

async fn rollout(app: &App, caller: &Caller, at: &RolloutPath) -> Result<Rollout, Problem> {
    let mut filters = vec![Filter::Is("rollout_id", Value::Whole(at.rollout_id))];
    filters.extend(caller.scope.filter("fleet"));
    let found = app.store.first(&ROLLOUTS, filters).await?;
    found.ok_or_else(|| Problem::not_found(format_args!("roll-out {}", at.rollout_id)))
}

/// One roll-out with its events.
#[utoipa::path(
    get, path = "/v1/rollouts/{rollout_id}", tag = "rollouts", params(RolloutPath),
    responses((status = 200, description = "The roll-out", body = RolloutDetail))
)]
async fn get_rollout(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    Path(at): Path<RolloutPath>,
) -> Result<Json<RolloutDetail>, Problem> {
    let rollout = rollout(&app, &caller, &at).await?;
    Ok(Json(RolloutDetail { events: app.store.rollout_events(at.rollout_id).await?, rollout }))
}

async fn order(
    app: &App,
    at: &RolloutPath,
    asker: Asker,
    (kind, why): (RecordedKind, Option<String>),
) -> Result<Response, Problem> {
    let fleet = rollout(app, &asker.caller, at).await?.fleet;
    let fleet = Name::new(&fleet).map_err(|_| Problem::not_found(format_args!("fleet {fleet}")))?;
    let mut action = asker.action(kind.word(), &json!({ "rollout_id": at.rollout_id }), reason(why)?);
    action.fleet = Some(fleet.to_string());
    ask(app, &fleet, &action).await
}

/// Defines the orders to a roll-out.
macro_rules! orders {
    ($($(#[$meta:meta])* $name:ident = $path:literal, $kind:ident, $done:literal;)+) => {
        $($(#[$meta])*
        #[utoipa::path(
            post, path = $path, tag = "rollouts",
            params(RolloutPath, ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")),
            request_body = Option<Why>,
            responses(
                (status = 200, description = $done, body = ActionRow),
                (status = 202, description = "Pending; poll the action", body = ActionRow)
            ),
            extensions(("x-required-role" = json!("ENGINEER")))
        )]
        async fn $name(
            State(app): State<App>,
            Path(at): Path<RolloutPath>,
            asker: Asker,
            OptionalBody(why): OptionalBody<Why>,
        ) -> Result<Response, Problem> {
            order(&app, &at, asker, (RecordedKind::$kind, why.reason)).await
        })+
    };
}

orders! {
    /// Pause a roll-out: robots stay as they are, and errors are not compared.
    pause_rollout = "/v1/rollouts/{rollout_id}/pause", RolloutPause, "The roll-out is paused";
    /// Resume a paused roll-out.
    resume_rollout = "/v1/rollouts/{rollout_id}/resume", RolloutResume, "The roll-out is running";
    /// Advance a roll-out to its next stage, whatever the errors say. After the stage of 25 % the change is in force everywhere.
    advance_rollout = "/v1/rollouts/{rollout_id}/advance", RolloutAdvance, "The next stage has begun";
    /// Roll a change back: the changed robots get the fleet's policy and calibrations again. The roll-out ends.
    roll_back_rollout = "/v1/rollouts/{rollout_id}/roll_back", RolloutBack, "The change is taken back";
}
