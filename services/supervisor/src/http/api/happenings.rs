//! Trims and changes of health.

use axum::extract::{Extension, State};
use axum::response::Json;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vibrissa_protocol::Name;

use crate::http::App;
use crate::http::access::Caller;
use crate::http::extract::Query;
use crate::http::moment::{Moment, between};
use crate::http::page::{Page, list_query};
use crate::http::problem::Problem;
use crate::http::words::HealthKindWord;
use vibrissa_store::lists::happenings::{HEALTH_CHANGES, HealthChange, HealthChangeSort, TRIMS, Trim, TrimSort};

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(list_trims)).routes(routes!(list_health_changes))
}

list_query! {
    /// Filters for the list of trims.
    pub struct TrimsQuery by TrimSort {
        /// Name of the fleet.
        #[param(value_type = Option<String>, pattern = "^[A-Za-z0-9_-]{1,64}$")]
        pub fleet: Option<Name>,
        /// Name of the robot.
        #[param(value_type = Option<String>, pattern = "^[A-Za-z0-9_-]{1,64}$")]
        pub robot: Option<Name>,
        /// Name of the array.
        #[param(value_type = Option<String>, pattern = "^[A-Za-z0-9_-]{1,64}$")]
        pub array: Option<Name>,
        /// Number of the whisker in its array.
        #[param(maximum = 65535)]
        pub whisker: Option<u16>,
        /// Earliest time of detection, inclusive.
        #[param(value_type = Option<String>, format = DateTime)]
        pub from: Option<Moment>,
        /// Latest time of detection, exclusive.
        #[param(value_type = Option<String>, format = DateTime)]
        pub to: Option<Moment>,
    }
}

/// All detected trims.
#[utoipa::path(
    get, path = "/v1/trims", tag = "happenings", params(TrimsQuery),
    responses((status = 200, description = "A page of trims", body = Page<Trim>))
)]
async fn list_trims(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    Query(query): Query<TrimsQuery>,
) -> Result<Json<Page<Trim>>, Problem> {
    let mut selection = query.page()?;
    selection.filters.extend(caller.scope.filter("fleet"));
    selection.is("fleet", query.fleet);
    selection.is("robot", query.robot);
    selection.is("\"array\"", query.array);
    selection.is_number("whisker", query.whisker);
    selection.filters.extend(between("detected_at", query.from, query.to));
    Ok(Json(Page::of(app.store.list(&TRIMS, &selection).await?, &selection)))
}

list_query! {
    /// Filters for the list of health changes.
    pub struct HealthChangesQuery by HealthChangeSort {
        /// Name of the fleet.
        #[param(value_type = Option<String>, pattern = "^[A-Za-z0-9_-]{1,64}$")]
        pub fleet: Option<Name>,
        /// Name of the robot.
        #[param(value_type = Option<String>, pattern = "^[A-Za-z0-9_-]{1,64}$")]
        pub robot: Option<Name>,
        /// Name of the array.
        #[param(value_type = Option<String>, pattern = "^[A-Za-z0-9_-]{1,64}$")]
        pub array: Option<Name>,
        /// Number of the whisker in its array.
        #[param(maximum = 65535)]
        pub whisker: Option<u16>,
        /// Kind of the change.
        #[param(inline)]
        pub kind: Option<HealthKindWord>,
        /// Earliest time of recording, inclusive.
        #[param(value_type = Option<String>, format = DateTime)]
        pub from: Option<Moment>,
        /// Latest time of recording, exclusive.
        #[param(value_type = Option<String>, format = DateTime)]
        pub to: Option<Moment>,
    }
}

/// All changes of whiskers' conditions and faults.
#[utoipa::path(
    get, path = "/v1/health-changes", tag = "happenings", params(HealthChangesQuery),
    responses((status = 200, description = "A page of changes of health", body = Page<HealthChange>))
)]
async fn list_health_changes(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    Query(query): Query<HealthChangesQuery>,
) -> Result<Json<Page<HealthChange>>, Problem> {
    let mut selection = query.page()?;
    selection.filters.extend(caller.scope.filter("fleet"));
    selection.is("fleet", query.fleet);
    selection.is("robot", query.robot);
    selection.is("\"array\"", query.array);
    selection.is_number("whisker", query.whisker);
    selection.is("kind", query.kind);
    selection.filters.extend(between("recorded_at", query.from, query.to));
    Ok(Json(Page::of(app.store.list(&HEALTH_CHANGES, &selection).await?, &selection)))
}
