//! Bytes that the broker keeps: what waits for each connection and its subscriptions, and retained messages. A connection for which too much waits
//! is closed; a retained message beyond the limit is not kept.

use std::collections::HashMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use tokio::sync::oneshot;

/// Most bytes that wait for one connection: for a client that does not read, or in a packet that is not complete.
const CONNECTION_BYTES_MAX: usize = 16 << 20;
/// Most bytes that wait for all connections.
const BYTES_MAX: usize = 64 << 20;
/// Most bytes of retained messages with their topics.
const RETAINED_BYTES_MAX: usize = 64 << 20;
/// Most retained messages.
const RETAINED_MAX: usize = 100_000;
/// Memory that each of them needs beside its bytes.
const RETAINED_OVERHEAD_BYTES: usize = 256;

/// The accounts.
#[derive(Debug, Default)]
pub(super) struct Ledger(Mutex<Books>);

#[derive(Debug, Default)]
struct Books {
    next: u64,
    open: HashMap<u64, Account>,
    bytes: usize,
    retained: HashMap<Box<str>, usize>,
    retained_bytes: usize,
}

#[derive(Debug)]
struct Account {
    bytes: usize,
    /// Dropped to close the connection.
    _close: oneshot::Sender<()>,
}

impl Ledger {
    fn books(&self) -> MutexGuard<'_, Books> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Number of open connections.
    pub(super) fn connections(&self) -> usize {
        self.books().open.len()
    }

    /// Opens an account: its number, and what resolves when its connection must close.
    pub(super) fn open(&self) -> (u64, oneshot::Receiver<()>) {
        let (close, closed) = oneshot::channel();
        let mut books = self.books();
        books.next += 1;
        let number = books.next;
        books.open.insert(number, Account { bytes: 0, _close: close });
        (number, closed)
    }

    /// Closes an account, and its connection.
    pub(super) fn close(&self, number: u64) {
        self.books().close(number);
    }

    /// More bytes wait for a connection. Returns the number of the connection that was closed for them.
    pub(super) fn add(&self, number: u64, bytes: usize) -> Option<u64> {
        let mut books = self.books();
        let account = books.open.get_mut(&number)?;
        account.bytes += bytes;
        let is_full = account.bytes > CONNECTION_BYTES_MAX;
        books.bytes += bytes;
        let closed = if is_full {
            number
        } else if books.bytes > BYTES_MAX {
            *books.open.iter().max_by_key(|(_, account)| account.bytes)?.0
        } else {
            return None;
        };
        books.close(closed);
        Some(closed)
    }

    /// Fewer bytes wait for a connection.
    pub(super) fn remove(&self, number: u64, bytes: usize) {
        let mut books = self.books();
        if let Some(account) = books.open.get_mut(&number) {
            account.bytes -= bytes;
            books.bytes -= bytes;
        }
    }

    /// Counts a retained message, which replaces the one of its topic. Returns whether there is room for it; if not, the one
    /// before stays.
    pub(super) fn retain(&self, topic: &str, payload_bytes: usize) -> bool {
        let mut books = self.books();
        if payload_bytes == 0 {
            let bytes = books.retained.remove(topic).unwrap_or_default();
            books.retained_bytes -= bytes;
            return true;
        }
        let bytes = topic.len() + payload_bytes + RETAINED_OVERHEAD_BYTES;
        let before = books.retained.get(topic).copied();
        let total = books.retained_bytes - before.unwrap_or_default() + bytes;
        if total > RETAINED_BYTES_MAX || (before.is_none() && books.retained.len() >= RETAINED_MAX) {
            return false;
        }
        books.retained.insert(topic.into(), bytes);
        books.retained_bytes = total;
        true
    }
}

impl Books {
    fn close(&mut self, number: u64) {
        if let Some(account) = self.open.remove(&number) {
            self.bytes -= account.bytes;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regress_a_connection_for_which_too_much_waits_is_closed() {
        let ledger = Ledger::default();
        let (one, mut closed) = ledger.open();
        let (other, mut open) = ledger.open();
        assert_eq!((ledger.add(one, CONNECTION_BYTES_MAX), ledger.add(other, 1)), (None, None));
        ledger.remove(one, 10);
        assert_eq!((ledger.add(one, 10), ledger.add(one, 1)), (None, Some(one)));
        assert_eq!(closed.try_recv(), Err(oneshot::error::TryRecvError::Closed));
        assert_eq!(open.try_recv(), Err(oneshot::error::TryRecvError::Empty));
        assert_eq!((ledger.connections(), ledger.books().bytes), (1, 1));
    }

    #[test]
    fn regress_of_all_connections_the_largest_is_closed() {
        let ledger = Ledger::default();
        let numbers: Vec<u64> = (0..5).map(|_| ledger.open().0).collect();
        for &number in &numbers[..4] {
            assert_eq!(ledger.add(number, CONNECTION_BYTES_MAX - 10), None);
        }
        ledger.add(numbers[2], 5);
        assert_eq!(ledger.add(numbers[4], 36), Some(numbers[2]), "not the small one that was the last");
        assert_eq!(ledger.connections(), 4);
    }

    #[test]
    fn regress_retained_messages_have_a_limit_in_bytes() {
        let ledger = Ledger::default();
        let mut kept = 0;
        while ledger.retain(&format!("t/{kept}"), 1 << 20) {
            kept += 1;
        }
        assert_eq!(kept, 63);
        assert!(ledger.retain("t/0", 1 << 20), "a replacement");
        assert!(ledger.retain("t/0", 0) && ledger.retain("u", 1 << 20) && !ledger.retain("v", 1 << 20));
        let small = Ledger::default();
        let kept = (0..200_000).filter(|number| small.retain(&number.to_string(), 1)).count();
        assert_eq!(kept, RETAINED_MAX);
    }

    #[test]
    fn property_after_any_sequence_the_sums_are_those_of_the_accounts() {
        let ledger = Ledger::default();
        let mut random = 12_345_u32;
        let mut open: Vec<(u64, usize)> = Vec::new();
        for _ in 0..20_000 {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let (choice, which) = ((random >> 24) % 8, (random >> 8) as usize);
            match choice {
                0 => open.push((ledger.open().0, 0)),
                1 if !open.is_empty() => ledger.close(open.swap_remove(which % open.len()).0),
                2..6 if !open.is_empty() => {
                    let (number, bytes) = {
                        let place = which % open.len();
                        open[place].1 += which % (8 << 20);
                        (open[place].0, which % (8 << 20))
                    };
                    if let Some(closed) = ledger.add(number, bytes) {
                        open.retain(|(number, _)| *number != closed);
                    }
                }
                _ => {
                    if let Some((number, bytes)) = open.last_mut() {
                        ledger.remove(*number, *bytes);
                        *bytes = 0;
                    }
                }
            }
            let books = ledger.books();
            assert_eq!(books.bytes, open.iter().map(|(_, bytes)| bytes).sum::<usize>());
            assert!(books.bytes <= BYTES_MAX && books.open.len() == open.len());
        }
    }
}
