//! One whisker: its state, and what changes it besides contacts.

use borsh::{BorshDeserialize, BorshSerialize};

use crate::detection::{Change, Detector};
use crate::estimation::filter::FilterParams;
use crate::estimation::{
    Bin, GainWalks, LeakWatch, LengthFilter, NoiseScale, RatioSpread, ResponseBins, Temperatures, Waiting,
};
use crate::mechanics::{CONTACT_RATIOS, Model, Offset, Target};
use crate::robot::effect::{Command, CommandState, Condition, Fault, Reason};
use crate::robot::event::{AirControl, RegulatorState};
use crate::robot::health::gauge::GaugeWatch;
use crate::robot::health::standing::Standing;
use crate::robot::params::Params;
use crate::robot::state::factsheet::Sheet;
use crate::robot::state::rare_state::Rare;
use crate::robot::touch_tests::DistanceZero;
use crate::units::{ContactRatio, Megapascal, Micros};

/// Error of the model after steps of an eroding whisker's pressure, as a share of that after a single step to an unknown pressure:
/// with 0.5 the 95 % interval of the length holds the truth in 96 % of the cases, with 0.35 in 79 %.
const STEP_ERROR_SHARE: f64 = 0.5;
/// Standard deviation of the level before a cut, log sensitivity, on a whisker with lasting noise: creep and habits move it for
/// some hundred contacts, beside the walk of the gain. In the mix of nuisances the 95 % interval of the length holds the truth
/// in 91 % of the cases without it.
const LASTING_LEVEL_SD: f64 = 0.01;
/// Relative difference between a loss of sensitivity and its end: a gauge hardly sits as before.
const REGAINED_WITHIN: f64 = 0.25;
/// The offset at a pressure is known from this standard deviation on, log sensitivity. A gain that wanders as usual leaves 0.007.
const OFFSET_KNOWN_SD: f64 = 0.02;
/// The state of one whisker.
#[derive(Debug, Clone, PartialEq)]
pub struct Whisker {
    pub(in crate::robot) array: u16,
    pub(in crate::robot) sheet: Sheet,
    pub(in crate::robot) filter: LengthFilter,
    pub(in crate::robot) noise: NoiseScale,
    /// How fast its gain wanders.
    pub(in crate::robot) walks: GainWalks,
    /// Temperatures of its contacts; `None` before the first contact with a temperature.
    pub(in crate::robot) temperatures: Option<Temperatures>,
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
    /// Its setpoints have failed, in this boot: it serves nobody until they are tried again.
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
    /// The robot has vented it by itself, and nothing fills it again without a person.
    Vented,
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

/// The properties of a whisker that decide whether it needs a compensator and whether it may serve as one.
///
/// Length and offset are left out: they move with each contact, and a decision stands until one of these differs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::robot) struct DecisionBasis {
    pub condition: Condition,
    pub fault: Option<Fault>,
    pub given_up: bool,
    pub held: bool,
    pub undecided: bool,
}

impl Whisker {
    pub(in crate::robot) fn new(array: u16, sheet: Sheet, params: &Params) -> Self {
        let mut new = Self {
            array,
            filter: LengthFilter::new(sheet.length, &params.filter),
            noise: NoiseScale::default(),
            walks: GainWalks::default(),
            temperatures: None,
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
        };
        new.keep_tolerance(&params.filter);
        new
    }

    /// The stated length has the error that its factsheet states.
    pub(in crate::robot) fn keep_tolerance(&mut self, params: &FilterParams) {
        self.filter.keep_tolerance(self.sheet.length_tolerance_mm, params);
    }

    pub(in crate::robot) fn decision_basis(&self) -> DecisionBasis {
        let Self { condition, fault, given_up, held, undecided, .. } = *self;
        DecisionBasis { condition, fault, given_up, held, undecided }
    }

    /// Whether all stored numbers are finite: a version before this one could learn infinite ones.
    pub(in crate::robot) fn is_sound(&self) -> bool {
        let numbers = [self.noise.variance(), self.told_since_alarm.into(), self.detector.statistic(false)];
        let is_sound = |bin: Bin| bin.mean().is_finite() && bin.variance() > 0.0;
        self.filter.is_sound()
            && self.spread.is_sound()
            && self.noise.is_sound()
            && self.walks.is_sound()
            && self.rare.zero.is_sound()
            && self.rare.first.as_ref().is_none_or(|first| first.is_sound())
            && numbers.iter().all(|one| one.is_finite())
            && self.whole.felt().all(is_sound)
    }

    /// Learns everything anew.
    pub(in crate::robot) fn mend(&mut self) {
        self.filter = LengthFilter::new(self.sheet.length, &FilterParams::default());
        self.keep_tolerance(&FilterParams::default());
        (self.noise, self.detector) = (NoiseScale::default(), Detector::default());
        (self.temperatures, self.spread) = (None, RatioSpread::default());
        self.walks = GainWalks::default();
        (self.whole, self.whole_waiting) = (ResponseBins::default(), Waiting::default());
        (self.contacts, self.condition, self.told_since_alarm) = (0, Condition::Learning, 0.0);
        if let Some(rare) = self.rare.get_mut() {
            (rare.pending_trim, rare.whole_offset, rare.own, rare.erosion, rare.unsteady) =
                (None, None, None, None, None);
            (rare.zero, rare.first) = (DistanceZero::UNKNOWN, None);
        }
    }

    /// The whole whisker, as a target.
    #[must_use]
    pub fn target(&self) -> Target {
        Target { length: self.sheet.length, pressure: self.sheet.pressure }
    }

