//! Touch tests after a change of sensitivity that the contacts leave undecided.
//!
//! A cut makes a whisker more sensitive at equal contact ratio, and so may a gain that wanders. For cuts of one or two
//! millimetres contacts often do not tell which it was. Touches do: at the former tip they come or they do not. So if a
//! suspicion ends as a wandering gain, or lasts, the supervisor requests a test. Until its end, the response while whole
//! is not learned. If it finds a cut, the offset that the filter has moved to goes back, and the change counts as length.

use crate::detection::Verdict;
use crate::estimation::filter::LENGTH;
use crate::estimation::gain_walk::Moved;
use crate::robot::Robot;
use crate::robot::effect::{Condition, TestReason, WhiskerIndex};
use crate::robot::params::Params;
use crate::robot::state::contact_evaluation::ContactResult;
use crate::robot::state::whisker::Whisker;
use crate::robot::touch_tests::LengthTest;

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
            Verdict::Wandered => true,
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
}

impl Whisker {
    fn want_test_of_change(&mut self, params: &Params, wandered: f64) {
        let is_whole = matches!(self.condition, Condition::Healthy | Condition::Suspected);
        if !is_whole || !self.is_at_nominal_pressure() || self.rare.length_test.is_some() {
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
        let mut test = LengthTest::new(whole_mm);
        test.evidence.hardly_below(whole_mm - 2.0 * loss_mm - LOSS_BEYOND_MM);
        test.wanted = Some(TestReason::Change);
        self.rare.get_or_insert().length_test = Some(Box::new(test));
    }

    /// Sets the offset back to that of the response while whole: the change was a cut and not a wandering gain.
    pub(super) fn take_gain_back(&mut self, params: &Params) {
        if !self.is_at_nominal_pressure() {
            return;
        }
        let moved = self.whole_lag(self.filter.offset());
        let variance = self.gain_lag(params, &self.whole).powi(2) + (BACK_SHARE_SD * moved).powi(2);
        if self.filter.wandered(Moved { by: -moved, variance }) {
            self.walks.changed();
        }
    }
}
