//! A whisker's own calibration, estimated from its responses at several pressures.
//!
//! While a compensation holds a pressure, the compensator's response is measured there. Its deviations from the
//! model at that and at nominal pressure show how k2 and the elongation of *this* chamber differ from the built-in
//! values, and so predict its response at a new pressure.
//!
//! Linear and Gaussian: the deviation from the model over contact ratio a and pressure Q is
//! `o(a) + sum_i w_i (g_i(a, Q) - g_i(a, Q_nominal))`. `o` is a parabola (gauge, gluing and all other effects that
//! do not depend on pressure); `g_i` is the change of ln s for one step of the i-th parameter ([`Family`]). The
//! weights w have the prior "uniform within 10 %, either formulation". Each visit of a trimmed whisker adds one
//! unknown, its length error. The posterior is one solution of the normal equations, so it depends only on the
//! measurements and not on their order; it is also bounded.

use borsh::{BorshDeserialize, BorshSerialize};
use nalgebra::{Cholesky, DMatrix, DVector, SMatrix};

use super::bins::ResponseBins;
use super::smooth::{Smooth, terms};
use crate::mechanics::{CONTACT_RATIOS, FAMILY, Family, LOG_MODULUS, LogChanges, Model, OTHER_FORMULATION};
use crate::units::{Megapascal, Millimetre};

/// Number of stored visits.
const VISITS_MAX: usize = 8;
/// Prior standard deviations of the parabola: level, slope, curvature.
const OFFSET_PRIOR: [f64; 3] = [0.3, 0.6, 0.1];
/// Model error of the linear approximation, log sensitivity in one bin (standard deviation).
const NO_FIT: f64 = 0.004;
/// Bound of the calibration weights: 30 % off the built-in values.
const WEIGHT_MAX: f64 = 0.3 / crate::mechanics::FAMILY_STEP;
/// Prior standard deviations of an offset's slope over the contact ratio: by another rubber, and by all else, which is the
/// spread of one rubber, the formulation, a glued gauge and the robot's contact ratios.
const SLOPE_BY_RUBBER: f64 = 0.3;
const SLOPE_BY_REST: f64 = 0.08;
/// Standard deviation of the rubber's log modulus as a share of it, once contacts have told it.
const MODULUS_SHARE: f64 = 0.2;
/// Least standard deviation of the log modulus.
const LEAST_MODULUS_SD: f64 = 1e-3;
/// Bounds of the formulation weight.
const FORMULATION_MIN_MAX: (f64, f64) = (-0.5, 1.5);

/// Weights of a [`Family`]: number of steps by which a whisker's own calibration differs from the model's.
pub type Weights = [f64; FAMILY];

/// A whisker's responses at the pressures at which it has served as compensator.
#[derive(Debug, Clone, PartialEq, Default, BorshSerialize, BorshDeserialize)]
pub struct OwnCalibration {
    visits: Vec<Visit>,
}

/// The response measured at one pressure.
#[derive(Debug, Clone, PartialEq, BorshSerialize, BorshDeserialize)]
pub struct Visit {
    /// Number of the compensation in which it was measured.
    pub compensation: u32,
    /// The pressure during the visit.
    pub pressure: Megapascal,
    /// Length of the reference model.
    pub length: Millimetre,
    /// Standard deviation of the length, mm.
    pub length_sd_mm: f64,
    /// The response relative to the model at that length.
    pub bins: ResponseBins,
}

/// The whole whisker at nominal pressure: the reference for visits.
#[derive(Debug, Clone, Copy)]
pub struct Nominal<'a> {
    /// Length of the whole whisker.
    pub length: Millimetre,
    /// Nominal pressure of the whisker.
    pub pressure: Megapascal,
    /// The response relative to the model at that length and pressure.
    pub bins: &'a ResponseBins,
}

