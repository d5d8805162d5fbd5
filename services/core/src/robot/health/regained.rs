//! A rise of sensitivity after a loss of about the same size: the loss is over, or the whisker was cut.
//!
//! The readings cannot tell one from the other, and both explanations lead to the same level. So neither is taken as
//! certain: the whisker is suspected, and the interval of its length holds both lengths. A touch test decides, where
//! the robot offers one; otherwise a person does. No pressure changes meanwhile, because the whisker reads as it did
//! while it was whole.

use crate::detection::Change;
use crate::estimation::filter::Wander;
use crate::mechanics::Offset;
use crate::robot::Robot;
use crate::robot::effect::{Condition, Effect, WhiskerIndex};
use crate::robot::params::Params;
use crate::robot::state::rare_state::PendingTrim;
use crate::robot::state::whisker::Whisker;
use crate::units::{ContactRatio, Millimetre};

/// Standard deviation of the length in doubt, as a share of the cut that would explain the rise: the cut is well within
/// the 95 % interval.
const DOUBT_SHARE: f64 = 0.7;
/// Largest standard deviation of a length in doubt within the filter, mm. The filter is linear: beyond this the length
/// would leave what the contacts tell. The stated interval is wider.
const DOUBT_SD_MAX_MM: f64 = 4.5;
/// A difference from the whole length that is a cut: at least this, mm, and this many standard deviations.
const LOSS_MIN_MM: f64 = 0.5;
const LOSS_MIN_SD: f64 = 3.0;
/// A length of a whole whisker with at least this standard deviation is in doubt, mm.
const DOUBT_SD_MM: f64 = 0.6;

/// Standard deviation of a length after a suspicion that nothing has confirmed, mm. Cuts of 1 mm are not told from the
/// errors that the contacts share: they are within the 95 % interval.
const UNCONFIRMED_SD_MM: f64 = 0.55;

impl Robot {
    /// Puts the length of a whisker in doubt after a rise that took back its loss of sensitivity.
    pub(super) fn doubt_length(
        &mut self,
        params: &Params,
        index: WhiskerIndex,
        change: &Change,
        effects: &mut Vec<Effect>,
    ) {
        let whisker = &mut self.whiskers[index];
        let Some(model) = whisker.model(params) else { return };
        let slope = whisker.log_slope_with_length(model);
        let length_mm = whisker.filter.length().length.mm();
        let loss_mm = length_mm * (1.0 - change.size.exp());
        let Some(doubt) = Doubt::of(loss_mm) else { return };
        let is_cut = whisker.is_cut();
        whisker.filter.doubt_gain(slope * doubt.learned_sd_mm() / length_mm, slope);
        whisker.filter.keep_doubt(doubt.sd_mm);
        self.test_doubt(index, loss_mm);
        // The end of a loss ends no earlier cut.
        let to = if is_cut { Condition::Trimmed } else { Condition::Suspected };
        self.set_condition(index, to, effects);
    }

    /// Puts the length of a whisker in doubt that may have lost this, mm, beside its former doubt: at most `most_mm` in all.
    /// False if its condition stays: the loss is within the least doubt, or the whisker serves or was cut before.
    pub(super) fn doubt_further(
        &mut self,
        params: &Params,
        index: WhiskerIndex,
        (loss_mm, most_mm): (f64, f64),
        effects: &mut Vec<Effect>,
    ) -> bool {
        let whisker = &mut self.whiskers[index];
        let Some((model, doubt)) = whisker.model(params).zip(Doubt::of(loss_mm)) else { return false };
        let slope = whisker.log_slope_with_length(model);
        let length_mm = whisker.filter.length().length.mm();
        let before_mm = f64::from(whisker.filter.least_sd_mm());
        let all =
            Doubt { sd_mm: before_mm.hypot(doubt.sd_mm).min(DOUBT_SHARE * most_mm).max(before_mm).max(doubt.sd_mm) };
        let more = all.learned_sd_mm().powi(2) - before_mm.powi(2);
        if more > 0.0 {
            whisker.filter.doubt_gain(slope * more.sqrt() / length_mm, slope);
        }
        whisker.filter.keep_doubt(all.sd_mm);
        if matches!(whisker.condition, Condition::Trimmed | Condition::Eroding) || !whisker.is_at_nominal_pressure() {
            return false;
        }
        self.test_doubt(index, loss_mm);
        self.set_condition(index, Condition::Suspected, effects);
        true
    }

    /// Puts the length of a whisker in doubt that is learned now: it may have been shorter by this from the first
    /// contact on, mm, or longer if it is below 0. `whole` is its offset while whole.
    pub(super) fn doubt_whole(
        &mut self,
        params: &Params,
        index: WhiskerIndex,
        (loss_mm, whole): (f64, Offset),
        effects: &mut Vec<Effect>,
    ) {
        let whisker = &mut self.whiskers[index];
        let Some((model, doubt)) = whisker.model(params).zip(Doubt::of(loss_mm)) else { return };
        let slopes = (whisker.log_slope_with_length(model), whisker.log_slope_at(model, ContactRatio::TIP));
        whisker.filter.doubt_whole(doubt.learned_sd_mm(), slopes);
        whisker.filter.keep_doubt(doubt.sd_mm);
        whisker.leaves_whole(whole);
        self.test_doubt(index, loss_mm);
        self.set_condition(index, Condition::Suspected, effects);
    }

