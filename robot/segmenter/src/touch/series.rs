//! Bins, and sums over them.

use crate::intake::Bin;

/// Bins that are kept: half a second at the highest rate.
const KEPT: usize = 128;

/// A bin relative to the baseline, positive in the direction of the contact.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Point {
    pub(crate) t_s: f64,
    pub(crate) strain: f64,
    pub(crate) strain_2: Option<f64>,
    pub(crate) deflection_mm: Option<f64>,
    pub(crate) distance_mm: Option<f64>,
}

/// The newest bins, as they came.
#[derive(Clone, Debug)]
pub(crate) struct Ring {
    bins: [Bin; KEPT],
    next: usize,
    count: usize,
}

impl Ring {
    pub(crate) fn new() -> Ring {
        Ring { bins: [Bin::default(); KEPT], next: 0, count: 0 }
    }

    pub(crate) fn clear(&mut self) {
        self.count = 0;
    }

    pub(crate) fn push(&mut self, bin: Bin) {
        self.bins[self.next] = bin;
        self.next = (self.next + 1) % KEPT;
        self.count = (self.count + 1).min(KEPT);
    }

    /// From the newest to the oldest.
    pub(crate) fn back(&self) -> impl Iterator<Item = &Bin> {
        (1..=self.count).map(move |age| &self.bins[(self.next + KEPT - age) % KEPT])
    }
}

/// Sums of a straight line through points.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Line {
    pub(super) count: f64,
    pub(super) t: f64,
    pub(super) y: f64,
    pub(super) tt: f64,
    pub(super) ty: f64,
}

impl Line {
    pub(super) fn add(&mut self, t: f64, y: f64) {
        self.count += 1.0;
        self.t += t;
        self.y += y;
        self.tt += t * t;
        self.ty += t * y;
    }

    pub(super) fn slope(&self) -> f64 {
        let spread = self.count * self.tt - self.t * self.t;
        if spread > 0.0 { (self.count * self.ty - self.t * self.y) / spread } else { 0.0 }
    }

    pub(super) fn at(&self, t: f64) -> f64 {
        self.y / self.count + self.slope() * (t - self.t / self.count)
    }
}

#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sums {
    pub(super) count: f64,
    pub(super) strain: f64,
    pub(super) strain_2: f64,
    pub(super) count_2: f64,
    pub(super) t_s: f64,
}

impl Sums {
    pub(super) fn add(&mut self, point: &Point) {
        self.count += 1.0;
        self.strain += point.strain;
        self.t_s += point.t_s;
        if let Some(strain_2) = point.strain_2 {
            self.strain_2 += strain_2;
            self.count_2 += 1.0;
        }
    }

    pub(super) fn mean(&self) -> f64 {
        self.strain / self.count
    }
}

/// The deflection at a time that the ring covers, between two bins.
pub(super) fn deflection_at(ring: &Ring, t_s: f64) -> Option<f64> {
    let mut later: Option<&Bin> = None;
    for bin in ring.back() {
        if bin.t_s <= t_s {
            let (mm, Some(later)) = (bin.deflection_mm?, later) else {
                return bin.deflection_mm;
            };
            let part = (t_s - bin.t_s) / (later.t_s - bin.t_s);
            return Some(mm + part * (later.deflection_mm? - mm));
        }
        later = Some(bin);
    }
    None
}
