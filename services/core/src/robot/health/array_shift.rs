//! Changes common to an array: a mis-scaled deflection or another temperature, not a length.
//!
//! A single whisker cannot distinguish such a shift from a cut. So before a change is called, it is compared with the
//! contacts of the array's other whiskers. All that can tell must feel a shift: one that denies it makes each whisker be
//! judged alone, as several whiskers may be cut at once. Cut whiskers are witnesses, too, and eroding ones cannot deny. A
//! whisker that is not touched does not matter. A trim is delayed by the contacts that one of the others needs to deny
//! the shift: one or two for a large cut.

use smallvec::SmallVec;

use crate::detection::{Change, Detector, Fit, Others};
use crate::estimation::filter::LENGTH;
use crate::mechanics::Model;
use crate::robot::Robot;
use crate::robot::effect::{Condition, Effect, WhiskerIndex};
use crate::robot::params::Params;
use crate::robot::state::rare_state::Unsteady;
use crate::robot::state::whisker::Whisker;
use crate::units::ContactRatio;

/// With fewer others nothing is attributed to the array.
const OTHERS_MIN: usize = 2;
/// Log likelihood ratio from which another whisker shows the shift, too. It is evaluated at every contact while the
/// suspicion lasts, so chance must not reach it.
const FEELS: f64 = 6.0;
/// Largest rise of sensitivity that temperature or a scale can explain, in log sensitivity: 10 %. A cut of 5 mm makes at
/// least 15 %. No cut makes a fall, so that a fall of any size may be a shift.
const SHIFT_MAX: f64 = 0.095;
/// A shift may be the beginning of a longer one, as a room warms up. For so many contacts each whisker's offset
/// follows, by a random walk of this share of the shift found; that costs sensitivity to small cuts meanwhile.
const UNSTEADY_CONTACTS: u32 = 1000;
pub(in crate::robot) const UNSTEADY_SHARE: f64 = 0.02;
/// Standard deviation of the share of a shift that is a whisker's own change: whiskers age together, and one that tells nothing
/// is taken to shift with the others. With 0 the 95 % interval of a measured error holds the truth in 91 % of the cases
/// if whiskers age by 10 % in 10,000 contacts; with 0.3 in 96 %, with 0.5 in 98 %.
const OWN_SHARE_SD: f64 = 0.4;
/// Changes of one whisker up to this many times the shift are attributed to it meanwhile.
const REST_MAX: f64 = 1.5;
/// Relative difference that one shift may have between whiskers: their curves differ a little.
const ALIKE: f64 = 0.1;
/// Log likelihood ratio that its contacts after the alarm must promise before a whisker can deny the shift. A whisker
/// with the shift then shows less than half of it with a probability of 0.4 %.
const DENIES: f64 = 14.0;
/// The same before it can doubt the shift, with a probability of 6 % if it has it. Two whiskers and a quarter of them
/// deny it together.
const DOUBTS: f64 = 5.0;
/// Difference of size by which another whisker shows another change: relative, besides three standard deviations. A
/// start that is fitted too early halves the size.
const ANOTHER: f64 = 0.5;
/// Log likelihood ratio that the whisker's own contacts after the last alarm promise, up to which it waits for others
/// that cannot tell yet: three times what an answer takes, and half of that for others that were not touched at all.
/// Those that are touched less often are ignored.
const WAITS: f64 = 3.0 * DENIES;
const WAITS_FOR_SILENT: f64 = 1.5 * DENIES;
/// Information since the last alarm of a whisker whose filter has absorbed too much of a change to deny it.
pub(in crate::robot) const ABSORBED: f32 = -1.0;
/// The same of a whisker whose detector has begun anew since: it is no witness before the next alarm.
const BEGUN_ANEW: f32 = -2.0;

/// Answer of another whisker to a suspected shift of the array.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Testimony {
    Feels(Fit),
    Denies,
    Doubts,
    Unclear,
}

/// Mean of the changes that several whiskers show, weighted by their information.
#[derive(Debug, Clone, Copy, Default)]
struct Pooled {
    information: f64,
    sum: f64,
}

impl Pooled {
    fn add(&mut self, fit: &Fit) {
        self.information += 1.0 / fit.variance;
        self.sum += fit.size / fit.variance;
    }

    /// The mean, nearer to zero or beyond it by two standard deviations for a loss of length.
    fn least(&self) -> f64 {
        self.sum / self.information + 2.0 / self.information.sqrt()
    }
}

