//! Contacts messages without a receipt.
//!
//! A limited number is stored until a receipt covers them. Uncovered messages are sent again, oldest first, in
//! windows. The pause between windows doubles while no receipt arrives, and starts over with the next one.
//!
//! A message is lost if a receipt covers one that was sent after it, because messages arrive in order. Others may still be on
//! their way: while receipts arrive, they are sent again only after twice the time that messages need at present. Otherwise
//! repetitions would fill a slow network, broker or supervisor, and make it slower.

use std::collections::{BTreeMap, BTreeSet};

use vibrissa_protocol::Receipt;

/// First pause before messages are sent again, in microseconds.
pub const BACKOFF_START_US: u64 = 1_000_000;
/// Longest pause between transmissions, in microseconds.
pub const BACKOFF_MAX_US: u64 = 30_000_000;
/// Number of messages that are sent again at once.
pub const WINDOW: usize = 64;

/// Stored messages of one boot.
#[derive(Debug)]
pub struct Outbox {
    most: usize,
    /// Longest pause between transmissions.
    backoff_max_us: u64,
    messages: BTreeMap<u64, Kept>,
    /// (time of the last transmission, seq) of each message, to find the next one to send again.
    by_sent: BTreeSet<(u64, u64)>,
    /// Bytes of the stored messages.
    bytes: usize,
    backoff_us: u64,
    /// Time of the last window, if no receipt has covered anything since.
    unanswered_since_us: Option<u64>,
    /// Time of the last receipt that covered anything.
    answered_us: u64,
    /// Everything sent before has arrived or is lost: the latest first transmission of a covered message.
    settled_us: u64,
    /// Time from the first transmission of recent messages to their receipts; it rises at once, and falls slowly.
    delay_us: u64,
    /// Time of the last window in silence. Messages sent before it do not tell how long messages need.
    silent_us: u64,
    dropped: u64,
    /// Highest sequence number that a receipt has covered.
    newest_covered: Option<u64>,
}

#[derive(Debug)]
struct Kept {
    payload: Vec<u8>,
    /// Times of the first and the last transmission; 0 if there was none, or if the message is due at once.
    first_sent_us: u64,
    sent_us: u64,
}

impl Outbox {
    /// An empty outbox for at most `most` messages.
    #[must_use]
    pub fn new(most: usize) -> Self {
        Self::with_longest_pause(most, BACKOFF_MAX_US)
    }

    /// The same with another longest pause, at least [`BACKOFF_START_US`]. A robot that keeps the contract has
    /// [`BACKOFF_MAX_US`].
    #[must_use]
    pub fn with_longest_pause(most: usize, backoff_max_us: u64) -> Self {
        Self {
            most,
            backoff_max_us,
            messages: BTreeMap::new(),
            by_sent: BTreeSet::new(),
            bytes: 0,
            backoff_us: BACKOFF_START_US,
            unanswered_since_us: None,
            answered_us: 0,
            settled_us: 0,
            delay_us: 0,
            silent_us: 0,
            dropped: 0,
            newest_covered: None,
        }
    }

    /// Stores a message that is sent now; `None` if not connected, so that it is due at the next chance.
    pub fn keep(&mut self, seq: u64, payload: Vec<u8>, sent_us: Option<u64>) {
        let sent_us = sent_us.unwrap_or(0);
        self.bytes += payload.len();
        self.messages.insert(seq, Kept { payload, first_sent_us: sent_us, sent_us });
        self.by_sent.insert((sent_us, seq));
        while self.messages.len() > self.most {
            self.drop_oldest();
        }
    }

    /// Drops the oldest message and counts it, because there is no room. Returns whether there was one.
    pub fn drop_oldest(&mut self) -> bool {
        let Some((oldest, kept)) = self.messages.pop_first() else {
            return false;
        };
        self.by_sent.remove(&(kept.sent_us, oldest));
        self.bytes -= kept.payload.len();
        self.dropped += 1;
        true
    }

