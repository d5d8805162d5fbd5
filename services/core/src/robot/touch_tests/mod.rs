//! The reach of whiskers, and touch tests that measure their length.
//!
//! A contact at a known distance says nothing about what lies beyond it, so a cut of such a whisker shows only by silence
//! near the tip ([`crate::estimation::reach`]). Silence raises a suspicion and an alarm, and asks for a touch test if the
//! robot can do one. Only touches decide: those that came, those that did not, and those at the tip
//! ([`crate::estimation::length_evidence`]).
//!
//! ```text
//!            silence, a missed touch,                   requested        ACCEPTED, RUNNING
//!            a setpoint, an operator
//! no test ────────────────────────────▶ measurement ──────────────▶ in flight ───────────┐
//!    ▲                                     │    ▲                                        │
//!    │ the length is decided, or the       │    └────────────────────────────────────────┘
//!    │ reason is gone                      │       DONE, REJECTED, FAILED, expired, or a new boot
//!    └─────────────────────────────────────┘
//! ```
//!
//! [`evidence`] adds contacts and decides, [`request`] sends requests and takes the robot's answers.

mod evidence;
mod request;

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
    wanted: Option<TestReason>,
    in_flight: Option<TestInFlight>,
    /// No request before this, by the supervisor's clock.
    not_before: Micros,
}

/// A requested test.
#[derive(Debug, Clone, Copy, PartialEq, BorshSerialize, BorshDeserialize)]
struct TestInFlight {
    key: CommandKey,
    kind: TestKind,
    reason: TestReason,
    state: TestState,
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

    /// The requested test and its progress.
    pub(in crate::robot) fn in_flight(&self) -> Option<(CommandKey, TestKind, TestState)> {
        self.in_flight.map(|test| (test.key, test.kind, test.state))
    }

    /// Whether a test is wanted and not requested yet.
    pub(in crate::robot) fn is_wanted(&self) -> bool {
        self.wanted.is_some() && self.in_flight.is_none()
    }
}

impl TestBudget {
    const HOUR: Micros = Micros(3_600_000_000);

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
