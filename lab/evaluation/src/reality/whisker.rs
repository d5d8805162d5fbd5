//! The true whisker: rubber, gain, noise, and the reading of each contact.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use vibrissa_core::mechanics::{ByRatio, Calibration, Formulation, Model};

use super::StatedPlace;
use super::elastica::Place;
use super::mechanics::Mechanics;
use super::nuisances::{DEFLECTION_MAX_MM, Nuisances};
use super::rubber::{Press, Rubber};
use crate::deviation::{deviating, with_calibration};

/// Nominal pressure, MPa.
pub(super) const NOMINAL_MPA: f64 = 0.1;
/// Largest relative deviation of a whisker's calibration from the model.
const CALIBRATION_ERROR: f64 = 0.05;
/// Largest relative difference between whiskers of one robot, which are cast from one batch.
const BATCH_ERROR: f64 = 0.01;
/// Independent noise of the ideal world: strain (relative and floor) and deflection (relative).
const STRAIN_RELATIVE: f64 = 0.02;
const STRAIN_FLOOR: f64 = 5e-6;
const DEFLECTION_RELATIVE: f64 = 0.01;
/// Standard deviation of an outlier, in log sensitivity: ten times all independent noise together.
const OUTLIER_SD: f64 = 0.25;
/// Share of the contacts that are read on the way out.
const ON_THE_WAY_OUT: f64 = 0.5;
/// First loads take effect within about three times this number of contacts.
const FIRST_LOADS_CONTACTS: f64 = 15.0;

/// Range of the modulus of rubbers, MPa.
const MODULUS_MPA: (f64, f64) = (0.5, 2.5);
/// Largest angle at which a gauge is mounted, degrees.
pub(super) const MOUNTED_DEG: f64 = 10.0;

/// The calibration with the modulus of a rubber within a share of the range around the designed one. The chamber's modulus
/// E2 at each pressure stays.
fn with_modulus(designed: Calibration, share: f64, batch: &mut ChaCha8Rng) -> Calibration {
    let within: f64 = batch.random();
    let drawn_mpa = MODULUS_MPA.0 * (MODULUS_MPA.1 / MODULUS_MPA.0).powf(within);
    let factor = (drawn_mpa / designed.youngs_modulus_mpa).powf(share);
    Calibration {
        c: designed.c / factor,
        a: designed.a / factor,
        youngs_modulus_mpa: designed.youngs_modulus_mpa * factor,
        ..designed
    }
}

/// Random numbers for one purpose.
#[must_use]
pub(super) fn stream(seed: u64, purpose: u64) -> ChaCha8Rng {
    let mut stream = ChaCha8Rng::seed_from_u64(seed);
    stream.set_stream(purpose);
    stream
}

pub(super) fn normal(stream: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(stream)
}

/// Where and how hard a robot touches at present.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Habit {
    /// Range of the contact ratios.
    pub ratios: (f64, f64),
    /// Range of the deflections, mm.
    pub deflections_mm: (f64, f64),
}

impl Habit {
    /// All over the whisker.
    pub const ANY: Self = Self { ratios: (0.45, 1.0), deflections_mm: (0.2, DEFLECTION_MAX_MM) };
}

/// Circumstances of a contact that the whiskers of a robot share.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Circumstances {
    /// Where and how hard the robot touches.
    pub habit: Habit,
    /// Deviation of the temperature from that of the installation, K.
    pub warmer_k: f64,
    /// Change of all sensitivities by another cause, in log sensitivity.
    pub log_shift: f64,
    /// Error that all contact ratios share.
    pub ratio_off: f64,
    /// Angle of the contacts to the direction in which the robot drives, degrees.
    pub heading_deg: f64,
    /// Time since the last contact, s.
    pub pause_s: f64,
    /// Time from the touch to the reading, s.
    pub held_s: f64,
    /// True pressure of the chamber, MPa.
    pub pressure_mpa: f64,
}

/// Readings of one contact, except the pressure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Touch {
    /// Contact ratio to the present length, with its error.
    pub ratio: f64,
    /// Distance from the base with its error, mm.
    pub distance_mm: f64,
    /// Deflection, mm.
    pub deflection_mm: f64,
    /// Strain, m/m.
    pub strain: f64,
    /// True sensitivity without noise and nuisances, 1/mm.
    pub true_per_mm: f64,
    /// Deflection without its error, mm.
    pub true_deflection_mm: f64,
}

