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

use super::Moment;

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
    by_sent: BTreeSet<(Moment, u64)>,
    /// Bytes of the stored messages.
    bytes: usize,
    backoff_us: u64,
    /// Time of the last window, if no receipt has covered anything since.
    unanswered_since: Option<Moment>,
    /// Time of the last receipt that covered anything.
    answered: Moment,
    /// Everything sent before has arrived or is lost: the latest first transmission of a covered message.
    settled: Moment,
    /// Time from the first transmission of recent messages to their receipts; it rises at once, and falls slowly.
    delay_us: u64,
    /// Time of the last window in silence. Messages sent before it do not tell how long messages need.
    silent: Moment,
    dropped: u64,
    /// Highest sequence number that a receipt has covered.
    newest_covered: Option<u64>,
}

#[derive(Debug)]
struct Kept {
    payload: Vec<u8>,
    /// The first and the last transmission; `BEFORE_ALL` if there was none, or if the message is due at once.
    first_sent: Moment,
    sent: Moment,
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
            unanswered_since: None,
            answered: Moment::BEFORE_ALL,
            settled: Moment::BEFORE_ALL,
            delay_us: 0,
            silent: Moment::BEFORE_ALL,
            dropped: 0,
            newest_covered: None,
        }
    }

    /// Stores a message that is sent now; `None` if not connected, so that it is due at the next chance.
    pub fn keep(&mut self, seq: u64, payload: Vec<u8>, sent: Option<Moment>) {
        let sent = sent.unwrap_or_default();
        self.bytes += payload.len();
        self.messages.insert(seq, Kept { payload, first_sent: sent, sent });
        self.by_sent.insert((sent, seq));
        while self.messages.len() > self.most {
            self.drop_oldest();
        }
    }

    /// Drops the oldest message and counts it, because there is no room. Returns whether there was one.
    pub fn drop_oldest(&mut self) -> bool {
        let Some((oldest, kept)) = self.messages.pop_first() else {
            return false;
        };
        self.by_sent.remove(&(kept.sent, oldest));
        self.bytes -= kept.payload.len();
        self.dropped += 1;
        true
    }

    /// Removes the messages that a receipt covers.
    pub fn receipt(&mut self, receipt: &Receipt, now: Moment) {
        let before = self.messages.len();
        let kept_on = self.messages.split_off(&receipt.next);
        let mut covered = std::mem::replace(&mut self.messages, kept_on);
        for &(first, last) in receipt.held.iter().filter(|(first, last)| first <= last) {
            let seqs: Vec<u64> = self.messages.range(first..=last).map(|(&seq, _)| seq).collect();
            covered.extend(seqs.into_iter().filter_map(|seq| self.messages.remove(&seq).map(|kept| (seq, kept))));
        }
        for (seq, kept) in covered {
            self.by_sent.remove(&(kept.sent, seq));
            self.bytes -= kept.payload.len();
            self.newest_covered = self.newest_covered.max(Some(seq));
            // Which transmission has arrived is not known.
            self.settled = self.settled.max(kept.first_sent);
            if kept.first_sent > self.silent {
                let delay_us = now.since(kept.first_sent);
                self.delay_us = delay_us.max((7 * self.delay_us + delay_us) / 8);
            }
        }
        if self.messages.len() < before {
            self.backoff_us = BACKOFF_START_US;
            self.unanswered_since = None;
            self.answered = now;
        }
    }

    /// After a reconnection, earlier transmissions may be lost: all messages are due immediately.
    pub fn reconnected(&mut self) {
        self.by_sent = self.messages.keys().map(|&seq| (Moment::BEFORE_ALL, seq)).collect();
        for kept in self.messages.values_mut() {
            kept.sent = Moment::BEFORE_ALL;
        }
        self.backoff_us = BACKOFF_START_US;
        self.unanswered_since = None;
    }

    /// Time of the next window, if there are messages.
    #[must_use]
    pub fn resend_at(&self) -> Option<Moment> {
        let &(sent, _) = self.by_sent.first()?;
        let due = match sent {
            Moment::BEFORE_ALL => Moment::BEFORE_ALL,
            _ if sent < self.settled => sent + BACKOFF_START_US,
            _ => (sent + self.patience_us()).min((sent + BACKOFF_START_US).max(self.silent_at())),
        };
        Some(due.max(self.unanswered_since.map_or(Moment::BEFORE_ALL, |since| since + self.backoff_us)))
    }

    /// Time after which a message that may be on its way is sent again although receipts arrive.
    fn patience_us(&self) -> u64 {
        (2 * self.delay_us).clamp(BACKOFF_START_US, self.backoff_max_us)
    }

    /// Time at which receipts have been absent for a pause.
    fn silent_at(&self) -> Moment {
        self.answered + self.backoff_us
    }

    /// The messages to send again now, oldest first.
    pub fn resend(&mut self, now: Moment) -> Vec<Vec<u8>> {
        let is_silent = now >= self.silent_at();
        if self.unanswered_since.is_some() {
            self.backoff_us = (self.backoff_us * 2).min(self.backoff_max_us);
        }
        let patience_us = self.patience_us();
        // True up to some time of transmission.
        let due = |&&(sent, _): &&(Moment, u64)| {
            let pause_us = if is_silent || sent < self.settled { BACKOFF_START_US } else { patience_us };
            sent == Moment::BEFORE_ALL || sent + pause_us <= now
        };
        let mut window: Vec<(Moment, u64)> = self.by_sent.iter().take_while(due).copied().collect();
        window.sort_unstable_by_key(|&(_, seq)| seq);
        window.truncate(WINDOW);
        let mut payloads = Vec::with_capacity(window.len());
        for (sent, seq) in window {
            self.by_sent.remove(&(sent, seq));
            self.by_sent.insert((now, seq));
            if let Some(kept) = self.messages.get_mut(&seq) {
                if kept.first_sent == Moment::BEFORE_ALL {
                    kept.first_sent = now;
                }
                kept.sent = now;
                payloads.push(kept.payload.clone());
            }
        }
        self.unanswered_since = Some(now);
        if is_silent {
            self.silent = now;
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
mod tests;
