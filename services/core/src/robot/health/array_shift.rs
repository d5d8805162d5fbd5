//! Changes common to an array: a mis-scaled deflection or another temperature, not a length.
//!
//! A single whisker cannot distinguish such a shift from a cut. So before a change is called, it is compared with the
//! contacts of the array's other healthy whiskers, and the majority decides: one whisker that was really cut, or never
//! touched, does not matter. A trim is delayed by the contacts that the others need to deny the shift: one or two for a
//! large cut.

use crate::detection::{Change, Fit, Others};
use crate::estimation::filter::LENGTH;
use crate::mechanics::Model;
use crate::robot::Robot;
use crate::robot::effect::{Condition, Effect, WhiskerIndex};
use crate::robot::params::Params;
use crate::robot::state::whisker::Unsteady;
use crate::units::ContactRatio;

/// With fewer others there is no majority.
const OTHERS_MIN: usize = 2;
/// Log likelihood ratio from which another whisker shows the shift, too. It is evaluated at every contact while the
/// suspicion lasts, so chance must not reach it.
const FEELS: f64 = 6.0;
/// A shift may be the beginning of a longer one, as a room warms up. For so many contacts each whisker's offset
/// follows, by a random walk of this share of the shift found; that costs sensitivity to small cuts meanwhile.
const UNSTEADY_CONTACTS: u32 = 1000;
pub(in crate::robot) const UNSTEADY_SHARE: f64 = 0.02;
/// Changes of one whisker up to this many times the shift are attributed to it meanwhile.
const REST_MAX: f64 = 1.5;
/// Relative difference that one shift may have between whiskers: their curves differ a little.
const ALIKE: f64 = 0.1;
/// Log likelihood ratio that its contacts after the alarm must promise before a whisker can deny the shift.
const DENIES: f64 = 8.0;

impl Robot {
    /// Whether the other healthy whiskers of the array show the change that this one suspects.
    pub(in crate::robot) fn others_feel(&self, index: WhiskerIndex) -> Others {
        let Some(own) = self.whiskers[index].detector.suspected_shift() else {
            return Others::Not;
        };
        let (mut others, mut feel, mut deny) = (0, 0, 0);
        for other in self.sound_whiskers_of(index).filter(|&other| other != index) {
            let whisker = &self.whiskers[other];
            others += 1;
            if whisker.detector.felt(own.size).is_some_and(|other| feels(&own, &other)) {
                feel += 1;
            } else if 0.5 * own.size.powi(2) * f64::from(whisker.told_since_alarm) >= DENIES {
                deny += 1;
            }
        }
        if others < OTHERS_MIN || 2 * deny > others {
            Others::Not
        } else if 2 * feel > others {
            Others::Too
        } else {
            Others::NotYet
        }
    }