/// A whisker with its true state.
#[derive(Debug)]
pub struct Whisker {
    nuisances: Nuisances,
    mechanics: Mechanics,
    /// Length at installation, mm.
    pub whole_mm: f64,
    /// Present length, mm.
    pub length_mm: f64,
    /// Change of log sensitivity per K.
    pub per_k: f64,
    /// Correlation of the correlated noise from contact to contact.
    pub phi: f64,
    /// Angle of its gauge to the direction in which the robot drives, degrees.
    mounted_deg: f64,
    /// Error of the robot's distances in touch tests, mm.
    zero_mm: f64,
    ageing: f64,
    walked: f64,
    dropped: f64,
    correlated: f64,
    contacts: u64,
    rubber: Rubber,
    contact_stream: ChaCha8Rng,
    noise_stream: ChaCha8Rng,
}

impl Whisker {
    /// A whole whisker of a robot, which deviates from the designed one.
    #[must_use]
    pub fn new(designed: &Model, nuisances: Nuisances, whole_mm: f64, seed: u64, number: u64) -> Self {
        let mut batch = stream(seed, 0);
        let mut own = stream(seed, 1 + 4 * number);
        let calibration = deviating(designed.calibration(), |value| {
            let shared = CALIBRATION_ERROR * batch.random_range(-1.0..=1.0);
            value * (1.0 + shared + BATCH_ERROR * own.random_range(-1.0..=1.0))
        });
        let calibration = with_modulus(calibration, nuisances.modulus, &mut stream(seed, u64::MAX - 2));
        let formulation = if batch.random() { Formulation::Published } else { Formulation::Consistent };
        let model = with_calibration(designed, calibration, formulation);
        let sign = if batch.random() { 1.0 } else { -1.0 };
        let per_k = sign * batch.random_range(0.003..=0.01) * own.random_range(0.9..=1.1);
        let ageing_sign = if own.random() { 1.0 } else { -1.0 };
        let phi = own.random_range(0.5..=0.9);
        let zero_mm = if batch.random() { nuisances.zero_mm } else { -nuisances.zero_mm };
        let mut mounting = stream(seed, u64::MAX - 3 - number);
        Self {
            mounted_deg: mounting.random_range(-MOUNTED_DEG..=MOUNTED_DEG),
            zero_mm,
            mechanics: Mechanics::new(model, NOMINAL_MPA, &nuisances),
            nuisances,
            whole_mm,
            length_mm: whole_mm,
            per_k: nuisances.temperature * per_k,
            phi,
            ageing: ageing_sign * nuisances.ageing,
            walked: 0.0,
            dropped: 0.0,
            correlated: nuisances.ar_sd * normal(&mut own),
            contacts: 0,
            rubber: Rubber::default(),
            contact_stream: stream(seed, 2 + 4 * number),
            noise_stream: stream(seed, 3 + 4 * number),
        }
    }

    /// Makes a contact at a ratio to the present length; `None` on the chamber.
    pub fn touch(&mut self, at: &Circumstances) -> Option<Touch> {
        self.touch_at(at, StatedPlace::Ratio)
    }

