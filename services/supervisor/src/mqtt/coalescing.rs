//! Poll coalescing: how often to read from the network in a burst.
//!
//! A broker writes each message separately. A reader that reads at once gets one or two, and pays a wake-up, a read and
//! the write of an acknowledgement for them: several times the cost of the messages themselves. So at a high rate the
//! receiving thread sleeps for half a millisecond between two reads. This must not slow a burst down, as it does with a
//! broker that allows few unacknowledged messages and therefore waits for each read. So a trial decides: turns with and
//! without pauses alternate, because robots that wait for receipts send in waves, and a single turn says little.

use std::time::Duration;

use tokio::time::Instant;

/// Pause between two reads.
pub(super) const PAUSE: Duration = Duration::from_micros(500);
/// Limit of messages per read; a read that reaches it is followed by the next one at once.
pub(super) const READ_MAX: usize = 128;
/// Rate from which on it is a burst, messages per second; a burst ends below half of it.
const BUSY_PER_S: f64 = 8_000.0;
/// Period over which the rate is measured outside a burst,
const WINDOW: Duration = Duration::from_millis(10);
/// and in a burst, and length of a turn of a trial: the interval of receipts.
const TURN: Duration = Duration::from_millis(100);
/// Turns of a trial, alternately with and without pauses, beginning with pauses.
const TURNS: u32 = 10;
/// Least number of messages with pauses, as a fraction of the number without, for which pauses are used.
const LEFT_MIN: f64 = 0.8;
/// How long the result of a trial holds.
const RESULT_VALID_FOR: Duration = Duration::from_secs(30);

/// Decides whether one connection pauses between reads.
#[derive(Debug)]
pub(super) struct PollCoalescing {
    since: Instant,
    messages: u64,
    state: State,
    result: Option<TrialResult>,
}

/// Result of the last trial, and the end of its validity.
#[derive(Debug, Clone, Copy, PartialEq)]
struct TrialResult {
    pauses: bool,
    until: Instant,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum State {
    /// Low rate: reads without pauses.
    Calm,
    /// Trial in a burst: number of turns so far, and numbers of messages with pauses and without.
    Trial(u32, [u64; 2]),
    /// A burst after a trial, with pauses or without.
    Burst(bool),
}

impl PollCoalescing {
    pub(super) fn new(now: Instant) -> Self {
        Self { since: now, messages: 0, state: State::Calm, result: None }
    }

    /// Whether to pause before the next read; `messages` is the number of messages of the last one.
    pub(super) fn pauses(&mut self, now: Instant, messages: usize) -> bool {
        self.messages += messages as u64;
        let elapsed = now.saturating_duration_since(self.since);
        if elapsed >= if self.state == State::Calm { WINDOW } else { TURN } {
            self.state = self.after(now, self.messages as f64 / elapsed.as_secs_f64());
            (self.since, self.messages) = (now, 0);
        }
        let pauses = match self.state {
            State::Calm => false,
            State::Trial(turns, _) => turns.is_multiple_of(2),
            State::Burst(pauses) => pauses,
        };
        pauses && messages < READ_MAX
    }

    /// The state after a period with this rate, messages per second.
    fn after(&mut self, now: Instant, per_s: f64) -> State {
        let is_burst = per_s >= if self.state == State::Calm { BUSY_PER_S } else { BUSY_PER_S / 2.0 };
        if !is_burst {
            return State::Calm;
        }
        match self.state {
            State::Trial(turns, mut came) => {
                came[turns as usize % 2] += self.messages;
                if turns + 1 < TURNS {
                    return State::Trial(turns + 1, came);
                }
                let pauses = came[0] as f64 >= LEFT_MIN * came[1] as f64;
                self.result = Some(TrialResult { pauses, until: now + RESULT_VALID_FOR });
                State::Burst(pauses)
            }
            State::Calm | State::Burst(_) => match self.result {
                Some(result) if now < result.until => State::Burst(result.pauses),
                Some(_) | None => State::Trial(0, [0; 2]),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: Duration = Duration::from_millis(1);

    /// Reads `count` times, once a millisecond, and returns the number of pauses. `brings` gives the messages of a
    /// read; its argument says whether a pause was before it.
    fn reads(
        coalescing: &mut PollCoalescing,
        now: &mut Instant,
        count: usize,
        mut brings: impl FnMut(bool) -> usize,
    ) -> usize {
        let mut is_paused = false;
        let read = |_: &usize| {
            *now += MS;
            is_paused = coalescing.pauses(*now, brings(is_paused));
            is_paused
        };
        (0..count).filter(read).count()
    }

    #[test]
    fn pauses_begin_with_a_burst_and_end_with_it() {
        let mut now = Instant::now();
        let mut coalescing = PollCoalescing::new(now);
        assert_eq!(reads(&mut coalescing, &mut now, 1_000, |_| 7), 0, "7,000 a second");
        let trial = reads(&mut coalescing, &mut now, 1_010, |_| 50);
        assert!((490..=510).contains(&trial), "{trial}");
        assert!(reads(&mut coalescing, &mut now, 1_000, |_| 50) >= 990);
        assert!(reads(&mut coalescing, &mut now, 500, |_| 1) <= 110);
        assert_eq!(reads(&mut coalescing, &mut now, 500, |_| 1), 0);
        assert!(reads(&mut coalescing, &mut now, 100, |_| 50) >= 90, "the result holds for the next burst");
    }

    #[test]
    fn robots_that_send_by_fits_and_starts_are_paused() {
        let mut now = Instant::now();
        let mut coalescing = PollCoalescing::new(now);
        let mut at = 0;
        let mut wave = |_| {
            at += 1;
            if at % 130 < 60 { 127 } else { 1 }
        };
        reads(&mut coalescing, &mut now, 2_000, &mut wave);
        assert!(reads(&mut coalescing, &mut now, 20_000, &mut wave) >= 19_990);
    }

    #[test]
    fn a_broker_that_waits_for_acknowledgements_is_left_alone_but_for_trials() {
        let mut now = Instant::now();
        let mut coalescing = PollCoalescing::new(now);
        let paused = reads(&mut coalescing, &mut now, 100_000, |is_paused| if is_paused { 20 } else { 50 });
        assert!((1_400..=2_100).contains(&paused), "{paused} in 100 s");
    }

    #[test]
    fn while_more_is_there_it_is_looked_at_once() {
        let mut now = Instant::now();
        let mut coalescing = PollCoalescing::new(now);
        assert_eq!(reads(&mut coalescing, &mut now, 2_000, |_| READ_MAX), 0);
    }
}
