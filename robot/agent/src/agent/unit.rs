//! The unit of a driver's clock, by comparing its elapsed time with the agent's.

use crate::contract::Moment;

/// Time over which the clocks are compared, in microseconds: a clock that counts seconds changes four times.
const SPAN_US: u64 = 4_000_000;
/// Factor between the elapsed times of two clocks with the same unit; a buffer is emptied at once, or a link is late.
const SAME: f64 = 2.0;
/// Names of units, with their number in a second.
const UNITS: [(&str, f64); 4] = [("seconds", 1.0), ("milliseconds", 1e3), ("microseconds", 1e6), ("nanoseconds", 1e9)];

/// Elapsed time of a driver's clock.
#[derive(Debug, Default)]
pub(super) struct Pace {
    since: Option<(u64, Moment)>,
    /// The unit that it has instead of the right one.
    wrong: Option<&'static str>,
}

impl Pace {
    /// Takes a time of the field `name`, one of whose ticks is so many microseconds; what is wrong with its unit.
    pub(super) fn problem(&mut self, name: &str, right: &str, tick_us: u64, ticks: u64, now: Moment) -> Option<String> {
        match self.since {
            // After a restart of the board, and at the start.
            None => self.since = Some((ticks, now)),
            Some((first, _)) if ticks < first => self.since = Some((ticks, now)),
            Some((first, at)) if now >= at + SPAN_US => {
                let per_s = (ticks - first) as f64 * 1e6 / now.since(at) as f64;
                let right_per_s = 1e6 / tick_us as f64;
                let is_of = |unit: f64| (unit / SAME..=unit * SAME).contains(&per_s);
                let unit = UNITS.iter().find(|(_, unit)| *unit != right_per_s && is_of(*unit));
                // Between the units nothing is known: the verdict stays.
                if unit.is_some() || is_of(right_per_s) {
                    self.wrong = unit.map(|(name, _)| *name);
                }
                self.since = Some((ticks, now));
            }
            Some(_) => {}
        }
        let wrong = self.wrong?;
        Some(format!("{name} advances by {wrong}: is {name} in {right}?"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Problems of a clock with so many ticks a second, sent so many times a second for 20 s.
    fn problems(name: &str, tick_us: u64, per_s: f64, rate: u64) -> Vec<String> {
        let mut pace = Pace::default();
        let problem = |at: u64| {
            let us = at * 1_000_000 / rate;
            let ticks = 5_000 + (us as f64 / 1e6 * per_s) as u64;
            pace.problem(name, "UNIT", tick_us, ticks, Moment::of_us(7_000_000 + us))
        };
        (0..20 * rate).filter_map(problem).collect()
    }

    #[test]
    fn regress_a_clock_of_another_unit_is_recognised_by_its_pace() {
        for rate in [1, 4, 100] {
            for (unit, per_s) in UNITS {
                for (name, tick_us) in [("t_ms", 1_000), ("t_us", 1)] {
                    let problems = problems(name, tick_us, per_s, rate);
                    if (per_s * tick_us as f64 - 1e6).abs() < 1.0 {
                        assert_eq!(problems, [""; 0], "{name} in {unit}");
                        continue;
                    }
                    let expected = format!("{name} advances by {unit}: is {name} in UNIT?");
                    assert!(problems.contains(&expected), "{name} in {unit}, {rate} a second: {problems:?}");
                    assert!(problems.len() as u64 >= 15 * rate, "{name} in {unit}: {}", problems.len());
                }
            }
        }
    }

    #[test]
    fn a_clock_that_runs_a_little_wrong_or_restarts_has_its_unit() {
        for per_s in [700.0, 999.0, 1_001.0, 1_400.0] {
            assert_eq!(problems("t_ms", 1_000, per_s, 10), [""; 0]);
        }
        let mut pace = Pace::default();
        for second in 0..60_u64 {
            let ticks = second % 17 * 1_000;
            assert_eq!(pace.problem("t_ms", "ms", 1_000, ticks, Moment::of_us(second * 1_000_000)), None);
        }
    }
}
