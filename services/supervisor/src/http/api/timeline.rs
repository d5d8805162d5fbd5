//! The timeline: what happened between two times, in one list.

use axum::extract::{Extension, State};
use axum::response::Response;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vibrissa_edge::clock::wall_clock;
use vibrissa_protocol::Name;

use crate::http::App;
use crate::http::access::Caller;
use crate::http::extract::Query;
use crate::http::fleets::FleetFilter;
use crate::http::listing::Listing;
use crate::http::moment::{Moment, between};
use crate::http::page::{Page, list_query};
use crate::http::problem::Problem;
use crate::http::words::{AuditKindWord, EventKindWord};
use vibrissa_store::lists::timeline::{TIMELINE, TimelineRow, TimelineSort};
use vibrissa_store::time::Time;

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(list_timeline))
}

/// Length of the default span, µs: a day.
const SPAN_US: i64 = 86_400_000_000;

list_query! {
    /// Filters for the timeline.
    pub struct TimelineQuery by TimelineSort {
        /// Fleets: names or patterns such as `hall-*`, separated by commas.
        pub fleet: Option<FleetFilter>,
        /// Name of the robot.
        #[param(value_type = Option<String>, pattern = "^[A-Za-z0-9_-]{1,64}$")]
        pub robot: Option<Name>,
        /// Name of the array.
        #[param(value_type = Option<String>, pattern = "^[A-Za-z0-9_-]{1,64}$")]
        pub array: Option<Name>,
        /// Number of the whisker in its array.
        #[param(maximum = 65535)]
        pub whisker: Option<u16>,
        /// Kind of the events; `ACTION` for the actions of people.
        #[param(inline)]
        pub kind: Option<EventKindWord>,
        /// Kind of the actions.
        #[param(inline)]
        pub action: Option<AuditKindWord>,
        /// Person or token: only actions that it requested.
        #[param(max_length = 200)]
        pub actor: Option<String>,
        /// Earliest time, inclusive; a day before `to` by default.
        #[param(value_type = Option<String>, format = DateTime)]
        pub from: Option<Moment>,
        /// Latest time, exclusive; now by default.
        #[param(value_type = Option<String>, format = DateTime)]
        pub to: Option<Moment>,
    }
}

/// Events between two times, the newest first, with the full names of their subjects, and the actions of people in this
/// time.
///
/// The log keeps trims, alarms, changes of condition, begins and ends of compensations and failed setpoints for a week,
/// and other events for a day. The audit log keeps the actions.
#[utoipa::path(
    get, path = "/v1/timeline", tag = "happenings", params(TimelineQuery),
    responses((status = 200, description = "A page of the timeline", body = Page<TimelineRow>))
)]
async fn list_timeline(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    listing: Listing,
    Query(query): Query<TimelineQuery>,
) -> Result<Response, Problem> {
    let mut selection = query.page()?;
    selection.filters.extend(caller.scope.filter("fleet"));
    selection.of_fleets(query.fleet.as_deref());
    selection.is("robot", query.robot);
    selection.is("\"array\"", query.array);
    selection.is_number("whisker", query.whisker);
    selection.is("kind", query.kind);
    if query.action.is_some() {
        selection.is("kind", Some("ACTION"));
        selection.is("word", query.action);
    }
    selection.is("actor", query.actor);
    let end = query.to.map_or_else(|| wall_clock().0 as i64, |Moment(Time(to))| to);
    let from = query.from.unwrap_or(Moment(Time(end.saturating_sub(SPAN_US))));
    selection.filters.extend(between("at", Some(from), query.to));
    listing.answer::<TimelineRow>(&app, &TIMELINE, selection).await
}
