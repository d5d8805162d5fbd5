//! One whisker: its state, and the evaluation of its contacts.

use borsh::{BorshDeserialize, BorshSerialize};

use crate::detection::{Change, Detector, Others, Situation, Verdict};
use crate::estimation::filter::{FilterParams, LENGTH, NoInformation, Observation, Wander};
use crate::estimation::leak::Source;
use crate::estimation::spread::Deviation;
use crate::estimation::{
    Bin, ErosionWatch, GainWalks, Innovation, LeakWatch, LengthFilter, NoiseScale, RatioSpread, ResponseBins, Waiting,
};
use crate::mechanics::{CONTACT_RATIOS, Model, Offset, Target, compensable_range};
use crate::robot::effect::{Command, CommandState, Condition, ContactUse, Fault, Reason};
use crate::robot::event::{Contact, RegulatorState};
use crate::robot::health::alarms::Standing;
use crate::robot::health::array_shift::{ABSORBED, UNSTEADY_SHARE};
use crate::robot::health::gauge::GaugeWatch;
use crate::robot::params::Params;
use crate::robot::state::factsheet::Sheet;
use crate::robot::state::place::Placed;
use crate::robot::state::rare_state::Rare;
use crate::robot::state::tracked::DecisionBasis;
use crate::units::{ContactRatio, Megapascal, Micros};

/// Largest step of an eroding whisker's pressure that leaves its offset as certain as it was.
const EROSION_STEP_MAX_MPA: f64 = 0.01;
/// Relative difference between a loss of sensitivity and its end: a gauge hardly sits as before.
const REGAINED_WITHIN: f64 = 0.25;
/// Bound of a temperature's difference, K: beyond it a thermometer is broken.
const WARMER_MAX_K: f64 = 100.0;

/// The state of one whisker.
#[derive(Debug, Clone, PartialEq)]
pub struct Whisker {
    pub(in crate::robot) array: u16,
    pub(in crate::robot) sheet: Sheet,
    pub(in crate::robot) filter: LengthFilter,
    pub(in crate::robot) noise: NoiseScale,
    /// How fast its gain wanders.
    pub(in crate::robot) walks: GainWalks,
    /// Temperature of its first contact, degrees Celsius: the offset is stated for it.
    pub(in crate::robot) reference_c: Option<f32>,
    /// Places of its contacts.
    pub(in crate::robot) spread: RatioSpread,
    pub(in crate::robot) detector: Detector,
    /// Contacts that were used.
    pub(in crate::robot) contacts: u64,
    pub(in crate::robot) condition: Condition,
    /// Its response while whole, against the model at whole length.
    pub(in crate::robot) whole: ResponseBins,
    /// Contacts that are not counted in it yet, and never will be if the whisker is not whole any more.
    pub(in crate::robot) whole_waiting: Waiting,
    pub(in crate::robot) air: Air,
    pub(in crate::robot) leak: LeakWatch,
    pub(in crate::robot) gauge: GaugeWatch,
    pub(in crate::robot) rare: Rare,
    pub(in crate::robot) fault: Option<Fault>,
    /// Time of the last contact or status, by the supervisor's clock.
    pub(in crate::robot) heard: Option<Micros>,
    pub(in crate::robot) desired: Option<Box<Desired>>,
    pub(in crate::robot) command: Option<Box<InFlight>>,
    /// The last setpoint failed for good, in this boot.
    pub(in crate::robot) given_up: bool,
    /// Information of its contacts about log length since any whisker of its array raised an alarm: the inverse of a
    /// variance. Negative if its detector has begun anew since.
    pub(in crate::robot) told_since_alarm: f32,
    /// Its gauge's baseline drifts.
    pub(in crate::robot) drifting: bool,
    /// The alarm for the drift stands.
    pub(in crate::robot) drift_told: bool,
    /// A trim that no decision has been made about.
    pub(in crate::robot) undecided: bool,
    /// It is trimmed, and nobody can serve it.
    pub(in crate::robot) unserved: bool,
    /// The alarm for a shift of its array stands, and it does not read steadily yet.
    pub(in crate::robot) shift_told: bool,
    /// An operator holds the whisker.
    pub(in crate::robot) held: bool,
    /// Numbers of the whiskers that an operator has refused as its compensators.
    pub(in crate::robot) refused_servers: Vec<u16>,
    /// Alarms that stand.
    pub(in crate::robot) standing: Standing,
    pub(in crate::robot) holds: Holds,
    /// State as of the last decision; not stored.
    pub(in crate::robot) decided_on: DecisionBasis,
}

