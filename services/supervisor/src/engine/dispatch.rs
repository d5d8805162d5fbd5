//! Distribution of messages to the shards. A message that needs row ids from the database first is handled alone, in
//! its turn; all others are handled by the shards in parallel.

use std::time::Instant;

use tracing::error;
use vibrissa_protocol::{RobotTopic, Topic};

use super::Engine;
use super::commit::committer::{LeaseLost, Outage};
use super::intake::Parcel;
use super::quarantine::suspects;
use super::shard::{Shard, shard_of};
use crate::inbox::Incoming;

/// Number of messages from which on the shards work in tasks of their own.
const WORTH_TASKS: usize = 128;
/// Payload bytes from which on the shards work in tasks, about a millisecond's work. Meanwhile this thread receives, so
/// that no robot's messages wait in the broker behind those of a robot that sends much.
const WORTH_A_TASK_BYTES: usize = 128 * 1024;

impl Engine {
    /// Steps messages through the core, those of each robot in order.
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

    /// The shard of a message; `None` if the message is not from a robot of the fleet.
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

    /// Handles the parcels in their shards; each shard is owned by one task until it is done.
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
            // The task is never aborted, so an error means that it has panicked.
            let shard: Shard = task.await.unwrap_or_else(|ended| std::panic::resume_unwind(ended.into_panic()));
            self.shards.push(shard);
        }
    }

    /// Handles a factsheet that needs row ids for a robot, boot or whiskers, and waits while the database is
    /// unreachable. The factsheet is stepped after it has its ids. If the database rejects it permanently, it is put
    /// into quarantine.
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
                error!(%problem, fleet = %self.fleet, robot = %parcel.robot, "database rejects this message for good");
                self.quarantine(suspects::quarantined(&parcel, &rejection));
                return Ok(());
            }
            committer.wait_out(&mut outage, problem, "cannot assign row ids").await?;
        }
    }

    /// Reason why no new robot is accepted now, if there is one.
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
