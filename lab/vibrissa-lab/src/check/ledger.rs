//! Record of the contacts messages: which arrived, how often, in which order, and which are receipted.

use std::collections::BTreeMap;
use std::time::Duration;

use bytes::Bytes;
use tokio::time::Instant;
use vibrissa_protocol::Rule;

use super::report::Findings;

/// Part of a receipt that covers a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Cover {
    /// The receipt's `next`.
    Next,
    /// The receipt's `held`.
    Held,
}

/// A message, by its number.
#[derive(Debug)]
struct Sent {
    payload: Bytes,
    /// Times of arrival.
    times: Vec<Instant>,
    /// Positions of the last arrival among all arrivals, and of the one before it.
    last: u64,
    before: Option<u64>,
    covered: Option<(Instant, Cover)>,
}

/// The contacts messages of one boot: numbers and receipts of another one mean other messages.
#[derive(Debug, Default)]
pub(super) struct Ledger {
    sent: BTreeMap<u64, Sent>,
    arrivals: u64,
    /// Whether the order of repeated messages is judged: only while nothing is receipted.
    pub(super) judges_order: bool,
    /// Receipts sent; few, because the check makes each one deliberately.
    receipts: Vec<Receipted>,
    /// Number of repeated messages while the order was judged.
    ordered: u64,
}

/// A receipt that was sent.
#[derive(Debug)]
struct Receipted {
    next: u64,
    held: Vec<u64>,
    at: Instant,
}

impl Receipted {
    fn covers(&self, seq: u64) -> Option<(Instant, Cover)> {
        let cover = match seq {
            _ if seq < self.next => Cover::Next,
            _ if self.held.contains(&seq) => Cover::Held,
            _ => return None,
        };
        Some((self.at, cover))
    }
}

impl Ledger {
    /// Records the arrival of a message.
    pub(super) fn arrive(&mut self, seq: u64, payload: &Bytes, at: Instant, grace: Duration, findings: &mut Findings) {
        self.arrivals += 1;
        let order = self.arrivals;
        let overtaken = self.overtaken(seq);
        let Some(known) = self.sent.get_mut(&seq) else {
            // It may have been in transit when it was receipted.
            let covered = self.receipts.iter().find_map(|receipt| receipt.covers(seq));
            let first = Sent { payload: payload.clone(), times: vec![at], last: order, before: None, covered };
            self.sent.insert(seq, first);
            return;
        };
        known.times.push(at);
        known.before = Some(std::mem::replace(&mut known.last, order));
        let is_same = is_same(&known.payload, payload);
        findings.judge(Rule::ResendSame, is_same, format!("contacts {seq} was sent again, {}", same_text(is_same)));
        if let Some((since, cover)) = known.covered {
            if at > since + grace {
                let (rule, how) = match cover {
                    Cover::Next => (Rule::ReceiptNext, "is below next"),
                    Cover::Held => (Rule::ReceiptHeld, "is in a held range"),
                };
                let after_s = (at - since).as_secs_f64();
                findings.fail(
                    rule,
                    format!("contacts {seq} was sent again {after_s:.1} s after it was receipted: it {how}"),
                );
            }
        } else if self.judges_order {
            self.ordered += 1;
            if let Some(older) = overtaken {
                let seen = format!("contacts {seq} was sent again before {older}, which has waited longer");
                findings.fail(Rule::ResendOldestFirst, seen);
            } else if self.ordered > 1 {
                findings.pass(Rule::ResendOldestFirst, format!("{} messages were sent again in order", self.ordered));
            }
        }
    }

    /// An uncovered message with a lower number that has waited longer than this one.
    fn overtaken(&self, seq: u64) -> Option<u64> {
        let last = self.sent.get(&seq)?.last;
        let older = self.sent.range(..seq).find(|(_, sent)| sent.covered.is_none() && sent.last < last);
        older.map(|(&seq, _)| seq)
    }

    /// Whether the message of this number is no longer sent, although newer ones are: one of them came twice since.
    pub(super) fn is_gone(&self, seq: u64) -> bool {
        let Some(last) = self.sent.get(&seq).map(|sent| sent.last) else { return false };
        self.sent.range(seq + 1..).any(|(_, newer)| newer.before.is_some_and(|before| before > last))
    }

    /// The lowest number of a message that was sent again after a time.
    pub(super) fn oldest_again(&self, since: Instant) -> Option<u64> {
        let is_again = |sent: &Sent| sent.times.len() > 1 && sent.times.last().is_some_and(|&at| at > since);
        self.sent.iter().find(|(_, sent)| is_again(sent)).map(|(&seq, _)| seq)
    }

    /// Records a receipt that covers everything below `next` and the numbers in `held`.
    pub(super) fn cover(&mut self, next: u64, held: &[u64], at: Instant) {
        let receipt = Receipted { next, held: held.to_vec(), at };
        for (&seq, sent) in &mut self.sent {
            sent.covered = sent.covered.or_else(|| receipt.covers(seq));
        }
        self.receipts.push(receipt);
    }

    /// Numbers of messages that no receipt covers, lowest first.
    pub(super) fn uncovered(&self) -> Vec<u64> {
        self.sent.iter().filter(|(_, sent)| sent.covered.is_none()).map(|(&seq, _)| seq).collect()
    }