    /// Makes a contact where the objects of robots stand that know such a place; `None` on the chamber, and where the
    /// whisker does not reach.
    ///
    /// Each contact takes the same number of draws in each row, so that rows differ by their nuisance alone.
    pub fn touch_at(&mut self, at: &Circumstances, kind: StatedPlace) -> Option<Touch> {
        let [place, force, way, peak, rare]: [f64; 5] = std::array::from_fn(|_| self.contact_stream.random());
        let noise: [f64; 6] = std::array::from_fn(|_| normal(&mut self.noise_stream));
        let within = |(low, high): (f64, f64), share: f64| low + share * (high - low);
        let drawn = within(at.habit.ratios, place);
        let ratio = match kind {
            StatedPlace::Ratio | StatedPlace::RatioTests | StatedPlace::Unknown => drawn,
            StatedPlace::Tip => 1.0,
            StatedPlace::Distance | StatedPlace::DistanceTests => drawn * self.whole_mm / self.length_mm,
        };
        let deflection_mm = within(at.habit.deflections_mm, force);
        let returns = way < ON_THE_WAY_OUT;
        let peak_mm = if returns { within((deflection_mm, DEFLECTION_MAX_MM), peak) } else { deflection_mm };
        let log_gain = self.log_gain() + self.per_k * at.warmer_k + at.log_shift;
        if ratio > 1.0 {
            return None;
        }
        self.live(noise[4], noise[5]);

        let touched = Place { ratio, length_mm: self.length_mm, pressure_mpa: at.pressure_mpa };
        let true_per_mm = self.mechanics.per_mm(touched, deflection_mm, returns)?;
        let press = Press { deflection_mm, peak_mm, pause_s: at.pause_s, held_s: at.held_s };
        let felt_mm = self.rubber.press(&self.nuisances, &press);
        let independent = if rare < self.nuisances.outliers { OUTLIER_SD } else { STRAIN_RELATIVE };
        let straight = 1.0 - self.nuisances.curvature_per_mm * deflection_mm;
        let angle = if self.nuisances.turn_deg > 0.0 { at.heading_deg + self.mounted_deg } else { 0.0 };
        let seen_mm = felt_mm * angle.to_radians().cos();
        let strain = true_per_mm * seen_mm * straight * (log_gain + self.correlated + independent * noise[0]).exp();
        Some(Touch {
            ratio: ((1e4 * (ratio + at.ratio_off + self.nuisances.ratio_sd * noise[1])).round() / 1e4).clamp(0.01, 1.0),
            distance_mm: ((ratio + self.nuisances.ratio_sd * noise[1]) * self.length_mm).max(0.1),
            deflection_mm: (deflection_mm * (1.0 + DEFLECTION_RELATIVE * noise[2])).max(0.01),
            strain: (strain + STRAIN_FLOOR * noise[3]).clamp(-0.5, 0.5),
            true_per_mm,
            true_deflection_mm: deflection_mm,
        })
    }

    /// Makes a contact on request, at a distance in mm that the robot misses by its usual error, and at a deflection in mm;
    /// `None` where the whisker does not reach.
    pub fn touch_on_request(&mut self, at: &Circumstances, distance_mm: f64, deflection_mm: f64) -> Option<Touch> {
        let off_mm = self.distance_sd_mm() * normal(&mut self.contact_stream);
        let ratio = (distance_mm + self.zero_mm + off_mm) / self.whole_mm;
        let habit = Habit { ratios: (ratio, ratio), deflections_mm: (deflection_mm, deflection_mm) };
        let touch = self.touch_at(&Circumstances { habit, ..*at }, StatedPlace::Distance)?;
        Some(Touch { distance_mm, ..touch })
    }

    /// Standard deviation of the robot's distances, mm.
    #[must_use]
    pub fn distance_sd_mm(&self) -> f64 {
        (self.nuisances.ratio_sd * self.whole_mm).max(0.1)
    }

    /// Advances correlated noise and walking gain by one contact.
    fn live(&mut self, correlated: f64, walk: f64) {
        self.contacts += 1;
        self.walked += self.nuisances.walk * walk;
        let fresh = (1.0 - self.phi * self.phi).sqrt();
        self.correlated = self.phi * self.correlated + self.nuisances.ar_sd * fresh * correlated;
    }

    /// The whisker's own change of log sensitivity since its installation, without temperature and noise.
    #[must_use]
    pub fn log_gain(&self) -> f64 {
        let contacts = self.contacts as f64;
        let first = if self.nuisances.first_loads == 0.0 {
            0.0
        } else {
            self.nuisances.first_loads * (1.0 - (-contacts / FIRST_LOADS_CONTACTS).exp())
        };
        self.ageing * contacts + first + self.walked - self.dropped
    }

    /// The gain drops once, by this much log sensitivity.
    pub fn drop_gain(&mut self, log: f64) {
        self.dropped += log;
    }

    /// Number of contacts so far.
    #[must_use]
    pub fn contacts(&self) -> u64 {
        self.contacts
    }

    /// Log sensitivity without noise and nuisances, by contact ratio, for a length and a pressure: the mean over the
    /// deflections of a robot.
    #[must_use]
    pub fn log_sensitivities(&self, length_mm: f64, pressure_mpa: f64) -> ByRatio {
        self.mechanics.log_per_mm(length_mm, pressure_mpa, Habit::ANY.deflections_mm)
    }
}