/// Whether a pressure is one that this program knows of, since it has the robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, BorshSerialize, BorshDeserialize)]
pub(in crate::robot) enum Holds {
    /// Not reported yet.
    #[default]
    Unheard,
    /// It was set by a command that is not remembered: it is on its way back.
    Stray,
    /// Reported by the robot, or accepted.
    Known,
}

/// A cut that is confirmed.
#[derive(Debug, Clone, Copy, PartialEq, BorshSerialize, BorshDeserialize)]
pub(in crate::robot) struct PendingTrim {
    pub length_before_mm: f64,
    pub contacts_since_change: u32,
    pub contacts_since_confirmed: u32,
}

/// An offset that follows a shift of the whole array.
#[derive(Debug, Clone, Copy, PartialEq, BorshSerialize, BorshDeserialize)]
pub(in crate::robot) struct Unsteady {
    /// The shift that was found, log sensitivity, without its sign.
    pub log_shift: f64,
    /// Contacts for which it goes on.
    pub contacts_left: u32,
}

impl Unsteady {
    fn after_contact(&self) -> Option<Self> {
        let contacts_left = self.contacts_left.checked_sub(1)?;
        Some(Self { contacts_left, ..*self })
    }
}

/// The chamber's pressure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::robot) struct Air {
    /// As last measured; below 0 before that.
    pub measured_mpa: f64,
    /// Setpoint that the robot holds or moves to.
    pub setpoint: Megapascal,
    /// The pressure at which the offset was learned.
    pub learned_at: Megapascal,
    pub regulator: RegulatorState,
    pub unheld_since: Option<Micros>,
}

impl Air {
    /// A setpoint without a measured pressure yet.
    pub(in crate::robot) fn held(setpoint: Megapascal, learned_at: Megapascal) -> Self {
        let regulator = RegulatorState::Ok;
        Self { measured_mpa: -1.0, setpoint, learned_at, regulator, unheld_since: None }
    }

    /// The pressure as last measured.
    pub(in crate::robot) fn measured(&self) -> Option<Megapascal> {
        Megapascal::new(self.measured_mpa).ok()
    }

    pub(in crate::robot) fn measure(&mut self, pressure: Megapascal) {
        self.measured_mpa = pressure.mpa();
    }
}

/// A pressure that the whisker shall have.
#[derive(Debug, Clone, PartialEq, BorshSerialize, BorshDeserialize)]
pub(in crate::robot) struct Desired {
    pub pressure: Megapascal,
    pub reason: Reason,
    pub compensation: Option<u32>,
    pub gain: Option<[f64; CONTACT_RATIOS.len()]>,
}

/// A setpoint under way.
#[derive(Debug, Clone, PartialEq, BorshSerialize, BorshDeserialize)]
pub(in crate::robot) struct InFlight {
    pub command: Command,
    pub state: CommandState,
    pub resend_at: Micros,
}

/// Result of one contact.
pub(in crate::robot) struct ContactResult {
    /// Contact ratio; `None` if the place is not known.
    pub ratio: Option<ContactRatio>,
    pub used: ContactUse,
    pub innovation: Option<Innovation>,
    pub verdict: Verdict,
    /// Found change of the gain, log sensitivity, that is no change of the whisker; 0 for most contacts.
    pub wandered: f64,
}