/// Posterior of a whisker's own calibration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Belief {
    /// Mean of the weights.
    pub mean: Weights,
    /// Lower triangular Cholesky factor R of their covariance R R^T, row by row.
    pub root: [Weights; FAMILY],
    /// Weights for predictions: the mean if there is a visit at another pressure, otherwise zero (the model
    /// unchanged). Equally likely formulations are no reason to predict with half of each.
    pub predict: Weights,
}

impl OwnCalibration {
    /// Stores a visit. It replaces one of the same compensation and pressure, or else the oldest if there are too
    /// many.
    pub fn remember(&mut self, visit: Visit) {
        let same = |one: &Visit| one.compensation == visit.compensation && one.pressure == visit.pressure;
        match self.visits.iter_mut().find(|one| same(one)) {
            Some(known) => *known = visit,
            None => {
                if self.visits.len() == VISITS_MAX {
                    self.visits.remove(0);
                }
                self.visits.push(visit);
            }
        }
    }

    /// Posterior from all stored visits.
    #[must_use]
    pub fn belief(&self, model: &Model, nominal: &Nominal<'_>) -> Belief {
        let modulus = nominal.log_modulus(model);
        if self.visits.is_empty() {
            return Belief::prior(modulus);
        }
        let family = model.family(modulus.0);
        let count = 3 + FAMILY + self.visits.len();
        let mut equations = Equations::new(count);
        equations.prior(&self.visits, modulus);
        for bin in nominal.bins.felt() {
            let mut row = DVector::zeros(count);
            row.as_mut_slice()[..3].copy_from_slice(&terms(bin.mean_ratio()));
            equations.observe(&row, bin.mean(), bin.variance() + NO_FIT.powi(2));
        }
        let at_nominal = family.log_changes(model, nominal.length, nominal.pressure);
        for (at, visit) in self.visits.iter().enumerate() {
            equations.visit(model, &family, (&at_nominal, nominal.length), visit, at);
        }
        equations.belief(modulus)
    }

    /// Whether the whisker was measured at another than its nominal pressure.
    #[must_use]
    pub fn is_informed(&self) -> bool {
        !self.visits.is_empty()
    }
}

impl Nominal<'_> {
    /// Mean and standard deviation of the log modulus of its rubber over the model's, by the slope of its response over the
    /// contact ratio. While no contact tells it, the model's modulus counts as right.
    fn log_modulus(&self, model: &Model) -> (f64, f64) {
        let (slope, variance) = Smooth::through(self.bins).slope();
        // Either the calibration's own rubber, or another one: small slopes tell hardly of another rubber, large ones do.
        let (same, other) = (SLOPE_BY_REST.powi(2) + variance, SLOPE_BY_RUBBER.powi(2) + variance);
        let density = |variance: f64| (-0.5 * slope * slope / variance).exp() / variance.sqrt();
        let is_other = density(other) / (density(same) + density(other));
        let told = SLOPE_BY_RUBBER.powi(2) / other;
        let (mean, per_log) = model.log_modulus(is_other * told * slope, self.length, self.pressure);
        if per_log == 0.0 {
            return (0.0, LEAST_MODULUS_SD);
        }
        let between = (is_other * (1.0 - is_other)).sqrt() * told * slope / per_log;
        let by_noise = is_other * told * variance.sqrt() / per_log;
        (mean, (MODULUS_SHARE * mean).hypot(between).hypot(by_noise).max(LEAST_MODULUS_SD))
    }
}

impl Belief {
    /// Prior without any visit: uniform within 10 %, either formulation, and this log modulus with its standard deviation.
    #[must_use]
    pub fn prior(modulus: (f64, f64)) -> Self {
        let mut root = [[0.0; FAMILY]; FAMILY];
        for (i, row) in root.iter_mut().enumerate() {
            row[i] = prior_of(i, modulus).1;
        }
        let mut predict = [0.0; FAMILY];
        predict[LOG_MODULUS] = modulus.0;
        Self { mean: std::array::from_fn(|i| prior_of(i, modulus).0), root, predict }
    }

