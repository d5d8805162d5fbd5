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

    /// Says what is wrong with a part of a fleet's supervision, or that nothing is.
    pub fn set_of(&self, fleet: &Name, part: &str, problem: Option<String>) {
        self.set(format!("{}{part}", prefix(fleet)), problem.map(|problem| format!("fleet {fleet}: {problem}")));
    }

    /// Says through what a fleet is listened to.
    pub(crate) fn listens(&self, fleet: &Name, link: LinkState) {
        self.parts().links.insert(fleet.clone(), link);
    }

    /// A fleet is not supervised here any more: what is wrong with it is another's concern.
    pub(crate) fn forget(&self, fleet: &Name) {
        let mut parts = self.parts();
        parts.links.remove(fleet);
        parts.problems.retain(|part, _| !part.starts_with(&prefix(fleet)));
    }

    /// Everything that is wrong, each thing once.
    #[must_use]
    pub fn problems(&self) -> BTreeSet<String> {
        let parts = self.parts();
        parts.problems.values().cloned().chain(parts.links.values().flat_map(LinkState::problems)).collect()
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

/// What the names of a fleet's parts begin with; no fleet's name has a slash.
fn prefix(fleet: &Name) -> String {
    format!("fleet/{fleet}/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regress_what_was_wrong_with_a_fleet_goes_with_it() {
        let readiness = Readiness::default();
        let [a, ab] = ["a", "ab"].map(|fleet| Name::new(fleet).unwrap());
        readiness.set_of(&a, "database", Some("nothing is recorded".to_owned()));
        readiness.set_of(&ab, "database", Some("nothing is recorded".to_owned()));
        readiness.listens(&a, LinkState::default());
        assert_eq!(readiness.problems().len(), 3);
        readiness.forget(&a);
        assert_eq!(readiness.problems(), BTreeSet::from(["fleet ab: nothing is recorded".to_owned()]));
    }
}
