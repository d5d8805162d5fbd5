//! Touch tests and their progress.

use axum::extract::{Extension, State};
use axum::response::{Json, Response};
use serde::Deserialize;
use utoipa::IntoParams;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vibrissa_protocol::Name;

use crate::http::App;
use crate::http::access::Caller;
use crate::http::extract::{Path, Query};
use crate::http::fleets::FleetFilter;
use crate::http::listing::Listing;
use crate::http::moment::{Moment, between};
use crate::http::page::{Page, list_query};
use crate::http::problem::Problem;
use crate::http::words::TestStateWord;
use vibrissa_store::list::{Filter, Value};
use vibrissa_store::lists::touch_tests::{TOUCH_TESTS, TouchTest, TouchTestSort};

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(list_touch_tests)).routes(routes!(get_touch_test))
}

list_query! {
    /// Filters for the list of touch tests.
    pub struct TouchTestsQuery by TouchTestSort {
        /// Fleets: names or patterns such as `hall-*`, separated by commas.
        pub fleet: Option<FleetFilter>,
        /// Name of the robot.
        #[param(value_type = Option<String>, pattern = "^[A-Za-z0-9_-]{1,64}$")]
        pub robot: Option<Name>,
        /// Name of the array.
        #[param(value_type = Option<String>, pattern = "^[A-Za-z0-9_-]{1,64}$")]
        pub array: Option<Name>,
        /// Number of the whisker in its array.
        #[param(maximum = 65535)]
        pub whisker: Option<u16>,
        /// State of the test.
        #[param(inline)]
        pub state: Option<TestStateWord>,
        /// Identifier of the test, as in the contract's `request` and in the action that requested it.
        #[param(value_type = Option<String>, pattern = "^[A-Za-z0-9_-]{1,64}$")]
        pub test_id: Option<Name>,
        /// Earliest time of the request or proposal, inclusive.
        #[param(value_type = Option<String>, format = DateTime)]
        pub from: Option<Moment>,
        /// Latest time of the request or proposal, exclusive.
        #[param(value_type = Option<String>, format = DateTime)]
        pub to: Option<Moment>,
    }
}

/// All touch tests that were requested or proposed.
#[utoipa::path(
    get, path = "/v1/touch-tests", tag = "touch tests", params(TouchTestsQuery),
    responses((status = 200, description = "A page of touch tests", body = Page<TouchTest>))
)]
async fn list_touch_tests(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    listing: Listing,
    Query(query): Query<TouchTestsQuery>,
) -> Result<Response, Problem> {
    let mut selection = query.page()?;
    selection.filters.extend(caller.scope.filter("fleet"));
    selection.of_fleets(query.fleet.as_deref());
    selection.is("robot", query.robot);
    selection.is("\"array\"", query.array);
    selection.is_number("whisker", query.whisker);
    selection.is("state", query.state);
    selection.is("test_id", query.test_id);
    selection.filters.extend(between("requested_at", query.from, query.to));
    listing.answer::<TouchTest>(&app, &TOUCH_TESTS, selection).await
}

/// Path parameters of a touch test.
#[derive(Debug, Clone, Deserialize, IntoParams)]
#[into_params(parameter_in = Path)]
pub struct TouchTestPath {
    /// Identifier of the test, as in the contract's `request` and in the action that requested it.
    #[param(value_type = String, pattern = "^[A-Za-z0-9_-]{1,64}$")]
    pub test_id: Name,
}

/// One touch test with its progress.
#[utoipa::path(
    get, path = "/v1/touch-tests/{test_id}", tag = "touch tests", params(TouchTestPath),
    responses((status = 200, description = "The touch test", body = TouchTest))
)]
async fn get_touch_test(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    Path(at): Path<TouchTestPath>,
) -> Result<Json<TouchTest>, Problem> {
    let mut filters = vec![Filter::Is("test_id", Value::Text(at.test_id.to_string()))];
    filters.extend(caller.scope.filter("fleet"));
    let found = app.store.first(&TOUCH_TESTS, filters).await?;
    found.map(Json).ok_or_else(|| Problem::not_found(format_args!("touch test {}", at.test_id)))
}
