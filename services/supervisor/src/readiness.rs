//! Problems that keep the service from its work, and its standing in each fleet: the content of `/readyz`.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use serde::Serialize;
use vibrissa_protocol::Name;

use crate::mqtt::{LinkState, NodesInUse};

/// Shared by all parts that can have a problem.
#[derive(Debug, Clone, Default)]
pub struct Readiness(Arc<Mutex<Parts>>);

#[derive(Debug, Default)]
struct Parts {
    problems: BTreeMap<String, String>,
    fleets: BTreeMap<Name, Standing>,
    links: BTreeMap<Name, LinkState>,
}

/// This supervisor's role in a fleet.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(tag = "standing", rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Standing {
    /// This supervisor owns the fleet.
    Owned {
        /// Epoch of the lease.
        epoch: u64,
    },
    /// Another supervisor owns the fleet, or nobody does yet.
    Standby {
        /// Name of the supervisor that owns it; null if there is none.
        holder: Option<String>,
    },
}

impl Readiness {
    /// Sets the problem of a part; `None` clears it.
    pub fn set(&self, part: impl Into<String>, problem: Option<String>) {
        let part = part.into();
        let mut parts = self.parts();
        match problem {
            Some(problem) => drop(parts.problems.insert(part, problem)),
            None => drop(parts.problems.remove(&part)),
        }
    }

    /// Sets this supervisor's role in a fleet.
    pub fn stands(&self, fleet: &Name, standing: Standing) {
        self.parts().fleets.insert(fleet.clone(), standing);
    }

    /// Sets the problem of a part of a fleet's supervision; `None` clears it.
    pub fn set_of(&self, fleet: &Name, part: &str, problem: Option<String>) {
        self.set(format!("{}{part}", prefix(fleet)), problem.map(|problem| format!("fleet {fleet}: {problem}")));
    }

    /// Registers the link of a fleet, whose problems are then included.
    pub(crate) fn listens(&self, fleet: &Name, link: LinkState) {
        self.parts().links.insert(fleet.clone(), link);
    }

    /// Removes the problems and the link of a fleet that is no longer supervised here.
    pub(crate) fn forget(&self, fleet: &Name) {
        let mut parts = self.parts();
        parts.links.remove(fleet);
        parts.problems.retain(|part, _| !part.starts_with(&prefix(fleet)));
    }

    /// All problems, without duplicates.
    #[must_use]
    pub fn problems(&self) -> BTreeSet<String> {
        let parts = self.parts();
        parts.problems.values().cloned().chain(parts.links.values().flat_map(LinkState::problems)).collect()
    }

    /// Nodes of the broker that the connections of each fleet use.
    #[must_use]
    pub fn nodes(&self) -> BTreeMap<Name, NodesInUse> {
        self.parts().links.iter().map(|(fleet, link)| (fleet.clone(), link.nodes())).collect()
    }

    /// This supervisor's role in each fleet.
    #[must_use]
    pub fn fleets(&self) -> BTreeMap<Name, Standing> {
        self.parts().fleets.clone()
    }

    fn parts(&self) -> MutexGuard<'_, Parts> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Prefix of the names of a fleet's parts; a fleet's name has no slash.
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
