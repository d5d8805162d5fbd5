//! Group commit: when the open batches, and receipts with them, become a transaction. Few messages are committed in
//! rounds of 500 ms; a setpoint is committed at once; more messages are committed after 20 ms or with the next
//! receipts. The first messages of a new owner are committed, with receipts, after 20 ms: their robots have waited.
//!
//! Batching matters because each commit waits for the disk, each receipt wakes a robot, and in a quiet fleet each
//! wake-up finds cold caches.

use std::time::Duration;

use tokio::time::Instant;

/// Interval of the core's ticks.
pub(crate) const TICK: Duration = Duration::from_millis(250);
/// Interval of receipts at a high message rate.
pub(crate) const RECEIPTS: Duration = Duration::from_millis(100);
/// How long a batch collects messages at a high message rate.
const GATHER: Duration = Duration::from_millis(20);
/// Number of messages between two ticks up to which the rate is low.
const FEW: usize = 40;
/// Ticks per round: half of the time after which a robot sends again.
const TICKS_A_ROUND: u32 = 2;

/// Schedule of one fleet's commits.
#[derive(Debug)]
pub(crate) struct Schedule {
    /// When the open batches must be committed.
    due: Option<Instant>,
    /// Since when there is anything to commit.
    since: Option<Instant>,
    /// Number of messages since the last commit began.
    gathered: usize,
    /// Number of messages since the last tick, and between the last two ticks.
    messages: [usize; 2],
    /// Receipts and waiting checkpoints go with the next commit.
    receipts_due: bool,
    /// Number of consecutive commits that have left them to the next one.
    passed_over: u32,
    /// Number of the current round.
    number: u64,
    /// How long a batch collects messages at a high message rate.
    gather: Duration,
    /// No message has been committed yet.
    is_first: bool,
}

impl Schedule {
    /// A schedule whose first commit is due at once.
    pub(crate) fn new(now: Instant) -> Self {
        Self {
            due: Some(now),
            since: None,
            gathered: 0,
            messages: [0; 2],
            receipts_due: false,
            passed_over: 0,
            number: 0,
            gather: GATHER,
            is_first: true,
        }
    }

    /// Collects messages for a tick: a partitioned log has them, and each transaction costs far more than its reference.
    pub(crate) fn gather_for_a_tick(&mut self) {
        self.gather = TICK;
    }

    /// Number of the current round: a new one begins with each commit, and with each call while there is nothing to
    /// commit.
    pub(crate) fn number(&mut self) -> u64 {
        if self.due.is_none() {
            self.number += 1;
        }
        self.number
    }

    /// Counts handled messages.
    pub(crate) fn count(&mut self, messages: usize) {
        self.messages[0] += messages;
        self.gathered += messages;
    }

    /// Shortens the wait: messages already wait for the next transaction, so there are more than a few.
    pub(crate) fn hurry(&mut self) {
        if let Some(since) = self.since {
            self.due_by(since + GATHER);
        }
    }

    /// Schedules a commit of the open batches: with the round at a low message rate, otherwise after 20 ms.
    pub(crate) fn has_gathered(&mut self, now: Instant) {
        let are_few = self.gathered <= FEW * TICKS_A_ROUND as usize;
        let window = if self.is_first {
            GATHER
        } else if are_few {
            TICK * TICKS_A_ROUND
        } else {
            self.gather
        };
        self.receipts_due |= self.is_first;
        let since = *self.since.get_or_insert(now);
        self.due_by(since + window);
    }

    /// Makes a commit due at `due` at the latest.
    pub(crate) fn due_by(&mut self, due: Instant) {
        self.due = Some(self.due.map_or(due, |earlier| earlier.min(due)));
    }

    /// When the next commit is due, if there is one.
    pub(crate) fn due(&self) -> Option<Instant> {
        self.due
    }

    /// Whether the message rate is low, so that messages wait for the next round.
    pub(crate) fn are_few(&self) -> bool {
        self.messages.iter().all(|&messages| messages <= FEW)
    }

    /// Counts a tick with this number. Returns whether receipts are to be checked now.
    pub(crate) fn tick(&mut self, number: u32) -> bool {
        let is_round = number.is_multiple_of(TICKS_A_ROUND) || !self.are_few();
        self.messages = [0, self.messages[0]];
        is_round
    }

    /// Makes receipts part of the next commit, which is due at `now`.
    pub(crate) fn receipts_are_due(&mut self, now: Instant) {
        self.receipts_due = true;
        self.due_by(now);
    }

    /// Number of consecutive commits without the receipts that were due.
    pub(crate) fn passed_over(&self) -> u32 {
        self.passed_over
    }

