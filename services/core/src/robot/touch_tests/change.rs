//! Touch tests after a change of sensitivity that is to be confirmed, or that the contacts leave undecided.
//!
//! A cut makes a whisker more sensitive at equal contact ratio, and so may a gain that wanders. For cuts of one or two
//! millimetres contacts often do not tell which it was. Touches do: at the former tip they come or they do not. So if a
//! suspicion ends as a wandering gain, or lasts, the supervisor requests a test. Until its end, the response while whole
//! is not learned. If it finds a cut, the offset that the filter has moved to goes back, and the change counts as length.
//!
//! A test also confirms each small cut, and each cut of an unsteady whisker, before it is reported. Steps and walks of the gain look
//! like small cuts, and on an unsteady whisker other nuisances look like larger ones. Of 12 false trims that a mix of nuisances gives in
//! 30 million contacts, tests refute all, and cuts of 2 mm and more are found as before. A refuted cut counts as gain. The report waits no
//! longer than the detector's patience, and not for a robot that cannot do the test now.

use crate::detection::Verdict;
use crate::estimation::filter::LENGTH;
use crate::estimation::gain_walk::Moved;
use crate::policy::Mode;
use crate::robot::Robot;
use crate::robot::effect::{Condition, TestReason, WhiskerIndex};
use crate::robot::params::Params;
use crate::robot::state::contact_evaluation::ContactResult;
use crate::robot::state::whisker::Whisker;
use crate::robot::touch_tests::LengthTest;
use crate::units::Micros;

/// A suspicion that has lasted for so many contacts is undecided.
const UNDECIDED_CONTACTS: u32 = 300;
/// Losses that tests do not find, mm.
const LOSS_MIN_MM: f64 = 0.3;
/// The loss is at most twice the one that the moved gain explains, and this, mm.
const LOSS_BEYOND_MM: f64 = 1.5;
/// Share of the offset that goes back and stays uncertain.
const BACK_SHARE_SD: f64 = 0.3;

impl Robot {
    /// Asks for a test of a whisker whose sensitivity rose, if its contacts leave open whether it was cut.
    pub(in crate::robot) fn test_change(&mut self, params: &Params, index: WhiskerIndex, felt: &ContactResult) {
        let is_undecided = match felt.verdict {
            Verdict::Wandered | Verdict::Unconfirmed => true,
            Verdict::Looking => self.whiskers[index].detector.contacts_suspected() == Some(UNDECIDED_CONTACTS),
            Verdict::Quiet | Verdict::Alarm | Verdict::Dismissed | Verdict::Changed(_) | Verdict::Shared(_) => false,
        };
        let can_test = self.head.touch_tests.tip || self.head.touch_tests.wall;
        // At a known distance a cut does not change the sensitivity.
        let informs_length = felt.innovation.is_some_and(|seen| seen.row[LENGTH] != 0.0);
        if is_undecided && can_test && informs_length {
            self.whiskers[index].want_test_of_change(params, felt.wandered);
        }
    }

    /// Whether a touch test of a whisker's length is under way, or can begin now without an operator. After a rejected, failed or
    /// expired test it cannot, so that a robot without an answer delays a report by one test.
    pub(in crate::robot) fn can_confirm(&self, params: &Params, now: Micros, index: WhiskerIndex) -> bool {
        let whisker = &self.whiskers[index];
        if let Some(test) = &whisker.rare.length_test {
            return test.is_measuring();
        }
        (self.head.touch_tests.tip || self.head.touch_tests.wall)
            && params.policy.mode != Mode::Advise
            && whisker.is_whole()
            && whisker.can_measure(params)
            && self.can_begin_test(params, now, index)
            && self.head.tests.is_left(now, params.touch_tests.per_hour)
    }

    /// A touch test has found that a whisker kept its length: a suspected change of sensitivity is one of its gain.
    pub(super) fn refute_cut(&mut self, params: &Params, index: WhiskerIndex) {
        let whisker = &mut self.whiskers[index];
        if whisker.detector.is_suspicious() {
            let moved = whisker.follow_gain(Verdict::Wandered);
            self.gain_wandered(params, index, moved);
        }
    }
}

impl Whisker {
    /// Whether it works with its full length, at its nominal pressure.
    fn is_whole(&self) -> bool {
        matches!(self.condition, Condition::Healthy | Condition::Suspected) && self.is_at_nominal_pressure()
    }

    fn want_test_of_change(&mut self, params: &Params, wandered: f64) {
        if !self.is_whole() || self.rare.length_test.is_some() {
            return;
        }
        let Some(slope) = self.model(params).map(|model| self.log_slope_with_length(model)) else { return };
        let whole_mm = self.sheet.length.mm();
        let by_gain = -wandered / slope;
        let log_loss = self.detector.suspected_shift().map_or(by_gain, |fit| -fit.size);
        let loss_mm = log_loss.abs() * whole_mm;
        if !(log_loss > 0.0 && loss_mm >= LOSS_MIN_MM) {
            return;
        }
        self.want_test_of_loss(whole_mm, loss_mm);
    }

    /// Begins a measurement of a length that may have lost this much.
    pub(in crate::robot) fn want_test_of_loss(&mut self, length_mm: f64, loss_mm: f64) {
        let mut test = LengthTest::new(length_mm);
        test.evidence.hardly_below(length_mm - 2.0 * loss_mm - LOSS_BEYOND_MM);
        test.wanted = Some(TestReason::Change);
        self.rare.get_or_insert().length_test = Some(Box::new(test));
    }

    /// Sets the offset back to that of the response while whole: the change was a cut and not a wandering gain.
    pub(super) fn take_gain_back(&mut self, params: &Params) {
        if !self.is_at_nominal_pressure() {
            return;
        }
        let moved = self.whole_lag(self.filter.whole_offset());
        let variance = self.gain_lag(params, &self.whole).powi(2) + (BACK_SHARE_SD * moved).powi(2);
        if self.filter.wandered(Moved { by: -moved, variance }) {
            self.walks.changed();
        }
    }
}
