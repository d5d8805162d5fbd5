//! The exponential function of a whole curve at once.
//!
//! A decision evaluates hundreds of cases of a dozen responses each within one step; scalar exponentials would take
//! longer than everything else in it. This function has no branches, so that compilers vectorise it. It agrees with
//! [`f64::exp`] to a few units in the last place.

/// Limit of the exponent: values beyond e^±700 cannot be sensitivities.
const LARGEST: f64 = 700.0;
/// 1.5 * 2^52: added to a small number, it leaves the number, rounded to an integer, in the lowest bits.
const ROUNDING: f64 = 6_755_399_441_055_744.0;
/// ln 2 in two parts. Multiples of the first up to some thousand are exact.
const LN_2: (f64, f64) = (0.693_147_180_369_123_8, 1.908_214_929_270_587_7e-10);
/// Number of bits of the fraction; the exponent lies above them.
const FRACTION_BITS: u32 = 52;

/// 1 / k! from k = 12 down to 0: the Taylor series up to half of ln 2, where the next term is 2e-16.
const SERIES: [f64; 13] = {
    let mut terms = [1.0; 13];
    let mut k = 1;
    while k < terms.len() {
        terms[12 - k] = terms[13 - k] / k as f64;
        k += 1;
    }
    terms
};

/// e raised to each value.
pub(super) fn exp<const N: usize>(logs: &[f64; N]) -> [f64; N] {
    let mut powers = *logs;
    // Compilers vectorise this loop in place, but not `map`.
    for value in &mut powers {
        let log = value.clamp(-LARGEST, LARGEST);
        let shifted = log * std::f64::consts::LOG2_E + ROUNDING;
        let doublings = shifted - ROUNDING;
        let rest = (log - doublings * LN_2.0) - doublings * LN_2.1;
        let mut power = SERIES[0];
        for term in &SERIES[1..] {
            power = power * rest + term;
        }
        *value = f64::from_bits(power.to_bits().wrapping_add(shifted.to_bits() << FRACTION_BITS));
    }
    powers
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn property_it_is_the_exponential_function() {
        for k in -60_000..60_000 {
            let log = f64::from(k) * 0.011_37;
            let (result, known) = (exp(&[log; 12])[7], log.exp());
            assert!((result - known).abs() <= 1e-15 * known, "{log}: {result} {known}");
        }
        assert_eq!(exp(&[0.0; 12]), [1.0; 12]);
    }

    #[test]
    fn what_is_no_sensitivity_stays_apart() {
        assert!(exp(&[f64::NAN; 12])[0].is_nan());
        assert!(exp(&[f64::INFINITY; 12])[3] > 1e300 && exp(&[f64::NEG_INFINITY; 12])[3] < 1e-300);
    }
}
