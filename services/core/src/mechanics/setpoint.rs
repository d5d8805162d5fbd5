//! Solves for the pressure that gives one whisker the sensitivity of another (eq. 34), and predicts the error.

use borsh::{BorshDeserialize, BorshSerialize};

use super::length::CutIntoChamber;
use super::model::Model;
use super::profile::{self, ByRatio, CONTACT_RATIOS, ErrorProfile, GainProfile, Offset, UsualContacts, weighted_mean};
use super::root;
use crate::units::{ContactRatio, Megapascal, Millimetre};

/// Tolerance of a solved pressure, in MPa.
const PRESSURE_TOLERANCE_MPA: f64 = 1e-12;
/// Log sensitivities this close count as equal, so that rounding at the ends of the range decides nothing.
const EQUAL_LOG: f64 = 1e-12;
/// Number of grid cells in the search for the least mean error.
const MEAN_CELLS: u32 = 16;
/// Tolerance of the pressure of the least mean error, in MPa.
const MEAN_TOLERANCE_MPA: f64 = 1e-7;
/// Tolerance of the pressure of the best shape, in MPa.
const SHAPE_TOLERANCE_MPA: f64 = 1e-9;

/// Quantity that a setpoint is solved for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, BorshSerialize, BorshDeserialize)]
pub enum Objective {
    /// Equal sensitivity at the tip, a = 1: the paper's eq. 34.
    #[default]
    Tip,
    /// Least mean of eq. 35 over [`CONTACT_RATIOS`]. Better by the model's prediction, but more dependent on the
    /// model.
    Mean,
    /// A response that is the target's times one number: air corrects the shape over the contact ratio, and a gain on
    /// the readings corrects the level. Only for robots that multiply their readings.
    Shape,
}

/// The whisker whose sensitivity the compensator shall have.
#[derive(Debug, Clone, Copy, PartialEq, BorshSerialize, BorshDeserialize)]
pub struct Target {
    /// La: length at zero pressure.
    pub length: Millimetre,
    /// Pressure of the target.
    pub pressure: Megapascal,
}

/// The compensator before the compensation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Compensator {
    /// La: length at zero pressure.
    pub length: Millimetre,
    /// Pressure before the compensation: the `before` of eq. 35.
    pub pressure: Megapascal,
    /// Lowest permitted pressure.
    pub pressure_min: Megapascal,
    /// Highest permitted pressure; raised to `pressure_min` if it is below.
    pub pressure_max: Megapascal,
}

/// A pressure with its predicted results.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setpoint {
    /// The pressure to apply.
    pub pressure: Megapascal,
    /// k2 at that pressure; the paper reports both.
    pub k2: f64,
    /// Predicted error of the reading by eq. 35: that of the pressure with [`Self::reading_gain`] applied.
    pub error: ErrorProfile,
    /// Predicted mean error of the pressure alone by eq. 35, as a ratio.
    pub air_error: f64,
    /// Factor on each reading, above 0; 1 unless the objective is [`Objective::Shape`].
    pub reading_gain: f64,
    /// Predicted residual gain; [`Self::reading_gain`] at each contact ratio with [`Objective::Shape`].
    pub gain: GainProfile,
}

/// Whether the objective can be met within the pressure range. A result out of range is not a failure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Solution {
    /// The objective is met.
    InRange(Setpoint),
    /// Needs less than `pressure_min`, to which the setpoint is clamped: the compensator stays too sensitive.
    NeedsBelow(Setpoint),
    /// Needs more than `pressure_max`, to which the setpoint is clamped (or to the peak of the tip's sensitivity):
    /// the compensator stays too insensitive.
    NeedsAbove(Setpoint),
}

impl Solution {
    /// The setpoint, clamped or not.
    #[must_use]
    pub fn setpoint(&self) -> &Setpoint {
        match self {
            Self::InRange(setpoint) | Self::NeedsBelow(setpoint) | Self::NeedsAbove(setpoint) => setpoint,
        }
    }
}