impl Robot {
    /// Whether the other whiskers of the array show the change that this one suspects: all that can tell must.
    pub(in crate::robot) fn others_feel(&self, params: &Params, index: WhiskerIndex) -> Others {
        let one = &self.whiskers[index];
        let Some((own, model)) = one.detector.suspected_shift().zip(one.model(params)) else {
            return Others::Not;
        };
        // Its own filter has absorbed too much: waiting would tell no more.
        let promised = if one.told_since_alarm < 0.0 { f64::INFINITY } else { one.promised(&own) };
        let (mut others, mut silent, mut feel) = (0_usize, 0, 0);
        let (mut doubts, mut waits, mut all) = (0, false, Pooled::default());
        for other in self.witnesses_of(index) {
            let reported = self.whiskers[other].told_since_alarm;
            others += 1;
            let answer = self.whiskers[other].answer(&own);
            doubts += usize::from(answer == Testimony::Doubts);
            match answer {
                Testimony::Feels(felt) => {
                    feel += 1;
                    all.add(&felt);
                }
                Testimony::Denies => return Others::Not,
                Testimony::Unclear | Testimony::Doubts if reported == BEGUN_ANEW => others -= 1,
                // It can only feel.
                Testimony::Unclear if !self.whiskers[other].can_deny() => silent += 1,
                Testimony::Unclear | Testimony::Doubts if reported == ABSORBED => {}
                Testimony::Unclear | Testimony::Doubts if reported == 0.0 => {
                    silent += 1;
                    waits |= promised < WAITS_FOR_SILENT;
                }
                Testimony::Unclear | Testimony::Doubts => waits |= promised < WAITS,
            }
        }
        all.add(&own);
        let is_beyond = feel > 0 && all.least() * -one.log_slope_with_length(model).abs() > SHIFT_MAX;
        let is_denied = doubts >= others.div_ceil(4).max(2);
        if others < OTHERS_MIN || is_beyond || is_denied {
            Others::Not
        } else if waits {
            Others::NotYet
        } else if 2 * feel > others - silent {
            Others::Too
        } else {
            Others::Not
        }
    }

    /// The whiskers that share temperature and scale with one: those of its array, or of the robot if the array is too
    /// small to tell.
    fn group_of(&self, index: WhiskerIndex) -> impl Iterator<Item = WhiskerIndex> + use<> {
        let array = self.whiskers[index].array;
        let of_array = move |other: &WhiskerIndex, all: &[Whisker]| all[*other].array == array;
        let members = (0..self.whiskers.len()).filter(|other| of_array(other, &self.whiskers)).count();
        let group: SmallVec<[WhiskerIndex; 32]> =
            (0..self.whiskers.len()).filter(|other| members <= OTHERS_MIN || of_array(other, &self.whiskers)).collect();
        group.into_iter()
    }

    /// The other whiskers of the group that are learned and without a fault.
    fn witnesses_of(&self, index: WhiskerIndex) -> impl Iterator<Item = WhiskerIndex> + '_ {
        let can_tell = move |&other: &WhiskerIndex| {
            let whisker = &self.whiskers[other];
            other != index && whisker.fault.is_none() && whisker.condition != Condition::Learning
        };
        self.group_of(index).filter(can_tell)
    }

    /// A whisker has raised an alarm: from now on the others' contacts count as answers to it.
    pub(in crate::robot) fn ask_others(&mut self, index: WhiskerIndex) {
        for index in self.group_of(index) {
            self.whiskers[index].told_since_alarm = 0.0;
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
        let shift = self.median_shift(index, change);
        let median = Fit { size: shift, variance: change.variance, gain: 0.0 };
        for member in self.group_of(index) {
            let whisker = &mut self.whiskers[member];
            let Some(model) = whisker.model(params) else { continue };
            let log_shift = shift * whisker.log_slope_with_length(model);
            let feels = whisker.detector.felt(shift).is_some_and(|felt| feels(&median, &felt));
            match whisker.detector.felt_change(shift).filter(|_| feels) {
                Some(felt) => whisker.take_out_felt(model, &felt, log_shift),
                None => whisker.take_out(log_shift),
            }
            self.shift_measured(member, log_shift);
            self.end_suspicion(member, effects);
        }
        self.whiskers[index].shift_told = true;
    }

    /// Brings the measured responses of the compensations in which a whisker serves to another scale.
    pub(in crate::robot) fn shift_measured(&mut self, compensator: WhiskerIndex, log_shift: f64) {
        for running in self.head.compensations.iter_mut().filter(|one| one.compensator() == compensator) {
            running.after.shift(log_shift);
            running.refining.shift(log_shift);
            if let Some(before) = &mut running.before {
                before.shift(log_shift);
            }
        }
    }

    /// The median shift of the whiskers that feel it, as the change of log length that would explain it.
    fn median_shift(&self, index: WhiskerIndex, change: &Change) -> f64 {
        let own = Fit { size: change.size, variance: change.variance, gain: 0.0 };
        let felt = |other: WhiskerIndex| {
            self.whiskers[other].detector.felt(own.size).filter(|felt| feels(&own, felt)).map(|felt| felt.size)
        };
        let mut felt: Vec<f64> = self.witnesses_of(index).filter_map(felt).collect();
        felt.push(own.size);
        felt.sort_by(f64::total_cmp);
        felt[felt.len() / 2]
    }
}

