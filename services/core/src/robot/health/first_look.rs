//! A whisker that may never have been as its factsheet says, or was cut while it was learned.
//!
//! Its offset from the model takes in a wrong length as well as a cut among the first contacts. Two sources tell of
//! them when it is learned: the offsets of the robot's other whiskers of the same model, and a step among its own contacts.
//! Neither tells a length from a gain. So the length is put in doubt, with an interval over both, and no pressure
//! changes for it.

use smallvec::SmallVec;

use crate::detection::Detector;
use crate::estimation::Innovation;
use crate::estimation::filter::LENGTH;
use crate::estimation::gain_walk::Moved;
use crate::mechanics::Offset;
use crate::robot::Robot;
use crate::robot::effect::{Condition, Effect, WhiskerIndex};
use crate::robot::params::Params;
use crate::robot::state::first_contacts::{BLOCK, Step};
use crate::robot::state::whisker::Whisker;

/// While the detector follows a change, it may call the change itself. From this contact on no look comes any more.
const LOOKED_UNTIL: u64 = 600;
/// First contacts that count: those before are the first loads of the rubber.
const EARLY_FROM: u64 = 3;
/// Rise of the log sensitivity among the first contacts that is no first load and no habit: 2 mm of 70.
const RISE_MIN: f64 = 0.06;
/// ... in standard deviations of the rise.
const RISE_SD: f64 = 5.0;
/// A change within a block shows in part only. The rise is larger by up to this share of the change, per block before it.
const HIDDEN: f64 = 0.5;
/// Other whiskers that an offset is compared with, at least.
const PEERS_MIN: usize = 3;
/// Contacts of each of them, at least.
const PEER_CONTACTS: u64 = 100;
/// Distance from the offsets of all others, log sensitivity, that no scatter of gauges and rubber explains: 3 mm of 70.
const APART_MIN: f64 = 0.075;
/// ... as a share of the others' range.
const APART_SHARE: f64 = 0.7;

/// A whisker differs from the others by more than this says, if it is at the edge of its batch.
const AT_EDGE: f64 = 1.25;

impl Whisker {
    /// Keeps what the contacts of a whisker tell while it is learned.
    pub(in crate::robot) fn follow_first(&mut self, seen: &Innovation) {
        if self.contacts < EARLY_FROM || seen.row[LENGTH] == 0.0 || self.condition != Condition::Learning {
            return;
        }
        let deviation = seen.residual + self.filter.whole_offset().at(seen.ratio);
        self.rare.get_or_insert().first.get_or_insert_default().add(seen.ratio.a(), deviation);
    }

    /// Whether it still has to be compared with the others of its model.
    pub(super) fn is_due_for_look(&self) -> bool {
        self.condition == Condition::Healthy && self.rare.first.is_some()
    }

    /// A rise among its first contacts that is no change which the detector follows. `None` if it is as it should be.
    fn rises(&self, params: &Params, is_followed: bool) -> Option<Step> {
        let step = self.rare.first.as_ref()?.step(self.filter.whole_offset().slope)?;
        let followed_from = params.detection.followed_from.saturating_sub(EARLY_FROM as u32) as usize;
        // The filter had absorbed a part of a change before the detector began to follow it.
        let is_told = !is_followed || step.contacts_before < followed_from;
        let is_rise = is_told && step.rise > RISE_MIN.max(RISE_SD * step.rise_sd);
        let hidden = HIDDEN * BLOCK as f64 / step.contacts_before as f64;
        is_rise.then_some(Step { rise: (1.0 + hidden) * step.rise, ..step })
    }

    /// Whether its offset tells how the whiskers of its model are.
    fn is_peer(&self) -> bool {
        matches!(self.condition, Condition::Learning | Condition::Healthy)
            && self.contacts >= PEER_CONTACTS
            && self.is_at_nominal_pressure()
            && self.fault.is_none()
    }
}

impl Robot {
    /// Excess of log sensitivity by which a whisker that is learned now differs from the other whiskers. `None` if it is
    /// as it should be.
    fn is_apart_by(&self, index: WhiskerIndex) -> Option<f64> {
        let whisker = &self.whiskers[index];
        let offset = whisker.filter.whole_offset();
        let is_alike = |other: &Whisker| {
            other.sheet.model == whisker.sheet.model
                && other.sheet.pressure == whisker.sheet.pressure
                && other.is_peer()
        };
        let others = self.whiskers.iter().enumerate().filter(|(at, other)| *at != index && is_alike(other));
        let mut levels: SmallVec<[f64; 32]> = others.map(|(_, other)| other.filter.whole_offset().level).collect();
        levels.sort_by(f64::total_cmp);
        let [least, .., most] = levels[..] else { return None };
        let beyond = (offset.level - most).max(least - offset.level);
        let is_apart = levels.len() >= PEERS_MIN && beyond > APART_MIN.max(APART_SHARE * (most - least));
        is_apart.then(|| AT_EDGE * (offset.level - levels[levels.len() / 2]))
    }

    /// A whisker is learned: puts its length in doubt if it has changed meanwhile, or differs from what its factsheet
    /// promises.
    pub(super) fn look_first(&mut self, params: &Params, index: WhiskerIndex, effects: &mut Vec<Effect>) {
        let whisker = &mut self.whiskers[index];
        let is_followed = !whisker.detector.has_little_doubt();
        let Some(step) = whisker.rises(params, is_followed) else {
            self.look_at_others(params, index, effects);
            return;
        };
        whisker.rare.forget_first();
        // The filter is far behind the step, which is noise to it.
        let by = step.level - whisker.filter.whole_offset().level;
        whisker.filter.wandered(Moved { by, variance: step.level_sd.powi(2) });
        whisker.detector = Detector::default();
        whisker.cannot_deny();
        let now = whisker.filter.whole_offset();
        self.doubt_first(params, index, step.rise, Offset { level: now.level - step.rise, ..now }, effects);
    }

    /// Puts the length of a whisker in doubt if it differs from the others of its model.
    pub(super) fn look_at_others(&mut self, params: &Params, index: WhiskerIndex, effects: &mut Vec<Effect>) {
        let whisker = &self.whiskers[index];
        let is_followed = !whisker.detector.has_little_doubt() || whisker.rare.pending_trim.is_some();
        if is_followed && whisker.contacts < LOOKED_UNTIL {
            return;
        }
        let apart = self.is_apart_by(index).filter(|_| !is_followed);
        let whisker = &mut self.whiskers[index];
        whisker.rare.forget_first();
        let whole = whisker.filter.whole_offset();
        if let Some(by) = apart {
            self.doubt_first(params, index, by, whole, effects);
        }
    }

    /// The log sensitivity of a whisker is higher by this than it should be, which is its length or its gain. `whole` is its
    /// offset while whole.
    fn doubt_first(&mut self, params: &Params, index: WhiskerIndex, by: f64, whole: Offset, effects: &mut Vec<Effect>) {
        let whisker = &self.whiskers[index];
        let Some(model) = whisker.model(params).filter(|_| whisker.is_at_nominal_pressure()) else { return };
        let length_mm = whisker.filter.length().length.mm();
        let loss_mm = -by / whisker.log_slope_with_length(model) * length_mm;
        self.doubt_whole(params, index, (loss_mm, whole), effects);
    }
}