    /// Removes the messages that a receipt covers.
    pub fn receipt(&mut self, receipt: &Receipt, now_us: u64) {
        let before = self.messages.len();
        let kept_on = self.messages.split_off(&receipt.next);
        let mut covered = std::mem::replace(&mut self.messages, kept_on);
        for &(first, last) in receipt.held.iter().filter(|(first, last)| first <= last) {
            let seqs: Vec<u64> = self.messages.range(first..=last).map(|(&seq, _)| seq).collect();
            covered.extend(seqs.into_iter().filter_map(|seq| self.messages.remove(&seq).map(|kept| (seq, kept))));
        }
        for (seq, kept) in covered {
            self.by_sent.remove(&(kept.sent_us, seq));
            self.bytes -= kept.payload.len();
            self.newest_covered = self.newest_covered.max(Some(seq));
            // Which transmission has arrived is not known.
            self.settled_us = self.settled_us.max(kept.first_sent_us);
            if kept.first_sent_us > self.silent_us {
                let delay_us = now_us.saturating_sub(kept.first_sent_us);
                self.delay_us = delay_us.max((7 * self.delay_us + delay_us) / 8);
            }
        }
        if self.messages.len() < before {
            self.backoff_us = BACKOFF_START_US;
            self.unanswered_since_us = None;
            self.answered_us = now_us;
        }
    }

    /// After a reconnection, earlier transmissions may be lost: all messages are due immediately.
    pub fn reconnected(&mut self) {
        self.by_sent = self.messages.keys().map(|&seq| (0, seq)).collect();
        for kept in self.messages.values_mut() {
            kept.sent_us = 0;
        }
        self.backoff_us = BACKOFF_START_US;
        self.unanswered_since_us = None;
    }

    /// Time of the next window, if there are messages.
    #[must_use]
    pub fn resend_at_us(&self) -> Option<u64> {
        let &(sent_us, _) = self.by_sent.first()?;
        let due_us = match sent_us {
            0 => 0,
            _ if sent_us < self.settled_us => sent_us + BACKOFF_START_US,
            _ => (sent_us + self.patience_us()).min((sent_us + BACKOFF_START_US).max(self.silent_at_us())),
        };
        Some(due_us.max(self.unanswered_since_us.map_or(0, |since_us| since_us + self.backoff_us)))
    }

    /// Time after which a message that may be on its way is sent again although receipts arrive.
    fn patience_us(&self) -> u64 {
        (2 * self.delay_us).clamp(BACKOFF_START_US, self.backoff_max_us)
    }

    /// Time at which receipts have been absent for a pause.
    fn silent_at_us(&self) -> u64 {
        self.answered_us + self.backoff_us
    }

    /// The messages to send again now, oldest first.
    pub fn resend(&mut self, now_us: u64) -> Vec<Vec<u8>> {
        let is_silent = now_us >= self.silent_at_us();
        if self.unanswered_since_us.is_some() {
            self.backoff_us = (self.backoff_us * 2).min(self.backoff_max_us);
        }
        let patience_us = self.patience_us();
        // True up to some time of transmission.
        let due = |&&(sent_us, _): &&(u64, u64)| {
            let pause_us = if is_silent || sent_us < self.settled_us { BACKOFF_START_US } else { patience_us };
            sent_us == 0 || sent_us + pause_us <= now_us
        };
        let mut window: Vec<(u64, u64)> = self.by_sent.iter().take_while(due).copied().collect();
        window.sort_unstable_by_key(|&(_, seq)| seq);
        window.truncate(WINDOW);
        let mut payloads = Vec::with_capacity(window.len());
        for (sent_us, seq) in window {
            self.by_sent.remove(&(sent_us, seq));
            self.by_sent.insert((now_us, seq));
            if let Some(kept) = self.messages.get_mut(&seq) {
                if kept.first_sent_us == 0 {
                    kept.first_sent_us = now_us;
                }
                kept.sent_us = now_us;
                payloads.push(kept.payload.clone());
            }
        }
        self.unanswered_since_us = Some(now_us);
        if is_silent {
            self.silent_us = now_us;
        }
        payloads
    }

    /// Number of stored messages.
    #[must_use]
    pub fn len(&self) -> usize {
        self.messages.len()
    }

