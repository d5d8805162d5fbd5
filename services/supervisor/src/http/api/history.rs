//! Aggregates of a whisker's contacts per minute and hour.

use axum::extract::State;
use axum::response::Response;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::paths::WhiskerPath;
use crate::http::App;
use crate::http::extract::{Path, Query};
use crate::http::listing::Listing;
use crate::http::moment::{Moment, between};
use crate::http::page::{Page, list_query};
use crate::http::problem::Problem;
use crate::http::words::ResolutionWord;
use vibrissa_store::list::{Filter, Value};
use vibrissa_store::lists::history::{HOURS, MINUTES, Rollup, RollupSort};

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(list_history))
}

list_query! {
    /// Filters for aggregates.
    pub struct HistoryQuery by RollupSort {
        /// Minutes, which are stored for a limited time, or hours, which are always stored. Default: hours.
        #[param(inline)]
        pub resolution: Option<ResolutionWord>,
        /// Earliest begin, inclusive, by the supervisor's clock.
        #[param(value_type = Option<String>, format = DateTime)]
        pub from: Option<Moment>,
        /// Latest begin, exclusive.
        #[param(value_type = Option<String>, format = DateTime)]
        pub to: Option<Moment>,
    }
}

/// Aggregates of a whisker's contacts for each completed minute or hour that has contacts, newest first.
#[utoipa::path(
    get, path = "/v1/fleets/{fleet}/robots/{robot}/arrays/{array}/whiskers/{whisker}/history", tag = "whiskers",
    params(WhiskerPath, HistoryQuery),
    responses((status = 200, description = "A page of minutes or hours", body = Page<Rollup>))
)]
async fn list_history(
    State(app): State<App>,
    Path(at): Path<WhiskerPath>,
    listing: Listing,
    Query(query): Query<HistoryQuery>,
) -> Result<Response, Problem> {
    let mut selection = query.page()?;
    selection.filters = between("start_at", query.from, query.to).collect();
    selection.filters.push(Filter::Is("whisker_id", Value::Whole(at.whisker_id(&app.store).await?)));
    let list = match query.resolution.unwrap_or(ResolutionWord::Hour) {
        ResolutionWord::Minute => &MINUTES,
        ResolutionWord::Hour => &HOURS,
    };
    listing.answer::<Rollup>(&app, list, selection).await
}
