//! Tests of contacts and receipts: which messages are sent again, when, and in which order.

use std::time::Duration;

use tokio::time::Instant;
use vibrissa_protocol::{BootId, Factsheet, Rule};

use super::bench::Bench;
use super::listener::Listener;
use super::report::seconds;

/// Number of transmissions of one message, including the first, whose pauses are compared.
const SENDINGS: usize = 4;
/// The same if these pauses have not grown: a busy machine delays some by seconds, which hardly changes longer ones.
const SENDINGS_IN_DOUBT: usize = 6;
/// Smallest ratio of the last pause to the shortest one that counts as exponential growth.
const GROWTH: f64 = 1.6;
/// Rules that can be tested only on robots that send contacts again.
const AGAIN: [Rule; 7] = [
    Rule::ResendOldestFirst,
    Rule::ResendBackoff,
    Rule::ResendSame,
    Rule::ReceiptNext,
    Rule::ReceiptHeld,
    Rule::ReceiptGap,
    Rule::ReceiptBoot,
];

impl Bench {
    /// Tests contacts, if any arrive, and receipts, if the robot supports them.
    pub(super) async fn contacts(&mut self) -> anyhow::Result<()> {
        let limit = self.timings().contacts;
        let Some(boot) =
            self.until(limit, |heard| heard.boot.clone().filter(|boot| heard.ledger(boot).len() > 0)).await?
        else {
            let why = format!("no contacts arrived within {}: touch a whisker during the check", seconds(limit));
            self.skip(
                &[
                    Rule::ContactsInRange,
                    Rule::ContactsOnFactsheet,
                    Rule::StrainWithinGauge,
                    Rule::PlaceAsStated,
                    Rule::ContactsResent,
                ],
                &why,
            );
            self.skip(&AGAIN, &why);
            return Ok(());
        };
        let states_range = |factsheet: &Factsheet| {
            factsheet.arrays.iter().flat_map(|array| &array.whiskers).any(|one| one.strain_max.is_some())
        };
        if !self.heard.factsheet.as_ref().is_some_and(states_range) {
            self.exempt(&[Rule::StrainWithinGauge], "the factsheet states no strain_max");
        }
        if self.heard.at_least_once > 0 {
            let why = "contacts come with quality of service 1: this robot leaves retransmission to MQTT";
            self.skip(&[Rule::ContactsResent], why);
            self.skip(&AGAIN, why);
            return Ok(());
        }
        // Receipts everything so far, so that the first pause is the shortest.
        let first = self.heard.ledger(&boot).end();
        self.receipt(&boot, first, &[]).await?;
        self.judge_order(&boot, true);
        let is_resending = self.withhold(&boot, first).await?;
        self.is_resending = is_resending;
        self.judge_order(&boot, false);
        let missing = self.heard.ledger(&boot).missing(first);
        if let Some(seq) = missing.first() {
            let seen = format!("contacts {seq} and {} others never arrived", missing.len() - 1);
            self.fail(Rule::SeqWithoutGaps, seen);
        }
        if is_resending {
            self.partly(&boot).await?;
            let end = self.heard.ledger(&boot).end();
            self.receipt(&boot, end, &[]).await?;
        }
        Ok(())
    }

    fn judge_order(&mut self, boot: &BootId, judges_order: bool) {
        if let Some(ledger) = self.heard.ledger_mut(boot) {
            ledger.judges_order = judges_order;
        }
    }

    /// Withholds receipts, and watches whether messages from `first` on are sent again; returns whether they are.
    async fn withhold(&mut self, boot: &BootId, first: u64) -> anyhow::Result<bool> {
        let (contacts, resend, backoff) = (self.timings().contacts, self.timings().resend, self.timings().backoff);
        let oldest = |heard: &Listener| heard.ledger(boot).uncovered().into_iter().find(|&seq| seq >= first);
        let Some(seq) = self.until(contacts, oldest).await? else {
            let why = format!("no more contacts arrived within {}", seconds(contacts));
            self.skip(&[Rule::ContactsResent], &why);
            self.skip(&AGAIN, &why);
            return Ok(false);
        };
        let again = self.until(resend, |heard| (heard.ledger(boot).times(seq).len() > 1).then_some(())).await?;
        if again.is_none() {
            self.fail(Rule::ContactsResent, format!("contacts {seq} was not sent again within {}", seconds(resend)));
            self.skip(&AGAIN, "nothing is sent again");
            return Ok(false);
        }
        self.pass(Rule::ContactsResent, format!("contacts {seq} was sent again"));
        let begun = Instant::now();
        for sendings in [SENDINGS, SENDINGS_IN_DOUBT] {
            let left = backoff.saturating_sub(begun.elapsed());
            let has_enough = |heard: &Listener| (heard.ledger(boot).times(seq).len() >= sendings).then_some(());
            if self.until(left, has_enough).await?.is_none() || has_grown(&self.pauses(boot, seq, sendings)) {
                break;
            }
        }
        self.judge_pauses(boot, seq, backoff);
        self.skip(&[Rule::ResendOldestFirst], "at no time did more than one message wait to be sent again");
        Ok(true)
    }

    /// Pauses between the first transmissions of a message, s.
    fn pauses(&self, boot: &BootId, seq: u64, sendings: usize) -> Vec<f64> {
        let times = self.heard.ledger(boot).times(seq);
        let pause = |pair: &[Instant]| (pair[1] - pair[0]).as_secs_f64();
        times.windows(2).take(sendings - 1).map(pause).collect()
    }

