//! Contacts messages of one robot until a receipt covers them.
//!
//! It follows the rules of [`vibrissa_robot::contract::outbox`], but for many messages per second: it stores the data from which a
//! message can be written again, not the message. A message that a receipt passes over is sent again one second
//! after its last transmission. Messages beyond all receipts may still be on their way; they are sent again only
//! when no receipt arrives any more. Oldest first, in windows.

use std::collections::VecDeque;

use vibrissa_robot::contract::outbox::{BACKOFF_MAX_US, BACKOFF_START_US, WINDOW};

/// A stored message.
#[derive(Debug, Clone)]
pub struct Kept {
    /// Time of its contacts, in microseconds since 1970 UTC; with robot and sequence number it determines the
    /// message.
    pub felt_us: u64,
    /// The message itself, if it cannot be written again.
    pub payload: Option<Box<[u8]>>,
    sent_us: u64,
    is_covered: bool,
}

/// Messages of one boot.
#[derive(Debug, Clone)]
pub struct Outbox {
    /// Sequence number of the first stored message.
    first: u64,
    kept: VecDeque<Kept>,
    uncovered: usize,
    /// One more than the highest number that a receipt has covered.
    end: u64,
    backoff_us: u64,
    /// Time of the last covering receipt or, after it, of the last window sent again.
    answered_us: u64,
    /// Whether a window was sent again and nothing has been covered since.
    is_waiting: bool,
}

impl Default for Outbox {
    fn default() -> Self {
        Self {
            first: 0,
            kept: VecDeque::new(),
            uncovered: 0,
            end: 0,
            backoff_us: BACKOFF_START_US,
            answered_us: 0,
            is_waiting: false,
        }
    }
}

impl Outbox {
    /// Sequence number of the next message.
    #[must_use]
    pub fn next_seq(&self) -> u64 {
        self.first + self.kept.len() as u64
    }

    /// Number of messages that no receipt covers.
    #[must_use]
    pub fn uncovered(&self) -> usize {
        self.uncovered
    }

    /// Stores the next message, which is sent now.
    pub fn keep(&mut self, now_us: u64, payload: Option<Box<[u8]>>) {
        if self.uncovered == 0 {
            self.answered_us = now_us;
        }
        self.kept.push_back(Kept { felt_us: now_us, payload, sent_us: now_us, is_covered: false });
        self.uncovered += 1;
    }

    /// The message with a sequence number.
    #[must_use]
    pub fn get(&self, seq: u64) -> Option<&Kept> {
        self.kept.get(usize::try_from(seq.checked_sub(self.first)?).ok()?)
    }

    /// Removes the messages that a receipt covers, and returns their number.
    pub fn receipt(&mut self, now_us: u64, next: u64, held: &[(u64, u64)]) -> usize {
        let before = self.uncovered;
        self.cover(self.first, next);
        for &(first, last) in held {
            self.cover(first, last.saturating_add(1));
        }
        while self.kept.front().is_some_and(|kept| kept.is_covered) {
            self.kept.pop_front();
            self.first += 1;
        }
        let covered = before - self.uncovered;
        if covered > 0 {
            self.answered_us = now_us;
            self.backoff_us = BACKOFF_START_US;
            self.is_waiting = false;
        }
        covered
    }

    /// Marks the messages from one number to before another as covered.
    fn cover(&mut self, from: u64, to: u64) {
        let to = to.min(self.next_seq());
        self.end = self.end.max(to);
        for seq in from.max(self.first)..to {
            let kept = &mut self.kept[(seq - self.first) as usize];
            if !std::mem::replace(&mut kept.is_covered, true) {
                kept.payload = None;
                self.uncovered -= 1;
            }
        }
    }

    /// Sequence numbers of the messages to send again now, oldest first; they count as sent.
    pub fn resend(&mut self, now_us: u64) -> Vec<u64> {
        let is_silent = now_us >= self.answered_us + self.backoff_us;
        if self.uncovered == 0 || self.is_waiting && !is_silent {
            return Vec::new();
        }
        let until = if is_silent { self.next_seq() } else { self.end };
        let mut seqs = Vec::new();
        for (seq, kept) in (self.first..until).zip(&mut self.kept) {
            if kept.is_covered || kept.sent_us + BACKOFF_START_US > now_us {
                continue;
            }
            kept.sent_us = now_us;
            seqs.push(seq);
            if seqs.len() == WINDOW {
                break;
            }
        }
        if !seqs.is_empty() {
            if self.is_waiting {
                self.backoff_us = (2 * self.backoff_us).min(BACKOFF_MAX_US);
            }
            self.is_waiting = true;
            self.answered_us = now_us;
        }
        seqs
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: u64 = 1_000_000;

    /// An outbox with messages 0.. sent at 100 s.
    fn outbox(count: u64) -> Outbox {
        let mut outbox = Outbox::default();
        (0..count).for_each(|_| outbox.keep(100 * S, None));
        outbox
    }

    #[test]
    fn what_is_on_its_way_is_not_sent_again_while_receipts_come() {
        let mut outbox = outbox(10);
        for at in 1..10 {
            assert_eq!(outbox.receipt(100 * S + at * S / 2, at, &[]), 1);
            assert_eq!(outbox.resend(100 * S + at * S / 2), [0; 0]);
        }
        assert_eq!(outbox.resend(105 * S + S / 2), [9], "no receipt for a second");
    }

    #[test]
    fn what_a_receipt_passes_over_is_sent_again_a_second_after_it_was_sent() {
        let mut outbox = outbox(10);
        assert_eq!(outbox.receipt(100 * S + S / 2, 2, &[(5, 6)]), 4);
        assert_eq!(outbox.resend(100 * S + S / 2), [0; 0]);
        assert_eq!(outbox.receipt(101 * S, 2, &[(5, 7)]), 1);
        assert_eq!(outbox.resend(101 * S), [2, 3, 4], "8 and 9 may be on their way");
        assert_eq!(outbox.uncovered(), 5);
        assert_eq!(outbox.receipt(101 * S + S / 4, 10, &[]), 5);
        assert_eq!((outbox.uncovered(), outbox.next_seq()), (0, 10));
        assert_eq!(outbox.resend(200 * S), [0; 0]);
    }

    #[test]
    fn the_pause_doubles_while_no_receipt_comes() {
        let mut outbox = outbox(1);
        let sent_s: Vec<u64> = (100..200).filter(|&at_s| outbox.resend(at_s * S) == [0]).collect();
        assert_eq!(sent_s, [101, 102, 104, 108, 116, 132, 162, 192]);
    }

    #[test]
    fn windows_follow_at_the_pace_of_receipts() {
        let mut outbox = outbox(200);
        assert_eq!(outbox.resend(101 * S), (0..64).collect::<Vec<u64>>());
        assert_eq!(outbox.resend(101 * S + S / 2), [0; 0]);
        outbox.receipt(101 * S + S / 2, 10, &[(60, 199)]);
        assert_eq!(outbox.resend(101 * S + S / 2), [0; 0], "10 to 59 were sent half a second ago");
        assert_eq!(outbox.resend(102 * S), (10..60).collect::<Vec<u64>>());
    }
}
