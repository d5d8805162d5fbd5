//! Setpoints and their progress.

use axum::extract::{Extension, State};
use axum::response::{Json, Response};
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vibrissa_protocol::Name;

use crate::http::App;
use crate::http::access::Caller;
use crate::http::extract::{Path, Query};
use crate::http::fleets::FleetFilter;
use crate::http::listing::Listing;
use crate::http::moment::{Moment, between};
use crate::http::number::RowNumber;
use crate::http::page::{LIMIT_MAX, Page, list_query};
use crate::http::problem::Problem;
use crate::http::words::SetpointStateWord;
use vibrissa_store::list::{Filter, Selection, Value};
use vibrissa_store::lists::setpoints::{SETPOINT_STATES, SETPOINTS, Setpoint, SetpointSort, SetpointState};

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(list_setpoints)).routes(routes!(get_setpoint))
}

list_query! {
    /// Filters for the list of setpoints.
    pub struct SetpointsQuery by SetpointSort {
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
        /// State of the setpoint.
        #[param(inline)]
        pub state: Option<SetpointStateWord>,
        /// Number of the compensation.
        #[param(value_type = Option<i64>, minimum = 0, maximum = 9007199254740991_i64)]
        pub compensation_id: Option<RowNumber>,
        /// Earliest time of issue, inclusive.
        #[param(value_type = Option<String>, format = DateTime)]
        pub from: Option<Moment>,
        /// Latest time of issue, exclusive.
        #[param(value_type = Option<String>, format = DateTime)]
        pub to: Option<Moment>,
    }
}

/// All setpoints that were sent to robots.
#[utoipa::path(
    get, path = "/v1/setpoints", tag = "setpoints", params(SetpointsQuery),
    responses((status = 200, description = "A page of setpoints", body = Page<Setpoint>))
)]
async fn list_setpoints(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    listing: Listing,
    Query(query): Query<SetpointsQuery>,
) -> Result<Response, Problem> {
    let mut selection = query.page()?;
    selection.filters.extend(caller.scope.filter("fleet"));
    selection.of_fleets(query.fleet.as_deref());
    selection.is("robot", query.robot);
    selection.is("\"array\"", query.array);
    selection.is_number("whisker", query.whisker);
    selection.is("state", query.state);
    selection.is_number("compensation_id", query.compensation_id.map(i64::from));
    selection.filters.extend(between("issued_at", query.from, query.to));
    listing.answer::<Setpoint>(&app, &SETPOINTS, selection).await
}

/// Path parameters of a setpoint.
#[derive(Debug, Clone, Deserialize, IntoParams)]
#[into_params(parameter_in = Path)]
pub struct SetpointPath {
    /// Command ID of the setpoint, a UUID.
    #[param(pattern = "^[A-Za-z0-9_-]{1,64}$")]
    pub command_id: String,
}

/// A setpoint with its history.
#[derive(Debug, Serialize, ToSchema)]
pub struct SetpointWithHistory {
    /// The setpoint, as in the list.
    #[serde(flatten)]
    pub setpoint: Setpoint,
    /// States of the setpoint in order, at most 1000.
    pub history: Vec<SetpointState>,
}

/// One setpoint with its history.
#[utoipa::path(
    get, path = "/v1/setpoints/{command_id}", tag = "setpoints", params(SetpointPath),
    responses((status = 200, description = "The setpoint", body = SetpointWithHistory))
)]
async fn get_setpoint(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    Path(at): Path<SetpointPath>,
) -> Result<Json<SetpointWithHistory>, Problem> {
    let filter = || Filter::Is("command_id", Value::Text(at.command_id.clone()));
    let mut filters = vec![filter()];
    filters.extend(caller.scope.filter("fleet"));
    let setpoint = app.store.first(&SETPOINTS, filters).await?;
    let setpoint = setpoint.ok_or_else(|| Problem::not_found(format!("setpoint {}", at.command_id)))?;
    let selection = Selection::all(&SETPOINT_STATES, LIMIT_MAX).with(filter());
    let history = app.store.list(&SETPOINT_STATES, &selection).await?.rows;
    Ok(Json(SetpointWithHistory { setpoint, history }))
}
