//! The reach of whiskers, and touch tests that measure their length.
//!
//! A contact at a known distance says nothing about what lies beyond it, so a cut of such a whisker shows only by silence
//! near the tip ([`crate::estimation::reach`]). Silence raises a suspicion and an alarm, and asks for a touch test if the
//! robot can do one. Only touches decide: those that came, those that did not, and those at the tip
//! ([`crate::estimation::length_evidence`]).
//!
//! ```text
//!            silence, a missed touch,                   requested        ACCEPTED, RUNNING
//!            a setpoint, an operator,
//!            a pause, a schedule, a change
//! no test ────────────────────────────▶ measurement ──────────────▶ in flight ───────────┐
//!    ▲                                     │    ▲  │                   ▲                 │
//!    │ the length is decided, or the       │    │  │ in mode ADVISE    │ an operator     │
//!    │ reason is gone                      │    │  └────▶ proposed ────┘                 │
//!    └─────────────────────────────────────┘    └────────────────────────────────────────┘
//!                                                  DONE, REJECTED, FAILED, expired, or a new boot
//! ```
//! A measurement can end while its test is in flight. Such a test is only followed to its end.
//!
//! An operator can refuse a proposed test. It is not proposed again for the same reason until there is new evidence.
//!
//! [`evidence`] adds contacts and decides, [`change`] asks for tests after changes of sensitivity that stay undecided, [`request`] sends requests and takes the robot's answers, [`plan`] finds the
//! whiskers that are due after a pause or by the schedule, [`zero`] measures the error that all distances of a robot share.

mod change;
mod evidence;
mod plan;
mod request;
mod zero;

pub(in crate::robot) use plan::TestTimes;
pub(in crate::robot) use zero::DistanceZero;

use borsh::{BorshDeserialize, BorshSerialize};

use crate::estimation::LengthEvidence;
use crate::robot::effect::{CommandKey, TestKind, TestReason, TestState};
use crate::units::Micros;

/// Standard deviation of a robot's distances before it has stated one, mm.
const SD_MM: f64 = 0.5;

/// Measurement of a whisker's length by touches.
#[derive(Debug, Clone, PartialEq, BorshSerialize, BorshDeserialize)]
pub(in crate::robot) struct LengthTest {
    evidence: LengthEvidence,
    /// Standard deviation of the robot's distances, mm, as it stated it last.
    sd_mm: f64,
    /// Touches that came.
    touches: u16,
    /// Touches that came or were missed.
    contacts: u16,
    /// Tests that were done for this measurement.
    done: u8,
    /// Reason for the next test; `None` if none is wanted.
    pub(in crate::robot) wanted: Option<TestReason>,
    /// The requested or proposed test; one that an operator refused stays until there is new evidence.
    pub(in crate::robot) in_flight: Option<TestInFlight>,
    /// No request before this, by the supervisor's clock.
    not_before: Micros,
}

/// A requested test.
#[derive(Debug, Clone, Copy, PartialEq, BorshSerialize, BorshDeserialize)]
pub(in crate::robot) struct TestInFlight {
    key: CommandKey,
    pub kind: TestKind,
    pub reason: TestReason,
    pub state: TestState,
    /// Given up at this time, by the supervisor's clock.
    until: Micros,
}

/// Number of touch tests requested from a robot in the present hour.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, BorshSerialize, BorshDeserialize)]
pub(in crate::robot) struct TestBudget {
    /// Start of the hour, by the supervisor's clock.
    since: Micros,
    requested: u16,
}

crate::optional_parts::optional_fields!(LengthTest: evidence, sd_mm;
    touches: *touches > 0,
    contacts: *contacts > *touches,
    done: *done > 0,
    wanted: wanted.is_some(),
    in_flight: in_flight.is_some(),
    not_before: *not_before > Micros::default(),
);
crate::optional_parts::optional_fields!(TestBudget: since; requested: *requested > 0);

impl LengthTest {
    /// A measurement of a whisker that had this length, mm.
    fn new(length_mm: f64) -> Self {
        Self {
            evidence: LengthEvidence::new(length_mm),
            sd_mm: SD_MM,
            touches: 0,
            contacts: 0,
            done: 0,
            wanted: None,
            in_flight: None,
            not_before: Micros::default(),
        }
    }

    /// The requested or proposed test and its progress.
    pub(in crate::robot) fn in_flight(&self) -> Option<(TestKind, TestState)> {
        self.in_flight.filter(|test| test.state != TestState::Refused).map(|test| (test.kind, test.state))
    }

    /// Key of the requested test; none for a proposal.
    pub(in crate::robot) fn key_under_way(&self) -> Option<CommandKey> {
        self.under_way().map(|test| test.key)
    }

    /// The requested test, which is not a proposal.
    fn under_way(&self) -> Option<TestInFlight> {
        self.in_flight.filter(|test| !matches!(test.state, TestState::Proposed | TestState::Refused))
    }

    /// The proposed test.
    fn proposal(&self) -> Option<TestInFlight> {
        self.in_flight.filter(|test| test.state == TestState::Proposed)
    }

    /// Whether it measures after a change of sensitivity that stayed undecided.
    pub(in crate::robot) fn is_for_change(&self) -> bool {
        self.wanted == Some(TestReason::Change)
    }

    /// Whether a test of the length is under way for this measurement.
    fn is_measuring(&self) -> bool {
        let is_of_length = self.wanted.is_some_and(|reason| reason != TestReason::Setpoint);
        is_of_length && self.under_way().is_some() && !self.is_only_followed()
    }

    /// Whether an operator has refused the wanted test.
    fn is_refused(&self) -> bool {
        self.in_flight.is_some_and(|test| test.state == TestState::Refused && self.wanted == Some(test.reason))
    }

    /// Whether its measurement has ended before its test: the touches are no evidence any more.
    fn is_only_followed(&self) -> bool {
        let test = self.in_flight.filter(|test| test.state != TestState::Refused);
        test.is_some_and(|test| self.wanted != Some(test.reason))
    }
}

impl TestBudget {
    const HOUR: Micros = Micros(3_600_000_000);

    /// Whether one of so many tests per hour is left.
    fn is_left(mut self, now: Micros, per_hour: u16) -> bool {
        self.take(now, per_hour)
    }

    /// Takes one of so many tests per hour; false if none is left.
    fn take(&mut self, now: Micros, per_hour: u16) -> bool {
        // A clock that was set back begins an hour, too.
        if now.since(self.since).max(self.since.since(now)) >= Self::HOUR || self.requested == 0 {
            *self = Self { since: now, requested: 0 };
        }
        let is_left = self.requested < per_hour;
        self.requested += u16::from(is_left);
        is_left
    }
}
