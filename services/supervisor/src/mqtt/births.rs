//! Requests for births: each robot of the fleet publishes its birth and its factsheet again.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use tokio::time::Instant;
use vibrissa_edge::clock::wall_clock;
use vibrissa_protocol::{Name, SupervisorRequest, SupervisorRequestKind, Timestamp, Topic, encode};

use super::Connection;
use crate::births::BirthCause;

/// Shortest interval between two requests. Robots answer within this time, and an answer serves all requests before it.
const INTERVAL_MIN: Duration = Duration::from_secs(2);
/// Limit of requests per minute, because each makes the whole fleet answer.
const PER_MINUTE: usize = 10;
const MINUTE: Duration = Duration::from_secs(60);
/// Longest pause after a request because births or factsheets were shed. The pause doubles, because the answers of a large
/// fleet can fill the inbox again: without it, 10,000 robots with 100 whiskers each sent 450,000 factsheets in six minutes.
const SHED_PAUSE_MAX: Duration = Duration::from_secs(600);

/// The requests for one fleet.
pub(crate) type SharedBirths = Arc<Mutex<BirthRequests>>;

/// The requests for all fleets of this supervisor.
#[derive(Debug, Clone, Default)]
pub(crate) struct FleetBirths(Arc<Mutex<BTreeMap<Name, SharedBirths>>>);

impl FleetBirths {
    /// The requests for a fleet.
    pub(crate) fn of(&self, fleet: &Name) -> SharedBirths {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).entry(fleet.clone()).or_default().clone()
    }
}

/// The requests of one supervisor for one fleet.
#[derive(Debug, Default)]
pub(crate) struct BirthRequests {
    /// `seq` of the next request.
    seq: u64,
    /// When they are published.
    pub(super) pace: Pace,
}

/// Limits how often all births and factsheets are requested, from the robots or from the broker.
#[derive(Debug, Default)]
pub(crate) struct Pace {
    wanted: Option<BirthCause>,
    /// Time of the last request because messages were shed, and the pause after it.
    shed: Option<(Instant, Duration)>,
    /// Times of the requests of the last minute.
    sent: VecDeque<Instant>,
}

impl Pace {
    /// Wants a request as soon as the limits allow it. Requests wanted before it are served by the same one.
    pub(super) fn want(&mut self, cause: BirthCause) {
        if self.wanted.is_none_or(|wanted| wanted == BirthCause::Shed) {
            self.wanted = Some(cause);
        }
    }

    /// The cause of a request that must be made now.
    pub(super) fn take_due(&mut self, now: Instant) -> Option<BirthCause> {
        let is_shed = self.wanted? == BirthCause::Shed;
        if is_shed && self.shed.is_some_and(|(last, pause)| now.saturating_duration_since(last) < pause) {
            return None;
        }
        while self.sent.front().is_some_and(|sent| now.saturating_duration_since(*sent) >= MINUTE) {
            self.sent.pop_front();
        }
        let is_early = self.sent.back().is_some_and(|last| now.saturating_duration_since(*last) < INTERVAL_MIN);
        if is_early || self.sent.len() >= PER_MINUTE {
            return None;
        }
        self.sent.push_back(now);
        if is_shed {
            self.shed = Some((now, self.pause_after_shed(now)));
        }
        self.wanted.take()
    }

    /// Pause after a request at `now` because messages were shed: twice the last one, if that ended not long ago.
    fn pause_after_shed(&self, now: Instant) -> Duration {
        match self.shed {
            Some((last, pause)) if now.saturating_duration_since(last) < 4 * pause => (2 * pause).min(SHED_PAUSE_MAX),
            Some(_) | None => 2 * INTERVAL_MIN,
        }
    }
}

impl BirthRequests {
    /// Topic and payload of the next request.
    pub(super) fn message(&mut self, connection: &Connection) -> (String, Vec<u8>) {
        let request = SupervisorRequest {
            boot_id: connection.boot_id.clone(),
            seq: self.seq,
            epoch: connection.epoch,
            timestamp: Timestamp(wall_clock().0),
            request: SupervisorRequestKind::Birth,
        };
        self.seq += 1;
        (Topic::SupervisorRequest { fleet: connection.fleet.clone() }.to_string(), encode(&request))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_are_at_least_two_seconds_apart_and_at_most_ten_a_minute() {
        let begin = Instant::now();
        let mut requests = Pace::default();
        assert_eq!(requests.take_due(begin), None, "none is wanted");
        let mut sent_ms = Vec::new();
        for ms in (0..300_000).step_by(100) {
            requests.want(BirthCause::Connected);
            if requests.take_due(begin + Duration::from_millis(ms)).is_some() {
                sent_ms.push(ms);
            }
        }
        assert_eq!(sent_ms[..10], [0, 2_000, 4_000, 6_000, 8_000, 10_000, 12_000, 14_000, 16_000, 18_000]);
        for window in sent_ms.windows(PER_MINUTE + 1) {
            assert!(window[PER_MINUTE] - window[0] >= 60_000, "{window:?}");
        }
        assert_eq!(sent_ms.len(), 5 * PER_MINUTE);
    }

    /// The answers of a large fleet filled the inbox, which shed some of them, which led to the next request.
    #[test]
    fn regress_requests_after_shed_answers_become_rare_and_others_do_not_wait_for_them() {
        let begin = Instant::now();
        let mut requests = Pace::default();
        let mut sent_s = Vec::new();
        for s in 0..3_600 {
            requests.want(BirthCause::Shed);
            if requests.take_due(begin + Duration::from_secs(s)).is_some() {
                sent_s.push(s);
            }
        }
        assert_eq!(sent_s[..8], [0, 4, 12, 28, 60, 124, 252, 508]);
        assert!(sent_s.len() <= 8 + 6, "{sent_s:?}");

        let next = begin + Duration::from_secs(3_600);
        requests.want(BirthCause::Shed);
        requests.want(BirthCause::Connected);
        assert_eq!(requests.take_due(next), Some(BirthCause::Connected));

        // After a time without, the first is sent at once.
        let later = next + 5 * SHED_PAUSE_MAX;
        for s in [0, 4] {
            requests.want(BirthCause::Shed);
            assert_eq!(requests.take_due(later + Duration::from_secs(s)), Some(BirthCause::Shed));
        }
    }

    #[test]
    fn one_request_serves_all_that_were_wanted_before_it_and_a_late_one_is_kept() {
        let begin = Instant::now();
        let mut requests = Pace::default();
        requests.want(BirthCause::Connected);
        requests.want(BirthCause::Unheard);
        assert_eq!(requests.take_due(begin), Some(BirthCause::Connected));
        assert_eq!(requests.take_due(begin + MINUTE), None);
        let next = begin + MINUTE;
        requests.want(BirthCause::Shed);
        assert_eq!(requests.take_due(next), Some(BirthCause::Shed));
        requests.want(BirthCause::Allowed);
        assert_eq!(requests.take_due(next + Duration::from_millis(1_999)), None);
        assert_eq!(requests.take_due(next + INTERVAL_MIN), Some(BirthCause::Allowed));
    }
}
