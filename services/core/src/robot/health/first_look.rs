//! A whisker that may never have been as its factsheet says, or was cut while it was learned.
//!
//! Its offset from the model takes in a wrong length as well as a cut among the first contacts. Two sources tell of
//! them when it is learned: the offsets of the robot's other whiskers of the same model, and its own first contacts.
//! Neither tells a length from a gain. So the length is put in doubt, with an interval over both, and no pressure
//! changes for it.

use smallvec::SmallVec;

use crate::estimation::Innovation;
use crate::estimation::filter::LENGTH;
use crate::robot::Robot;
use crate::robot::effect::{Condition, Effect, WhiskerIndex};
use crate::robot::params::Params;
use crate::robot::state::first_contacts::EARLY_CONTACTS;
use crate::robot::state::whisker::Whisker;

/// The last look at the first contacts comes at this one: by then the level has nearly all of a cut while it was learned.
const LAST_LOOK: u64 = 300;
/// While the detector follows a change, it may call the change itself. From this contact on the first ones are forgotten.
const LOOKED_UNTIL: u64 = 600;
/// First contacts that count: those before are the first loads of the rubber.
const EARLY_FROM: u64 = 3;
/// Rise of the log sensitivity since the first contacts that is no first load and no habit: 2 mm of 70.
const RISE_MIN: f64 = 0.06;
/// ... in standard deviations of the mean of the first contacts, if their errors were independent. A late cut is in the noise
/// that is learned, and an early one in the scatter of the first contacts. So the smaller of the two counts.
const RISE_SD: f64 = 6.0;
/// Other whiskers that an offset is compared with, at least.
const PEERS_MIN: usize = 3;
/// Contacts of each of them, at least.
const PEER_CONTACTS: u64 = 100;
/// Distance from the offsets of all others, log sensitivity, that no scatter of gauges and rubber explains: 3 mm of 70.
const APART_MIN: f64 = 0.075;
/// ... as a share of the others' range.
const APART_SHARE: f64 = 0.7;

/// A part of a rise is hidden, because the contacts before it count, too: those after it show at least this much less.
const DILUTED: f64 = 1.5;
/// A whisker differs from the others by more than this says, if it is at the edge of its batch.
const AT_EDGE: f64 = 1.25;

impl Whisker {
    /// Keeps what the first contacts of a whisker tell while it is learned.
    pub(in crate::robot) fn follow_first(&mut self, seen: &Innovation) {
        let is_early = (EARLY_FROM..EARLY_FROM + u64::from(EARLY_CONTACTS)).contains(&self.contacts);
        if !is_early || seen.row[LENGTH] == 0.0 || self.condition != Condition::Learning {
            return;
        }
        let deviation = seen.residual + self.filter.whole_offset().at(seen.ratio);
        self.rare.get_or_insert().first.get_or_insert_default().add(seen.ratio, deviation);
    }

    /// Whether its first contacts still have to be compared with the level that was learned.
    pub(super) fn is_due_for_last_look(&self) -> bool {
        self.condition == Condition::Healthy && self.contacts >= LAST_LOOK && self.rare.first.is_some()
    }

    /// Excess of log sensitivity over its own first contacts. `None` if it is as it should be.
    fn rises_by(&self, params: &Params) -> Option<f64> {
        let (rise, scatter) = self.rare.first?.rise_to(self.filter.whole_offset())?;
        let noise = self.contact_log_sd(params).powi(2);
        let sd = (noise.min(scatter) / f64::from(EARLY_CONTACTS)).sqrt();
        // Of a cut among them a share f of the rise is in their mean, and f (1 - f) of its square in their scatter.
        let whole = rise + (scatter - noise).max(0.0) / rise;
        (rise > RISE_MIN.max(RISE_SD * sd)).then_some(DILUTED * whole)
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

    /// Puts the length of a whisker that was learned in doubt, if it differs from what its factsheet promises.
    pub(super) fn look_first(&mut self, params: &Params, index: WhiskerIndex, effects: &mut Vec<Effect>) {
        let whisker = &self.whiskers[index];
        let is_last = whisker.contacts >= LAST_LOOK;
        let is_followed = !whisker.detector.has_little_doubt() || whisker.rare.pending_trim.is_some();
        if is_followed && whisker.contacts < LOOKED_UNTIL {
            return;
        }
        let own = whisker.rises_by(params);
        let differs = own.or_else(|| if is_last { None } else { self.is_apart_by(index) }).filter(|_| !is_followed);
        let whisker = &mut self.whiskers[index];
        if is_last || differs.is_some() {
            whisker.rare.forget_first();
        }
        let Some((by, model)) = differs.zip(whisker.model(params)) else { return };
        let length_mm = whisker.filter.length().length.mm();
        let loss_mm = -by / whisker.log_slope_with_length(model) * length_mm;
        if whisker.is_at_nominal_pressure() {
            self.doubt_whole(params, index, loss_mm, effects);
        }
    }
}
