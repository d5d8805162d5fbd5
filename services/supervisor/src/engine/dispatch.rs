//! Distribution of messages to the workers. A message that needs row ids from the database first is handled alone, in
//! its turn; all others are handled by the workers in parallel.

use tokio::time::Instant;
use tracing::error;
use vibrissa_protocol::{Name, RobotTopic, Topic};

use super::Engine;
use super::commit::committer::{LeaseLost, Outage};
use super::message::RawMessage;
use super::part::index_of;
use super::quarantine::suspect::{Turn, quarantined};
use crate::inbox::Incoming;
use crate::log_inbox::{LogBatch, LogRange, LogRecord};
use vibrissa_core::units::Micros;
use vibrissa_edge::clock::wall_clock;
use vibrissa_edge::full_name::FullName;
use vibrissa_store::LogPositions;
use vibrissa_store::fault::{self, Fault};

/// Messages are stepped, and the room of the batches is checked, when their robots have this many whiskers together:
/// each message can need a checkpoint of all its robot's whiskers. Commits of 95,000 states took up to 4 s.
const WHISKERS_AT_A_TIME: usize = 16_384;

impl Engine {
    /// Steps messages through the core, those of each robot in order.
    pub(super) async fn take_in(&mut self, incoming: &mut Vec<Incoming>) -> Result<(), LeaseLost> {
        let count = incoming.len();
        let mut messages: Vec<Vec<RawMessage>> = self.workers.iter().map(|_| Vec::new()).collect();
        let mut whiskers = 0;
        for incoming in incoming.drain(..) {
            let Some(raw) = self.address(incoming) else { continue };
            let Some(raw) = self.suspects.pass(raw) else { continue };
            if raw.kind == RobotTopic::Factsheet {
                self.workers.handle(&mut messages, false, &self.background).await;
                self.take_factsheet(raw).await?;
            } else {
                whiskers += self.workers.robot(&raw.robot).map_or(0, |known| known.whisker_ids.len());
                messages[index_of(&raw.robot, self.workers.count())].push(raw);
            }
            if whiskers >= WHISKERS_AT_A_TIME {
                whiskers = 0;
                self.workers.handle(&mut messages, false, &self.background).await;
                self.make_room().await?;
            }
        }
        self.workers.handle(&mut messages, false, &self.background).await;
        self.pipeline.stepped(count, &self.workers);
        Ok(())
    }

    /// Begins a commit of full batches, after the one that is being written.
    async fn make_room(&mut self) -> Result<(), LeaseLost> {
        if !self.workers.has_room() {
            self.settle().await?;
            self.begin_commit();
        }
        Ok(())
    }

    /// Steps messages of the partitioned log, in its order. The journal only refers to them.
    pub(super) async fn take_in_log(&mut self, batch: LogBatch) -> Result<(), LeaseLost> {
        let LogBatch { range, records } = batch;
        let LogRange { partition, from, to } = range;
        if fault::is(Fault::OffsetBeforeState) {
            self.settle().await?;
            let topic = self.log.as_ref().map(|log| log.topic().into()).unwrap_or_default();
            if let Some(committer) = self.pipeline.idle_committer() {
                let (writer, lease) = committer.database();
                let positions = LogPositions { topic, next: [(partition, to)].into() };
                // A fault planted by a test: what fails here is lost, too.
                let _ = writer.set_log_positions(lease, &positions).await;
            }
        }
        let (count, received) = (records.len(), wall_clock());
        self.metrics.promises.received(count as u64);
        let mut messages: Vec<Vec<RawMessage>> = self.workers.iter().map(|_| Vec::new()).collect();
        let mut except = Vec::new();
        for LogRecord { offset, topic, robot, kind, payload } in records {
            self.metrics.messages_received.count([kind.as_str()]);
            let received = Micros(received.0 + offset.abs_diff(from));
            let raw = RawMessage { topic, robot, kind, payload, received };
            // A replay must leave out what is not stepped here and now.
            let worker = self.workers.of(&raw.robot);
            if self.suspects.has(&raw.robot) || !worker.takes(&raw.robot) {
                except.extend(worker.robot_id(&raw.robot));
            }
            if let Some(raw) = self.suspects.pass(raw) {
                messages[index_of(&raw.robot, self.workers.count())].push(raw);
            }
        }
        let are_there: Vec<bool> = messages.iter().map(|messages| !messages.is_empty()).collect();
        self.workers.handle(&mut messages, true, &self.background).await;
        for (worker, _) in self.workers.iter_mut().zip(are_there).filter(|(_, is_there)| *is_there) {
            worker.refer(received, range, &except);
        }
        self.pipeline.set_log_next(partition, to);
        self.pipeline.stepped(count, &self.workers);
        self.pipeline.took(count as u64, &self.workers);
        Ok(())
    }

