//! Measured errors of compensations, single and in groups.

use axum::extract::{Extension, State};
use axum::response::{Json, Response};
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vibrissa_protocol::Name;

use crate::http::App;
use crate::http::access::Caller;
use crate::http::extract::Query;
use crate::http::fleets::FleetFilter;
use crate::http::listing::Listing;
use crate::http::moment::{Moment, between};
use crate::http::number::RowNumber;
use crate::http::page::{Page, list_query};
use crate::http::problem::Problem;
use crate::http::words::CaseWord;
use vibrissa_store::list::{Filter, Value};
use vibrissa_store::lists::errors::{
    BY_CASE, BY_RATIO, BY_TIME, BY_WHISKER, ERRORS, ErrorByCase, ErrorByRatio, ErrorByTime, ErrorByWhisker, ErrorSort,
    ErrorStatement,
};

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new()
        .routes(routes!(list_errors))
        .routes(routes!(errors_by_time))
        .routes(routes!(errors_by_case))
        .routes(routes!(errors_by_ratio))
        .routes(routes!(errors_by_whisker))
}

list_query! {
    /// Filters for the list of errors.
    pub struct ErrorsQuery by ErrorSort {
        /// Fleets: names or patterns such as `hall-*`, separated by commas.
        pub fleet: Option<FleetFilter>,
        /// Name of the robot.
        #[param(value_type = Option<String>, pattern = "^[A-Za-z0-9_-]{1,64}$")]
        pub robot: Option<Name>,
        /// Name of the array.
        #[param(value_type = Option<String>, pattern = "^[A-Za-z0-9_-]{1,64}$")]
        pub array: Option<Name>,
        /// Number of the target whisker.
        #[param(maximum = 65535)]
        pub whisker: Option<u16>,
        /// Compensation case of the paper.
        #[param(inline)]
        pub case: Option<CaseWord>,
        /// Number of the compensation.
        #[param(value_type = Option<i64>, minimum = 0, maximum = 9007199254740991_i64)]
        pub compensation_id: Option<RowNumber>,
        /// Earliest time of the statement, inclusive.
        #[param(value_type = Option<String>, format = DateTime)]
        pub from: Option<Moment>,
        /// Latest time of the statement, exclusive.
        #[param(value_type = Option<String>, format = DateTime)]
        pub to: Option<Moment>,
    }
}

/// All measured errors of compensations, each as stated while contacts came in.
#[utoipa::path(
    get, path = "/v1/errors", tag = "errors", params(ErrorsQuery),
    responses((status = 200, description = "A page of errors", body = Page<ErrorStatement>))
)]
async fn list_errors(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    listing: Listing,
    Query(query): Query<ErrorsQuery>,
) -> Result<Response, Problem> {
    let mut selection = query.page()?;
    let ErrorsQuery { fleet, robot, array, whisker, case, compensation_id, from, to, .. } = query;
    selection.filters =
        ErrorGroupsQuery { fleet, robot, array, whisker, case, compensation_id, from, to }.filters(&caller);
    listing.answer::<ErrorStatement>(&app, &ERRORS, selection).await
}

/// Filters for groups of errors. Only the newest 200,000 matching statements are grouped.
#[derive(Debug, Default, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct ErrorGroupsQuery {
    /// Fleets: names or patterns such as `hall-*`, separated by commas.
    pub fleet: Option<FleetFilter>,
    /// Name of the robot.
    #[param(value_type = Option<String>, pattern = "^[A-Za-z0-9_-]{1,64}$")]
    pub robot: Option<Name>,
    /// Name of the array.
    #[param(value_type = Option<String>, pattern = "^[A-Za-z0-9_-]{1,64}$")]
    pub array: Option<Name>,
    /// Number of the target whisker.
    #[param(maximum = 65535)]
    pub whisker: Option<u16>,
    /// Compensation case of the paper.
    #[param(inline)]
    pub case: Option<CaseWord>,
    /// Number of the compensation.
    #[param(value_type = Option<i64>, minimum = 0, maximum = 9007199254740991_i64)]
    pub compensation_id: Option<RowNumber>,
    /// Earliest time of the statement, inclusive.
    #[param(value_type = Option<String>, format = DateTime)]
    pub from: Option<Moment>,
    /// Latest time of the statement, exclusive.
    #[param(value_type = Option<String>, format = DateTime)]
    pub to: Option<Moment>,
}

impl ErrorGroupsQuery {
    fn filters(&self, caller: &Caller) -> Vec<Filter> {
        let names = [("robot", &self.robot), ("\"array\"", &self.array)];
        let names = names.into_iter().filter_map(|(column, name)| Some((column, name.as_ref()?.to_string())));
        let mut filters: Vec<Filter> = names.map(|(column, name)| Filter::Is(column, Value::Text(name))).collect();
        filters.extend(self.fleet.as_ref().map(|fleets| Filter::fleets("fleet", fleets.iter())));
        filters.extend(self.case.map(|case| Filter::Is("compensation_case", Value::Text(case.to_string()))));
        filters.extend(self.whisker.map(|whisker| Filter::Is("target_whisker", Value::Whole(whisker.into()))));
        filters.extend(self.compensation_id.map(|id| Filter::Is("compensation_id", Value::Whole(id.0))));
        filters.extend(between("recorded_at", self.from, self.to));
        filters.extend(caller.scope.filter("fleet"));
        filters
    }
}

