//! Tests of a full memory: contacts are not receipted until the robot drops the oldest.

use tokio::time::Instant;
use vibrissa_protocol::{BootId, Rule};

use super::action::Action;
use super::assisted::Told;
use super::bench::Bench;
use super::listener::Listener;
use super::report::seconds;

const RULES: [Rule; 2] = [Rule::ContactsDropped, Rule::ContactsBounded];

/// A full memory.
#[derive(Debug)]
struct Full {
    boot: BootId,
    /// Number of the oldest message without a receipt.
    first: u64,
    /// `contacts_dropped` before.
    before: u64,
}

/// Observations of a full memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Seen {
    /// Number of the oldest message without a receipt, before anything was dropped.
    first: u64,
    /// Number of the oldest message that the robot still sends.
    oldest: u64,
    /// Rise of `contacts_dropped` before that message was sent, and after it.
    dropped: (u64, u64),
}

impl Bench {
    /// Tests which contacts messages the robot keeps, and its count of the others.
    pub(super) async fn memory(&mut self, progress: Told<'_>) -> anyhow::Result<()> {
        if self.heard.at_least_once > 0 {
            self.skip(&RULES, "contacts come with quality of service 1: this robot leaves retransmission to MQTT");
            return Ok(());
        }
        let Some(boot) = self.heard.boot.clone().filter(|_| self.is_resending) else {
            self.skip(&RULES, "no contacts messages were sent again");
            return Ok(());
        };
        let needed = [Rule::ResendOldestFirst, Rule::ReceiptNext, Rule::ReceiptHeld, Rule::ReceiptGap];
        if self.has_failed(&needed) {
            self.skip(&RULES, "the robot does not obey receipts, with which the test finds what it keeps");
            return Ok(());
        }
        let first = self.heard.ledger(&boot).end();
        self.receipt(&boot, first, &[]).await?;
        self.listen(self.timings().grace).await?;
        let Some(before) = self.next_dropped().await? else {
            self.skip(&RULES, "no status came");
            return Ok(());
        };
        let full = Full { boot, first, before };
        let limit = self.timings().fill;
        self.please(progress, Action::Touch, limit);
        let mark = self.mark();
        let is_full = |heard: &Listener| {
            let is_counted = dropped(heard, mark).is_some_and(|count| count > before);
            (is_counted || heard.ledger(&full.boot).is_gone(first)).then_some(())
        };
        let filled = self.until(limit, is_full).await?;
        self.please(progress, Action::Rest, self.timings().help);
        if filled.is_some() {
            self.judge_full(&full).await?;
        } else {
            let sent = self.heard.ledger(&full.boot).end() - first;
            let why = format!(
                "the robot dropped none of {sent} messages within {}: give it a smaller memory for the check, touch \
                 more often, or raise --fill",
                seconds(limit)
            );
            self.skip(&RULES, &why);
        }
        // A silence of this length may have changed the pressure.
        self.is_away = true;
        let end = self.heard.ledger(&full.boot).end();
        self.receipt(&full.boot, end, &[]).await
    }

    async fn judge_full(&mut self, full: &Full) -> anyhow::Result<()> {
        let before = full.before;
        let rise = |count: Option<u64>| count.unwrap_or(before).saturating_sub(before);
        // A status that was under way when the first message was dropped does not count it.
        let counted = rise(self.next_dropped().await?);
        // Receipts the newest message only: the pauses start over, and the oldest ones come again.
        let (newest, receipted) = (self.heard.ledger(&full.boot).end() - 1, Instant::now());
        self.receipt(&full.boot, full.first, &[newest]).await?;
        let (resend, grace) = (self.timings().resend, self.timings().grace);
        let since = receipted + grace / 2;
        if self.until(resend, |heard| heard.ledger(&full.boot).oldest_again(since)).await?.is_none() {
            self.fail(Rule::ContactsBounded, format!("nothing was sent again within {} of a receipt", seconds(resend)));
            self.skip(&RULES, "nothing is sent again by a full memory");
            return Ok(());
        }
        // Collects the other messages of the same round.
        self.listen(grace / 2).await?;
        let oldest = self.heard.ledger(&full.boot).oldest_again(since).unwrap_or(full.first);
        let later = rise(self.next_dropped().await?);
        let seen = Seen { first: full.first, oldest, dropped: (counted, later) };
        let newest = self.heard.ledger(&full.boot).end() - 1;
        let text = seen.text();
        if seen.is_nothing() {
            self.skip(&RULES, &format!("{text}: a message that seemed to be dropped came late"));
            return Ok(());
        }
        self.judge(Rule::ContactsDropped, seen.is_counted(), text.clone());
        if !seen.is_bounded() {
            self.fail(Rule::ContactsBounded, text);
            return Ok(());
        }
        // The newest one was kept, too.
        let receipted = Instant::now();
        self.receipt(&full.boot, newest, &[]).await?;
        let comes =
            |heard: &Listener| heard.ledger(&full.boot).times(newest).iter().any(|&at| at > receipted).then_some(());
        let is_kept = self.until(resend, comes).await?.is_some();
        let how = if is_kept { "was sent again" } else { "was not sent again" };
        self.judge(Rule::ContactsBounded, is_kept, format!("{text}; contacts {newest}, the newest, {how}"));
        Ok(())
    }

    /// `contacts_dropped` of the next status.
    async fn next_dropped(&mut self) -> anyhow::Result<Option<u64>> {
        let (mark, limit) = (self.mark(), self.timings().status.1 + self.timings().answer);
        self.until(limit, |heard| dropped(heard, mark)).await
    }
}

/// `contacts_dropped` of the newest status since a position in the log.
fn dropped(heard: &Listener, mark: usize) -> Option<u64> {
    heard.statuses(mark).last().map(|(status, _)| status.contacts_dropped.unwrap_or(0))
}

impl Seen {
    /// Whether nothing was dropped.
    fn is_nothing(self) -> bool {
        self.oldest <= self.first && self.dropped.1 == 0
    }

    /// Whether the oldest messages are gone.
    fn is_bounded(self) -> bool {
        self.oldest > self.first && self.oldest >= self.first + self.dropped.0
    }

    /// Whether the count rose, and by as many as are gone.
    fn is_counted(self) -> bool {
        // If others than the oldest were dropped, only the rise can be judged.
        self.dropped.1 > 0 && (!self.is_bounded() || self.oldest <= self.first + self.dropped.1)
    }

    fn text(self) -> String {
        let Self { first, oldest, dropped: (counted, later) } = self;
        let count = if counted == later { counted.to_string() } else { format!("{counted} to {later}") };
        let gone = if oldest > first {
            format!("contacts {first} to {} are no longer sent", oldest - 1)
        } else {
            format!("contacts {oldest} is still sent")
        };
        format!("{gone}, and contacts_dropped rose by {count}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_oldest_must_be_gone_and_as_many_as_are_counted() {
        let judged = |oldest, dropped| {
            let seen = Seen { first: 10, oldest, dropped };
            (seen.is_bounded(), seen.is_counted())
        };
        assert_eq!(judged(13, (3, 3)), (true, true));
        // The robot went on dropping while it was observed.
        assert_eq!(judged(15, (3, 7)), (true, true));
        // It counts nothing, or too few.
        assert_eq!(judged(13, (0, 0)), (true, false));
        assert_eq!(judged(13, (1, 2)), (true, false));
        // It drops the newest, or others between.
        assert_eq!(judged(10, (3, 3)), (false, true));
        assert_eq!(judged(12, (3, 3)), (false, true));
        assert!(Seen { first: 10, oldest: 10, dropped: (0, 0) }.is_nothing());
    }
}
