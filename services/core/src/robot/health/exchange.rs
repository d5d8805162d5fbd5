//! Two whiskers of a robot whose cables were exchanged: each reads as the other one did.
//!
//! A whisker alone shows a cut, or a loss of sensitivity. With exchanged cables the other one shows the opposite at the same
//! time, and both changes are the difference between what the two have learned. Two such coincidences by chance are less
//! likely than the error of maintenance. Then no trim is called: both are suspected, at their lengths before, and read the
//! present response as their own. If the cables are put right, the same happens the other way round, and the suspicion ends.

use borsh::{BorshDeserialize, BorshSerialize};

use crate::detection::Change;
use crate::estimation::filter::{LENGTH, STATES};
use crate::mechanics::Offset;
use crate::robot::Robot;
use crate::robot::effect::{Condition, Effect, WhiskerIndex};
use crate::robot::health::misfit::Cause;
use crate::robot::params::Params;
use crate::robot::state::whisker::Whisker;
use crate::units::{ContactRatio, Millimetre};

/// Least difference between two whiskers that can be told from noise, log sensitivity: calibrations differ by less.
const DIFFERENCE_MIN: f64 = 0.08;
/// A change may be off the expected one by this, by this share of it, and by two standard deviations, up to a bound.
const OFF_MAX: f64 = 0.012;
const OFF_SHARE: f64 = 0.15;
const OFF_SD_MAX: f64 = 0.04;
/// Log likelihood ratio from which a change counts that is not called yet.
const FELT: f64 = 3.0;
/// The same that lets a cut wait, for at most so many contacts.
const MAY_BE_FELT: f64 = 1.0;
const WAITS: u64 = 60;
/// A change of another whisker belongs to one of this whisker if it had at most this many contacts since.
const CONTACTS_APART: u64 = 150;
/// Most changes that are remembered.
const CHANGES_MAX: usize = 8;

/// A change of sensitivity that was called.
#[derive(Debug, Clone, Copy, PartialEq, BorshSerialize, BorshDeserialize)]
pub(in crate::robot) struct CalledChange {
    whisker: u32,
    /// Contacts of the whisker when it was called.
    contacts: u64,
    seen: Seen,
    /// Change of log length as which it was taken; 0 if it was taken as a loss of sensitivity.
    as_length: f32,
}

/// A change of one whisker's response.
#[derive(Debug, Clone, Copy, PartialEq, BorshSerialize, BorshDeserialize)]
struct Seen {
    /// Response before, log sensitivity at the middle contact ratio.
    before: f32,
    shift: f32,
    sd: f32,
}

impl Seen {
    /// Whether it leads to the response of another whisker.
    fn leads_to(&self, other: &Self) -> bool {
        let [before, shift, sd] = [self.before, self.shift, self.sd].map(f64::from);
        let expected = f64::from(other.before) - before;
        let off_max = OFF_MAX + OFF_SHARE * expected.abs() + (2.0 * sd).min(OFF_SD_MAX);
        expected.abs() >= DIFFERENCE_MIN && (shift - expected).abs() <= off_max
    }

    /// Whether each leads to the response of the other.
    fn fits(&self, other: &Self) -> bool {
        self.leads_to(other) && other.leads_to(self)
    }
}

/// What another whisker shows of an exchange.
enum Half {
    /// A change that was called.
    Called(CalledChange),
    /// A change that is felt only.
    Felt(Seen, Change),
}

impl Half {
    fn seen(&self) -> Seen {
        match self {
            Self::Called(called) => called.seen,
            Self::Felt(seen, _) => *seen,
        }
    }
}

impl Robot {
    /// Whether a change of a whisker is one half of an exchange of cables. Then both halves are taken out.
    pub(super) fn is_exchange(
        &mut self,
        params: &Params,
        index: WhiskerIndex,
        change: &Change,
        effects: &mut Vec<Effect>,
    ) -> bool {
        let Some(own) = self.whiskers[index].seen(params, change) else { return false };
        let found = (0..self.whiskers.len()).filter(|&other| other != index).find_map(|other| {
            let half = self.other_half(params, other, change.size)?;
            own.fits(&half.seen()).then_some((other, half))
        });
        let Some((other, half)) = found else {
            self.note_change(index, own, change);
            return false;
        };
        self.rescale(params, index, change);
        match half {
            Half::Called(called) => self.take_back_length(params, other, called.as_length.into()),
            Half::Felt(_, felt) => self.rescale(params, other, &felt),
        }
        self.whiskers[other].detector = crate::detection::Detector::default();
        self.whiskers[other].cannot_deny();
        self.head.called_changes.retain(|one| ![index, other].contains(&(one.whisker as usize)));
        let is_put_right = [index, other].iter().all(|&one| self.misfit(one) == Some(Cause::CablesExchanged));
        for one in [index, other] {
            if is_put_right {
                self.forget_misfit(one);
                self.set_condition(one, Condition::Healthy, effects);
            } else {
                self.name_cause(one, Cause::CablesExchanged);
                self.set_condition(one, Condition::Suspected, effects);
            }
        }
        true
    }

