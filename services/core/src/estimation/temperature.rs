//! Temperature of a whisker's contacts, against that of earlier ones.

use borsh::{BorshDeserialize, BorshSerialize};

/// Bound of a temperature's difference, K: beyond it a thermometer is broken.
const WARMER_MAX_K: f64 = 100.0;
/// Difference from the temperature of the last contacts from which the offset becomes less certain, K: another room, or a
/// night without contacts.
const MOVED_K: f64 = 2.0;
/// Number of contacts over which that temperature follows: it stays near a day's swing, of which contacts tell the coefficient.
const FOLLOWS_CONTACTS: f64 = 100.0;

/// Temperatures of a whisker's earlier contacts, degrees Celsius.
#[derive(Debug, Clone, Copy, PartialEq, BorshSerialize, BorshDeserialize)]
pub struct Temperatures {
    /// Temperature of the first contact, for which the offset is stated.
    reference_c: f32,
    /// Temperature of the last contacts.
    lately_c: f32,
}

/// Temperature of a contact.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Warmth {
    /// Difference from the first contact's temperature, K.
    pub warmer_k: f64,
    /// Sudden change against the last contacts, K; 0 while it is small.
    pub moved_k: f64,
}

impl Temperatures {
    /// Temperatures of a whisker whose offset was learned at one temperature.
    #[must_use]
    pub fn of(reference_c: f32) -> Self {
        Self { reference_c, lately_c: reference_c }
    }

    /// Takes the temperature of a contact in.
    pub fn feel(&mut self, temperature_c: f64) -> Warmth {
        let above = |one_c: f32| (temperature_c - f64::from(one_c)).clamp(-WARMER_MAX_K, WARMER_MAX_K);
        let moved_k = above(self.lately_c);
        let has_moved = moved_k.abs() >= MOVED_K;
        let follows = if has_moved { 1.0 } else { 1.0 / FOLLOWS_CONTACTS };
        self.lately_c = (f64::from(self.lately_c) + follows * moved_k) as f32;
        Warmth { warmer_k: above(self.reference_c), moved_k: if has_moved { moved_k } else { 0.0 } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn property_a_step_counts_once_and_a_swing_never() {
        let mut felt = Temperatures::of(20.0);
        assert_eq!(felt.feel(21.5), Warmth { warmer_k: 1.5, moved_k: 0.0 });
        // 10 K in 1000 contacts.
        assert!((1..=1000).all(|contact| felt.feel(21.5 + 0.01 * f64::from(contact)).moved_k == 0.0));
        assert!(felt.feel(25.5).moved_k < -4.0);
        assert_eq!(felt.feel(25.5), Warmth { warmer_k: 5.5, moved_k: 0.0 });
        assert_eq!(felt.feel(1e9), Warmth { warmer_k: 100.0, moved_k: 100.0 });
    }
}
