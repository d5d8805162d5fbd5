//! Requests for many: their list, their progress, and how to stop them.

use axum::extract::{Extension, State};
use axum::response::{Json, Response};
use serde::{Deserialize, Serialize};
use serde_json::json;
use utoipa::{IntoParams, ToSchema};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vibrissa_edge::actions::RecordedKind;
use vibrissa_edge::words::Word as _;
use vibrissa_store::bulk::Refusals;
use vibrissa_store::list::{Filter, Value};
use vibrissa_store::lists::bulk::{BULK, BulkRow, BulkSort};

use crate::http::App;
use crate::http::access::{Caller, Role};
use crate::http::asking::{Asker, Why, number_of, reason};
use crate::http::extract::{OptionalBody, Path, Query};
use crate::http::fleets::FleetFilter;
use crate::http::listing::Listing;
use crate::http::page::{Page, list_query};
use crate::http::problem::{Kind, Problem};

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new()
        .routes(routes!(list_bulk_actions))
        .routes(routes!(get_bulk_action))
        .routes(routes!(stop_bulk_action))
}

list_query! {
    /// Filters for the list of requests for many.
    pub struct BulkQuery by BulkSort {
        /// Fleets: names or patterns such as `hall-*`, separated by commas. Requests that concern several fleets are
        /// left out.
        pub fleet: Option<FleetFilter>,
        /// Person or token that requested it.
        #[param(max_length = 200)]
        pub actor: Option<String>,
    }
}

/// Limits the list to the caller's fleets, and to the caller's own requests.
fn seen_by(caller: &Caller) -> Option<Filter> {
    let own = Filter::Is("actor", Value::Text(caller.actor.clone()));
    caller.scope.filter("fleet").map(|scope| Filter::AnyOf(vec![scope, own]))
}

/// All requests for many with their progress, the newest first.
#[utoipa::path(
    get, path = "/v1/bulk-actions", tag = "actions", params(BulkQuery),
    responses((status = 200, description = "A page of requests", body = Page<BulkRow>))
)]
async fn list_bulk_actions(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    listing: Listing,
    Query(query): Query<BulkQuery>,
) -> Result<Response, Problem> {
    let mut selection = query.page()?;
    selection.filters.extend(seen_by(&caller));
    selection.of_fleets(query.fleet.as_deref());
    selection.is("actor", query.actor);
    listing.answer::<BulkRow>(&app, &BULK, selection).await
}

/// Path parameters of a request for many.
#[derive(Debug, Clone, Deserialize, IntoParams)]
#[into_params(parameter_in = Path)]
pub struct BulkPath {
    /// Number of the request.
    #[param(minimum = 0)]
    pub action_id: i64,
}

/// A request for many with its progress.
#[derive(Debug, Serialize, ToSchema)]
pub struct BulkDetail {
    /// The request with its numbers.
    pub request: BulkRow,
    /// Why subjects were refused, the most frequent reason first, at most 20. `/v1/audit?parent_id=...&state=REFUSED` lists
    /// them.
    pub refusals: Vec<Refusals>,
}

async fn detail(app: &App, caller: &Caller, action_id: i64) -> Result<BulkDetail, Problem> {
    let mut filters = vec![Filter::Is("action_id", Value::Whole(action_id))];
    filters.extend(seen_by(caller));
    let request: Option<BulkRow> = app.store.first(&BULK, filters).await?;
    let request = request.ok_or_else(|| Problem::not_found(format_args!("request for many {action_id}")))?;
    Ok(BulkDetail { request, refusals: app.store.bulk_refusals(action_id).await? })
}

/// One request for many with its progress, and why subjects were refused.
#[utoipa::path(
    get, path = "/v1/bulk-actions/{action_id}", tag = "actions", params(BulkPath),
    responses((status = 200, description = "The request", body = BulkDetail))
)]
async fn get_bulk_action(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    Path(at): Path<BulkPath>,
) -> Result<Json<BulkDetail>, Problem> {
    detail(&app, &caller, at.action_id).await.map(Json)
}

/// Kinds of requests that only engineers may make.
fn is_for_engineers(kind: &str) -> bool {
    kind == RecordedKind::Policies.word() || kind == RecordedKind::Calibrations.word()
}

/// Stop a request for many: actions that were not executed yet are withdrawn. What is done stays done.
#[utoipa::path(
    post, path = "/v1/bulk-actions/{action_id}/stop", tag = "actions",
    params(BulkPath, ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")),
    request_body = Option<Why>,
    responses((status = 200, description = "The request is stopped", body = BulkDetail)),
    extensions(("x-required-role" = json!("OPERATOR")))
)]
async fn stop_bulk_action(
    State(app): State<App>,
    Path(at): Path<BulkPath>,
    asker: Asker,
    OptionalBody(why): OptionalBody<Why>,
) -> Result<Json<BulkDetail>, Problem> {
    let caller = asker.caller.clone();
    let found = detail(&app, &caller, at.action_id).await?;
    if is_for_engineers(&found.request.kind) && caller.role < Role::Engineer {
        return Err(Problem::new(Kind::Forbidden, "only engineers may stop a change of policies or calibrations"));
    }
    let fleets = app.store.bulk_fleets(at.action_id).await?;
    if fleets.iter().any(|fleet| !caller.scope.covers(fleet)) {
        return Err(Problem::not_found(format_args!("request for many {}", at.action_id)));
    }
    let mut action =
        asker.action(RecordedKind::BulkStop.word(), &json!({ "action_id": at.action_id }), reason(why.reason)?);
    action.fleet = found.request.fleet;
    let (asked, _) = app.store.stop_bulk(at.action_id, &fleets, &action).await?;
    number_of(asked)?;
    app.action_notifier.changed();
    detail(&app, &caller, at.action_id).await.map(Json)
}