    fn judge_pauses(&mut self, boot: &BootId, seq: u64, limit: Duration) {
        let pauses = self.pauses(boot, seq, SENDINGS_IN_DOUBT);
        let shown = pauses.iter().map(|pause| format!("{pause:.2}")).collect::<Vec<_>>().join(", ");
        if pauses.len() < SENDINGS - 1 {
            let sent = pauses.len() + 1;
            let why = format!("contacts {seq} arrived only {sent} times within {} (pauses {shown} s)", seconds(limit));
            self.skip(&[Rule::ResendBackoff], &why);
            return;
        }
        let holds = has_grown(&pauses[..SENDINGS - 1]) || has_grown(&pauses);
        self.judge(Rule::ResendBackoff, holds, format!("contacts {seq} arrived after pauses of {shown} s"));
    }

    /// Sends a receipt with a gap, and a receipt for another boot.
    async fn partly(&mut self, boot: &BootId) -> anyhow::Result<()> {
        let (contacts, resend, grace) = (self.timings().contacts, self.timings().resend, self.timings().grace);
        let enough = |heard: &Listener| {
            let open = heard.ledger(boot).uncovered();
            (open.len() >= 4).then(|| [open[0], open[1], open[2], open[3]])
        };
        let Some([below, gap, held, beyond]) = self.until(contacts, enough).await? else {
            let why = "fewer than four contacts messages arrived: touch whiskers more often during the check";
            self.skip(&[Rule::ReceiptNext, Rule::ReceiptHeld, Rule::ReceiptGap, Rule::ReceiptBoot], why);
            return Ok(());
        };
        let receipted = Instant::now();
        self.receipt(boot, below + 1, &[held]).await?;
        let text = format!("after next = {}, held = [[{held}, {held}]]", below + 1);
        let since = receipted + grace;
        let both = |heard: &Listener| {
            let comes = |seq| heard.ledger(boot).times(seq).iter().any(|&at| at > since);
            (comes(gap) && comes(beyond)).then_some(())
        };
        let all = self.until(resend, both).await?;
        // Collects the late messages of the same round.
        self.listen(grace / 2).await?;
        self.pass(Rule::ReceiptNext, format!("{text}, contacts {below} was not sent again"));
        self.pass(Rule::ReceiptHeld, format!("{text}, contacts {held} was not sent again"));
        if all.is_none() && !self.heard.ledger(boot).times(gap).iter().any(|&at| at > since) {
            let seen = format!("{text}, contacts {gap} was not sent again within {}", seconds(resend));
            self.fail(Rule::ReceiptGap, seen);
            self.skip(&[Rule::ReceiptBoot], "messages that a receipt leaves open are not sent again");
            return Ok(());
        }
        self.pass(Rule::ReceiptGap, format!("{text}, contacts {gap} was sent again"));
        self.foreign(boot, gap).await
    }

    /// Sends a receipt for another boot, which must cover nothing.
    async fn foreign(&mut self, boot: &BootId, open: u64) -> anyhow::Result<()> {
        let other = BootId::new("a-boot-that-never-was")?;
        let (end, receipted) = (self.heard.ledger(boot).end(), Instant::now());
        self.receipt(&other, end, &[]).await?;
        let (resend, since) = (self.timings().resend, receipted + self.timings().grace / 2);
        let comes = |heard: &Listener| heard.ledger(boot).times(open).iter().any(|&at| at > since).then_some(());
        let again = self.until(resend, comes).await?;
        let how = if again.is_some() { "was sent again" } else { "was not sent again" };
        let seen = format!("after a receipt for another boot, contacts {open} {how}");
        self.judge(Rule::ReceiptBoot, again.is_some(), seen);
        Ok(())
    }
}

/// Whether the last pause is longer than the shortest one before it, as exponential growth makes it.
fn has_grown(pauses: &[f64]) -> bool {
    let Some((last, before)) = pauses.split_last() else { return false };
    *last >= GROWTH * before.iter().copied().fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pauses between arrivals if each transmission is late by so much. The robot waits from one transmission to the next.
    fn arrivals(pauses: &[f64], late: &[f64]) -> Vec<f64> {
        pauses.iter().zip(late.windows(2)).map(|(pause, late)| pause + late[1] - late[0]).collect()
    }

    #[test]
    fn pauses_that_double_have_grown_at_the_latest_after_six_transmissions_that_come_seconds_late() {
        let doubling = [1.0, 2.0, 4.0, 8.0, 16.0];
        assert!(has_grown(&doubling[..3]) && has_grown(&doubling));
        let is_late = arrivals(&doubling, &[0.0, 2.0, 2.5, 1.0, 3.0, 0.5]);
        assert!(!has_grown(&is_late[..3]), "{is_late:?}");
        for late in [[0.0, 2.0, 2.5, 1.0, 3.0, 0.5], [0.0, 3.0, 3.0, 1.0, 4.0, 0.0], [4.0, 4.0, 4.0, 0.0, 4.0, 0.0]] {
            assert!(has_grown(&arrivals(&doubling, &late)), "{late:?}");
        }
    }

    #[test]
    fn even_pauses_have_not_grown() {
        let even = [1.0; 5];
        assert!(!has_grown(&even[..3]) && !has_grown(&even));
        assert!(!has_grown(&arrivals(&even, &[0.0, 0.2, 0.1, 0.3, 0.2, 0.4])) && !has_grown(&[]));
    }
}
