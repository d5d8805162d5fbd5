//! Robots whose rows the database has rejected. They do not hold up the other robots, and the message to blame is
//! found.
//!
//! ```text
//!                        rows refused                             no rejection for a minute
//!  ordinary robot ───────────────────────▶ suspect ──────────────────────────────────────────▶ ordinary robot
//!                    state as it was        │   ▲
//!                    committed last         ▼   │ rows refused: half as many messages; of one message: quarantine
//!                                     messages step through
//!                                     the core, few at a time
//! ```
//!
//! A suspect's messages wait in a queue of its own. A few at a time are stepped and committed. If the database rejects
//! their rows, the robot is restored to its last committed state, and half as many are tried. A single message that is
//! rejected is put into quarantine, and receipted. After each rejection the suspect rests for longer, so that a robot
//! that sends only such messages costs the database a few transactions per minute.

use std::collections::VecDeque;
use std::time::Duration;

use tokio::time::Instant;
use vibrissa_protocol::{RobotTopic, envelope};

use crate::engine::message::RawMessage;
use vibrissa_edge::clock::wall_clock;
use vibrissa_store::Rejection;
use vibrissa_store::batch::QuarantineRow;

/// A suspect without rejected rows for this time is an ordinary robot again.
const PROBATION: Duration = Duration::from_secs(60);
/// Number of rejections without a rest; each later one doubles the rest.
const FREE_REFUSALS: u32 = 3;
/// The first rest.
const REST: Duration = Duration::from_millis(250);
/// The longest rest.
const REST_MAX: Duration = Duration::from_secs(60);
/// Limit of waiting messages. Contacts beyond it are lost here, and robots send them again, because they have no
/// receipt.
const WAITING_MAX: usize = 2048;
/// Limit of waiting bytes.
const WAITING_BYTES_MAX: usize = 4 * 1024 * 1024;

/// A step of a suspect.
#[derive(Debug, Clone)]
pub(crate) enum Turn {
    /// A message as received.
    Message(RawMessage),
    /// A message in quarantine: only its number is admitted, so that it is receipted.
    Receipt(RawMessage),
}

impl Turn {
    fn bytes(&self) -> usize {
        match self {
            Self::Message(raw) | Self::Receipt(raw) => raw.payload.len(),
        }
    }
}

/// A robot whose rows the database has rejected.
#[derive(Debug)]
pub(crate) struct Suspect {
    waiting: VecDeque<Turn>,
    /// Turns that are stepped, but not known as committed.
    under_way: Vec<Turn>,
    /// Number of the transaction that commits them, once all are stepped.
    number: Option<i64>,
    /// Largest number of turns under way.
    most: usize,
    refusals: u32,
    rests_until: Instant,
    refused_last: Instant,
}

/// The consequence of a rejection.
#[derive(Debug)]
pub(crate) enum Verdict {
    /// The message to blame is not known yet.
    TryFewer,
    /// This message is to blame.
    Quarantine(Box<QuarantineRow>),
}

impl Suspect {
    /// A robot whose rows were rejected for the first time.
    pub(crate) fn new(now: Instant) -> Self {
        Self {
            waiting: VecDeque::new(),
            under_way: Vec::new(),
            number: None,
            most: 0,
            refusals: 0,
            rests_until: now,
            refused_last: now,
        }
    }

    /// Handles the rejection of the rows of the messages under way, or of `messages`, which came before those waiting.
    /// If the problem is `widespread`, no message is blamed, because the database is the likely cause.
    pub(crate) fn refused(
        &mut self,
        now: Instant,
        messages: Vec<RawMessage>,
        rejection: &Rejection,
        widespread: bool,
    ) -> Verdict {
        (self.refused_last, self.number) = (now, None);
        let mut blamed = std::mem::take(&mut self.under_way);
        if blamed.is_empty() {
            blamed = messages.into_iter().map(Turn::Message).collect();
        }
        if blamed.len() == 1
            && !widespread
            && let Some(Turn::Message(raw)) = blamed.pop_if(|turn| matches!(turn, Turn::Message(_)))
        {
            let row = quarantined(&raw, rejection);
            if raw.kind == RobotTopic::Contacts {
                self.waiting.push_front(Turn::Receipt(raw));
            }
            self.most = 1;
            self.rest(now);
            return Verdict::Quarantine(Box::new(row));
        }
        if blamed.len() <= 1 {
            // No message is to blame, or not only messages.
            self.rest(now);
        }
        self.most = (blamed.len() / 2).max(1);
        for turn in blamed.into_iter().rev() {
            self.waiting.push_front(turn);
        }
        Verdict::TryFewer
    }

