//! Reads what operators change between two batches: actions, allow lists, and the errors that decide about a roll-out.

use tokio::time::Instant;
use tracing::warn;
use vibrissa_core::units::Micros;
use vibrissa_protocol::Refusal;
use vibrissa_store::actions::{Action, Pending};
use vibrissa_store::refusals::RefusalRow;
use vibrissa_store::{Lease, StoreError, Writer};

use super::Engine;
use super::actions::{ACTIONS_MAX, Execution};
use super::commit::committer::LeaseLost;
use super::decommission::leaves;
use super::quarantine::suspects::Suspects;
use super::rollout::Rollout;
use crate::readiness::SET_ASIDE_TOLD;

/// Most robots whose refusals are written at a time.
const REFUSING_ROBOTS_AT_A_TIME: usize = 100;

/// Name of refused messages in the service's readiness.
const REFUSED: &str = "refused";

/// Reads actions that are pending, and whether there are more. Those for suspects wait: however many they are, the ones of
/// others are read.
async fn read_pending(writer: &mut Writer, lease: &Lease, suspects: &Suspects) -> Result<(Pending, bool), StoreError> {
    let is_full = |read: &Pending| (read.actions.len() + read.unreadable.len()) as i64 == ACTIONS_MAX;
    let first = writer.pending(lease, ACTIONS_MAX, &[]).await?;
    if !is_full(&first) || suspects.is_empty() {
        let are_more = is_full(&first);
        return Ok((first, are_more));
    }
    let mut read = writer.pending(lease, ACTIONS_MAX, &suspects.names()).await?;
    let are_more = is_full(&read);
    // One of a suspect may have expired.
    let of_suspects = |action: &Action| read.actions.iter().all(|other| other.action_id != action.action_id);
    let waiting: Vec<Action> = first.actions.into_iter().filter(of_suspects).collect();
    read.actions.extend(waiting);
    read.unreadable.extend(first.unreadable);
    read.actions.sort_by_key(|action| action.action_id);
    read.unreadable.sort_unstable();
    read.unreadable.dedup();
    Ok((read, are_more))
}

impl Engine {
    /// Executes the pending actions. If the database is unreachable, this does not wait: the actions stay pending.
    ///
    /// The answers so far are committed first, because actions without a committed answer would be read again.
    pub(super) async fn handle_actions(&mut self, now: Micros) -> Result<(), LeaseLost> {
        self.settle().await?;
        if self.pipeline.has_answers() {
            return Ok(());
        }
        let Some(committer) = self.pipeline.idle_committer() else { return Ok(()) };
        let (writer, lease) = committer.database();
        let read = read_pending(writer, lease, &self.suspects).await;
        let (Pending { actions: pending, unreadable }, are_more) = match read {
            Ok(read) => read,
            Err(problem) => {
                committer.failed(&problem, "cannot read operator actions");
                return Ok(());
            }
        };
        if are_more {
            self.action_sent.notify_one();
        }
        let (leaving, others): (Vec<&Action>, Vec<&Action>) = pending.iter().partition(|action| leaves(action));
        let Self { fleet, workers, in_force, rollout, metrics, suspects, pipeline, .. } = self;
        let mut execution = Execution { fleet, workers, in_force, rollout, metrics, now };
        for action in others {
            execution.handle(action, suspects, pipeline);
        }
        for action_id in unreadable {
            execution.refuse_unreadable(action_id, pipeline);
        }
        for action in leaving {
            self.decommission(action).await?;
        }
        self.show_rollout();
        self.pipeline.stepped(0, &self.workers);
        Ok(())
    }

    /// Answers an action outside of [`Execution`]; `None` if it has expired.
    pub(super) fn answer(&mut self, action: &Action, robot_id: i64, done: Option<Result<(), String>>) {
        let Self { fleet, workers, in_force, rollout, metrics, pipeline, .. } = self;
        let mut execution = Execution { fleet, workers, in_force, rollout, metrics, now: Micros::default() };
        execution.answer(action, robot_id, done, pipeline);
    }