impl Whisker {
    pub(in crate::robot) fn new(array: u16, sheet: Sheet, params: &Params) -> Self {
        Self {
            array,
            filter: LengthFilter::new(sheet.length, &params.filter),
            noise: NoiseScale::default(),
            walks: GainWalks::default(),
            reference_c: None,
            spread: RatioSpread::default(),
            detector: Detector::default(),
            contacts: 0,
            condition: Condition::Learning,
            whole: ResponseBins::default(),
            whole_waiting: Waiting::default(),
            air: Air::held(sheet.pressure, sheet.pressure),
            leak: LeakWatch::default(),
            gauge: GaugeWatch::default(),
            rare: Rare::default(),
            fault: None,
            heard: None,
            desired: None,
            command: None,
            given_up: false,
            told_since_alarm: 0.0,
            drifting: false,
            drift_told: false,
            undecided: false,
            unserved: false,
            shift_told: false,
            held: false,
            refused_servers: Vec::new(),
            standing: Standing::default(),
            holds: Holds::default(),
            decided_on: DecisionBasis {
                condition: Condition::Learning,
                fault: None,
                given_up: false,
                held: false,
                undecided: false,
            },
            sheet,
        }
    }

    /// Whether all stored numbers are finite: a version before this one could learn infinite ones.
    pub(in crate::robot) fn is_sound(&self) -> bool {
        let numbers = [self.noise.variance(), self.told_since_alarm.into(), self.detector.statistic(false)];
        let is_sound = |bin: Bin| bin.mean().is_finite() && bin.variance() > 0.0;
        self.filter.is_sound()
            && self.spread.is_sound()
            && self.noise.is_sound()
            && self.walks.is_sound()
            && numbers.iter().all(|one| one.is_finite())
            && self.whole.felt().all(is_sound)
    }

    /// Learns everything anew.
    pub(in crate::robot) fn mend(&mut self) {
        self.filter = LengthFilter::new(self.sheet.length, &FilterParams::default());
        (self.noise, self.detector) = (NoiseScale::default(), Detector::default());
        (self.reference_c, self.spread) = (None, RatioSpread::default());
        self.walks = GainWalks::default();
        (self.whole, self.whole_waiting) = (ResponseBins::default(), Waiting::default());
        (self.contacts, self.condition, self.told_since_alarm) = (0, Condition::Learning, 0.0);
        if let Some(rare) = self.rare.get_mut() {
            (rare.pending_trim, rare.whole_offset, rare.own, rare.erosion, rare.unsteady) =
                (None, None, None, None, None);
        }
    }

    /// The whole whisker, as a target.
    #[must_use]
    pub fn target(&self) -> Target {
        Target { length: self.sheet.length, pressure: self.sheet.pressure }
    }

    /// Its offset from the model while whole at nominal pressure.
    pub(in crate::robot) fn whole_offset(&self) -> Offset {
        self.rare.whole_offset.unwrap_or_else(|| self.filter.offset())
    }

    /// Takes one contact in: its use, its innovation and the detector's verdict.
    pub(in crate::robot) fn feel(
        &mut self,
        params: &Params,
        model: &Model,
        contact: &Contact<'_>,
        others: Others,
    ) -> ContactResult {
        let placed = Placed::on(&self.filter.length(), contact.place);
        let result = self.feel_at(params, model, contact, placed, others);
        ContactResult { ratio: placed.ok().map(|placed| placed.ratio), ..result }
    }

