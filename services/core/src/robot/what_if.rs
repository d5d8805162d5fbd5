//! What would be done if a whisker were cut: the decision itself, made on a copy.

use super::Robot;
use super::effect::{Condition, Decision, Effect, EndReason, Reason, WhiskerIndex};
use super::event::Link;
use super::params::Params;
use crate::mechanics::CONTACT_RATIOS;
use crate::policy::Mode;
use crate::units::{Megapascal, Millimetre};

/// What would be done.
#[derive(Debug, Clone, PartialEq)]
pub struct WhatIf {
    /// The decisions that would be taken: about the whisker itself, and about those that its cut leaves unserved
    /// or whose compensator it takes. Numbers of compensations are the next free ones.
    pub decisions: Vec<Decision>,
    /// Compensations in force that would end.
    pub ended: Vec<(u32, EndReason)>,
    /// Pressures that would be commanded.
    pub setpoints: Vec<Planned>,
}

/// A setpoint that would be sent.
#[derive(Debug, Clone, PartialEq)]
pub struct Planned {
    /// For whom.
    pub whisker: WhiskerIndex,
    /// Pressure to hold.
    pub pressure: Megapascal,
    /// Why.
    pub reason: Reason,
    /// The compensation that it belongs to.
    pub compensation: Option<u32>,
    /// Residual gain at [`CONTACT_RATIOS`].
    pub gain: Option<[f64; CONTACT_RATIOS.len()]>,
}

/// Why there is no answer.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum WhatIfError {
    /// There is no such whisker.
    #[error("there is no whisker with index {0}")]
    UnknownWhisker(WhiskerIndex),
    /// A cut shortens.
    #[error("a cut to {asked_mm} mm is none: the whisker has {present_mm} mm")]
    NotShorter {
        /// What was asked.
        asked_mm: f64,
        /// What it has.
        present_mm: f64,
    },
}

impl Robot {
    /// What would be done if a whisker were cut to `length` and the cut had just been found. The robot is taken
    /// to be connected; faults and holds count as they are, and the policy's mode does not: setpoints are those that
    /// would be sent once all is approved. A length within the chamber is answered too: then it cannot
    /// serve itself.
    ///
    /// # Errors
    /// There is no such whisker, or it is not longer than that.
    pub fn what_if(&self, params: &Params, whisker: WhiskerIndex, length: Millimetre) -> Result<WhatIf, WhatIfError> {
        let mut copy = self.clone();
        copy.cut(whisker, length)?;
        // Who would be asked and told does not hang on whether anybody listens just now.
        copy.head.link = Link::Online;
        let now = copy.whiskers.iter().filter_map(|one| one.heard).max().unwrap_or_default();
        copy.head.clock.assume_known(now);
        let mut effects = Vec::new();
        // The decision is shown, whoever must approve it.
        let mut automatic = params.clone();
        automatic.policy.mode = Mode::Automatic;
        copy.decide(&automatic, &mut effects);
        copy.reconcile_all(&automatic, now, &mut effects);
        // What is sent again anyway has nothing to do with the cut.
        let is_new = |index: WhiskerIndex| copy.whiskers[index].desired != self.whiskers[index].desired;
        Ok(WhatIf::of(effects, is_new))
    }

    /// The state that a trim leaves which was found and whose length is settled.
    fn cut(&mut self, index: WhiskerIndex, length: Millimetre) -> Result<(), WhatIfError> {
        if index >= self.whiskers.len() {
            return Err(WhatIfError::UnknownWhisker(index));
        }
        let one = &mut self.whiskers[index];
        let estimate_mm = one.filter.length().length.mm();
        // A cut that is being looked into counts from its result on.
        let present_mm = one.rare.pending_trim.map_or(estimate_mm, |pending| pending.length_before_mm);
        if length.mm() >= present_mm {
            return Err(WhatIfError::NotShorter { asked_mm: length.mm(), present_mm });
        }
        // No length is below what the filter can hold.
        let log_change = (length.mm().max(1.0) / estimate_mm).ln();
        one.filter.jump(log_change, 0.0, [0.0, 0.0, 1.0, 0.0]);
        if one.is_at_nominal_pressure() {
            one.rare.get_or_insert().whole_offset.get_or_insert_with(|| one.filter.offset());
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
        let mut answer = Self { decisions: Vec::new(), ended: Vec::new(), setpoints: Vec::new() };
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
