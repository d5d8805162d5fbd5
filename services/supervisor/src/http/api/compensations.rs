//! Compensations: decisions about trimmed whiskers, and their outcomes.

use axum::extract::{Extension, State};
use axum::response::{Json, Response};
use serde::Serialize;
use utoipa::ToSchema;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vibrissa_protocol::Name;

use super::paths::CompensationPath;
use crate::http::App;
use crate::http::access::Caller;
use crate::http::extract::{Path, Query};
use crate::http::fleets::FleetFilter;
use crate::http::listing::Listing;
use crate::http::moment::{Moment, between};
use crate::http::page::{LIMIT_MAX, Page, list_query};
use crate::http::problem::Problem;
use crate::http::search::Search;
use crate::http::words::{ApprovalWord, CaseWord};
use vibrissa_store::list::{Filter, Selection, Value};
use vibrissa_store::lists::compensations::{
    CANDIDATES, COMPENSATIONS, Candidate, CompensationSort, CompensationSummary, LOOKS, Look, RATIO_ERRORS, RatioError,
};

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(list_compensations)).routes(routes!(get_compensation))
}

list_query! {
    /// Filters for the list of compensations.
    pub struct CompensationsQuery by CompensationSort {
        /// Fleets: names or patterns such as `hall-*`, separated by commas.
        pub fleet: Option<FleetFilter>,
        /// Name of the robot.
        #[param(value_type = Option<String>, pattern = "^[A-Za-z0-9_-]{1,64}$")]
        pub robot: Option<Name>,
        /// Name of the array.
        #[param(value_type = Option<String>, pattern = "^[A-Za-z0-9_-]{1,64}$")]
        pub array: Option<Name>,
        /// Number of the target whisker.
        #[param(maximum = 65535)]
        pub target_whisker: Option<u16>,
        /// Number of the compensator.
        #[param(maximum = 65535)]
        pub compensator_whisker: Option<u16>,
        /// Compensation case of the paper.
        #[param(inline)]
        pub case: Option<CaseWord>,
        /// Approval state of the compensation.
        #[param(inline)]
        pub approval: Option<ApprovalWord>,
        /// True: only active compensations; false: only ended ones.
        pub active: Option<bool>,
        /// Text to look for in the names of fleet, robot and array, in upper or lower case.
        #[param(value_type = Option<String>, min_length = 1, max_length = 100, pattern = "^[^\\x00]+$")]
        pub q: Option<Search>,
        /// Earliest time of the decision, inclusive.
        #[param(value_type = Option<String>, format = DateTime)]
        pub from: Option<Moment>,
        /// Latest time of the decision, exclusive.
        #[param(value_type = Option<String>, format = DateTime)]
        pub to: Option<Moment>,
    }
}

/// All decisions about trimmed whiskers, with their outcomes.
#[utoipa::path(
    get, path = "/v1/compensations", tag = "compensations", params(CompensationsQuery),
    responses((status = 200, description = "A page of compensations", body = Page<CompensationSummary>))
)]
async fn list_compensations(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    listing: Listing,
    Query(query): Query<CompensationsQuery>,
) -> Result<Response, Problem> {
    let mut selection = query.page()?;
    selection.filters.extend(caller.scope.filter("fleet"));
    selection.is("approval", query.approval);
    selection.of_fleets(query.fleet.as_deref());
    selection.is("robot", query.robot);
    selection.is("\"array\"", query.array);
    selection.is_number("target_whisker", query.target_whisker);
    selection.is_number("compensator_whisker", query.compensator_whisker);
    selection.is("compensation_case", query.case);
    selection.filters.extend(query.active.map(|active| Filter::IsNull("ended_at", active)));
    selection.contains(&["fleet", "robot", "\"array\""], query.q);
    selection.filters.extend(between("decided_at", query.from, query.to));
    listing.answer::<CompensationSummary>(&app, &COMPENSATIONS, selection).await
}

/// A decision with all details.
#[derive(Debug, Serialize, ToSchema)]
pub struct Compensation {
    /// Decision and outcome.
    #[serde(flatten)]
    pub summary: CompensationSummary,
    /// Candidates in the order of evaluation, at most 1000.
    pub candidates: Vec<Candidate>,
    /// Newest measured error per contact ratio.
    pub errors_by_ratio: Vec<RatioError>,
    /// Reviews of its setpoint in order of time, at most 1000.
    pub looks: Vec<Look>,
}

/// One decision with its candidates, its error per contact ratio, and the reviews of its setpoint.
#[utoipa::path(
    get, path = "/v1/compensations/{compensation_id}", tag = "compensations", params(CompensationPath),
    responses((status = 200, description = "The compensation", body = Compensation))
)]
async fn get_compensation(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    Path(at): Path<CompensationPath>,
) -> Result<Json<Compensation>, Problem> {
    compensation(&app, &caller, at).await.map(Json)
}

/// One decision, if it is in the caller's scope.
pub(super) async fn compensation(app: &App, caller: &Caller, at: CompensationPath) -> Result<Compensation, Problem> {
    let id = at.compensation_id;
    let filter = || Filter::Is("compensation_id", Value::Whole(id));
    let mut filters = vec![filter()];
    filters.extend(caller.scope.filter("fleet"));
    let summary = app.store.first(&COMPENSATIONS, filters).await?;
    let summary = summary.ok_or_else(|| Problem::not_found(format!("compensation {id}")))?;
    let of = |list| Selection::all(list, LIMIT_MAX).with(filter());
    Ok(Compensation {
        summary,
        candidates: app.store.list(&CANDIDATES, &of(&CANDIDATES)).await?.rows,
        errors_by_ratio: app.store.list(&RATIO_ERRORS, &of(&RATIO_ERRORS)).await?.rows,
        looks: app.store.list(&LOOKS, &of(&LOOKS)).await?.rows,
    })
}
