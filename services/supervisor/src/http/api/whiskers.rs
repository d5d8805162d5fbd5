//! Whiskers: what is known of each.

use axum::extract::{Extension, State};
use axum::response::Json;
use serde::Deserialize;
use utoipa::IntoParams;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vibrissa_protocol::Name;

use crate::http::App;
use crate::http::access::Caller;
use crate::http::extract::{Path, Query};
use crate::http::page::{Page, list_query};
use crate::http::problem::Problem;
use crate::http::words::ConditionWord;
use crate::store::list::{Filter, Value};
use crate::store::lists::whiskers::{WHISKERS, Whisker, WhiskerSort};

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(list_whiskers)).routes(routes!(get_whisker))
}

list_query! {
    /// Which whiskers.
    pub struct WhiskersQuery by WhiskerSort {
        /// Of this fleet.
        #[param(value_type = Option<String>, pattern = "^[A-Za-z0-9_-]{1,64}$")]
        pub fleet: Option<Name>,
        /// Of this robot.
        #[param(value_type = Option<String>, pattern = "^[A-Za-z0-9_-]{1,64}$")]
        pub robot: Option<Name>,
        /// Of this array.
        #[param(value_type = Option<String>, pattern = "^[A-Za-z0-9_-]{1,64}$")]
        pub array: Option<Name>,
        /// In this condition.
        pub condition: Option<ConditionWord>,
        /// Only those with a fault, or without.
        pub faulty: Option<bool>,
    }
}

/// Every whisker that is on a robot.
#[utoipa::path(
    get, path = "/v1/whiskers", tag = "whiskers", params(WhiskersQuery),
    responses((status = 200, description = "A page of whiskers", body = Page<Whisker>))
)]
async fn list_whiskers(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    Query(query): Query<WhiskersQuery>,
) -> Result<Json<Page<Whisker>>, Problem> {
    let mut selection = query.page()?;
    selection.filters.extend(caller.scope.filter("fleet"));
    selection.is("fleet", query.fleet);
    selection.is("robot", query.robot);
    selection.is("\"array\"", query.array);
    selection.is("condition", query.condition);
    selection.filters.extend(query.faulty.map(|faulty| Filter::IsNull("fault", !faulty)));
    Ok(Json(Page::of(app.store.list(&WHISKERS, &selection).await?, &selection)))
}

/// Where a whisker is.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Path)]
pub struct WhiskerPath {
    /// Fleet.
    #[param(value_type = String, pattern = "^[A-Za-z0-9_-]{1,64}$")]
    pub fleet: Name,
    /// Robot.
    #[param(value_type = String, pattern = "^[A-Za-z0-9_-]{1,64}$")]
    pub robot: Name,
    /// Array.
    #[param(value_type = String, pattern = "^[A-Za-z0-9_-]{1,64}$")]
    pub array: Name,
    /// Number in the array.
    pub whisker: u16,
}

/// One whisker.
#[utoipa::path(
    get, path = "/v1/fleets/{fleet}/robots/{robot}/arrays/{array}/whiskers/{whisker}", tag = "whiskers",
    params(WhiskerPath),
    responses((status = 200, description = "The whisker", body = Whisker))
)]
async fn get_whisker(State(app): State<App>, Path(at): Path<WhiskerPath>) -> Result<Json<Whisker>, Problem> {
    let filters = vec![
        Filter::Is("fleet", Value::Text(at.fleet.to_string())),
        Filter::Is("robot", Value::Text(at.robot.to_string())),
        Filter::Is("\"array\"", Value::Text(at.array.to_string())),
        Filter::Is("whisker", Value::Whole(at.whisker.into())),
    ];
    let found = app.store.first(&WHISKERS, filters).await?;
    found.map(Json).ok_or_else(|| {
        Problem::not_found(format_args!("whisker {} of {}/{}/{}", at.whisker, at.fleet, at.robot, at.array))
    })
}
