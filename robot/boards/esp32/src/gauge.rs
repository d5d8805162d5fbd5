//! The condition of the gauge. It is repeated while it is bad, as the agent may have started anew.

/// Without a bad reading for this long the gauge counts as in order. µs.
const CLEAN_US: u64 = 10_000_000;
/// A bad condition is told so often. µs.
const REPEAT_US: u64 = 2_000_000;

#[derive(Clone, Copy, Default, PartialEq, Eq)]
enum Condition {
    #[default]
    Good,
    /// The converter is at an end of its range.
    Saturated,
    /// It gives no reading.
    Open,
}

#[derive(Default)]
pub(crate) struct Gauge {
    /// The worst condition since the last line.
    worst: Condition,
    told: Condition,
    told_us: u64,
    /// Time of the newest bad reading.
    bad_us: u64,
}

impl Gauge {
    pub(crate) fn read(&mut self, strain: f32, is_at_end: bool) {
        if !strain.is_finite() {
            self.worst = Condition::Open;
        } else if is_at_end && self.worst == Condition::Good {
            self.worst = Condition::Saturated;
        }
    }

    /// The word to tell now, if one is due.
    pub(crate) fn due(&mut self, now_us: u64) -> Option<&'static str> {
        if self.worst != Condition::Good {
            self.bad_us = now_us;
        }
        let condition = self.condition(now_us);
        let is_again = condition != Condition::Good && now_us.saturating_sub(self.told_us) >= REPEAT_US;
        if condition == self.told && !is_again {
            // Only a bad condition that is to be told stays until it has room.
            self.worst = Condition::Good;
            return None;
        }
        Some(match condition {
            Condition::Good => "OK",
            Condition::Saturated => "SATURATED",
            Condition::Open => "OPEN",
        })
    }

    /// The word was told.
    pub(crate) fn told(&mut self, now_us: u64) {
        self.told = self.condition(now_us);
        self.told_us = now_us;
        self.worst = Condition::Good;
    }

    fn condition(&self, now_us: u64) -> Condition {
        let is_clean = now_us.saturating_sub(self.bad_us) >= CLEAN_US;
        if self.worst == Condition::Good && !is_clean { self.told } else { self.worst }
    }
}
