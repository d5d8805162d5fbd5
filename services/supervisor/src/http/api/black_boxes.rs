//! Black boxes: the messages of robots around trims, faults and alarms.

use std::io::Read;

use axum::extract::{Extension, State};
use axum::http::{HeaderName, HeaderValue, header};
use axum::response::{Json, Response};
use flate2::read::MultiGzDecoder;
use serde::Deserialize;
use utoipa::IntoParams;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vibrissa_edge::black_box::About;
use vibrissa_host::task;
use vibrissa_protocol::Name;

use crate::http::App;
use crate::http::access::Caller;
use crate::http::extract::{Path, Query};
use crate::http::fleets::FleetFilter;
use crate::http::listing::Listing;
use crate::http::moment::{Moment, between};
use crate::http::page::{Page, list_query};
use crate::http::problem::{Kind, Problem};
use vibrissa_store::black_boxes::BlackBoxBody;
use vibrissa_store::list::{Filter, Value};
use vibrissa_store::lists::black_boxes::{BLACK_BOXES, BlackBox, BlackBoxSort};

/// Most bytes of a recording that are sent: far more than the memory of a robot's messages.
const BYTES_MAX: u64 = 64 * 1024 * 1024;

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new()
        .routes(routes!(list_black_boxes))
        .routes(routes!(get_black_box))
        .routes(routes!(get_black_box_recording))
}

list_query! {
    /// Filters for the list of black boxes.
    pub struct BlackBoxesQuery by BlackBoxSort {
        /// Fleets: names or patterns such as `hall-*`, separated by commas.
        pub fleet: Option<FleetFilter>,
        /// Name of the robot.
        #[param(value_type = Option<String>, pattern = "^[A-Za-z0-9_-]{1,64}$")]
        pub robot: Option<Name>,
        /// Earliest time of the first event, inclusive.
        #[param(value_type = Option<String>, format = DateTime)]
        pub from: Option<Moment>,
        /// Latest time of the first event, exclusive.
        #[param(value_type = Option<String>, format = DateTime)]
        pub to: Option<Moment>,
    }
}

/// All black boxes. Each has the messages from and to a robot around a trim, a fault or an alarm about a whisker.
#[utoipa::path(
    get, path = "/v1/black-boxes", tag = "happenings", params(BlackBoxesQuery),
    responses((status = 200, description = "A page of black boxes", body = Page<BlackBox>))
)]
async fn list_black_boxes(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    listing: Listing,
    Query(query): Query<BlackBoxesQuery>,
) -> Result<Response, Problem> {
    let mut selection = query.page()?;
    selection.filters.extend(caller.scope.filter("fleet"));
    selection.of_fleets(query.fleet.as_deref());
    selection.is("robot", query.robot);
    selection.filters.extend(between("event_at", query.from, query.to));
    listing.answer::<BlackBox>(&app, &BLACK_BOXES, selection).await
}

/// Path parameters of a black box.
#[derive(Debug, Clone, Copy, Deserialize, IntoParams)]
#[into_params(parameter_in = Path)]
pub struct BlackBoxPath {
    /// Number of the box.
    #[param(minimum = 0)]
    pub black_box_id: i64,
}

/// One black box, without its messages.
#[utoipa::path(
    get, path = "/v1/black-boxes/{black_box_id}", tag = "happenings", params(BlackBoxPath),
    responses((status = 200, description = "The black box", body = BlackBox))
)]
async fn get_black_box(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    Path(at): Path<BlackBoxPath>,
) -> Result<Json<BlackBox>, Problem> {
    let mut filters = vec![Filter::Is("black_box_id", Value::Whole(at.black_box_id))];
    filters.extend(caller.scope.filter("fleet"));
    let found = app.store.first(&BLACK_BOXES, filters).await?;
    found.map(Json).ok_or_else(|| not_found(at.black_box_id))
}

/// The messages of a black box as a file for `vibrissa-lab replay`: one JSON object per line, in the format of `vibrissa record`.
#[utoipa::path(
    get, path = "/v1/black-boxes/{black_box_id}/recording", tag = "happenings", params(BlackBoxPath),
    responses((status = 200, description = "The recording", body = String, content_type = "application/x-ndjson"))
)]
async fn get_black_box_recording(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    Path(at): Path<BlackBoxPath>,
) -> Result<([(HeaderName, HeaderValue); 2], Vec<u8>), Problem> {
    let id = at.black_box_id;
    let found = app.store.black_box(id).await?;
    let found = found.filter(|one| caller.scope.covers(&one.fleet));
    let found = found.ok_or_else(|| not_found(id))?;
    let name = format!("attachment; filename=\"black-box-{id}-{}-{}.jsonl\"", found.fleet, found.robot);
    let lines = task::blocking(move || lines_of(id, &found)).await;
    let lines = lines.map_err(|problem| Problem::new(Kind::Internal, problem.to_string()))?;
    let lines = lines.map_err(|problem| Problem::new(Kind::Internal, format!("cannot unpack it: {problem}")))?;
    let headers = [
        (header::CONTENT_TYPE, HeaderValue::from_static("application/x-ndjson")),
        (header::CONTENT_DISPOSITION, HeaderValue::from_str(&name).unwrap_or(HeaderValue::from_static("attachment"))),
    ];
    Ok((headers, lines))
}

fn lines_of(black_box_id: i64, found: &BlackBoxBody) -> std::io::Result<Vec<u8>> {
    let about = About {
        format: About::FORMAT,
        black_box_id,
        cause: found.cause.clone(),
        event_us: found.event_us,
        began_us: found.began_us,
        ends_us: found.ends_us,
        state: found.state.clone(),
        left_out: found.left_out,
    };
    let mut lines = Vec::new();
    about.line(&found.fleet, &found.robot).write(&mut lines);
    MultiGzDecoder::new(&found.body[..]).take(BYTES_MAX).read_to_end(&mut lines)?;
    Ok(lines)
}

fn not_found(black_box_id: i64) -> Problem {
    Problem::not_found(format_args!("black box {black_box_id}"))
}
