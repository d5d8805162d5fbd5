//! What is served under `/v1`: a module for each kind of thing.

pub mod compensations;
pub mod contacts;
pub mod errors;
pub mod fleets;
pub mod happenings;
pub mod model;
pub mod paths;
pub mod plots;
pub mod robots;
pub mod setpoints;
pub mod what_if;
pub mod whiskers;

use utoipa_axum::router::OpenApiRouter;

use super::App;

/// All routes, with what they say of themselves.
pub fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new()
        .merge(fleets::routes())
        .merge(robots::routes())
        .merge(whiskers::routes())
        .merge(contacts::routes())
        .merge(model::routes())
        .merge(what_if::routes())
        .merge(happenings::routes())
        .merge(compensations::routes())
        .merge(setpoints::routes())
        .merge(errors::routes())
        .merge(plots::routes())
}
