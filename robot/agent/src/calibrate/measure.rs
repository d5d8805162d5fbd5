//! Properties of a gauge and a sensor from their samples: pure, without a driver and a person.

/// A strain is a touch beyond so many standard deviations of the noise, and beyond this strain.
const TOUCH_SDS: f64 = 8.0;
const TOUCH_LEAST: f64 = 5e-5;
/// A touch lasts at least so long, and has ended after so long below this part of its largest strain. s.
const TOUCH_S: f64 = 0.15;
const RELEASED_S: f64 = 0.5;
const RELEASED: f64 = 0.3;
/// A touch goes to both sides if the smaller one is more than this part of the larger one: more than a whisker swings.
const BOTH: f64 = 0.5;
/// An unchanged strain for this long, and in so many samples, is the end of the scale. s.
const FLAT_S: f64 = 0.3;
const FLAT_SAMPLES: u32 = 5;
/// Way of the base during which an unchanged strain is the end of the scale, mm.
const FLAT_MM: f64 = 0.2;

/// A strain with its time of receipt.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sample {
    pub(super) t_s: f64,
    pub(super) strain: f64,
    /// Way of the base at that time.
    pub(super) deflection_mm: Option<f64>,
}

/// A gauge at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rest {
    pub(super) zero: f64,
    /// Standard deviation of the noise.
    pub(super) sd: f64,
    pub(super) rate_hz: f64,
    /// Longest time with one value: that of a coarse converter.
    pub(super) flat_s: f64,
}

impl Rest {
    /// Zero, noise and rate from samples at rest; `None` for fewer than ten.
    pub(super) fn of(samples: &[Sample]) -> Option<Self> {
        let (first, last) = (samples.first()?, samples.last()?);
        if samples.len() < 10 || last.t_s <= first.t_s {
            return None;
        }
        let zero = median(samples.iter().map(|sample| sample.strain));
        // Glitches of a cheap converter leave the median of the deviations alone.
        let sd = 1.4826 * median(samples.iter().map(|sample| (sample.strain - zero).abs()));
        let mean_square =
            samples.iter().map(|sample| (sample.strain - zero).powi(2)).sum::<f64>() / samples.len() as f64;
        let mut run = Run::default();
        samples.iter().for_each(|sample| run.push(sample));
        Some(Self {
            zero,
            sd: if sd > 0.0 { sd } else { mean_square.sqrt() },
            rate_hz: (samples.len() - 1) as f64 / (last.t_s - first.t_s),
            flat_s: run.longest_s,
        })
    }
}

/// The middle one of some values; 0 without any.
pub(super) fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

/// Samples in a row with one value.
#[derive(Debug, Clone, Copy, Default)]
struct Run {
    /// The value, with time and deflection at its begin.
    first: Option<Sample>,
    count: u32,
    longest_s: f64,
}

impl Run {
    fn push(&mut self, sample: &Sample) {
        match self.first {
            Some(first) if first.strain == sample.strain => {
                self.count += 1;
                self.longest_s = self.longest_s.max(sample.t_s - first.t_s);
            }
            Some(_) | None => (self.first, self.count) = (Some(*sample), 1),
        }
    }
}

/// A touch: from its begin until the whisker is free again.
#[derive(Debug)]
pub(super) struct Touch {
    rest: Rest,
    before: Option<Sample>,
    /// Largest deviations upwards and downwards that two samples in a row have.
    up: f64,
    down: f64,
    began_s: Option<f64>,
    is_real: bool,
    released_s: Option<f64>,
    /// Ways of the base at rest before, and at the largest deviation.
    rest_mm: Option<f64>,
    top_mm: Option<f64>,
    run: Run,
    /// The value at which the strain stays while the base moves on, or for long.
    end: Option<f64>,
}

impl Touch {
    pub(super) fn new(rest: Rest) -> Self {
        Self {
            rest,
            before: None,
            up: 0.0,
            down: 0.0,
            began_s: None,
            is_real: false,
            released_s: None,
            rest_mm: None,
            top_mm: None,
            run: Run::default(),
            end: None,
        }
    }

