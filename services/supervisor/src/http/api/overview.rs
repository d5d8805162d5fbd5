//! Overview of fleets in one answer: the robots that need attention first with their whiskers, changes since a time, and the
//! distribution of measured errors.

use std::collections::HashMap;

use axum::extract::{Extension, State};
use axum::response::Json;
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vibrissa_edge::clock::wall_clock;

use crate::http::App;
use crate::http::access::Caller;
use crate::http::extract::Query;
use crate::http::fleets::FleetFilter;
use crate::http::moment::Moment;
use crate::http::problem::Problem;
use vibrissa_store::list::{Filter, Selection, Value};
use vibrissa_store::lists::robots::ROBOTS;
use vibrissa_store::lists::whiskers::WHISKERS;
use vibrissa_store::overview::{OverviewWhisker, RobotRow};
use vibrissa_store::time::Time;

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(get_overview))
}

/// Most robots of an overview.
const ROBOTS_MAX: u32 = 24;
/// Most whiskers of a robot in an overview.
const WHISKERS_MAX: u32 = 96;
/// Default time before now from which changes count: a day, in µs.
const SINCE_US: i64 = 86_400_000_000;
/// Width of the bins of errors, as a ratio.
const BIN_WIDTH: f64 = 0.05;
/// Number of the bins; the last one begins at 50 % and has no end.
const BINS: u8 = 11;

/// Parameters of an overview.
#[derive(Debug, Clone, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct OverviewQuery {
    /// Fleets: names or patterns such as `hall-*`, separated by commas; all visible fleets if omitted.
    pub fleet: Option<FleetFilter>,
    /// Earliest time of the changes, inclusive; 24 hours before now if omitted.
    #[param(value_type = Option<String>, format = DateTime)]
    pub from: Option<Moment>,
}

/// Overview of fleets.
#[derive(Debug, Serialize, ToSchema)]
pub struct Overview {
    /// Earliest time of the changes.
    pub from: Time,
    /// Number of trims that were detected, at most 100000, like all numbers of changes.
    #[schema(minimum = 0)]
    pub trims: i64,
    /// Number of setpoints that were issued and that robots applied.
    #[schema(minimum = 0)]
    pub setpoints_applied: i64,
    /// Number of alarms that were raised, whether they still stand or not.
    #[schema(minimum = 0)]
    pub alarms: i64,
    /// Number of whiskers that people marked as replaced.
    #[schema(minimum = 0)]
    pub whiskers_replaced: i64,
    /// Distribution of the newest measured mean error (Eq. 35) of the compensations in force, at most 20000 of them. The bins
    /// are in order, empty ones included.
    pub errors: Vec<OverviewErrors>,
    /// At most 24 robots, those that need attention first.
    pub robots: Vec<OverviewRobot>,
}

/// A bin of measured errors.
#[derive(Debug, Serialize, ToSchema)]
pub struct OverviewErrors {
    /// Lower bound of the bin as a ratio, inclusive. The first bin contains all errors below its upper bound.
    pub error_from: f64,
    /// Upper bound of the bin as a ratio, exclusive; null for the last one.
    pub error_to: Option<f64>,
    /// Number of compensations in the bin.
    #[schema(minimum = 0)]
    pub compensations: i64,
}

/// A robot in an overview.
#[derive(Debug, Serialize, ToSchema)]
pub struct OverviewRobot {
    /// Name of the fleet.
    pub fleet: String,
    /// Name of the robot.
    pub robot: String,
    /// Connection state: `ONLINE`, `SILENT`, `OFFLINE` or `CONNECTION_BROKEN`.
    pub connection: String,
    /// Number of things that need attention, as in the list of robots.
    #[schema(minimum = 0)]
    pub attention: i64,
    /// Its whiskers in the order in which they became known, at most 96.
    pub whiskers: Vec<OverviewWhisker>,
}

