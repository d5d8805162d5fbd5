//! A measured response as a smooth curve over the contact ratio.
//!
//! A whisker's deviation from its model is nearly a straight line over the contact ratio: for rubbers within ten
//! per cent the bend is at most 0.5 %. A parabola through all bins, with a weak prior on its curvature, therefore
//! needs only some hundred contacts for the precision that single bins reach after thousands.

use borsh::{BorshDeserialize, BorshSerialize};
use nalgebra::{Cholesky, Matrix3, SMatrix, Vector3};

use super::bins::ResponseBins;
use super::uncertainty::Curve;
use crate::mechanics::{CONTACT_RATIOS, Offset};

/// Prior standard deviations: level, slope per unit of contact ratio, curvature per unit squared.
const PRIOR: [f64; 3] = [0.3, 0.6, 0.1];
/// Deviation of known responses from a parabola in log sensitivity; it is below the resolution.
const NO_FIT: f64 = 1e-4;

/// ln(measured / model's sensitivity) over the contact ratio, with its covariance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Smooth {
    coefficients: Vector3<f64>,
    /// Lower triangular Cholesky factor R of the covariance R R^T.
    root: Matrix3<f64>,
}

/// Prior of a response before its first contact: mean and covariance of the parabola.
#[derive(Debug, Clone, Copy, PartialEq, BorshSerialize, BorshDeserialize)]
pub struct Carried {
    mean: [f64; 3],
    covariance: [[f64; 3]; 3],
}

/// Minimum uncertainty added by a change of pressure, as standard deviations of level and slope: nonlinear effects
/// and the pressure sensor's error.
const CARRIED_SD: [f64; 2] = [0.002, 0.003];

impl Default for Carried {
    /// Prior of any whisker.
    fn default() -> Self {
        let covariance = Matrix3::from_diagonal(&Vector3::from(PRIOR.map(|sd| sd.powi(2))));
        Self { mean: [0.0; 3], covariance: covariance.into() }
    }
}

impl Carried {
    /// Brings the belief to another scale, by this much log sensitivity.
    pub fn shift(&mut self, log_shift: f64) {
        self.mean[0] += log_shift;
    }
}

/// Least-squares parabola through a curve.
fn parabola(curve: &Curve) -> Vector3<f64> {
    let rows = SMatrix::<f64, 12, 3>::from_fn(|k, i| terms(CONTACT_RATIOS[k])[i]);
    let normal = rows.transpose() * rows;
    let weighed = rows.transpose() * SMatrix::<f64, 12, 1>::from(*curve);
    Cholesky::new(normal).map_or_else(Vector3::zeros, |factor| factor.solve(&weighed))
}

/// 1, a and a^2 about the centre of the contact ratios.
pub(super) fn terms(a: f64) -> [f64; 3] {
    let off = a - Offset::CENTRE;
    [1.0, off, off * off]
}

impl Smooth {
    /// Fits the bins of a response, each weighted by the inverse of its variance.
    #[must_use]
    pub fn through(bins: &ResponseBins) -> Self {
        Self::from(&Carried::default(), bins)
    }

    /// Fits the bins of a response together with a prior.
    #[must_use]
    pub fn from(carried: &Carried, bins: &ResponseBins) -> Self {
        let mut information = Matrix3::from(carried.covariance).try_inverse().unwrap_or_else(Matrix3::zeros);
        let mut weighed = information * Vector3::from(carried.mean);
        for bin in bins.felt() {
            let row = Vector3::from(terms(bin.mean_ratio()));
            let weight = 1.0 / (bin.variance() + NO_FIT.powi(2));
            information += row * row.transpose() * weight;
            weighed += row * bin.mean() * weight;
        }
        // The prior keeps the information matrix positive definite, so the factor exists.
        let solved = Cholesky::new(information).map(|factor| (factor.solve(&weighed), factor.inverse()));
        let (coefficients, covariance) = solved.unwrap_or((Vector3::zeros(), Matrix3::zeros()));
        let root = Cholesky::new(covariance).map_or_else(Matrix3::zeros, |factor| factor.l());
        Self { coefficients, root }
    }

