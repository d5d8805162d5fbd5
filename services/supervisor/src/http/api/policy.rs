//! Compensation policy of a fleet, and its history.

use axum::extract::State;
use axum::http::{HeaderMap, HeaderValue, header};
use axum::response::{IntoResponse, Json, Response};
use serde::Deserialize;
use serde_json::json;
use utoipa::ToSchema;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vibrissa_edge::words::Word;

use super::paths::FleetPath;
use crate::http::App;
use crate::http::asking::{Asker, ask, reason};
use crate::http::extract::{Body, Path, Query};
use crate::http::page::{Page, list_query};
use crate::http::problem::{Kind, Problem};
use crate::http::words::words;
use vibrissa_store::lists::actions::{ActionRow, POLICIES, PolicyRow, PolicySort};

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(get_policy, put_policy)).routes(routes!(list_policies))
}

words! {
    /// Whether compensations need approval.
    pub enum ModeWord {
        /// Compensations start without approval.
        Automatic = "AUTOMATIC",
        /// An operator approves each proposed compensation.
        Advise = "ADVISE",
    }
}

words! {
    /// Objective of the setpoint solver.
    pub enum ObjectiveWord {
        /// Equal sensitivity at the tip.
        Tip = "TIP",
        /// Least mean error over the contact ratios.
        Mean = "MEAN",
    }
}

words! {
    /// Whether a longer whisker may compensate for a shorter one.
    pub enum LongerForShorterWord {
        /// A longer whisker is never used.
        Never = "NEVER",
        /// Only if no other candidate is suitable.
        LastResort = "LAST_RESORT",
        /// Like any other candidate.
        Allowed = "ALLOWED",
    }
}

/// A complete policy.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = NewPolicy)]
pub struct PolicyBody {
    /// Whether compensations need approval.
    pub mode: ModeWord,
    /// Objective of the setpoint solver.
    pub objective: ObjectiveWord,
    /// Whether a longer whisker may compensate for a shorter one.
    pub longer_for_shorter: LongerForShorterWord,
    /// Maximum mean predicted error of a compensation, as a ratio.
    #[schema(minimum = 0.0, maximum = 10.0)]
    pub predicted_error_max: f64,
    /// Cost of a neighbour that gives up its own role, in units of mean error.
    #[schema(minimum = 0.0, maximum = 10.0)]
    pub own_role_cost: f64,
    /// Minimum gain for a change of an active assignment, in units of mean error.
    #[schema(minimum = 0.0, maximum = 10.0)]
    pub change_margin: f64,
    /// Reason in free text, at most 1000 characters.
    #[schema(max_length = 1000)]
    pub reason: Option<String>,
}

async fn in_force(app: &App, at: &FleetPath) -> Result<PolicyRow, Problem> {
    if !app.store.has_fleet(at.fleet.as_str()).await? {
        return Err(Problem::not_found(at));
    }
    let set: Option<PolicyRow> = app.store.first(&POLICIES, at.filters()).await?;
    let policy = &app.params.policy;
    Ok(set.unwrap_or_else(|| PolicyRow {
        fleet: at.fleet.to_string(),
        version: 0,
        mode: policy.mode.word().to_owned(),
        objective: policy.objective.word().to_owned(),
        longer_for_shorter: policy.longer_for_shorter.word().to_owned(),
        predicted_error_max: policy.predicted_error_max,
        own_role_cost: policy.own_role_cost,
        change_margin: policy.change_margin,
        changed_at: None,
        changed_by: None,
        reason: None,
    }))
}

fn etag(version: i64) -> String {
    format!("\"{version}\"")
}

/// The policy in force. A change must send its `ETag` as `If-Match`.
#[utoipa::path(
    get, path = "/v1/fleets/{fleet}/policy", tag = "policy", params(FleetPath),
    responses((status = 200, description = "The policy", body = PolicyRow, headers(("ETag" = String, description = "Its version"))))
)]
async fn get_policy(State(app): State<App>, Path(at): Path<FleetPath>) -> Result<Response, Problem> {
    let policy = in_force(&app, &at).await?;
    let tag = etag(policy.version);
    let mut response = Json(policy).into_response();
    if let Ok(tag) = HeaderValue::from_str(&tag) {
        response.headers_mut().insert(header::ETAG, tag);
    }
    Ok(response)
}

/// Set another policy in place of the one that was read. Later decisions follow it at once.
#[utoipa::path(
    put, path = "/v1/fleets/{fleet}/policy", tag = "policy",
    params(
        FleetPath,
        ("If-Match" = Option<String>, Header, description = "`ETag` of the policy that was read; 428 if missing"),
        ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")
    ),
    request_body = PolicyBody,
    responses(
        (status = 200, description = "The policy is in force", body = ActionRow),
        (status = 202, description = "Pending; poll the action", body = ActionRow)
    ),
    extensions(("x-required-role" = json!("ENGINEER")))
)]
async fn put_policy(
    State(app): State<App>,
    Path(at): Path<FleetPath>,
    headers: HeaderMap,
    asker: Asker,
    Body(body): Body<PolicyBody>,
) -> Result<Response, Problem> {
    let numbers = [
        ("predicted_error_max", body.predicted_error_max),
        ("own_role_cost", body.own_role_cost),
        ("change_margin", body.change_margin),
    ];
    for (field, number) in numbers {
        if !(0.0..=10.0).contains(&number) {
            return Err(Problem::invalid(field, format!("must be from 0 to 10, not {number}")));
        }
    }
    let why = reason(body.reason)?;
    let expected_version = expected(&app, &at, &headers).await?;
    let parameters = json!({
        "expected_version": expected_version,
        "mode": body.mode,
        "objective": body.objective,
        "longer_for_shorter": body.longer_for_shorter,
        "predicted_error_max": body.predicted_error_max,
        "own_role_cost": body.own_role_cost,
        "change_margin": body.change_margin,
    });
    let mut action = asker.action("POLICY", &parameters, why);
    action.fleet = Some(at.fleet.to_string());
    ask(&app, &at.fleet, &action).await
}

/// The version in the caller's `If-Match`, if it is still current. The engine checks it once more.
async fn expected(app: &App, at: &FleetPath, headers: &HeaderMap) -> Result<i64, Problem> {
    let now = in_force(app, at).await?.version;
    let Some(told) = headers.get(header::IF_MATCH) else {
        return Err(Problem::new(
            Kind::VersionMissing,
            format!("read the policy first, and send its ETag as If-Match: {}", etag(now)),
        ));
    };
    let told = told.to_str().unwrap_or_default().trim();
    if told == "*" || told.split(',').any(|tag| tag.trim() == etag(now)) {
        return Ok(now);
    }
    Err(Problem::new(Kind::VersionChanged, format!("the policy in force is {}, not {told}: read it again", etag(now))))
}

list_query! {
    /// Pagination of the history of policies.
    pub struct PoliciesQuery by PolicySort {}
}

/// All policies that were set, with actor and reason.
#[utoipa::path(
    get, path = "/v1/fleets/{fleet}/policy/history", tag = "policy", params(FleetPath, PoliciesQuery),
    responses((status = 200, description = "A page of policies", body = Page<PolicyRow>))
)]
async fn list_policies(
    State(app): State<App>,
    Path(at): Path<FleetPath>,
    Query(query): Query<PoliciesQuery>,
) -> Result<Json<Page<PolicyRow>>, Problem> {
    let mut selection = query.page()?;
    selection.filters.extend(at.filters());
    Ok(Json(Page::of(app.store.list(&POLICIES, &selection).await?, &selection)))
}
