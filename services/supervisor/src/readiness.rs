//! What keeps the service from its work, and which fleets it works for: what `/readyz` tells.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use serde::Serialize;
use vibrissa_protocol::Name;

use crate::mqtt::LinkState;

/// Shared by everything that can be in trouble.
#[derive(Debug, Clone, Default)]
pub struct Readiness(Arc<Mutex<Parts>>);

#[derive(Debug, Default)]
struct Parts {
    problems: BTreeMap<String, String>,
    fleets: BTreeMap<Name, Standing>,
    links: BTreeMap<Name, LinkState>,
}

/// How this supervisor and a fleet stand.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(tag = "standing", rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Standing {
    /// Supervised here.
    Owned {
        /// Since when, in changes of owner.
        epoch: u64,
    },
    /// Supervised elsewhere, or about to be.
    Standby {
        /// Who supervises it, as it is called; null if nobody does.
        holder: Option<String>,
    },
}

impl Readiness {
    /// Says what is wrong with a part, or that nothing is.
    pub fn set(&self, part: impl Into<String>, problem: Option<String>) {
        let part = part.into();
        let mut parts = self.parts();
        match problem {
            Some(problem) => drop(parts.problems.insert(part, problem)),
            None => drop(parts.problems.remove(&part)),
        }
    }

    /// Says how things stand with a fleet.
    pub fn stands(&self, fleet: &Name, standing: Standing) {
        self.parts().fleets.insert(fleet.clone(), standing);
    }

    /// Says through what a fleet is listened to, or that it is not listened to here.
    pub(crate) fn listens(&self, fleet: &Name, link: Option<LinkState>) {
        let mut parts = self.parts();
        match link {
            Some(link) => drop(parts.links.insert(fleet.clone(), link)),
            None => drop(parts.links.remove(fleet)),
        }
    }

    /// Everything that is wrong, each thing once.
    #[must_use]
    pub fn problems(&self) -> BTreeSet<String> {
        let parts = self.parts();
        parts.problems.values().cloned().chain(parts.links.values().filter_map(LinkState::problem)).collect()
    }

    /// How things stand with each fleet.
    #[must_use]
    pub fn fleets(&self) -> BTreeMap<Name, Standing> {
        self.parts().fleets.clone()
    }

    fn parts(&self) -> MutexGuard<'_, Parts> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
