//! Compensations that a bench contains: a whisker of one length at two pressures, beside one of another length.

use vibrissa_core::mechanics::{Kind, Model, compensation_error};
use vibrissa_core::units::{ContactRatio, Megapascal, Millimetre};

use super::groups::{Compared, Comparison, clusters, rounded};

/// Least difference of the strains before a compensation, as a share of the target's: as in the error profile.
const LEAST_DIFFERENCE: f64 = 0.02;
/// Most compensations that are shown.
const SHOWN_MAX: usize = 6;

/// Sensitivity of one whisker at one pressure and ratio.
struct Sensitivity {
    ratio: f64,
    measured_per_mm: f64,
    computed_per_mm: f64,
}

/// All contacts of one whisker at one pressure.
struct Series {
    length_mm: f64,
    pressure_mpa: f64,
    by_ratio: Vec<Sensitivity>,
}

/// A compensation with its error by contact ratio.
pub(crate) struct Compensation {
    target_mm: f64,
    length_mm: f64,
    before_mpa: f64,
    after_mpa: f64,
    /// Contact ratio, measured and computed error of eq. 35 as ratios.
    pub(crate) by_ratio: Vec<(f64, f64, f64)>,
}

impl Compensation {
    /// Whiskers and pressures.
    pub(crate) fn name(&self) -> String {
        let mpa = |pressure_mpa: f64| rounded(pressure_mpa, 1000.0);
        format!(
            "{} mm for {} mm at {} MPa, by {} MPa",
            rounded(self.length_mm, 10.0),
            rounded(self.target_mm, 10.0),
            mpa(self.before_mpa),
            mpa(self.after_mpa)
        )
    }

    fn mean_computed(&self) -> f64 {
        self.by_ratio.iter().map(|(.., computed)| computed).sum::<f64>() / self.by_ratio.len() as f64
    }
}

/// For each target, and each other whisker, the pressure of the bench with the least computed error.
pub(crate) fn compensations(comparison: &Comparison, model: &Model) -> Vec<Compensation> {
    if !comparison.by_ratio {
        return Vec::new();
    }
    let all = series(&comparison.of_kind(Kind::ContactStrain), model);
    let mut found = Vec::new();
    for target in &all {
        let others = all.iter().filter(|before| {
            before.length_mm != target.length_mm && (before.pressure_mpa - target.pressure_mpa).abs() < 0.002
        });
        for before in others {
            let after = all
                .iter()
                .filter(|after| after.length_mm == before.length_mm && after.pressure_mpa != before.pressure_mpa);
            let compensations = after.map(|after| compensation(target, before, after));
            let best = compensations
                .filter(|one| !one.by_ratio.is_empty())
                .min_by(|a, b| a.mean_computed().total_cmp(&b.mean_computed()));
            found.extend(best);
        }
    }
    found.sort_by(|a, b| a.mean_computed().total_cmp(&b.mean_computed()));
    found.truncate(SHOWN_MAX);
    found
}

fn compensation(target: &Series, before: &Series, after: &Series) -> Compensation {
    let at = |series: &'_ Series, ratio: f64| {
        let same = series.by_ratio.iter().find(|one| (one.ratio - ratio).abs() < 0.01)?;
        Some((same.measured_per_mm, same.computed_per_mm))
    };
    let error = |one: &Sensitivity| {
        let (before, after) = (at(before, one.ratio)?, at(after, one.ratio)?);
        let differs = (before.1 - one.computed_per_mm).abs() > LEAST_DIFFERENCE * one.computed_per_mm;
        let measured = compensation_error(after.0, before.0, one.measured_per_mm)?;
        let computed = compensation_error(after.1, before.1, one.computed_per_mm)?;
        differs.then_some((one.ratio, measured, computed))
    };
    Compensation {
        target_mm: target.length_mm,
        length_mm: before.length_mm,
        before_mpa: before.pressure_mpa,
        after_mpa: after.pressure_mpa,
        by_ratio: target.by_ratio.iter().filter_map(error).collect(),
    }
}

fn series(contacts: &[Compared], model: &Model) -> Vec<Series> {
    let mut all = Vec::new();
    for (length_mm, of_length) in clusters(contacts, |one| one.length_mm) {
        for (pressure_mpa, of_pressure) in clusters(&of_length, |one| Some(one.reading.pressure.mpa())) {
            let by_ratio = clusters(&of_pressure, |one| one.place);
            let sensitivity = |(ratio, group): (f64, Vec<Compared>)| {
                let computed_per_mm = computed_per_mm(model, ratio, length_mm, pressure_mpa)?;
                Some(Sensitivity { ratio, measured_per_mm: slope(&group)?, computed_per_mm })
            };
            all.push(Series {
                length_mm,
                pressure_mpa,
                by_ratio: by_ratio.into_iter().filter_map(sensitivity).collect(),
            });
        }
    }
    all
}

fn computed_per_mm(model: &Model, ratio: f64, length_mm: f64, pressure_mpa: f64) -> Option<f64> {
    let morphology = model.morphology(Megapascal::new(pressure_mpa).ok()?);
    let (ratio, length) = (ContactRatio::new(ratio).ok()?, Millimetre::new(length_mm).ok()?);
    model.sensitivity_per_mm(ratio, length, &morphology).ok()
}

/// Slope of the strain over the deflection, through the origin.
fn slope(group: &[Compared]) -> Option<f64> {
    let (mut products, mut squares) = (0.0, 0.0);
    for one in group {
        let deflection_mm = one.reading.contact()?.deflection_mm;
        products += deflection_mm * one.reading.value;
        squares += deflection_mm * deflection_mm;
    }
    (squares > 0.0).then_some(products / squares)
}
