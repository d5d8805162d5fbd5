//! Weighted least squares of bench readings, by Levenberg and Marquardt, with the scatter of each kind of reading.
//!
//! Strains without contact and elongations have a roughly constant *relative* error, so their logarithms are fitted:
//! on a linear scale the soft, high-pressure end, where setpoints are most sensitive to errors, would hardly count.
//! Readings of contacts are differences and may be zero. Their error is taken as proportional to the modelled number,
//! and to a twentieth of the largest reading of the kind.
//!
//! The scatter of a kind without stated standard deviations is estimated from its own residuals and the readings that
//! the fit leaves free (`n - tr H`). Stated standard deviations are taken as they are, or larger if the residuals are.

use nalgebra::{DMatrix, DVector};

use super::reading::{BenchReading, KINDS, Kind};
use super::unknowns::{Unknown, Values};
use crate::mechanics::model::Model;

/// Most steps of the fit.
const STEPS_MAX: usize = 200;
/// The fit ends with a step that changes no coordinate by this.
const STEP_MIN: f64 = 1e-10;
/// With more damping no step can reduce the sum of squares any more, except by rounding.
const DAMPING_MAX: f64 = 1e12;
/// Step of the numerical derivatives.
const DERIVATIVE_STEP: f64 = 1e-5;
/// Most rounds of fit and scatter.
const ROUNDS_MAX: usize = 15;
/// Least scatter, so that exact readings have a finite weight.
const SCATTER_MIN: f64 = 1e-9;
/// Scatter in the first round, as a ratio; that of a gauge at zero pressure is in m/m.
const FIRST_SCATTER: f64 = 0.02;
/// A contact's error: share of the largest reading of its kind.
const FLOOR_SHARE: f64 = 0.05;

/// Readings with one scatter: of one kind, with or without stated standard deviations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Group {
    pub(super) kind: Kind,
    pub(super) stated: bool,
}

/// A group with its scatter.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Scattered {
    pub(super) group: Group,
    pub(super) readings: usize,
    /// Factor on the unit of the group: a ratio, m/m at zero pressure, or 1 as stated.
    pub(super) scatter: f64,
    /// Readings that the fit leaves free; infinite if the standard deviations are taken as stated.
    pub(super) degrees: f64,
    /// J' W J of the free unknowns.
    pub(super) information: DMatrix<f64>,
}

/// Readings, and the unknowns to fit.
pub(super) struct Problem<'a> {
    pub(super) base: Model,
    pub(super) readings: &'a [BenchReading],
    pub(super) free: Vec<Unknown>,
    pub(super) assumed: Values,
}

/// A solved problem.
pub(super) struct Solved {
    pub(super) values: Values,
    pub(super) groups: Vec<Scattered>,
}