    /// Whether a cut that was called may be one half of an exchange, of which the other whisker does not show enough yet.
    pub(super) fn may_be_exchanged(&self, params: &Params, index: WhiskerIndex) -> bool {
        let Some(own) = self.called_change(index, WAITS) else { return false };
        let is_other = |&other: &WhiskerIndex| other != index && self.called_change(other, CONTACTS_APART).is_none();
        (0..self.whiskers.len()).filter(is_other).any(|other| {
            let felt = self.whiskers[other].felt_opposite(params, own.as_length.into(), MAY_BE_FELT);
            felt.is_some_and(|(seen, _)| own.seen.fits(&seen))
        })
    }

    /// A change of another whisker, opposite to one of this size.
    fn other_half(&self, params: &Params, other: WhiskerIndex, size: f64) -> Option<Half> {
        match self.called_change(other, CONTACTS_APART) {
            Some(called) => Some(Half::Called(called)).filter(|_| f64::from(called.seen.shift) * size > 0.0),
            // Shortly after a change was called, its rest may look like the opposite.
            None => {
                self.whiskers[other].felt_opposite(params, size, FELT).map(|(seen, change)| Half::Felt(seen, change))
            }
        }
    }

    /// A change of a whisker that was called at most so many of its contacts ago.
    fn called_change(&self, whisker: WhiskerIndex, within: u64) -> Option<CalledChange> {
        let contacts = self.whiskers[whisker].contacts;
        let is_recent =
            |one: &&CalledChange| one.whisker as usize == whisker && contacts.saturating_sub(one.contacts) <= within;
        self.head.called_changes.iter().rev().find(is_recent).copied()
    }

    /// The readings of a whisker are learned anew: its changes belong to the past.
    pub(in crate::robot) fn forget_called_changes(&mut self, index: WhiskerIndex) {
        self.head.called_changes.retain(|one| one.whisker as usize != index);
    }

    fn note_change(&mut self, index: WhiskerIndex, seen: Seen, change: &Change) {
        let contacts = self.whiskers[index].contacts;
        let as_length = if change.size < 0.0 { change.size as f32 } else { 0.0 };
        if self.head.called_changes.len() >= CHANGES_MAX {
            self.head.called_changes.remove(0);
        }
        self.head.called_changes.push(CalledChange { whisker: index as u32, contacts, seen, as_length });
    }

    /// Takes a called change back that was no cut: the offset moves instead of the length.
    fn take_back_length(&mut self, params: &Params, index: WhiskerIndex, as_length: f64) {
        let whisker = &mut self.whiskers[index];
        if let Some(rare) = whisker.rare.get_mut() {
            rare.pending_trim = None;
        }
        let Some(model) = whisker.model(params) else { return };
        let log_shift = as_length * whisker.log_slope_with_length(model);
        whisker.filter.rescaled(as_length, [0.0; STATES], log_shift, log_shift);
        self.shift_measured(index, log_shift);
    }
}

impl Whisker {
    /// A change of its response, with the response before.
    fn seen(&self, params: &Params, change: &Change) -> Option<Seen> {
        let model = self.model(params)?;
        let slope = self.log_slope_with_length(model);
        let lacking = change.lacking;
        let log_length = self.filter.log_length() - (1.0 - lacking[LENGTH]) * change.size;
        let length = Millimetre::new(self.sheet.length.mm() * log_length.exp()).ok()?;
        let middle = ContactRatio::known(Offset::CENTRE);
        let per_mm = model.sensitivity_per_mm(middle, length, &model.morphology(self.air.setpoint)).ok()?;
        let before = per_mm.ln() + self.filter.offset().level + lacking[0] * change.size;
        let sd = change.variance.sqrt() * slope.abs();
        Some(Seen { before: before as f32, shift: (change.size * slope) as f32, sd: sd as f32 })
    }

    /// A change that it feels with at least this log likelihood ratio, and that nobody has called yet, opposite to one of this
    /// size.
    fn felt_opposite(&self, params: &Params, size: f64, least: f64) -> Option<(Seen, Change)> {
        let gain = |like: f64| self.detector.felt(like).map_or(0.0, |fit| fit.gain);
        if gain(-size) < least.max(gain(size)) {
            return None;
        }
        let felt = self.detector.felt_change(-size)?;
        Some((self.seen(params, &felt)?, felt))
    }
}
