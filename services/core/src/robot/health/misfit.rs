//! Readings that the calibration of a whisker does not fit any more, and errors of maintenance that explain them.
//!
//! - **Residual.** The length filter follows a change, and the detector suspects one. If neither does, and readings stay off
//!   nevertheless, the calibration does not fit the whisker. The mean residual of some 25 contacts decides.
//! - **Reversed gauge.** Strong contacts read strains below zero, one after the other.
//! - **Replaced whisker.** A cut whisker reads like a whole one again: somebody has replaced it, and has not told so.
//! - **Exchanged cables.** Two whiskers of a robot change at once, and each reads as the other one did: [`super::exchange`].
//!
//! The last two change the readings as a cut or a loss of sensitivity would. While they are in doubt, no setpoint goes out.
//! An operator confirms by an action: REPLACED, or REBASELINE of each whisker.

use borsh::{BorshDeserialize, BorshSerialize};

use crate::detection::Change;
use crate::estimation::filter::LENGTH;
use crate::robot::Robot;
use crate::robot::effect::{AlarmKind, Condition, ContactUse, WhiskerIndex};
use crate::robot::state::whisker::Whisker;

/// A mean residual above this is too large, log strain: 5 %.
const RESIDUAL_MAX: f32 = 0.05;
/// The alarm ends below this share of it.
const ENDED_SHARE: f32 = 0.5;
/// Number of contacts that the means remember, and number in a row for which they must be off, or fit again.
const MEMORY: f32 = 25.0;
const STANDING: u8 = 45;
/// The mean must be off by this many of its standard deviations, with noise that hangs together for some contacts.
const SDS: f32 = 3.0;
/// Residuals beyond this count as this.
const RESIDUAL_BOUND: f32 = 1.0;
/// Strong contacts in a row with a strain below zero.
const NEGATIVES: u8 = 20;
/// Length that a new whisker seems to have may be off the whole one by this share of what the old one had lost.
const WHOLE_WITHIN: f64 = 0.25;

/// Likeliest cause of readings that do not fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, BorshSerialize, BorshDeserialize)]
pub(in crate::robot) enum Cause {
    /// None of the others.
    Unknown,
    /// The cables of this whisker and another one were exchanged.
    CablesExchanged,
    /// The gauge has the wrong polarity.
    GaugeReversed,
    /// There is another whisker in its place.
    WhiskerReplaced,
}

impl From<Cause> for AlarmKind {
    fn from(cause: Cause) -> Self {
        match cause {
            Cause::Unknown => Self::ModelMisfit,
            Cause::CablesExchanged => Self::CablesExchanged,
            Cause::GaugeReversed => Self::GaugeReversed,
            Cause::WhiskerReplaced => Self::WhiskerReplaced,
        }
    }
}

/// How the newest contacts of one whisker fit.
#[derive(Debug, Clone, Copy, PartialEq, Default, BorshSerialize, BorshDeserialize)]
pub(in crate::robot) struct MisfitWatch {
    /// Fading means of the residual and of its square.
    mean: f32,
    square: f32,
    /// Contacts in the means, up to [`MEMORY`].
    contacts: u8,
    /// Contacts in a row for which the mean was off, or fits again.
    standing: u8,
    /// Contacts in a row with a strain below zero.
    negatives: u8,
    pub cause: Option<Cause>,
}

crate::optional_parts::optional_fields!(MisfitWatch: mean, square, contacts;
    standing: *standing > 0,
    negatives: *negatives > 0,
    cause: cause.is_some(),
);

impl MisfitWatch {
    fn take(&mut self, residual: f64, is_explained: bool) {
        let residual = (residual as f32).clamp(-RESIDUAL_BOUND, RESIDUAL_BOUND);
        self.contacts = self.contacts.saturating_add(1).min(MEMORY as u8);
        let share = 1.0 / f32::from(self.contacts);
        self.mean += share * (residual - self.mean);
        self.square += share * (residual.powi(2) - self.square);
        self.negatives = self.negatives.saturating_sub(2);
        if self.negatives == 0 && self.cause == Some(Cause::GaugeReversed) {
            self.cause = None;
        }
        let turns = match self.cause {
            None => self.is_off() && !is_explained,
            Some(Cause::Unknown) => is_explained || self.mean.abs() < ENDED_SHARE * RESIDUAL_MAX,
            Some(Cause::CablesExchanged | Cause::GaugeReversed | Cause::WhiskerReplaced) => false,
        };
        self.standing = if turns { self.standing.saturating_add(1) } else { 0 };
        if self.standing >= STANDING {
            self.standing = 0;
            self.cause = if self.cause.is_none() { Some(Cause::Unknown) } else { None };
        }
    }