/// Solves for the compensator's pressure.
///
/// [`Objective::Tip`] finds Q with `ln s_c(1, La_c, Q) + o_c(1) = ln s_t(1, La_t, Q_t) + o_t(1)`; without offsets,
/// that is eq. 34 at a = 1 and a deflection of 1 mm. The sensitivity rises with the pressure, so there is at most
/// one root; it is solved to 1e-12 MPa. (The tip of a short whisker, for nguyen-2021 below 52 mm, has a peak within
/// the range: then only the pressures up to the peak are searched.)
///
/// [`Objective::Mean`] minimises the mean of eq. 35 on a grid of sixteenths of the range, then by golden section to
/// 1e-7 MPa, a ten-thousandth of a regulator's resolution. Each term falls to its zero and rises again; so does the
/// mean, except for small ripples between the zeros. Contact ratios that lie on the chamber at the highest pressure
/// are excluded. A minimum at an end of the range counts as out of range. If there is nothing to compensate at any
/// contact ratio, the tip decides.
///
/// [`Objective::Shape`] minimises the variance of ln(s_target / s_compensator) over the contact ratios, all with one
/// weight, on the same grid, then by golden section to 1e-9 MPa. The gain is e to the mean of that logarithm. The
/// variance is the square of a difference in shape that changes steadily with the pressure, so it has one valley.
/// Without a choice of pressure (`pressure_max` is at most `pressure_min`) the gain alone remains.
///
/// # Errors
/// One of the two whiskers is cut into its chamber.
pub fn solve_setpoint(
    target_model: &Model,
    target: Target,
    target_offset: Offset,
    compensator_model: &Model,
    compensator: Compensator,
    compensator_offset: Offset,
    objective: Objective,
) -> Result<Solution, CutIntoChamber> {
    let straight = |offset: Offset| move |_: Megapascal| CONTACT_RATIOS.map(|a| offset.at(ContactRatio::known(a)));
    solve_setpoint_as_felt(
        (target_model, target, &straight(target_offset)),
        (compensator_model, compensator, &straight(compensator_offset)),
        objective,
        &UsualContacts::UNKNOWN,
    )
}

/// Deviation of a real whisker from its model: ln s minus the model's.
pub trait Deviation {
    /// Deviation at a pressure, for [`CONTACT_RATIOS`].
    fn at(&self, pressure: Megapascal) -> [f64; CONTACT_RATIOS.len()];

    /// Deviation at a pressure, at the tip only (the last of [`CONTACT_RATIOS`]). The root search needs it at many
    /// pressures.
    fn at_tip(&self, pressure: Megapascal) -> f64 {
        self.at(pressure)[TIP]
    }
}

impl<F: Fn(Megapascal) -> [f64; CONTACT_RATIOS.len()]> Deviation for F {
    fn at(&self, pressure: Megapascal) -> [f64; CONTACT_RATIOS.len()] {
        self(pressure)
    }
}

/// [`solve_setpoint`] for whiskers whose deviation from the model depends on the pressure. The usual contacts apply to
/// [`Objective::Shape`]: their weights to the mean, the variance and the predicted error, and their highest sensitivities as a
/// limit of the pressure. The limit is no lower than the target's sensitivity.
///
/// # Errors
/// One of the two whiskers is cut into its chamber.
pub fn solve_setpoint_as_felt(
    (target_model, target, target_deviation): (&Model, Target, &dyn Deviation),
    (model, compensator, deviation): (&Model, Compensator, &dyn Deviation),
    objective: Objective,
    usual: &UsualContacts,
) -> Result<Solution, CutIntoChamber> {
    target_model.check_length(target.length)?;
    model.check_length(compensator.length)?;
    let at_target = target_deviation.at(target.pressure);
    let target_per_mm = profile::sensitivities_per_mm(
        target_model,
        target.length,
        &target_model.morphology(target.pressure),
        &at_target.map(f64::exp),
    );
    let question = Question {
        model,
        compensator,
        deviation,
        usual,
        before: after(model, compensator.length, deviation, compensator.pressure),
        target: target_per_mm,
        wanted_log: log_at_tip(target_model, target.length, target.pressure) + at_target[TIP],
    };
    Ok(match objective {
        Objective::Tip => question.solve_tip(),
        Objective::Mean => question.solve_mean(),
        Objective::Shape => question.solve_shape(),
    })
}

