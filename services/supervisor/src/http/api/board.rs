//! The board of robots: each robot with its worst state, in groups, beside the worst whiskers, the distribution of errors and
//! the changes of a day.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use axum::extract::{Extension, State};
use axum::response::Json;
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vibrissa_edge::clock::wall_clock;
use vibrissa_store::list::Filter;
use vibrissa_store::lists::board::{BoardRow, WorstRow};
use vibrissa_store::overview::HourOfChanges;
use vibrissa_store::time::Time;

use super::overview::{OverviewErrors, errors};
use crate::http::App;
use crate::http::access::Caller;
use crate::http::extract::Query;
use crate::http::fleets::FleetFilter;
use crate::http::labels::{LabelFilter, LabelKeyText};
use crate::http::problem::Problem;
use crate::http::search::Search;
use crate::http::words::RobotStateWord;

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(get_board))
}

/// Most robots that an answer names one by one.
const NAMED_MAX: usize = 2_000;
/// Most whiskers of an answer.
const WHISKERS_MAX: i64 = 50;
/// Hours of changes.
const HOURS: usize = 24;
/// Length of an hour, µs.
const HOUR_US: i64 = 3_600_000_000;

/// Parameters of a board.
#[derive(Debug, Clone, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct BoardQuery {
    /// Fleets: names or patterns such as `hall-*`, separated by commas; all visible fleets if omitted.
    pub fleet: Option<FleetFilter>,
    /// Conditions on the labels of the robot: `key=value`, or `key` for any value; up to 8, separated by commas.
    #[param(inline)]
    pub label: Option<LabelFilter>,
    /// Text to look for in the names of fleet and robot and in the model, in upper or lower case.
    #[param(value_type = Option<String>, min_length = 1, max_length = 100, pattern = "^[^\\x00]+$")]
    pub q: Option<Search>,
    /// State of the robots and whiskers that the answer names. The numbers of the groups do not depend on it.
    #[param(inline)]
    pub state: Option<RobotStateWord>,
    /// Key of the label that groups the robots; by fleet if omitted.
    #[param(inline)]
    pub by: Option<LabelKeyText>,
}

/// Board of robots.
#[derive(Debug, Serialize, ToSchema)]
pub struct Board {
    /// Groups with the numbers of their robots by state, in the order of their names.
    pub groups: Vec<BoardGroup>,
    /// The robots by fleet and name. None of them is named if there are more than 2000.
    pub robots: Vec<BoardRobot>,
    /// Whether the robots are too many to be named: then `robots` is empty.
    pub folded: bool,
    /// Keys of the labels of all these robots, in order.
    pub label_keys: Vec<String>,
    /// At most 50 whiskers, the worst first: cut and not compensated, faulty, worn, compensated; each by the missing length.
    pub whiskers: Vec<BoardWhisker>,
    /// Distribution of the newest measured mean error of the compensations in force, as in the overview.
    pub errors: Vec<OverviewErrors>,
    /// Changes of the last 24 hours in the fleets. Neither the condition on labels nor the search concerns them.
    pub changes: BoardChanges,
}

/// A group of robots: a fleet, or the robots with the same value of a label.
#[derive(Debug, Serialize, ToSchema)]
pub struct BoardGroup {
    /// Name of the fleet, or value of the label; null for the robots without the label.
    pub group: Option<String>,
    /// Number of robots.
    #[schema(minimum = 0)]
    pub robots: usize,
    /// Numbers of robots by state; each robot is in one state, and states without robots are missing.
    pub states: BTreeMap<String, usize>,
}

/// A robot of a board.
#[derive(Debug, Serialize, ToSchema)]
pub struct BoardRobot {
    /// Name of the fleet.
    pub fleet: String,
    /// Name of the robot.
    pub robot: String,
    /// Number of its group, from 0.
    #[schema(minimum = 0)]
    pub group: usize,
    /// Its worst state.
    pub state: RobotStateWord,
    /// Number of whiskers that are the reason of the state; 0 if it is about the whole robot.
    #[schema(minimum = 0)]
    pub whiskers: i64,
    /// Number of standing alarms that are not shelved.
    #[schema(minimum = 0)]
    pub alarms: i64,
}