    fn feel_at(
        &mut self,
        params: &Params,
        model: &Model,
        contact: &Contact<'_>,
        placed: Result<Placed, ContactUse>,
        others: Others,
    ) -> ContactResult {
        self.air.measure(contact.pressure);
        let off_by_mpa = (contact.pressure.mpa() - self.air.setpoint.mpa()).abs();
        if off_by_mpa > params.health.settled_within_mpa {
            return ContactResult::unused(ContactUse::Unsettled);
        }
        if self.command.is_none() {
            self.leak.read(&params.health.leak, Source::Contact, contact.robot_time, contact.pressure);
        }
        let placed = match placed {
            Ok(placed) => placed,
            Err(used) => return ContactResult::unused(used),
        };
        let morphology = model.morphology(contact.pressure);
        let stated_sd = placed.ratio_sd.unwrap_or(params.noise.ratio);
        let expected = self.spread.expected(placed.ratio, stated_sd);
        let warmer_k = self.warmer_k(contact.temperature_c);
        let observation = Observation {
            place: expected,
            informs_length: placed.informs_length,
            deflection_mm: contact.deflection.mm(),
            strain: contact.strain.ratio(),
            warmer_k,
        };
        let seen = self.filter.observe(model, &morphology, &params.noise, &self.noise, &observation);
        if self.gauge.watch(&observation, seen.as_ref().ok(), params.health.gauge_contacts) {
            return ContactResult::unused(ContactUse::GaugeFault);
        }
        match seen {
            Err(NoInformation::OnChamber(_)) => ContactResult::unused(ContactUse::OnChamber),
            Err(NoInformation::TooWeak) => ContactResult::unused(ContactUse::TooWeak),
            Err(NoInformation::Implausible) => ContactResult::unused(ContactUse::Implausible),
            Ok(seen) => {
                self.learn_places(placed.ratio, stated_sd, &seen);
                self.take(params, &placed, &seen, others)
            }
        }
    }

    /// Takes in a stated contact ratio, and what the contact tells of its error.
    fn learn_places(&mut self, stated: ContactRatio, stated_sd: f64, seen: &Innovation) {
        if let Some(per_ratio) = seen.tells_errors {
            let variance = seen.variance / seen.seen.sound.max(1e-3);
            let seen = Deviation { residual: seen.residual, variance, per_ratio };
            self.spread.learn_errors(stated, stated_sd, &seen);
        }
        self.spread.learn(stated, stated_sd);
    }

    /// Temperature above that of the first contact, K; 0 if it is not known.
    fn warmer_k(&mut self, temperature_c: Option<f64>) -> f64 {
        let Some(temperature_c) = temperature_c.filter(|one| one.is_finite()) else { return 0.0 };
        let reference_c = *self.reference_c.get_or_insert(temperature_c as f32);
        (temperature_c - f64::from(reference_c)).clamp(-WARMER_MAX_K, WARMER_MAX_K)
    }

    fn take(&mut self, params: &Params, placed: &Placed, seen: &Innovation, others: Others) -> ContactResult {
        self.contacts += 1;
        self.tell(seen);
        let learning = self.condition == Condition::Learning;
        // While learning, a scale of the noise that is not known yet is the likeliest cause of a little doubt.
        let calm = (self.detector.is_calm() || learning && self.detector.has_little_doubt())
            && self.rare.pending_trim.is_none();
        if self.detector.is_suspicious() || self.rare.pending_trim.is_some() {
            self.noise.forget_doubtful();
        } else {
            self.noise.correlate(seen.alone.standardised, seen.alone.noise_share, calm);
        }
        if calm {
            self.learn_noise(params, seen);
            if matches!(self.condition, Condition::Learning | Condition::Healthy) && self.is_at_nominal_pressure() {
                // Against the model at whole length: the residual is against the present estimate.
                let shift = seen.row[LENGTH] * self.filter.log_length();
                let deviation = seen.residual + self.filter.offset().at(seen.ratio) + shift;
                // An outlier gets a larger variance.
                let variance = seen.noise_variance / seen.seen.sound.max(1e-3);
                self.whole_waiting.add(&mut self.whole, seen.ratio, deviation, variance);
            }
        }
        // Wear is known to change the sensitivity: a gain that wanders instead would keep the length from following.
        if self.contacts > params.detection.followed_from.into() && self.condition != Condition::Eroding {
            self.walks.see(seen);
        }
        let mut verdict = self.judge(params, seen, learning, others);
        if !self.filter.learn(seen, self.wander(params)) {
            return ContactResult::unused(ContactUse::Implausible);
        }
        let wandered = self.follow_gain(verdict);
        // After another verdict the detector starts anew, and its caller moves the state first.
        if matches!(verdict, Verdict::Quiet | Verdict::Looking)
            && let Some(length) = placed.tip.and_then(|tip| self.filter.observe_length(&self.noise, tip.at, tip.sd_mm))
        {
            verdict = self.judge(params, &length, learning, others);
            // The random walk of this contact is in the state already. An implausible length changes nothing.
            let _ = self.filter.learn(&length, Wander { length_mm: 0.0, baseline_strain: 0.0, offset: 0.0 });
        }
        if let Some(rare) = self.rare.get_mut() {
            rare.unsteady = rare.unsteady.and_then(|unsteady| unsteady.after_contact());
        }
        self.shift_told &= self.rare.unsteady.is_some();
        self.follow_erosion(params);
        let used = if learning { ContactUse::Learning } else { ContactUse::Used };
        ContactResult { ratio: None, used, innovation: Some(*seen), verdict, wandered }
    }

