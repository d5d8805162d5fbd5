//! The audit log: every action that was requested.

use axum::extract::{Extension, State};
use axum::response::{Json, Response};
use serde::Deserialize;
use utoipa::IntoParams;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vibrissa_protocol::Name;

use crate::http::App;
use crate::http::access::Caller;
use crate::http::extract::{Path, Query};
use crate::http::fleets::FleetFilter;
use crate::http::listing::Listing;
use crate::http::moment::{Moment, between};
use crate::http::page::{Page, list_query};
use crate::http::problem::Problem;
use crate::http::search::Search;
use crate::http::words::{AuditKindWord, words};
use vibrissa_store::list::{Filter, Value};
use vibrissa_store::lists::actions::{ACTIONS, ActionRow, ActionSort};

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(list_audit)).routes(routes!(get_action))
}

words! {
    /// State of an action.
    pub enum ActionState {
        /// Not executed yet.
        Pending = "PENDING",
        /// Executed by the fleet's supervisor.
        Done = "DONE",
        /// Refused by the fleet's supervisor.
        Refused = "REFUSED",
        /// Expired: it was not executed in time, and will not be.
        Expired = "EXPIRED",
    }
}

list_query! {
    /// Filters for the audit log.
    pub struct AuditQuery by ActionSort {
        /// Fleets of the action: names or patterns such as `hall-*`, separated by commas.
        pub fleet: Option<FleetFilter>,
        /// Robot of the action.
        #[param(value_type = Option<String>, pattern = "^[A-Za-z0-9_-]{1,64}$")]
        pub robot: Option<Name>,
        /// State of the action.
        #[param(inline)]
        pub state: Option<ActionState>,
        /// Kind of action.
        #[param(inline)]
        pub kind: Option<AuditKindWord>,
        /// Person or token that requested the action.
        #[param(max_length = 200)]
        pub actor: Option<String>,
        /// Earliest time of the request, inclusive.
        #[param(value_type = Option<String>, format = DateTime)]
        pub from: Option<Moment>,
        /// Latest time of the request, exclusive.
        #[param(value_type = Option<String>, format = DateTime)]
        pub to: Option<Moment>,
        /// Number of the request for many of which the actions are parts.
        #[param(minimum = 0)]
        pub parent_id: Option<i64>,
        /// Text to look for in the names of fleet, robot and array, in actor, reason and parameters, in upper or lower case.
        #[param(value_type = Option<String>, min_length = 1, max_length = 100, pattern = "^[^\\x00]+$")]
        pub q: Option<Search>,
    }
}

/// All requested actions with actor, reason and outcome.
#[utoipa::path(
    get, path = "/v1/audit", tag = "audit", params(AuditQuery),
    responses((status = 200, description = "A page of the log", body = Page<ActionRow>))
)]
async fn list_audit(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    listing: Listing,
    Query(query): Query<AuditQuery>,
) -> Result<Response, Problem> {
    let mut selection = query.page()?;
    selection.filters.extend(caller.scope.filter("fleet"));
    selection.of_fleets(query.fleet.as_deref());
    selection.is("robot", query.robot);
    selection.is("state", query.state);
    selection.is("kind", query.kind);
    selection.is("actor", query.actor);
    selection.is_number("parent_id", query.parent_id);
    selection.filters.extend(between("asked_at", query.from, query.to));
    selection.contains(&["fleet", "robot", "\"array\"", "actor", "reason", "parameters"], query.q);
    listing.answer::<ActionRow>(&app, &ACTIONS, selection).await
}

/// Path parameters of an action.
#[derive(Debug, Clone, Deserialize, IntoParams)]
#[into_params(parameter_in = Path)]
pub struct ActionPath {
    /// Number of the action.
    #[param(minimum = 0)]
    pub action_id: i64,
}

/// One action with its state.
#[utoipa::path(
    get, path = "/v1/actions/{action_id}", tag = "audit", params(ActionPath),
    responses((status = 200, description = "The action", body = ActionRow))
)]
async fn get_action(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    Path(at): Path<ActionPath>,
) -> Result<Json<ActionRow>, Problem> {
    let mut filters = vec![Filter::Is("action_id", Value::Whole(at.action_id))];
    filters.extend(caller.scope.filter("fleet"));
    let found = app.store.first(&ACTIONS, filters).await?;
    found.map(Json).ok_or_else(|| Problem::not_found(format_args!("action {}", at.action_id)))
}
