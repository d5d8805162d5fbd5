//! Fleets in requests: names and patterns.

use std::ops::Deref;

use serde::{Deserialize, Serialize};
use utoipa::openapi::{RefOr, Schema};
use utoipa::{PartialSchema, ToSchema};
use vibrissa_edge::fleets::{FleetSelection, selection_pattern};

use super::labels::text;

/// Fleets that a row, an event or a subject may be of.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct FleetFilter(pub FleetSelection);

impl Deref for FleetFilter {
    type Target = FleetSelection;

    fn deref(&self) -> &FleetSelection {
        &self.0
    }
}

impl PartialSchema for FleetFilter {
    fn schema() -> RefOr<Schema> {
        let description = "Names of fleets, or patterns in which `*` stands for any characters of names; up to 100, \
                           separated by commas. A fleet must match one of them.";
        text(selection_pattern(), description, "hall-*,lab")
    }
}

impl ToSchema for FleetFilter {}
