//! Policies and calibrations of all fleets that meet conditions.

use std::collections::BTreeSet;

use axum::extract::State;
use axum::response::Json;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use utoipa::ToSchema;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vibrissa_edge::actions::{ActionKind, RecordedKind};
use vibrissa_edge::words::Word as _;
use vibrissa_store::list::Selection;
use vibrissa_store::lists::robots::{ROBOTS, RobotSort, RobotSummary};

use super::bulk::{Options, Request, Started, Subject, ask_many};
use super::calibrations::{CalibrationPath, numbers_of};
use super::filters::RobotFilter;
use super::policy::{PolicyBody, version_of};
use crate::http::App;
use crate::http::access::Scope;
use crate::http::asking::Asker;
use crate::http::extract::{Body, Path};
use crate::http::problem::Problem;

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(set_policies)).routes(routes!(activate_calibration_in_fleets))
}

/// Most robots that are read to find their fleets.
const ROBOTS_MAX: usize = 100_000;
/// Robots of a page.
const PAGE: u32 = 1000;

/// Policy for the fleets that a request concerns.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PolicyAtOnce {
    /// Conditions on robots: the request concerns the fleets that have such robots.
    #[serde(default)]
    pub filter: RobotFilter,
    /// The policy. Its `reason` is that of the request.
    pub policy: PolicyBody,
    /// True: only list the fleets, and change nothing.
    #[serde(default)]
    pub dry_run: bool,
    /// Digest of the fleets that the dry run listed. The request is refused (412) if other fleets meet the conditions
    /// meanwhile, or have another policy.
    #[schema(pattern = "^[0-9a-f]{32}$")]
    pub digest: Option<String>,
}

/// Fleets that the activation of a calibration concerns.
#[derive(Debug, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct FleetsAtOnce {
    /// Conditions on robots: the request concerns the fleets that have such robots.
    #[serde(default)]
    pub filter: RobotFilter,
    /// True: only list the fleets, and change nothing.
    #[serde(default)]
    pub dry_run: bool,
    /// Digest of the fleets that the dry run listed. The request is refused (412) if other fleets meet the conditions
    /// meanwhile.
    #[schema(pattern = "^[0-9a-f]{32}$")]
    pub digest: Option<String>,
    /// Reason in free text, at most 1000 characters.
    #[schema(max_length = 1000)]
    pub reason: Option<String>,
}

/// The fleets of the robots that meet the conditions.
async fn fleets(app: &App, scope: &Scope, filter: RobotFilter) -> Result<BTreeSet<String>, Problem> {
    let mut names = BTreeSet::new();
    let sort = RobotSort::RobotId.sort();
    let filters = filter.conditions(scope)?;
    let mut selection = Selection { filters, sort, descending: false, after: None, limit: PAGE };
    for _ in 0..ROBOTS_MAX / PAGE as usize {
        let page = app.store.list::<RobotSummary>(&ROBOTS, &selection).await?;
        names.extend(page.rows.into_iter().map(|row| row.fleet));
        selection.after = page.next;
        if selection.after.is_none() {
            break;
        }
    }
    Ok(names)
}

fn whole(fleet: String) -> Subject {
    Subject { fleet, robot: None, array: None, whisker: None }
}

/// Set a policy in all fleets that have robots which meet the conditions, at most 1000.
///
/// With `dry_run` it lists them and changes nothing. Each fleet gets its own entry in the audit log, which its owner executes.
/// A fleet refuses if its policy was changed meanwhile. `/v1/bulk-actions/{action_id}` has the progress.
#[utoipa::path(
    post, path = "/v1/policies", tag = "policy",
    params(("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")),
    request_body = PolicyAtOnce,
    responses((status = 200, description = "The fleets", body = Started)),
    extensions(("x-required-role" = json!("ENGINEER")))
)]
async fn set_policies(
    State(app): State<App>,
    asker: Asker,
    Body(mut body): Body<PolicyAtOnce>,
) -> Result<Json<Started>, Problem> {
    body.policy.check().map_err(|problem| problem.within("policy"))?;
    let reason = body.policy.reason.take();
    let which = json!(body.filter);
    let policy = json!(body.policy);
    let mut subjects = Vec::new();
    for fleet in fleets(&app, &asker.caller.scope, body.filter).await? {
        let mut parameters = policy.clone();
        if let Value::Object(all) = &mut parameters {
            all.insert("expected_version".to_owned(), json!(version_of(&app, &fleet).await?));
        }
        subjects.push((whole(fleet), parameters));
    }
    let request = Request {
        of_all: RecordedKind::Policies,
        of_each: ActionKind::Policy.word(),
        which,
        details: json!({ "policy": policy }),
        subjects,
        more: false,
        options: Options { dry_run: body.dry_run, digest: body.digest, per_second: None, reason },
    };
    ask_many(&app, asker, request).await
}

/// Activate a calibration in all fleets that have robots which meet the conditions, at most 1000.
///
/// With `dry_run` it lists them and changes nothing. Each fleet gets its own entry in the audit log, which its owner executes.
/// `/v1/bulk-actions/{action_id}` has the progress.
#[utoipa::path(
    post, path = "/v1/calibrations/{calibration_id}/activate", tag = "calibrations",
    params(CalibrationPath, ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")),
    request_body = FleetsAtOnce,
    responses((status = 200, description = "The fleets", body = Started)),
    extensions(("x-required-role" = json!("ENGINEER")))
)]
async fn activate_calibration_in_fleets(
    State(app): State<App>,
    Path(at): Path<CalibrationPath>,
    asker: Asker,
    Body(body): Body<FleetsAtOnce>,
) -> Result<Json<Started>, Problem> {
    let parameters = json!({
        "calibration_id": at.calibration_id,
        "calibration": numbers_of(&app, at.calibration_id).await?,
    });
    let which = json!(body.filter);
    let names = fleets(&app, &asker.caller.scope, body.filter).await?;
    let request = Request {
        of_all: RecordedKind::Calibrations,
        of_each: RecordedKind::Calibration.word(),
        which,
        details: json!({ "calibration_id": at.calibration_id }),
        subjects: names.into_iter().map(|fleet| (whole(fleet), parameters.clone())).collect(),
        more: false,
        options: Options { dry_run: body.dry_run, digest: body.digest, per_second: None, reason: body.reason },
    };
    ask_many(&app, asker, request).await
}
