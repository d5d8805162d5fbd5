//! The age of the oldest of many items that enter and leave in about the same order, without a list of them.

use tokio::time::Instant;

/// Counts the items that have entered and left. A mark is the number of items at a moment: once as many have left, a new
/// mark is made. So the age is never greater than that of the oldest item, and at most one turn of the items behind it.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Watermark {
    entered: u64,
    left: u64,
    mark: Option<(u64, Instant)>,
}

impl Watermark {
    pub(super) fn enter(&mut self, count: u64, now: Instant) {
        self.entered += count;
        if count > 0 {
            self.mark.get_or_insert((self.entered, now));
        }
    }

    /// More items than have entered cannot leave.
    pub(super) fn leave(&mut self, count: u64, now: Instant) {
        self.left = (self.left + count).min(self.entered);
        if self.mark.is_some_and(|(until, _)| self.left >= until) {
            self.mark = (self.left < self.entered).then_some((self.entered, now));
        }
    }

    /// Since when the oldest item has waited, at least; `None` if all have left.
    pub(super) fn oldest(&self) -> Option<Instant> {
        self.mark.map(|(_, since)| since)
    }
}
