//! exp and ln in single precision, without branches, calls or tables, so that the compiler vectorises them.
//!
//! Their results are the same on every machine, to the last bit.

/// ln 2 in two parts; integer multiples of the first are exact because it has few digits.
const LN_2: (f32, f32) = (0.693_359_4, -2.121_944_4e-4);
/// 1.5 * 2^23: added to a number, it leaves the nearest integer in the last bits.
const WHOLE: f32 = 12_582_912.0;
/// The bits of 1.0, and the position of the exponent.
const ONE: u32 = 0x3f80_0000;
const EXPONENT_AT: u32 = 23;
/// The bits of the square root of 1/2.
const ROOT_HALF: i32 = 0x3f35_04f3;
/// Least exponent; smaller ones give the same result.
const LEAST: f32 = -87.0;

/// e^x for x up to 88, to one unit in the last place. From -87 on downward the result is 1.6e-38.
pub(super) fn exp(x: f32) -> f32 {
    let x = if x > LEAST { x } else { LEAST };
    let shifted = x * std::f32::consts::LOG2_E + WHOLE;
    let whole = shifted - WHOLE;
    let r = (x - whole * LN_2.0) - whole * LN_2.1;
    // Minimax polynomial over ±ln 2 / 2 (Moshier, Cephes).
    let p = 1.987_569_2e-4;
    let p = p * r + 1.398_2e-3;
    let p = p * r + 8.333_452e-3;
    let p = p * r + 4.166_579_6e-2;
    let p = p * r + 1.666_666_5e-1;
    let p = p * r + 5e-1;
    let power = f32::from_bits((shifted.to_bits() << EXPONENT_AT).wrapping_add(ONE));
    (p * (r * r) + r + 1.0) * power
}

/// ln(1 + y) for y >= 0, to two units in the last place, also for tiny y.
pub(super) fn ln_one_plus(y: f32) -> f32 {
    let u = 1.0 + y;
    let lost = (y - (u - 1.0)) / u;
    let bits = u.to_bits() as i32 - ROOT_HALF;
    let exponent = (bits >> EXPONENT_AT) as f32;
    let f = f32::from_bits(((bits & 0x007f_ffff) + ROOT_HALF) as u32) - 1.0;
    // With s = f / (2 + f): ln(1 + f) = 2 atanh(s), which starts with f - f^2 / 2 (Ng, fdlibm).
    let s = f / (2.0 + f);
    let z = s * s;
    let rest = z * (0.666_666_6 + z * (0.400_009_72 + z * (0.284_987_87 + z * 0.242_790_79)));
    let half_square = 0.5 * f * f;
    s * (half_square + rest) + (exponent * LN_2.1 + lost) - half_square + f + exponent * LN_2.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn property_exp_is_that_of_the_library() {
        for k in -870_000..=880_000 {
            let x = 1e-4 * k as f32;
            let truth = f64::from(x).exp();
            assert!((f64::from(exp(x)) / truth - 1.0).abs() < 2e-7, "{x}");
        }
        assert_eq!(exp(-1e30), exp(-87.0));
        assert_eq!(exp(0.0), 1.0);
    }

    #[test]
    fn property_ln_is_that_of_the_library() {
        for k in 0..2_000_000 {
            let y = (1e-5 * f64::from(k) - 10.0).exp2() as f32;
            let truth = f64::from(y).ln_1p();
            assert!((f64::from(ln_one_plus(y)) / truth - 1.0).abs() < 3e-7, "{y}");
        }
        for y in [0.0, 1e-30, 1e-8, 1e-6, 1e-4] {
            assert!((f64::from(ln_one_plus(y)) - f64::from(y).ln_1p()).abs() <= 2e-7 * f64::from(y), "{y}");
        }
    }
}
