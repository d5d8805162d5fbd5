//! The extent of a fleet's journal in the database.

use std::collections::VecDeque;

use crate::engine::commit::transaction::SealedTransaction;

/// Limit of the contacts kept in the journal for robots whose rows the database has rejected: about 20 MB.
const HELD_CONTACTS_MAX: usize = 200_000;

/// Transactions whose entries are still in the journal.
#[derive(Debug)]
pub(in crate::engine) struct JournalIndex {
    /// Number of the last sealed transaction.
    last: i64,
    /// Transactions with entries in the journal, with the number of their contacts.
    transactions: VecDeque<(i64, usize)>,
    contacts: usize,
}

impl JournalIndex {
    /// The journal of a fleet after its recovery, up to the transaction `last`. It is deleted once the first
    /// checkpoints are written, because all its entries were replayed.
    pub(in crate::engine) fn recovered(last: i64) -> Self {
        Self { last, transactions: (last > 0).then_some((last, 0)).into_iter().collect(), contacts: 0 }
    }

    /// Number of the transaction that is sealed next.
    pub(in crate::engine) fn next(&self) -> i64 {
        self.last + 1
    }

    /// Number of contacts in the journal.
    pub(in crate::engine) fn contacts(&self) -> usize {
        self.contacts
    }

    /// Adds the transaction that is sealed now.
    pub(in crate::engine) fn append(&mut self, transaction: &SealedTransaction) {
        self.last = transaction.number;
        if transaction.rows.journal.is_some() {
            self.transactions.push_back((self.last, transaction.journal_contacts));
            self.contacts += transaction.journal_contacts;
        }
    }

    /// Drops entries before `oldest`, the first one that is not contained in a checkpoint. `deletes` says whether the
    /// database is to delete them, too. `is_held` is true if a checkpoint may be rejected, so that entries are needed
    /// for longer.
    pub(in crate::engine) fn truncate(
        &mut self,
        oldest: Option<i64>,
        (deletes, is_held): (bool, bool),
        transaction: &mut SealedTransaction,
    ) {
        let needed_from = oldest.unwrap_or(self.last + 1);
        // Entries need not be written if the same transaction writes the checkpoints of all their robots.
        if needed_from > self.last && transaction.rows.journal.take().is_some() {
            self.contacts -= self.transactions.pop_back().map_or(0, |(_, contacts)| contacts);
        }
        let is_held = is_held && self.contacts < HELD_CONTACTS_MAX;
        while let Some((number, contacts)) =
            self.transactions.front().copied().filter(|(number, _)| deletes && !is_held && *number < needed_from)
        {
            self.transactions.pop_front();
            self.contacts -= contacts;
            transaction.rows.journal_done = Some(number);
        }
    }
}
