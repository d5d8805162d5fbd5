//! Watches for robots whose births were not received, and has the supervisor request them again.
//!
//! The receiving connection asks all robots once it is up. That request, or an answer to it, may be lost.

use std::time::Duration;

use tokio::time::Instant;

use crate::births::BirthCause;

/// Time for answers after the robots are heard: the contract allows them 2 s.
const PATIENCE: Duration = Duration::from_secs(5);
/// First and longest pause between two requests because of robots without a birth. The pause doubles: otherwise a robot
/// without a birth would make the whole fleet answer all the time.
const PAUSE: Duration = Duration::from_secs(10);
const PAUSE_MAX: Duration = Duration::from_secs(3600);

/// The watch of one fleet, from its takeover on.
#[derive(Debug)]
pub(super) struct BirthWatch {
    /// Since when robots are heard.
    heard_since: Option<Instant>,
    /// Whether the robots of the database were checked.
    is_checked: bool,
    unannounced_from: Option<Instant>,
    pause: Duration,
}

impl BirthWatch {
    pub(super) fn new() -> Self {
        Self { heard_since: None, is_checked: false, unannounced_from: None, pause: PAUSE }
    }

    /// The cause of a request that is due at `now`, while robots are heard. `has_unannounced` says whether a message of
    /// a boot without a birth has come since the last call; `has_unheard` whether a robot of the database was not heard.
    pub(super) fn due(
        &mut self,
        now: Instant,
        has_unannounced: bool,
        has_unheard: impl FnOnce() -> bool,
    ) -> Option<BirthCause> {
        let heard_since = *self.heard_since.get_or_insert(now);
        if now.saturating_duration_since(heard_since) < PATIENCE {
            return None;
        }
        // Once: a robot that was removed for good never answers.
        if !std::mem::replace(&mut self.is_checked, true) && has_unheard() {
            return Some(BirthCause::Unheard);
        }
        if !has_unannounced || self.unannounced_from.is_some_and(|from| now < from) {
            return None;
        }
        self.unannounced_from = Some(now + self.pause);
        self.pause = (2 * self.pause).min(PAUSE_MAX);
        Some(BirthCause::Unannounced)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(begin: Instant, s: u64) -> Instant {
        begin + Duration::from_secs(s)
    }

    #[test]
    fn robots_of_the_database_that_are_not_heard_are_asked_once_more_after_five_seconds() {
        let begin = Instant::now();
        let mut watch = BirthWatch::new();
        let asked: Vec<u64> = (0..1_000).filter(|&s| watch.due(at(begin, s), false, || true).is_some()).collect();
        assert_eq!(asked, [5]);
        let mut watch = BirthWatch::new();
        assert!((0..1_000).all(|s| watch.due(at(begin, s), false, || false).is_none()), "all are heard");
    }

    #[test]
    fn robots_without_a_birth_are_asked_after_doubling_pauses() {
        let begin = Instant::now();
        let mut watch = BirthWatch::new();
        let causes = (0..20_000).filter_map(|s| Some((s, watch.due(at(begin, s), true, || false)?)));
        let asked: Vec<u64> = causes
            .map(|(s, cause)| {
                assert_eq!(cause, BirthCause::Unannounced);
                s
            })
            .collect();
        let first = [5, 15, 35, 75, 155, 315, 635, 1275, 2555, 5115];
        assert_eq!(asked[..10], first);
        assert!(asked[10..].windows(2).all(|pair| pair[1] - pair[0] == PAUSE_MAX.as_secs()), "{asked:?}");
    }
}
