//! The condition of a chamber in the status: regulator, gauge and segmenter.

use vibrissa_protocol::{Gauge, Regulator, Segmenter, SetpointError, WhiskerStatus};
use vibrissa_segmenter::Condition as Heard;

use super::Chamber;
use crate::contract::Now;

/// Least excess of the supply over the target, in MPa.
const SUPPLY_MARGIN_MPA: f64 = 0.005;

impl Chamber {
    /// Condition of regulator and gauge.
    pub(in crate::agent) fn condition(&self, now: Now) -> (Regulator, Gauge) {
        let is_known = self.reading_ends_at().is_some_and(|end| now.at < end);
        let Some(reading) = self.reading.filter(|_| is_known) else {
            return (Regulator::Fault, self.gauge());
        };
        let regulator = self.regulator.unwrap_or_else(|| {
            let below_mpa = self.target_mpa - reading.pressure_mpa;
            let is_low = self.supply_mpa.is_some_and(|supply_mpa| supply_mpa < self.target_mpa + SUPPLY_MARGIN_MPA);
            if below_mpa > self.limits.tolerance_mpa {
                if is_low { Regulator::SupplyLow } else { Regulator::Filling }
            } else if below_mpa < -self.limits.tolerance_mpa {
                Regulator::Venting
            } else {
                Regulator::Ok
            }
        });
        (regulator, self.gauge())
    }

    /// Condition of the gauge as the driver states it, or else as its strains show it.
    fn gauge(&self) -> Gauge {
        if self.gauge == Gauge::Ok && self.gauge_watch.is_clipped() { Gauge::Saturated } else { self.gauge }
    }

    /// Reason why the setpoint was not reached in time.
    pub(in crate::agent) fn failure(&self, now: Now) -> SetpointError {
        match self.condition(now).0 {
            Regulator::SupplyLow => SetpointError::SupplyLow,
            Regulator::Leak => SetpointError::Leak,
            Regulator::Ok | Regulator::Filling | Regulator::Venting | Regulator::Fault => SetpointError::Fault,
        }
    }

    pub(in crate::agent) fn status(&self, now: Now) -> WhiskerStatus {
        let (regulator, gauge) = self.condition(now);
        WhiskerStatus {
            array: self.array.clone(),
            whisker: self.number,
            // Without a reading the condition is FAULT, so that nobody takes the pressure for a measured one.
            pressure_mpa: self.reading.map_or(self.target_mpa, |reading| reading.pressure_mpa),
            setpoint_mpa: self.target_mpa,
            regulator,
            gauge,
            segmenter: self.segmenter(),
        }
    }

    /// How far contacts from samples can be relied on; `None` if no driver sends samples.
    pub(in crate::agent) fn segmenter(&self) -> Option<Segmenter> {
        Some(match self.stream.as_ref()?.condition() {
            Heard::Learning(_) => Segmenter::Learning,
            Heard::Lost => Segmenter::Lost,
            Heard::Ready if self.gauge_watch.is_reversed() => Segmenter::Inverted,
            Heard::Clipped => Segmenter::Clipped,
            Heard::Noisy => Segmenter::Noisy,
            Heard::Ready => Segmenter::Ready,
        })
    }
}
