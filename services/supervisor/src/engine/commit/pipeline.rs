//! What was gathered becomes transactions, one after the other; what waits for them goes out.
//!
//! Ordinary transactions are written at once. One with a setpoint is first kept as it is, in one short row, and what waits
//! for it goes out; its rows follow as soon as nothing else is to be kept. All rows are written in the order in which their
//! transactions were sealed.

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

/// Transactions that may be kept before the rows of the first must be written.
const KEPT_MAX: usize = 16;
/// Contacts and states of whiskers in a transaction that holds nothing up.
const SMALL: usize = 200;
/// With more contacts a transaction is not worth writing twice, in bytes and in rows.
const KEPT_CONTACTS_MAX: usize = 2000;

/// Contacts kept in the journal at most for robots whose rows the database has refused: some 20 MB.
const HELD_FOR_SUSPECTS_MAX: usize = 200_000;
/// Robots that are sent receipts at a time, ten times a second: of more each one's comes a bit less often.
const RECEIPTS_AT_ONCE: usize = 500;
/// How often receipts may come with the next one instead, one after the other.
const PASSED_OVER_MAX: u32 = 8;

/// What is being written of a transaction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::engine) enum Part {
    /// Its bytes: what waits for it goes out then, and its rows follow.
    Bytes,
    /// Its rows: what still waits for it goes out then.
    Rows,
}

/// What the commit under way gives back.
pub(in crate::engine) type Done = (Committer, Sealed, Part, Result<Committed, LeaseLost>);

impl Engine {
    /// Closes what was gathered, or takes the next one whose rows are to be written, and has it committed while more is gathered.
    pub(in crate::engine) fn begin_commit(&mut self) {
        let Some(mut committer) = self.committer.take() else { return };
        let Some((mut sealed, mut part)) = self.next_commit() else {
            self.committer = Some(committer);
            return;
        };
        let rows = sealed.batch.contacts.len() + sealed.batch.whiskers.len();
        // What is small is written in this thread, without waking another.
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

    /// What is to be written now: what has a setpoint before the rows of what was kept, these before all else.
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
        // Behind what was kept before, if there is any after all.
        self.kept.push_back(sealed);
        self.kept.pop_front().map(|sealed| (sealed, Part::Rows))
    }

    /// Whether a setpoint waits for what is gathered.
    pub(in crate::engine) fn is_urgent(&self) -> bool {
        self.shards.iter().any(|shard| shard.gathering.is_urgent)
    }

    /// Whether what is gathered is kept first, because a setpoint waits for it.
    fn is_kept(&self) -> bool {
        let contacts = || self.shards.iter().map(|shard| shard.gathering.batch.contacts.len()).sum::<usize>();
        self.is_urgent()
            && self.kept.len() < KEPT_MAX
            && self.rounds.passed_over() < PASSED_OVER_MAX
            && contacts() < KEPT_CONTACTS_MAX
    }

    /// Takes what was gathered out of the shards, with the states that are to be written.
    ///
    /// What is kept first is short: receipts, and states that may wait, come with the next one.
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

    /// Entries that are in all states are not needed any more; `is_round` says whether to tell the database so.
    fn forget_journal(&mut self, is_round: bool, sealed: &mut Sealed) {
        let oldest = self.shards.iter_mut().filter_map(|shard| shard.oldest_waiting()).map(|(number, _)| number).min();
        let needed_from = oldest.unwrap_or(self.number + 1);
        // What is written with the states of all whom it is about need not be written.
        if needed_from > self.number && sealed.batch.journal.take().is_some() {
            self.journal_contacts -= self.journal.pop_back().map_or(0, |(_, contacts)| contacts);
        }
        // A suspect's state may be refused, and then its entries are needed longer than its state says.
        let is_held = !self.suspects.is_empty() && self.journal_contacts < HELD_FOR_SUSPECTS_MAX;
        while let Some((number, contacts)) =
            self.journal.front().copied().filter(|(number, _)| is_round && !is_held && *number < needed_from)
        {
            self.journal.pop_front();
            self.journal_contacts -= contacts;
            sealed.batch.journal_done = Some(number);
        }
    }

    /// Tells the shards which transaction they gather for from now on.
    pub(in crate::engine) fn number_gatherings(&mut self) {
        for shard in &mut self.shards {
            shard.gathering.number = self.number + 1;
        }
    }

    /// Waits until nothing is being written, nor waits for its rows.
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

    /// A commit has ended: now what waited for it goes out.
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

    /// What waited for a transaction goes out, and it is told of.
    fn go_out(&mut self, sealed: &mut Sealed, committed: &Committed) {
        self.time_taken(&sealed.taken);
        let mut untold = std::mem::take(&mut sealed.untold);
        for (shard, untold) in self.shards.iter_mut().zip(&mut untold) {
            if let Some(lives) = &mut shard.gathering.lives {
                lives.committed(untold, committed.took);
            }
        }
        // Taken before: a robot's answer can be there before this is through.
        let now = SystemTime::now();
        let all = self.publish(std::mem::take(&mut sealed.publications));
        for (shard, untold) in self.shards.iter_mut().zip(untold) {
            if let Some(lives) = &mut shard.gathering.lives {
                lives.published(untold, now, all);
            }
        }
    }

    /// Sends what waited for the commit. Nothing is lost if the broker is away: setpoints are sent again
    /// until answered, receipts with the next message. Nor if the fleet may be somebody else's by now.
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

/// What the commit under way gives back, when it has ended; never if there is none.
pub(in crate::engine) async fn done(committing: &mut Option<JoinHandle<Done>>) -> Done {
    let Some(task) = committing else { return pending().await };
    let done = task.await;
    *committing = None;
    // It is never aborted: if it has no result, it has panicked.
    done.unwrap_or_else(|ended| std::panic::resume_unwind(ended.into_panic()))
}
