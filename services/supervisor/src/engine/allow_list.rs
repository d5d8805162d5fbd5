//! Allow list of a fleet's robots, and the robots that it refused.

use std::collections::{BTreeMap, HashSet};
use std::sync::Arc;

use vibrissa_core::units::Micros;
use vibrissa_protocol::Name;

use vibrissa_store::allowed::TurnedAwayReading;

/// Limit of the refused robots remembered per worker; beyond it, the one whose last attempt is oldest is forgotten.
const REFUSED_MAX: usize = 64;

/// A fleet's allow list: every robot is allowed if neither list exists, otherwise each robot that is in at least one of
/// them.
#[derive(Debug, Clone, Default)]
pub(crate) struct AllowList {
    /// Robots in the file of `limits.robots_file`.
    file: Option<Arc<HashSet<Name>>>,
    /// Robots in the list that people have set.
    set: Option<Arc<HashSet<Name>>>,
}

impl AllowList {
    /// Sets the robots of the file.
    pub(crate) fn set_file(&mut self, robots: Arc<HashSet<Name>>) {
        self.file = Some(robots);
    }

    /// Sets the robots of the list that people have set.
    pub(crate) fn set_listed(&mut self, robots: Option<HashSet<Name>>) {
        self.set = robots.map(Arc::new);
    }

    /// Numbers of robots in the file, and in the list that people have set.
    pub(crate) fn counts(&self) -> [Option<usize>; 2] {
        [&self.file, &self.set].map(|list| list.as_ref().map(|list| list.len()))
    }

    pub(crate) fn permits(&self, robot: &Name) -> bool {
        let has = |list: &Option<Arc<HashSet<Name>>>| list.as_ref().is_some_and(|list| list.contains(robot));
        (self.file.is_none() && self.set.is_none()) || has(&self.file) || has(&self.set)
    }
}

/// Robots that were refused because they are in no list.
#[derive(Debug, Default)]
pub(crate) struct RefusedRobots {
    robots: BTreeMap<Name, TurnedAwayReading>,
    has_changed: bool,
}

impl RefusedRobots {
    /// Whether robots have been added or removed since they were written.
    pub(crate) fn has_changed(&self) -> bool {
        self.has_changed
    }

    pub(crate) fn written(&mut self) {
        self.has_changed = false;
    }

    pub(crate) fn rows(&self) -> impl Iterator<Item = TurnedAwayReading> {
        self.robots.values().cloned()
    }

    /// Removes robots that do not fit a condition.
    pub(crate) fn retain(&mut self, fits: impl Fn(&Name) -> bool) {
        let before = self.robots.len();
        self.robots.retain(|name, _| fits(name));
        self.has_changed |= self.robots.len() != before;
    }

    /// Counts an attempt; returns whether it is the first one that is remembered.
    pub(crate) fn count(&mut self, robot: &Name, now: Micros) -> bool {
        let now_us = now.0 as i64;
        self.has_changed = true;
        if let Some(known) = self.robots.get_mut(robot) {
            known.tries += 1;
            known.last_us = now_us;
            return false;
        }
        if self.robots.len() >= REFUSED_MAX {
            let oldest = self.robots.iter().min_by_key(|(_, known)| known.last_us).map(|(name, _)| name.clone());
            oldest.and_then(|name| self.robots.remove(&name));
        }
        let first = TurnedAwayReading { robot: robot.to_string(), tries: 1, first_us: now_us, last_us: now_us };
        self.robots.insert(robot.clone(), first);
        true
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
            let allowed = AllowList { file, set };
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
        let mut refused = RefusedRobots::default();
        for number in 0..10_000 {
            refused.count(&name(&format!("r{number}")), Micros(number));
            refused.count(&name("again"), Micros(number));
        }
        assert_eq!(refused.robots.len(), REFUSED_MAX);
        assert_eq!(refused.robots["again"].tries, 10_000);
        assert!(refused.robots.contains_key("r9999") && !refused.robots.contains_key("r0"));
    }
}
