//! Trims and changes of health.

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
use crate::http::words::HealthKindWord;
use vibrissa_store::list::{Filter, Value};
use vibrissa_store::lists::happenings::{HEALTH_CHANGES, HealthChange, HealthChangeSort, TRIMS, Trim, TrimSort};

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new()
        .routes(routes!(list_trims))
        .routes(routes!(get_trim))
        .routes(routes!(list_health_changes))
        .routes(routes!(get_health_change))
}

list_query! {
    /// Filters for the list of trims.
    pub struct TrimsQuery by TrimSort {
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
    listing: Listing,
    Query(query): Query<TrimsQuery>,
) -> Result<Response, Problem> {
    let mut selection = query.page()?;
    selection.filters.extend(caller.scope.filter("fleet"));
    selection.of_fleets(query.fleet.as_deref());
    selection.is("robot", query.robot);
    selection.is("\"array\"", query.array);
    selection.is_number("whisker", query.whisker);
    selection.filters.extend(between("detected_at", query.from, query.to));
    listing.answer::<Trim>(&app, &TRIMS, selection).await
}

list_query! {
    /// Filters for the list of health changes.
    pub struct HealthChangesQuery by HealthChangeSort {
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
    listing: Listing,
    Query(query): Query<HealthChangesQuery>,
) -> Result<Response, Problem> {
    let mut selection = query.page()?;
    selection.filters.extend(caller.scope.filter("fleet"));
    selection.of_fleets(query.fleet.as_deref());
    selection.is("robot", query.robot);
    selection.is("\"array\"", query.array);
    selection.is_number("whisker", query.whisker);
    selection.is("kind", query.kind);
    selection.filters.extend(between("recorded_at", query.from, query.to));
    listing.answer::<HealthChange>(&app, &HEALTH_CHANGES, selection).await
}

/// Defines the routes of single rows: each has a number, and a path with that number.
macro_rules! rows {
    ($($(#[$meta:meta])* $name:ident($at:ident { $(#[$id_meta:meta])* $id:ident }) -> $row:ident = $path:literal, $list:ident, $what:literal;)+) => {
        $(
        #[doc = concat!("Path parameters of a row: ", $what, ".")]
        #[derive(Debug, Clone, Copy, Deserialize, IntoParams)]
        #[into_params(parameter_in = Path)]
        pub struct $at {
            $(#[$id_meta])*
            #[param(minimum = 0)]
            pub $id: i64,
        }

        $(#[$meta])*
        #[utoipa::path(
            get, path = $path, tag = "happenings", params($at),
            responses((status = 200, description = "The row of the list", body = $row))
        )]
        async fn $name(
            State(app): State<App>,
            Extension(caller): Extension<Caller>,
            Path(at): Path<$at>,
        ) -> Result<Json<$row>, Problem> {
            let mut filters = vec![Filter::Is(stringify!($id), Value::Whole(at.$id))];
            filters.extend(caller.scope.filter("fleet"));
            let found = app.store.first(&$list, filters).await?;
            found.map(Json).ok_or_else(|| Problem::not_found(format_args!("{} {}", $what, at.$id)))
        })+
    };
}

rows! {
    /// One detected trim of a whisker.
    get_trim(TrimPath {
        /// Number of the trim.
        trim_id
    }) -> Trim = "/v1/trims/{trim_id}", TRIMS, "trim";
    /// One change of a whisker's condition or fault.
    get_health_change(HealthChangePath {
        /// Number of the change.
        health_change_id
    }) -> HealthChange = "/v1/health-changes/{health_change_id}", HEALTH_CHANGES, "health change";
}
