//! Reach: the distances from the base at which a whisker is touched.
//!
//! A cut whisker feels no contact beyond its tip. Silence there is evidence of a cut, as far as such contacts were common
//! before. Robots change their habits, so silence alone is a suspicion and no proof.
//!
//! For each of some lost lengths, `within` is the mean probability that a contact lies below the shortened tip. A contact
//! with the probability p of lying there has the likelihood ratio p / `within` for that cut against no change. The mean
//! of this ratio is 1 while the distances have any steady distribution, so the Shiryaev-Roberts statistic over all
//! starts, averaged over the lost lengths, reaches A on average at most once in A contacts. The mean is estimated before
//! each contact from the contacts so far (a prequential forecast, Dawid, J. R. Stat. Soc. A 147 (1984) 278).

use borsh::{BorshDeserialize, BorshSerialize};

/// Number of lost lengths.
const CUTS: usize = 16;
/// Lost lengths, as parts of the whole length: 0.5 to 24 mm of 70 mm, closer where a cut is small.
const LOST: [f32; CUTS] = {
    const OF_70_MM: [f32; CUTS] =
        [0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0, 12.0, 14.0, 16.0, 20.0, 24.0];
    let mut lost = [0.0; CUTS];
    let mut index = 0;
    while index < CUTS {
        lost[index] = OF_70_MM[index] / 70.0;
        index += 1;
    }
    lost
};
/// Contacts before the first likelihood ratio.
const LEAST_CONTACTS: f32 = 100.0;
/// Contacts over which habits are averaged: several times those that silence beyond a cut of 1 mm takes.
const MEMORY_CONTACTS: f32 = 3000.0;
/// Least probability that a contact lies below a shortened tip, so that one wrong distance cannot end a suspicion.
const LEAST_WITHIN: f32 = 1e-3;
/// Largest statistic; far above any threshold.
const SHIRYAEV_MAX: f32 = 1e15;
/// A suspicion is over when the statistic has fallen to this.
const OVER: f32 = 1.0;
/// Silence is proof of a lost reach, unless habits have changed, when the statistic exceeds the threshold of a suspicion
/// by this factor: once in a billion contacts with the threshold of 100,000.
const LOST_FACTOR: f64 = 1e4;

/// The reach of one whisker.
#[derive(Debug, Clone, PartialEq, BorshSerialize, BorshDeserialize)]
pub struct Reach {
    /// Length of the whisker while it is learned, mm.
    length_mm: f32,
    contacts: f32,
    /// Sums of the probabilities that a contact lies below each shortened tip.
    within: [f32; CUTS],
    shiryaev: [f32; CUTS],
    is_silent: bool,
    is_lost: bool,
}

crate::optional_parts::optional_fields!(Reach: length_mm, contacts, within, shiryaev;
    is_silent: *is_silent,
    is_lost: *is_lost,
);

impl Reach {
    /// Nothing is known of the contacts of a whisker of this length, mm.
    #[must_use]
    pub fn new(length_mm: f64) -> Self {
        let length_mm = length_mm as f32;
        Self { length_mm, contacts: 0.0, within: [0.0; CUTS], shiryaev: [0.0; CUTS], is_silent: false, is_lost: false }
    }

    /// Adds a contact at a distance from the base with its standard deviation, both in mm.
    /// `contacts_between_false_alarms` is the statistic from which silence is suspicious.
    pub fn follow(&mut self, distance_mm: f64, sd_mm: f64, contacts_between_false_alarms: f64) {
        let (distance_mm, sd_mm) = (distance_mm as f32, (sd_mm as f32).max(1e-3 * self.length_mm));
        let is_learned = self.contacts >= LEAST_CONTACTS;
        let learned = self.contacts + 1.0;
        for ((within, shiryaev), lost) in self.within.iter_mut().zip(&mut self.shiryaev).zip(LOST) {
            let tip_mm = self.length_mm * (1.0 - lost);
            // A straight line instead of the normal distribution: its sums need not be exact, only the same ones.
            let is_within = (0.5 + (tip_mm - distance_mm) / (4.0 * sd_mm)).clamp(LEAST_WITHIN, 1.0);
            if is_learned {
                let forecast = (*within + 1.0) / learned;
                *shiryaev = ((1.0 + *shiryaev) * is_within / forecast).min(SHIRYAEV_MAX);
            }
            *within += is_within;
        }
        self.contacts = learned;
        if self.contacts > MEMORY_CONTACTS {
            let kept = MEMORY_CONTACTS / self.contacts;
            self.within.iter_mut().for_each(|sum| *sum *= kept);
            self.contacts = MEMORY_CONTACTS;
        }
        let statistic = self.statistic();
        self.is_silent =
            if self.is_silent { statistic > OVER } else { f64::from(statistic) >= contacts_between_false_alarms };
        let is_beyond_doubt = f64::from(statistic) >= LOST_FACTOR * contacts_between_false_alarms;
        self.is_lost = self.is_silent && (self.is_lost || is_beyond_doubt);
    }