    /// Takes a sample; whether the touch is over.
    pub(super) fn push(&mut self, sample: &Sample) -> bool {
        let off = sample.strain - self.rest.zero;
        let before = self.before.replace(*sample).map_or(0.0, |before| before.strain - self.rest.zero);
        // A single wrong sample of a cheap converter is no extreme.
        let both = if off * before > 0.0 { off.signum() * off.abs().min(before.abs()) } else { 0.0 };
        let largest = self.strain();
        (self.up, self.down) = (self.up.max(both), self.down.max(-both));
        if self.strain() > largest {
            self.top_mm = sample.deflection_mm.or(self.top_mm);
        }
        let is_off = both.abs() > self.threshold();
        if !is_off && self.began_s.is_none() {
            self.rest_mm = sample.deflection_mm.or(self.rest_mm);
        }
        if is_off {
            let began_s = *self.began_s.get_or_insert(sample.t_s);
            self.is_real |= sample.t_s - began_s >= TOUCH_S;
        } else if !self.is_real {
            self.began_s = None;
        }
        self.run.push(sample);
        self.look_for_end(sample, off);
        if !self.is_real || both.abs() > RELEASED * self.strain() {
            self.released_s = None;
            return false;
        }
        sample.t_s - *self.released_s.get_or_insert(sample.t_s) >= RELEASED_S
    }

    fn look_for_end(&mut self, sample: &Sample, off: f64) {
        let Some(first) = self.run.first.filter(|_| self.run.count >= FLAT_SAMPLES) else { return };
        if off.abs() < self.strain() || off.abs() <= self.threshold() {
            return;
        }
        let way_mm = first.deflection_mm.zip(sample.deflection_mm).map(|(from_mm, to_mm)| (to_mm - from_mm).abs());
        let is_flat = self.rest.flat_s < FLAT_S && sample.t_s - first.t_s >= FLAT_S;
        if way_mm.is_some_and(|way_mm| way_mm >= FLAT_MM) || is_flat {
            self.end = Some(sample.strain);
        }
    }

    fn threshold(&self) -> f64 {
        (TOUCH_SDS * self.rest.sd).max(TOUCH_LEAST)
    }

    /// Largest change of the strain.
    pub(super) fn strain(&self) -> f64 {
        self.up.max(self.down)
    }

    /// Whether it lasted long enough to be one.
    pub(super) fn is_real(&self) -> bool {
        self.is_real
    }

    /// 1 if the touch makes the strain larger, -1 if it makes it smaller; `None` if it goes to both sides.
    pub(super) fn sign(&self) -> Option<f64> {
        (self.up.min(self.down) <= BOTH * self.strain()).then(|| (self.up - self.down).signum())
    }

    /// Change of the base's way from rest to the largest strain, mm.
    pub(super) fn way_mm(&self) -> Option<f64> {
        Some(self.top_mm? - self.rest_mm?)
    }

    /// The value of the strain at which the converter ends.
    pub(super) fn end(&self) -> Option<f64> {
        self.end
    }

    /// Whether an unchanged strain tells nothing without a motion: the converter is coarse.
    pub(super) fn is_coarse(&self) -> bool {
        self.rest.flat_s >= FLAT_S && self.way_mm().is_none()
    }
}

/// Difference of the readings of a second of a chamber that stands still, by a fine converter. MPa.
const STILL_MPA: f64 = 0.000_5;
/// The same of two seconds by a coarse one: 0.001 22 MPa is a step of 10 bits at a sensor of 4 V/MPa, and 0.004 9 at one of
/// 1 V/MPa. MPa.
const STILL_COARSE_MPA: f64 = 0.005;

/// Readings of a pressure in a time. MPa.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Level {
    count: usize,
    sum_mpa: f64,
    least_mpa: f64,
    most_mpa: f64,
}

impl Level {
    pub(super) fn of(readings: impl Iterator<Item = f64>) -> Self {
        let none = Self { count: 0, sum_mpa: 0.0, least_mpa: f64::MAX, most_mpa: f64::MIN };
        readings.fold(none, |level, mpa| Self {
            count: level.count + 1,
            sum_mpa: level.sum_mpa + mpa,
            least_mpa: level.least_mpa.min(mpa),
            most_mpa: level.most_mpa.max(mpa),
        })
    }

    pub(super) fn count(self) -> usize {
        self.count
    }

    pub(super) fn mean(self) -> f64 {
        self.sum_mpa / self.count.max(1) as f64
    }