    /// Compares the errors of a roll-out. If the database is unreachable, this does not wait.
    pub(super) async fn review_rollout(&mut self, now: Micros) -> Result<(), LeaseLost> {
        let Some(since_us) = self.rollout.as_ref().and_then(Rollout::compares_since) else { return Ok(()) };
        self.settle().await?;
        let Some(committer) = self.pipeline.idle_committer() else { return Ok(()) };
        let (writer, lease) = committer.database();
        let errors = match writer.errors_since(lease, since_us).await {
            Ok(errors) => errors,
            Err(problem) => {
                committer.failed(&problem, "cannot read the errors of a roll-out");
                return Ok(());
            }
        };
        let Some(rollout) = self.rollout.as_mut() else { return Ok(()) };
        let comparison = rollout.compare(&errors);
        let Self { fleet, workers, in_force, rollout, metrics, .. } = self;
        Execution { fleet, workers, in_force, rollout, metrics, now }.review_rollout(comparison);
        self.show_rollout();
        self.pipeline.stepped(0, &self.workers);
        Ok(())
    }

    fn show_rollout(&self) {
        self.metrics.rollout_stage.set(self.rollout.as_ref().map_or(0, Rollout::stage_number));
    }

    /// Reads the allow lists if they have changed, and writes the refused robots. If the database is unreachable, this
    /// does not wait.
    pub(super) async fn refresh_allow_list(&mut self) -> Result<(), LeaseLost> {
        self.allow_list.read_changed_file(&mut self.workers);
        self.settle().await?;
        if let Some(committer) = self.pipeline.idle_committer() {
            self.allow_list.refresh(committer, &mut self.workers).await;
        }
        Ok(())
    }

    /// Excludes the robots that the allow lists exclude now, before anything goes out that moves a robot. Returns false if the list
    /// cannot be read.
    pub(super) async fn excludes_all_that_the_list_does(&mut self) -> bool {
        self.allow_list.read_changed_file(&mut self.workers);
        let Some(committer) = self.pipeline.idle_committer() else { return false };
        self.allow_list.expect_change();
        self.allow_list.read(committer, &mut self.workers).await
    }

    /// Writes the counts of refusals. If the database is unreachable, this does not wait.
    pub(super) async fn write_refusals(&mut self) -> Result<(), LeaseLost> {
        if !self.workers.robots().any(|known| known.refusals.are_due()) {
            return Ok(());
        }
        self.settle().await?;
        let rows = self.workers.refusals(REFUSING_ROBOTS_AT_A_TIME, self.refusals_written_to);
        if let Some(committer) = self.pipeline.idle_committer() {
            let (writer, lease) = committer.database();
            match writer.add_refusals(lease, &rows).await {
                Ok(()) => {
                    self.workers.refusals_written(&rows);
                    self.refusals_written_to = rows.last().map_or(0, |row| row.robot_id);
                    self.tell_refusals(&rows);
                }
                Err(problem) => warn!(%problem, fleet = %self.fleet, "cannot count refused messages"),
            }
        }
        Ok(())
    }

    /// Names for a while a robot whose messages are not those of the contract, as for items that are set aside.
    fn tell_refusals(&mut self, rows: &[RefusalRow]) {
        let now = Instant::now();
        if self.refusals_told_from > now {
            return;
        }
        let Some(row) = rows.iter().find(|row| Refusal::LABELS.contains(&row.reason)) else { return };
        let Some(known) = self.workers.robots().find(|known| known.robot_id == row.robot_id) else { return };
        let (robot, RefusalRow { topic, reason, problem, .. }) = (known.full_name(), row);
        let what =
            format!("messages of robot {robot} are refused ({topic}, {reason}): {problem}. Its page counts them");
        self.refusals_told_from = now + SET_ASIDE_TOLD;
        self.readiness.tell_set_aside(&self.fleet, REFUSED, &what);
    }
}
