//! Uncertainty of the log sensitivity of one contact.

use borsh::io::{Read, Result};
use borsh::{BorshDeserialize, BorshSerialize};

use super::outlier::InnovationDensity;

/// Configured noise of a robot's readings, as standard deviations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorNoise {
    /// Strain noise, relative to the reading.
    pub strain_relative: f64,
    /// Strain noise floor, absolute, m/m.
    pub strain_floor: f64,
    /// Deflection noise, relative to the reading.
    pub deflection_relative: f64,
    /// Contact ratio noise, absolute.
    pub ratio: f64,
}

impl Default for SensorNoise {
    fn default() -> Self {
        Self { strain_relative: 0.02, strain_floor: 5e-6, deflection_relative: 0.01, ratio: 0.01 }
    }
}

impl SensorNoise {
    /// Variance of ln(strain / deflection) minus its prediction, to first order.
    ///
    /// `expected_strain` is the model's, because with the measured strain small readings would get a large weight. The
    /// error of the contact's place is not part of it.
    #[must_use]
    pub fn log_variance(&self, expected_strain: f64) -> f64 {
        let floor = self.strain_floor / expected_strain;
        self.strain_relative.powi(2) + floor.powi(2) + self.deflection_relative.powi(2)
    }

    /// Least strain whose logarithm is still nearly Gaussian: ten times the floor.
    #[must_use]
    pub fn least_strain(&self) -> f64 {
        10.0 * self.strain_floor
    }
}

/// Learned ratio between a whisker's true noise variance and the configured one, with the share of outliers and the
/// correlation of the noise from contact to contact.
///
/// Averages squared standardised innovations, each weighted by its probability of not being an outlier. The
/// configured noise counts as [`NoiseScale::PRIOR_CONTACTS`] contacts, the past as at most
/// [`NoiseScale::MEMORY_CONTACTS`].
///
/// Creep, loop and history make noise that lasts for some contacts. The mean of n such contacts has the variance of n / c
/// independent ones, c being one plus twice the sum of the correlations: the inflation. Filter and detector take
/// each contact for one of c times its variance. That holds for means over more contacts than the noise lasts, whatever
/// its kind, and asks for no model of it.
#[derive(Debug, Clone, Copy, PartialEq, BorshSerialize, BorshDeserialize)]
pub struct NoiseScale {
    variance: f32,
    contacts: f32,
    outliers: f32,
    /// Sum of the earlier innovations, each weighted by [`LASTS`] to the power of its age.
    earlier: f32,
    /// Mean product of an innovation and that sum.
    together: f32,
    /// Sum of the products since the detector was calm, and their number.
    doubtful: f32,
    doubtful_contacts: f32,
    /// Error of a deflection or strain that does not grow with it, as mm of deflection: a loop of the rubber, play.
    play_mm: f32,
    /// Contacts from which it was learned.
    play_contacts: f32,
}

/// Play of a new whisker, and its range, mm. Its factor of growth is bounded, so that it must not become tiny.
const PLAY_AT_FIRST_MM: f32 = 0.02;
const PLAY_MIN_MAX_MM: (f64, f64) = (0.003, 1.0);
/// Share of outliers of a new whisker, and the number of contacts that it counts as.
const OUTLIERS_AT_FIRST: f64 = 0.005;
const OUTLIERS_PRIOR_CONTACTS: f64 = 200.0;
/// A usual deflection, mm.
const USUAL_MM: f64 = 3.0;
/// Range of the share of outliers.
const OUTLIERS_MIN_MAX: (f64, f64) = (InnovationDensity::OUTLIERS_MIN, 0.1);
/// Contacts in which the scale is learned before the correlation: it would be that of another scale.
const SCALE_FIRST_CONTACTS: f64 = 30.0;
/// Number of contacts that independence counts as.
const INDEPENDENT_CONTACTS: f64 = 30.0;
/// Weight of a contact relative to the one after it, in the sum of earlier innovations.
const LASTS: f64 = 0.9;
/// The weights leave out part of the correlation: a third of one of 0.8 to the power of the age.
const LEFT_OUT: f64 = 1.3;
/// The inflation is taken smaller by this many standard deviations of its estimate, so that chance seldom costs
/// sensitivity.
const DOUBT_SD: f64 = 1.0;
/// Largest inflation: that of a correlation of 0.9.
const INFLATION_MAX: f64 = 19.0;
/// An innovation counts as at most this many standard deviations: outliers are independent.
const LARGEST_SD: f64 = 3.0;

impl Default for NoiseScale {
    fn default() -> Self {
        Self {
            variance: 1.0,
            contacts: Self::PRIOR_CONTACTS as f32,
            outliers: OUTLIERS_AT_FIRST as f32,
            earlier: 0.0,
            together: 0.0,
            doubtful: 0.0,
            doubtful_contacts: 0.0,
            play_mm: PLAY_AT_FIRST_MM,
            play_contacts: Self::PRIOR_CONTACTS as f32,
        }
    }
}

