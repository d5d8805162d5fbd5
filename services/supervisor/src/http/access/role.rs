//! Roles of callers.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Role of a caller; each role includes the rights of those before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Role {
    /// Reads all data of its fleets.
    Viewer,
    /// Acts on whiskers and alarms: approves, holds, sets pressures.
    Operator,
    /// Changes policies, calibrations and allow lists.
    Engineer,
    /// Has every right.
    Admin,
}

impl Role {
    /// All roles, in ascending order of rights.
    pub const ALL: [Self; 4] = [Self::Viewer, Self::Operator, Self::Engineer, Self::Admin];

    /// Name of the role in the database and in JSON.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Viewer => "VIEWER",
            Self::Operator => "OPERATOR",
            Self::Engineer => "ENGINEER",
            Self::Admin => "ADMIN",
        }
    }

    /// The role with this name; `None` if the name is unknown.
    #[must_use]
    pub fn of_word(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|role| role.word() == word)
    }
}
