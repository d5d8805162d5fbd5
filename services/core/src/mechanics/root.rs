//! Numerical roots, minima and peaks.

/// Number of cells in a search over the pressure: 5 kPa each over the examined range.
const CELLS: u32 = 40;
/// Tolerance of the pressure of an extreme value, in MPa.
const TOLERANCE_MPA: f64 = 1e-9;
/// Step that shows whether a curve still rises, in MPa.
const STEP_MPA: f64 = 1e-6;

/// Root of `f` between `low` and `high`, where it has opposite signs, to within `tolerance`.
///
/// The ITP method (Oliveira and Takahashi 2020): the secant's guess is moved toward the middle just enough to need
/// at most one step more than bisection; for smooth functions a dozen steps where bisection takes forty. `f_low`
/// and `f_high` are the values at the ends; the sign of `f_low` gives the direction. Without a change of sign, the
/// result lies at one of the ends.
pub(crate) fn root(
    (mut low, f_low): (f64, f64),
    (mut high, f_high): (f64, f64),
    tolerance: f64,
    f: impl Fn(f64) -> f64,
) -> f64 {
    let rising = if f_low <= 0.0 { 1.0 } else { -1.0 };
    let (mut y_low, mut y_high) = (rising * f_low, rising * f_high);
    let width = high - low;
    let truncation = 0.2 / width;
    let bisection_steps = (width / (2.0 * tolerance)).log2().ceil().max(0.0);
    let mut allowed = tolerance * (bisection_steps + 1.0).exp2();
    while high - low > 2.0 * tolerance {
        let middle = 0.5 * (low + high);
        let slack = allowed - 0.5 * (high - low);
        allowed *= 0.5;
        let secant = (y_high * low - y_low * high) / (y_high - y_low);
        let shift = truncation * (high - low).powi(2);
        let toward = (middle - secant).signum();
        let shifted = if shift <= (middle - secant).abs() { secant + toward * shift } else { middle };
        let projected = if (shifted - middle).abs() <= slack { shifted } else { middle - toward * slack };
        // A guess on an end would stall, so it is moved inside by the tolerance.
        let guess = projected.clamp(low + tolerance, high - tolerance);
        let y = rising * f(guess);
        if y > 0.0 {
            (high, y_high) = (guess, y);
        } else if y < 0.0 {
            (low, y_low) = (guess, y);
        } else {
            return guess;
        }
    }
    0.5 * (low + high)
}

/// Minimum of `f` between `low` and `high`, to within `tolerance`.
///
/// A grid of `cells` finds the valley, golden section its bottom; this needs no derivative and tolerates a kink.
/// Finds the minimum if `f` has one valley within the two cells next to the least grid point.
pub(super) fn least(low: f64, high: f64, cells: u32, tolerance: f64, f: impl Fn(f64) -> f64) -> f64 {
    let step = (high - low) / f64::from(cells);
    let grid = |k: u32| {
        if k == cells { high } else { low + step * f64::from(k) }
    };
    let (best, best_value) =
        (0..=cells).map(|k| (k, f(grid(k)))).min_by(|(_, a), (_, b)| a.total_cmp(b)).unwrap_or((0, f64::INFINITY));
    let (found, value) = golden_section(grid(best.saturating_sub(1)), grid((best + 1).min(cells)), tolerance, &f);
    if value < best_value { found } else { grid(best) }
}

fn golden_section(mut low: f64, mut high: f64, tolerance: f64, f: &impl Fn(f64) -> f64) -> (f64, f64) {
    const SHARE: f64 = 0.618_033_988_749_894_8;
    let mut left = high - SHARE * (high - low);
    let mut right = low + SHARE * (high - low);
    let (mut f_left, mut f_right) = (f(left), f(right));
    while high - low > tolerance {
        if f_left <= f_right {
            (high, right, f_right) = (right, left, f_left);
            left = high - SHARE * (high - low);
            f_left = f(left);
        } else {
            (low, left, f_left) = (left, right, f_right);
            right = low + SHARE * (high - low);
            f_right = f(right);
        }
    }
    if f_left <= f_right { (left, f_left) } else { (right, f_right) }
}

/// Pressure at which `f` is greatest between two pressures, if `f` rises to one peak. The peak is mostly at the
/// upper end, which two evaluations show.
///
/// A tip's sensitivity rises with the pressure because the wall softens. It also falls, because the chamber's
/// growing compliance absorbs more of the deflection; for short whiskers (nguyen-2021: below 52 mm) this effect
/// prevails below 0.2 MPa. Beyond the peak, more pressure does not help.
pub(super) fn peak_mpa(low_mpa: f64, high_mpa: f64, f: impl Fn(f64) -> f64) -> f64 {
    let near_high_mpa = high_mpa - STEP_MPA;
    if near_high_mpa <= low_mpa || f(high_mpa) >= f(near_high_mpa) {
        high_mpa
    } else {
        least(low_mpa, high_mpa, CELLS, TOLERANCE_MPA, |pressure_mpa| -f(pressure_mpa))
    }
}
