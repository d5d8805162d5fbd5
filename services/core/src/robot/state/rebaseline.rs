//! A whisker whose readings are learned anew, because they changed and the whisker did not: its gauge was glued anew,
//! say, or its model is another.
//!
//! - The length estimate is taken as it is, as certain as it is. A cut that is confirmed but not called yet is called,
//!   with that length: it would be forgotten otherwise.
//! - Offset, noise scale, baseline, detector, the gauge's and the array's suspicions, the response while whole and the
//!   chamber's own calibration were all learned through the old gauge or model: they begin as for a new whisker.
//! - The condition is LEARNING, as in any cold start, but TRIMMED stays TRIMMED, or nobody would serve it. A loss of
//!   sensitivity or an erosion is over by the operator's word; where it goes on, it is detected again.
//! - A compensation goes on at its pressure and with its gain: the chamber has not changed. Measurements
//!   through the old gauge are dropped, and the model is its reference, as there is no measured one left.
//! - A compensation in which this whisker would serve and that waits for approval ends, and is decided anew: the
//!   measurements that it was decided on are dropped.

use crate::detection::Detector;
use crate::estimation::{GainWalks, NoiseScale, ResponseBins, Waiting};
use crate::robot::Robot;
use crate::robot::effect::{Condition, Effect, EndReason, WhiskerIndex};
use crate::robot::params::Params;
use crate::robot::state::rare_state::Rare;
use crate::robot::state::whisker::Whisker;
use crate::robot::touch_tests::DistanceZero;

impl Robot {
    /// The whisker is learned anew at its present length.
    pub(in crate::robot) fn rebaseline(&mut self, params: &Params, index: WhiskerIndex, effects: &mut Vec<Effect>) {
        self.call_trim(index, effects);
        self.end_as_compensator(index, EndReason::Operator, |one| one.is_proposed(), effects);
        let whisker = &mut self.whiskers[index];
        whisker.forget_readings(params);
        if whisker.condition != Condition::Trimmed {
            self.set_condition(index, Condition::Learning, effects);
        }
        for running in self.head.compensations.iter_mut().filter(|one| one.compensator() == index) {
            running.after = ResponseBins::default();
            running.before = running.before.is_some().then(ResponseBins::default);
            running.refining = running.refining.felt_anew();
        }
    }
}

impl Whisker {
    fn forget_readings(&mut self, params: &Params) {
        self.filter = self.filter.learned_anew(&params.filter);
        self.noise = NoiseScale::default();
        self.walks = GainWalks::default();
        self.detector = Detector::default();
        self.contacts = 0;
        self.whole = ResponseBins::default();
        self.whole_waiting = Waiting::default();
        let reported = std::mem::take(&mut self.gauge).reported;
        self.gauge.reported = reported;
        self.told_since_alarm = 0.0;
        self.end_measurement();
        let followed = self.rare.get_mut().and_then(|rare| rare.length_test.take());
        // The zero of the distances is the robot's, and only a whole whisker tells it.
        let zero = self.rare.zero;
        self.rare = Rare::default();
        if followed.is_some() || zero != DistanceZero::UNKNOWN {
            let rare = self.rare.get_or_insert();
            (rare.length_test, rare.zero) = (followed, zero);
        }
        self.shift_told = false;
        self.drifting = false;
        self.drift_told = false;
        self.air.learned_at = self.air.setpoint;
    }
}
