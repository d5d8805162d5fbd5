//! Topics on which the broker has refused the last publication.

use std::collections::BTreeMap;
use std::time::Duration;

use tokio::time::Instant;

/// Limit of the topics that are remembered: they contain names of robots.
const TOPICS_MAX: usize = 64;
/// How long a refusal is remembered if nothing more is published on the topic: twice the longest pause between two tries of a
/// setpoint, so that readiness does not come and go with them.
const KEPT: Duration = Duration::from_secs(2 * 3600);

/// The last refusal on a topic.
#[derive(Debug)]
struct Refused {
    why: String,
    at: Instant,
}

/// The refused topics. A topic stays until a publication on it is accepted: acceptance on another topic says nothing.
#[derive(Debug, Default)]
pub(super) struct Refusals(BTreeMap<String, Refused>);

impl Refusals {
    /// Notes a refusal. Returns whether it is the first on this topic.
    pub(super) fn refused(&mut self, topic: &str, why: &str, now: Instant) -> bool {
        self.0.retain(|_, refused| is_kept(refused, now));
        let is_news = !self.0.contains_key(topic);
        if is_news && self.0.len() >= TOPICS_MAX {
            return false;
        }
        self.0.insert(topic.to_owned(), Refused { why: why.to_owned(), at: now });
        is_news
    }

    /// Notes an acceptance. Returns whether the topic was refused before.
    pub(super) fn accepted(&mut self, topic: &str) -> bool {
        !self.0.is_empty() && self.0.remove(topic).is_some()
    }

    /// Whether the last publication on this topic was refused.
    pub(super) fn has(&self, topic: &str) -> bool {
        self.0.contains_key(topic)
    }

    /// The reasons, one for each kind of topic.
    pub(super) fn texts(&self, now: Instant) -> Vec<String> {
        let mut kinds: BTreeMap<&str, (&str, usize)> = BTreeMap::new();
        for (topic, refused) in self.0.iter().filter(|(_, refused)| is_kept(refused, now)) {
            let kind = topic.rsplit('/').next().unwrap_or(topic);
            kinds.entry(kind).or_insert((refused.why.as_str(), 0)).1 += 1;
        }
        let text = |(why, topics): (&str, usize)| match topics {
            1 => why.to_owned(),
            more => format!("{why}; the same on {} more topics", more - 1),
        };
        kinds.into_values().map(text).collect()
    }
}

fn is_kept(refused: &Refused, now: Instant) -> bool {
    now.saturating_duration_since(refused.at) < KEPT
}

#[cfg(test)]
mod tests {
    use super::*;
    use vibrissa_core::robot::params::CommandParams;

    #[test]
    fn regress_a_refused_setpoint_is_remembered_until_it_is_tried_again() {
        let pause = Duration::from_secs_f64(CommandParams::default().retry_after_max.as_s());
        let (mut refusals, mut now) = (Refusals::default(), Instant::now());
        for _ in 0..24 {
            refusals.refused("whisker/v1/f/r/setpoint", "no", now);
            now += pause;
            assert_eq!(refusals.texts(now), ["no"]);
        }
    }

    #[test]
    fn refusals_are_bounded_and_forgotten_once_nothing_more_is_published() {
        let (mut refusals, now) = (Refusals::default(), Instant::now());
        for robot in 0..1000 {
            refusals.refused(&format!("whisker/v1/f/r{robot}/receipt"), "no", now);
        }
        assert_eq!(refusals.texts(now), [format!("no; the same on {} more topics", TOPICS_MAX - 1)]);
        assert!(refusals.texts(now + KEPT).is_empty());
        assert!(refusals.refused("whisker/v1/f/r/setpoint", "no", now + KEPT) && refusals.0.len() == 1);
        assert!(!refusals.refused("whisker/v1/f/r/setpoint", "no", now + KEPT), "known already");
        assert!(refusals.accepted("whisker/v1/f/r/setpoint") && !refusals.has("whisker/v1/f/r/setpoint"));
    }
}
