//! Equally likely cases of independent standard normal variables: a fixed, evenly spread set, so that the same
//! question has the same answer every time.

use std::borrow::Cow;

use statrs::distribution::{ContinuousCDF, Normal};

/// Default number of cases.
pub const CASES: u32 = 400;

/// Numbers of variables in predictions, pressure reviews and measurements: their cases are precomputed.
const USUAL: [usize; 4] = [7, 9, 12, 14];

/// Precomputed cases: quantiles of the normal distribution take longer than all other work on a case.
#[derive(Debug, Clone)]
pub struct CubatureCases {
    tables: Vec<Table>,
}

/// The first [`CASES`] cases for a number of variables.
#[derive(Debug, Clone)]
struct Table {
    causes: usize,
    amounts: Vec<f64>,
}

impl Default for CubatureCases {
    fn default() -> Self {
        let table = |causes| Table { causes, amounts: amounts(causes, CASES) };
        Self { tables: USUAL.map(table).into() }
    }
}

impl CubatureCases {
    /// The cases in order, each as the values of all variables in standard deviations. Empty if `causes` is 0.
    #[must_use]
    pub fn amounts(&self, causes: usize, count: u32) -> Cow<'_, [f64]> {
        let known = self.tables.iter().find(|table| table.causes == causes);
        match known.and_then(|table| table.amounts.get(..causes * count as usize)) {
            Some(amounts) => Cow::Borrowed(amounts),
            None => Cow::Owned(amounts(causes, count)),
        }
    }
}

fn amounts(causes: usize, count: u32) -> Vec<f64> {
    let steps = evenly_spread(causes);
    let normal = Normal::standard();
    let amount = |case: u32, step: f64| {
        let part = (0.5 + f64::from(case) * step).fract().clamp(1e-9, 1.0 - 1e-9);
        normal.inverse_cdf(part)
    };
    (0..count).flat_map(|case| steps.iter().map(move |&step| amount(case, step))).collect()
}

/// Additive recurrence of the generalised golden ratio (Roberts 2018), one step for each dimension.
fn evenly_spread(dimensions: usize) -> Vec<f64> {
    let power = 1.0 / (dimensions as f64 + 1.0);
    let golden = (0..64).fold(1.5_f64, |x, _| (1.0 + x).powf(power));
    (0..dimensions as i32).map(|at| golden.powi(-at - 1)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_worked_out_is_what_would_be() {
        let cases = CubatureCases::default();
        for (causes, count) in [(0, 400), (1, 400), (7, 16), (9, 400), (12, 127), (14, 401)] {
            let found = cases.amounts(causes, count);
            assert_eq!(*found, amounts(causes, count), "{causes} {count}");
            assert_eq!(found.len(), causes * count as usize);
            assert_eq!(matches!(found, Cow::Borrowed(_)), USUAL.contains(&causes) && count <= CASES);
        }
    }
}