    /// Adds the information of a contact about a change of log length before the last alarm in the array.
    ///
    /// The filter absorbs such a change. With a state of variance V and noise R per unit of log length, n contacts leave the
    /// share u = R / (R + n V) of it, and have told I = n / (R + n V). Both follow from I and the state's present variance
    /// V u: I V u = u (1 - u). Once half is absorbed, contacts tell too little.
    fn tell(&mut self, seen: &Innovation) {
        let square = seen.row[LENGTH].powi(2);
        if square <= 0.0 || self.told_since_alarm < 0.0 {
            return;
        }
        let state = (seen.variance - seen.noise_variance) / square;
        let absorbed = 1.0 - 4.0 * f64::from(self.told_since_alarm) * state;
        if absorbed <= 0.0 {
            self.told_since_alarm = ABSORBED;
            return;
        }
        let left = 0.5 * (1.0 + absorbed.sqrt());
        self.told_since_alarm += (left.powi(2) * square / seen.variance) as f32;
    }

    /// Verdict on an innovation; none while learning.
    fn judge(&mut self, params: &Params, seen: &Innovation, learning: bool, others: Others) -> Verdict {
        let detection = &params.detection;
        if !learning {
            let eroding = self.condition == Condition::Eroding;
            let situation = Situation { eroding, others, wandering: self.walks.evidence() };
            return self.detector.update(detection, seen, &situation);
        }
        if self.contacts > detection.followed_from.into() {
            self.detector.follow(seen);
        }
        Verdict::Quiet
    }

    /// Takes the rate at which the gain wanders from the contacts that show no change. Returns the change of the gain that was
    /// found with it, log sensitivity.
    fn follow_gain(&mut self, verdict: Verdict) -> f64 {
        let moved = match verdict {
            Verdict::Changed(_) | Verdict::Shared(_) => {
                self.walks.changed();
                None
            }
            Verdict::Wandered => Some(self.walks.wandered()),
            // A change while learning is called later; it must not pass for a walk.
            Verdict::Quiet if !matches!(self.condition, Condition::Learning | Condition::Eroding) => {
                self.walks.quiet(self.detector.is_calm(), self.detector.log_ratio_max())
            }
            Verdict::Quiet | Verdict::Looking | Verdict::Alarm | Verdict::Dismissed => None,
        };
        let Some(moved) = moved else { return 0.0 };
        let is_moved = self.filter.wandered(moved);
        self.detector = Detector::default();
        self.cannot_deny();
        if is_moved { moved.by } else { 0.0 }
    }

    fn learn_noise(&mut self, params: &Params, seen: &Innovation) {
        let alone = &seen.alone;
        let factor = self.noise.learn(alone.standardised, alone.sound, alone.noise_share, seen.by_play);
        if self.condition == Condition::Learning {
            self.filter.rescale(factor, &params.filter);
        }
    }

    fn wander(&self, params: &Params) -> Wander {
        let eroding = self.condition == Condition::Eroding;
        let (filter, drifting) = (&params.filter, self.drifting);
        Wander {
            length_mm: if eroding { filter.erosion_wander_mm } else { filter.wander_mm },
            baseline_strain: if drifting {
                filter.drifting_baseline_wander_strain
            } else {
                filter.baseline_wander_strain
            },
            offset: self.rare.unsteady.map_or(0.0, |unsteady| UNSTEADY_SHARE * unsteady.log_shift).hypot(if eroding {
                0.0
            } else {
                self.walks.rate()
            }),
        }
    }

