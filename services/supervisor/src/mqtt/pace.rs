//! How often to look at the network in a burst.
//!
//! A broker writes each message by itself. Whoever looks at once finds one or two, and pays a wake-up, a read and the
//! write of an acknowledgement for them: several times what the messages themselves cost. So while many come, the
//! receiving thread sleeps for half a millisecond between two looks. That must not slow a burst down: a broker that lets few
//! messages be without acknowledgement waits for each look, and is left alone again.

use std::time::{Duration, Instant};

/// The pause between two looks.
pub(super) const PAUSE: Duration = Duration::from_micros(500);
/// Messages that one look brings at the most; after so many there are more, and it is looked again at once.
pub(super) const LOOK_MAX: usize = 128;
/// How long messages are counted for their rate.
const WINDOW: Duration = Duration::from_millis(10);
/// From this rate on it is paused, in messages a second; below half of it no longer.
const BUSY_PER_S: f64 = 8_000.0;
/// Pauses are given up when less than this part of the rate is left.
const LEFT_MIN: f64 = 0.85;
/// Until it is tried again.
const CALM: Duration = Duration::from_secs(1);

/// Decides on the pauses of one connection.
#[derive(Debug)]
pub(super) struct Pace {
    since: Instant,
    messages: u32,
    state: State,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum State {
    /// Without pauses, until there are many messages, but not before that time.
    Prompt(Instant),
    /// With pauses; so many messages a second came without.
    Paced(f64),
}

impl Pace {
    pub(super) fn new(now: Instant) -> Self {
        Self { since: now, messages: 0, state: State::Prompt(now) }
    }

    /// Whether to pause before the next look, after one that has brought so many messages.
    pub(super) fn pauses(&mut self, now: Instant, messages: usize) -> bool {
        self.messages = self.messages.saturating_add(u32::try_from(messages).unwrap_or(u32::MAX));
        let elapsed = now.saturating_duration_since(self.since);
        if elapsed >= WINDOW {
            let per_s = f64::from(self.messages) / elapsed.as_secs_f64();
            self.state = self.state.after(per_s, now);
            (self.since, self.messages) = (now, 0);
        }
        messages < LOOK_MAX && matches!(self.state, State::Paced(_))
    }
}

impl State {
    fn after(self, per_s: f64, now: Instant) -> Self {
        match self {
            Self::Prompt(not_before) if per_s >= BUSY_PER_S && now >= not_before => Self::Paced(per_s),
            Self::Prompt(_) => self,
            Self::Paced(_) if per_s < BUSY_PER_S / 2.0 => Self::Prompt(now),
            Self::Paced(without) if per_s < LEFT_MIN * without => Self::Prompt(now + CALM),
            Self::Paced(_) => self,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Looks once a millisecond, for so many; gives how many pauses there were.
    fn looks(pace: &mut Pace, now: &mut Instant, count: usize, messages: usize) -> usize {
        let look = |_: &usize| {
            *now += Duration::from_millis(1);
            pace.pauses(*now, messages)
        };
        (0..count).filter(look).count()
    }

    #[test]
    fn pauses_begin_with_a_burst_and_end_with_it() {
        let mut now = Instant::now();
        let mut pace = Pace::new(now);
        assert_eq!(looks(&mut pace, &mut now, 1_000, 7), 0, "7,000 a second");
        assert!(looks(&mut pace, &mut now, 100, 50) >= 90);
        assert!(looks(&mut pace, &mut now, 100, 1) <= 10);
        assert!(looks(&mut pace, &mut now, 100, 50) >= 90, "the next burst at once");
    }

    #[test]
    fn a_broker_that_waits_for_acknowledgements_is_left_alone_for_a_second() {
        let mut now = Instant::now();
        let mut pace = Pace::new(now);
        let pauses = looks(&mut pace, &mut now, 20, 50);
        assert!((1..=11).contains(&pauses));
        // Slower now.
        assert!(looks(&mut pace, &mut now, 20, 20) <= 11);
        assert_eq!(looks(&mut pace, &mut now, 900, 50), 0);
        assert!(looks(&mut pace, &mut now, 1_100, 50) > 900);
    }

    #[test]
    fn while_more_is_there_it_is_looked_at_once() {
        let mut now = Instant::now();
        let mut pace = Pace::new(now);
        assert_eq!(looks(&mut pace, &mut now, 100, LOOK_MAX), 0);
    }
}
