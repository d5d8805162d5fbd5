//! The error that all distances of a robot share: its kinematics, or the place where it holds the whisker.
//!
//! A touch test compares the length with the robot's own millimetres. If these are off by 2 mm, a whole whisker looks
//! cut by 2 mm, and a cut one whole. So each whisker keeps the error of its distances with a standard deviation. The
//! first test of a learned whisker measures the error, because its contacts show that it is whole. Contacts at its tip
//! while it is learned do so, too. Before that, no test tells a cut of a few millimetres.
//!
//! The factory length has an error, too, and it ends up in the same number. A later test tells the loss without it.

use borsh::{BorshDeserialize, BorshSerialize};

use crate::policy::Mode;
use crate::robot::Robot;
use crate::robot::effect::{Condition, Effect, TestReason, WhiskerIndex};
use crate::robot::event::{Contact, ContactPlace, Distance};
use crate::robot::params::Params;
use crate::robot::state::whisker::Whisker;
use crate::units::{Micros, Millimetre};

/// The error is known once its standard deviation is down to this, mm.
const KNOWN_SD_MM: f64 = 0.2;
/// The same where one gain follows from a length that only tests tell, mm: it is 4 % of the difference that a cut of 2 mm
/// makes.
const KNOWN_ALONE_SD_MM: f64 = 0.1;
/// A test can confirm a cut, and a contact of it tells a sensitivity, once it is down to this, mm.
const USABLE_SD_MM: f64 = 0.5;
/// Least standard deviation of a contact at the tip: errors of distances are alike from contact to contact.
const TIP_SD_MM: f64 = 0.5;
/// A distance of the tip may be off by so many standard deviations; another one is a wrong report.
const PLAUSIBLE_SD: f64 = 4.0;
/// Tests of a whisker for this purpose, one after another. Fifty touches against a wall tell the error to about 0.2 mm,
/// a hundred to 0.1 mm, ten at the tip to 0.2 mm.
const TESTS_MAX: u8 = 5;
/// Least probability that the whisker is whole.
const WHOLE_MIN: f64 = 0.05;
/// Time after which a test that the robot could not do is requested again.
const AGAIN_AFTER: Micros = Micros(3_600_000_000);
/// Contacts that the length filter forgets a length in, about. The shared error does not average out among them, so
/// that each of them tells no more than a part of what one alone would.
const AVERAGED_CONTACTS: f64 = 100.0;

/// The error of a robot's distances at one whisker.
#[derive(Debug, Clone, Copy, PartialEq, BorshSerialize, BorshDeserialize)]
pub(in crate::robot) struct DistanceZero {
    /// To be added to the robot's distances, mm.
    off_mm: f32,
    /// Its standard deviation, mm; below 0 before anything was measured.
    sd_mm: f32,
    /// Tests that were done for it.
    tests: u8,
    /// Time of the last request, by the supervisor's clock; 0 if another one may follow at once.
    asked: Micros,
}

impl DistanceZero {
    pub(in crate::robot) const UNKNOWN: Self = Self { off_mm: 0.0, sd_mm: -1.0, tests: 0, asked: Micros(0) };

    /// The error with its standard deviation, mm, where this is the standard deviation before any measurement.
    pub(in crate::robot) fn known(&self, prior_sd_mm: f64) -> (f64, f64) {
        let sd_mm = if self.sd_mm < 0.0 { prior_sd_mm } else { f64::from(self.sd_mm).min(prior_sd_mm) };
        (self.off_mm.into(), sd_mm)
    }

    /// The error with its standard deviation, mm, once it was measured.
    pub(in crate::robot) fn measured(&self) -> Option<(f64, f64)> {
        (self.sd_mm >= 0.0).then(|| (self.off_mm.into(), self.sd_mm.into()))
    }

    /// Whether its numbers are finite.
    pub(in crate::robot) fn is_sound(&self) -> bool {
        self.off_mm.is_finite() && self.sd_mm.is_finite()
    }

    fn learn(&mut self, off_mm: f64, sd_mm: f64) {
        (self.off_mm, self.sd_mm) = (off_mm as f32, sd_mm as f32);
    }
}

impl Robot {
    /// Requests a test of the next whisker whose distances have an unknown error, in mode AUTOMATIC. Half of the tests
    /// of an hour are left to suspicions.
    pub(super) fn plan_zero(&mut self, params: &Params, now: Micros, effects: &mut Vec<Effect>) {
        let can_test = self.head.touch_tests.tip || self.head.touch_tests.wall;
        if !can_test || params.touch_tests.zero_sd_mm <= 0.0 || params.policy.mode != Mode::Automatic {
            return;
        }
        let is_next = |index: &WhiskerIndex| {
            let whisker = &self.whiskers[*index];
            // Contacts without a place leave a whisker in its first condition.
            let is_learned = whisker.condition == Condition::Healthy || self.states_no_place(*index);
            is_learned
                && whisker.lacks_zero(params, now, self.needs_exact_length(*index))
                && whisker.rare.length_test.is_none()
        };
        let Some(index) = (0..self.whiskers.len()).find(is_next) else { return };
        let waits = self.tests_under_way().next().is_some()
            || !self.head.tests.is_left(now, params.touch_tests.per_hour.div_ceil(2))
            || !self.can_begin_test(params, now, index);
        if waits {
            return;
        }
        let rare = self.whiskers[index].rare.get_or_insert();
        rare.zero.asked = now;
        self.want_test(index, TestReason::Schedule);
        self.request_test(params, now, index, effects);
    }

