//! Open batches become transactions, one after the other, and their publications go out.
//!
//! An ordinary transaction is written as rows at once. One with a setpoint is first committed as one row of the intent
//! log, and its publications go out; its rows follow as soon as no other intent must be written. The rows of all
//! transactions are written in the order of sealing.

use std::future::pending;
use std::time::SystemTime;

use tokio::task::JoinHandle;
use tokio::time::Instant;

use crate::engine::Engine;
use crate::engine::commit::batch::Sealed;
use crate::engine::commit::committer::{BytesRefused, Committed, Committer, LeaseLost};
use crate::outbox::Publication;
use vibrissa_edge::clock::wall_clock;
use vibrissa_store::batch::JournalRow;

/// Largest number of intents whose rows are not written yet.
const KEPT_MAX: usize = 16;
/// Number of contacts and whiskers' checkpoints up to which a transaction is written in the engine's own thread.
const SMALL: usize = 200;
/// With more contacts, a transaction is not written twice, as an intent and as rows.
const KEPT_CONTACTS_MAX: usize = 2000;

/// Limit of the contacts kept in the journal for robots whose rows the database has rejected: about 20 MB.
const HELD_FOR_SUSPECTS_MAX: usize = 200_000;
/// Number of robots that get receipts at a time, ten times a second. If more are due, each robot's receipts are less
/// frequent.
const RECEIPTS_AT_ONCE: usize = 500;
/// Number of consecutive transactions that may leave due receipts to the next one.
const PASSED_OVER_MAX: u32 = 8;

/// The part of a transaction that is being written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::engine) enum Part {
    /// The intent: after it the publications go out, and the rows follow.
    Bytes,
    /// The rows: after them the publications go out, if they have not yet.
    Rows,
}

/// Result of the commit task.
pub(in crate::engine) type Done = (Committer, Sealed, Part, Result<Committed, LeaseLost>);

impl Engine {
    /// Seals the open batches, or takes the oldest transaction without rows, and starts its commit.
    pub(in crate::engine) fn begin_commit(&mut self) {
        let Some(mut committer) = self.committer.take() else { return };
        let Some((mut sealed, mut part)) = self.next_commit() else {
            self.committer = Some(committer);
            return;
        };
        let rows = sealed.batch.contacts.len() + sealed.batch.whiskers.len();
        // A small transaction is written in this thread, which avoids waking another.
        let is_small = sealed.bytes.is_some() || rows <= SMALL;
        let commit = async move {
            let kept = match &sealed.bytes {
                Some(bytes) => committer.keep(sealed.number, bytes).await,
                None => Ok(Err(BytesRefused)),
            };
            let committed = match kept {
                Ok(Ok(committed)) => Ok(committed),
                Ok(Err(BytesRefused)) => {
                    (sealed.bytes, sealed.batch.redo_done, part) =
                        (None, sealed.batch.redo_done.filter(|_| sealed.is_out), Part::Rows);
                    committer.commit(&mut sealed.batch).await
                }
                Err(LeaseLost) => Err(LeaseLost),
            };
            (committer, sealed, part, committed)
        };
        self.committing = Some(if is_small { tokio::spawn(commit) } else { self.workers.spawn(commit) });
    }

    /// The next part to write: the intent of a batch with a setpoint, before the rows of earlier intents, before all
    /// else.
    fn next_commit(&mut self) -> Option<(Sealed, Part)> {
        let is_kept = self.is_kept();
        if !is_kept && let Some(sealed) = self.kept.pop_front() {
            return Some((sealed, Part::Rows));
        }
        let mut sealed = self.seal(is_kept);
        if sealed.batch.is_empty() && sealed.publications.is_empty() {
            return None;
        }
        if is_kept && let Some(bytes) = sealed.batch.to_bytes() {
            sealed.batch.redo_done = Some(sealed.number);
            sealed.bytes = Some(bytes);
            return Some((sealed, Part::Bytes));
        }
        // After the rows of earlier intents, if there are any.
        self.kept.push_back(sealed);
        self.kept.pop_front().map(|sealed| (sealed, Part::Rows))
    }

    /// Whether a setpoint waits for the open batches.
    pub(in crate::engine) fn is_urgent(&self) -> bool {
        self.shards.iter().any(|shard| shard.gathering.is_urgent)
    }

    /// Whether the open batches are to be committed as an intent first, because a setpoint waits for them.
    fn is_kept(&self) -> bool {
        let contacts = || self.shards.iter().map(|shard| shard.gathering.batch.contacts.len()).sum::<usize>();
        self.is_urgent()
            && self.kept.len() < KEPT_MAX
            && self.rounds.passed_over() < PASSED_OVER_MAX
            && contacts() < KEPT_CONTACTS_MAX
    }