/// Whether another whisker shows a change of the same size as this one, within two standard deviations.
fn feels(own: &Fit, other: &Fit) -> bool {
    let sd = (own.variance + other.variance).sqrt();
    other.gain >= FEELS && (other.size - own.size).abs() <= 2.0 * sd + ALIKE * own.size.abs()
}

impl Whisker {
    /// Answer to a change that another whisker of its array suspects.
    fn answer(&self, own: &Fit) -> Testimony {
        let felt = self.detector.felt(own.size);
        if let Some(felt) = felt.filter(|felt| feels(own, felt)) {
            return Testimony::Feels(felt);
        }
        let shows_another = |felt: &Fit| {
            let sd = (own.variance + felt.variance).sqrt();
            (felt.size - own.size).abs() > 3.0 * sd + ANOTHER * own.size.abs()
        };
        let promised = self.promised(own);
        // At half the size of the change, the log likelihood gain is a quarter.
        let is_weak = |felt: &Fit| felt.gain < FEELS.min(0.25 * promised);
        let is_another = felt.is_none_or(|felt| is_weak(&felt) || shows_another(&felt));
        if !is_another || !self.can_deny() || promised < DOUBTS {
            Testimony::Unclear
        } else if promised < DENIES {
            Testimony::Doubts
        } else {
            Testimony::Denies
        }
    }

    /// The filter of an eroding or unsteady whisker follows each change.
    fn can_deny(&self) -> bool {
        self.condition != Condition::Eroding && self.rare.unsteady.is_none()
    }

    /// Log likelihood ratio that its contacts since the last alarm in its array promise for a change.
    fn promised(&self, own: &Fit) -> f64 {
        0.5 * own.size.powi(2) * f64::from(self.told_since_alarm)
    }

    /// Its detector has begun anew: contacts before the next alarm in its array cannot deny a change.
    pub(in crate::robot) fn cannot_deny(&mut self) {
        self.told_since_alarm = BEGUN_ANEW;
    }

    /// d ln sensitivity / d ln length in the middle of the contact ratios; 0 where the model does not hold.
    pub(in crate::robot) fn log_slope_with_length(&self, model: &Model) -> f64 {
        self.log_slope_at(model, ContactRatio::known(crate::mechanics::Offset::CENTRE))
    }

    /// The same at another contact ratio.
    pub(in crate::robot) fn log_slope_at(&self, model: &Model, ratio: ContactRatio) -> f64 {
        let length = self.filter.length().length;
        let morphology = model.morphology(self.air.setpoint);
        model
            .sensitivity_and_slope(ratio, length, &morphology)
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
        self.follow_shift(log_shift);
        self.detector = Detector::default();
    }

    /// Takes a shift out of a whisker that feels it as this change: its offset moves by as much and is surer than that of
    /// others, so that a cut soon afterwards stays plain.
    fn take_out_felt(&mut self, model: &Model, felt: &Change, log_shift: f64) {
        let slope = self.log_slope_with_length(model);
        let log_sd = (felt.variance.sqrt() * slope).abs().min(log_shift.abs());
        self.filter.rescaled(felt.size, felt.lacking, felt.size * slope, log_sd);
        self.follow_shift(log_shift);
        self.detector = Detector::default();
    }

    /// The shift may go on, and belongs to earlier measurements, too.
    fn follow_shift(&mut self, log_shift: f64) {
        self.rare.get_or_insert().unsteady =
            Some(Unsteady { log_shift: log_shift.abs(), contacts_left: UNSTEADY_CONTACTS });
        self.shift_reference(log_shift);
    }

    /// Brings the response while whole to another scale.
    pub(in crate::robot) fn shift_reference(&mut self, log_shift: f64) {
        self.whole.shift(log_shift);
        self.whole.doubt_level(OWN_SHARE_SD * log_shift);
        if let Some(offset) = self.rare.get_mut().and_then(|rare| rare.whole_offset.as_mut()) {
            offset.level += log_shift;
        }
    }
}
