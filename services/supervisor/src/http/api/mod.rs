//! What is served under `/v1`: a module for each kind of thing.

pub mod actions;
pub mod alarm_actions;
pub mod audit;
pub mod calibrations;
pub mod events;
pub mod paths;
pub mod policy;
pub mod whiskers;

use utoipa_axum::router::OpenApiRouter;

use super::App;

/// All routes, with what they say of themselves.
pub fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new()
        .merge(whiskers::routes())
        .merge(actions::routes())
        .merge(policy::routes())
        .merge(alarm_actions::routes())
        .merge(audit::routes())
        .merge(calibrations::routes())
        .merge(events::routes())
}