    /// The number after the highest one.
    pub(super) fn end(&self) -> u64 {
        self.sent.last_key_value().map_or(0, |(&seq, _)| seq + 1)
    }

    /// Numbers from `from` on that never arrived.
    pub(super) fn missing(&self, from: u64) -> Vec<u64> {
        (from..self.end()).filter(|seq| !self.sent.contains_key(seq)).collect()
    }

    /// Times at which a message arrived.
    pub(super) fn times(&self, seq: u64) -> &[Instant] {
        self.sent.get(&seq).map_or(&[], |sent| &sent.times)
    }

    /// Number of messages.
    pub(super) fn len(&self) -> usize {
        self.sent.len()
    }
}

/// Whether two messages have the same content, in whatever notation.
fn is_same(one: &[u8], other: &[u8]) -> bool {
    let read = |bytes: &[u8]| serde_json::from_slice::<serde_json::Value>(bytes).ok();
    one == other || read(one).is_some_and(|one| Some(one) == read(other))
}

fn same_text(is_same: bool) -> &'static str {
    if is_same { "with the same content" } else { "with another content" }
}

#[cfg(test)]
mod tests {
    use super::super::report::Outcome;
    use super::*;

    /// A robot's messages, half a second apart.
    struct Robot {
        ledger: Ledger,
        findings: Findings,
        at: Instant,
    }

    impl Robot {
        fn new(seqs: &[u64]) -> Self {
            let ledger = Ledger { judges_order: true, ..Ledger::default() };
            let mut robot = Self { ledger, findings: Findings::default(), at: Instant::now() };
            robot.sends(seqs);
            robot
        }

        fn sends(&mut self, seqs: &[u64]) {
            for seq in seqs {
                self.says(*seq, format!("{{\"seq\":{seq}}}"));
            }
        }

        fn says(&mut self, seq: u64, text: String) {
            self.at += Duration::from_millis(500);
            self.ledger.arrive(seq, &Bytes::from(text), self.at, Duration::from_millis(400), &mut self.findings);
        }

        fn outcome(self, rule: Rule) -> Outcome {
            let (findings, _) = self.findings.close("");
            findings.iter().find(|finding| finding.rule == rule).unwrap().outcome
        }
    }

    #[test]
    fn what_comes_again_in_order_passes_also_when_new_ones_come_between() {
        let mut robot = Robot::new(&[0, 1, 2]);
        robot.sends(&[0, 1, 3, 2, 0, 1, 2, 3]);
        assert_eq!(robot.outcome(Rule::ResendOldestFirst), Outcome::Pass);
    }

    #[test]
    fn a_newer_one_before_an_older_one_that_waits_longer_fails() {
        let mut robot = Robot::new(&[0, 1, 2]);
        robot.sends(&[2, 1, 0]);
        assert_eq!(robot.outcome(Rule::ResendOldestFirst), Outcome::Fail);
    }

    #[test]
    fn what_is_receipted_may_come_once_more_if_it_was_under_way() {
        for (grace, expected) in [(Duration::from_millis(200), Outcome::Skipped), (Duration::ZERO, Outcome::Fail)] {
            let mut robot = Robot::new(&[0, 1, 2]);
            robot.ledger.cover(1, &[2], robot.at + grace);
            robot.sends(&[2]);
            assert_eq!(robot.ledger.uncovered(), [1]);
            assert_eq!(robot.outcome(Rule::ReceiptHeld), expected);
        }
    }

    #[test]
    fn regress_what_comes_first_after_its_receipt_does_not_wait_for_one() {
        let mut robot = Robot::new(&[3]);
        robot.ledger.cover(4, &[6], robot.at);
        robot.sends(&[0, 6, 4, 5, 4, 5]);
        assert_eq!(robot.ledger.uncovered(), [4, 5]);
        assert_eq!(robot.outcome(Rule::ResendOldestFirst), Outcome::Pass);
    }

    #[test]
    fn a_message_is_gone_once_a_newer_one_came_twice_since() {
        let mut robot = Robot::new(&[0, 1, 2]);
        let begun = robot.at;
        robot.sends(&[0, 1, 2]);
        assert!((0..3).all(|seq| !robot.ledger.is_gone(seq)));
        assert_eq!(robot.ledger.oldest_again(begun), Some(0));
        let later = robot.at;
        // New messages say nothing.
        robot.sends(&[3, 4, 5]);
        assert!(!robot.ledger.is_gone(0));
        robot.sends(&[1, 2]);
        assert!(robot.ledger.is_gone(0) && !robot.ledger.is_gone(1));
        assert_eq!(robot.ledger.oldest_again(later), Some(1));
    }

    #[test]
    fn content_is_compared_as_json() {
        let mut robot = Robot::new(&[0]);
        robot.says(0, "{ \"seq\": 0 }".to_owned());
        robot.sends(&[1]);
        assert_eq!(robot.ledger.missing(0), [0_u64; 0]);
        robot.says(1, "{\"seq\":1,\"more\":true}".to_owned());
        assert_eq!(robot.outcome(Rule::ResendSame), Outcome::Fail);
    }
}