    /// Seals the open batches of all shards, with the checkpoints that are due.
    ///
    /// An intent is short: it leaves receipts, and checkpoints that may wait, to the next transaction.
    fn seal(&mut self, is_kept: bool) -> Sealed {
        let now = wall_clock();
        let receipts = self.rounds.begin(is_kept, Instant::now());
        self.pace.go_on(now, self.journal_contacts);
        let mut sealed = Sealed { answered: std::mem::take(&mut self.answered), ..Sealed::default() };
        let (mut entries, mut contacts) = (Vec::new(), 0);
        let receipts_at_once = if self.is_ending { usize::MAX } else { RECEIPTS_AT_ONCE / self.shards.len() };
        for shard in &mut self.shards {
            shard.snapshot_decided(&mut self.pace);
            if receipts {
                shard.snapshot_waiting(now, &mut self.pace);
                shard.receipts(receipts_at_once);
            }
            contacts += shard.gathering.seal_into(&mut sealed, &mut entries);
        }
        self.number += 1;
        sealed.number = self.number;
        if !entries.is_empty() {
            self.journal.push_back((self.number, contacts));
            self.journal_contacts += contacts;
            sealed.batch.journal = Some(JournalRow { number: self.number, entries });
        }
        self.forget_journal(receipts, &mut sealed);
        self.number_gatherings();
        sealed
    }

    /// Drops journal entries that all checkpoints contain; `is_round` says whether the database is to delete them, too.
    fn forget_journal(&mut self, is_round: bool, sealed: &mut Sealed) {
        let oldest = self.shards.iter_mut().filter_map(|shard| shard.oldest_waiting()).map(|(number, _)| number).min();
        let needed_from = oldest.unwrap_or(self.number + 1);
        // Entries need not be written if the same transaction writes the checkpoints of all their robots.
        if needed_from > self.number && sealed.batch.journal.take().is_some() {
            self.journal_contacts -= self.journal.pop_back().map_or(0, |(_, contacts)| contacts);
        }
        // A suspect's checkpoint may be rejected, so its entries are needed for longer.
        let is_held = !self.suspects.is_empty() && self.journal_contacts < HELD_FOR_SUSPECTS_MAX;
        while let Some((number, contacts)) =
            self.journal.front().copied().filter(|(number, _)| is_round && !is_held && *number < needed_from)
        {
            self.journal.pop_front();
            self.journal_contacts -= contacts;
            sealed.batch.journal_done = Some(number);
        }
    }

    /// Tells the shards the number of the open transaction.
    pub(in crate::engine) fn number_gatherings(&mut self) {
        for shard in &mut self.shards {
            shard.gathering.number = self.number + 1;
        }
    }

    /// Waits until no transaction is being written, and the rows of all are written.
    pub(in crate::engine) async fn settle(&mut self) -> Result<(), LeaseLost> {
        loop {
            if self.committing.is_some() {
                let done = done(&mut self.committing).await;
                self.committed(done)?;
            }
            if self.kept.is_empty() {
                return Ok(());
            }
            self.begin_commit();
        }
    }

    /// Handles the end of a commit: the publications go out.
    pub(in crate::engine) fn committed(
        &mut self,
        (committer, mut sealed, part, committed): Done,
    ) -> Result<(), LeaseLost> {
        let mut committed = committed?;
        self.committer = Some(committer);
        if committed.was_away {
            self.listen_anew();
        }
        let number = sealed.number;
        if !committed.offenders.is_empty() {
            self.convict(committed.offenders.drain(..).collect(), &mut sealed);
        }
        if part == Part::Rows {
            self.suspects_committed(number);
            self.mailroom.answered(sealed.answered.drain(..));
            if !sealed.batch.records.is_empty() {
                self.mailroom.changed();
            }
        }
        if !sealed.is_out {
            self.go_out(&mut sealed, &committed);
        }
        if part == Part::Bytes {
            (sealed.bytes, sealed.is_out) = (None, true);
            self.kept.push_back(sealed);
        }
        Ok(())
    }

    /// Publishes after the commit, and updates traces and metrics.
    fn go_out(&mut self, sealed: &mut Sealed, committed: &Committed) {
        self.time_taken(&sealed.taken);
        let mut untold = std::mem::take(&mut sealed.untold);
        for (shard, untold) in self.shards.iter_mut().zip(&mut untold) {
            if let Some(lives) = &mut shard.gathering.lives {
                lives.committed(untold, committed.took);
            }
        }
        // Taken before publishing, because a robot may answer before `publish` returns.
        let now = SystemTime::now();
        let all = self.publish(std::mem::take(&mut sealed.publications));
        for (shard, untold) in self.shards.iter_mut().zip(untold) {
            if let Some(lives) = &mut shard.gathering.lives {
                lives.published(untold, now, all);
            }
        }
    }

    /// Publishes after a commit; returns false if messages were dropped. Nothing is lost if the broker is unreachable
    /// or the lease may have expired: setpoints are sent again until they are answered, and receipts with the next
    /// message.
    pub(in crate::engine) fn publish(&self, publications: Vec<Publication>) -> bool {
        let Some(outbox) = &self.outbox else { return true };
        let mut dropped = publications.len();
        if self.lease.is_fresh() {
            dropped = publications.into_iter().filter_map(|one| outbox.try_send(one).err()).count();
        }
        self.metrics.publications_dropped.inc_by(dropped as u64);
        dropped == 0
    }
}

/// Waits for the end of the running commit; forever if there is none.
pub(in crate::engine) async fn done(committing: &mut Option<JoinHandle<Done>>) -> Done {
    let Some(task) = committing else { return pending().await };
    let done = task.await;
    *committing = None;
    // The task is never aborted, so an error means that it has panicked.
    done.unwrap_or_else(|ended| std::panic::resume_unwind(ended.into_panic()))
}
