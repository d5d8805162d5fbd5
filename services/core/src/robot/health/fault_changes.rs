//! The fault and the vents of a whisker, with the changes behind them.

use crate::robot::effect::Fault;
use crate::robot::health::flapping::{Flapping, Vent};
use crate::robot::params::FlappingParams;
use crate::robot::state::whisker::{Holds, Whisker};
use crate::units::Micros;

/// A whisker's fault, and the changes behind it.
pub(in crate::robot) type FaultState = (Option<Fault>, Option<Flapping<Fault>>);

impl Whisker {
    /// Its fault and the changes behind it once the newest evidence is taken in.
    pub(in crate::robot) fn with_evidence(
        &self,
        params: &FlappingParams,
        now: Micros,
        present: Option<Fault>,
    ) -> FaultState {
        let known = self.rare.flapping;
        if present == Some(Fault::Stale) {
            // The fault before the silence goes on, and so does its alarm.
            let before = self.fault.filter(|&fault| fault != Fault::Stale);
            return (present, known.or_else(|| before.map(|fault| Flapping::steady(Some(fault)))));
        }
        if known.is_none() && (present == self.fault || (present.is_none() && self.fault == Some(Fault::Stale))) {
            return (present, None);
        }
        let mut flapping = known.unwrap_or_else(|| Flapping::steady(self.fault.filter(|&fault| fault != Fault::Stale)));
        flapping.observe(params, now, present);
        (flapping.reported, Some(flapping).filter(|flapping| !flapping.is_over(params, now)))
    }

    /// The fault, other than silence, whose alarm stands.
    pub(in crate::robot) fn fault_with_alarm(&self) -> Option<Fault> {
        let steady = self.fault.filter(|&fault| fault != Fault::Stale);
        self.rare.flapping.map_or(steady, |flapping| flapping.alarm)
    }

    /// The changes behind its alarm VENTED once the newest evidence is taken in; none if it has long not been vented.
    pub(in crate::robot) fn vents_with_evidence(&self, params: &FlappingParams, now: Micros) -> Option<Flapping<Vent>> {
        let present = Some(Vent).filter(|_| self.holds == Holds::Vented && self.desired.is_none());
        if present.is_none() && self.rare.vents.is_none() {
            return None;
        }
        let mut vents = self.rare.vents.unwrap_or_else(|| Flapping::steady(None));
        vents.observe(params, now, present);
        Some(vents).filter(|vents| present.is_some() || !vents.is_over(params, now))
    }

    /// Whether the alarm VENTED is due. A pressure that is on its way ends it.
    pub(in crate::robot) fn has_vented_alarm(&self) -> bool {
        self.desired.is_none() && self.rare.vents.is_some_and(|vents| vents.alarm.is_some())
    }

    /// When time alone changes its fault, its vents, or an alarm of them.
    pub(in crate::robot) fn flapping_times(&self, params: &FlappingParams) -> impl Iterator<Item = Micros> {
        let of_fault = self.rare.flapping.map(|flapping| flapping.times(params));
        let of_vents = self.rare.vents.map(|vents| vents.times(params));
        of_fault.into_iter().chain(of_vents).flatten()
    }
}
