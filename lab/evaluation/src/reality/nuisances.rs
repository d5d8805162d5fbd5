//! Sizes of the nuisances that last, by row.
//!
//! Strength 1 follows recordings of a moulded silicone whisker and the literature: independent noise well under 1 %,
//! while creep, loop, first loads and temperature make percents that last from seconds to days.

use super::row::{Nuisance, Row};

/// Full range of the deflections, mm.
pub(super) const DEFLECTION_MAX_MM: f64 = 6.0;

/// Sizes of the nuisances of a row; 0 or false is off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nuisances {
    /// Standard deviation of the error of a contact ratio.
    pub ratio_sd: f64,
    /// Contacts move between two zones of the whisker.
    pub zones: bool,
    /// Factor on the temperature coefficients, which are 0.3 to 1 % per K.
    pub temperature: f64,
    /// Size of a step of all sensitivities of the robot, in log sensitivity.
    pub step: f64,
    /// Standard deviation of the random step of the gain at each contact, in log sensitivity.
    pub walk: f64,
    /// Change of the gain with each contact, in log sensitivity; its sign differs between whiskers.
    pub ageing: f64,
    /// Change of the gain in the first 50 contacts, in log sensitivity.
    pub first_loads: f64,
    /// Standard deviation of the correlated noise, in log sensitivity.
    pub ar_sd: f64,
    /// Weight of each of the two Prony terms.
    pub creep: f64,
    /// Largest difference between the way in and the way out, in mm of deflection.
    pub loop_mm: f64,
    /// Loss of sensitivity per mm of deflection, as a ratio.
    pub curvature_per_mm: f64,
    /// Share of contacts with ten times the noise.
    pub outliers: f64,
    /// Factor on the dead band of the valves, which is 1.5 to 3 kPa. If 0, the regulator is ideal.
    pub valves: f64,
    /// Factor on the rate of a leak, which is 0.1 to 3 % per second.
    pub leak: f64,
    /// Size of the error that all contact ratios of a robot share while its camera has moved.
    pub ratio_off: f64,
    /// Largest angle of a contact to the plane of the gauge, degrees.
    pub turn_deg: f64,
    /// Size of the error that all distances of a robot's touch tests share, mm.
    pub zero_mm: f64,
    /// Share of its range, 0.5 to 2.5 MPa on a logarithmic scale, that the modulus of the rubber takes.
    pub modulus: f64,
    /// Share of the messages that come late, by up to a minute.
    pub late: f64,
    /// Amplitude with which a regulator hunts around its target, MPa.
    pub hunting_mpa: f64,
    /// Whether whiskers bend as an elastica does, and not as the core's mechanics say.
    pub elastica: bool,
    /// Share of its thickness under pressure that the chamber's wall has by its volume, and not by the paper; only with
    /// `elastica`.
    pub wall_by_volume: f64,
    /// Coefficient of friction between objects and whiskers; only with `elastica`.
    pub friction: f64,
}

impl Nuisances {
    /// The ideal world: independent noise of the configured size.
    pub const NONE: Self = Self {
        ratio_sd: 0.01,
        zones: false,
        temperature: 0.0,
        step: 0.0,
        walk: 0.0,
        ageing: 0.0,
        first_loads: 0.0,
        ar_sd: 0.0,
        creep: 0.0,
        loop_mm: 0.0,
        curvature_per_mm: 0.0,
        outliers: 0.0,
        valves: 0.0,
        leak: 0.0,
        ratio_off: 0.0,
        turn_deg: 0.0,
        zero_mm: 0.0,
        modulus: 0.0,
        late: 0.0,
        hunting_mpa: 0.0,
        elastica: false,
        wall_by_volume: 0.0,
        friction: 0.0,
    };

    /// Sizes of the nuisances of a row that last.
    #[must_use]
    pub fn of(row: Row) -> Self {
        let mut all = Self::NONE;
        let each: &[Nuisance] = if row.nuisance == Nuisance::Mix { &LASTING } else { &[row.nuisance] };
        for &nuisance in each {
            all.add(nuisance, row.strength);
        }
        all
    }

    fn add(&mut self, nuisance: Nuisance, strength: f64) {
        match nuisance {
            Nuisance::Habits => (self.ratio_sd, self.zones) = (0.01 * strength, true),
            Nuisance::Temperature => self.temperature = strength,
            Nuisance::Step => self.step = 0.03 * strength,
            Nuisance::Walk => self.walk = 0.03 / 5000.0_f64.sqrt() * strength,
            Nuisance::Ageing => (self.ageing, self.first_loads) = (0.05 / 10_000.0 * strength, 0.03 * strength),
            Nuisance::Ar1 => self.ar_sd = 0.02 * strength,
            Nuisance::Creep => self.creep = 0.02 * strength,
            Nuisance::Loop => self.loop_mm = 0.04 * DEFLECTION_MAX_MM * strength,
            Nuisance::Curvature => self.curvature_per_mm = 0.015 * strength,
            Nuisance::Outliers => self.outliers = 0.02 * strength,
            Nuisance::Valves => self.valves = strength,
            // The valves are as real ones, and the leak has the strength.
            Nuisance::Leak => (self.valves, self.leak) = (1.0, strength),
            Nuisance::Camera => self.ratio_off = 0.02 * strength,
            Nuisance::Turn => self.turn_deg = 20.0 * strength,
            Nuisance::Zero => self.zero_mm = strength,
            Nuisance::Modulus => self.modulus = strength,
            Nuisance::Late => self.late = 0.1 * strength,
            Nuisance::Elastica => self.elastica = true,
            Nuisance::Wall => (self.elastica, self.wall_by_volume) = (true, strength),
            Nuisance::Friction => (self.elastica, self.friction) = (true, 0.3 * strength),
            Nuisance::Hunting => (self.valves, self.hunting_mpa) = (1.0, 0.002 * strength),
            Nuisance::Ideal
            | Nuisance::LossCut
            | Nuisance::Factory
            | Nuisance::Exchange
            | Nuisance::Scrape
            | Nuisance::Learning
            | Nuisance::SecondCut
            | Nuisance::Erosion
            | Nuisance::GainDrop
            | Nuisance::Mix => {}
        }
    }
}

/// The nuisances of the mix.
const LASTING: [Nuisance; 11] = [
    Nuisance::Habits,
    Nuisance::Temperature,
    Nuisance::Step,
    Nuisance::Walk,
    Nuisance::Ageing,
    Nuisance::Ar1,
    Nuisance::Creep,
    Nuisance::Loop,
    Nuisance::Curvature,
    Nuisance::Outliers,
    Nuisance::Valves,
];
