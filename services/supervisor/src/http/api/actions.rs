//! Operators' actions on whiskers, robots and proposed compensations.

use axum::extract::State;
use axum::response::Response;
use serde::Deserialize;
use serde_json::json;
use utoipa::ToSchema;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vibrissa_protocol::Name;

use super::paths::{RobotPath, WhiskerPath};
use crate::http::App;
use crate::http::asking::{Asker, Why, ask, reason};
use crate::http::extract::{Body, OptionalBody, Path};
use crate::http::problem::Problem;
use vibrissa_store::list::Filter;
use vibrissa_store::lists::actions::ActionRow;
use vibrissa_store::lists::whiskers::{WHISKERS, Whisker};

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new()
        .routes(routes!(set_pressure))
        .routes(routes!(hold_whisker))
        .routes(routes!(release_whisker))
        .routes(routes!(whisker_replaced))
        .routes(routes!(rebaseline_whisker))
        .routes(routes!(retry_whisker))
        .routes(routes!(test_whisker))
        .routes(routes!(refuse_whisker_test))
        .routes(routes!(hold_robot))
        .routes(routes!(release_robot))
        .routes(routes!(approve_compensation))
        .routes(routes!(refuse_compensation))
}

/// A manual setpoint.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = ManualSetpoint)]
pub struct SetpointBody {
    /// Pressure in MPa: 0 to the whisker's maximum, at most 0.2.
    #[schema(minimum = 0.0, maximum = 0.2)]
    pub pressure_mpa: f64,
    /// Reason in free text, at most 1000 characters.
    #[schema(max_length = 1000)]
    pub reason: Option<String>,
}

/// Requests an action on an existing whisker.
async fn of_whisker(
    app: &App,
    at: &WhiskerPath,
    asker: Asker,
    (kind, parameters): (&str, serde_json::Value),
    why: Option<String>,
) -> Result<Response, Problem> {
    exists(app, at.filters(), at).await?;
    let mut action = asker.action(kind, &parameters, reason(why)?);
    action.fleet = Some(at.fleet.to_string());
    action.robot = Some(at.robot.to_string());
    action.array = Some(at.array.to_string());
    action.whisker = Some(at.whisker.into());
    ask(app, &at.fleet, &action).await
}

async fn of_robot(
    app: &App,
    at: &RobotPath,
    asker: Asker,
    kind: &str,
    why: Option<String>,
) -> Result<Response, Problem> {
    exists(app, at.filters(), at).await?;
    let mut action = asker.action(kind, &json!({}), reason(why)?);
    action.fleet = Some(at.fleet.to_string());
    action.robot = Some(at.robot.to_string());
    ask(app, &at.fleet, &action).await
}

/// Checks that the whisker or robot exists, because no engine would answer an action on an unknown one.
async fn exists(app: &App, filters: Vec<Filter>, what: impl std::fmt::Display) -> Result<(), Problem> {
    let found: Option<Whisker> = app.store.first(&WHISKERS, filters).await?;
    found.map(drop).ok_or_else(|| Problem::not_found(what))
}

/// Set a whisker's pressure manually.
///
/// The whisker is held from then on: no automatic setpoint changes its pressure. A compensation that it serves ends.
#[utoipa::path(
    post, path = "/v1/fleets/{fleet}/robots/{robot}/arrays/{array}/whiskers/{whisker}/setpoint", tag = "actions",
    params(WhiskerPath, ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")),
    request_body = SetpointBody,
    responses(
        (status = 200, description = "Done: the setpoint is being sent", body = ActionRow),
        (status = 202, description = "Pending; poll the action", body = ActionRow)
    ),
    extensions(("x-required-role" = json!("OPERATOR")))
)]
async fn set_pressure(
    State(app): State<App>,
    Path(at): Path<WhiskerPath>,
    asker: Asker,
    Body(body): Body<SetpointBody>,
) -> Result<Response, Problem> {
    let parameters = json!({ "pressure_mpa": body.pressure_mpa });
    of_whisker(&app, &at, asker, ("SETPOINT", parameters), body.reason).await
}

