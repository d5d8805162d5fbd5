//! Values at and near the limits of a range.

use std::fmt::Write as _;

use rand::Rng;
use rand::seq::IndexedRandom;

use super::shape::{Range, Text};

/// Magnitudes at which arithmetic goes wrong: the smallest numbers, and numbers whose squares and quotients leave the
/// range of an `f64`.
const MAGNITUDES: [f64; 12] =
    [5e-324, f64::MIN_POSITIVE, 1e-300, 1e-160, 1e-100, 1e-45, 1e-30, 1e-16, 1e-12, 1e-9, 1e-6, f64::EPSILON];

/// Texts that confuse readers, databases and terminals, as JSON.
const TEXTS: [&str; 16] = [
    r#""a\u0000b""#,
    r#""\u0000""#,
    r#""\u001b[2J\u0007""#,
    r#""line\nline\r\ttab""#,
    r#""\u007f\u0085\u009f""#,
    r#""\u202eright to left\u200b""#,
    r#""\ufeff""#,
    r#""\ufffe\uffff""#,
    r#""😀\ud83d\ude00""#,
    r#""'; DROP TABLE robots; --""#,
    r#""<script>alert(1)</script>""#,
    r#""%00%s%n$(id)`id`""#,
    r#""../../etc/passwd""#,
    r#""NaN""#,
    r#""nguyen-2021 ""#,
    r#"" ""#,
];

/// Draws a number of the range, mostly at or near its ends, at zero or of an extreme magnitude.
pub fn number(random: &mut impl Rng, range: Range) -> f64 {
    let Range { least, most } = range;
    let value = match random.random_range(0..10) {
        0 => least,
        1 => most,
        2 => least.next_up(),
        3 => most.next_down(),
        4 | 5 => {
            let magnitude = MAGNITUDES.choose(random).copied().unwrap_or(f64::MIN_POSITIVE);
            let sign = if least < 0.0 && random.random() { -1.0 } else { 1.0 };
            // If the range does not contain zero, the distance is taken from its least value.
            if least > 0.0 { least * (1.0 + magnitude) } else { sign * magnitude }
        }
        6 => 0.0 * if random.random() { -1.0 } else { 1.0 },
        7 => {
            // All magnitudes are equally likely.
            let (low, high) = (least.max(f64::MIN_POSITIVE).ln(), most.max(f64::MIN_POSITIVE).ln());
            if low < high { random.random_range(low..high).exp() } else { most }
        }
        _ => least + (most - least) * random.random::<f64>(),
    };
    value.clamp(least, most)
}

/// Draws an integer of the range, often one of its ends.
pub fn integer(random: &mut impl Rng, least: u64, most: u64) -> u64 {
    match random.random_range(0..6) {
        0 => least,
        1 => most,
        2 => least.saturating_add(1).min(most),
        3 => most.saturating_sub(1).max(least),
        _ => random.random_range(least..=most) >> random.random_range(0..53).min(most.leading_zeros()),
    }
    .clamp(least, most)
}

/// Draws a time in microseconds since 1970 UTC: now, seconds or years off, or at the limits.
pub fn time_us(random: &mut impl Rng, now_us: u64, most: u64) -> u64 {
    const YEAR_US: u64 = 365 * 86_400 * 1_000_000;
    let back = |by: u64| now_us.saturating_sub(by);
    match random.random_range(0..12) {
        0 => 0,
        1 => most,
        2 => back(random.random_range(0..30) * YEAR_US),
        3 => now_us.saturating_add(random.random_range(0..200) * YEAR_US).min(most),
        4 => back(random.random_range(0..3_600_000_000)),
        5 => now_us + random.random_range(0..3_600_000_000),
        _ => back(random.random_range(0..1_000_000)),
    }
}

/// Appends a text as JSON.
pub fn text(random: &mut impl Rng, kind: Text, now_us: u64, out: &mut String) {
    match kind {
        Text::Name => {
            let name = ["left", "right", "a", "-", "__proto__", "supervisor"].choose(random).copied();
            let _ = write!(out, "\"{}\"", name.unwrap_or("left"));
        }
        Text::Timestamp => {
            let limit_us = 253_402_300_799_000_000;
            let time = vibrissa_protocol::Timestamp(time_us(random, now_us, limit_us));
            let _ = write!(out, "\"{time}\"");
        }
        Text::Free(most) => match random.random_range(0..4) {
            0 => out.push_str(TEXTS.choose(random).copied().unwrap_or(r#""""#)),
            // The longest allowed text, made of characters of four bytes each.
            1 => {
                let _ = write!(out, "\"{}\"", "😀".repeat(most));
            }
            _ => {
                let _ = write!(out, "\"t{}\"", random.random_range(0..1000));
            }
        },
    }
}

/// Appends a number in a form that parses to the same `f64`.
pub fn write_number(value: f64, out: &mut String) {
    let _ = write!(out, "{value:e}");
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::*;

    #[test]
    fn numbers_stay_in_their_range_and_reach_both_ends() {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        for (least, most) in [(5e-324, 1.0), (-1.0, 1.0), (0.0, 1.0), (1e-6, 1000.0), (-100.0, 300.0)] {
            let numbers: Vec<f64> = (0..2000).map(|_| number(&mut random, Range { least, most })).collect();
            assert!(numbers.iter().all(|value| (least..=most).contains(value)), "{least} to {most}");
            assert!(numbers.contains(&least) && numbers.contains(&most), "{least} to {most}");
            assert!(numbers.iter().any(|value| value.abs() < least.max(1e-300) * 1.1), "{least} to {most}");
        }
    }

    #[test]
    fn a_number_is_read_back_to_the_last_bit() {
        let mut random = ChaCha8Rng::seed_from_u64(2);
        for _ in 0..2000 {
            let value = number(&mut random, Range { least: -1000.0, most: 1000.0 });
            let mut out = String::new();
            write_number(value, &mut out);
            assert_eq!(serde_json::from_str::<f64>(&out).unwrap().to_bits(), value.to_bits(), "{out}");
        }
    }

    #[test]
    fn integers_stay_in_their_range() {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        for (least, most) in [(0, 0), (0, 65_535), (0, (1 << 53) - 1), (7, 9), (0, u64::MAX)] {
            assert!((0..1000).all(|_| (least..=most).contains(&integer(&mut random, least, most))));
        }
    }
}
