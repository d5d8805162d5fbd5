//! Steps of air: a change of the pressure in the whisker moves the baseline.

use crate::intake::Bin;

/// Changes of the setpoint and of the pressure that count. MPa.
const SETPOINT_MPA: f64 = 0.000_5;
const PRESSURE_MPA: f64 = 0.003;
/// The baseline moves for so long after a change of the setpoint, and of the pressure. s.
const AFTER_S: (f64, f64) = (1.0, 0.6);

#[derive(Clone, Debug, Default)]
pub(crate) struct Air {
    setpoint_mpa: Option<f64>,
    pressure_mpa: Option<f64>,
    until_s: f64,
}

impl Air {
    /// Whether the air moves the baseline.
    pub(crate) fn push(&mut self, bin: &Bin) -> bool {
        let changed = |before: &mut Option<f64>, now: Option<f64>, least: f64| {
            let changed = before.zip(now).is_some_and(|(before, now)| (now - before).abs() > least);
            if now.is_some() && (changed || before.is_none()) {
                *before = now;
            }
            changed
        };
        if changed(&mut self.setpoint_mpa, bin.setpoint_mpa, SETPOINT_MPA) {
            self.until_s = bin.t_s + AFTER_S.0;
        }
        if changed(&mut self.pressure_mpa, bin.pressure_mpa, PRESSURE_MPA) {
            self.until_s = self.until_s.max(bin.t_s + AFTER_S.1);
        }
        bin.t_s < self.until_s
    }
}