/// Groups of errors.
#[derive(Debug, Serialize, ToSchema)]
pub struct Groups<T> {
    /// The groups, at most 1000.
    pub items: Vec<T>,
}

/// Filters for groups of errors by time.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct ErrorsByTimeQuery {
    /// Fleets: names or patterns such as `hall-*`, separated by commas.
    pub fleet: Option<FleetFilter>,
    /// Name of the robot.
    #[param(value_type = Option<String>, pattern = "^[A-Za-z0-9_-]{1,64}$")]
    pub robot: Option<Name>,
    /// Name of the array.
    #[param(value_type = Option<String>, pattern = "^[A-Za-z0-9_-]{1,64}$")]
    pub array: Option<Name>,
    /// Number of the target whisker.
    #[param(maximum = 65535)]
    pub whisker: Option<u16>,
    /// Compensation case of the paper.
    #[param(inline)]
    pub case: Option<CaseWord>,
    /// Number of the compensation.
    #[param(value_type = Option<i64>, minimum = 0, maximum = 9007199254740991_i64)]
    pub compensation_id: Option<RowNumber>,
    /// Earliest time of the statement, inclusive.
    #[param(value_type = Option<String>, format = DateTime)]
    pub from: Option<Moment>,
    /// Latest time of the statement, exclusive.
    #[param(value_type = Option<String>, format = DateTime)]
    pub to: Option<Moment>,
    /// Length of the intervals in seconds; they begin at whole multiples of it since 1970.
    #[param(minimum = 1, maximum = 31536000, default = 3600)]
    pub bucket_s: Option<u32>,
}

/// Default length of the intervals, in seconds.
const BUCKET_S: u32 = 3600;
/// Greatest length of the intervals, in seconds: a year.
const BUCKET_S_MAX: u32 = 31_536_000;
const US_PER_S: i64 = 1_000_000;

/// Errors by time: the newest statement of each compensation per interval. The newest 1000 intervals, in order.
#[utoipa::path(
    get, path = "/v1/errors/by-time", tag = "errors", params(ErrorsByTimeQuery),
    responses((status = 200, description = "Errors by time", body = Groups<ErrorByTime>))
)]
async fn errors_by_time(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    Query(query): Query<ErrorsByTimeQuery>,
) -> Result<Json<Groups<ErrorByTime>>, Problem> {
    let bucket_s = query.bucket_s.unwrap_or(BUCKET_S);
    if !(1..=BUCKET_S_MAX).contains(&bucket_s) {
        return Err(Problem::invalid("bucket_s", format!("must be 1 to {BUCKET_S_MAX}, not {bucket_s}")));
    }
    let ErrorsByTimeQuery { fleet, robot, array, whisker, case, compensation_id, from, to, .. } = query;
    let which = ErrorGroupsQuery { fleet, robot, array, whisker, case, compensation_id, from, to };
    let bucket_us = i64::from(bucket_s) * US_PER_S;
    let mut items: Vec<ErrorByTime> = app.store.groups(&BY_TIME, &which.filters(&caller), bucket_us).await?;
    items.reverse();
    Ok(Json(Groups { items }))
}

/// Errors by case of the paper: the newest statement of each compensation counts.
#[utoipa::path(
    get, path = "/v1/errors/by-case", tag = "errors", params(ErrorGroupsQuery),
    responses((status = 200, description = "Errors by case", body = Groups<ErrorByCase>))
)]
async fn errors_by_case(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    Query(which): Query<ErrorGroupsQuery>,
) -> Result<Json<Groups<ErrorByCase>>, Problem> {
    Ok(Json(Groups { items: app.store.groups(&BY_CASE, &which.filters(&caller), i64::MAX).await? }))
}

/// Errors by contact ratio: the newest statement of each compensation counts.
#[utoipa::path(
    get, path = "/v1/errors/by-ratio", tag = "errors", params(ErrorGroupsQuery),
    responses((status = 200, description = "Errors by contact ratio", body = Groups<ErrorByRatio>))
)]
async fn errors_by_ratio(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    Query(which): Query<ErrorGroupsQuery>,
) -> Result<Json<Groups<ErrorByRatio>>, Problem> {
    Ok(Json(Groups { items: app.store.groups(&BY_RATIO, &which.filters(&caller), i64::MAX).await? }))
}

/// Errors by target whisker, the greatest first: the newest statement of each compensation counts.
#[utoipa::path(
    get, path = "/v1/errors/by-whisker", tag = "errors", params(ErrorGroupsQuery),
    responses((status = 200, description = "Errors by whisker", body = Groups<ErrorByWhisker>))
)]
async fn errors_by_whisker(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    Query(which): Query<ErrorGroupsQuery>,
) -> Result<Json<Groups<ErrorByWhisker>>, Problem> {
    Ok(Json(Groups { items: app.store.groups(&BY_WHISKER, &which.filters(&caller), i64::MAX).await? }))
}
