//! What operators do to whiskers, robots and proposed compensations.

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
        .routes(routes!(hold_robot))
        .routes(routes!(release_robot))
        .routes(routes!(approve))
        .routes(routes!(refuse))
}

/// A pressure to hold.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = ManualSetpoint)]
pub struct SetpointBody {
    /// Pressure, 0 to the whisker's highest and at most 0.2.
    #[schema(minimum = 0.0, maximum = 0.2)]
    pub pressure_mpa: f64,
    /// Why, in your words.
    #[schema(max_length = 1000)]
    pub reason: Option<String>,
}

/// What is asked about a whisker that is there.
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

/// Nobody waits for an answer about what is not there.
async fn exists(app: &App, filters: Vec<Filter>, what: impl std::fmt::Display) -> Result<(), Problem> {
    let found: Option<Whisker> = app.store.first(&WHISKERS, filters).await?;
    found.map(drop).ok_or_else(|| Problem::not_found(what))
}

/// Set a whisker's pressure by hand.
///
/// The whisker is held from then on, so that nothing moves it away; a compensation that it serves in ends.
#[utoipa::path(
    post, path = "/v1/fleets/{fleet}/robots/{robot}/arrays/{array}/whiskers/{whisker}/setpoint", tag = "actions",
    params(WhiskerPath, ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")),
    request_body = SetpointBody,
    responses(
        (status = 200, description = "Done: the setpoint is on its way", body = ActionRow),
        (status = 202, description = "Asked; look at the action later", body = ActionRow)
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

/// Spells out the actions on a whisker that have no parameters.
macro_rules! whisker_actions {
    ($($(#[$meta:meta])* $name:ident = $path:literal, $kind:literal, $done:literal;)+) => {
        $($(#[$meta])*
        #[utoipa::path(
            post, path = $path, tag = "actions",
            params(WhiskerPath, ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")),
            request_body = Option<Why>,
            responses(
                (status = 200, description = $done, body = ActionRow),
                (status = 202, description = "Asked; look at the action later", body = ActionRow)
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
    /// Send no automatic setpoint to a whisker any more.
    hold_whisker = "/v1/fleets/{fleet}/robots/{robot}/arrays/{array}/whiskers/{whisker}/hold", "HOLD", "It is held";
    /// Let a held whisker be moved again.
    release_whisker = "/v1/fleets/{fleet}/robots/{robot}/arrays/{array}/whiskers/{whisker}/release", "RELEASE", "It is released";
    /// Say that a new whisker is in the place of the old one: it is learned anew.
    whisker_replaced = "/v1/fleets/{fleet}/robots/{robot}/arrays/{array}/whiskers/{whisker}/replaced", "REPLACED", "It is learned anew";
    /// Learn a whisker's readings anew, at the length that is estimated now: after work on its gauge, say.
    rebaseline_whisker = "/v1/fleets/{fleet}/robots/{robot}/arrays/{array}/whiskers/{whisker}/rebaseline", "REBASELINE", "It is learned anew";
}

/// Spells out the actions on a robot.
macro_rules! robot_actions {
    ($($(#[$meta:meta])* $name:ident = $path:literal, $kind:literal, $done:literal;)+) => {
        $($(#[$meta])*
        #[utoipa::path(
            post, path = $path, tag = "actions",
            params(RobotPath, ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")),
            request_body = Option<Why>,
            responses(
                (status = 200, description = $done, body = ActionRow),
                (status = 202, description = "Asked; look at the action later", body = ActionRow)
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
    /// Send no automatic setpoint to any whisker of a robot any more, nor to those that it gets.
    hold_robot = "/v1/fleets/{fleet}/robots/{robot}/hold", "HOLD", "It is held";
    /// Let a held robot's whiskers be moved again.
    release_robot = "/v1/fleets/{fleet}/robots/{robot}/release", "RELEASE", "It is released";
}

/// A compensation.
#[derive(Debug, Clone, Deserialize, utoipa::IntoParams)]
#[into_params(parameter_in = Path)]
pub struct CompensationPath {
    /// Number.
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

/// Let a proposed compensation begin.
#[utoipa::path(
    post, path = "/v1/compensations/{compensation_id}/approve", tag = "actions",
    params(CompensationPath, ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")),
    request_body = Option<Why>,
    responses(
        (status = 200, description = "It begins", body = ActionRow),
        (status = 202, description = "Asked; look at the action later", body = ActionRow)
    ),
    extensions(("x-required-role" = json!("OPERATOR")))
)]
async fn approve(
    State(app): State<App>,
    Path(at): Path<CompensationPath>,
    asker: Asker,
    OptionalBody(why): OptionalBody<Why>,
) -> Result<Response, Problem> {
    of_compensation(&app, at.compensation_id, asker, "APPROVE", why.reason).await
}

/// Do not let a proposed compensation begin: the next best is looked for.
#[utoipa::path(
    post, path = "/v1/compensations/{compensation_id}/refuse", tag = "actions",
    params(CompensationPath, ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")),
    request_body = Option<Why>,
    responses(
        (status = 200, description = "It does not begin", body = ActionRow),
        (status = 202, description = "Asked; look at the action later", body = ActionRow)
    ),
    extensions(("x-required-role" = json!("OPERATOR")))
)]
async fn refuse(
    State(app): State<App>,
    Path(at): Path<CompensationPath>,
    asker: Asker,
    OptionalBody(why): OptionalBody<Why>,
) -> Result<Response, Problem> {
    of_compensation(&app, at.compensation_id, asker, "REFUSE", why.reason).await
}
