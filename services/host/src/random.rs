//! Random numbers that nobody can guess.

use crate::process;

/// Fills `bytes` with random ones of the system.
///
/// # Panics
/// The system has no random numbers; hash tables could not be created either.
#[expect(clippy::disallowed_methods, reason = "the one source of randomness")]
pub fn fill(bytes: &mut [u8]) {
    if let Some(process) = process::simulated() {
        return process.fill(bytes);
    }
    if let Err(problem) = getrandom::fill(bytes) {
        panic!("no randomness from the system: {problem}");
    }
}

/// Random bytes.
#[must_use]
pub fn bytes<const N: usize>() -> [u8; N] {
    let mut bytes = [0; N];
    fill(&mut bytes);
    bytes
}

/// 128 random bits as 32 hexadecimal digits.
#[must_use]
pub fn hex() -> String {
    format!("{:032x}", u128::from_ne_bytes(bytes()))
}

/// A number from 0 to below 1.
#[must_use]
pub fn fraction() -> f64 {
    const BITS: u32 = 53;
    (u64::from_ne_bytes(bytes()) >> (u64::BITS - BITS)) as f64 / (1_u64 << BITS) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fractions_are_spread_over_their_range() {
        let all: Vec<f64> = (0..1_000).map(|_| fraction()).collect();
        assert!(all.iter().all(|one| (0.0..1.0).contains(one)));
        let mean = all.iter().sum::<f64>() / 1_000.0;
        assert!((mean - 0.5).abs() < 0.1, "{mean}");
    }
}
