//! Whiskers and their state.

use axum::extract::{Extension, State};
use axum::response::{Json, Response};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vibrissa_protocol::Name;

use super::filters::WhiskerFilter;
use super::paths::WhiskerPath;
use crate::http::App;
use crate::http::access::Caller;
use crate::http::extract::{Path, Query};
use crate::http::fleets::FleetFilter;
use crate::http::labels::LabelFilter;
use crate::http::listing::Listing;
use crate::http::page::{Page, list_query};
use crate::http::problem::Problem;
use crate::http::search::Search;
use crate::http::words::ConditionWord;
use vibrissa_store::lists::whiskers::{WHISKERS, Whisker, WhiskerSort};

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(list_whiskers)).routes(routes!(find_whisker)).routes(routes!(get_whisker))
}

list_query! {
    /// Filters for the list of whiskers.
    pub struct WhiskersQuery by WhiskerSort {
        /// Fleets: names or patterns such as `hall-*`, separated by commas.
        pub fleet: Option<FleetFilter>,
        /// Name of the robot.
        #[param(value_type = Option<String>, pattern = "^[A-Za-z0-9_-]{1,64}$")]
        pub robot: Option<Name>,
        /// Name of the array.
        #[param(value_type = Option<String>, pattern = "^[A-Za-z0-9_-]{1,64}$")]
        pub array: Option<Name>,
        /// Mechanical condition of the whisker.
        #[param(inline)]
        pub condition: Option<ConditionWord>,
        /// True: only whiskers with a fault; false: only those without.
        pub faulty: Option<bool>,
        /// True: only whiskers that an operator holds; false: only the others.
        pub held: Option<bool>,
        /// True: only whiskers for which the alarm VENTED stands; false: only the others.
        pub vented: Option<bool>,
        /// Model of the whisker.
        #[param(value_type = Option<String>, pattern = "^[A-Za-z0-9_-]{1,64}$")]
        pub model: Option<Name>,
        /// Conditions on the labels of the robot: `key=value`, or `key` for any value; up to 8, separated by commas.
        #[param(inline)]
        pub label: Option<LabelFilter>,
        /// Text to look for in the names of fleet, robot and array, in upper or lower case.
        #[param(value_type = Option<String>, min_length = 1, max_length = 100, pattern = "^[^\\x00]+$")]
        pub q: Option<Search>,
    }
}

impl WhiskersQuery {
    /// The conditions among the parameters.
    fn filter(&self) -> WhiskerFilter {
        WhiskerFilter {
            fleet: self.fleet.clone(),
            robot: self.robot.clone(),
            array: self.array.clone(),
            condition: self.condition,
            faulty: self.faulty,
            held: self.held,
            vented: self.vented,
            model: self.model.clone(),
            label: self.label.clone(),
            q: self.q.clone(),
        }
    }
}

/// All whiskers that are on a robot.
#[utoipa::path(
    get, path = "/v1/whiskers", tag = "whiskers", params(WhiskersQuery),
    responses((status = 200, description = "A page of whiskers", body = Page<Whisker>))
)]
async fn list_whiskers(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    listing: Listing,
    Query(query): Query<WhiskersQuery>,
) -> Result<Response, Problem> {
    let mut selection = query.page()?;
    selection.filters = query.filter().conditions(&caller.scope)?;
    listing.answer::<Whisker>(&app, &WHISKERS, selection).await
}

/// One whisker with its state.
#[utoipa::path(
    get, path = "/v1/fleets/{fleet}/robots/{robot}/arrays/{array}/whiskers/{whisker}", tag = "whiskers",
    params(WhiskerPath),
    responses((status = 200, description = "The whisker", body = Whisker))
)]
async fn get_whisker(State(app): State<App>, Path(at): Path<WhiskerPath>) -> Result<Json<Whisker>, Problem> {
    whisker(&app, &at).await.map(Json)
}

/// One whisker of the list, by the names in its row: the same answer as below `/v1/fleets`.
#[utoipa::path(
    get, path = "/v1/whiskers/{fleet}/{robot}/{array}/{whisker}", tag = "whiskers", params(WhiskerPath),
    responses((status = 200, description = "The whisker", body = Whisker))
)]
async fn find_whisker(State(app): State<App>, Path(at): Path<WhiskerPath>) -> Result<Json<Whisker>, Problem> {
    whisker(&app, &at).await.map(Json)
}

/// A whisker that is on a robot.
pub(super) async fn whisker(app: &App, at: &WhiskerPath) -> Result<Whisker, Problem> {
    match app.store.first(&WHISKERS, at.filters()).await? {
        Some(whisker) => Ok(whisker),
        None => Err(at.unknown(&app.store).await),
    }
}