    /// Begins a commit. Returns whether it includes receipts. A commit that `passes_over` due receipts leaves them to
    /// the next one, which is then due at once.
    pub(crate) fn begin(&mut self, passes_over: bool, now: Instant) -> bool {
        self.is_first &= self.since.is_none();
        (self.due, self.since, self.gathered) = (None, None, 0);
        self.number += 1;
        let receipts = self.receipts_due && !passes_over;
        self.receipts_due &= !receipts;
        self.passed_over = if self.receipts_due { self.passed_over + 1 } else { 0 };
        if self.receipts_due {
            self.due_by(now);
        }
        receipts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: Duration = Duration::from_millis(1);

    /// A schedule after its first commit of a message.
    fn begun(now: Instant) -> Schedule {
        let mut schedule = Schedule::new(now);
        schedule.has_gathered(now);
        schedule.begin(false, now);
        schedule
    }

    /// Handles `messages` messages every `gap_ms` for ten seconds. Returns the number of commits, and the longest wait,
    /// ms.
    fn commits(messages: usize, gap_ms: u64) -> (u32, u64) {
        let begin = Instant::now();
        let mut schedule = begun(begin);
        let (mut commits, mut longest_ms, mut oldest_ms) = (0, 0, None);
        for ms in 0..10_000 {
            let now = begin + Duration::from_millis(ms);
            if ms.is_multiple_of(gap_ms) {
                schedule.count(messages);
                schedule.has_gathered(now);
                oldest_ms.get_or_insert(ms);
            }
            let is_round = ms.is_multiple_of(250) && schedule.tick((ms / 250) as u32);
            let is_look = is_round || ms.is_multiple_of(100) && !schedule.are_few();
            if is_look && oldest_ms.is_some() {
                schedule.receipts_are_due(now);
            }
            if schedule.due().is_some_and(|due| due <= now) {
                assert_eq!(schedule.begin(false, now), is_look);
                longest_ms = longest_ms.max(oldest_ms.take().map_or(0, |oldest_ms| ms - oldest_ms));
                commits += 1;
            }
        }
        (commits, longest_ms)
    }

    #[test]
    fn few_messages_are_committed_in_rounds_and_many_after_some_milliseconds() {
        for (messages, gap_ms, expected, wait_ms) in
            [(1, 100, 19..=21, 500), (1, 10, 19..=21, 500), (1, 1, 190..=210, 100), (100, 1, 450..=550, 20)]
        {
            let (count, longest_ms) = commits(messages, gap_ms);
            assert!(expected.contains(&count), "{messages} each {gap_ms} ms: {count}");
            assert!(longest_ms <= wait_ms, "{messages} each {gap_ms} ms: {longest_ms}");
        }
    }

    #[test]
    fn many_messages_wait_for_20_ms_from_the_first_and_a_setpoint_for_nothing() {
        let now = Instant::now();
        let mut schedule = begun(now);
        assert_eq!(schedule.due(), None);
        schedule.count(1);
        schedule.has_gathered(now);
        assert_eq!(schedule.due(), Some(now + TICK * TICKS_A_ROUND));
        schedule.count(100);
        schedule.has_gathered(now + MS);
        assert_eq!(schedule.due(), Some(now + GATHER));
        schedule.due_by(now + 2 * MS);
        assert_eq!(schedule.due(), Some(now + 2 * MS));
        schedule.begin(false, now + 2 * MS);
        assert_eq!(schedule.due(), None, "the next batch starts empty");
    }

    #[test]
    fn the_first_message_of_an_owner_is_committed_after_20_ms_with_its_receipt() {
        let now = Instant::now();
        let mut schedule = Schedule::new(now);
        assert!(!schedule.begin(false, now), "nothing has come yet");
        schedule.count(1);
        schedule.has_gathered(now + MS);
        assert_eq!(schedule.due(), Some(now + MS + GATHER));
        assert!(schedule.begin(false, now + MS + GATHER));
        schedule.count(1);
        schedule.has_gathered(now + 2 * MS);
        assert_eq!(schedule.due(), Some(now + 2 * MS + TICK * TICKS_A_ROUND));
    }

    #[test]
    fn what_others_wait_for_is_committed_after_20_ms_and_nothing_is_committed_for_nothing() {
        let now = Instant::now();
        let mut schedule = begun(now);
        schedule.hurry();
        assert_eq!(schedule.due(), None);
        schedule.count(1);
        schedule.has_gathered(now);
        schedule.hurry();
        assert_eq!(schedule.due(), Some(now + GATHER));
    }

    #[test]
    fn a_round_lasts_until_a_commit_or_while_there_is_nothing_to_commit() {
        let now = Instant::now();
        let mut schedule = begun(now);
        let first = schedule.number();
        assert!(schedule.number() > first, "a new round while there is nothing to commit");
        schedule.count(1);
        schedule.has_gathered(now);
        let gathered_for = schedule.number();
        assert_eq!(schedule.number(), gathered_for);
        schedule.begin(false, now);
        schedule.count(1);
        schedule.has_gathered(now);
        assert!(schedule.number() > gathered_for);
    }

    #[test]
    fn receipts_that_are_passed_over_are_due_at_once() {
        let now = Instant::now();
        let mut schedule = begun(now);
        schedule.receipts_are_due(now);
        for passed_over in 1..=3 {
            assert!(!schedule.begin(true, now), "passed over");
            assert_eq!((schedule.due(), schedule.passed_over()), (Some(now), passed_over));
        }
        assert!(schedule.begin(false, now));
        assert_eq!((schedule.due(), schedule.passed_over()), (None, 0));
        assert!(!schedule.begin(false, now), "receipts are included only once");
    }
}