/// Best pressure for [`Objective::Mean`] or [`Objective::Shape`], against measured responses before the compensation and
/// of the target. [`Objective::Tip`] is taken as the former: a refinement reduces the mean of eq. 35. The usual contacts apply
/// to [`Objective::Shape`], as in [`solve_setpoint_as_felt`].
///
/// `None` if the compensator is cut into its chamber, or if the target's response at the tip is unknown.
#[must_use]
pub fn least_error(
    model: &Model,
    compensator: Compensator,
    deviation: &dyn Deviation,
    (before, target): (ByRatio, ByRatio),
    objective: Objective,
    usual: &UsualContacts,
) -> Option<Solution> {
    model.check_length(compensator.length).ok()?;
    let wanted_log = target[TIP]?.ln();
    let question = Question { model, compensator, deviation, usual, before, target, wanted_log };
    Some(match objective {
        Objective::Tip | Objective::Mean => question.solve_mean(),
        Objective::Shape => question.solve_shape(),
    })
}

/// Index of the tip, a = 1, in [`CONTACT_RATIOS`].
const TIP: usize = CONTACT_RATIOS.len() - 1;

/// The problem: both whiskers, with all values that do not depend on the pressure sought.
struct Question<'a> {
    model: &'a Model,
    compensator: Compensator,
    deviation: &'a dyn Deviation,
    usual: &'a UsualContacts,
    before: ByRatio,
    target: ByRatio,
    /// Log sensitivity of the target at its tip.
    wanted_log: f64,
}

