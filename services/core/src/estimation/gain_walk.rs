//! How fast a whisker's gain wanders: a random walk of log sensitivity with a learned rate.
//!
//! Rubber ages, gauges settle, and a robot's own calibration drifts. A filter that takes the gain for constant calls such
//! a wandering a cut, and one that takes it for wandering loses small cuts. So for each of a few rates a scalar filter
//! follows the gain (multiple models: Magill, IEEE Trans. Automat. Contr. 10 (1965) 434). It does not repeat the length
//! filter: it keeps the deviation of its own prediction from the length filter's, and the log likelihood of the contacts
//! relative to it. With the length filter's state variance s and its noise R for a contact, both in log sensitivity, a
//! rate's variance is s + e. The contact reduces it to (s + e) R / (s + e + R), and s to s R / (s + R); the difference
//! and the walk's own variance are the next e.
//!
//! The log likelihoods have two uses. A suspected change is compared with the wandering that would explain the same
//! contacts ([`crate::detection`]). And while nothing is suspected, the length filter takes the likeliest rate.

use borsh::{BorshDeserialize, BorshSerialize};

use super::innovation::Innovation;

/// Random walks, log sensitivity per square root of a contact: none, and 1.4, 3.5 and 8.5 % in 5,000 contacts.
const RATES: [f64; COUNT] = [0.0, 2e-4, 5e-4, 1.2e-3];
const COUNT: usize = 4;
/// Log likelihood by which another rate must lead before the filter takes it.
const TAKEN_FROM: f64 = 3.0;
/// ... and by which it must lead the likeliest change.
const LEADS_CHANGE: f64 = 1.0;
/// Log of the prior odds of a faster walk.
const FASTER: f64 = -3.0;
/// Bounds of the log likelihoods. The lower one bounds the memory: a whisker may begin to age.
const LOG_RATIO_MIN_MAX: (f64, f64) = (-6.0, 1000.0);
/// Least share of the filter's own variance that a slower walk leaves.
const VARIANCE_LEAST: f64 = 0.1;
/// Least probability that a contact is not an outlier, as in the length filter.
const LEAST_SOUND: f64 = 1e-3;

/// Walks of the gain, compared with the one that the length filter takes.
#[derive(Debug, Clone, Copy, PartialEq, Default, BorshSerialize, BorshDeserialize)]
pub struct GainWalks {
    /// Index of the rate that the length filter takes.
    taken: u8,
    /// Expected deviation from the length filter's prediction, log sensitivity.
    beyond: [f32; COUNT],
    /// Variance in addition to the length filter's.
    variance: [f32; COUNT],
    /// Log likelihood of the contacts relative to the length filter's.
    log_ratio: [f32; COUNT],
    /// The same when nothing was suspected last.
    calm: [f32; COUNT],
}

/// Evidence that the gain wanders, and the whisker has not changed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wandering {
    /// Log likelihood that the likeliest other walk gains over the one that the filter takes, less its prior odds.
    pub log_ratio: f64,
}

/// Uncertainty of the gain after the contacts so far.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GainDoubt {
    /// Expected deviation of the gain from the length filter's, log sensitivity.
    pub by: f64,
    /// Its variance beside the length filter's own.
    pub variance: f64,
    /// Root of the mean square of the random walks, log sensitivity per square root of a contact.
    pub rate: f64,
}

/// Change of the length filter's offset with another rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moved {
    /// Change of the offset, log sensitivity.
    pub by: f64,
    /// Added variance of the offset, squared log sensitivity.
    pub variance: f64,
}

impl GainWalks {
    /// Random walk that the length filter takes, log sensitivity per square root of a contact.
    #[must_use]
    pub fn rate(&self) -> f64 {
        RATES[usize::from(self.taken) % COUNT]
    }

    /// Uncertainty of the gain, over all walks: its deviation from the length filter's, and its rate.
    #[must_use]
    pub fn doubt(&self) -> GainDoubt {
        let odds = |index: usize| if index > usize::from(self.taken) { FASTER } else { 0.0 };
        let log: [f64; COUNT] = std::array::from_fn(|index| f64::from(self.log_ratio[index]) + odds(index));
        let most = log.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let weights = log.map(|log| (log - most).exp());
        let all: f64 = weights.iter().sum();
        let mean_of = |of: &dyn Fn(usize) -> f64| (0..COUNT).map(|index| weights[index] / all * of(index)).sum::<f64>();
        let by = mean_of(&|index| self.beyond[index].into());
        let variance =
            mean_of(&|index| f64::from(self.variance[index]) + (f64::from(self.beyond[index]) - by).powi(2)).max(0.0);
        GainDoubt { by, variance, rate: mean_of(&|index| RATES[index].powi(2)).sqrt() }
    }