/// Defines the actions on a whisker that have no parameters.
macro_rules! whisker_actions {
    ($($(#[$meta:meta])* $name:ident = $path:literal, $kind:literal, $done:literal;)+) => {
        $($(#[$meta])*
        #[utoipa::path(
            post, path = $path, tag = "actions",
            params(WhiskerPath, ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")),
            request_body = Option<Why>,
            responses(
                (status = 200, description = $done, body = ActionRow),
                (status = 202, description = "Pending; poll the action", body = ActionRow)
            ),
            extensions(("x-required-role" = json!("OPERATOR")))
        )]
        async fn $name(
            State(app): State<App>,
            Path(at): Path<WhiskerPath>,
            asker: Asker,
            OptionalBody(why): OptionalBody<Why>,
        ) -> Result<Response, Problem> {
            of_whisker(&app, &at, asker, ($kind, json!({})), why.reason).await
        })+
    };
}

whisker_actions! {
    /// Hold a whisker: send it no automatic setpoints.
    hold_whisker = "/v1/fleets/{fleet}/robots/{robot}/arrays/{array}/whiskers/{whisker}/hold",
        "HOLD", "The whisker is held";
    /// Release a held whisker: allow automatic setpoints again.
    release_whisker = "/v1/fleets/{fleet}/robots/{robot}/arrays/{array}/whiskers/{whisker}/release",
        "RELEASE", "The whisker is released";
    /// Mark a whisker as replaced by a new one, and learn its baseline from scratch.
    whisker_replaced = "/v1/fleets/{fleet}/robots/{robot}/arrays/{array}/whiskers/{whisker}/replaced",
        "REPLACED", "The whisker is being relearned";
    /// Relearn a whisker's baseline at its currently estimated length, for example after work on its gauge.
    rebaseline_whisker = "/v1/fleets/{fleet}/robots/{robot}/arrays/{array}/whiskers/{whisker}/rebaseline",
        "REBASELINE", "The baseline is being relearned";
    /// Try a failed setpoint of a whisker again at once.
    ///
    /// The supervisor decides anew about compensators, and sends the setpoint. After unanswered and postponed setpoints it does
    /// so by itself, after growing pauses; not after a refusal by the robot. Refused with 409 if no setpoint of the
    /// whisker has failed, or it is held.
    retry_whisker = "/v1/fleets/{fleet}/robots/{robot}/arrays/{array}/whiskers/{whisker}/retry",
        "RETRY", "The setpoint is tried again";
    /// Have the robot measure the length of a whisker by touches, or start a proposed touch test.
    ///
    /// The robot must name a touch test in its factsheet. `test_id` of the action names the test in `/v1/touch-tests`. It is
    /// null if the request has to wait for the robot, for a setpoint under way, or because of the limit per hour. The test
    /// then follows with the reason `OPERATOR`.
    test_whisker = "/v1/fleets/{fleet}/robots/{robot}/arrays/{array}/whiskers/{whisker}/touch_test",
        "TOUCH_TEST", "The touch test is requested";
    /// Refuse a proposed touch test of a whisker.
    ///
    /// The test ends in the state `REFUSED`. It is not proposed again for the same reason without new evidence.
    refuse_whisker_test = "/v1/fleets/{fleet}/robots/{robot}/arrays/{array}/whiskers/{whisker}/touch_test/refuse",
        "REFUSE_TOUCH_TEST", "The touch test is refused";
}

/// Defines the actions on a robot.
macro_rules! robot_actions {
    ($($(#[$meta:meta])* $name:ident = $path:literal, $kind:literal, $done:literal;)+) => {
        $($(#[$meta])*
        #[utoipa::path(
            post, path = $path, tag = "actions",
            params(RobotPath, ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")),
            request_body = Option<Why>,
            responses(
                (status = 200, description = $done, body = ActionRow),
                (status = 202, description = "Pending; poll the action", body = ActionRow)
            ),
            extensions(("x-required-role" = json!("OPERATOR")))
        )]
        async fn $name(
            State(app): State<App>,
            Path(at): Path<RobotPath>,
            asker: Asker,
            OptionalBody(why): OptionalBody<Why>,
        ) -> Result<Response, Problem> {
            of_robot(&app, &at, asker, $kind, why.reason).await
        })+
    };
}

robot_actions! {
    /// Hold a robot: send no automatic setpoints to its whiskers, including those that are added later.
    hold_robot = "/v1/fleets/{fleet}/robots/{robot}/hold", "HOLD", "The robot is held";
    /// Release a held robot: allow automatic setpoints again.
    release_robot = "/v1/fleets/{fleet}/robots/{robot}/release", "RELEASE", "The robot is released";
}

/// Path parameters of a compensation.
#[derive(Debug, Clone, Deserialize, utoipa::IntoParams)]
#[into_params(parameter_in = Path)]
pub struct CompensationPath {
    /// Number of the compensation.
    #[param(minimum = 0)]
    pub compensation_id: i64,
}

async fn of_compensation(
    app: &App,
    id: i64,
    asker: Asker,
    kind: &str,
    why: Option<String>,
) -> Result<Response, Problem> {
    let found = app.store.robot_of_compensation(id).await?;
    let found = found.filter(|(fleet, _)| asker.caller.scope.covers(fleet));
    let (fleet, robot) = found.ok_or_else(|| Problem::not_found(format_args!("compensation {id}")))?;
    let mut action = asker.action(kind, &json!({}), reason(why)?);
    let owned = Name::new(&fleet).map_err(|bad| Problem::invalid("compensation_id", bad.to_string()))?;
    action.fleet = Some(fleet);
    action.robot = Some(robot);
    action.compensation_id = Some(id);
    ask(app, &owned, &action).await
}

/// Approve a proposed compensation, which then starts.
#[utoipa::path(
    post, path = "/v1/compensations/{compensation_id}/approve", tag = "actions",
    params(CompensationPath, ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")),
    request_body = Option<Why>,
    responses(
        (status = 200, description = "The compensation starts", body = ActionRow),
        (status = 202, description = "Pending; poll the action", body = ActionRow)
    ),
    extensions(("x-required-role" = json!("OPERATOR")))
)]
async fn approve_compensation(
    State(app): State<App>,
    Path(at): Path<CompensationPath>,
    asker: Asker,
    OptionalBody(why): OptionalBody<Why>,
) -> Result<Response, Problem> {
    of_compensation(&app, at.compensation_id, asker, "APPROVE", why.reason).await
}

/// Refuse a proposed compensation. The next best candidate is evaluated.
#[utoipa::path(
    post, path = "/v1/compensations/{compensation_id}/refuse", tag = "actions",
    params(CompensationPath, ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")),
    request_body = Option<Why>,
    responses(
        (status = 200, description = "The compensation does not start", body = ActionRow),
        (status = 202, description = "Pending; poll the action", body = ActionRow)
    ),
    extensions(("x-required-role" = json!("OPERATOR")))
)]
async fn refuse_compensation(
    State(app): State<App>,
    Path(at): Path<CompensationPath>,
    asker: Asker,
    OptionalBody(why): OptionalBody<Why>,
) -> Result<Response, Problem> {
    of_compensation(&app, at.compensation_id, asker, "REFUSE", why.reason).await
}
