//! Refusals of robots.

use axum::extract::State;
use axum::response::Response;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vibrissa_store::lists::refusals::{REFUSALS, RefusalCount, RefusalSort};

use super::paths::RobotPath;
use crate::http::App;
use crate::http::extract::{Path, Query};
use crate::http::listing::Listing;
use crate::http::page::{Page, list_query};
use crate::http::problem::Problem;

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(list_refusals))
}

list_query! {
    /// Parameters of the list of refusals.
    pub struct RefusalsQuery by RefusalSort {}
}

/// Refusals of a robot, by topic and reason: messages, and contacts and other entries of messages. The other entries
/// of their messages were accepted.
#[utoipa::path(
    get, path = "/v1/fleets/{fleet}/robots/{robot}/refusals", tag = "robots", params(RobotPath, RefusalsQuery),
    responses((status = 200, description = "A page of counts", body = Page<RefusalCount>))
)]
async fn list_refusals(
    State(app): State<App>,
    Path(at): Path<RobotPath>,
    listing: Listing,
    Query(query): Query<RefusalsQuery>,
) -> Result<Response, Problem> {
    if !app.store.has_robot(at.fleet.as_str(), at.robot.as_str()).await? {
        return Err(at.unknown(&app.store).await);
    }
    let mut selection = query.page()?;
    selection.filters.extend(at.filters());
    listing.answer::<RefusalCount>(&app, &REFUSALS, selection).await
}
