//! Prediction of the decision after a cut: the decision itself, made on a copy.

use super::Robot;
use super::effect::{Condition, Decision, Effect, EndReason, Reason, WhiskerIndex};
use super::event::Link;
use super::params::Params;
use crate::estimation::filter::{LENGTH, STATES};
use crate::mechanics::{CONTACT_RATIOS, Objective};
use crate::policy::{Case, Mode};
use crate::units::{Megapascal, Millimetre};

/// Predicted decisions after a cut.
#[derive(Debug, Clone, PartialEq)]
pub struct WhatIf {
    /// The decisions that would be taken: about the whisker itself, and about those that its cut leaves unserved
    /// or whose compensator it takes. Numbers of compensations are the next free ones.
    pub decisions: Vec<Decision>,
    /// Compensations in force that would end.
    pub ended: Vec<(u32, EndReason)>,
    /// Pressures that would be commanded.
    pub setpoints: Vec<Planned>,
    /// The compensation of the cut whisker with each objective of the policy; none with those by which no whisker serves
    /// it.
    pub by_objective: Vec<(Objective, Option<Served>)>,
}

/// A compensation that would serve the cut whisker.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Served {
    /// Whisker that would serve.
    pub compensator: WhiskerIndex,
    /// Case of the paper.
    pub case: Case,
    /// Pressure to hold.
    pub pressure: Megapascal,
    /// Factor on each reading; none with an objective for robots that apply no gain.
    pub reading_gain: Option<f64>,
    /// Predicted mean error of the reading (Eq. 35), as a ratio.
    pub predicted_error: f64,
    /// Its 95 % interval.
    pub predicted_error_interval: Option<(f64, f64)>,
}

/// A setpoint that would be sent after the cut.
#[derive(Debug, Clone, PartialEq)]
pub struct Planned {
    /// Whisker that would hold the pressure.
    pub whisker: WhiskerIndex,
    /// Pressure to hold.
    pub pressure: Megapascal,
    /// Reason for the setpoint.
    pub reason: Reason,
    /// The compensation that it belongs to.
    pub compensation: Option<u32>,
    /// Residual gain at [`CONTACT_RATIOS`].
    pub gain: Option<[f64; CONTACT_RATIOS.len()]>,
}

/// Reason for refusing a prediction.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum WhatIfError {
    /// There is no such whisker.
    #[error("there is no whisker with index {0}")]
    UnknownWhisker(WhiskerIndex),
    /// The length is not below the present one.
    #[error("a cut to {asked_mm:.2} mm does not shorten the whisker: it has {present_mm:.2} mm")]
    NotShorter {
        /// Requested length, mm.
        asked_mm: f64,
        /// Present length, mm.
        present_mm: f64,
    },
}

impl Robot {
    /// Decisions and setpoints if a whisker were cut to `length` and the cut had just been detected. The robot counts
    /// as connected. Faults and holds count as they are, the policy's mode does not: setpoints are those after all
    /// approvals. A length within the chamber is valid, too: then the whisker cannot serve itself.
    ///
    /// # Errors
    /// There is no such whisker, or it is not longer than that.
    pub fn what_if(&self, params: &Params, whisker: WhiskerIndex, length: Millimetre) -> Result<WhatIf, WhatIfError> {
        let mut copy = self.clone();
        copy.cut(whisker, length)?;
        // The decision must not depend on the present connection.
        copy.head.link = Link::Online;
        let now = copy.whiskers.iter().filter_map(|one| one.heard).max().unwrap_or_default();
        copy.head.clock.assume_known(now);
        let mut effects = Vec::new();
        // The decision is shown as if it were approved.
        let mut automatic = params.clone();
        automatic.policy.mode = Mode::Automatic;
        let by_objective = copy.by_objective(&automatic, whisker);
        copy.decide(&automatic, &mut effects);
        copy.reconcile_all(&automatic, now, &mut effects);
        // Setpoints that were wanted before the cut have nothing to do with it.
        let is_new = |index: WhiskerIndex| copy.whiskers[index].desired != self.whiskers[index].desired;
        Ok(WhatIf { by_objective, ..WhatIf::of(effects, is_new) })
    }

    /// The compensation of a cut whisker with each objective. With SHAPE the robot counts as one that applies a gain, with the
    /// others as one that does not.
    fn by_objective(&self, params: &Params, whisker: WhiskerIndex) -> Vec<(Objective, Option<Served>)> {
        let served = |objective: Objective| {
            let (mut copy, mut params, mut effects) = (self.clone(), params.clone(), Vec::new());
            params.policy.objective = objective;
            copy.head.applies_gain = objective == Objective::Shape;
            copy.decide(&params, &mut effects);
            let one = copy.head.compensations.iter().find(|one| one.target() == whisker)?;
            let decisions = WhatIf::of(effects, |_| false).decisions;
            let interval = decisions
                .iter()
                .filter(|decision| decision.target == whisker)
                .find_map(|decision| decision.candidates.get(decision.chosen?)?.predicted_error_interval);
            Some(Served {
                compensator: one.compensator(),
                case: one.case,
                pressure: one.pressure,
                reading_gain: one.reading_gain(),
                predicted_error: one.predicted_error,
                predicted_error_interval: interval,
            })
        };
        [Objective::Tip, Objective::Mean, Objective::Shape].map(|objective| (objective, served(objective))).to_vec()
    }

    /// Brings the robot into the state after a detected trim of known length.
    fn cut(&mut self, index: WhiskerIndex, length: Millimetre) -> Result<(), WhatIfError> {
        if index >= self.whiskers.len() {
            return Err(WhatIfError::UnknownWhisker(index));
        }
        let one = &mut self.whiskers[index];
        let estimate_mm = one.filter.length().length.mm();
        // A confirmed cut that is not called yet counts with its length before.
        let present_mm = one.rare.pending_trim.map_or(estimate_mm, |pending| pending.length_before_mm);
        if length.mm() >= present_mm {
            return Err(WhatIfError::NotShorter { asked_mm: length.mm(), present_mm });
        }
        // No length is below what the filter can hold.
        let log_change = (length.mm().max(1.0) / estimate_mm).ln();
        let mut by_length = [0.0; STATES];
        by_length[LENGTH] = 1.0 / one.filter.per_log();
        one.filter.jump(log_change, 0.0, by_length);
        if one.is_at_nominal_pressure() {
            one.rare.get_or_insert().whole_offset.get_or_insert_with(|| one.filter.whole_offset());
        }
        if let Some(rare) = one.rare.get_mut() {
            rare.pending_trim = None;
        }
        one.refused_servers.clear();
        one.condition = Condition::Trimmed;
        one.undecided = true;
        Ok(())
    }
}

impl WhatIf {
    #[expect(clippy::wildcard_enum_match_arm, reason = "a decision has few kinds of effects; the rest is not its own")]
    fn of(effects: Vec<Effect>, is_new: impl Fn(WhiskerIndex) -> bool) -> Self {
        let mut answer =
            Self { decisions: Vec::new(), ended: Vec::new(), setpoints: Vec::new(), by_objective: Vec::new() };
        for effect in effects {
            match effect {
                Effect::Decided(decision) => answer.decisions.push(*decision),
                Effect::Ended { compensation, reason, .. } => answer.ended.push((compensation, reason)),
                Effect::Command(command) if is_new(command.whisker) => answer.setpoints.push(Planned {
                    whisker: command.whisker,
                    pressure: command.pressure,
                    reason: command.reason,
                    compensation: command.compensation,
                    gain: command.gain,
                }),
                _ => {}
            }
        }
        answer
    }
}