    /// While it erodes: how fast, and how long it will still do.
    fn follow_erosion(&mut self, params: &Params) {
        if self.condition != Condition::Eroding {
            if let Some(rare) = self.rare.get_mut() {
                rare.erosion = None;
            }
            return;
        }
        let Some(model) = self.model(params) else { return };
        let (target, max) = (self.target(), self.sheet.pressure_max);
        let watch = self.rare.get_or_insert().erosion.get_or_insert_with(|| {
            let shortest = compensable_range(model, target, Megapascal::ZERO, max).0;
            Box::new(ErosionWatch::new(target.length, shortest, params.filter.erosion_wander_mm))
        });
        watch.follow(&self.filter.length());
    }

    /// Moves the estimate by a confirmed change.
    pub(in crate::robot) fn jump(&mut self, change: &Change) {
        self.filter.jump(change.size, change.variance, change.lacking);
    }

    /// Whether a rise of sensitivity takes back a loss: it leads to about the level before the loss.
    pub(in crate::robot) fn regains(&self, params: &Params, change: &Change) -> bool {
        let Some((before, model)) = self.rare.whole_offset.zip(self.model(params)) else { return false };
        let slope = self.log_slope_with_length(model);
        // The offset as it was before it absorbed a part of the rise.
        let lost = before.level - (self.filter.offset().level + change.size * change.lacking[0]);
        let off = (change.size * slope - lost).abs();
        self.condition == Condition::SensitivityLoss
            && lost > 0.0
            && off <= REGAINED_WITHIN * lost + 2.0 * change.variance.sqrt() * slope.abs()
    }

    /// Whether it is held at the factsheet's pressure, where its reference response is taken.
    pub(in crate::robot) fn is_at_nominal_pressure(&self) -> bool {
        (self.air.learned_at.mpa() - self.sheet.pressure.mpa()).abs() < 1e-3
    }

    /// The robot holds another pressure from now on: the model's error there is to be learned anew.
    pub(in crate::robot) fn pressure_set(&mut self, setpoint: Megapascal, params: &Params) {
        if setpoint == self.air.setpoint {
            return;
        }
        self.air.setpoint = setpoint;
        self.air.unheld_since = None;
        self.leak.interrupt(&params.health.leak);
        let moved_mpa = setpoint.mpa() - self.air.learned_at.mpa();
        if moved_mpa.abs() > 1e-3 {
            if self.is_at_nominal_pressure() {
                self.rare.get_or_insert().whole_offset = Some(self.filter.offset());
            }
            // While it erodes its setpoints are small steps. If each made the offset uncertain, the loss of length would be
            // taken for the model's error there.
            if self.condition != Condition::Eroding || moved_mpa.abs() > EROSION_STEP_MAX_MPA {
                self.filter.pressure_moved(moved_mpa, &params.filter);
            }
            self.detector = Detector::default();
            self.cannot_deny();
            self.air.learned_at = setpoint;
        }
    }

    /// The highest setpoint: the lower of the factsheet's limit and the paper's.
    pub(in crate::robot) fn pressure_limit(&self) -> Megapascal {
        let (own, examined) = (self.sheet.pressure_max, Megapascal::EXAMINED_MAX);
        if own < examined { own } else { examined }
    }

    /// The model of the factsheet; factsheets with unknown models are refused, so it is there.
    pub(in crate::robot) fn model<'p>(&self, params: &'p Params) -> Option<&'p Model> {
        // Shared names compare by pointer.
        params.models.iter().find(|(name, _)| *name == self.sheet.model).map(|(_, model)| model)
    }
}

impl ContactResult {
    fn unused(used: ContactUse) -> Self {
        Self { ratio: None, used, innovation: None, verdict: Verdict::Quiet, wandered: 0.0 }
    }
}
