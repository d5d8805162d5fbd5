//! Statistics of alarms by ISA-18.2: rate, floods, levels, the most frequent, chattering, standing and durations.

use axum::extract::{Extension, State};
use axum::response::Json;
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vibrissa_edge::clock::wall_clock;
use vibrissa_edge::guidance::{Level, of_word};
use vibrissa_edge::words::Words as _;

use crate::http::App;
use crate::http::access::Caller;
use crate::http::extract::Query;
use crate::http::fleets::FleetFilter;
use crate::http::moment::Moment;
use crate::http::problem::Problem;
use crate::http::words::{LevelWord, OneOf};
use vibrissa_store::alarm_statistics::{ALARMS_MAX, AlarmsOfSubject, Span, StaleAlarm};
use vibrissa_store::list::Filter;
use vibrissa_store::time::Time;

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(get_alarm_statistics))
}

/// Length of the default span, µs: a week.
const SPAN_US: i64 = 7 * 86_400_000_000;
const US_PER_HOUR: f64 = 3.6e9;
const US_PER_S: f64 = 1e6;

/// Fleets and span of the statistics.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct AlarmStatisticsQuery {
    /// Fleets: names or patterns such as `hall-*`, separated by commas.
    pub fleet: Option<FleetFilter>,
    /// Earliest time of raising, inclusive; a week before `to` by default.
    #[param(value_type = Option<String>, format = DateTime)]
    pub from: Option<Moment>,
    /// Latest time of raising, exclusive; now by default.
    #[param(value_type = Option<String>, format = DateTime)]
    pub to: Option<Moment>,
}

/// Statistics of the alarms that were raised in a span, by ISA-18.2. Each alarm counts once.
#[derive(Debug, Serialize, ToSchema)]
pub struct AlarmStatistics {
    /// Begin of the span.
    pub from: Time,
    /// End of the span.
    pub to: Time,
    /// Number of alarms that were raised. The statistics are computed over the newest 100000.
    #[schema(minimum = 0)]
    pub alarms: i64,
    /// Whether more than 100000 alarms were raised, and the oldest of them are left out.
    pub is_limited: bool,
    /// Mean number of alarms in an hour of the span.
    #[schema(minimum = 0)]
    pub alarms_per_hour: f64,
    /// Largest number of alarms in ten minutes.
    #[schema(minimum = 0)]
    pub busiest_ten_minutes: i64,
    /// Number of intervals of ten minutes with a flood: more than 10 alarms.
    #[schema(minimum = 0)]
    pub floods: i64,
    /// Number of the alarms that are over.
    #[schema(minimum = 0)]
    pub cleared: i64,
    /// Median time from raising to clearing, s; null if none is over.
    pub median_duration_s: Option<f64>,
    /// Longest time from raising to clearing, s; null if none is over.
    pub longest_duration_s: Option<f64>,
    /// Numbers by level, the least urgent first.
    pub levels: Vec<AlarmsOfLevel>,
    /// The ten whiskers or robots and kinds with the most alarms.
    pub top: Vec<AlarmsOfSubject>,
    /// At most ten whiskers or robots and kinds whose alarms chatter: three or more within ten minutes.
    pub chattering: Vec<AlarmsOfSubject>,
    /// Number of alarms that stand now, whenever they were raised, shelved ones included.
    #[schema(minimum = 0)]
    pub standing: i64,
    /// Number of alarms that have stood for more than a day.
    #[schema(minimum = 0)]
    pub standing_over_a_day: i64,
    /// At most ten alarms that have stood for more than a day, the oldest first.
    pub stale: Vec<StaleAlarm>,
}

/// Number of alarms of a level.
#[derive(Debug, Serialize, ToSchema)]
pub struct AlarmsOfLevel {
    /// How soon somebody must act.
    pub level: LevelWord,
    /// Number of alarms.
    #[schema(minimum = 0)]
    pub alarms: i64,
}

/// Statistics of the alarms of a span: how many in an hour, floods, levels, durations, the most frequent, those that
/// chatter, and those that have stood for more than a day.
#[utoipa::path(
    get, path = "/v1/alarms/statistics", tag = "happenings", params(AlarmStatisticsQuery),
    responses((status = 200, description = "The statistics", body = AlarmStatistics))
)]
async fn get_alarm_statistics(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    Query(query): Query<AlarmStatisticsQuery>,
) -> Result<Json<AlarmStatistics>, Problem> {
    let now_us = wall_clock().0 as i64;
    let to_us = query.to.map_or(now_us, |Moment(Time(to))| to);
    let from_us = query.from.map_or(to_us.saturating_sub(SPAN_US), |Moment(Time(from))| from);
    let mut filters: Vec<Filter> = caller.scope.filter("r.fleet").into_iter().collect();
    filters.extend(query.fleet.map(|fleets| Filter::fleets("r.fleet", fleets.iter())));
    let found = app.store.alarm_statistics(&Span { filters, from_us, to_us, now_us }).await?;
    let numbers = found.numbers;
    let of_level = |level: Level| {
        let level_of = |kind: &str| of_word(kind).map_or(Level::Warning, |guidance| guidance.level);
        let alarms = found.kinds.iter().filter(|one| level_of(&one.kind) == level).map(|one| one.alarms).sum();
        AlarmsOfLevel { level: OneOf(level), alarms }
    };
    let seconds = |us: i64| us as f64 / US_PER_S;
    Ok(Json(AlarmStatistics {
        from: Time(from_us),
        to: Time(to_us),
        alarms: numbers.alarms,
        is_limited: numbers.alarms == ALARMS_MAX,
        alarms_per_hour: numbers.alarms as f64 / (to_us.saturating_sub(from_us).max(1) as f64 / US_PER_HOUR),
        busiest_ten_minutes: numbers.busiest,
        floods: numbers.floods,
        cleared: numbers.cleared,
        median_duration_s: numbers.median_us.map(seconds),
        longest_duration_s: numbers.longest_us.map(seconds),
        levels: Level::all().into_iter().map(of_level).collect(),
        top: found.top,
        chattering: found.chattering,
        standing: numbers.standing,
        standing_over_a_day: numbers.stale,
        stale: found.stale,
    }))
}
