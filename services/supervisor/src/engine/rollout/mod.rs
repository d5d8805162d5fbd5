//! Staged roll-outs of a fleet: some robots get a change before the others, and their errors decide about the rest.
//!
//! The core decides ([`vibrissa_core::rollout`]); here is the state, and `actions::rollouts` steps the chosen robots.
//! The state is a row of the database, written in the transaction in which robots change, so a roll-out survives its
//! owner. The changed robots have parameters of their own ([`TrialParams`]); those of the fleet stay until the last stage.

pub(super) mod change;
pub(super) mod compare;
pub(super) mod trial;

use std::sync::Arc;

use tracing::warn;
use vibrissa_core::robot::Params;
use vibrissa_core::rollout::Stage;
use vibrissa_edge::words::named;
use vibrissa_protocol::{Name, plain};
use vibrissa_store::rollouts::RolloutRow;

use change::Change;
use trial::TrialParams;

/// The roll-out of a fleet that is running or paused.
#[derive(Debug, Clone)]
pub(super) struct Rollout {
    pub(super) row: RolloutRow,
    pub(super) change: Change,
    pub(super) params: Arc<Params>,
}

impl Rollout {
    /// Takes a roll-out up that another owner has begun.
    ///
    /// # Errors
    /// This program cannot read the change, or the change does not fit the parameters.
    pub(super) fn restored(row: RolloutRow, base: &Arc<Params>) -> Result<Self, String> {
        let change = Change::read(&row.kind, &row.change, base)?;
        Ok(Self { params: change.over(base)?, change, row })
    }

    pub(super) fn trial(&self) -> TrialParams {
        let (seed, place_max) = (self.row.rollout_id as u64, self.row.place_max as u32);
        TrialParams { params: self.params.clone(), seed, place_max }
    }

    pub(super) fn stage(&self) -> Stage {
        named(&self.row.stage).unwrap_or(Stage::Few)
    }

    /// Time since which decisions count, if the errors are to be compared.
    pub(super) fn compares_since(&self) -> Option<i64> {
        (self.row.state == "RUNNING" && self.stage() != Stage::All).then_some(self.row.stage_us)
    }

    /// Stage for the metrics: 1 for 5 %, 2 for 25 %.
    pub(super) fn stage_number(&self) -> i64 {
        self.stage() as i64 + 1
    }
}

/// The parameters of a robot of a fleet with this roll-out, where the base is those of the fleet.
pub(crate) fn params_of(row: RolloutRow, base: Arc<Params>, robot: &Name) -> Arc<Params> {
    let number = row.rollout_id;
    match Rollout::restored(row, &base).map(|open| open.trial()) {
        Ok(trial) if trial.has(robot) => trial.params,
        Ok(_) => base,
        Err(problem) => {
            warn!(rollout = number, problem, "cannot read a roll-out, using the parameters of the fleet");
            base
        }
    }
}

/// A change or an order that is not in its stored form.
pub(super) fn malformed(problem: &serde_json::Error) -> String {
    format!("MALFORMED: {}", plain::data(&problem.to_string()))
}

/// A person's order to a roll-out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Order {
    Pause,
    Resume,
    Advance,
    RollBack,
}