    fn is_off(&self) -> bool {
        let variance = (self.square - self.mean.powi(2)).max(0.0);
        let sd = (variance / f32::from(self.contacts.max(1))).sqrt();
        f32::from(self.contacts) >= MEMORY && self.mean.abs() - SDS * sd > RESIDUAL_MAX
    }

    fn take_negative(&mut self) {
        self.negatives = self.negatives.saturating_add(1).min(NEGATIVES);
        if self.negatives == NEGATIVES && self.cause.is_none_or(|cause| cause == Cause::Unknown) {
            self.cause = Some(Cause::GaugeReversed);
        }
    }
}

impl Robot {
    /// Takes in how a contact fitted.
    pub(super) fn watch_misfit(&mut self, index: WhiskerIndex, used: ContactUse, residual: Option<f64>) {
        let whisker = &self.whiskers[index];
        let is_explained = whisker.is_explained();
        let is_learned = whisker.condition != Condition::Learning;
        match (used, residual) {
            (ContactUse::NegativeStrain, _) => self.misfit_of(index).take_negative(),
            (ContactUse::Used, Some(residual)) if is_learned => self.misfit_of(index).take(residual, is_explained),
            _ => {}
        }
    }

    fn misfit_of(&mut self, index: WhiskerIndex) -> &mut MisfitWatch {
        let whiskers = self.whiskers.len();
        if self.head.misfits.len() < whiskers {
            self.head.misfits.resize(whiskers, MisfitWatch::default());
        }
        &mut self.head.misfits[index]
    }

    /// The likeliest cause of readings that do not fit.
    pub(in crate::robot) fn misfit(&self, index: WhiskerIndex) -> Option<Cause> {
        self.head.misfits.get(index).and_then(|one| one.cause)
    }

    /// Whether the readings are in doubt until an operator acts.
    pub(in crate::robot) fn awaits_confirmation(&self, index: WhiskerIndex) -> bool {
        matches!(self.misfit(index), Some(Cause::CablesExchanged | Cause::WhiskerReplaced))
    }

    /// Names the cause of readings that do not fit.
    pub(super) fn name_cause(&mut self, index: WhiskerIndex, cause: Cause) {
        self.misfit_of(index).cause = Some(cause);
        self.head.undecided = true;
    }

    /// The readings of a whisker are learned anew, or its cause is gone.
    pub(in crate::robot) fn forget_misfit(&mut self, index: WhiskerIndex) {
        if self.head.misfits.get(index).is_some_and(|one| *one != MisfitWatch::default()) {
            self.head.misfits[index] = MisfitWatch::default();
            self.head.undecided = true;
        }
        self.forget_called_changes(index);
    }
}

impl Whisker {
    /// Whether something is known or looked for that explains a residual.
    fn is_explained(&self) -> bool {
        matches!(self.condition, Condition::Suspected | Condition::Eroding)
            || self.rare.pending_trim.is_some()
            || self.rare.length_test.is_some()
    }

    /// Whether a loss of sensitivity leads a cut whisker back to its whole length.
    pub(super) fn reads_like_whole(&self, change: &Change) -> bool {
        // The filter has absorbed a part of the change already.
        let lacks = change.lacking[LENGTH];
        let (before, after) =
            (self.filter.log_length() - (1.0 - lacks) * change.size, self.filter.log_length() + lacks * change.size);
        let off_max = WHOLE_WITHIN * before.abs() + 2.0 * change.variance.sqrt();
        self.condition == Condition::Trimmed && before < 0.0 && after.abs() <= off_max
    }
}