    fn rest(&mut self, now: Instant) {
        self.refusals += 1;
        let Some(doublings) = self.refusals.checked_sub(FREE_REFUSALS + 1) else { return };
        self.rests_until = now + REST.saturating_mul(1 << doublings.min(16)).min(REST_MAX);
    }

    /// Adds a message; returns false and drops the message if the queue is full.
    pub(crate) fn wait(&mut self, raw: RawMessage) -> bool {
        let bytes: usize = self.waiting.iter().map(Turn::bytes).sum();
        if self.waiting.len() >= WAITING_MAX || bytes + raw.payload.len() > WAITING_BYTES_MAX {
            return false;
        }
        self.waiting.push_back(Turn::Message(raw));
        true
    }

    /// True while the suspect rests: it then gets no events, not even ticks.
    pub(crate) fn rests(&self, now: Instant) -> bool {
        now < self.rests_until
    }

    /// Begins and returns the next turns; none while others are under way, or while the suspect rests.
    pub(crate) fn begin(&mut self, now: Instant) -> Vec<Turn> {
        if !self.under_way.is_empty() || self.rests(now) {
            return Vec::new();
        }
        let count = self.most.max(1).min(self.waiting.len());
        (self.under_way, self.number) = (self.waiting.drain(..count).collect(), None);
        self.under_way.clone()
    }

    /// Whether the turns that were begun have not been rejected.
    pub(crate) fn is_under_way(&self) -> bool {
        !self.under_way.is_empty()
    }

    /// Records that all turns are stepped, and belong to the transaction of this number.
    pub(crate) fn stepped(&mut self, number: i64) {
        self.number = Some(number);
    }

    /// Records that the rows of a transaction are written.
    pub(crate) fn committed(&mut self, number: i64) {
        if self.number.is_some_and(|last| number >= last) {
            (self.under_way, self.number) = (Vec::new(), None);
            self.most = self.most.saturating_mul(2).min(WAITING_MAX);
        }
    }

    /// Whether the suspect is an ordinary robot again.
    pub(crate) fn is_cleared(&self, now: Instant) -> bool {
        self.waiting.is_empty()
            && self.under_way.is_empty()
            && now >= self.refused_last.max(self.rests_until) + PROBATION
    }
}

