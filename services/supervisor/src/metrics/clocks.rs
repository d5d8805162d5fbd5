//! How other clocks stand to this supervisor's.

use prometheus::{GaugeVec, Opts, Registry, Result};

use super::kinds::Word;

/// The clocks that are compared with this supervisor's.
pub(super) const CLOCKS: [Word; 4] = ["host", "database", "robots", "supervisors"];

/// How far other clocks are ahead of this supervisor's, s.
#[derive(Debug, Clone)]
pub struct ClockMetrics {
    ahead: GaugeVec,
}

impl ClockMetrics {
    pub(super) fn declare(registry: &Registry) -> Result<Self> {
        let ahead = GaugeVec::new(
            Opts::new(
                "vibrissa_clock_ahead_seconds",
                "How far another clock is ahead of this supervisor's; absent while it is not known.",
            ),
            &["clock"],
        )?;
        registry.register(Box::new(ahead.clone()))?;
        Ok(Self { ahead })
    }

    /// Shows how far each clock is ahead, in µs, if it is known.
    pub fn show(&self, clocks: impl IntoIterator<Item = (Word, Option<i64>)>) {
        for (clock, ahead_us) in clocks {
            match ahead_us {
                Some(ahead_us) => self.ahead.with_label_values(&[clock]).set(ahead_us as f64 / 1e6),
                None => drop(self.ahead.remove_label_values(&[clock])),
            }
        }
    }
}
