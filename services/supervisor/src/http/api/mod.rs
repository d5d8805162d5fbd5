//! The API under `/v1`: one module for each kind of resource.

pub mod actions;
pub mod alarm_actions;
pub mod alarm_statistics;
pub mod alarms;
pub mod alarms_at_once;
pub mod allowed;
pub mod audit;
pub mod black_boxes;
pub mod board;
pub mod bulk;
pub mod bulk_actions;
pub mod bulk_fleets;
pub mod calibrations;
pub mod compensations;
pub mod contact_place;
pub mod contact_uses;
pub mod contacts;
pub mod dead_letters;
pub mod each;
pub mod errors;
pub mod events;
pub mod filters;
pub mod fleets;
pub mod happenings;
pub mod history;
pub mod labels;
pub mod maintenance;
pub mod me;
pub mod model;
pub mod notes;
pub mod overview;
pub mod paths;
pub mod policy;
pub mod quarantine;
pub mod refusals;
pub mod robots;
pub mod rollouts;
pub mod setpoints;
pub mod timeline;
pub mod touch_tests;
pub mod webhooks;
pub mod what_if;
pub mod whiskers;

use utoipa_axum::router::OpenApiRouter;

use super::App;

/// All routes with their descriptions.
pub fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new()
        .merge(whiskers::routes())
        .merge(actions::routes())
        .merge(policy::routes())
        .merge(alarms::routes())
        .merge(alarm_actions::routes())
        .merge(alarm_statistics::routes())
        .merge(alarms_at_once::routes())
        .merge(allowed::routes())
        .merge(audit::routes())
        .merge(black_boxes::routes())
        .merge(board::routes())
        .merge(bulk::routes())
        .merge(bulk_actions::routes())
        .merge(bulk_fleets::routes())
        .merge(calibrations::routes())
        .merge(events::routes())
        .merge(fleets::routes())
        .merge(overview::routes())
        .merge(robots::routes())
        .merge(refusals::routes())
        .merge(rollouts::routes())
        .merge(labels::routes())
        .merge(notes::routes())
        .merge(quarantine::routes())
        .merge(contacts::routes())
        .merge(contact_place::routes())
        .merge(contact_uses::routes())
        .merge(each::routes())
        .merge(history::routes())
        .merge(maintenance::routes())
        .merge(me::routes())
        .merge(model::routes())
        .merge(what_if::routes())
        .merge(happenings::routes())
        .merge(compensations::routes())
        .merge(setpoints::routes())
        .merge(timeline::routes())
        .merge(touch_tests::routes())
        .merge(errors::routes())
        .merge(webhooks::routes())
        .merge(dead_letters::routes())
}
