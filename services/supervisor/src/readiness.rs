//! Problems that keep the service from its work, and its standing in each fleet, or shard of a
//! fleet: the content of `/readyz`.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use serde::Serialize;
use vibrissa_edge::shard::FleetShard;

use crate::mqtt::{LinkState, NodesInUse};

/// Shared by all parts that can have a problem.
#[derive(Debug, Clone, Default)]
pub struct Readiness(Arc<Mutex<Parts>>);

#[derive(Debug, Default)]
struct Parts {
    problems: BTreeMap<String, String>,
    shards: BTreeMap<FleetShard, Standing>,
    links: BTreeMap<FleetShard, LinkState>,
}

/// This supervisor's role in a fleet, or in a shard of it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(tag = "standing", rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Standing {
    /// This supervisor owns it.
    Owned {
        /// Epoch of the lease.
        epoch: u64,
    },
    /// Another supervisor owns it, or nobody does yet.
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

    /// Sets this supervisor's role in a shard.
    pub fn stands(&self, shard: &FleetShard, standing: Standing) {
        self.parts().shards.insert(shard.clone(), standing);
    }

    /// Forgets its role in shards that no longer exist.
    pub(crate) fn retain(&self, exists: impl Fn(&FleetShard) -> bool) {
        self.parts().shards.retain(|shard, _| exists(shard));
    }

    /// Sets the problem of a part of a shard's supervision; `None` clears it.
    pub fn set_of(&self, shard: &FleetShard, part: &str, problem: Option<String>) {
        self.set(format!("{}{part}", prefix(shard)), problem.map(|problem| format!("fleet {shard}: {problem}")));
    }

    /// Registers the link of a shard, whose problems are then included.
    pub(crate) fn listens(&self, shard: &FleetShard, link: LinkState) {
        self.parts().links.insert(shard.clone(), link);
    }

    /// Removes the problems and the link of a shard that is no longer supervised here.
    pub(crate) fn forget(&self, shard: &FleetShard) {
        let mut parts = self.parts();
        parts.links.remove(shard);
        parts.problems.retain(|part, _| !part.starts_with(&prefix(shard)));
    }

    /// All problems, without duplicates.
    #[must_use]
    pub fn problems(&self) -> BTreeSet<String> {
        let parts = self.parts();
        parts.problems.values().cloned().chain(parts.links.values().flat_map(LinkState::problems)).collect()
    }

    /// Nodes of the broker that the connections of each shard use.
    #[must_use]
    pub fn nodes(&self) -> BTreeMap<FleetShard, NodesInUse> {
        self.parts().links.iter().map(|(shard, link)| (shard.clone(), link.nodes())).collect()
    }

    /// This supervisor's role in each shard.
    #[must_use]
    pub fn shards(&self) -> BTreeMap<FleetShard, Standing> {
        self.parts().shards.clone()
    }

    fn parts(&self) -> MutexGuard<'_, Parts> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Prefix of the names of a shard's parts; no name has a colon.
fn prefix(shard: &FleetShard) -> String {
    format!("fleet {shard}: ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use vibrissa_protocol::Name;

    #[test]
    fn regress_what_was_wrong_with_a_fleet_goes_with_it() {
        let readiness = Readiness::default();
        let [a, ab] = ["a", "ab"].map(|fleet| FleetShard::whole(Name::new(fleet).unwrap()));
        readiness.set_of(&a, "database", Some("nothing is recorded".to_owned()));
        readiness.set_of(&ab, "database", Some("nothing is recorded".to_owned()));
        readiness.listens(&a, LinkState::default());
        assert_eq!(readiness.problems().len(), 3);
        readiness.forget(&a);
        assert_eq!(readiness.problems(), BTreeSet::from(["fleet ab: nothing is recorded".to_owned()]));
    }
}
