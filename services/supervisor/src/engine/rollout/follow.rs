//! The stages of a roll-out in the further shards of a fleet.
//!
//! The first shard has the roll-out: it compares the errors of the whole fleet, and decides. The transaction of each stage adds
//! an action `ROLLOUT_STAGE` for every other shard, whose owner executes it within a second, or at its next start.

use vibrissa_core::rollout::place;
use vibrissa_protocol::Name;
use vibrissa_store::actions::Action;
use vibrissa_store::rollouts::StageOfShard;

use super::{Change, TrialParams, malformed};
use crate::engine::actions::{Execution, Problem};

impl Execution<'_> {
    /// Changes the robots of this shard as a stage of the fleet's roll-out says.
    pub(in crate::engine) fn follow_rollout(&mut self, action: &Action) -> Result<(), Problem> {
        let stage: StageOfShard = serde_json::from_str(&action.parameters).map_err(|problem| malformed(&problem))?;
        let change = Change::read(&stage.kind, &stage.change, &self.in_force.params)?;
        let (seed, place_max) = (stage.rollout_id as u64, stage.place_max as u32);
        // An owner that has just started has the newest stage already, and executes those that wait in their order.
        match stage.event.as_str() {
            "STARTED" | "ADVANCED" => {
                let params = change.over(&self.in_force.params)?;
                self.shards.set_trial(Some(&TrialParams { params, seed, place_max }));
            }
            "COMPLETED" => {
                self.shards.set_trial(None);
                self.bring_into_force(&change)?;
            }
            _ => self.shards.set_trial(None),
        }
        let is_concerned = |name: &Name| {
            let place = i64::from(place(seed, name.as_str()));
            place <= stage.place_max && stage.place_before.is_none_or(|before| place > before)
        };
        let robots = self.names(is_concerned);
        self.apply(&change, &robots);
        Ok(())
    }

    /// Puts a change in force that the first shard has recorded. At the start of this shard it may have been in force already.
    fn bring_into_force(&mut self, change: &Change) -> Result<(), Problem> {
        match change {
            Change::Policy(policy, version) if *version >= self.in_force.policy_version => {
                self.put_in_force(policy, *version);
            }
            Change::Policy(..) => {}
            Change::Calibration(_) => self.set_params(change.over(&self.in_force.params)?),
        }
        Ok(())
    }
}
