//! The messages in the files of an archive from the log, by robot and boot.

use std::collections::BTreeMap;

use anyhow::{Context, ensure};
use serde::{Deserialize, Serialize};

/// Version of the stored form.
const VERSION: u32 = 1;
/// Time after which a boot without messages is forgotten, µs: eight days. Robots and bridges repeat messages within hours.
const REMEMBERED_US: i64 = 8 * 86_400_000_000;
/// Most boots of a robot that are remembered.
const BOOTS_MAX: usize = 16;
/// Most ranges of a boot. A robot that has dropped messages leaves gaps; beyond this number the lowest gap counts as seen.
const RANGES_MAX: usize = 1024;

/// Numbers of messages of a boot.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Boot {
    /// Time of receipt of the newest message, µs since 1970 UTC.
    newest_us: i64,
    /// Inclusive ranges, ascending, not touching.
    ranges: Vec<(u64, u64)>,
}

/// The messages that the files have, as a JSON object in the database.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Seen {
    version: u32,
    /// Boots by robot and boot id.
    robots: BTreeMap<String, BTreeMap<String, Boot>>,
}

impl Default for Seen {
    fn default() -> Self {
        Self { version: VERSION, robots: BTreeMap::new() }
    }
}

impl Seen {
    /// Reads the stored form.
    ///
    /// # Errors
    /// It is of another version, or malformed.
    pub(super) fn from_json(json: &str) -> anyhow::Result<Self> {
        let seen: Self = serde_json::from_str(json).context("log_archives.seen cannot be read")?;
        ensure!(seen.version == VERSION, "log_archives.seen has version {}, not {VERSION}", seen.version);
        Ok(seen)
    }

    pub(super) fn to_json(&self) -> anyhow::Result<String> {
        Ok(serde_json::to_string(self)?)
    }

    /// Whether a message was never seen before. From now on it was.
    pub(super) fn is_new(&mut self, robot: &str, boot_id: &str, seq: u64, received_us: i64) -> bool {
        let boots = match self.robots.get_mut(robot) {
            Some(boots) => boots,
            None => self.robots.entry(robot.to_owned()).or_default(),
        };
        if let Some(boot) = boots.get_mut(boot_id) {
            boot.newest_us = boot.newest_us.max(received_us);
            return boot.add(seq);
        }
        boots.insert(boot_id.to_owned(), Boot { newest_us: received_us, ranges: vec![(seq, seq)] });
        if boots.len() > BOOTS_MAX
            && let Some(oldest) = boots.iter().min_by_key(|(_, boot)| boot.newest_us).map(|(id, _)| id.clone())
        {
            boots.remove(&oldest);
        }
        true
    }

    /// Forgets boots that have not been heard for long.
    pub(super) fn forget_old(&mut self, now_us: i64) {
        self.robots.retain(|_, boots| {
            boots.retain(|_, boot| boot.newest_us >= now_us - REMEMBERED_US);
            !boots.is_empty()
        });
    }
}

impl Boot {
    /// Adds a number; `false` if it was there.
    fn add(&mut self, seq: u64) -> bool {
        // The first range that does not end before the number.
        let at = self.ranges.partition_point(|&(_, last)| last < seq);
        if self.ranges.get(at).is_some_and(|&(first, _)| first <= seq) {
            return false;
        }
        let extends_left = at > 0 && self.ranges[at - 1].1 + 1 == seq;
        let extends_right = self.ranges.get(at).is_some_and(|&(first, _)| seq + 1 == first);
        match (extends_left, extends_right) {
            (true, true) => {
                self.ranges[at - 1].1 = self.ranges[at].1;
                self.ranges.remove(at);
            }
            (true, false) => self.ranges[at - 1].1 = seq,
            (false, true) => self.ranges[at].0 = seq,
            (false, false) => self.ranges.insert(at, (seq, seq)),
        }
        if self.ranges.len() > RANGES_MAX {
            let (first, _) = self.ranges.remove(0);
            self.ranges[0].0 = first;
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn brute_force_numbers_in_any_order_are_new_once() {
        let mut state = 1_u64;
        for _ in 0..200 {
            let (mut seen, mut all) = (Seen::default(), BTreeSet::new());
            for _ in 0..300 {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                let seq = (state >> 33) % 200;
                assert_eq!(seen.is_new("r", "b", seq, 0), all.insert(seq), "{seq} of {all:?}");
            }
            let ranges = &seen.robots["r"]["b"].ranges;
            assert!(ranges.windows(2).all(|two| two[0].1 + 1 < two[1].0), "{ranges:?}");
        }
    }

    #[test]
    fn robots_and_boots_have_numbers_of_their_own_and_old_boots_are_forgotten() {
        let mut seen = Seen::default();
        assert!(seen.is_new("r", "b", 0, 0) && seen.is_new("r", "c", 0, 5) && seen.is_new("s", "b", 0, REMEMBERED_US));
        seen.forget_old(REMEMBERED_US + 3);
        assert!(seen.is_new("r", "b", 0, 0), "forgotten");
        assert!(!seen.is_new("r", "c", 0, 0) && !seen.is_new("s", "b", 0, 0));
        for boot in 0..2 * BOOTS_MAX {
            seen.is_new("r", &format!("d{boot}"), 0, 10 + boot as i64);
        }
        assert_eq!(seen.robots["r"].len(), BOOTS_MAX);
        assert!(!seen.is_new("r", &format!("d{}", 2 * BOOTS_MAX - 1), 0, 100), "the newest boot stays");
    }

    #[test]
    fn the_number_of_ranges_is_limited_and_nothing_new_is_refused_above_the_lowest_gap() {
        let mut seen = Seen::default();
        for gap in 0..2 * RANGES_MAX as u64 {
            assert!(seen.is_new("r", "b", 2 * gap, 0));
        }
        assert_eq!(seen.robots["r"]["b"].ranges.len(), RANGES_MAX);
        assert!(!seen.is_new("r", "b", 1, 0), "the lowest gaps count as seen");
        assert!(seen.is_new("r", "b", 4 * RANGES_MAX as u64 - 3, 0));
    }

    #[test]
    fn golden_version_1_is_read() {
        let json = r#"{"version":1,"robots":{"r":{"b":{"newest_us":7,"ranges":[[0,17],[19,19]]}}}}"#;
        let mut seen = Seen::from_json(json).unwrap();
        assert_eq!(seen.to_json().unwrap(), json);
        assert!(seen.is_new("r", "b", 18, 8) && !seen.is_new("r", "b", 19, 8));
        assert!(Seen::from_json(&json.replace("1,\"robots", "2,\"robots")).is_err());
    }
}