    /// Difference of the largest reading and the smallest one.
    pub(super) fn range(self) -> f64 {
        (self.most_mpa - self.least_mpa).max(0.0)
    }

    /// The level of this second and the one before, if the pressure stands still. The readings of a coarse converter jump by
    /// its step also then: they stand if they have not fallen on average.
    pub(super) fn still_after(self, before: Self) -> Option<Self> {
        let both = Self {
            count: self.count + before.count,
            sum_mpa: self.sum_mpa + before.sum_mpa,
            least_mpa: self.least_mpa.min(before.least_mpa),
            most_mpa: self.most_mpa.max(before.most_mpa),
        };
        let is_level = both.range() < STILL_COARSE_MPA && self.mean() >= before.mean();
        (both.range() < STILL_MPA || is_level).then_some(both)
    }
}

/// First time after `from_s` at which a reading is `by_mpa` or more beyond that of the time; negative for a fall.
pub(super) fn moved_after_s(readings: &[(f64, f64)], from_s: f64, from_mpa: f64, by_mpa: f64) -> Option<f64> {
    let after = readings.iter().filter(|(t_s, _)| *t_s >= from_s);
    let has_moved = |mpa: f64| (mpa - from_mpa) * by_mpa.signum() >= by_mpa.abs();
    after.clone().find(|(_, mpa)| has_moved(*mpa)).map(|(t_s, _)| t_s - from_s)
}

#[cfg(test)]
mod tests {
    use super::*;

    const ZERO: f64 = 1e-3;

    fn noise(at: u64) -> f64 {
        // A sequence without a pattern that matters: -1 to 1.
        ((at * 7919 + at * at * 104_729) % 2_001) as f64 / 1_000.0 - 1.0
    }

    fn rest_of(noise_by: f64) -> Rest {
        let samples: Vec<Sample> = (0..300_u64)
            .map(|at| Sample { t_s: at as f64 * 0.01, strain: ZERO + noise_by * noise(at), deflection_mm: None })
            .collect();
        Rest::of(&samples).unwrap()
    }

    /// A touch of 1.5 s with this largest change, and an end of the converter.
    fn touched(change: f64, back: f64, end: f64, mm_per_strain: Option<f64>) -> Touch {
        let mut touch = Touch::new(rest_of(1e-5));
        for at in 0..400_u64 {
            let t_s = at as f64 * 0.01;
            let shape = if t_s < 1.0 { 0.0 } else { ((t_s - 1.0) / 0.4).min((2.5 - t_s) / 0.4).clamp(0.0, 1.0) };
            let swing = if (2.5..2.53).contains(&t_s) { back } else { 0.0 };
            let strain = ZERO + change * shape - swing + 1e-5 * noise(at);
            let strain = if change > 0.0 { strain.min(end) } else { strain.max(end) };
            let deflection_mm = mm_per_strain.map(|mm| 20.0 + mm * change.abs() * shape);
            if touch.push(&Sample { t_s, strain, deflection_mm }) {
                assert!(t_s > 2.5, "it ends after the release, and not at {t_s} s");
                return touch;
            }
        }
        panic!("it never ends: {touch:?}");
    }

    /// It was never taken back: the supervisor limited every compensation by a gauge that was good again.
    #[test]
    fn regress_a_good_gauge_loses_the_smaller_end_of_an_earlier_calibration() {
        let touch = touched(0.006, 0.0, 1.0, Some(300.0));
        let change = |strain_max| crate::calibrate::gauge::scale_of(&touch, &rest_of(1e-5), 0.5, strain_max).change;
        assert_eq!(change(Some(0.004)), Some(("strain_max".to_owned(), String::new())));
        assert_eq!(change(Some(0.012)), None);
        assert_eq!(change(None), None);
    }