    /// Change of the deviation from the model between two pressures, at [`CONTACT_RATIOS`].
    #[must_use]
    pub fn change(weights: &Weights, from: &LogChanges, to: &LogChanges) -> [f64; CONTACT_RATIOS.len()] {
        std::array::from_fn(|k| Self::change_at(weights, &from[k], &to[k]))
    }

    /// Change of the deviation from the model between two pressures, at one contact ratio.
    #[must_use]
    pub fn change_at(weights: &Weights, from: &[f64; FAMILY], to: &[f64; FAMILY]) -> f64 {
        (0..FAMILY).map(|i| weights[i] * (to[i] - from[i])).sum()
    }

    /// Changes caused by one standard deviation of each independent variable behind the covariance, at
    /// [`CONTACT_RATIOS`].
    #[must_use]
    pub fn causes(&self, from: &LogChanges, to: &LogChanges) -> [[f64; CONTACT_RATIOS.len()]; FAMILY] {
        std::array::from_fn(|j| Self::change(&std::array::from_fn(|i| self.root[i][j]), from, to))
    }
}

/// Prior mean and standard deviation of a calibration step, of the formulation (0 or 1), or of the log modulus.
fn prior_of(index: usize, modulus: (f64, f64)) -> (f64, f64) {
    match index {
        OTHER_FORMULATION => (0.5, 0.5),
        LOG_MODULUS => modulus,
        _ => (0.0, 1.0),
    }
}

/// Normal equations for the parabola, the weights and the visits' errors in log length.
struct Equations {
    information: DMatrix<f64>,
    weighed: DVector<f64>,
}

impl Equations {
    fn new(count: usize) -> Self {
        Self { information: DMatrix::zeros(count, count), weighed: DVector::zeros(count) }
    }

    fn observe(&mut self, row: &DVector<f64>, value: f64, variance: f64) {
        self.information += row * row.transpose() / variance;
        self.weighed += row * (value / variance);
    }

    fn prior(&mut self, visits: &[Visit], modulus: (f64, f64)) {
        let offsets = OFFSET_PRIOR.map(|sd| (0.0, sd)).into_iter();
        let weights = (0..FAMILY).map(|i| prior_of(i, modulus));
        let lengths = visits.iter().map(|visit| (0.0, (visit.length_sd_mm / visit.length.mm()).max(1e-5)));
        for (i, (mean, sd)) in offsets.chain(weights).chain(lengths).enumerate() {
            self.information[(i, i)] += sd.powi(-2);
            self.weighed[i] += mean / sd.powi(2);
        }
        // One compensation has one length: its visits share the error.
        for (later, visit) in visits.iter().enumerate() {
            if let Some(first) = visits[..later].iter().position(|one| one.compensation == visit.compensation) {
                let mut row = DVector::zeros(self.weighed.len());
                (row[3 + FAMILY + first], row[3 + FAMILY + later]) = (1.0, -1.0);
                self.observe(&row, 0.0, 1e-10);
            }
        }
    }

    fn visit(
        &mut self,
        model: &Model,
        family: &Family,
        (at_nominal, whole): (&LogChanges, Millimetre),
        visit: &Visit,
        at: usize,
    ) {
        let there = family.log_changes(model, visit.length, visit.pressure);
        let morphology = model.morphology(visit.pressure);
        for bin in visit.bins.felt() {
            let a = bin.mean_ratio();
            let Ok(ratio) = crate::units::ContactRatio::new(a) else { continue };
            let Ok((_, slope)) = model.sensitivity_and_slope(ratio, visit.length, &morphology) else { continue };
            let (k, share) = between(a);
            let mut row = DVector::zeros(self.weighed.len());
            // A cut does not change what lies before the contact.
            row.as_mut_slice()[..3].copy_from_slice(&terms(a * visit.length.mm() / whole.mm()));
            for i in 0..FAMILY {
                let change = |k: usize| there[k][i] - at_nominal[k][i];
                row[3 + i] = change(k) + share * (change(k + 1) - change(k));
            }
            row[3 + FAMILY + at] = slope;
            self.observe(&row, bin.mean(), bin.variance() + NO_FIT.powi(2));
        }
    }