    /// Bytes of the stored messages.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.bytes
    }

    /// The stored messages with their numbers, the oldest first.
    pub fn messages(&self) -> impl Iterator<Item = (u64, &[u8])> {
        self.messages.iter().map(|(&seq, kept)| (seq, &kept.payload[..]))
    }

    /// Whether no message is stored.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.messages.is_empty()
    }

    /// Highest sequence number of this boot that a receipt has covered.
    #[must_use]
    pub fn newest_covered(&self) -> Option<u64> {
        self.newest_covered
    }

    /// Number of messages dropped because the outbox was full.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    /// Starts a new boot without the stored messages, which are counted as dropped.
    pub fn restart(&mut self) {
        let lost = self.messages.len() as u64;
        *self = Self { dropped: lost, ..Self::with_longest_pause(self.most, self.backoff_max_us) };
    }
}

#[cfg(test)]
mod tests {
    use vibrissa_protocol::BootId;

    use super::*;

    const S: u64 = 1_000_000;

    fn receipt(next: u64, held: &[(u64, u64)]) -> Receipt {
        let boot = BootId::new("b").unwrap();
        Receipt { boot_id: boot.clone(), seq: 0, robot_boot_id: boot, next, held: held.to_vec() }
    }

    /// An outbox with messages 0.. sent at 100 s; the payload of each is its number.
    fn outbox(count: u64, most: usize) -> Outbox {
        let mut outbox = Outbox::new(most);
        (0..count).for_each(|seq| outbox.keep(seq, vec![seq as u8], Some(100 * S)));
        outbox
    }

    fn numbers(payloads: &[Vec<u8>]) -> Vec<u8> {
        payloads.iter().map(|payload| payload[0]).collect()
    }

    #[test]
    fn a_receipt_covers_what_is_below_next_and_what_is_held() {
        let mut outbox = outbox(10, 100);
        outbox.receipt(&receipt(3, &[(5, 6), (9, 20)]), 100 * S);
        assert_eq!(outbox.messages.keys().copied().collect::<Vec<_>>(), [3, 4, 7, 8]);
        assert_eq!(outbox.by_sent.len(), 4);
        assert_eq!(outbox.newest_covered(), Some(9));
        outbox.receipt(&receipt(10, &[]), 100 * S);
        assert_eq!((outbox.len(), outbox.resend_at_us()), (0, None));
    }

    #[test]
    fn uncovered_messages_are_sent_again_oldest_first() {
        let mut outbox = outbox(5, 100);
        outbox.receipt(&receipt(0, &[(1, 2)]), 100 * S);
        assert_eq!(outbox.resend_at_us(), Some(101 * S));
        assert_eq!(numbers(&outbox.resend(101 * S)), [0, 3, 4]);
    }

    #[test]
    fn the_pause_doubles_while_no_receipt_comes_up_to_its_longest() {
        let mut outbox = outbox(1, 100);
        let mut sent_s = vec![];
        for _ in 0..8 {
            let at_us = outbox.resend_at_us().unwrap();
            assert_eq!(outbox.resend(at_us).len(), 1);
            sent_s.push(at_us / S - 100);
        }
        assert_eq!(sent_s, [1, 2, 4, 8, 16, 32, 62, 92]);
    }

    #[test]
    fn a_receipt_that_covers_something_starts_the_pause_over() {
        let mut outbox = outbox(3, 100);
        for at_s in [101, 102, 104, 108] {
            outbox.resend(at_s * S);
        }
        outbox.receipt(&receipt(1, &[]), 108 * S);
        assert_eq!(outbox.resend_at_us(), Some(109 * S));
    }

    #[test]
    fn a_gap_is_filled_although_receipts_keep_coming() {
        let mut outbox = outbox(2, 100);
        outbox.receipt(&receipt(0, &[(1, 1)]), 100 * S);
        for seq in 2..12 {
            let at_us = 100 * S + seq * 100_000;
            outbox.keep(seq, vec![seq as u8], Some(at_us));
            outbox.receipt(&receipt(0, &[(1, seq)]), at_us);
        }
        assert_eq!(outbox.resend_at_us(), Some(101 * S));
        assert_eq!(numbers(&outbox.resend(101 * S + 100_000)), [0]);
    }

