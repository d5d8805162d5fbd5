//! Fits the curve k2(Q) to measured points, by least squares of the logarithms.

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

use super::FitError;

/// Least fall of k2, as a share of its limit.
const LEAST_FALL: f64 = 1e-3;
/// Most steps of the fit.
const STEPS_MAX: usize = 1000;
/// The fit ends with a step that changes no parameter by this share.
const STEP_MIN: f64 = 1e-10;
/// With more damping no step can reduce the sum of squares any more, except by rounding.
const DAMPING_MAX: f64 = 1e12;

/// A measured k2.
#[derive(Debug, Clone, Copy)]
pub(super) struct Point {
    pub(super) pressure_mpa: f64,
    pub(super) log_k2: f64,
}

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
    let undetermined = FitError::NotDetermined { parameter: "b" };
    let logs = minimise(points, start.logs()).ok_or(undetermined)?;
    let curve = Curve::from_logs(&logs);
    let lowest_mpa = points.iter().map(|point| point.pressure_mpa).fold(f64::INFINITY, f64::min);
    if curve.k2(lowest_mpa) < (1.0 + LEAST_FALL) * curve.c {
        return Err(FitError::NotDetermined { parameter: "a" });
    }
    let covariance = normal_equations(points, &curve).0.try_inverse().ok_or(undetermined)?;
    if logs.iter().chain(covariance.iter()).all(|value| value.is_finite()) {
        Ok((curve, covariance))
    } else {
        Err(undetermined)
    }
}

/// Least squares by Levenberg and Marquardt, from a starting point. `None` without convergence.
fn minimise(points: &[Point], start: Vector3<f64>) -> Option<Vector3<f64>> {
    let sum_of = |curve: &Curve| points.iter().map(|point| curve.residual(point).powi(2)).sum::<f64>();
    let (mut logs, mut damping) = (start, 1e-3);
    for _ in 0..STEPS_MAX {
        let curve = Curve::from_logs(&logs);
        let (normal, slope) = normal_equations(points, &curve);
        let damped = normal + damping * Matrix3::from_diagonal(&normal.diagonal());
        let step = damped.cholesky()?.solve(&slope);
        let next = logs + step;
        if sum_of(&Curve::from_logs(&next)) <= sum_of(&curve) {
            (logs, damping) = (next, damping / 10.0);
            if step.amax() < STEP_MIN {
                return Some(logs);
            }
        } else if damping < DAMPING_MAX {
            damping *= 10.0;
        } else {
            return Some(logs);
        }
    }
    None
}

/// J' J and J' r, with the Jacobian J and the residuals r of the logarithms.
fn normal_equations(points: &[Point], curve: &Curve) -> (Matrix3<f64>, Vector3<f64>) {
    points.iter().fold((Matrix3::zeros(), Vector3::zeros()), |(normal, slope), point| {
        let gradient = curve.log_gradient(point.pressure_mpa);
        (normal + gradient * gradient.transpose(), slope + gradient * curve.residual(point))
    })
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
