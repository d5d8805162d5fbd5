//! Answers to requests for births, which all robots of a fleet receive at once.

use super::Moment;

/// Longest delay of an answer, in microseconds. Random delays keep a fleet from answering at the same moment.
pub const DELAY_MAX_US: u64 = 2_000_000;

/// The time of the next answer.
#[derive(Debug, Default)]
pub struct Births {
    due: Option<Moment>,
}

impl Births {
    /// Time of the next answer, if a request waits for one.
    #[must_use]
    pub fn due(&self) -> Option<Moment> {
        self.due
    }

    /// A birth was sent, which answers all requests so far.
    pub fn sent(&mut self) {
        self.due = None;
    }

    /// A request has arrived. One answer serves all requests that arrive before it. `delay_us` is random and below
    /// [`DELAY_MAX_US`].
    pub fn requested(&mut self, now: Moment, delay_us: u64) {
        self.due.get_or_insert(now + delay_us);
    }
}