    /// The response after `change`, with the uncertainty of that change given by `causes`.
    #[must_use]
    pub fn carried(&self, change: &Curve, causes: &[Curve]) -> Carried {
        let mut covariance = self.root * self.root.transpose();
        for cause in causes.iter().map(parabola) {
            covariance += cause * cause.transpose();
        }
        covariance[(0, 0)] += CARRIED_SD[0].powi(2);
        covariance[(1, 1)] += CARRIED_SD[1].powi(2);
        Carried { mean: (self.coefficients + parabola(change)).into(), covariance: covariance.into() }
    }

    /// Slope at the centre of the contact ratios, and its variance.
    #[must_use]
    pub fn slope(&self) -> (f64, f64) {
        (self.coefficients[1], self.root.row(1).norm_squared())
    }

    /// Values at [`CONTACT_RATIOS`].
    #[must_use]
    pub fn by_ratio(&self) -> [f64; CONTACT_RATIOS.len()] {
        CONTACT_RATIOS.map(|a| Vector3::from(terms(a)).dot(&self.coefficients))
    }

    /// Effects of one standard deviation of three independent variables, at [`CONTACT_RATIOS`].
    #[must_use]
    pub fn causes(&self) -> [[f64; CONTACT_RATIOS.len()]; 3] {
        std::array::from_fn(|j| CONTACT_RATIOS.map(|a| Vector3::from(terms(a)).dot(&self.root.column(j))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::ContactRatio;

    #[test]
    fn a_parabola_comes_back_and_the_spread_falls_with_the_contacts() {
        let truth = |a: f64| 0.05 - 0.2 * (a - 0.725) + 0.06 * (a - 0.725).powi(2);
        let felt = |contacts: u32| {
            let mut bins = ResponseBins::default();
            for k in 0..contacts {
                let a = 0.45 + 0.55 * f64::from(k) / f64::from(contacts - 1);
                bins.add(ContactRatio::known(a), truth(a), 0.035_f64.powi(2), 0.0);
            }
            Smooth::through(&bins)
        };
        let (some, many) = (felt(200), felt(20_000));
        for (k, a) in CONTACT_RATIOS.into_iter().enumerate() {
            assert!((many.by_ratio()[k] - truth(a)).abs() < 5e-4, "{a}: {:?}", many.by_ratio());
        }
        let spread = |smooth: &Smooth| smooth.causes().iter().map(|cause| cause[6].powi(2)).sum::<f64>().sqrt();
        let expected = 0.035 / 200_f64.sqrt();
        assert!(spread(&some) > expected && spread(&some) < 2.0 * expected, "{}", spread(&some));
        assert!(spread(&many) < 0.12 * spread(&some));
    }

    #[test]
    fn what_is_carried_is_kept_until_contacts_say_otherwise() {
        let mut bins = ResponseBins::default();
        for k in 0..6000 {
            bins.add(ContactRatio::known(0.45 + 0.55 * f64::from(k) / 5999.0), 0.1, 0.035_f64.powi(2), 0.0);
        }
        let change = CONTACT_RATIOS.map(|a| 0.03 * (a - 0.725));
        let carried = Smooth::through(&bins).carried(&change, &[[0.001; CONTACT_RATIOS.len()]]);
        let there = Smooth::from(&carried, &ResponseBins::default());
        for (k, change) in change.into_iter().enumerate() {
            assert!((there.by_ratio()[k] - 0.1 - change).abs() < 1e-3, "{:?}", there.by_ratio());
        }
        let spread: f64 = there.causes().iter().map(|cause| cause[5].powi(2)).sum::<f64>().sqrt();
        assert!(spread > 0.002 && spread < 0.003, "{spread}");
        let mut others = ResponseBins::default();
        for k in 0..6000 {
            others.add(ContactRatio::known(0.45 + 0.55 * f64::from(k) / 5999.0), 0.15, 0.035_f64.powi(2), 0.0);
        }
        let moved = Smooth::from(&carried, &others).by_ratio()[5];
        assert!(moved > 0.145 && moved < 0.15, "{moved}");
    }

    #[test]
    fn without_a_contact_it_is_the_model_and_uncertain() {
        let nothing = Smooth::through(&ResponseBins::default());
        assert_eq!(nothing.by_ratio(), [0.0; CONTACT_RATIOS.len()]);
        assert!((nothing.causes()[0][5] - PRIOR[0]).abs() < 0.01);
    }
}
