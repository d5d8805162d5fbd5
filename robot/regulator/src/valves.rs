//! The outputs of the two valves: each closes at the end of its pulse, also if no command comes any more.

use crate::{Command, Way};

/// Longest pulse that a valve is ever given, whatever a command says. µs.
const PULSE_MOST_US: u32 = 1_000_000;

/// The two valves. Call [`Valves::outputs`] as often as the valves shall be exact, every millisecond for instance.
#[derive(Clone, Copy, Debug, Default)]
pub struct Valves {
    open: Option<(Way, u64)>,
}

impl Valves {
    /// Two closed valves.
    pub const fn new() -> Valves {
        Valves { open: None }
    }

    /// Begins or ends a pulse.
    pub fn apply(&mut self, now_us: u64, command: Command) {
        match command {
            Command::None => {}
            Command::Fill(us) => self.open = Some((Way::Fill, now_us.saturating_add(us.min(PULSE_MOST_US).into()))),
            Command::Vent(us) => self.open = Some((Way::Vent, now_us.saturating_add(us.min(PULSE_MOST_US).into()))),
            Command::Close => self.open = None,
        }
    }

    /// Whether the fill valve and the vent valve are open now; never both.
    pub fn outputs(&mut self, now_us: u64) -> (bool, bool) {
        match self.open {
            Some((way, until_us)) if now_us < until_us => (way == Way::Fill, way == Way::Vent),
            Some(_) | None => {
                self.open = None;
                (false, false)
            }
        }
    }
}
