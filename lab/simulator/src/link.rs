//! Faults of a link that affect the first transmission of contacts messages; repeated transmissions always pass.

use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// A fault of the link with its duration.
#[derive(Debug, Clone, Copy, Default)]
struct Fault {
    fraction: f64,
    until_us: u64,
}

impl Fault {
    fn strikes(self, now_us: u64, draw: f64) -> bool {
        now_us < self.until_us && draw < self.fraction
    }
}

/// Kind of fault that an event sets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FaultKind {
    Lose,
    Repeat,
    Reorder,
}

/// The link of one robot.
#[derive(Debug)]
pub(crate) struct Link {
    lose: Fault,
    repeat: Fault,
    reorder: Fault,
    held_back: Option<Vec<u8>>,
    stream: ChaCha8Rng,
}

impl Link {
    pub(crate) fn new(stream: ChaCha8Rng) -> Self {
        let none = Fault::default();
        Self { lose: none, repeat: none, reorder: none, held_back: None, stream }
    }

    /// Sets a fault until a time.
    pub(crate) fn set(&mut self, kind: FaultKind, fraction: f64, until_us: u64) {
        let fault = Fault { fraction, until_us };
        match kind {
            FaultKind::Lose => self.lose = fault,
            FaultKind::Repeat => self.repeat = fault,
            FaultKind::Reorder => self.reorder = fault,
        }
    }

    /// Passes a message through the link: returns the messages that arrive, which may be none or more than one.
    pub(crate) fn pass(&mut self, payload: Vec<u8>, now_us: u64) -> Vec<Vec<u8>> {
        let draws: [f64; 3] = std::array::from_fn(|_| self.stream.random());
        let mut out = Vec::with_capacity(2);
        if self.lose.strikes(now_us, draws[0]) {
            return out;
        }
        if self.held_back.is_none() && self.reorder.strikes(now_us, draws[2]) {
            self.held_back = Some(payload);
            return out;
        }
        if self.repeat.strikes(now_us, draws[1]) {
            out.push(payload.clone());
        }
        out.push(payload);
        out.extend(self.held_back.take());
        out
    }

    /// Drops a message held back on the old connection.
    pub(crate) fn reconnected(&mut self) {
        self.held_back = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Purpose, stream};

    fn passed(kind: Option<FaultKind>, fraction: f64, until_us: u64) -> Vec<u8> {
        let mut link = Link::new(stream(3, "r", "", 0, Purpose::Link));
        if let Some(kind) = kind {
            link.set(kind, fraction, until_us);
        }
        (0..100).flat_map(|number| link.pass(vec![number], u64::from(number))).map(|payload| payload[0]).collect()
    }

    #[test]
    fn a_good_link_passes_everything_in_order() {
        assert_eq!(passed(None, 0.0, 0), (0..100).collect::<Vec<u8>>());
    }

    #[test]
    fn a_lossy_link_loses_its_fraction_while_it_lasts() {
        let passed = passed(Some(FaultKind::Lose), 0.5, 50);
        assert!((60..90).contains(&passed.len()), "{}", passed.len());
        assert!(passed.ends_with(&(50..100).collect::<Vec<u8>>()));
    }

    #[test]
    fn a_repeating_link_sends_twice() {
        assert_eq!(passed(Some(FaultKind::Repeat), 1.0, 50).len(), 150);
    }

    #[test]
    fn a_reordering_link_swaps_neighbours_and_loses_nothing() {
        let mut passed = passed(Some(FaultKind::Reorder), 1.0, 50);
        assert_eq!(passed[..4], [1, 0, 3, 2]);
        passed.sort_unstable();
        assert_eq!(passed, (0..100).collect::<Vec<u8>>());
    }
}