    /// Its offset from the model while whole at nominal pressure.
    pub(in crate::robot) fn whole_offset(&self) -> Offset {
        self.rare.whole_offset.unwrap_or_else(|| self.filter.whole_offset())
    }

    /// Difference between the level of its response while whole by the length filter, which has this offset, and by the
    /// averages, log sensitivity. Averages leave out the contacts during a doubtful change, and follow a wandering
    /// gain late.
    pub(in crate::robot) fn whole_lag(&self, offset: Offset) -> f64 {
        let sums = self.whole.felt().fold((0.0, 0.0, 0.0), |(weight, ratio, mean), bin| {
            let one = 1.0 / bin.variance();
            (weight + one, ratio + one * bin.mean_ratio(), mean + one * bin.mean())
        });
        let (weight, ratio, mean) = sums;
        ContactRatio::new(ratio / weight).map_or(0.0, |at| offset.at(at) - mean / weight)
    }

    /// Its response while whole, at its present level.
    pub(in crate::robot) fn present_whole(&self) -> ResponseBins {
        if self.is_at_nominal_pressure() { self.whole_now() } else { self.whole.clone() }
    }

    /// Its response while whole with its present offset, against the model at its present length and nominal pressure: that of
    /// a whisker that has lost sensitivity, cut or not.
    pub(in crate::robot) fn whole_now(&self) -> ResponseBins {
        let mut whole = self.whole.clone();
        whole.shift(self.whole_lag(self.filter.whole_offset()));
        whole
    }

    /// It is not whole any more: this was its offset.
    pub(in crate::robot) fn leaves_whole(&mut self, offset: Offset) {
        if self.rare.whole_offset.is_none() {
            self.whole.shift(self.whole_lag(offset));
            self.rare.get_or_insert().whole_offset = Some(offset);
        }
    }

    /// Moves the estimate by a confirmed change.
    pub(in crate::robot) fn jump(&mut self, change: &Change) {
        self.filter.jump(change.size, change.variance, change.lacking);
    }

    /// Widens the length's uncertainty by a wander of the gain before a change, which counted as a change of length.
    pub(in crate::robot) fn doubt_gain(&mut self, params: &Params) {
        let Some(model) = self.model(params) else { return };
        let (lag, slope) = (self.gain_lag(params, &self.whole), self.log_slope_with_length(model));
        let level_sd = if self.noise.is_lasting(&params.noise) { LASTING_LEVEL_SD } else { 0.0 };
        self.filter.doubt_gain(lag.hypot(level_sd), slope);
    }

    /// Whether a rise of sensitivity takes back a loss: it leads to about the level before the loss.
    pub(in crate::robot) fn regains(&self, params: &Params, change: &Change) -> bool {
        let Some((before, model)) = self.rare.whole_offset.zip(self.model(params)) else { return false };
        let slope = self.log_slope_with_length(model);
        // The offset as it was before it absorbed a part of the rise.
        let lost = before.level - (self.filter.whole_offset().level + change.size * change.lacking[0]);
        let off = (change.size * slope - lost).abs();
        self.condition == Condition::SensitivityLoss
            && lost > 0.0
            && off <= REGAINED_WITHIN * lost + 2.0 * change.variance.sqrt() * slope.abs()
    }

    /// A whole whisker that is back at its nominal pressure shows its offset again: that of the last departure is outdated.
    pub(in crate::robot) fn renew_whole_offset(&mut self) {
        if self.condition == Condition::Healthy
            && self.rare.whole_offset.is_some()
            && self.is_at_nominal_pressure()
            && self.filter.offset_sd() < OFFSET_KNOWN_SD
            && let Some(rare) = self.rare.get_mut()
        {
            rare.whole_offset = None;
        }
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
                let (present, is_whole) = (self.filter.whole_offset(), self.condition == Condition::Healthy);
                let before = &mut self.rare.get_or_insert().whole_offset;
                // After a loss the present offset is not that of the whole whisker, also after a cut that followed.
                *before = before.filter(|_| !is_whole).or(Some(present));
            }
            if self.condition != Condition::Eroding {
                self.filter.pressure_moved(moved_mpa, &params.filter);
            } else {
                self.doubt_pressure_step(setpoint, params);
            }
            self.detector = Detector::default();
            self.cannot_deny();
            self.air.learned_at = setpoint;
        }
    }

    /// While it erodes its setpoints are small steps. If each made the offset uncertain, the loss of length would be taken for
    /// the model's error there. So that error counts as length, which becomes as uncertain as the error at this distance from
    /// the nominal pressure.
    fn doubt_pressure_step(&mut self, setpoint: Megapascal, params: &Params) {
        let Some(model) = self.model(params) else { return };
        let slope = self.log_slope_with_length(model);
        let nominal_mpa = self.sheet.pressure.mpa();
        let square = |pressure: Megapascal| {
            (STEP_ERROR_SHARE * params.filter.offset_per_mpa * (pressure.mpa() - nominal_mpa)).powi(2)
        };
        let more = square(setpoint) - square(self.air.learned_at);
        if more > 0.0 && slope != 0.0 {
            self.filter.doubt_model(more.sqrt(), slope);
        }
    }

    /// The lowest and the highest pressure that a robot with such air can hold in it, by its factsheet.
    pub(in crate::robot) fn pressures(&self, air: AirControl) -> (Megapascal, Megapascal) {
        let (own, highest) = (self.sheet.pressure, self.sheet.pressure_max);
        match air {
            AirControl::FillAndVent => (Megapascal::ZERO, highest),
            AirControl::VentOnly => (Megapascal::ZERO, if own < highest { own } else { highest }),
            AirControl::None => (own, own),
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
