//! Fits the curve k2(Q) to measured points, by least squares of the logarithms.

use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::storage::Owned;
use nalgebra::{Dyn, Matrix2, Matrix3, OMatrix, OVector, U3, Vector2, Vector3};

use super::FitError;
use super::readings::Point;

/// Least fall of k2, as a share of its limit.
const LEAST_FALL: f64 = 1e-3;

/// k2(Q) = c + a exp(-b Q).
#[derive(Debug, Clone, Copy)]
pub(super) struct Curve {
    pub(super) c: f64,
    pub(super) a: f64,
    pub(super) b_per_mpa: f64,
}

impl Curve {
    fn from_logs(logs: &Vector3<f64>) -> Self {
        Self { c: logs.x.exp(), a: logs.y.exp(), b_per_mpa: logs.z.exp() }
    }

    fn logs(&self) -> Vector3<f64> {
        Vector3::new(self.c.ln(), self.a.ln(), self.b_per_mpa.ln())
    }

    pub(super) fn k2(&self, pressure_mpa: f64) -> f64 {
        self.c + self.a * (-self.b_per_mpa * pressure_mpa).exp()
    }

    /// ln k2 measured - fitted.
    pub(super) fn residual(&self, point: &Point) -> f64 {
        point.log_k2 - self.k2(point.pressure_mpa).ln()
    }

    /// d ln k2 / d (ln c, ln a, ln b).
    pub(super) fn log_gradient(&self, pressure_mpa: f64) -> Vector3<f64> {
        let falling = self.a * (-self.b_per_mpa * pressure_mpa).exp();
        Vector3::new(self.c, falling, -falling * self.b_per_mpa * pressure_mpa) / (self.c + falling)
    }
}

/// Fits the curve; the covariance is for a residual standard deviation of 1.
pub(super) fn fit_curve(points: &[Point]) -> Result<(Curve, Matrix3<f64>), FitError> {
    let start = first_guess(points).ok_or(FitError::NotDetermined { parameter: "a" })?;
    let (problem, report) =
        LevenbergMarquardt::new().with_patience(200).minimize(Problem { points, logs: start.logs() });
    let curve = Curve::from_logs(&problem.logs);
    let undetermined = FitError::NotDetermined { parameter: "b" };
    if !report.termination.was_successful() {
        return Err(undetermined);
    }
    let lowest_mpa = points.iter().map(|point| point.pressure_mpa).fold(f64::INFINITY, f64::min);
    if curve.k2(lowest_mpa) < (1.0 + LEAST_FALL) * curve.c {
        return Err(FitError::NotDetermined { parameter: "a" });
    }
    let jacobian = problem.jacobian_matrix();
    let covariance = (jacobian.transpose() * jacobian).try_inverse().ok_or(undetermined)?;
    if problem.logs.iter().chain(covariance.iter()).all(|value| value.is_finite()) {
        Ok((curve, covariance))
    } else {
        Err(undetermined)
    }
}

/// Starting point: for a fixed b the curve is linear in c and a, so the best b of a wide grid is taken, with
/// relative errors weighted equally.
fn first_guess(points: &[Point]) -> Option<Curve> {
    let highest_mpa = points.iter().map(|point| point.pressure_mpa).fold(0.0, f64::max);
    (0..40)
        .map(|k| 0.1 * 1.2_f64.powi(k) / highest_mpa)
        .filter_map(|b_per_mpa| {
            let (mut normal, mut right) = (Matrix2::zeros(), Vector2::zeros());
            for point in points {
                let row = Vector2::new(1.0, (-b_per_mpa * point.pressure_mpa).exp()) / point.log_k2.exp();
                normal += row * row.transpose();
                right += row;
            }
            let solution = normal.try_inverse()? * right;
            let curve = Curve { c: solution.x, a: solution.y, b_per_mpa };
            let sum: f64 = points.iter().map(|point| (curve.k2(point.pressure_mpa).ln() - point.log_k2).powi(2)).sum();
            (curve.c > 0.0 && curve.a > 0.0 && sum.is_finite()).then_some((curve, sum))
        })
        .min_by(|(_, a), (_, b)| a.total_cmp(b))
        .map(|(curve, _)| curve)
}

struct Problem<'a> {
    points: &'a [Point],
    logs: Vector3<f64>,
}

impl Problem<'_> {
    fn jacobian_matrix(&self) -> OMatrix<f64, Dyn, U3> {
        let curve = Curve::from_logs(&self.logs);
        OMatrix::<f64, Dyn, U3>::from_fn(self.points.len(), |i, j| curve.log_gradient(self.points[i].pressure_mpa)[j])
    }
}

impl LeastSquaresProblem<f64, Dyn, U3> for Problem<'_> {
    type ParameterStorage = Owned<f64, U3>;
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, U3>;

    fn set_params(&mut self, logs: &Vector3<f64>) {
        self.logs = *logs;
    }

    fn params(&self) -> Vector3<f64> {
        self.logs
    }

    fn residuals(&self) -> Option<OVector<f64, Dyn>> {
        let curve = Curve::from_logs(&self.logs);
        let residuals = self.points.iter().map(|point| curve.k2(point.pressure_mpa).ln() - point.log_k2);
        Some(OVector::<f64, Dyn>::from_iterator(self.points.len(), residuals))
    }

    fn jacobian(&self) -> Option<OMatrix<f64, Dyn, U3>> {
        Some(self.jacobian_matrix())
    }
}