    /// Rate of the walks that contacts speak for, log sensitivity per square root of a contact: 0 before any do.
    #[must_use]
    pub fn shown_rate(&self) -> f64 {
        let taken = usize::from(self.taken) % COUNT;
        let weight = |index: usize| match f64::from(self.log_ratio[index]) {
            _ if index == taken => 1.0,
            ratio if ratio > 0.0 => (ratio + if index > taken { FASTER } else { 0.0 }).exp(),
            _ => 0.0,
        };
        let weights: [f64; COUNT] = std::array::from_fn(weight);
        let squares = (0..COUNT).map(|index| weights[index] * RATES[index].powi(2));
        (squares.sum::<f64>() / weights.iter().sum::<f64>()).sqrt()
    }

    /// Compares a contact with each walk, before the length filter learns from it.
    pub fn see(&mut self, seen: &Innovation) {
        let noise = seen.noise_variance;
        let state = seen.variance - noise;
        let own_noise = noise / seen.seen.sound.max(LEAST_SOUND);
        let own_gain = state / (state + own_noise);
        let rate = self.rate();
        for index in (0..COUNT).filter(|&index| index != usize::from(self.taken)) {
            let beyond = f64::from(self.beyond[index]);
            let extra = f64::from(self.variance[index]).max((VARIANCE_LEAST - 1.0) * state);
            let residual = seen.residual - beyond;
            let variance = seen.variance + extra;
            let here = seen.density.at(residual / variance.sqrt());
            let log_ratio = (here.density / seen.seen.density).ln() - 0.5 * (variance / seen.variance).ln();
            let after = f64::from(self.log_ratio[index]) + log_ratio;
            self.log_ratio[index] = after.clamp(LOG_RATIO_MIN_MAX.0, LOG_RATIO_MIN_MAX.1) as f32;
            let noise_here = noise / here.sound.max(LEAST_SOUND);
            let all = state + extra;
            let gain = all / (all + noise_here);
            self.beyond[index] = (beyond + gain * residual - own_gain * seen.residual) as f32;
            let left = gain * noise_here - own_gain * own_noise;
            self.variance[index] = (left + RATES[index].powi(2) - rate.powi(2)) as f32;
        }
    }

    /// Evidence that the gain wanders.
    #[must_use]
    pub fn evidence(&self) -> Wandering {
        Wandering { log_ratio: self.likeliest().1 }
    }

    fn likeliest(&self) -> (usize, f64) {
        let odds = |index: usize| if index > usize::from(self.taken) { FASTER } else { 0.0 };
        let others = (0..COUNT).filter(|&index| index != usize::from(self.taken));
        let gains = others.map(|index| (index, f64::from(self.log_ratio[index]) + odds(index)));
        gains.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or_default()
    }

    /// No change is suspected. Returns the move to another rate if it is clearly likelier than the present one and than
    /// any change, whose largest log likelihood ratio is `by_change`. What the contacts have told so far stays if the
    /// detector is calm.
    #[must_use]
    pub fn quiet(&mut self, calm: bool, by_change: f64) -> Option<Moved> {
        if calm {
            self.calm = self.log_ratio;
        }
        let (index, gain) = self.likeliest();
        (gain > TAKEN_FROM && gain > by_change + LEADS_CHANGE).then(|| self.take(index))
    }

    /// A suspected change was a wandering: its rate is taken.
    #[must_use]
    pub fn wandered(&mut self) -> Moved {
        let (index, _) = self.likeliest();
        let moved = self.take(index);
        self.calm = self.log_ratio;
        moved
    }

    /// A change was confirmed: its contacts tell nothing about a wandering.
    pub fn changed(&mut self) {
        self.log_ratio = self.calm;
        self.beyond = [0.0; COUNT];
    }

    fn take(&mut self, index: usize) -> Moved {
        let moved = Moved { by: self.beyond[index].into(), variance: f64::from(self.variance[index]).max(0.0) };
        let (beyond, variance, log_ratio) = (self.beyond[index], self.variance[index], self.log_ratio[index]);
        self.beyond.iter_mut().for_each(|one| *one -= beyond);
        self.variance.iter_mut().for_each(|one| *one -= variance);
        self.log_ratio.iter_mut().for_each(|one| *one -= log_ratio);
        self.taken = index as u8;
        self.calm = self.log_ratio;
        moved
    }

    /// Whether all numbers are finite and in range.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        let all = [self.beyond, self.variance, self.log_ratio, self.calm];
        usize::from(self.taken) < COUNT && all.iter().flatten().all(|one| one.is_finite())
    }
}
