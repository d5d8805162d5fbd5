//! Robots and their arrays.

use axum::extract::{Extension, State};
use axum::response::{Json, Response};
use serde::Serialize;
use serde_json::json;
use utoipa::ToSchema;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vibrissa_edge::actions::RecordedKind;
use vibrissa_edge::words::Word as _;
use vibrissa_protocol::Name;

use super::filters::RobotFilter;
use super::paths::{ArrayPath, RobotPath};
use crate::http::App;
use crate::http::access::Caller;
use crate::http::asking::{Asker, Why, ask, reason};
use crate::http::extract::{OptionalBody, Path, Query};
use crate::http::fleets::FleetFilter;
use crate::http::labels::LabelFilter;
use crate::http::listing::Listing;
use crate::http::page::{LIMIT_MAX, Page, list_query};
use crate::http::problem::Problem;
use crate::http::search::Search;
use crate::http::words::ConnectionWord;
use vibrissa_store::list::Selection;
use vibrissa_store::lists::actions::ActionRow;
use vibrissa_store::lists::robots::{ARRAYS, ArraySort, ArraySummary, ROBOTS, RobotSort, RobotSummary};
use vibrissa_store::lists::whiskers::{WHISKERS, Whisker};

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new()
        .routes(routes!(list_robots))
        .routes(routes!(find_robot))
        .routes(routes!(get_robot, decommission_robot))
        .routes(routes!(list_arrays))
        .routes(routes!(find_array))
        .routes(routes!(get_array))
}

list_query! {
    /// Filters for the list of robots.
    pub struct RobotsQuery by RobotSort {
        /// Fleets: names or patterns such as `hall-*`, separated by commas.
        pub fleet: Option<FleetFilter>,
        /// Connection state of the robot.
        #[param(inline)]
        pub connection: Option<ConnectionWord>,
        /// True: only robots with something that needs attention; false: only the others.
        pub attention: Option<bool>,
        /// True: only robots that an operator holds; false: only the others.
        pub held: Option<bool>,
        /// Conditions on the labels of the robot: `key=value`, or `key` for any value; up to 8, separated by commas.
        #[param(inline)]
        pub label: Option<LabelFilter>,
        /// Text to look for in the names of fleet and robot and in the model, in upper or lower case.
        #[param(value_type = Option<String>, min_length = 1, max_length = 100, pattern = "^[^\\x00]+$")]
        pub q: Option<Search>,
    }
}

impl RobotsQuery {
    /// The conditions among the parameters.
    fn filter(&self) -> RobotFilter {
        RobotFilter {
            fleet: self.fleet.clone(),
            robot: None,
            connection: self.connection,
            attention: self.attention,
            held: self.held,
            label: self.label.clone(),
            q: self.q.clone(),
        }
    }
}

/// All known robots, each with the number of items that need attention.
#[utoipa::path(
    get, path = "/v1/robots", tag = "robots", params(RobotsQuery),
    responses((status = 200, description = "A page of robots", body = Page<RobotSummary>))
)]
async fn list_robots(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    listing: Listing,
    Query(query): Query<RobotsQuery>,
) -> Result<Response, Problem> {
    let mut selection = query.page()?;
    selection.filters = query.filter().conditions(&caller.scope)?;
    listing.answer::<RobotSummary>(&app, &ROBOTS, selection).await
}

/// One robot with its counts of whiskers, faults and alarms.
#[utoipa::path(
    get, path = "/v1/fleets/{fleet}/robots/{robot}", tag = "robots", params(RobotPath),
    responses((status = 200, description = "The robot", body = RobotSummary))
)]
async fn get_robot(State(app): State<App>, Path(at): Path<RobotPath>) -> Result<Json<RobotSummary>, Problem> {
    robot(&app, &at).await.map(Json)
}

/// Decommission a robot that has left for good.
///
/// It leaves all lists, metrics and limits, its alarms end, its compensations and setpoints end, and its retained messages are
/// cleared at the broker. Its history stays. Its learned state is forgotten: its next boot is registered anew, if the allow list permits it. Refused with 409 while the robot is connected and heard, unless the allow list
/// excludes it.
#[utoipa::path(
    delete, path = "/v1/fleets/{fleet}/robots/{robot}", tag = "robots",
    params(RobotPath, ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")),
    request_body = Option<Why>,
    responses(
        (status = 200, description = "The robot is decommissioned", body = ActionRow),
        (status = 202, description = "Pending; poll the action", body = ActionRow)
    ),
    extensions(("x-required-role" = json!("ENGINEER")))
)]
async fn decommission_robot(
    State(app): State<App>,
    Path(at): Path<RobotPath>,
    asker: Asker,
    OptionalBody(why): OptionalBody<Why>,
) -> Result<Response, Problem> {
    robot(&app, &at).await?;
    let mut action = asker.action(RecordedKind::Decommission.word(), &json!({}), reason(why.reason)?);
    action.fleet = Some(at.fleet.to_string());
    action.robot = Some(at.robot.to_string());
    ask(&app, &at.fleet, &action).await
}

