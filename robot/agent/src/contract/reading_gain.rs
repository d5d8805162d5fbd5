//! The factor on a whisker's readings. It belongs to a pressure.

/// Pressures closer than this are the same, in MPa.
const SAME_MPA: f64 = 1e-4;

/// Factor on the readings of a whisker, with the pressure that it belongs to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReadingGain {
    factor: f64,
    pressure_mpa: f64,
    /// Whether a setpoint was applied in this boot. Then the robot knows its factor better than any estimate.
    is_of_setpoint: bool,
}

impl ReadingGain {
    /// At the start of a boot, in which the robot holds this pressure by itself.
    #[must_use]
    pub const fn new(pressure_mpa: f64) -> Self {
        Self { factor: 1.0, pressure_mpa, is_of_setpoint: false }
    }

    /// The factor in force.
    #[must_use]
    pub const fn factor(&self) -> f64 {
        self.factor
    }

    /// The robot reports a setpoint as APPLIED, with its pressure and its `reading_gain`.
    pub fn applied(&mut self, pressure_mpa: f64, reading_gain: Option<f64>) {
        *self = Self { factor: reading_gain.unwrap_or(1.0), pressure_mpa, is_of_setpoint: true };
    }

    /// The robot begins to give the chamber a pressure without a setpoint.
    pub fn left(&mut self, pressure_mpa: f64) {
        if !is_same(self.pressure_mpa, pressure_mpa) {
            (self.factor, self.pressure_mpa) = (1.0, pressure_mpa);
        }
    }

    /// The robot takes an estimate with this pressure and this `reading_gain`.
    pub fn estimated(&mut self, pressure_mpa: f64, reading_gain: Option<f64>) {
        if !self.is_of_setpoint {
            let known = reading_gain.filter(|_| is_same(self.pressure_mpa, pressure_mpa));
            self.factor = known.unwrap_or(1.0);
        }
    }
}

fn is_same(one_mpa: f64, other_mpa: f64) -> bool {
    (one_mpa - other_mpa).abs() <= SAME_MPA
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_factor_is_that_of_the_setpoint_applied_last_until_the_robot_leaves_its_pressure() {
        let mut gain = ReadingGain::new(0.1);
        assert_eq!(gain.factor(), 1.0);
        gain.applied(0.082, Some(0.887));
        assert_eq!(gain.factor(), 0.887);
        // An estimate that was on its way is older.
        gain.estimated(0.082, Some(0.9));
        assert_eq!(gain.factor(), 0.887);
        gain.left(0.082);
        assert_eq!(gain.factor(), 0.887, "the same pressure");
        gain.left(0.0);
        assert_eq!(gain.factor(), 1.0);
        gain.estimated(0.0, Some(0.9));
        assert_eq!(gain.factor(), 1.0, "only a setpoint brings it back");
        gain.applied(0.082, Some(0.887));
        gain.applied(0.1, None);
        assert_eq!(gain.factor(), 1.0, "absent is 1");
    }

    #[test]
    fn in_a_new_boot_an_estimate_counts_only_for_the_pressure_that_the_robot_holds() {
        let mut gain = ReadingGain::new(0.1);
        gain.estimated(0.082, Some(0.887));
        assert_eq!(gain.factor(), 1.0);
        gain.estimated(0.100_004, Some(1.7));
        assert_eq!(gain.factor(), 1.7);
        gain.estimated(0.1, None);
        assert_eq!(gain.factor(), 1.0);
        gain.estimated(0.1, Some(1.7));
        gain.left(0.0);
        assert_eq!(gain.factor(), 1.0);
    }
}