impl Problem<'_> {
    /// Fits, from the best of the starting points. `None` without convergence, or if no reading is free to show a scatter.
    pub(super) fn solve(&self, starts: &[Values]) -> Option<Solved> {
        let mut groups = self.groups();
        let first = |start: &Values| {
            let weights = self.weights(start, &groups);
            let values = self.minimise(*start, &weights)?;
            Some((values, self.cost(&values, &weights)))
        };
        let found = starts.iter().filter_map(first).min_by(|(_, a), (_, b)| a.total_cmp(b));
        let mut values = found?.0;
        for _ in 0..ROUNDS_MAX {
            let before: Vec<f64> = groups.iter().map(|group| group.scatter).collect();
            self.update(&values, &mut groups)?;
            values = self.minimise(values, &self.weights(&values, &groups))?;
            let settled = |(group, before): (&Scattered, f64)| (group.scatter / before).ln().abs() < 1e-4;
            if groups.iter().zip(before).all(settled) {
                break;
            }
        }
        self.update(&values, &mut groups)?;
        Some(Solved { values, groups })
    }

    pub(super) fn model(&self, values: &Values) -> Model {
        self.base.relative(values.calibration(), self.base.formulation())
    }

    /// Precision of the assumptions.
    pub(super) fn assumed_information(&self) -> DMatrix<f64> {
        DMatrix::from_diagonal(&DVector::from_iterator(
            self.free.len(),
            self.free.iter().map(|unknown| unknown.assumed_sd().powi(-2)),
        ))
    }

    /// Residual of a reading: of the logarithm, or of the number.
    pub(super) fn residual(&self, reading: &BenchReading, model: &Model, values: &Values) -> f64 {
        let modelled = reading.modelled(model, values.gauge());
        match reading.kind() {
            Some(Kind::Axial | Kind::Elongation) => (reading.value / modelled.max(f64::MIN_POSITIVE)).ln(),
            Some(Kind::Zero | Kind::ContactStrain | Kind::ContactForce) => reading.value - modelled,
            None => 0.0,
        }
    }

    fn groups(&self) -> Vec<Scattered> {
        let all = KINDS.into_iter().flat_map(|kind| [false, true].map(|stated| Group { kind, stated }));
        all.filter_map(|group| {
            let readings = self.readings.iter().filter(|reading| group_of(reading) == Some(group)).count();
            let scatter = if group.stated { 1.0 } else { FIRST_SCATTER };
            let information = DMatrix::zeros(self.free.len(), self.free.len());
            (readings > 0).then_some(Scattered { group, readings, scatter, degrees: f64::INFINITY, information })
        })
        .collect()
    }

    /// Standard deviation of each reading's residual before the group's scatter; `None` for a reading that does not count.
    fn units(&self, values: &Values) -> Vec<Option<(Group, f64)>> {
        let model = self.model(values);
        let largest = |kind: Kind| {
            let of_kind = self.readings.iter().filter(|reading| reading.kind() == Some(kind));
            of_kind.map(|reading| reading.value.abs()).fold(0.0, f64::max)
        };
        let floors = [Kind::ContactStrain, Kind::ContactForce].map(|kind| FLOOR_SHARE * largest(kind));
        let unit = |reading: &BenchReading| {
            let group = group_of(reading)?;
            let modelled = reading.modelled(&model, values.gauge());
            let stated = || (reading.sd.unwrap_or(0.0).powi(2) + reading.input_variance(&model, values.gauge())).sqrt();
            let unit = match (group.kind, group.stated) {
                (Kind::Axial | Kind::Elongation, true) => stated() / modelled.max(f64::MIN_POSITIVE),
                (Kind::Zero | Kind::ContactStrain | Kind::ContactForce, true) => stated(),
                (Kind::Zero | Kind::Axial | Kind::Elongation, false) => 1.0,
                (Kind::ContactStrain, false) => modelled.hypot(floors[0]),
                (Kind::ContactForce, false) => modelled.hypot(floors[1]),
            };
            Some((group, unit.max(f64::MIN_POSITIVE)))
        };
        self.readings.iter().map(unit).collect()
    }

    /// One over the standard deviation of each residual; 0 for a reading that does not count.
    fn weights(&self, values: &Values, groups: &[Scattered]) -> Vec<f64> {
        let weight = |unit: Option<(Group, f64)>| {
            let (group, unit) = unit?;
            let scatter = groups.iter().find(|one| one.group == group)?.scatter;
            Some(1.0 / (scatter * unit))
        };
        self.units(values).into_iter().map(|unit| weight(unit).unwrap_or(0.0)).collect()
    }

    /// New scatters, degrees of freedom and information of the groups. `None` if no reading is left free.
    fn update(&self, values: &Values, groups: &mut [Scattered]) -> Option<()> {
        let weights = self.weights(values, groups);
        let weighted = self.weighted_jacobian(values, &weights);
        let normal = weighted.transpose() * &weighted + self.assumed_information();
        let covariance = normal.try_inverse()?;
        let (model, units) = (self.model(values), self.units(values));
        let mut sums = vec![0.0; groups.len()];
        for (group, sum) in groups.iter_mut().zip(&mut sums) {
            let rows = (0..self.readings.len()).filter(|&row| units[row].is_some_and(|(of, _)| of == group.group));
            let (mut bound, mut information) = (0.0, DMatrix::zeros(self.free.len(), self.free.len()));
            for row in rows {
                let gradient = weighted.row(row).transpose();
                bound += (gradient.transpose() * &covariance * &gradient)[(0, 0)];
                information += &gradient * gradient.transpose();
                let unit = units[row].map_or(1.0, |(_, unit)| unit);
                *sum += (self.residual(&self.readings[row], &model, values) / unit).powi(2);
            }
            group.degrees = (group.readings as f64 - bound).max(0.0);
            group.information = information;
        }
        let relative = |group: &Scattered| !group.group.stated && group.group.kind != Kind::Zero;
        let (sum, degrees) = groups
            .iter()
            .zip(&sums)
            .filter(|(group, _)| relative(group))
            .fold((0.0, 0.0), |(sum, degrees), (group, of)| (sum + of, degrees + group.degrees));
        // Half a reading is rounding: as many readings as unknowns show no scatter.
        if degrees < 0.5 && groups.iter().any(relative) {
            return None;
        }
        for (group, sum_of) in groups.iter_mut().zip(sums) {
            // One reading's worth of the pooled scatter keeps a small group from a weight without limit.
            let pooled = if relative(group) { (sum / degrees, 1.0) } else { (0.0, 0.0) };
            let variance = (sum_of + pooled.0 * pooled.1) / (group.degrees + pooled.1).max(f64::MIN_POSITIVE);
            let scatter = variance.sqrt().max(SCATTER_MIN);
            let as_stated = group.group.stated && (scatter <= 1.0 || group.degrees < 0.5);
            group.information *= (group.scatter / if as_stated { 1.0 } else { scatter }).powi(2);
            group.scatter = if as_stated { 1.0 } else { scatter };
            group.degrees = if as_stated { f64::INFINITY } else { group.degrees.max(1.0) };
        }
        Some(())
    }

    /// Derivatives of the modelled logarithms or numbers, each row times its weight.
    pub(super) fn weighted_jacobian(&self, values: &Values, weights: &[f64]) -> DMatrix<f64> {
        let mut jacobian = DMatrix::zeros(self.readings.len(), self.free.len());
        for (column, unknown) in self.free.iter().enumerate() {
            let beside = |step: f64| {
                let mut moved = *values;
                moved.set(*unknown, values.of(*unknown) + step);
                (self.model(&moved), moved)
            };
            let (above, below) = (beside(DERIVATIVE_STEP), beside(-DERIVATIVE_STEP));
            for (row, (reading, weight)) in self.readings.iter().zip(weights).enumerate() {
                let difference =
                    self.residual(reading, &below.0, &below.1) - self.residual(reading, &above.0, &above.1);
                jacobian[(row, column)] = weight * difference / (2.0 * DERIVATIVE_STEP);
            }
        }
        jacobian
    }

    fn cost(&self, values: &Values, weights: &[f64]) -> f64 {
        let model = self.model(values);
        let readings = self.readings.iter().zip(weights);
        let of_readings: f64 =
            readings.map(|(reading, weight)| (weight * self.residual(reading, &model, values)).powi(2)).sum();
        let of_assumptions: f64 = self.free.iter().map(|unknown| self.assumed_residual(*unknown, values).powi(2)).sum();
        let cost = of_readings + of_assumptions;
        if cost.is_finite() && values.is_finite() { cost } else { f64::INFINITY }
    }

    fn assumed_residual(&self, unknown: Unknown, values: &Values) -> f64 {
        (self.assumed.of(unknown) - values.of(unknown)) / unknown.assumed_sd()
    }

    /// The least sum of squares at given weights. `None` without convergence.
    fn minimise(&self, start: Values, weights: &[f64]) -> Option<Values> {
        let (mut values, mut damping) = (start, 1e-3);
        let mut cost = self.cost(&values, weights);
        let assumed = self.assumed_information();
        for _ in 0..STEPS_MAX {
            let model = self.model(&values);
            let weighted = self.weighted_jacobian(&values, weights);
            let residuals = DVector::from_iterator(
                weights.len(),
                self.readings.iter().zip(weights).map(|(one, weight)| weight * self.residual(one, &model, &values)),
            );
            let pull = self.free.iter().map(|one| self.assumed_residual(*one, &values) / one.assumed_sd());
            let slope = weighted.transpose() * residuals + DVector::from_iterator(self.free.len(), pull);
            let normal = weighted.transpose() * &weighted + &assumed;
            loop {
                let damped = &normal + damping * DMatrix::from_diagonal(&normal.diagonal());
                let step = damped.cholesky()?.solve(&slope);
                let next = values.moved(&self.free, &step);
                let next_cost = self.cost(&next, weights);
                if next_cost <= cost {
                    (values, cost, damping) = (next, next_cost, damping / 10.0);
                    if step.amax() < STEP_MIN {
                        return Some(values);
                    }
                    break;
                }
                if damping > DAMPING_MAX {
                    return Some(values);
                }
                damping *= 10.0;
            }
        }
        None
    }
}

/// The group of a reading; `None` for a reading that does not count.
pub(super) fn group_of(reading: &BenchReading) -> Option<Group> {
    Some(Group { kind: reading.kind()?, stated: reading.has_sd() })
}
