//! The unknowns of a fit, their wide assumptions before any reading, and their values.

use nalgebra::DVector;

use super::given::Gauge;
use crate::mechanics::calibration::Calibration;
use crate::mechanics::geometry::Geometry;

/// A number that readings may determine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unknown {
    /// Limit of k2 at high pressure.
    C,
    /// Excess of k2 at zero pressure.
    A,
    /// Rate of softening, 1/MPa.
    B,
    /// Young's modulus E, MPa.
    Modulus,
    /// Elongation gain G, mm.
    ElongationGain,
    /// Factor on all strains of the gauge.
    GaugeGain,
    /// Strain that the gauge reads at zero pressure without contact, m/m.
    GaugeOffset,
}

/// All unknowns, in the order of [`Values`].
pub const UNKNOWNS: [Unknown; 7] = [
    Unknown::C,
    Unknown::A,
    Unknown::B,
    Unknown::Modulus,
    Unknown::ElongationGain,
    Unknown::GaugeGain,
    Unknown::GaugeOffset,
];

/// Strain of one unit of the offset: the others are logarithms, of the size of 1.
const OFFSET_UNIT: f64 = 1e-3;

impl Unknown {
    /// Its place in [`UNKNOWNS`].
    pub(super) fn index(self) -> usize {
        match self {
            Self::C => 0,
            Self::A => 1,
            Self::B => 2,
            Self::Modulus => 3,
            Self::ElongationGain => 4,
            Self::GaugeGain => 5,
            Self::GaugeOffset => 6,
        }
    }

    /// Name in errors.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::C => "c",
            Self::A => "a",
            Self::B => "b",
            Self::Modulus => "E",
            Self::ElongationGain => "G",
            Self::GaugeGain => "the gauge's gain",
            Self::GaugeOffset => "the gauge's offset",
        }
    }

    /// Standard deviation of the coordinate before any reading. Rubbers differ by a factor of 16 in both directions (two
    /// standard deviations), the shape gives G within a factor of 4, and the gauge its factor within one of 2.
    pub(super) fn assumed_sd(self) -> f64 {
        match self {
            Self::C | Self::A | Self::B | Self::Modulus => 4.0_f64.ln(),
            Self::ElongationGain => 2.0_f64.ln(),
            Self::GaugeGain => 0.5 * 2.0_f64.ln(),
            Self::GaugeOffset => 10.0,
        }
    }
}

/// Coordinates of all unknowns: logarithms, and the offset in thousandths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Values([f64; UNKNOWNS.len()]);

impl Values {
    /// The assumptions before any reading: the paper's rubber on a whisker of this shape.
    pub(super) fn assumed(geometry: &Geometry) -> Self {
        let paper = Calibration::nguyen_2021();
        Self([
            paper.c.ln(),
            paper.a.ln(),
            paper.b_per_mpa.ln(),
            paper.youngs_modulus_mpa.ln(),
            geometry.elongation_gain_mm().ln(),
            0.0,
            0.0,
        ])
    }

    pub(super) fn of(&self, unknown: Unknown) -> f64 {
        self.0[unknown.index()]
    }

    pub(super) fn set(&mut self, unknown: Unknown, coordinate: f64) {
        self.0[unknown.index()] = coordinate;
    }

    /// With a given modulus: the rubber stays as it is assumed, so c and a change inversely.
    pub(super) fn with_modulus(mut self, modulus_mpa: f64) -> Self {
        let by = modulus_mpa.ln() - self.of(Unknown::Modulus);
        for (unknown, by) in [(Unknown::Modulus, by), (Unknown::C, -by), (Unknown::A, -by)] {
            self.set(unknown, self.of(unknown) + by);
        }
        self
    }

    /// With steps of the free unknowns.
    pub(super) fn moved(mut self, free: &[Unknown], step: &DVector<f64>) -> Self {
        for (unknown, by) in free.iter().zip(step.iter()) {
            self.0[unknown.index()] += by;
        }
        self
    }

    pub(super) fn is_finite(&self) -> bool {
        self.0.iter().all(|value| value.is_finite() && value.abs() < 100.0)
    }

    pub(super) fn gauge(&self) -> Gauge {
        let number = |unknown| Self::in_unit(unknown, self.of(unknown));
        Gauge { gain: number(Unknown::GaugeGain), offset: number(Unknown::GaugeOffset) }
    }

    /// The number of an unknown in its unit, for a coordinate.
    pub(super) fn in_unit(unknown: Unknown, coordinate: f64) -> f64 {
        match unknown {
            Unknown::C | Unknown::A | Unknown::B | Unknown::Modulus | Unknown::ElongationGain | Unknown::GaugeGain => {
                coordinate.exp()
            }
            Unknown::GaugeOffset => OFFSET_UNIT * coordinate,
        }
    }

    /// The coordinate of a number in its unit.
    pub(super) fn coordinate(unknown: Unknown, number: f64) -> f64 {
        match unknown {
            Unknown::C | Unknown::A | Unknown::B | Unknown::Modulus | Unknown::ElongationGain | Unknown::GaugeGain => {
                number.ln()
            }
            Unknown::GaugeOffset => number / OFFSET_UNIT,
        }
    }

    pub(super) fn calibration(&self) -> Calibration {
        let number = |unknown| Self::in_unit(unknown, self.of(unknown));
        Calibration {
            c: number(Unknown::C),
            a: number(Unknown::A),
            b_per_mpa: number(Unknown::B),
            youngs_modulus_mpa: number(Unknown::Modulus),
            elongation_gain_mm: number(Unknown::ElongationGain),
        }
    }
}