/// Overview of one fleet or of all: robots that need attention first, with their whiskers, changes since a time, and the
/// distribution of measured errors.
#[utoipa::path(
    get, path = "/v1/overview", tag = "fleets", params(OverviewQuery),
    responses((status = 200, description = "The overview", body = Overview))
)]
async fn get_overview(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    Query(query): Query<OverviewQuery>,
) -> Result<Json<Overview>, Problem> {
    let from = query.from.map_or_else(|| Time(wall_clock().0 as i64 - SINCE_US), |Moment(from)| from);
    let filters = |column| {
        let fleet = query.fleet.as_ref().map(|fleets| Filter::fleets(column, fleets.iter()));
        fleet.into_iter().chain(caller.scope.filter(column)).collect::<Vec<Filter>>()
    };
    let concerned = filters("r.fleet");
    let (changes, errors, robots) = tokio::join!(
        app.store.changes_since(&concerned, from.0),
        errors(&app, &concerned),
        robots(&app, filters("fleet"))
    );
    let (changes, errors, robots) = (changes?, errors?, robots?);
    let vibrissa_store::overview::Changes { trims, setpoints_applied, alarms, whiskers_replaced } = changes;
    Ok(Json(Overview { from, trims, setpoints_applied, alarms, whiskers_replaced, errors, robots }))
}

pub(super) async fn errors(app: &App, filters: &[Filter]) -> Result<Vec<OverviewErrors>, Problem> {
    let counted = app.store.error_bins(filters, BIN_WIDTH, BINS.into()).await?;
    let compensations = |bin: u8| {
        let found = counted.iter().find(|one| one.bin == i64::from(bin));
        found.map_or(0, |one| one.compensations)
    };
    // Whole per cents, so that the bounds are 0.15 and not 0.15000000000000002.
    let bound = |bin: u8| (f64::from(bin) * BIN_WIDTH * 100.0).round() / 100.0;
    let bin = |bin: u8| OverviewErrors {
        error_from: bound(bin),
        error_to: (bin + 1 < BINS).then(|| bound(bin + 1)),
        compensations: compensations(bin),
    };
    Ok((0..BINS).map(bin).collect())
}

async fn robots(app: &App, filters: Vec<Filter>) -> Result<Vec<OverviewRobot>, Problem> {
    let selection = Selection { filters, ..Selection::all(&ROBOTS, ROBOTS_MAX) };
    let rows: Vec<RobotRow> = app.store.list(&ROBOTS, &selection).await?.rows;
    let ids: Vec<i64> = rows.iter().map(|row| row.robot_id).collect();
    let mut whiskers = whiskers(app, ids).await?;
    let robot = |RobotRow { robot_id, fleet, robot, connection, attention }| {
        let whiskers = whiskers.remove(&robot_id).unwrap_or_default();
        OverviewRobot { fleet, robot, connection, attention, whiskers }
    };
    Ok(rows.into_iter().map(robot).collect())
}

/// The first whiskers of each of these robots.
async fn whiskers(app: &App, robots: Vec<i64>) -> Result<HashMap<i64, Vec<OverviewWhisker>>, Problem> {
    let mut found: HashMap<i64, Vec<OverviewWhisker>> = HashMap::new();
    // One query for all: PostgreSQL plans each one anew, which takes longer than reading a few whiskers by an index.
    let many = Selection::all(&WHISKERS, ROBOTS_MAX * WHISKERS_MAX);
    let many = many.with(Filter::IsOneOfNumbers("robot_id", robots.clone()));
    let page = app.store.list::<OverviewWhisker>(&WHISKERS, &many).await?;
    if page.next.is_none() {
        for whisker in page.rows {
            let of_robot = found.entry(whisker.robot_id).or_default();
            if of_robot.len() < WHISKERS_MAX as usize {
                of_robot.push(whisker);
            }
        }
        return Ok(found);
    }
    // Robots with very many whiskers would leave no place for those of the others.
    for robot_id in robots {
        let own = Selection::all(&WHISKERS, WHISKERS_MAX).with(Filter::Is("robot_id", Value::Whole(robot_id)));
        found.insert(robot_id, app.store.list(&WHISKERS, &own).await?.rows);
    }
    Ok(found)
}
