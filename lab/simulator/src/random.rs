//! Reproducible randomness: one stream for each purpose, so that draws for one purpose never shift those for
//! another.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Purpose of a stream of random numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Purpose {
    /// Deviations of a whisker's calibration.
    Calibration,
    /// Times of a whisker's contacts.
    Timing,
    /// Contact ratios and deflections.
    Contact,
    /// Noise of a whisker's sensors.
    Noise,
    /// Noise of a pressure sensor.
    Regulator,
    /// Faults of the link.
    Link,
    /// Noise of touches on request.
    Test,
    /// Noise of the samples of a gauge.
    Samples,
    /// Delays of answers to requests for births.
    Birth,
}

/// Independent stream for a seed, robot, array, whisker and purpose.
pub(crate) fn stream(seed: u64, robot: &str, array: &str, whisker: u16, purpose: Purpose) -> ChaCha8Rng {
    let mut hash = Fnv::new(seed);
    for part in [robot.as_bytes(), array.as_bytes(), &whisker.to_le_bytes(), &[purpose as u8]] {
        hash.add(part);
    }
    ChaCha8Rng::seed_from_u64(hash.0)
}

/// Boot id of a robot: different for each seed, robot, start time and boot number.
pub(crate) fn boot_text(seed: u64, robot: &str, start_us: u64, boot: u64) -> String {
    let mut hash = Fnv::new(seed);
    for part in [robot.as_bytes(), &start_us.to_le_bytes(), &boot.to_le_bytes()] {
        hash.add(part);
    }
    format!("sim-{:016x}", hash.0)
}

/// Short hash of a text: the same on every machine and in every version.
pub(crate) fn digest(text: &str) -> u64 {
    let mut hash = Fnv::new(0);
    hash.add(text.as_bytes());
    hash.0
}

/// Normal deviate with the given standard deviation.
pub(crate) fn normal(stream: &mut ChaCha8Rng, standard_deviation: f64) -> f64 {
    let unit: f64 = StandardNormal.sample(stream);
    unit * standard_deviation
}

/// FNV-1a: the same on every machine and in every version, unlike the standard library's hasher.
struct Fnv(u64);

impl Fnv {
    fn new(seed: u64) -> Self {
        let mut hash = Self(0xcbf2_9ce4_8422_2325);
        hash.add(&seed.to_le_bytes());
        hash
    }

    /// Adds a part and its length, so that moving a byte from one part to the next changes the hash.
    fn add(&mut self, part: &[u8]) {
        for byte in part.iter().chain(&(part.len() as u64).to_le_bytes()) {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::Rng;

    use super::*;

    #[test]
    fn each_label_has_a_stream_of_its_own_and_the_same_labels_the_same() {
        let first =
            |robot: &str, array: &str, whisker, purpose| stream(7, robot, array, whisker, purpose).random::<u64>();
        let one = first("r", "left", 0, Purpose::Contact);
        assert_eq!(one, first("r", "left", 0, Purpose::Contact));
        assert_ne!(one, first("rl", "eft", 0, Purpose::Contact));
        assert_ne!(one, first("r", "left", 1, Purpose::Contact));
        assert_ne!(one, first("r", "left", 0, Purpose::Noise));
    }

    #[test]
    fn a_boot_has_a_mark_of_its_own() {
        let boots =
            [boot_text(1, "r", 5, 0), boot_text(1, "r", 5, 1), boot_text(1, "r", 6, 0), boot_text(2, "r", 5, 0)];
        for (index, boot) in boots.iter().enumerate() {
            assert!(!boots[..index].contains(boot));
        }
    }
}
