//! Plots of recorded data, as SVG.

use std::convert::Infallible;

use axum::extract::{Extension, FromRequestParts, State};
use axum::http::header;
use axum::http::request::Parts;
use axum::response::{IntoResponse, Response};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::compensations::compensation;
use super::contacts::{SpanQuery, series};
use super::paths::{ArrayPath, CompensationPath, WhiskerPath};
use super::robots::{array_summary, whiskers_of};
use super::whiskers::whisker;
use crate::http::App;
use crate::http::accept::preferred;
use crate::http::access::Caller;
use crate::http::extract::{Path, Query};
use crate::http::moment::Moment;
use crate::http::problem::Problem;
use crate::plot::{array, console};
use vibrissa_store::list::{Filter, List, Selection, Value};
use vibrissa_store::lists::errors::{ERRORS, ErrorStatement};
use vibrissa_store::lists::setpoints::{SETPOINTS, Setpoint};
use vibrissa_store::series::Series;
use vibrissa_store::time::Time;

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new()
        .routes(routes!(plot_lengths))
        .routes(routes!(plot_contacts))
        .routes(routes!(plot_pressures))
        .routes(routes!(plot_errors))
        .routes(routes!(plot_compensation))
        .routes(routes!(plot_array))
}

/// Media types of pictures.
const PICTURES: [&str; 2] = ["image/svg+xml", "text/xml"];

/// Maximum number of rows in a plot.
const ROWS: u32 = 1000;

/// Media type of a picture: `image/svg+xml`, or `text/xml` if the client does not accept that. Many generated clients
/// cannot read the first: they drop the answer or refuse it, and ask for another type than pictures.
#[derive(Debug, Clone, Copy)]
pub(super) struct Picture(&'static str);

impl<S: Send + Sync> FromRequestParts<S> for Picture {
    type Rejection = Infallible;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Infallible> {
        Ok(Self(PICTURES[preferred(&parts.headers, &PICTURES).unwrap_or(1)]))
    }
}

impl Picture {
    /// The answer with a picture.
    pub(super) fn of(self, svg: String) -> Response {
        let headers = [(header::CONTENT_TYPE, self.0), (header::CACHE_CONTROL, "no-cache"), (header::VARY, "Accept")];
        (headers, svg).into_response()
    }
}

/// The contacts of a plot: of the newest day, unless a time range is given.
async fn drawn(app: &App, at: &WhiskerPath, mut query: SpanQuery) -> Result<Series, Problem> {
    if query.from.is_none() && query.to.is_none() {
        query.to = Some(Moment(Time(i64::MAX)));
    }
    Ok(series(app, at, query).await?.1)
}

/// The newest rows of a whisker, newest first.
fn newest(list: &List, at: &WhiskerPath, column: &'static str) -> Selection {
    let whisker = Filter::Is(column, Value::Whole(at.whisker.into()));
    Selection { filters: at.on_array().filters(), ..Selection::all(list, ROWS) }.with(whisker)
}

/// A whisker's estimated length over time, with its 95 % interval: the newest day, unless a time range is given.
#[utoipa::path(
    get, path = "/v1/fleets/{fleet}/robots/{robot}/arrays/{array}/whiskers/{whisker}/lengths/plot.svg", tag = "plots",
    params(WhiskerPath, SpanQuery),
    responses((status = 200, description = "The plot", body = String, content_type = "image/svg+xml"))
)]
async fn plot_lengths(
    State(app): State<App>,
    Path(at): Path<WhiskerPath>,
    picture: Picture,
    Query(query): Query<SpanQuery>,
) -> Result<Response, Problem> {
    let whisker = whisker(&app, &at).await?;
    Ok(picture.of(console::lengths(&whisker, &drawn(&app, &at, query).await?)))
}

