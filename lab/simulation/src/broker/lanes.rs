//! Delays between clients and broker.

use std::collections::VecDeque;
use std::time::Duration;

use rand::Rng;
use rand_chacha::ChaCha8Rng;
use tokio::time::Instant;

/// Direction of messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Way {
    /// From a client to the broker.
    ToBroker,
    /// From the broker to a client.
    ToClient,
}

impl Way {
    /// Both directions.
    pub const BOTH: [Self; 2] = [Self::ToBroker, Self::ToClient];
}

/// Delay of each message in one direction. Messages of a connection do not overtake each other, unless the broker keeps
/// their order within a topic only.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Delay {
    /// Least delay. Timers have a resolution of 1 ms.
    pub least: Duration,
    /// Largest addition, drawn uniformly from zero on.
    pub spread: Duration,
}

impl Delay {
    /// A delay of this length, without an addition.
    #[must_use]
    pub const fn fixed(least: Duration) -> Self {
        Self { least, spread: Duration::ZERO }
    }

    pub(super) fn draw(self, random: &mut ChaCha8Rng) -> Duration {
        if self.spread.is_zero() {
            return self.least;
        }
        let most_ns = u64::try_from(self.spread.as_nanos()).unwrap_or(u64::MAX);
        self.least + Duration::from_nanos(random.random_range(0..=most_ns))
    }
}

/// Items on their way, in their order.
#[derive(Debug)]
pub(super) struct Lane<T> {
    waiting: VecDeque<(Instant, T)>,
    /// Nothing arrives until this ends.
    pub(super) is_held: bool,
}

impl<T> Lane<T> {
    pub(super) fn new(is_held: bool) -> Self {
        Self { waiting: VecDeque::new(), is_held }
    }

    pub(super) fn push(&mut self, due: Instant, item: T) {
        let due = self.waiting.back().map_or(due, |(last, _)| due.max(*last));
        self.waiting.push_back((due, item));
    }

    /// As [`Lane::push`], but the item may overtake others than those that it `follows`.
    pub(super) fn overtake(&mut self, due: Instant, item: T, follows: impl Fn(&T, &T) -> bool) {
        let first = self.waiting.iter().rposition(|(_, other)| follows(&item, other)).map_or(0, |last| last + 1);
        let due = if first == 0 { due } else { due.max(self.waiting[first - 1].0) };
        let at = first + self.waiting.range(first..).take_while(|(other, _)| *other <= due).count();
        self.waiting.insert(at, (due, item));
    }

    /// When the next item arrives; `None` if there is none, or the lane is held.
    pub(super) fn due(&self) -> Option<Instant> {
        self.waiting.front().filter(|_| !self.is_held).map(|(due, _)| *due)
    }

    /// Takes the next item that has arrived.
    pub(super) fn take(&mut self, now: Instant) -> Option<T> {
        self.due().filter(|due| *due <= now)?;
        self.waiting.pop_front().map(|(_, item)| item)
    }

    pub(super) fn len(&self) -> usize {
        self.waiting.len()
    }

    pub(super) fn clear(&mut self) {
        self.waiting.clear();
    }
}