    #[test]
    fn after_a_connection_windows_follow_at_the_pace_of_receipts() {
        let mut outbox = outbox(200, 1000);
        outbox.reconnected();
        assert_eq!(outbox.resend_at_us(), Some(0));
        assert_eq!(numbers(&outbox.resend(200 * S)), (0..64).collect::<Vec<u8>>());
        assert_eq!(outbox.resend_at_us(), Some(201 * S), "not more before a receipt or a pause");
        outbox.receipt(&receipt(10, &[]), 200 * S);
        assert_eq!(outbox.resend_at_us(), Some(0));
        assert_eq!(numbers(&outbox.resend(200 * S)), (64..128).collect::<Vec<u8>>());
    }

    #[test]
    fn regress_a_slow_supervisor_gets_no_repetitions_while_its_receipts_arrive() {
        let mut outbox = outbox(0, 1000);
        (0..200).for_each(|seq| outbox.keep(seq, vec![seq as u8], Some(100 * S)));
        // Eight messages in a second, so that the last receipt comes after 25 s.
        let mut sent_again = 0;
        for arrived in 1..=200 {
            let now_us = 100 * S + arrived * S / 8;
            if outbox.resend_at_us().is_some_and(|at_us| at_us <= now_us) {
                sent_again += outbox.resend(now_us).len();
            }
            outbox.receipt(&receipt(arrived, &[]), now_us);
        }
        assert_eq!((outbox.len(), sent_again), (0, 0));
    }

    #[test]
    fn a_lost_message_is_sent_again_while_receipts_for_others_arrive() {
        let (mut outbox, mut again) = (outbox(0, 1000), 0);
        for seq in 0..40 {
            let now_us = 100 * S + seq * S / 4;
            outbox.keep(seq, vec![seq as u8], Some(now_us));
            // Number 5 never arrives; the others have a receipt 2 s later.
            if let Some(arrived) = seq.checked_sub(8) {
                let held = if arrived > 5 { vec![(6, arrived)] } else { Vec::new() };
                outbox.receipt(&receipt(arrived.min(5), &held), now_us);
            }
            // Then a receipt for number 6 has shown the loss.
            if seq >= 14 && outbox.resend_at_us().is_some_and(|at_us| at_us <= now_us) {
                assert_eq!(numbers(&outbox.resend(now_us)), [5]);
                again += 1;
            }
        }
        assert_eq!(
            (outbox.len(), again),
            (9, 3),
            "number 5 after each time that messages need, and eight on their way"
        );
    }

    #[test]
    fn regress_the_oldest_come_again_a_second_after_a_receipt_for_the_newest_on_a_slow_network() {
        let mut outbox = outbox(1, 1000);
        // Messages need 20 s.
        outbox.receipt(&receipt(1, &[]), 120 * S);
        (1..=200).for_each(|seq| outbox.keep(seq, vec![seq as u8], Some(120 * S)));
        for _ in 0..5 {
            let at_us = outbox.resend_at_us().unwrap();
            assert_eq!(numbers(&outbox.resend(at_us))[0], 1);
        }
        let mut at_us = 155 * S;
        outbox.receipt(&receipt(1, &[(200, 200)]), at_us);
        let mut sent = Vec::new();
        while at_us <= 156 * S {
            sent.extend(numbers(&outbox.resend(at_us)));
            at_us = outbox.resend_at_us().unwrap().max(at_us + 1);
        }
        assert!(sent.contains(&1), "{sent:?}");
    }

    #[test]
    fn beyond_the_most_the_oldest_are_dropped_and_counted() {
        let mut outbox = outbox(7, 5);
        assert_eq!((outbox.len(), outbox.dropped()), (5, 2));
        assert_eq!(numbers(&outbox.resend(101 * S)), [2, 3, 4, 5, 6]);
    }

    #[test]
    fn a_restart_loses_what_is_kept_and_counts_it() {
        let mut outbox = outbox(4, 5);
        outbox.restart();
        assert_eq!((outbox.len(), outbox.dropped(), outbox.resend_at_us()), (0, 4, None));
    }
}
