//! The place of a touch, from its strain and deflection and the response that the supervisor has told.
//!
//! The strain per mm of deflection falls from the chamber to the tip. Its logarithm is interpolated between the points
//! of the response.

/// Standard deviations of a 95 % interval.
const SD_95: f64 = 1.96;
/// A strain this many standard deviations beyond an end of the response is no touch of this part of the whisker.
const BEYOND_SD: f64 = 4.0;

/// Response of a whisker at a pressure: points along it, by rising distance and falling strain.
#[derive(Debug, Clone, PartialEq)]
pub struct Response {
    /// Gauge pressure of the chamber, in MPa.
    pub pressure_mpa: f64,
    points: Vec<Point>,
}

/// A point of a response.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Point {
    distance_mm: f64,
    /// Logarithm of the strain per mm, and its standard deviation.
    log: f64,
    sd: f64,
}

/// Place of a touch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Most likely distance from the base, without the chamber's elongation, in mm.
    pub distance_mm: f64,
    /// 95 % interval of the distance, in mm. It ends at the chamber and at the tip.
    pub interval_mm: (f64, f64),
}

/// Reason for which a touch has no place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum NoPlace {
    /// The deflection is no deflection.
    #[error("the deflection must be above 0 and at most 1000 mm")]
    Deflection,
    /// The strain is not positive.
    #[error("the strain of a touch must be positive: subtract its value at rest, and check the sign of the gauge")]
    Negative,
    /// Even a touch beside the chamber would give less strain.
    #[error("the strain is larger than that of a touch beside the chamber: the touch was on the chamber")]
    OnChamber,
    /// Even a touch of the tip would give more strain.
    #[error("the strain is smaller than that of a touch at the tip: check the deflection")]
    BeyondTip,
}

impl Response {
    /// The response in an estimate: distance in mm, strain per mm and its standard deviation. `None` for fewer than two
    /// points, which tell no place.
    #[must_use]
    pub fn new(pressure_mpa: f64, points: &[(f64, f64, f64)]) -> Option<Self> {
        let point = |&(distance_mm, per_mm, sd_per_mm): &(f64, f64, f64)| Point {
            distance_mm,
            log: per_mm.ln(),
            sd: sd_per_mm / per_mm,
        };
        (points.len() > 1).then(|| Self { pressure_mpa, points: points.iter().map(point).collect() })
    }

    /// Place of a touch with this strain, as measured and without its value at rest, and this deflection in mm.
    ///
    /// # Errors
    /// [`NoPlace`]: no place on the whisker explains the strain.
    pub fn place(&self, strain: f64, deflection_mm: f64) -> Result<Place, NoPlace> {
        if !(deflection_mm > 0.0 && deflection_mm <= 1000.0) {
            return Err(NoPlace::Deflection);
        }
        if !(strain > 0.0 && strain.is_finite()) {
            return Err(NoPlace::Negative);
        }
        let log = (strain / deflection_mm).ln();
        let found = self.at(log);
        let (nearest, farthest) = (self.points[0], self.points[self.points.len() - 1]);
        if log > nearest.log + BEYOND_SD * nearest.sd {
            return Err(NoPlace::OnChamber);
        }
        if log < farthest.log - BEYOND_SD * farthest.sd {
            return Err(NoPlace::BeyondTip);
        }
        // A strain that is larger by an error comes from farther out than it seems.
        let of = |error: f64| self.at(log + error).distance_mm;
        let interval_mm = (of(SD_95 * found.sd), of(-SD_95 * found.sd));
        Ok(Place { distance_mm: found.distance_mm, interval_mm })
    }

    /// The point with this logarithm; an end of the response beyond it.
    fn at(&self, log: f64) -> Point {
        let after = self.points.partition_point(|point| point.log >= log).clamp(1, self.points.len() - 1);
        let (near, far) = (self.points[after - 1], self.points[after]);
        let share = ((near.log - log) / (near.log - far.log)).clamp(0.0, 1.0);
        let between = |near: f64, far: f64| near + share * (far - near);
        Point { distance_mm: between(near.distance_mm, far.distance_mm), log, sd: between(near.sd, far.sd) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn response() -> Response {
        let points = [(20.0, 0.01, 0.0004), (40.0, 0.007, 0.00028), (60.0, 0.005, 0.0002)];
        Response::new(0.1, &points).unwrap()
    }

    #[test]
    fn a_touch_is_where_its_strain_per_mm_is_on_the_response() {
        let at = |per_mm: f64| response().place(per_mm * 2.5, 2.5).unwrap().distance_mm;
        for (per_mm, distance_mm) in [(0.01, 20.0), (0.007, 40.0), (0.005, 60.0), ((0.007_f64 * 0.005).sqrt(), 50.0)] {
            assert!((at(per_mm) - distance_mm).abs() < 1e-9, "{per_mm}: {}", at(per_mm));
        }
        // A little beyond an end, the touch was there.
        assert_eq!((at(0.0105), at(0.0048)), (20.0, 60.0));
    }

    #[test]
    fn the_interval_has_the_error_of_the_strain_and_ends_with_the_whisker() {
        let place = response().place(0.014, 2.0).unwrap();
        // 1.96 times 4 % of the strain, by 20 mm for ln(0.01 / 0.007) and ln(0.007 / 0.005).
        let (low_mm, high_mm) = (40.0 - 20.0 * 0.0784 / 0.356_67, 40.0 + 20.0 * 0.0784 / 0.336_47);
        assert!(
            (place.interval_mm.0 - low_mm).abs() < 0.01 && (place.interval_mm.1 - high_mm).abs() < 0.01,
            "{place:?}"
        );
        assert_eq!(response().place(0.010_2, 2.0).unwrap().interval_mm.1, 60.0);
    }

    #[test]
    fn a_touch_that_no_place_explains_says_why() {
        let refused = |strain: f64, deflection_mm: f64| response().place(strain, deflection_mm).unwrap_err();
        assert_eq!(refused(0.03, 2.0), NoPlace::OnChamber);
        assert_eq!(refused(0.007, 2.0), NoPlace::BeyondTip);
        for strain in [0.0, -0.01, f64::NAN, f64::INFINITY] {
            assert_eq!(refused(strain, 2.0), NoPlace::Negative);
        }
        for deflection_mm in [0.0, -1.0, f64::NAN, 1000.1] {
            assert_eq!(refused(0.01, deflection_mm), NoPlace::Deflection);
        }
        assert_eq!(Response::new(0.1, &[(20.0, 0.01, 0.0004)]), None);
    }
}
