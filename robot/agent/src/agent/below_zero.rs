//! Readings of pressure a little below zero: the zero of a sensor that reads an empty chamber.

/// Largest such reading, in MPa: 5 % of the range of a chamber. Cheap sensors are off by up to 2.5 % of their own
/// range.
pub(super) const ZERO_MPA: f64 = 0.01;

/// Such readings of one whisker.
#[derive(Debug, Default, Clone, Copy)]
pub(super) struct BelowZero {
    /// Readings that were taken as 0.
    pub(super) readings: u64,
    /// The lowest one, in MPa.
    pub(super) lowest_mpa: f64,
}

impl BelowZero {
    /// The pressure that a reading stands for, and whether it is the first one below zero.
    pub(super) fn clamp(&mut self, mpa: f64) -> (f64, bool) {
        if !(-ZERO_MPA..0.0).contains(&mpa) {
            return (mpa, false);
        }
        self.readings += 1;
        self.lowest_mpa = self.lowest_mpa.min(mpa);
        (0.0, self.readings == 1)
    }
}