impl Question<'_> {
    fn range_mpa(&self) -> (f64, f64) {
        let low_mpa = self.compensator.pressure_min.mpa();
        (low_mpa, self.compensator.pressure_max.mpa().max(low_mpa))
    }

    fn solve_tip(&self) -> Solution {
        let (low_mpa, high_mpa) = self.range_mpa();
        let excess = |pressure_mpa: f64| {
            let pressure = Megapascal::known(pressure_mpa);
            log_at_tip(self.model, self.compensator.length, pressure) + self.deviation.at_tip(pressure)
                - self.wanted_log
        };
        let high_mpa = root::peak_mpa(low_mpa, high_mpa, excess);
        let (at_low, at_high) = (excess(low_mpa), excess(high_mpa));
        if at_low.abs() <= EQUAL_LOG {
            Solution::InRange(self.setpoint(low_mpa))
        } else if at_high.abs() <= EQUAL_LOG {
            Solution::InRange(self.setpoint(high_mpa))
        } else if at_low > 0.0 {
            Solution::NeedsBelow(self.setpoint(low_mpa))
        } else if at_high < 0.0 {
            Solution::NeedsAbove(self.setpoint(high_mpa))
        } else {
            let root_mpa = root::root((low_mpa, at_low), (high_mpa, at_high), PRESSURE_TOLERANCE_MPA, excess);
            Solution::InRange(self.setpoint(root_mpa))
        }
    }

    fn solve_mean(&self) -> Solution {
        let (low_mpa, high_mpa) = self.range_mpa();
        let at_high = self.after(high_mpa);
        let weighed: Vec<(usize, f64, f64)> = (0..CONTACT_RATIOS.len())
            .filter_map(|k| {
                let (before, target) = (self.before[k]?, self.target[k]?);
                at_high[k]?;
                profile::distinct(before, target).then_some((k, target, 1.0 / (before - target).abs()))
            })
            .collect();
        if weighed.is_empty() || low_mpa == high_mpa {
            return self.solve_tip();
        }
        let total_error = |pressure_mpa: f64| {
            let after = self.after(pressure_mpa);
            weighed.iter().map(|&(k, target, weight)| weight * (after[k].unwrap_or(target) - target).abs()).sum()
        };
        let least_mpa = root::least(low_mpa, high_mpa, MEAN_CELLS, MEAN_TOLERANCE_MPA, total_error);
        within((low_mpa, high_mpa), least_mpa, self.setpoint(least_mpa))
    }

    fn solve_shape(&self) -> Solution {
        let (low_mpa, highest_mpa) = self.range_mpa();
        let high_mpa = self.highest_readable_mpa(low_mpa, highest_mpa);
        let at_high = self.after(high_mpa);
        let used: Vec<usize> =
            (0..CONTACT_RATIOS.len()).filter(|&k| self.target[k].is_some() && at_high[k].is_some()).collect();
        // Mean and variance of ln(target / compensator).
        let shape = |pressure_mpa: f64| {
            let after = self.after(pressure_mpa);
            let log = |k: usize| Some((self.usual.weights[k], (self.target[k]? / after[k]?).ln()));
            let logs: Vec<(f64, f64)> = used.iter().filter_map(|&k| log(k)).collect();
            let mean = weighted_mean(logs.iter().copied());
            (mean, weighted_mean(logs.iter().map(|(weight, log)| (*weight, (log - mean).powi(2)))))
        };
        let setpoint = |pressure_mpa: f64| self.setpoint_with(pressure_mpa, shape(pressure_mpa).0.exp());
        if low_mpa == highest_mpa {
            return Solution::InRange(setpoint(low_mpa));
        }
        let least_mpa =
            root::least(low_mpa, high_mpa, MEAN_CELLS, SHAPE_TOLERANCE_MPA, |pressure_mpa| shape(pressure_mpa).1);
        within((low_mpa, high_mpa), least_mpa, setpoint(least_mpa))
    }

    /// Highest pressure from which down the gauge reads the largest usual strains, or as much as the target's gauge had to. The
    /// sensitivity rises with the pressure. The lowest pressure if none will do.
    fn highest_readable_mpa(&self, low_mpa: f64, high_mpa: f64) -> f64 {
        let limits: ByRatio = std::array::from_fn(|k| Some(self.usual.per_mm_max[k]?.max(self.target[k]?)));
        let excess = |pressure_mpa: f64| {
            let after = self.after(pressure_mpa);
            let logs = (0..CONTACT_RATIOS.len()).filter_map(|k| Some((after[k]? / limits[k]?).ln()));
            logs.fold(f64::NEG_INFINITY, f64::max)
        };
        if limits == [None; CONTACT_RATIOS.len()] || excess(high_mpa) <= 0.0 {
            return high_mpa;
        }
        let cell_mpa = (high_mpa - low_mpa) / f64::from(MEAN_CELLS);
        let grid = (0..=MEAN_CELLS).map(|k| low_mpa + cell_mpa * f64::from(k)).map(|mpa| (mpa, excess(mpa)));
        let points: Vec<(f64, f64)> = grid.collect();
        match points.iter().position(|(_, excess)| *excess > 0.0) {
            None => high_mpa,
            Some(0) => low_mpa,
            Some(above) => root::root(points[above - 1], points[above], PRESSURE_TOLERANCE_MPA, excess),
        }
    }

    fn after(&self, pressure_mpa: f64) -> ByRatio {
        after(self.model, self.compensator.length, self.deviation, Megapascal::known(pressure_mpa))
    }

    fn setpoint(&self, pressure_mpa: f64) -> Setpoint {
        let pressure = Megapascal::known(pressure_mpa);
        let after = self.after(pressure_mpa);
        let error = ErrorProfile::new(&after, &self.before, &self.target);
        let gain = GainProfile::new(&after, &self.target);
        Setpoint { pressure, k2: self.model.k2(pressure), error, air_error: error.mean, reading_gain: 1.0, gain }
    }

    /// A setpoint whose robot multiplies its readings.
    fn setpoint_with(&self, pressure_mpa: f64, reading_gain: f64) -> Setpoint {
        let read = self.after(pressure_mpa).map(|after| Some(reading_gain * after?));
        Setpoint {
            error: ErrorProfile::weighted(&read, &self.before, &self.target, &self.usual.weights),
            reading_gain,
            gain: GainProfile { by_ratio: [reading_gain; CONTACT_RATIOS.len()] },
            ..self.setpoint(pressure_mpa)
        }
    }
}

/// A minimum at an end of the range counts as out of range.
fn within((low_mpa, high_mpa): (f64, f64), pressure_mpa: f64, setpoint: Setpoint) -> Solution {
    if pressure_mpa == low_mpa {
        Solution::NeedsBelow(setpoint)
    } else if pressure_mpa == high_mpa {
        Solution::NeedsAbove(setpoint)
    } else {
        Solution::InRange(setpoint)
    }
}

/// ln s(1, La, Q) of a whisker that is not cut into its chamber.
fn log_at_tip(model: &Model, length: Millimetre, pressure: Megapascal) -> f64 {
    model.tip_sensitivity_per_mm(length, &model.morphology(pressure)).ln()
}

/// Sensitivities of a compensator at a pressure.
fn after(model: &Model, length: Millimetre, deviation: &dyn Deviation, pressure: Megapascal) -> ByRatio {
    let factors = deviation.at(pressure).map(f64::exp);
    profile::sensitivities_per_mm(model, length, &model.morphology(pressure), &factors)
}