/// A whisker that is not sound.
#[derive(Debug, Serialize, ToSchema)]
pub struct BoardWhisker {
    /// Name of the fleet.
    pub fleet: String,
    /// Name of the robot.
    pub robot: String,
    /// Name of the array.
    pub array: String,
    /// Number of the whisker in its array.
    #[schema(minimum = 0)]
    pub whisker: i64,
    /// Connection state of the robot: `ONLINE`, `SILENT`, `OFFLINE` or `CONNECTION_BROKEN`.
    pub connection: String,
    /// Mechanical condition, such as `TRIMMED`.
    pub condition: String,
    /// Fault, such as `LEAK`; null without one.
    pub fault: Option<String>,
    /// Number of the compensation in force for it; null without one.
    pub compensated_by: Option<i64>,
    /// Length by the factsheet less the estimated length, mm.
    pub lost_mm: f64,
    /// Newest measured mean error (Eq. 35) of the compensation in force, as a ratio; null without one.
    pub error: Option<f64>,
    /// Time of the cut, or of the standing alarm about the whisker, by the supervisor's clock; null without both.
    pub since: Option<Time>,
}

/// Numbers of changes in each of the last 24 hours, the present hour last.
#[derive(Debug, Default, Serialize, ToSchema)]
pub struct BoardChanges {
    /// Trims that the supervisor detected.
    pub trims: [i64; HOURS],
    /// Alarms that were raised.
    pub alarms: [i64; HOURS],
    /// Setpoints that were issued and that robots applied.
    pub setpoints_applied: [i64; HOURS],
    /// Whiskers that people marked as replaced.
    pub whiskers_replaced: [i64; HOURS],
}

/// The board of robots: each robot with its worst state, in groups by fleet or by a label, beside the worst whiskers.
#[utoipa::path(
    get, path = "/v1/board", tag = "fleets", params(BoardQuery),
    responses((status = 200, description = "The board", body = Board))
)]
async fn get_board(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    Query(query): Query<BoardQuery>,
) -> Result<Json<Board>, Problem> {
    let mut filters: Vec<Filter> = caller.scope.filter("r.fleet").into_iter().collect();
    filters.extend(query.fleet.as_ref().map(|fleets| Filter::fleets("r.fleet", fleets.iter())));
    // A replaced whisker is recorded by names, and not by the number of a robot.
    let of_fleets = filters.clone();
    filters.extend(Filter::labels("r.robot_id", query.label.as_ref().map(|LabelFilter(label)| label)));
    filters.extend(query.q.as_ref().map(|q| Filter::Contains(&["r.fleet", "r.robot", "r.model"], q.to_string())));
    let from_us = wall_clock().0 as i64 - HOUR_US * HOURS as i64;
    let (rows, errors, hours, whiskers) = tokio::join!(
        app.store.board_robots(&filters),
        errors(&app, &filters),
        app.store.changes_by_hour(&of_fleets, from_us),
        app.store.worst_whiskers(&filters, WHISKERS_MAX)
    );
    let (rows, errors, hours, mut whiskers) = (rows?, errors?, hours?, whiskers?);

    let by = query.by.as_ref().map(|LabelKeyText(key)| key.as_str());
    let (groups, group_of) = groups(&rows, by);
    let is_named = |row: &&BoardRow| query.state.is_none_or(|state| state_of(row).0 == state);
    let named: Vec<&BoardRow> = rows.iter().filter(is_named).collect();
    let folded = named.len() > NAMED_MAX;
    // Which robots are in a state is known only now.
    if query.state.is_some() && !folded {
        filters.push(Filter::IsOneOfNumbers("r.robot_id", named.iter().map(|row| row.robot_id).collect()));
        whiskers = app.store.worst_whiskers(&filters, WHISKERS_MAX).await?;
    }
    let robot = |row: &BoardRow| {
        let (state, whiskers) = state_of(row);
        let group = group_of.get(&group(row, by)).copied().unwrap_or_default();
        let BoardRow { fleet, robot, alarms, .. } = row.clone();
        BoardRobot { fleet, robot, group, state, whiskers, alarms }
    };
    let keys: BTreeSet<&str> = rows.iter().flat_map(|row| row.labels.0.iter().map(|(key, _)| key)).collect();
    Ok(Json(Board {
        robots: if folded { Vec::new() } else { named.into_iter().map(robot).collect() },
        folded,
        label_keys: keys.into_iter().map(ToOwned::to_owned).collect(),
        whiskers: whiskers.into_iter().map(BoardWhisker::from).collect(),
        errors,
        changes: BoardChanges::of(&hours),
        groups,
    }))
}