    /// The robot of a message; `None` if the message is not from a robot of the fleet.
    fn address(&self, incoming: Incoming) -> Option<RawMessage> {
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
        Some(RawMessage { topic, robot, kind, payload, received })
    }

    /// Handles a factsheet that needs row ids for a robot, boot or whiskers, and waits while the database is
    /// unreachable. The factsheet is stepped after it has its ids. If the database rejects it permanently, it is put
    /// into quarantine.
    async fn take_factsheet(&mut self, raw: RawMessage) -> Result<(), LeaseLost> {
        let Some(factsheet) = self.workers.of(&raw.robot).factsheet(&raw) else { return Ok(()) };
        if self.workers.robot(&raw.robot).is_none()
            && let Some(reason) = self.has_no_room_for_another()
        {
            self.workers.of(&raw.robot).refuse_new(&raw, reason);
            return Ok(());
        }
        let (mut outage, mut is_again) = (Outage::default(), false);
        loop {
            self.settle().await?;
            let Some(committer) = self.pipeline.idle_committer() else { return Ok(()) };
            let worker = self.workers.of(&raw.robot);
            let attempt = (&factsheet, std::mem::replace(&mut is_again, true));
            let Err(problem) = worker.handle_factsheet(&raw, attempt, committer).await else {
                let was_away = committer.end_of(&outage);
                if was_away {
                    self.restart_silence_timers();
                }
                self.workers.of(&raw.robot).batch_mut().push_message(raw);
                return self.make_room().await;
            };
            if let Some(rejection) = problem.rejection() {
                let robot = FullName::robot(self.fleet.as_str(), raw.robot.as_str());
                error!(%problem, %robot, "database rejects this message for good");
                self.suspects.quarantine(quarantined(&raw, &rejection), &mut self.workers, &mut self.pipeline);
                return Ok(());
            }
            committer.wait_out(&mut outage, problem, "cannot assign row ids").await?;
        }
    }

    /// Reason why no new robot is accepted now, if there is one.
    fn has_no_room_for_another(&mut self) -> Option<&'static str> {
        if self.workers.robot_count() >= self.limits.robots_per_fleet as usize {
            return Some("too_many_robots");
        }
        (!self.new_robots.take(Instant::now())).then_some("too_many_new_robots")
    }

    /// Steps the next messages of suspects.
    pub(super) async fn step_suspects(&mut self) -> Result<(), LeaseLost> {
        let now = tokio::time::Instant::now();
        for (name, turns) in self.suspects.begin(now, &mut self.workers) {
            self.step_turns(&name, turns).await?;
        }
        self.suspects.clear(now, &self.workers);
        Ok(())
    }

    async fn step_turns(&mut self, name: &Name, turns: Vec<Turn>) -> Result<(), LeaseLost> {
        let count = turns.len();
        for turn in turns {
            // A transaction sealed meanwhile may have been rejected: then all turns wait again.
            if !self.suspects.is_under_way(name) {
                return Ok(());
            }
            match turn {
                Turn::Receipt(raw) => self.workers.of(name).receipt_alone(&raw),
                Turn::Message(raw) if raw.kind == RobotTopic::Factsheet => self.take_factsheet(raw).await?,
                Turn::Message(raw) => self.workers.of(name).handle(&raw),
            }
        }
        // The suspect keeps these messages, not the transaction.
        self.workers.of(name).batch_mut().retain_messages(|raw| raw.robot != *name);
        let number = self.pipeline.open_number();
        self.suspects.stepped(name, number);
        self.pipeline.stepped(count, &self.workers);
        self.pipeline.commit_now();
        if self.workers.is_empty() && !self.pipeline.is_writing() {
            // The messages had no effects.
            self.suspects.committed(number);
        }
        Ok(())
    }
}