/// One robot of the list, by the names in its row: the same answer as below `/v1/fleets`.
#[utoipa::path(
    get, path = "/v1/robots/{fleet}/{robot}", tag = "robots", params(RobotPath),
    responses((status = 200, description = "The robot", body = RobotSummary))
)]
async fn find_robot(State(app): State<App>, Path(at): Path<RobotPath>) -> Result<Json<RobotSummary>, Problem> {
    robot(&app, &at).await.map(Json)
}

async fn robot(app: &App, at: &RobotPath) -> Result<RobotSummary, Problem> {
    match app.store.first(&ROBOTS, at.filters()).await? {
        Some(robot) => Ok(robot),
        None => Err(at.unknown(&app.store).await),
    }
}

list_query! {
    /// Filters for the list of arrays.
    pub struct ArraysQuery by ArraySort {
        /// Fleets: names or patterns such as `hall-*`, separated by commas.
        pub fleet: Option<FleetFilter>,
        /// Name of the robot.
        #[param(value_type = Option<String>, pattern = "^[A-Za-z0-9_-]{1,64}$")]
        pub robot: Option<Name>,
    }
}

/// All arrays that are on a robot, each with the number of items that need attention.
#[utoipa::path(
    get, path = "/v1/arrays", tag = "robots", params(ArraysQuery),
    responses((status = 200, description = "A page of arrays", body = Page<ArraySummary>))
)]
async fn list_arrays(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    listing: Listing,
    Query(query): Query<ArraysQuery>,
) -> Result<Response, Problem> {
    let mut selection = query.page()?;
    selection.filters.extend(caller.scope.filter("fleet"));
    selection.of_fleets(query.fleet.as_deref());
    selection.is("robot", query.robot);
    listing.answer::<ArraySummary>(&app, &ARRAYS, selection).await
}

/// An array with its whiskers.
#[derive(Debug, Serialize, ToSchema)]
pub struct Array {
    /// Name of the fleet.
    pub fleet: String,
    /// Name of the robot.
    pub robot: String,
    /// Name of the array.
    pub array: String,
    /// `TYPE_1` (whiskers compensate for one another) or `TYPE_2` (single whiskers, which compensate for themselves).
    pub array_type: String,
    /// Connection state of its robot: `ONLINE`, `SILENT`, `OFFLINE` or `CONNECTION_BROKEN`.
    pub connection: String,
    /// Number of standing alarms.
    #[schema(minimum = 0)]
    pub alarms: i64,
    /// Number of items that need attention: alarms, faulty and uncompensated whiskers, added up.
    #[schema(minimum = 0)]
    pub attention: i64,
    /// Its whiskers, at most 1000.
    pub whiskers: Vec<Whisker>,
}

/// One array with its whiskers.
#[utoipa::path(
    get, path = "/v1/fleets/{fleet}/robots/{robot}/arrays/{array}", tag = "robots", params(ArrayPath),
    responses((status = 200, description = "The array", body = Array))
)]
async fn get_array(State(app): State<App>, Path(at): Path<ArrayPath>) -> Result<Json<Array>, Problem> {
    let known = array_summary(&app, &at).await?;
    Ok(Json(Array {
        fleet: known.fleet,
        robot: known.robot,
        array: known.array,
        array_type: known.array_type,
        connection: known.connection,
        alarms: known.alarms,
        attention: known.attention,
        whiskers: whiskers_of(&app, &at).await?,
    }))
}

/// One array of the list, by the names in its row, with the counts of the list and without its whiskers.
#[utoipa::path(
    get, path = "/v1/arrays/{fleet}/{robot}/{array}", tag = "robots", params(ArrayPath),
    responses((status = 200, description = "The array", body = ArraySummary))
)]
async fn find_array(State(app): State<App>, Path(at): Path<ArrayPath>) -> Result<Json<ArraySummary>, Problem> {
    array_summary(&app, &at).await.map(Json)
}

/// An array that is on a robot.
pub(super) async fn array_summary(app: &App, at: &ArrayPath) -> Result<ArraySummary, Problem> {
    match app.store.first(&ARRAYS, at.filters()).await? {
        Some(array) => Ok(array),
        None => Err(at.unknown(&app.store).await),
    }
}

/// The whiskers of an array, in the order in which they became known.
pub(super) async fn whiskers_of(app: &App, at: &ArrayPath) -> Result<Vec<Whisker>, Problem> {
    let selection = Selection { filters: at.filters(), ..Selection::all(&WHISKERS, LIMIT_MAX) };
    Ok(app.store.list(&WHISKERS, &selection).await?.rows)
}
