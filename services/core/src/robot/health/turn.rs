//! Changes that a turn of the contacts explains, where nobody states their angle.
//!
//! A gauge reads the cosine of the angle between a deflection and its plane. If contacts turn by up to a known angle, the log
//! sensitivity changes by up to -ln of its cosine. Up to there the readings cannot tell a turn from a cut, wear or a loss. So a
//! rise puts the length in doubt, with an interval over both explanations, and a touch test decides. A fall moves the
//! offset, as a wandering gain does. A larger change is called.

use crate::detection::{Change, HypothesisKind};
use crate::estimation::filter::{LENGTH, STATES};
use crate::mechanics::Offset;
use crate::robot::Robot;
use crate::robot::effect::{Effect, WhiskerIndex};
use crate::robot::params::Params;
use crate::robot::state::whisker::Whisker;

/// A change may exceed the largest one by this share, because people state a round angle, ...
const BEYOND_SHARE: f64 = 0.1;
/// ... and by so many of its standard deviations.
const BEYOND_SD: f64 = 3.0;

impl Whisker {
    /// Whether a turn explains a change: it is not too large, and does not lead too far from the response while whole.
    pub(super) fn may_have_turned(&self, params: &Params, change: &Change, turn_max: f64) -> bool {
        let is_other = change.kind == HypothesisKind::Drifting || self.rare.pending_trim.is_some();
        let Some(model) = self.model(params).filter(|_| turn_max > 0.0 && !is_other) else { return false };
        let (step, slope) = (change.as_step(), self.log_slope_with_length(model));
        let most = (1.0 + BEYOND_SHARE) * turn_max + BEYOND_SD * step.variance.sqrt() * slope.abs();
        let shift = step.size * slope;
        let now = self.filter.whole_offset();
        let after = Offset { level: now.level + step.size * step.lacking[0] + shift, ..now };
        shift.abs() <= most && (!self.is_at_nominal_pressure() || self.whole_lag(after).abs() <= most)
    }

    /// A change is called that is larger than any turn. A turn may be a part of it, or hide a part. So the interval of the length
    /// holds both. A former doubt is a part of the change.
    pub(super) fn exceeds_turn(&mut self, params: &Params, change: &Change, turn_max: f64) {
        let Some(model) = self.model(params).filter(|_| turn_max > 0.0) else { return };
        let (step, slope) = (change.as_step(), self.log_slope_with_length(model));
        if self.has_doubtful_length() {
            let now = self.filter.whole_offset();
            let risen = self.whole_lag(Offset { level: now.level + step.size * step.lacking[0], ..now });
            let mut direction = [0.0; STATES];
            (direction[0], direction[LENGTH]) = (1.0, -1.0 / slope);
            self.filter.jump(-risen.max(0.0), 0.0, direction);
        }
        self.doubt_at_least(turn_max / slope.abs() * self.filter.length().length.mm());
    }

    /// A length that is in doubt for a turn: the doubt follows the response as far as it rises above that while whole, also
    /// where nothing new is suspected.
    pub(super) fn follow_turn(&mut self, params: &Params, turn_max: f64) {
        let is_followed = turn_max > 0.0 && self.has_doubtful_length();
        let Some(model) = self.model(params).filter(|_| is_followed) else { return };
        let risen = self.whole_lag(self.filter.whole_offset());
        self.doubt_at_least(risen / self.log_slope_with_length(model).abs() * self.filter.length().length.mm());
    }
}

impl Robot {
    /// Takes a change in that is a turn of the contacts, or a cut, wear or a loss of the same size.
    pub(super) fn turned(
        &mut self,
        params: &Params,
        index: WhiskerIndex,
        (change, turn_max): (&Change, f64),
        effects: &mut Vec<Effect>,
    ) {
        let whisker = &self.whiskers[index];
        let Some(slope) = whisker.model(params).map(|model| whisker.log_slope_with_length(model)) else { return };
        let (step, length_mm) = (change.as_step(), whisker.filter.length().length.mm());
        let loss_mm = length_mm * (1.0 - step.size.exp());
        if loss_mm <= 0.0 {
            self.take_out(params, index, &step);
            self.end_suspicion(index, effects);
            return;
        }
        self.rescale(params, index, &step);
        let most_mm = length_mm * turn_max / slope.abs();
        if !self.doubt_further(params, index, (loss_mm, most_mm), effects) {
            self.end_suspicion(index, effects);
        }
    }
}