/// The state of a robot, and how many whiskers are its reason. Of a robot that is not heard nobody knows the present state of
/// the whiskers.
fn state_of(row: &BoardRow) -> (RobotStateWord, i64) {
    match row.connection.as_str() {
        "CONNECTION_BROKEN" => return (RobotStateWord::ConnectionBroken, 0),
        "SILENT" => return (RobotStateWord::Silent, 0),
        "OFFLINE" => return (RobotStateWord::Offline, 0),
        _ => {}
    }
    let states = [
        (RobotStateWord::Uncompensated, row.uncompensated),
        (RobotStateWord::Faulty, row.faulty),
        (RobotStateWord::Worn, row.worn),
        (RobotStateWord::Compensated, row.compensated),
        (RobotStateWord::Learning, row.learning),
    ];
    let worst = states.into_iter().find(|(_, whiskers)| *whiskers > 0);
    match worst {
        Some(worst @ (RobotStateWord::Uncompensated | RobotStateWord::Faulty, _)) => worst,
        _ if row.alarms > 0 => (RobotStateWord::Alarm, 0),
        Some(worst) => worst,
        None => (RobotStateWord::Healthy, 0),
    }
}

/// The group of a robot.
fn group<'a>(row: &'a BoardRow, by: Option<&str>) -> Option<&'a str> {
    by.map_or(Some(row.fleet.as_str()), |key| row.labels.0.get(key))
}

/// The groups in order, and the place of each; robots without the label are last.
fn groups<'a>(rows: &'a [BoardRow], by: Option<&str>) -> (Vec<BoardGroup>, HashMap<Option<&'a str>, usize>) {
    let mut found: BTreeMap<(bool, Option<&str>), BTreeMap<String, usize>> = BTreeMap::new();
    for row in rows {
        let group = group(row, by);
        let states = found.entry((group.is_none(), group)).or_default();
        *states.entry(state_of(row).0.to_string()).or_default() += 1;
    }
    let places = found.keys().enumerate().map(|(place, (_, group))| (*group, place)).collect();
    let groups = found.into_iter().map(|((_, group), states)| BoardGroup {
        group: group.map(ToOwned::to_owned),
        robots: states.values().sum(),
        states,
    });
    (groups.collect(), places)
}

impl From<WorstRow> for BoardWhisker {
    fn from(row: WorstRow) -> Self {
        let WorstRow { fleet, robot, array, whisker, connection, condition, fault, .. } = row;
        let WorstRow { compensated_by, lost_mm, error, since, .. } = row;
        Self { fleet, robot, array, whisker, connection, condition, fault, compensated_by, lost_mm, error, since }
    }
}

impl BoardChanges {
    fn of(hours: &[HourOfChanges]) -> Self {
        let of_kind = |kind: &str| {
            let mut all = [0; HOURS];
            for one in hours.iter().filter(|one| one.kind == kind) {
                // A change that another supervisor's clock dates after now is no change of this day.
                if let Some(hour) = usize::try_from(one.hour).ok().and_then(|hour| all.get_mut(hour)) {
                    *hour = one.changes;
                }
            }
            all
        };
        Self {
            trims: of_kind("trims"),
            alarms: of_kind("alarms"),
            setpoints_applied: of_kind("setpoints_applied"),
            whiskers_replaced: of_kind("whiskers_replaced"),
        }
    }
}