    fn belief(self, modulus: (f64, f64)) -> Belief {
        // The prior keeps the information matrix positive definite; rounding is the only way to fail.
        let Some(factor) = Cholesky::new(self.information) else { return Belief::prior(modulus) };
        let solved = factor.solve(&self.weighed);
        let covariance = factor.inverse();
        let own = SMatrix::<f64, FAMILY, FAMILY>::from_fn(|i, j| covariance[(3 + i, 3 + j)]);
        let Some(root) = Cholesky::new(own) else { return Belief::prior(modulus) };
        let root = root.l();
        let mean = std::array::from_fn(|i| {
            let (low, high) = if i == OTHER_FORMULATION { FORMULATION_MIN_MAX } else { (-WEIGHT_MAX, WEIGHT_MAX) };
            if i == LOG_MODULUS { solved[3 + i] } else { solved[3 + i].clamp(low, high) }
        });
        Belief { mean, root: std::array::from_fn(|i| std::array::from_fn(|j| root[(i, j)])), predict: mean }
    }
}

/// Index of the lower neighbour in [`CONTACT_RATIOS`], and the position between the neighbours, 0 to 1 inside the
/// table.
fn between(a: f64) -> (usize, f64) {
    let steps = (a - CONTACT_RATIOS[0]) / super::bins::WIDTH;
    let k = (steps.max(0.0) as usize).min(CONTACT_RATIOS.len() - 2);
    (k, steps - k as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanics::{Calibration, Formulation, Geometry};
    use crate::units::ContactRatio;

    const NOMINAL: f64 = 0.1;

    fn plant(factors: [f64; 4], formulation: Formulation) -> Model {
        let built_in = Calibration::nguyen_2021();
        let calibration = Calibration {
            c: factors[0] * built_in.c,
            a: factors[1] * built_in.a,
            b_per_mpa: factors[2] * built_in.b_per_mpa,
            elongation_gain_mm: factors[3] * built_in.elongation_gain_mm,
            ..built_in
        };
        Model::new(Geometry::nguyen_2021(), calibration, formulation).unwrap()
    }

    /// Noise-free contacts of the plant relative to the model, with a nominal noise variance.
    fn felt(plant: &Model, model: &Model, length: f64, pressure: f64) -> ResponseBins {
        let (length, pressure) = (Millimetre::known(length), Megapascal::known(pressure));
        let mut bins = ResponseBins::default();
        for k in 0..1200 {
            let ratio = ContactRatio::known(0.45 + 0.55 * f64::from(k) / 1199.0);
            let log = |m: &Model| m.sensitivity_per_mm(ratio, length, &m.morphology(pressure)).unwrap().ln();
            bins.add(ratio, log(plant) - log(model), 0.035_f64.powi(2), 0.0);
        }
        bins
    }

    fn visit(plant: &Model, model: &Model, pressure: f64) -> Visit {
        Visit {
            compensation: 1,
            pressure: Megapascal::known(pressure),
            length: Millimetre::known(65.0),
            length_sd_mm: 0.1,
            bins: felt(plant, model, 65.0, pressure),
        }
    }

    #[test]
    fn property_a_response_at_one_more_pressure_predicts_those_where_it_never_was() {
        let model = Model::nguyen_2021(Formulation::Published);
        let plants = [
            ([1.1, 0.9, 1.1, 1.1], Formulation::Consistent),
            ([0.9, 1.1, 0.9, 0.9], Formulation::Published),
            ([0.95, 0.92, 1.08, 1.0], Formulation::Consistent),
        ];
        for (factors, formulation) in plants {
            let plant = plant(factors, formulation);
            let whole = felt(&plant, &model, 65.0, NOMINAL);
            let nominal =
                Nominal { length: Millimetre::known(65.0), pressure: Megapascal::known(NOMINAL), bins: &whole };
            let off_by = |own: &OwnCalibration, pressure: f64| {
                let belief = own.belief(&model, &nominal);
                let changes = |q: f64| {
                    model.family(belief.predict[LOG_MODULUS]).log_changes(&model, nominal.length, Megapascal::known(q))
                };
                let change = Belief::change(&belief.predict, &changes(NOMINAL), &changes(pressure));
                let log = |m: &Model, q: f64| m.log_sensitivities(nominal.length, Megapascal::known(q));
                let deviation = |q: f64, k: usize| log(&plant, q)[k].unwrap() - log(&model, q)[k].unwrap();
                (0..12).map(|k| (change[k] - deviation(pressure, k) + deviation(NOMINAL, k)).abs()).sum::<f64>() / 12.0
            };
            let mut own = OwnCalibration::default();
            let before = off_by(&own, 0.03);
            own.remember(visit(&plant, &model, 0.05));
            let after = off_by(&own, 0.03);
            assert!(after < 0.4 * before && after < 0.006, "{factors:?} {formulation:?}: {before} {after}");
        }
    }

    /// Without any visit: the slope of the response at nominal pressure tells the rubber.
    #[test]
    fn property_the_response_of_another_rubber_is_predicted_at_another_pressure() {
        let model = Model::nguyen_2021(Formulation::Published);
        let built_in = Calibration::nguyen_2021();
        for factor in [0.5, 0.7, 1.5, 2.2] {
            let calibration = Calibration {
                c: built_in.c / factor,
                a: built_in.a / factor,
                youngs_modulus_mpa: built_in.youngs_modulus_mpa * factor,
                ..built_in
            };
            let plant = Model::new(Geometry::nguyen_2021(), calibration, Formulation::Published).unwrap();
            let length = Millimetre::known(65.0);
            let whole = felt(&plant, &model, 65.0, NOMINAL);
            let nominal = Nominal { length, pressure: Megapascal::known(NOMINAL), bins: &whole };
            let belief = OwnCalibration::default().belief(&model, &nominal);
            let family = model.family(belief.predict[LOG_MODULUS]);
            let changes = |mpa: f64| family.log_changes(&model, length, Megapascal::known(mpa));
            let change = Belief::change(&belief.predict, &changes(NOMINAL), &changes(0.03));
            let log = |one: &Model, mpa: f64| one.log_sensitivities(length, Megapascal::known(mpa)).map(Option::unwrap);
            let deviation = |mpa: f64, k: usize| log(&plant, mpa)[k] - log(&model, mpa)[k];
            let truth: [f64; CONTACT_RATIOS.len()] =
                std::array::from_fn(|k| deviation(0.03, k) - deviation(NOMINAL, k));
            let (before, after) = (0..change.len())
                .fold((0.0, 0.0), |(before, after), k| (before + truth[k].abs(), after + (change[k] - truth[k]).abs()));
            assert!(after < 0.3 * before, "{factor}: {before} {after}");
        }
    }

    #[test]
    fn nonsense_is_bounded_and_the_oldest_visit_gives_way() {
        let model = Model::nguyen_2021(Formulation::Published);
        let whole = felt(&model, &model, 65.0, NOMINAL);
        let nominal = Nominal { length: Millimetre::known(65.0), pressure: Megapascal::known(NOMINAL), bins: &whole };
        let mut own = OwnCalibration::default();
        for k in 0..20 {
            let mut one = visit(&model, &model, 0.02 + 0.004 * f64::from(k));
            for _ in 0..100 {
                one.bins.add(ContactRatio::TIP, 3.0, 1e-4, 0.0);
            }
            own.remember(one.clone());
            own.remember(one);
        }
        assert_eq!(own.visits.len(), VISITS_MAX);
        let belief = own.belief(&model, &nominal);
        assert!(belief.mean.iter().all(|weight| weight.abs() <= WEIGHT_MAX), "{:?}", belief.mean);
        assert_eq!(OwnCalibration::default().belief(&model, &nominal), Belief::prior(nominal.log_modulus(&model)));
    }
}