impl NoiseScale {
    /// Weight of the configured noise at the start, in contacts.
    pub const PRIOR_CONTACTS: f64 = 6.0;
    /// Largest weight of the past, in contacts.
    pub const MEMORY_CONTACTS: f64 = 4000.0;
    /// Noise from which a whisker counts as unsteady, as a multiple of the variance that its robot states. Creep, loops and
    /// habits make such noise, and they also add up to slow changes and to steps that are no change of the whisker. Independent
    /// noise as stated gives 0.9 to 1.1, strong correlated noise 1.2 to 4, all nuisances together 2.9 to 16.
    pub const UNSTEADY_MIN: f64 = 2.5;
    /// Inflation by correlation from which noise counts as lasting. Without this condition the mix gives 0.05 false trims, but
    /// whiskers with independent noise of more than their robot states pay for it: 2 mm take 211 contacts instead of 82. One in
    /// six of them is above this value by chance.
    const LASTING_INFLATION_MIN: f64 = 1.05;

    /// Factor on the configured variance, dimensionless, between 1/16 and 16.
    #[must_use]
    pub fn variance(&self) -> f64 {
        f64::from(self.variance)
    }

    /// Variance of the noise of one contact in log sensitivity, and the share of it by `play_mm`. `configured` is the
    /// configured variance.
    #[must_use]
    pub fn of_contact(&self, configured: f64, deflection_mm: f64) -> (f64, f64) {
        let by_play = (f64::from(self.play_mm) / deflection_mm).powi(2);
        let variance = self.variance() * configured + by_play;
        (variance, by_play / variance)
    }

    /// Variance of a mean of contacts at a usual deflection, as a multiple of the configured one.
    #[must_use]
    pub fn of_mean(&self, noise: &SensorNoise) -> f64 {
        let configured = noise.strain_relative.powi(2) + noise.deflection_relative.powi(2);
        self.inflation() * self.of_contact(configured, USUAL_MM).0 / configured
    }

    /// Whether the whisker is unsteady, and its noise lasts from contact to contact.
    #[must_use]
    pub fn is_lasting(&self, noise: &SensorNoise) -> bool {
        self.of_mean(noise) > Self::UNSTEADY_MIN && self.inflation() > Self::LASTING_INFLATION_MIN
    }

    /// Density of an innovation standardised with this scale.
    #[must_use]
    pub fn density(&self) -> InnovationDensity {
        InnovationDensity::learned_from(f64::from(self.contacts), f64::from(self.outliers))
    }

    /// Factor on the variance of a contact that makes up for the correlation between contacts, between 1 and 19.
    #[must_use]
    pub fn inflation(&self) -> f64 {
        let by = 2.0 * LEFT_OUT;
        let doubt = DOUBT_SD / ((1.0 - LASTS * LASTS) * self.pairs()).sqrt();
        (1.0 + by * (f64::from(self.together) - doubt)).clamp(1.0, INFLATION_MAX)
    }

    /// Learns from one standardised innovation; call it only while no change is suspected. `sound` is the
    /// probability by [`Self::density`] that the contact is not an outlier. `share` is the share of noise in the
    /// innovation's variance, 0 to 1: uncertainty of the state carries no information about the noise. `by_play` is the
    /// share of the play in the noise.
    ///
    /// Returns the factor by which the scale's variance has changed.
    pub fn learn(&mut self, standardised: f64, sound: f64, noise_share: f64, by_play: f64) -> f64 {
        let before = self.variance();
        let square = sound * standardised.powi(2) / InnovationDensity::mean_square_seen(self.outliers.into());
        let share = noise_share * (1.0 - by_play);
        self.contacts = (f64::from(self.contacts) + share).min(Self::MEMORY_CONTACTS) as f32;
        let contacts = f64::from(self.contacts);
        let after = before * (1.0 + share * (square - 1.0) / contacts);
        self.variance = after.clamp(0.0625, 16.0) as f32;
        self.learn_play(square, noise_share * by_play);
        let outliers = f64::from(self.outliers);
        let outliers = outliers + share * (1.0 - sound - outliers) / (contacts + OUTLIERS_PRIOR_CONTACTS);
        self.outliers = outliers.clamp(OUTLIERS_MIN_MAX.0, OUTLIERS_MIN_MAX.1) as f32;
        self.variance() / before
    }

    fn learn_play(&mut self, square: f64, share: f64) {
        self.play_contacts = (f64::from(self.play_contacts) + share).min(Self::MEMORY_CONTACTS) as f32;
        let after = f64::from(self.play_mm) * (1.0 + 0.5 * share * (square - 1.0) / f64::from(self.play_contacts));
        self.play_mm = after.clamp(PLAY_MIN_MAX_MM.0, PLAY_MIN_MAX_MM.1) as f32;
    }

