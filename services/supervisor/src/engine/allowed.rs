//! Allow list of a fleet's robots, and the robots that it refused.

use std::collections::{BTreeMap, HashSet};
use std::sync::Arc;

use tokio::sync::watch;
use tracing::{info, warn};
use vibrissa_core::units::Micros;
use vibrissa_protocol::Name;

use super::Engine;
use super::commit::committer::LeaseLost;
use crate::robots_file::RobotsFile;
use vibrissa_edge::clock::wall_clock;
use vibrissa_store::allowed::{AllowedReading, TurnedAwayReading, names_of};

/// Limit of the refused robots remembered per shard; beyond it, the one whose last attempt is oldest is forgotten.
const TURNED_AWAY_MAX: usize = 64;

/// A fleet's allow list: every robot is allowed if neither list exists, otherwise each robot that is in at least one of
/// them.
#[derive(Debug, Clone, Default)]
pub(super) struct Allowed {
    /// Robots in the file of `limits.robots_file`.
    file: Option<Arc<HashSet<Name>>>,
    /// Robots in the list that was set over HTTP.
    set: Option<Arc<HashSet<Name>>>,
}

impl Allowed {
    pub(super) fn permits(&self, robot: &Name) -> bool {
        let has = |list: &Option<Arc<HashSet<Name>>>| list.as_ref().is_some_and(|list| list.contains(robot));
        (self.file.is_none() && self.set.is_none()) || has(&self.file) || has(&self.set)
    }
}

/// Robots that were refused because they are in no list.
#[derive(Debug, Default)]
pub(super) struct TurnedAway {
    robots: BTreeMap<Name, TurnedAwayReading>,
    has_changed: bool,
}

impl TurnedAway {
    pub(super) fn count(&mut self, robot: &Name, now: Micros) {
        let now_us = now.0 as i64;
        self.has_changed = true;
        if let Some(known) = self.robots.get_mut(robot) {
            known.tries += 1;
            known.last_us = now_us;
            return;
        }
        if self.robots.len() >= TURNED_AWAY_MAX {
            let oldest = self.robots.iter().min_by_key(|(_, known)| known.last_us).map(|(name, _)| name.clone());
            oldest.and_then(|name| self.robots.remove(&name));
        }
        warn!(%robot, "robot refused, not on the fleet's allow list");
        let first = TurnedAwayReading { robot: robot.to_string(), tries: 1, first_us: now_us, last_us: now_us };
        self.robots.insert(robot.clone(), first);
    }
}

/// Sources of the engine's allow list.
#[derive(Debug, Default)]
pub(super) struct AllowedSource {
    file: Option<watch::Receiver<Arc<RobotsFile>>>,
    /// Version of the list that was set over HTTP; 0 before the first.
    version: i64,
    allowed: Allowed,
    /// The lists have changed, so that refused robots may be allowed now.
    pub(super) has_changed: bool,
}

impl Engine {
    /// Adds a file of allowed robots, which may change later.
    #[must_use]
    pub(crate) fn allowing(mut self, file: Option<watch::Receiver<Arc<RobotsFile>>>) -> Self {
        self.allowed.file = file;
        self.read_allowed_file();
        self
    }

    fn read_allowed_file(&mut self) {
        let Some(file) = &mut self.allowed.file else { return };
        self.allowed.allowed.file = Some(file.borrow_and_update().of_fleet(&self.fleet));
        self.apply_allowed();
    }

    fn apply_allowed(&mut self) {
        let count = |list: &Option<Arc<HashSet<Name>>>| list.as_ref().map(|list| list.len());
        let Allowed { file, set } = &self.allowed.allowed;
        info!(fleet = %self.fleet, in_file = ?count(file), set = ?count(set), "allow list loaded");
        for shard in &mut self.shards {
            shard.gathering.allowed = self.allowed.allowed.clone();
            // Robots that are allowed now are no longer listed as refused.
            let TurnedAway { robots, has_changed } = &mut shard.gathering.turned_away;
            let before = robots.len();
            robots.retain(|name, _| !self.allowed.allowed.permits(name));
            *has_changed |= robots.len() != before;
        }
    }

    /// Applies a list that was set over HTTP.
    pub(super) fn set_allowed(&mut self, reading: &AllowedReading) {
        self.allowed.version = reading.version;
        self.allowed.allowed.set = reading.robots.as_deref().map(|names| Arc::new(names_of(names).collect()));
        self.apply_allowed();
    }

    /// Reads the lists if they have changed, and writes the refused robots. If the database is unreachable, this does
    /// not wait.
    pub(super) async fn look_at_allowed(&mut self) -> Result<(), LeaseLost> {
        if self.allowed.file.as_ref().is_some_and(|file| file.has_changed().unwrap_or_default()) {
            self.read_allowed_file();
            self.allowed.has_changed = true;
        }
        self.settle().await?;
        let Some(committer) = &mut self.committer else { return Ok(()) };
        match committer.writer.allowed_robots(&self.lease, self.allowed.version).await {
            Ok(None) => {}
            Ok(Some(reading)) => {
                self.set_allowed(&reading);
                self.allowed.has_changed = true;
            }
            Err(problem) => {
                self.program.database_failed();
                warn!(%problem, fleet = %self.fleet, "cannot read the allow list, retrying");
                return Ok(());
            }
        }
        self.write_turned_away().await;
        Ok(())
    }

    async fn write_turned_away(&mut self) {
        let lists = || self.shards.iter().map(|shard| &shard.gathering.turned_away);
        if !lists().any(|list| list.has_changed) {
            return;
        }
        let rows: Vec<TurnedAwayReading> = lists().flat_map(|list| list.robots.values().cloned()).collect();
        let Some(committer) = &mut self.committer else { return };
        match committer.writer.write_turned_away(&self.lease, &rows).await {
            Ok(()) => {
                for shard in &mut self.shards {
                    shard.gathering.turned_away.has_changed = false;
                }
            }
            Err(problem) => {
                warn!(%problem, fleet = %self.fleet, at = wall_clock().0, "cannot write the refused robots")
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn name(text: &str) -> Name {
        Name::robot(text).unwrap()
    }

    #[test]
    fn everybody_is_allowed_without_a_list_and_with_lists_whoever_is_in_one() {
        let list = |names: &[&str]| Some(Arc::new(names.iter().map(|text| name(text)).collect()));
        let allowed = |file, set| {
            let allowed = Allowed { file, set };
            ["a", "b", "c"].map(|text| allowed.permits(&name(text)))
        };
        assert_eq!(allowed(None, None), [true; 3]);
        assert_eq!(allowed(list(&["a"]), None), [true, false, false]);
        assert_eq!(allowed(None, list(&["b"])), [false, true, false]);
        assert_eq!(allowed(list(&["a"]), list(&["b"])), [true, true, false]);
        assert_eq!(allowed(None, list(&[])), [false; 3], "an empty list allows nobody");
    }

    #[test]
    fn those_who_are_turned_away_are_bounded_and_the_newest_are_remembered() {
        let mut turned_away = TurnedAway::default();
        for number in 0..10_000 {
            turned_away.count(&name(&format!("r{number}")), Micros(number));
            turned_away.count(&name("again"), Micros(number));
        }
        assert_eq!(turned_away.robots.len(), TURNED_AWAY_MAX);
        assert_eq!(turned_away.robots["again"].tries, 10_000);
        assert!(turned_away.robots.contains_key("r9999") && !turned_away.robots.contains_key("r0"));
    }
}
