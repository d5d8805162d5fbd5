//! Starting points of a fit.

use nalgebra::{Matrix2, Vector2};

use super::least_squares::Problem;
use super::reading::{BenchReading, Kind};
use super::unknowns::{Unknown, Values};

/// Factors on the assumed modulus that a fit of E starts from.
const MODULUS_FACTORS: [f64; 5] = [0.25, 0.5, 1.0, 2.0, 4.0];

/// A measured E2.
#[derive(Debug, Clone, Copy)]
struct Point {
    pressure_mpa: f64,
    e2_mpa: f64,
}

impl Problem<'_> {
    /// The starting points. `None` if no curve k2(Q) falls toward a limit through the strains without contact.
    pub(super) fn starts(&self, from: Values) -> Option<Vec<Values>> {
        let zeros: Vec<f64> = self.of_kind(Kind::Zero).map(|reading| reading.value).collect();
        let offset = zeros.iter().fold(0.0, |sum, zero| sum + zero) / zeros.len().max(1) as f64;
        let points: Vec<Point> = self.of_kind(Kind::Axial).filter_map(|reading| self.point(reading, offset)).collect();
        let curve = if points.len() < 3 { None } else { first_guess(&points) };
        let others = self.readings.iter().any(|reading| reading.contact().is_some());
        if curve.is_none() && !others {
            return None;
        }
        let modulus = from.of(Unknown::Modulus);
        let factors: &[f64] = if self.free.contains(&Unknown::Modulus) { &MODULUS_FACTORS } else { &[1.0] };
        let starts = factors.iter().map(|factor| {
            let mut start = from;
            start.set(Unknown::GaugeOffset, Values::coordinate(Unknown::GaugeOffset, offset));
            start.set(Unknown::Modulus, modulus + factor.ln());
            if let Some((c_mpa, a_mpa, b_per_mpa)) = curve {
                let log_modulus = start.of(Unknown::Modulus);
                start.set(Unknown::C, c_mpa.ln() - log_modulus);
                start.set(Unknown::A, a_mpa.ln() - log_modulus);
                start.set(Unknown::B, b_per_mpa.ln());
            }
            start
        });
        Some(starts.collect())
    }

    fn of_kind(&self, kind: Kind) -> impl Iterator<Item = &BenchReading> {
        self.readings.iter().filter(move |reading| reading.kind() == Some(kind))
    }

    fn point(&self, reading: &BenchReading, offset: f64) -> Option<Point> {
        let (pressure_mpa, strain) = (reading.pressure.mpa(), reading.value - offset);
        (strain > 0.0).then(|| Point { pressure_mpa, e2_mpa: self.base.axial_gain * pressure_mpa / strain })
    }
}

/// E2 = c + a exp(-b Q) in MPa: for a fixed b the curve is linear in c and a, so the best b of a wide grid is taken, with
/// relative errors weighted equally.
fn first_guess(points: &[Point]) -> Option<(f64, f64, f64)> {
    let highest_mpa = points.iter().map(|point| point.pressure_mpa).fold(0.0, f64::max);
    (0..40)
        .map(|k| 0.1 * 1.2_f64.powi(k) / highest_mpa)
        .filter_map(|b_per_mpa| {
            let (mut normal, mut right) = (Matrix2::zeros(), Vector2::zeros());
            for point in points {
                let row = Vector2::new(1.0, (-b_per_mpa * point.pressure_mpa).exp()) / point.e2_mpa;
                normal += row * row.transpose();
                right += row;
            }
            let solution = normal.try_inverse()? * right;
            let (c, a) = (solution.x, solution.y);
            let e2_mpa = |pressure_mpa: f64| c + a * (-b_per_mpa * pressure_mpa).exp();
            let sum: f64 = points.iter().map(|point| (e2_mpa(point.pressure_mpa) / point.e2_mpa).ln().powi(2)).sum();
            (c > 0.0 && a > 0.0 && sum.is_finite()).then_some(((c, a, b_per_mpa), sum))
        })
        .min_by(|(_, a), (_, b)| a.total_cmp(b))
        .map(|(curve, _)| curve)
}