/// The quarantine row of a message that the database rejects.
pub(crate) fn quarantined(raw: &RawMessage, rejection: &Rejection) -> QuarantineRow {
    let envelope = envelope(&raw.payload);
    let kept = raw.payload.len().min(QuarantineRow::PAYLOAD_BYTES_MAX);
    QuarantineRow {
        robot: raw.robot.to_string(),
        topic: raw.kind.as_str(),
        boot_id: envelope.as_ref().map(|envelope| envelope.boot_id.to_string()),
        seq: envelope.as_ref().map(|envelope| envelope.seq as i64),
        received_us: raw.received.0 as i64,
        quarantined_us: wall_clock().0 as i64,
        cause: rejection.cause.word(),
        code: rejection.code.clone(),
        payload: raw.payload[..kept].to_vec(),
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use bytes::Bytes;
    use vibrissa_core::units::Micros;
    use vibrissa_protocol::{Name, Topic};

    use super::*;
    use vibrissa_store::RejectionCause;

    fn raw(seq: usize) -> RawMessage {
        let topic = Topic::parse("whisker/v1/f/r/contacts").unwrap();
        let payload = Bytes::from(format!(r#"{{"boot_id":"b","seq":{seq},"contacts":[]}}"#));
        let (robot, kind) = (Name::robot("r").unwrap(), RobotTopic::Contacts);
        RawMessage { topic, robot, kind, payload, received: Micros(1) }
    }

    fn seq(turn: &Turn) -> i64 {
        let (Turn::Message(raw) | Turn::Receipt(raw)) = turn;
        envelope(&raw.payload).unwrap().seq as i64
    }

    fn rejection() -> Rejection {
        Rejection { cause: RejectionCause::Data, code: "22021".to_owned(), text: "no".to_owned() }
    }

    /// Processes messages of which the database rejects some. Returns those accepted and those in quarantine, in order,
    /// and the number of transactions.
    fn go_through(count: usize, refused: &BTreeSet<i64>) -> (Vec<i64>, Vec<i64>, usize) {
        let (mut taken, mut quarantined, mut transactions) = (Vec::new(), Vec::new(), 0);
        let mut now = Instant::now();
        let mut suspect = Suspect::new(now);
        suspect.refused(now, (0..count).map(raw).collect(), &rejection(), false);
        while !suspect.is_cleared(now) {
            now += Duration::from_secs(1);
            let turns = suspect.begin(now);
            if turns.is_empty() {
                continue;
            }
            transactions += 1;
            let messages: Vec<i64> = turns.iter().filter(|turn| matches!(turn, Turn::Message(_))).map(seq).collect();
            suspect.stepped(transactions as i64);
            if messages.iter().any(|seq| refused.contains(seq)) {
                if let Verdict::Quarantine(row) = suspect.refused(now, Vec::new(), &rejection(), false) {
                    quarantined.extend(row.seq);
                }
            } else {
                taken.extend(messages);
                suspect.committed(transactions as i64);
            }
        }
        (taken, quarantined, transactions)
    }

    #[test]
    fn brute_force_exactly_the_refused_messages_are_put_into_quarantine() {
        for mask in 0_u32..1 << 8 {
            let refused: BTreeSet<i64> = (0..8).filter(|seq| mask & (1 << seq) != 0).collect();
            let (taken, quarantined, _) = go_through(8, &refused);
            assert_eq!(quarantined, refused.iter().copied().collect::<Vec<_>>(), "{mask:08b}");
            assert_eq!(taken, (0..8).filter(|seq| !refused.contains(seq)).collect::<Vec<_>>(), "{mask:08b}");
        }
    }

    #[test]
    fn one_bad_message_of_a_thousand_is_found_in_few_transactions() {
        for bad in [0, 1, 499, 998, 999] {
            let (taken, quarantined, transactions) = go_through(1000, &BTreeSet::from([bad]));
            assert_eq!((taken.len(), quarantined), (999, vec![bad]));
            assert!(transactions <= 40, "{bad}: {transactions}");
        }
    }

    #[test]
    fn what_no_message_is_to_blame_for_makes_it_rest_longer_and_longer() {
        let mut now = Instant::now();
        let mut suspect = Suspect::new(now);
        let mut rests = Vec::new();
        for _ in 0..20 {
            assert!(matches!(suspect.refused(now, Vec::new(), &rejection(), false), Verdict::TryFewer));
            rests.push(suspect.rests_until.saturating_duration_since(now));
            now = now.max(suspect.rests_until);
        }
        assert_eq!(rests[..6].iter().map(Duration::as_millis).collect::<Vec<_>>(), [0, 0, 0, 250, 500, 1000]);
        assert_eq!(rests.last(), Some(&REST_MAX));
        assert!(!suspect.is_cleared(now));
        assert!(suspect.is_cleared(now + PROBATION));
    }

    #[test]
    fn nothing_is_blamed_where_most_robots_are_refused() {
        let mut now = Instant::now();
        let mut suspect = Suspect::new(now);
        for _ in 0..8 {
            assert!(matches!(suspect.refused(now, vec![raw(7)], &rejection(), true), Verdict::TryFewer));
            now = now.max(suspect.rests_until);
            let turns = suspect.begin(now);
            assert_eq!(turns.iter().map(seq).collect::<Vec<_>>(), [7]);
        }
    }

    #[test]
    fn what_waits_is_bounded() {
        let mut suspect = Suspect::new(Instant::now());
        let fit = (0..10_000).filter(|&seq| suspect.wait(raw(seq))).count();
        assert_eq!(fit, WAITING_MAX);
    }
}
