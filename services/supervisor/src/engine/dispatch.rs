//! Messages on their way to the shards: what needs numbers from the database first is handled by itself, in its turn;
//! everything else by all shards at the same time.

use std::time::Instant;

use tracing::error;
use vibrissa_protocol::{RobotTopic, Topic};

use super::Engine;
use super::commit::committer::{LeaseLost, Outage};
use super::intake::Parcel;
use super::quarantine::suspects;
use super::shard::{Shard, shard_of};
use crate::inbox::Incoming;

/// Parcels of one round that are worth several tasks.
const WORTH_TASKS: usize = 128;
/// Bytes that are worth a task of their own, about a millisecond's work: meanwhile this thread receives, so that nobody's messages
/// wait in the broker behind those of a robot that sends much.
const WORTH_A_TASK_BYTES: usize = 128 * 1024;

impl Engine {
    /// Steps messages, in the order of each robot's.
    pub(super) async fn take_in(&mut self, messages: &mut Vec<Incoming>) -> Result<(), LeaseLost> {
        let count = messages.len();
        let mut parcels: Vec<Vec<Parcel>> = self.shards.iter().map(|_| Vec::new()).collect();
        for incoming in messages.drain(..) {
            let Some((shard, parcel)) = self.address(incoming) else { continue };
            let Some(parcel) = self.unless_suspect(parcel) else { continue };
            if parcel.kind == RobotTopic::Factsheet {
                self.handle_parcels(&mut parcels).await;
                self.take_factsheet(shard, parcel).await?;
            } else {
                parcels[shard].push(parcel);
            }
        }
        self.handle_parcels(&mut parcels).await;
        self.gathered(count);
        Ok(())
    }

    /// Which shard a message is for; none if it is none of a robot of the fleet.
    fn address(&self, incoming: Incoming) -> Option<(usize, Parcel)> {
        let Ok(text) = std::str::from_utf8(&incoming.topic) else {
            self.metrics.refuse("unknown_topic", "a topic that is not UTF-8", "");
            return None;
        };
        let topic = match Topic::parse(text) {
            Ok(topic) => topic,
            Err(refusal) => {
                self.metrics.refuse(refusal.label(), &refusal, text);
                return None;
            }
        };
        let Topic::Robot { fleet, robot, kind } = &topic else { return None };
        if *fleet != self.fleet || !kind.is_from_robot() {
            return None;
        }
        self.metrics.messages_received.count([kind.as_str()]);
        let (robot, kind) = (robot.clone(), *kind);
        let Incoming { payload, received, .. } = incoming;
        Some((shard_of(&robot, self.shards.len()), Parcel { topic, robot, kind, payload, received }))
    }

    /// Gives each shard its parcels; each shard is one task's as long as it works.
    async fn handle_parcels(&mut self, parcels: &mut [Vec<Parcel>]) {
        let busy = parcels.iter().filter(|parcels| !parcels.is_empty()).count();
        let is_few = busy <= 1 || parcels.iter().map(Vec::len).sum::<usize>() < WORTH_TASKS;
        let bytes: usize = parcels.iter().flatten().map(|parcel| parcel.payload.len()).sum();
        if is_few && bytes < WORTH_A_TASK_BYTES {
            for (shard, parcels) in self.shards.iter_mut().zip(parcels) {
                shard.handle_all(parcels);
            }
            return;
        }
        let mut tasks = Vec::with_capacity(self.shards.len());
        for (mut shard, parcels) in self.shards.drain(..).zip(parcels) {
            let mut parcels = std::mem::take(parcels);
            tasks.push(self.workers.spawn(async move {
                shard.handle_all(&mut parcels);
                shard
            }));
        }
        for task in tasks {
            // It is never aborted: without a result it has panicked.
            let shard: Shard = task.await.unwrap_or_else(|ended| std::panic::resume_unwind(ended.into_panic()));
            self.shards.push(shard);
        }
    }

    /// Handles a factsheet, by which new robots, boots or whiskers have numbers from the database; one that is away is waited
    /// for. Nothing is stepped before its numbers are there. A factsheet whose numbers the database refuses for good is put into
    /// quarantine.
    pub(super) async fn take_factsheet(&mut self, shard: usize, parcel: Parcel) -> Result<(), LeaseLost> {
        let Some(told) = self.shards[shard].factsheet(&parcel) else { return Ok(()) };
        if !self.shards[shard].robots.contains_key(&parcel.robot)
            && let Some(reason) = self.has_no_room_for_another()
        {
            self.shards[shard].refuse_new(&parcel, reason);
            return Ok(());
        }
        let (mut outage, mut is_again) = (Outage::default(), false);
        loop {
            self.settle().await?;
            let Some(committer) = &mut self.committer else { return Ok(()) };
            let told = (&told, std::mem::replace(&mut is_again, true));
            let Err(problem) = self.shards[shard].handle_factsheet(&parcel, told, committer).await else {
                if committer.end_of(&outage) {
                    self.listen_anew();
                }
                self.shards[shard].gathering.messages.push(parcel);
                if !self.has_room() {
                    self.begin_commit();
                }
                return Ok(());
            };
            if let Some(rejection) = problem.rejection() {
                error!(%problem, fleet = %self.fleet, robot = %parcel.robot, "the database refuses this message for good");
                self.quarantine(suspects::quarantined(&parcel, &rejection));
                return Ok(());
            }
            committer.wait_out(&mut outage, problem, "new things cannot be numbered").await?;
        }
    }

    /// Why no new robot is taken now, if so.
    fn has_no_room_for_another(&mut self) -> Option<&'static str> {
        let robots: usize = self.shards.iter().map(|shard| shard.robots.len()).sum();
        if robots >= self.limits.robots_per_fleet as usize {
            return Some("too_many_robots");
        }
        (!self.new_robots.take(Instant::now())).then_some("too_many_new_robots")
    }
}

impl Shard {
    fn handle_all(&mut self, parcels: &mut Vec<Parcel>) {
        for parcel in parcels.drain(..) {
            self.gathering.has_stepped = false;
            self.handle(&parcel);
            if self.gathering.has_stepped {
                self.gathering.messages.push(parcel);
            }
        }
    }
}
