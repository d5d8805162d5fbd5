//! The paper's whisker as a rod, from Table 1 alone.
//!
//! The air pulls the chamber longer by the measured elongation of the calibration. Each cross section stretches in inverse
//! proportion to its area. The wall gets thinner from outside, because the inner diameter stays: as eq. 18 to 20 of the paper say,
//! or as a wall that keeps its volume. The modulus of the wall is that of the calibration, a property of the rubber.

use vibrissa_core::mechanics::{Calibration, Geometry};

use super::{Rod, Section};

/// Slices between two marks on the chamber: its start, the two ends of the gauge, and its end.
const SLICES: u32 = 3;
/// Distance from the chamber's start of the first of the two places whose mean thickness the paper takes, mm.
const NEAR_CAP_MM: f64 = 0.5;
/// Length that no whisker exceeds, mm.
pub(super) const LONGEST_MM: f64 = 90.0;

/// A whisker under pressure.
#[derive(Debug)]
pub(super) struct Stretched {
    pub rod: Rod,
    pub elongation_mm: f64,
    /// Distance from the base at which the chamber ends, mm.
    pub chamber_end_mm: f64,
}

/// A cross section of the chamber under pressure.
#[derive(Clone, Copy)]
struct Ring {
    outer_mm: f64,
    inner_mm: f64,
    /// Length under pressure for each mm without.
    stretch: f64,
}

/// Square of the outer diameter less that of the inner one without pressure, and the inner diameter, mm^2 and mm.
fn wall(g: &Geometry, at_mm: f64) -> (f64, f64) {
    let share = (at_mm - g.c_mm) / (g.l_mm - g.c_mm);
    let mid_mm = g.d2_mid_large_mm + share * (g.d2_mid_small_mm - g.d2_mid_large_mm);
    ((mid_mm + g.t_mm).powi(2) - (mid_mm - g.t_mm).powi(2), mid_mm - g.t_mm)
}

/// Integral by Simpson's rule.
fn integral(from: f64, to: f64, f: impl Fn(f64) -> f64) -> f64 {
    (to - from) / 6.0 * (f(from) + 4.0 * f(0.5 * (from + to)) + f(to))
}

impl Stretched {
    /// `by_volume` is the share of its thickness that the wall has by its volume, and not by the paper.
    pub(super) fn new(g: &Geometry, calibration: &Calibration, by_volume: f64, pressure_mpa: f64) -> Self {
        let softened = calibration.a * (-calibration.b_per_mpa * pressure_mpa).exp();
        let wall_mpa = (calibration.c + softened) * calibration.youngs_modulus_mpa;
        let elongation_mm = calibration.elongation_gain_mm * pressure_mpa / wall_mpa;
        Self::with(g, (calibration.youngs_modulus_mpa, wall_mpa), by_volume, elongation_mm)
    }

    /// A whisker with a modulus of cap and body, one of the chamber's wall, and an elongation of the chamber.
    pub(super) fn with(g: &Geometry, (modulus_mpa, wall_mpa): (f64, f64), by_volume: f64, elongation_mm: f64) -> Self {
        let marks = [g.c_mm, g.xss_mm, g.xss_mm + g.e_mm, g.l_mm];
        let thin = |at_mm: f64| 1.0 / wall(g, at_mm).0;
        let total: f64 = marks.windows(2).map(|pair| integral(pair[0], pair[1], thin)).sum();
        let outer_mm = |at_mm: f64| wall(g, at_mm).1 + 2.0 * g.t_mm;
        let thinned = |at_mm: f64| 0.5 * g.poisson_ratio * outer_mm(at_mm) * elongation_mm / (g.l_mm - g.c_mm);
        let paper_mm = g.t_mm - 0.5 * (thinned(g.c_mm + NEAR_CAP_MM) + thinned(g.l_mm));
        let ring = |at_mm: f64| {
            let stretch = 1.0 + elongation_mm * thin(at_mm) / total;
            let (squares, inner_mm) = wall(g, at_mm);
            let volume_mm =
                0.5 * ((inner_mm.powi(2) + squares * stretch.powf(-2.0 * g.poisson_ratio)).sqrt() - inner_mm);
            let wall_mm = paper_mm + by_volume * (volume_mm - paper_mm);
            Ring { outer_mm: inner_mm + 2.0 * wall_mm, inner_mm, stretch }
        };
        let cone = |at_mm: f64, large_mm: f64, length_mm: f64| large_mm * (1.0 - at_mm / length_mm);
        let solid = |length_mm: f64, large_mm: f64, cone_mm: f64| Section {
            length_mm,
            outer_mm: [large_mm, cone(length_mm, large_mm, cone_mm)],
            inner_mm: [0.0; 2],
            modulus_mpa,
            has_gauge: false,
        };
        let mut sections = vec![solid(g.c_mm, g.d1_large_mm, g.l1_mm)];
        for pair in marks.windows(2) {
            let has_gauge = pair[0] == g.xss_mm;
            for slice in 0..SLICES {
                let at = |slice: u32| pair[0] + (pair[1] - pair[0]) * f64::from(slice) / f64::from(SLICES);
                let (near, far) = (ring(at(slice)), ring(at(slice + 1)));
                sections.push(Section {
                    length_mm: integral(at(slice), at(slice + 1), |at_mm| ring(at_mm).stretch),
                    outer_mm: [near.outer_mm, far.outer_mm],
                    inner_mm: [near.inner_mm, far.inner_mm],
                    modulus_mpa: wall_mpa,
                    has_gauge,
                });
            }
        }
        let chamber_end_mm = sections.iter().map(|one| one.length_mm).sum();
        sections.push(solid(LONGEST_MM - chamber_end_mm, g.d3_large_mm, g.l3_mm));
        Self { rod: Rod { sections }, elongation_mm, chamber_end_mm }
    }
}