    /// A test of a whole whisker is done: its touches tell the error that the distances share. False if it was another
    /// test, or if a cut explains the touches better.
    pub(super) fn learn_zero(&mut self, params: &Params, index: WhiskerIndex) -> bool {
        let alone = self.needs_exact_length(index);
        let whisker = &mut self.whiskers[index];
        let (off_mm, sd_mm) = whisker.zero(params);
        let is_of_zero = whisker.is_test_of_zero(params, alone);
        let Some(test) = whisker.rare.length_test.as_ref().filter(|_| is_of_zero) else { return false };
        if test.contacts == 0 {
            // Another one follows after a pause.
            whisker.end_measurement();
            return true;
        }
        if test.evidence.posterior(sd_mm).unchanged < WHOLE_MIN {
            return false;
        }
        let apparent = test.evidence.apparent(sd_mm);
        let off_mm = off_mm + test.evidence.length_mm() - apparent.mean_mm;
        let zero = &mut whisker.rare.get_or_insert().zero;
        zero.learn(off_mm, apparent.sd_mm.min(sd_mm));
        zero.tests = zero.tests.saturating_add(1);
        zero.asked = Micros(0);
        whisker.end_measurement();
        true
    }
}

impl Whisker {
    /// Error of its robot's distances and its standard deviation, mm.
    pub(in crate::robot) fn zero(&self, params: &Params) -> (f64, f64) {
        self.rare.zero.known(params.touch_tests.zero_sd_mm)
    }

    /// Whether the error of its distances is known well enough to measure lengths with them. `alone`: a gain
    /// follows from a length that nothing else tells.
    pub(in crate::robot) fn knows_zero(&self, params: &Params, alone: bool) -> bool {
        self.zero(params).1 <= if alone { KNOWN_ALONE_SD_MM } else { KNOWN_SD_MM } || self.rare.zero.tests >= TESTS_MAX
    }

    /// Whether a test can tell a cut of a few millimetres from the error of its distances.
    pub(in crate::robot) fn can_measure(&self, params: &Params) -> bool {
        self.zero(params).1 <= USABLE_SD_MM
    }

    /// Whether a test is to measure the error of its distances: nothing speaks against its whole length.
    fn lacks_zero(&self, params: &Params, now: Micros, alone: bool) -> bool {
        let asked = self.rare.zero.asked;
        let is_time = asked == Micros(0) || now.since(asked) >= AGAIN_AFTER;
        self.is_known_whole() && self.detector.is_calm() && is_time && !self.knows_zero(params, alone)
    }

    fn is_known_whole(&self) -> bool {
        matches!(self.condition, Condition::Learning | Condition::Healthy)
            && self.is_at_nominal_pressure()
            && !self.detector.is_suspicious()
            && !self.is_reach_silent()
            && self.filter.length().length.mm() > self.sheet.length.mm() - 1.0
    }

    /// Whether the present test measures the error of its distances.
    pub(super) fn is_test_of_zero(&self, params: &Params, alone: bool) -> bool {
        let reason = self.rare.length_test.as_ref().and_then(|test| test.wanted);
        matches!(reason, Some(TestReason::Schedule | TestReason::Operator))
            && self.is_known_whole()
            && !self.knows_zero(params, alone)
    }

    /// A distance as the robot's error leaves it.
    pub(super) fn true_distance(&self, params: &Params, at: Distance) -> Option<Distance> {
        let off_mm = self.zero(params).0;
        Some(Distance { at: Millimetre::new(at.at.mm() + off_mm).ok()?, ..at })
    }

    /// The place of a contact, as far as the error of the robot's distances is known.
    ///
    /// A robot whose contacts state distances has taught its offset from the model with the same error. So its tests
    /// count in its own millimetres, too. Before the error is known, touches of a test tell nothing else.
    pub(in crate::robot) fn true_place(
        &self,
        params: &Params,
        contact: &Contact<'_>,
        states_distance: bool,
    ) -> ContactPlace {
        let zero_sd_mm = self.zero(params).1;
        match contact.place {
            _ if contact.is_test && !self.can_measure(params) => ContactPlace::Unknown,
            ContactPlace::Tip(Some(at)) if contact.is_test && states_distance => ContactPlace::Distance(at),
            ContactPlace::Distance(at) if contact.is_test && !states_distance => {
                let at = self.true_distance(params, at).unwrap_or(at);
                ContactPlace::Distance(Distance { sd_mm: at.sd_mm.hypot(zero_sd_mm), ..at })
            }
            ContactPlace::Tip(Some(at)) => {
                let shared_mm = AVERAGED_CONTACTS.sqrt() * zero_sd_mm;
                let at = self.true_distance(params, at);
                ContactPlace::Tip(at.map(|at| Distance { sd_mm: at.sd_mm.hypot(shared_mm), ..at }))
            }
            place @ (ContactPlace::Distance(_)
            | ContactPlace::Ratio { .. }
            | ContactPlace::Tip(None)
            | ContactPlace::Unknown) => place,
        }
    }

    /// Contacts at the tip that its robot makes by habit tell the error of the distances while nothing speaks against
    /// the whole length.
    pub(super) fn follow_zero(&mut self, params: &Params, at: Distance, alone: bool) {
        let (off_mm, sd_mm) = self.zero(params);
        if self.knows_zero(params, alone)
            || self.rare.length_test.is_some()
            || !self.is_known_whole()
            || !self.detector.is_calm()
        {
            return;
        }
        let contact_sd_mm = at.sd_mm.max(TIP_SD_MM);
        let seen_mm = self.sheet.length.mm() - at.at.mm() - off_mm;
        let variance = sd_mm.powi(2) + contact_sd_mm.powi(2);
        if seen_mm.powi(2) > PLAUSIBLE_SD.powi(2) * variance {
            return;
        }
        let gain = sd_mm.powi(2) / variance;
        self.rare.get_or_insert().zero.learn(off_mm + gain * seen_mm, sd_mm * (1.0 - gain).sqrt());
    }
}