    /// A suspicion has ended without a verdict about the length, or with a loss of sensitivity: something else explains the
    /// readings as well.
    pub(in crate::robot) fn keep_small_doubt(&mut self, index: WhiskerIndex) {
        let filter = &mut self.whiskers[index].filter;
        filter.keep_doubt(UNCONFIRMED_SD_MM.max(filter.least_sd_mm().into()));
    }

    /// Asks for a test of a length in doubt, where one can tell.
    fn test_doubt(&mut self, index: WhiskerIndex, loss_mm: f64) {
        let can_test = self.head.touch_tests.tip || self.head.touch_tests.wall;
        let whisker = &mut self.whiskers[index];
        if can_test && loss_mm > 0.0 && whisker.rare.length_test.is_none() {
            whisker.want_test_of_loss(whisker.filter.length().length.mm(), loss_mm);
        }
    }

    /// The length is certain again. If it is another one, the whisker was cut.
    pub(super) fn end_doubt(&mut self, index: WhiskerIndex, effects: &mut Vec<Effect>) {
        let whisker = &mut self.whiskers[index];
        let whole_mm = whisker.sheet.length.mm();
        if whisker.is_cut() {
            let confirmed =
                PendingTrim { length_before_mm: whole_mm, contacts_since_change: 0, contacts_since_confirmed: 0 };
            whisker.rare.get_or_insert().pending_trim = Some(confirmed);
            self.call_trim(index, effects);
        } else {
            self.set_condition(index, Condition::Healthy, effects);
        }
    }
}

/// Doubt of a length.
struct Doubt {
    /// Standard deviation, mm.
    sd_mm: f64,
}

impl Doubt {
    /// The doubt of a length that may have lost or gained this, mm. `None` if that is within the least doubt.
    fn of(loss_mm: f64) -> Option<Self> {
        let sd_mm = DOUBT_SHARE * loss_mm.abs();
        (sd_mm >= DOUBT_SD_MM).then_some(Self { sd_mm })
    }

    /// The part of it that contacts and a measured length move the estimate within, mm.
    fn learned_sd_mm(&self) -> f64 {
        self.sd_mm.min(DOUBT_SD_MAX_MM)
    }
}

impl Whisker {
    /// Whether its length is certainly another one than while it was whole.
    fn is_cut(&self) -> bool {
        let length = self.filter.relative_length();
        self.sheet.length.mm() - length.length.mm() > LOSS_MIN_MM.max(LOSS_MIN_SD * length.sd_mm)
    }

    /// A loss of length is in doubt that may be as large as this, mm.
    pub(super) fn doubt_at_least(&mut self, loss_mm: f64) {
        self.filter.keep_doubt((DOUBT_SHARE * loss_mm).max(self.filter.least_sd_mm().into()));
    }

    /// A cut is confirmed: it explains what a suspicion before it has left open.
    pub(super) fn end_small_doubt(&mut self) {
        if f64::from(self.filter.least_sd_mm()) < DOUBT_SD_MM {
            self.filter.keep_doubt(0.0);
        }
    }

    /// Whether a loss of sensitivity was taken back, by its end or by a cut.
    pub(in crate::robot) fn has_doubtful_length(&self) -> bool {
        self.was_in_doubt() && self.filter.relative_length().sd_mm >= DOUBT_SD_MM
    }

    /// Whether a suspicion is that of [`Robot::doubt_length`]: the whisker has lost its response while whole, and no
    /// cut is confirmed.
    pub(in crate::robot) fn was_in_doubt(&self) -> bool {
        self.condition == Condition::Suspected
            && self.rare.whole_offset.is_some()
            && self.rare.pending_trim.is_none()
            && self.is_at_nominal_pressure()
    }

    /// Whether it is suspected only because its length was in doubt, and is not any more.
    pub(super) fn is_decided_after_doubt(&self) -> bool {
        self.was_in_doubt() && self.detector.is_calm() && self.rare.length_test.is_none() && !self.keeps_suspicion()
    }

    /// Takes in a length that was measured otherwise, and moves the offset with it, so that readings are predicted as
    /// before. False if no real whisker has that length.
    pub(in crate::robot) fn learn_measured_length(&mut self, length: Millimetre, sd_mm: f64) -> bool {
        let still = Wander { length_mm: 0.0, baseline_strain: 0.0, offset: 0.0 };
        let is_learned =
            self.filter.observe_length(&self.noise, length, sd_mm).is_some_and(|seen| self.filter.learn(&seen, still));
        if is_learned {
            self.filter.keep_doubt(0.0);
        }
        is_learned
    }
}
