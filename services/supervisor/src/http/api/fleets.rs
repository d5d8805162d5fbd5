//! Fleets: their supervisors and how much needs attention.

use axum::extract::{Extension, State};
use axum::response::{Json, Response};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::paths::FleetPath;
use crate::http::App;
use crate::http::access::Caller;
use crate::http::extract::{Path, Query};
use crate::http::fleets::FleetFilter;
use crate::http::listing::Listing;
use crate::http::page::{Page, list_query};
use crate::http::problem::Problem;
use vibrissa_store::lists::fleets::{FleetSort, FleetSummary, fleets};

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(list_fleets)).routes(routes!(get_fleet))
}

list_query! {
    /// Filters for the list of fleets.
    pub struct FleetsQuery by FleetSort {
        /// Fleets: names or patterns such as `hall-*`, separated by commas.
        #[param(inline)]
        pub fleet: Option<FleetFilter>,
    }
}

/// All known fleets, each with its supervisor and the number of items that need attention.
#[utoipa::path(
    get, path = "/v1/fleets", tag = "fleets", params(FleetsQuery),
    responses((status = 200, description = "A page of fleets", body = Page<FleetSummary>))
)]
async fn list_fleets(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    listing: Listing,
    Query(query): Query<FleetsQuery>,
) -> Result<Response, Problem> {
    let mut selection = query.page()?;
    selection.filters.extend(caller.scope.filter("fleet"));
    selection.of_fleets(query.fleet.as_deref());
    listing.answer::<FleetSummary>(&app, fleets(&app.store), selection).await
}

/// One fleet with its supervisor.
#[utoipa::path(
    get, path = "/v1/fleets/{fleet}", tag = "fleets", params(FleetPath),
    responses((status = 200, description = "The fleet", body = FleetSummary))
)]
async fn get_fleet(State(app): State<App>, Path(at): Path<FleetPath>) -> Result<Json<FleetSummary>, Problem> {
    let found = app.store.first(fleets(&app.store), at.filters()).await?;
    found.map(Json).ok_or_else(|| Problem::not_found(&at))
}
