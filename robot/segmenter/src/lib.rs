//! Makes contacts of the strain of a whisker: onset, measurement, slip-off, and where along the whisker.
//!
//! Pure and streaming: [`Segmenter::push`] takes one [`Sample`] and returns at most one [`Event`]. It allocates once a
//! contact, and does a bounded amount of work for each sample. There is no clock: time comes with the samples.
//!
//! Read in this order: [`Sample`] and [`Event`], [`Params`], `intake` with `glitch` and `shake` (from samples to bins),
//! `baseline` (drift and noise), `rest` (which level is rest), `segmenter` (the states) with `air` and `settling`,
//! `touch` (one contact), `distance` (two gauges), `condition` (how far findings can be relied on).
//!
//! docs/segmenter.md has the method, and how well it does on simulated streams.

mod air;
mod baseline;
mod condition;
mod distance;
mod glitch;
mod intake;
mod params;
mod rest;
mod segmenter;
mod settling;
mod shake;
mod touch;

pub use condition::{Condition, Missing};
pub use distance::{Distance, DistanceFusion};
pub use params::Params;
pub use segmenter::Segmenter;

/// Measurements of one time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Microseconds of any clock that does not jump.
    pub t_us: u64,
    /// Strain at the first gauge (x = 3 mm), m/m; any offset.
    pub strain: f64,
    /// Strain at the second gauge (x = 11 mm), if there is one.
    pub strain_2: Option<f64>,
    /// Way of the whisker's base against the object, with any offset, if known. It grows as the whisker is pressed.
    pub deflection_mm: Option<f64>,
    /// Distance of the object from the whisker's base, if the robot knows it from its motion.
    pub distance_mm: Option<f64>,
    /// Air pressure in the whisker's chamber, if known. MPa.
    pub pressure_mpa: Option<f64>,
    /// Pressure to which the chamber is regulated, if known. MPa.
    pub setpoint_mpa: Option<f64>,
    /// Whether the robot drives, if known: its shaking is no contact.
    pub driving: Option<bool>,
    /// Whether the converter or the gauge is known to end at this strain: it is a lower bound.
    pub saturated: bool,
}

/// A finding of the segmenter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// A contact has begun; its [`Contact`] follows at its end, unless samples are missing or the whisker shook.
    Onset {
        /// First estimate of when it began.
        t_us: u64,
        /// Time at which it was found.
        found_us: u64,
    },
    /// A contact has ended.
    Contact(Contact),
}

/// Part of the contact in which the strain was measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactKind {
    /// At the largest strain.
    Peak,
    /// In the first 0.3 s of a hold.
    Plateau,
    /// Just before the whisker slipped off.
    SlipOff,
}

/// One contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Time of its begin: the strain's rise, extended back to the baseline.
    pub onset_us: u64,
    /// Time at which the strain was measured.
    pub measured_us: u64,
    /// Time of its end.
    pub end_us: u64,
    /// Strain before the touch.
    pub baseline: f64,
    /// Change of strain from the baseline, with its sign.
    pub strain: f64,
    /// Standard deviation of `strain`: noise, drift, and the history of the rubber.
    pub strain_sd: f64,
    /// Part of the contact in which it was measured.
    pub kind: ContactKind,
    /// The whisker slipped off: the contact was at the tip.
    pub tip: bool,
    /// Change of the deflection from the onset to the measurement.
    pub deflection_mm: Option<f64>,
    /// The distance that the robot gave, at the measurement.
    pub distance_mm: Option<f64>,
    /// Strain at the second gauge over strain at the first, and its standard deviation.
    pub ratio: Option<(f64, f64)>,
    /// Distance of the contact from the base, from `ratio`.
    pub distance: Option<Distance>,
    /// A gauge was at its limit: the strain is a lower bound.
    pub saturated: bool,
}

/// Numbers of samples and contacts that were left out, since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Samples that were not later than the one before.
    pub out_of_order: u64,
    /// Samples that were not numbers.
    pub not_a_number: u64,
    /// Samples at the gauge's limit.
    pub saturated: u64,
    /// Samples that were glitches of the converter.
    pub glitches: u64,
    /// Contacts that were left out, as samples were missing in them or right after them.
    pub interrupted: u64,
    /// Contacts that were left out, as they were held back for too long, or as their reference was no rest.
    pub doubtful: u64,
}