    /// The whiskers of the same array that are learned and whole.
    fn sound_whiskers_of(&self, index: WhiskerIndex) -> impl Iterator<Item = WhiskerIndex> + '_ {
        let array = self.whiskers[index].array;
        let sound = move |&other: &WhiskerIndex| {
            let whisker = &self.whiskers[other];
            whisker.array == array
                && whisker.fault.is_none()
                && matches!(whisker.condition, Condition::Healthy | Condition::Suspected)
        };
        (0..self.whiskers.len()).filter(sound)
    }

    /// A whisker has raised an alarm: from now on the others' contacts count as answers to it.
    pub(in crate::robot) fn ask_others(&mut self, index: WhiskerIndex) {
        let array = self.whiskers[index].array;
        for index in 0..self.whiskers.len() {
            if self.whiskers[index].array == array {
                self.whiskers[index].told_since_alarm = 0.0;
            }
        }
    }

    /// Takes a shift of the whole array out: every whisker's offset is learned anew around it, and earlier measurements
    /// are brought to the same scale.
    pub(in crate::robot) fn shared_shift(
        &mut self,
        params: &Params,
        index: WhiskerIndex,
        change: &Change,
        effects: &mut Vec<Effect>,
    ) {
        let shift = self.median_shift(index, change.size);
        let array = self.whiskers[index].array;
        let members: Vec<WhiskerIndex> =
            (0..self.whiskers.len()).filter(|&other| self.whiskers[other].array == array).collect();
        for &member in &members {
            let whisker = &mut self.whiskers[member];
            let Some(model) = whisker.model(params) else { continue };
            let log_shift = shift * whisker.log_slope_with_length(model);
            whisker.take_out(log_shift);
            self.shift_measured(member, log_shift);
            if self.whiskers[member].condition == Condition::Suspected {
                self.set_condition(member, Condition::Healthy, effects);
            }
        }
        self.whiskers[index].shift_told = true;
    }

    /// Brings the measured responses of the compensations in which a whisker serves to another scale.
    pub(in crate::robot) fn shift_measured(&mut self, compensator: WhiskerIndex, log_shift: f64) {
        for running in self.head.compensations.iter_mut().filter(|one| one.compensator() == compensator) {
            running.after.shift(log_shift);
            running.refining.since_gain.shift(log_shift);
            if let Some(before) = &mut running.before {
                before.shift(log_shift);
            }
        }
    }

    /// The median shift of the whiskers, as the change of log length that would explain it.
    fn median_shift(&self, index: WhiskerIndex, own: f64) -> f64 {
        let others = self.sound_whiskers_of(index).filter(|&other| other != index);
        let mut felt: Vec<f64> =
            others.filter_map(|other| Some(self.whiskers[other].detector.felt(own)?.size)).collect();
        felt.push(own);
        felt.sort_by(f64::total_cmp);
        felt[felt.len() / 2]
    }
}

/// Whether another whisker shows a change of the same size as this one, within two standard deviations.
fn feels(own: &Fit, other: &Fit) -> bool {
    let sd = (own.variance + other.variance).sqrt();
    other.gain >= FEELS && (other.size - own.size).abs() <= 2.0 * sd + ALIKE * own.size.abs()
}

impl crate::robot::Whisker {
    /// d ln sensitivity / d ln length in the middle of the contact ratios; 0 where the model does not hold.
    pub(in crate::robot) fn log_slope_with_length(&self, model: &Model) -> f64 {
        let middle = ContactRatio::known(crate::mechanics::Offset::CENTRE);
        let length = self.filter.length().length;
        let morphology = model.morphology(self.air.setpoint);
        model
            .sensitivity_and_slope(middle, length, &morphology)
            .map_or(0.0, |(_, slope)| slope * length.mm() / (length.mm() + morphology.elongation_mm))
    }

    /// Whether a change may be the rest of the array's shift. Then it is taken out, too.
    pub(in crate::robot) fn is_rest_of_shift(&mut self, model: &Model, change: &Change) -> bool {
        let Some(unsteady) = self.rare.get_mut().and_then(|rare| rare.unsteady.take()) else { return false };
        let lacking = change.lacking[LENGTH].abs().max(1.0);
        let log_shift = change.size * lacking * self.log_slope_with_length(model);
        let rest = log_shift.abs() <= REST_MAX * unsteady.log_shift;
        if rest {
            self.take_out(log_shift);
        }
        self.rare.get_or_insert().unsteady = Some(unsteady);
        rest
    }

    fn take_out(&mut self, log_shift: f64) {
        self.filter.shared_shift(log_shift);
        self.rare.get_or_insert().unsteady =
            Some(Unsteady { log_shift: log_shift.abs(), contacts_left: UNSTEADY_CONTACTS });
        self.shift_reference(log_shift);
        self.detector = crate::detection::Detector::default();
    }

    /// Brings the response while whole to another scale.
    pub(in crate::robot) fn shift_reference(&mut self, log_shift: f64) {
        self.whole.shift(log_shift);
        if let Some(offset) = self.rare.get_mut().and_then(|rare| rare.whole_offset.as_mut()) {
            offset.level += log_shift;
        }
    }
}