    /// Learns the correlation from one standardised innovation; call it only while no alarm stands. `share` is as in
    /// [`Self::learn`].
    ///
    /// A change correlates innovations, too, and would hide itself. So the contacts of a doubt count once it is over:
    /// once the detector is `calm` again.
    pub fn correlate(&mut self, standardised: f64, share: f64, calm: bool) {
        if f64::from(self.contacts) < SCALE_FIRST_CONTACTS {
            return;
        }
        let one = share * standardised.clamp(-LARGEST_SD, LARGEST_SD);
        let earlier = f64::from(self.earlier);
        self.doubtful += (one * earlier) as f32;
        self.doubtful_contacts += 1.0;
        self.earlier = (one + LASTS * earlier) as f32;
        if calm {
            let (count, together) = (f64::from(self.doubtful_contacts), f64::from(self.together));
            let off = f64::from(self.doubtful) - count * together;
            self.together = (together + off / self.pairs().max(count)) as f32;
            (self.doubtful, self.doubtful_contacts) = (0.0, 0.0);
        }
    }

    /// The doubt has become an alarm: its contacts do not count.
    pub fn forget_doubtful(&mut self) {
        (self.earlier, self.doubtful, self.doubtful_contacts) = (0.0, 0.0, 0.0);
    }

    /// Number of contacts from which the correlation was learned.
    fn pairs(&self) -> f64 {
        (f64::from(self.contacts) - SCALE_FIRST_CONTACTS).max(0.0) + INDEPENDENT_CONTACTS
    }

    /// Whether all numbers are finite.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        let correlation = [self.earlier, self.together, self.doubtful, self.doubtful_contacts];
        let play = [self.play_mm, self.play_contacts];
        [self.variance, self.contacts, self.outliers].iter().chain(&correlation).chain(&play).all(|one| one.is_finite())
    }

    /// Reads a scale as it was stored in version 7 of the whisker, without play.
    ///
    /// # Errors
    /// The bytes end.
    pub fn read_7<R: Read>(reader: &mut R) -> Result<Self> {
        let [variance, contacts, outliers, earlier, together, doubtful, doubtful_contacts] =
            BorshDeserialize::deserialize_reader(reader)?;
        Ok(Self { variance, contacts, outliers, earlier, together, doubtful, doubtful_contacts, ..Self::default() })
    }

    /// Reads a scale as it was stored before version 7 of the whisker, without outliers and correlation.
    ///
    /// # Errors
    /// The bytes end.
    pub fn read_before_7<R: Read>(reader: &mut R) -> Result<Self> {
        let (variance, contacts) = BorshDeserialize::deserialize_reader(reader)?;
        Ok(Self { variance, contacts, ..Self::default() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A reproducible stream of numbers of unit variance: sums of three uniform ones (xorshift64, Marsaglia 2003).
    struct Independent(u64);

    impl Independent {
        fn next(&mut self) -> f64 {
            let mut uniform = || {
                self.0 ^= self.0 << 13;
                self.0 ^= self.0 >> 7;
                self.0 ^= self.0 << 17;
                (self.0 >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
            };
            2.0 * (uniform() + uniform() + uniform())
        }
    }

    /// A scale that learned from noise of this correlation from contact to contact.
    fn learned(keeps: f64, contacts: u32) -> NoiseScale {
        let mut scale = NoiseScale::default();
        let (mut noise, mut random) = (0.0, Independent(88_172_645_463_325_252));
        for _ in 0..contacts {
            noise = keeps * noise + (1.0 - keeps * keeps).sqrt() * random.next();
            let sound = scale.density().at(noise).sound;
            scale.learn(noise / scale.variance().sqrt(), sound, 1.0, 0.0);
            scale.correlate(noise / scale.variance().sqrt(), 1.0, true);
        }
        scale
    }

    #[test]
    fn property_the_inflation_is_that_of_the_mean_of_correlated_contacts() {
        assert!(learned(0.0, 5000).inflation() < 1.1, "{}", learned(0.0, 5000).inflation());
        for keeps in [0.5, 0.7, 0.8] {
            let (stated, truth) = (learned(keeps, 10_000).inflation(), (1.0 + keeps) / (1.0 - keeps));
            assert!((0.75..1.25).contains(&(stated / truth)), "{keeps}: {stated} {truth}");
        }
    }

    #[test]
    fn property_the_share_of_outliers_is_learned_within_its_range() {
        let (mut scale, mut random) = (NoiseScale::default(), Independent(88_172_645_463_325_252));
        for step in 0..20_000 {
            let one = random.next() * if step % 50 == 0 { 10.0 } else { 1.0 };
            let sound = scale.density().at(one).sound;
            scale.learn(one, sound, 1.0, 0.0);
        }
        // A third of the 2 % is within three standard deviations of the others.
        assert!((0.011..0.021).contains(&scale.outliers), "{scale:?}");
        let mut quiet = NoiseScale::default();
        for _ in 0..5000 {
            let one = random.next();
            let sound = quiet.density().at(one).sound;
            quiet.learn(one, sound, 1.0, 0.0);
        }
        assert!((f64::from(quiet.outliers) - InnovationDensity::OUTLIERS_MIN).abs() < 1e-6, "{quiet:?}");
    }
}
