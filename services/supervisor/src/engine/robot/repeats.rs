//! Whether a robot hears its receipts: one that does not sends contacts again and again that were receipted long before.

use vibrissa_core::units::Micros;

/// Age from which on a receipt must have reached its robot: two intervals after which robots send again, and a slow
/// network. Repeats of younger ones have crossed their receipt on the way.
const ARRIVED: Micros = Micros(3_000_000);
/// A robot that repeats receipted contacts for this long does not hear its receipts.
const PATIENCE: Micros = Micros(30_000_000);
/// A robot that repeats nothing for this long hears them again. Robots send again at least every few seconds.
const QUIET: Micros = Micros(15_000_000);

/// The receipts and repeats of a robot's newest boot.
#[derive(Debug, Clone, Default)]
pub(crate) struct Repeats {
    boot: i64,
    /// Contacts with lower numbers have a receipt that must have arrived.
    arrived: u64,
    /// The receipt after that: its `next`, and the time of its publication.
    under_way: Option<(u64, Micros)>,
    /// Time of the first and of the newest repeat, without a quiet time between them.
    repeats: Option<(Micros, Micros)>,
    /// The alarm stands.
    stands: bool,
}

impl Repeats {
    /// Notes a receipt for a boot, which covers all numbers below `next`.
    pub(crate) fn receipted(&mut self, boot: i64, next: u64, now: Micros) {
        if !self.is_of(boot) {
            return;
        }
        match self.under_way {
            Some((covered, sent)) if now.since(sent) >= ARRIVED => {
                (self.arrived, self.under_way) = (covered, Some((next, now)));
            }
            Some(_) => {}
            None => self.under_way = Some((next, now)),
        }
    }

    /// Notes contacts that were received before, as of their receipt.
    pub(crate) fn repeated(&mut self, boot: i64, seq: u64, now: Micros) {
        if !self.is_of(boot) || seq >= self.arrived {
            return;
        }
        let first = self.repeats.filter(|(_, newest)| now.since(*newest) < QUIET).map_or(now, |(first, _)| first);
        self.repeats = Some((first, now));
    }

    /// Forgets the repeats: the supervisor itself could not send receipts.
    pub(crate) fn excuse(&mut self) {
        self.repeats = None;
    }

    /// Whether the robot does not hear its receipts now, if that has changed since the last call.
    pub(crate) fn take_change(&mut self, now: Micros) -> Option<bool> {
        let recent = self.repeats.filter(|(_, newest)| now.since(*newest) < QUIET);
        // It stays until there are no repeats any more.
        let is = recent.is_some_and(|(first, newest)| self.stands || newest.since(first) >= PATIENCE);
        (is != std::mem::replace(&mut self.stands, is)).then_some(is)
    }

    /// Takes over a robot whose alarm stands: it stays until the robot has repeated nothing for a while.
    pub(crate) fn take_up(&mut self, now: Micros) {
        (self.stands, self.repeats) = (true, Some((now, now)));
    }

    /// Whether the alarm stands.
    pub(crate) fn stands(&self) -> bool {
        self.stands
    }

    /// Whether this is the newest boot. A newer one starts anew.
    fn is_of(&mut self, boot: i64) -> bool {
        if boot > self.boot {
            *self = Self { boot, stands: self.stands, ..Self::default() };
        }
        boot == self.boot
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(ms: u64) -> Micros {
        Micros(1_000_000_000 + ms * 1000)
    }

    /// A robot that makes contacts every 100 ms for a minute, and sends all again each second that it has no receipt for.
    /// Receipts come every 500 ms, `delay_ms` late; `hears` says which of them arrive. Returns the changes of the alarm, s.
    fn changes(delay_ms: u64, hears: impl Fn(u64) -> bool) -> Vec<(u64, bool)> {
        let (mut repeats, mut known, mut receipts) = (Repeats::default(), 0, Vec::new());
        let mut changes = Vec::new();
        for ms in (0..120_000).step_by(100) {
            let made = ms.min(60_000) / 100;
            receipts.retain(|&(arrives, next)| {
                let is_there = arrives <= ms;
                if is_there && hears(ms) {
                    known = next;
                }
                !is_there
            });
            if ms % 1000 == 0 {
                (known..made.saturating_sub(5)).for_each(|seq| repeats.repeated(1, seq, at(ms)));
            }
            if ms % 500 == 0 && (ms <= 60_000 || known < made) {
                repeats.receipted(1, made, at(ms));
                receipts.push((ms + delay_ms, made));
            }
            changes.extend(repeats.take_change(at(ms)).map(|is| (ms / 1000, is)));
        }
        changes
    }

    #[test]
    fn regress_a_robot_that_hears_no_receipt_is_found_after_half_a_minute_and_until_it_hears_them() {
        let deaf = changes(10, |_| false);
        assert!(matches!(deaf[..], [(30..=40, true)]), "{deaf:?}");
        let healed = changes(10, |ms| ms > 70_000);
        assert!(matches!(healed[..], [(30..=40, true), (85..=90, false)]), "{healed:?}");
    }

    #[test]
    fn a_slow_or_lossy_way_to_the_robot_is_no_deafness() {
        assert_eq!(changes(10, |_| true), []);
        assert_eq!(changes(2_000, |_| true), []);
        assert_eq!(changes(10, |ms| ms % 5_000 < 500), [], "one receipt in ten");
        assert_eq!(changes(10, |ms| !(20_000..45_000).contains(&ms)), [], "an outage of 25 s");
    }

    #[test]
    fn repeats_while_no_receipt_could_be_sent_and_of_an_older_boot_do_not_count() {
        let mut repeats = Repeats::default();
        for second in 0..100 {
            repeats.receipted(1, 10, at(second * 1000));
            repeats.repeated(1, 3, at(second * 1000));
            if second % 10 == 0 {
                repeats.excuse();
            }
            assert_eq!(repeats.take_change(at(second * 1000)), None);
        }
        for second in 100..200 {
            repeats.receipted(2, 10, at(second * 1000));
            repeats.receipted(1, 10, at(second * 1000));
            repeats.repeated(1, 3, at(second * 1000));
            assert_eq!(repeats.take_change(at(second * 1000)), None, "an older boot");
        }
    }
}
