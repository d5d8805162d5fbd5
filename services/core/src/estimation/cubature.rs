//! Equally likely cases of independent standard normal variables: a fixed, evenly spread set, so that the same
//! question has the same answer every time.

use std::borrow::Cow;
use std::sync::OnceLock;

use statrs::distribution::{ContinuousCDF, Normal};

/// Default number of cases.
pub const CASES: u32 = 400;

/// The first [`CASES`] cases by the number of variables, each made at its first use: quantiles of the normal distribution
/// take longer than all other work on a case.
static TABLES: [OnceLock<Vec<f64>>; 32] = [const { OnceLock::new() }; 32];

/// The cases in order, each as the values of all variables in standard deviations. Empty if `causes` is 0.
#[must_use]
pub fn amounts(causes: usize, count: u32) -> Cow<'static, [f64]> {
    let table = TABLES.get(causes).filter(|_| count <= CASES);
    match table.and_then(|table| table.get_or_init(|| quantiles(causes, CASES)).get(..causes * count as usize)) {
        Some(amounts) => Cow::Borrowed(amounts),
        None => Cow::Owned(quantiles(causes, count)),
    }
}

fn quantiles(causes: usize, count: u32) -> Vec<f64> {
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
        for (causes, count) in [(0, 400), (1, 400), (7, 16), (10, 400), (13, 127), (14, 401), (32, 16)] {
            let found = amounts(causes, count);
            assert_eq!(*found, quantiles(causes, count), "{causes} {count}");
            assert_eq!(found.len(), causes * count as usize);
            assert_eq!(matches!(found, Cow::Borrowed(_)), causes < 32 && count <= CASES);
        }
    }
}