    fn statistic(&self) -> f32 {
        self.shiryaev.iter().sum::<f32>() / CUTS as f32
    }

    /// Whether contacts near the tip have failed to come for suspiciously long.
    #[must_use]
    pub fn is_silent(&self) -> bool {
        self.is_silent
    }

    /// Whether they have failed to come for so long that chance does not explain it.
    #[must_use]
    pub fn is_lost(&self) -> bool {
        self.is_lost
    }

    /// Length at which the reach is learned, mm.
    #[must_use]
    pub fn length_mm(&self) -> f64 {
        self.length_mm.into()
    }

    /// The shortest length, mm, that the silence makes likely: shorter ones have 5 % of the statistic.
    #[must_use]
    pub fn shortest_mm(&self) -> f64 {
        let all: f32 = self.shiryaev.iter().sum();
        let mut sum = 0.0;
        let likely = self.shiryaev.iter().zip(LOST).rev().find(|(one, _)| {
            sum += **one;
            sum >= 0.05 * all
        });
        f64::from(self.length_mm) * (1.0 - likely.map_or(0.0, |(_, lost)| f64::from(lost)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Evenly spread numbers in 0..1 without randomness: the golden ratio's multiples.
    fn even(index: u32) -> f64 {
        (f64::from(index) * 0.618_033_988_749_894_9).fract()
    }

    fn contacts_until_silent(cut_mm: f64) -> Option<u32> {
        let mut reach = Reach::new(70.0);
        let mut index = 0;
        let mut next = |most_mm: f64| loop {
            index += 1;
            let distance_mm = 35.0 + 35.0 * even(index);
            if distance_mm <= most_mm {
                return distance_mm;
            }
        };
        for _ in 0..2000 {
            reach.follow(next(70.0), 0.3, 1e5);
            assert!(!reach.is_silent());
        }
        (1..1000).find(|_| {
            reach.follow(next(70.0 - cut_mm), 0.3, 1e5);
            reach.is_silent()
        })
    }

    #[test]
    fn silence_beyond_a_cut_is_suspicious_in_about_the_time_of_an_oracle() {
        // ln(1e5) / -ln(1 - cut / 35): 397, 196, 75, 34 and 19 contacts, for even distances over half the whisker.
        for (cut_mm, oracle) in [(1.0, 397), (2.0, 196), (5.0, 75), (10.0, 34), (16.0, 19)] {
            let contacts = contacts_until_silent(cut_mm).unwrap();
            assert!(f64::from(contacts) <= 1.25 * f64::from(oracle), "{cut_mm} mm: {contacts}");
        }
    }

    #[test]
    fn a_contact_near_the_tip_ends_the_suspicion() {
        let mut reach = Reach::new(70.0);
        for index in 0..1000 {
            reach.follow(35.0 + 35.0 * even(index), 0.3, 1e5);
        }
        for _ in 0..60 {
            reach.follow(50.0, 0.3, 1e5);
        }
        assert!(reach.is_silent());
        assert!(reach.shortest_mm() > 46.0 && reach.shortest_mm() < 60.0, "{}", reach.shortest_mm());
        for _ in 0..20 {
            reach.follow(69.5, 0.3, 1e5);
        }
        assert!(!reach.is_silent());
    }
}