/// Ratio of a whisker's measured to predicted sensitivity over time: the newest day, unless a time range is given.
#[utoipa::path(
    get, path = "/v1/fleets/{fleet}/robots/{robot}/arrays/{array}/whiskers/{whisker}/contacts/plot.svg", tag = "plots",
    params(WhiskerPath, SpanQuery),
    responses((status = 200, description = "The plot", body = String, content_type = "image/svg+xml"))
)]
async fn plot_contacts(
    State(app): State<App>,
    Path(at): Path<WhiskerPath>,
    picture: Picture,
    Query(query): Query<SpanQuery>,
) -> Result<Response, Problem> {
    let whisker = whisker(&app, &at).await?;
    Ok(picture.of(console::contacts(&whisker, &drawn(&app, &at, query).await?)))
}

/// A whisker's setpoints and measured pressures over time: the newest day, unless a time range is given.
#[utoipa::path(
    get, path = "/v1/fleets/{fleet}/robots/{robot}/arrays/{array}/whiskers/{whisker}/pressures/plot.svg", tag = "plots",
    params(WhiskerPath, SpanQuery),
    responses((status = 200, description = "The plot", body = String, content_type = "image/svg+xml"))
)]
async fn plot_pressures(
    State(app): State<App>,
    Path(at): Path<WhiskerPath>,
    picture: Picture,
    Query(query): Query<SpanQuery>,
) -> Result<Response, Problem> {
    let whisker = whisker(&app, &at).await?;
    let series = drawn(&app, &at, query).await?;
    let mut setpoints: Vec<Setpoint> = app.store.list(&SETPOINTS, &newest(&SETPOINTS, &at, "whisker")).await?.rows;
    setpoints.reverse();
    Ok(picture.of(console::pressures(&whisker, &series, &setpoints)))
}

/// The error of a whisker's compensations over time, with its 95 % interval: the newest 1000 statements.
#[utoipa::path(
    get, path = "/v1/fleets/{fleet}/robots/{robot}/arrays/{array}/whiskers/{whisker}/errors/plot.svg", tag = "plots",
    params(WhiskerPath),
    responses((status = 200, description = "The plot", body = String, content_type = "image/svg+xml"))
)]
async fn plot_errors(
    State(app): State<App>,
    Path(at): Path<WhiskerPath>,
    picture: Picture,
) -> Result<Response, Problem> {
    let whisker = whisker(&app, &at).await?;
    let selection = newest(&ERRORS, &at, "target_whisker");
    let mut statements: Vec<ErrorStatement> = app.store.list(&ERRORS, &selection).await?.rows;
    statements.reverse();
    Ok(picture.of(console::errors(&whisker, &statements)))
}

/// The error of a compensation by contact ratio: predicted, and measured with its 95 % interval.
#[utoipa::path(
    get, path = "/v1/compensations/{compensation_id}/plot.svg", tag = "plots", params(CompensationPath),
    responses((status = 200, description = "The plot", body = String, content_type = "image/svg+xml"))
)]
async fn plot_compensation(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    Path(at): Path<CompensationPath>,
    picture: Picture,
) -> Result<Response, Problem> {
    let one = compensation(&app, &caller, at).await?;
    let chosen = one.candidates.iter().find(|candidate| candidate.chosen);
    let predicted = chosen.and_then(|candidate| candidate.predicted_error_by_ratio.as_ref());
    Ok(picture.of(console::by_ratio(&one.summary, predicted, &one.errors_by_ratio)))
}

/// An array drawn to scale: each whisker's present and whole length, health and pressure, and its compensator.
#[utoipa::path(
    get, path = "/v1/fleets/{fleet}/robots/{robot}/arrays/{array}/plot.svg", tag = "plots", params(ArrayPath),
    responses((status = 200, description = "The plot", body = String, content_type = "image/svg+xml"))
)]
async fn plot_array(State(app): State<App>, Path(at): Path<ArrayPath>, picture: Picture) -> Result<Response, Problem> {
    let known = array_summary(&app, &at).await?;
    let name = format!("{}/{}", known.robot, known.array);
    Ok(picture.of(array::draw(&name, &whiskers_of(&app, &at).await?)))
}
