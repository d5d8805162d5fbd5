//! Messages that the database refused.

use axum::extract::{Extension, State};
use axum::response::Response;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vibrissa_protocol::Name;

use crate::http::App;
use crate::http::access::Caller;
use crate::http::extract::Query;
use crate::http::fleets::FleetFilter;
use crate::http::listing::Listing;
use crate::http::page::{Page, list_query};
use crate::http::problem::Problem;
use vibrissa_store::lists::quarantine::{QUARANTINE, QuarantineSort, Quarantined};

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(list_quarantine))
}

list_query! {
    /// Filters for the list of messages in quarantine.
    pub struct QuarantineQuery by QuarantineSort {
        /// Fleets: names or patterns such as `hall-*`, separated by commas.
        pub fleet: Option<FleetFilter>,
        /// Name of the robot.
        #[param(value_type = Option<String>, pattern = "^[A-Za-z0-9_-]{1,64}$")]
        pub robot: Option<Name>,
    }
}

/// Messages in quarantine: they conform to the contract, but the database refuses a row that follows from them. Each
/// was receipted, so that its robot does not send it again; it had no other effect. Each fleet keeps its newest 1000.
#[utoipa::path(
    get, path = "/v1/quarantine", tag = "happenings", params(QuarantineQuery),
    responses((status = 200, description = "A page of messages", body = Page<Quarantined>))
)]
async fn list_quarantine(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    listing: Listing,
    Query(query): Query<QuarantineQuery>,
) -> Result<Response, Problem> {
    let mut selection = query.page()?;
    selection.filters.extend(caller.scope.filter("fleet"));
    selection.of_fleets(query.fleet.as_deref());
    selection.is("robot", query.robot);
    listing.answer::<Quarantined>(&app, &QUARANTINE, selection).await
}
