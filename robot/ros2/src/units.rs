//! Pressures: ROS uses pascals, the agent megapascals above the atmosphere.

/// Readings beyond this are no chamber pressures, MPa.
const GAUGE_MAX_MPA: f64 = 1.0;
/// Lowest gauge pressure: a vacuum is below any whisker's use, MPa.
const GAUGE_MIN_MPA: f64 = -0.05;

/// Meaning of `fluid_pressure`, in readings and setpoints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pressures {
    /// Absolute pressure, as `sensor_msgs/FluidPressure` defines it; the atmosphere's pressure in Pa.
    Absolute(f64),
    /// Pressure above the atmosphere.
    Gauge,
}

impl Pressures {
    fn offset_pa(self) -> f64 {
        match self {
            Self::Absolute(atmosphere_pa) => atmosphere_pa,
            Self::Gauge => 0.0,
        }
    }

    /// The gauge pressure of a reading in Pa, in MPa.
    ///
    /// # Errors
    /// The reading cannot be the pressure of a chamber.
    pub fn gauge_mpa(self, reading_pa: f64) -> Result<f64, String> {
        let gauge_mpa = (reading_pa - self.offset_pa()) * 1e-6;
        if gauge_mpa.is_finite() && (GAUGE_MIN_MPA..=GAUGE_MAX_MPA).contains(&gauge_mpa) {
            return Ok(gauge_mpa);
        }
        let meaning = match self {
            Self::Absolute(_) => "absolute: is it gauge pressure? Then start with --pressures gauge",
            Self::Gauge => "gauge: is its unit Pa?",
        };
        Err(format!("a pressure of {reading_pa} Pa, {meaning}"))
    }

    /// A gauge pressure in MPa as a ROS pressure, Pa.
    #[must_use]
    pub fn pa(self, gauge_mpa: f64) -> f64 {
        gauge_mpa * 1e6 + self.offset_pa()
    }
}