    #[test]
    fn rest_has_a_zero_a_noise_and_a_rate_in_spite_of_glitches() {
        let rest = rest_of(1e-5);
        assert!((rest.zero - ZERO).abs() < 2e-6 && (rest.rate_hz - 100.0).abs() < 0.1, "{rest:?}");
        // A uniform distribution from -1 to 1 has a median deviation of 0.5.
        assert!((rest.sd / 1e-5 - 0.74).abs() < 0.1, "{rest:?}");
        let glitched: Vec<Sample> = (0..300_u64)
            .map(|at| {
                let strain = if at % 50 == 7 { 0.2 } else { ZERO + 1e-5 * noise(at) };
                Sample { t_s: at as f64 * 0.01, strain, deflection_mm: None }
            })
            .collect();
        let again = Rest::of(&glitched).unwrap();
        assert!((again.sd / rest.sd - 1.0).abs() < 0.1, "{again:?}");
        assert_eq!(Rest::of(&glitched[..9]), None);
    }

    #[test]
    fn a_touch_has_the_sign_of_its_strain_and_a_swing_is_not_both() {
        for (change, sign) in [(0.005, 1.0), (-0.005, -1.0)] {
            let touch = touched(change, 0.2 * change, 1.0 * change.signum(), None);
            assert_eq!((touch.sign(), touch.end(), touch.way_mm()), (Some(sign), None, None));
            assert!((touch.strain() - 0.005).abs() < 5e-5, "{touch:?}");
        }
        assert_eq!(touched(0.005, 0.004, 1.0, None).sign(), None, "to both sides");
        assert!(touched(0.005, 0.0, 1.0, Some(1_000.0)).way_mm().is_some_and(|mm| (mm - 5.0).abs() < 0.2));
        assert!(touched(0.005, 0.0, 1.0, Some(-1_000.0)).way_mm().is_some_and(|mm| (mm + 5.0).abs() < 0.2));
    }

    #[test]
    fn the_end_of_a_converter_is_seen_in_a_strain_that_stays() {
        for mm_per_strain in [None, Some(1_000.0)] {
            let touch = touched(0.005, 0.0, ZERO + 0.003, mm_per_strain);
            assert_eq!(touch.end(), Some(ZERO + 0.003), "{mm_per_strain:?}");
            assert_eq!(touched(0.005, 0.0, 1.0, mm_per_strain).end(), None);
        }
    }

    /// A second of four readings by a converter with this step, whose input has a noise of half a step.
    fn second(mpa: impl Fn(f64) -> f64, step_mpa: f64, at: u64) -> Level {
        Level::of((4 * at..4 * at + 4).map(|at| {
            let input_mpa = mpa(at as f64 / 4.0) + 0.5 * step_mpa * noise(at);
            ((input_mpa / step_mpa).floor() + 0.5) * step_mpa
        }))
    }

    /// First second of 20 at which a chamber with this pressure stands still.
    fn stands_after(mpa: impl Fn(f64) -> f64 + Copy, step_mpa: f64) -> Option<u64> {
        (1..20).find(|&at| second(mpa, step_mpa, at).still_after(second(mpa, step_mpa, at - 1)).is_some())
    }

    /// A reading that jumps by one step was never still, so that an empty chamber counted as one that does not empty.
    #[test]
    fn regress_an_empty_chamber_stands_still_although_its_converter_is_coarse() {
        for step_mpa in [0.000_01, 0.000_3, 0.001_22, 0.002_4] {
            for offset in 0..20 {
                let rest_mpa = step_mpa * f64::from(offset) / 20.0;
                let after_s = stands_after(|_| rest_mpa, step_mpa);
                assert!(after_s.is_some(), "{step_mpa} MPa, {offset}");
            }
            for time_s in [0.5, 1.0, 2.0] {
                let falls = |t_s: f64| 0.1 * (-t_s / time_s).exp();
                let after_s = stands_after(falls, step_mpa).unwrap();
                let left_mpa = falls(after_s as f64);
                assert!(left_mpa < 0.001 + 2.0 * step_mpa, "{step_mpa} MPa, {time_s} s: {left_mpa} MPa");
            }
        }
    }

    #[test]
    fn the_time_of_a_move_counts_from_the_pulse() {
        let readings = [(0.9, 0.0), (1.1, 0.0001), (1.2, 0.002), (1.3, 0.004)];
        assert!(moved_after_s(&readings, 1.0, 0.0, 0.001).is_some_and(|s| (s - 0.2).abs() < 1e-9));
        assert_eq!(moved_after_s(&readings, 1.0, 0.0, 0.01), None);
        assert!(moved_after_s(&[(2.0, 0.003)], 1.0, 0.01, -0.005).is_some());
    }
}
