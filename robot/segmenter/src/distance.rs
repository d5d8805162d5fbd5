//! Distance of a contact from the base, from the strains at two gauges.
//!
//! The ratio of the strains rises with the distance, and less and less steeply. So ratios are averaged, not distances,
//! and the distance with its error is the mean and the standard deviation of all distances that fit the average. Far
//! out the ratio says little; there the standard deviation tends to that of the whole whisker.

use crate::Params;

/// Distances that are compared.
const GRID: usize = 64;

/// A distance from the base with its standard deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// mm.
    pub mm: f64,
    /// mm.
    pub sd_mm: f64,
}

/// Average of the ratios of contacts with one object, or in one pass, at the same distance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DistanceFusion {
    weight: f64,
    weighted: f64,
}

impl DistanceFusion {
    /// Takes in a contact's ratio; one that is not a positive number is ignored.
    pub fn add(&mut self, ratio: f64, sd: f64) {
        if ratio.is_finite() && sd.is_finite() && sd > 0.0 {
            self.weight += 1.0 / (sd * sd);
            self.weighted += ratio / (sd * sd);
        }
    }

    /// The distance that fits all of them; `None` before the first.
    #[must_use]
    pub fn distance(&self, params: &Params) -> Option<Distance> {
        if self.weight <= 0.0 {
            return None;
        }
        let ratio = self.weighted / self.weight;
        let shared = params.ratio_shared_sd * ratio;
        Some(posterior(params, ratio, (1.0 / self.weight + shared * shared).sqrt()))
    }
}

/// Mean and standard deviation over evenly likely distances.
fn posterior(params: &Params, ratio: f64, sd: f64) -> Distance {
    let (near, far) = params.distances_mm;
    let (mut sum, mut sum_mm, mut sum_mm2) = (0.0, 0.0, 0.0);
    for index in 0..GRID {
        let mm = near + (far - near) * index as f64 / (GRID - 1) as f64;
        let off = ((ratio - ratio_at(params, mm)) / sd).clamp(-30.0, 30.0);
        let likelihood = (-0.5 * off * off).exp();
        sum += likelihood;
        sum_mm += likelihood * mm;
        sum_mm2 += likelihood * mm * mm;
    }
    let mm = sum_mm / sum;
    // Never finer than the grid.
    let grain = (far - near) / (GRID - 1) as f64;
    Distance { mm, sd_mm: (sum_mm2 / sum - mm * mm).max(grain * grain / 12.0).sqrt() }
}

/// Ratio of the gauges for a contact at this distance.
pub(crate) fn ratio_at(params: &Params, mm: f64) -> f64 {
    let table = &params.ratios;
    let upper = table.iter().position(|(at, _)| *at > mm).unwrap_or(table.len() - 1).max(1);
    let ((mm_0, ratio_0), (mm_1, ratio_1)) = (table[upper - 1], table[upper]);
    ratio_0 + (ratio_1 - ratio_0) * (mm - mm_0) / (mm_1 - mm_0)
}
