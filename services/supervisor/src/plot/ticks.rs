//! Axis ticks: round numbers, and round times in UTC.

use vibrissa_store::time::Time;

/// Position and label of a tick.
pub(crate) type Tick = (f64, String);

/// Round numbers within a range, about `count` at most.
pub(crate) fn numbers(low: f64, high: f64, count: u8) -> Vec<Tick> {
    let raw = (high - low) / f64::from(count);
    let power = 10_f64.powf(raw.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].into_iter().map(|one| one * power).find(|&step| step >= raw * 0.999);
    let step = step.unwrap_or(raw);
    let decimals = (-step.log10().floor()).max(0.0) as usize;
    let first = (low / step - 1e-9).ceil() as i64;
    let last = (high / step + 1e-9).floor() as i64;
    (first..=last).take(20).map(|index| (index as f64 * step, format!("{:.decimals$}", index as f64 * step))).collect()
}

const STEPS_S: [i64; 23] = [
    1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 10_800, 21_600, 43_200, 86_400, 172_800, 432_000,
    864_000, 1_728_000, 8_640_000,
];

/// About four round times within a range, in microseconds since 1970, and the name of the axis.
pub(crate) fn times(low_us: i64, high_us: i64) -> (Vec<Tick>, String) {
    let span_s = ((high_us - low_us) / 1_000_000).max(1);
    let step_s = STEPS_S.into_iter().find(|&step| step * 4 >= span_s).unwrap_or(span_s);
    let step_us = step_s * 1_000_000;
    let part = if step_s < 60 {
        11..19
    } else if step_s < 86_400 {
        11..16
    } else {
        5..10
    };
    let label = |us: i64| Time(us).to_string().get(part.clone()).unwrap_or_default().to_owned();
    let first = low_us.div_euclid(step_us) + 1;
    let ticks = (first..).map(|index| index * step_us).take_while(|&us| us <= high_us).take(8);
    let ticks = ticks.map(|us| (us as f64, label(us))).collect();
    let day = |us: i64| Time(us).to_string().get(..10).unwrap_or_default().to_owned();
    let (from, to) = (day(low_us), day(high_us));
    let days = if from == to { from } else { format!("{from} to {to}") };
    (ticks, format!("time, UTC, {days}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_round_and_within() {
        let labels = |low, high| numbers(low, high, 6).into_iter().map(|tick| tick.1).collect::<Vec<_>>();
        assert_eq!(labels(0.0, 1.0), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(labels(64.3, 70.2), ["65", "66", "67", "68", "69", "70"]);
        assert_eq!(labels(0.045, 0.1), ["0.05", "0.06", "0.07", "0.08", "0.09", "0.10"]);
    }

    #[test]
    fn times_are_round_and_within() {
        let start_us = 1_795_248_003_000_000;
        let (ticks, name) = times(start_us, start_us + 60_000_000);
        assert_eq!(
            ticks.iter().map(|tick| tick.1.as_str()).collect::<Vec<_>>(),
            ["08:00:15", "08:00:30", "08:00:45", "08:01:00"]
        );
        assert_eq!(name, "time, UTC, 2026-11-21");
    }
}
