//! Lines through long series in bounded memory.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use vibrissa_core::estimation::Trend;
use vibrissa_core::estimation::trend::BLOCKS;

/// A line with errors of unit variance of which each keeps this part of the one before.
fn series(rng: &mut ChaCha8Rng, per_x: f64, keep: f64, count: u32) -> Vec<(f64, f64)> {
    let mut error: f64 = StandardNormal.sample(rng);
    let mut next = |x: u32| {
        let fresh: f64 = StandardNormal.sample(rng);
        error = keep * error + (1.0 - keep * keep).sqrt() * fresh;
        (f64::from(x), 7.0 + per_x * f64::from(x) + error)
    };
    (0..count).map(&mut next).collect()
}

fn trend(series: &[(f64, f64)], readings_per_block_max: u32) -> Trend {
    let mut trend = Trend::new(readings_per_block_max);
    series.iter().for_each(|&(x, y)| trend.add(x, y));
    trend
}

#[test]
fn brute_force_few_readings_give_the_slope_of_least_squares() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let series = series(&mut rng, 0.3, 0.0, BLOCKS as u32);
    let count = series.len() as f64;
    let (x, y) = (series.iter().map(|p| p.0).sum::<f64>() / count, series.iter().map(|p| p.1).sum::<f64>() / count);
    let squares: f64 = series.iter().map(|p| (p.0 - x).powi(2)).sum();
    let expected = series.iter().map(|p| (p.0 - x) * (p.1 - y)).sum::<f64>() / squares;
    let slope = trend(&series, u32::MAX / 2).slope().unwrap();
    // Blocks have single precision.
    assert!((slope.per_x - expected).abs() < 1e-6 && (slope.weight / squares - 1.0).abs() < 1e-6);
}

#[test]
fn property_intervals_cover_the_slope_whether_errors_hang_together_or_not() {
    const SERIES: u32 = 400;
    for keep in [0.0, 0.5, 0.9, 0.97] {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let covered = (0..SERIES).filter(|_| {
            let (per_x, count) = (rng.random_range(-0.01..=0.01), rng.random_range(700..=3000));
            let interval =
                trend(&series(&mut rng, per_x, keep, count), u32::MAX / 2).slope().unwrap().interval().unwrap();
            (interval.low..=interval.high).contains(&per_x)
        });
        let part = covered.count() as f64 / f64::from(SERIES);
        println!("{keep}: {part}");
        assert!(part >= 0.92, "errors that keep {keep}: {part} covered");
    }
}

#[test]
fn property_what_is_long_ago_is_forgotten() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let before = series(&mut rng, 0.0, 0.0, 5000);
    let after = series(&mut rng, 0.05, 0.0, 2000);
    let then: Vec<(f64, f64)> = before.into_iter().chain(after.iter().map(|(x, y)| (5000.0 + x, *y))).collect();
    let interval = trend(&then, 64).slope().unwrap().interval().unwrap();
    assert!(interval.low < 0.05 && 0.05 < interval.high && interval.low > 0.04, "{interval:?}");
    assert!(trend(&then, 64).readings() <= 64 * BLOCKS as u32);
}

#[test]
fn a_slope_needs_two_readings_and_an_interval_three() {
    assert!(trend(&[(1.0, 1.0)], 8).slope().is_none());
    assert!(trend(&[(1.0, 1.0), (2.0, 3.0)], 8).slope().unwrap().interval().is_none());
    assert!(trend(&[(1.0, 1.0), (2.0, 3.0), (3.0, 4.0)], 8).slope().unwrap().interval().is_some());
}
