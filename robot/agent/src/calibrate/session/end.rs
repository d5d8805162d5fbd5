//! The end of a session: empty chambers and closed valves, whatever has happened.

use std::time::Duration;

use tokio::time::{Instant, timeout_at};

use super::{Air, End, Heard, PULSE_MAX_MS, Session};
use crate::driver::link::Link;
use crate::driver::{Opening, ToDriver};

/// Longest time for all chambers to be empty at the end, and the pressure that counts as empty.
const VENT: Duration = Duration::from_secs(15);
const EMPTY_MPA: f64 = 0.003;

impl Session<'_> {
    /// Empties all chambers, closes all valves, and ends the links; whether all chambers are known to be empty.
    pub(in crate::calibrate) async fn close(mut self) -> bool {
        let until = Instant::now() + VENT;
        let (mut is_empty, mut pulse_at) = (false, Instant::now());
        (self.present, self.air) = (None, Air::Held(0.0));
        self.newest.clear();
        self.repeat().await;
        while !is_empty && Instant::now() < until && self.ends.iter().any(|end| end.is_there) {
            if Instant::now() >= pulse_at {
                // Only drivers without a regulator need pulses: for others `set_pressure` is enough.
                self.tell_valves(Opening::Vent, PULSE_MAX_MS, true).await;
                pulse_at = Instant::now() + Duration::from_millis(500);
            }
            if let Ok(Some(heard)) = timeout_at(pulse_at, self.heard.recv()).await {
                match heard {
                    Heard::Line(end, line) => self.take(end, &line).await,
                    Heard::Gone(end) => self.ends[end].is_there = false,
                }
            }
            if Instant::now() >= self.repeat_at {
                self.repeat().await;
            }
            let zero_mpa = |place| self.zeros.get(place).copied().unwrap_or(0.0);
            let is_at_zero = |place| self.newest.get(place).is_some_and(|mpa| *mpa - zero_mpa(place) <= EMPTY_MPA);
            is_empty = self.whiskers.keys().all(is_at_zero);
        }
        self.tell_valves(Opening::Close, 0.0, false).await;
        for End { writer, child, .. } in self.ends {
            Link { reader: Box::new(tokio::io::empty()), writer, child }.close().await;
        }
        is_empty
    }

    async fn tell_valves(&mut self, open: Opening, for_ms: f64, only_without_regulator: bool) {
        for end in 0..self.ends.len() {
            if only_without_regulator && !self.ends[end].config.limits.regulate {
                continue;
            }
            for (array, whisker) in self.ends[end].config.whiskers.clone() {
                self.tell(end, &ToDriver::Valve { array, whisker, open, for_ms }).await;
            }
        }
    }
}
