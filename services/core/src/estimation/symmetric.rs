//! Covariance of the filter's states, stored as half of the symmetric matrix in single precision: relative
//! errors of 1e-7 do not matter in a measure of uncertainty.

use borsh::io::{Read, Result};
use borsh::{BorshDeserialize, BorshSerialize};

use super::innovation::STATES;

/// Entries on the diagonal and above it.
const ENTRIES: usize = STATES * (STATES + 1) / 2;

/// A symmetric matrix.
#[derive(Debug, Clone, Copy, PartialEq, Default, BorshSerialize, BorshDeserialize)]
pub(super) struct Symmetric([f32; ENTRIES]);

/// Index of an entry.
const fn at(row: usize, column: usize) -> usize {
    let (row, column) = if row < column { (row, column) } else { (column, row) };
    row * (2 * STATES - row - 1) / 2 + column
}

/// All entries of one half, as row and column.
fn entries() -> impl Iterator<Item = (usize, usize)> {
    (0..STATES).flat_map(|row| (row..STATES).map(move |column| (row, column)))
}

impl Symmetric {
    /// Diagonal matrix with these entries.
    pub(super) fn diagonal(entries: [f64; STATES]) -> Self {
        let mut one = Self::default();
        entries.into_iter().enumerate().for_each(|(state, value)| one.0[at(state, state)] = value as f32);
        one
    }

    /// Reads the entries of the first states from the matrix that these states alone have.
    pub(super) fn read_first<R: Read>(&mut self, states: usize, reader: &mut R) -> Result<()> {
        for (row, column) in entries().filter(|&(_, column)| column < states) {
            self.0[at(row, column)] = f32::deserialize_reader(reader)?;
        }
        Ok(())
    }

    /// Variance of one state.
    pub(super) fn variance(&self, state: usize) -> f64 {
        self.entry(state, state)
    }

    fn entry(&self, row: usize, column: usize) -> f64 {
        f64::from(self.0[at(row, column)])
    }

    fn add(&mut self, row: usize, column: usize, more: f64) {
        self.0[at(row, column)] = (self.entry(row, column) + more) as f32;
    }

    /// True if every entry is at most `most` in magnitude and no variance is negative. False if any entry is NaN.
    pub(super) fn is_within(&self, most: f64) -> bool {
        let most = most as f32;
        self.0.iter().all(|entry| entry.abs() <= most) && (0..STATES).all(|state| self.0[at(state, state)] >= 0.0)
    }

    /// Adds to the variance of one state.
    pub(super) fn widen(&mut self, state: usize, variance: f64) {
        self.add(state, state, variance);
    }

    /// Product of the matrix and a column.
    pub(super) fn times(&self, column: &[f64; STATES]) -> [f64; STATES] {
        std::array::from_fn(|row| (0..STATES).map(|k| self.entry(row, k) * column[k]).sum())
    }

    /// Adds `column column^T` times a factor.
    pub(super) fn add_square(&mut self, column: &[f64; STATES], factor: f64) {
        for (row, other) in entries() {
            self.add(row, other, column[row] * column[other] * factor);
        }
    }

    /// Multiplies each row and each column by a factor.
    pub(super) fn scale(&mut self, by: &[f64; STATES]) {
        for (row, column) in entries() {
            self.0[at(row, column)] = (self.entry(row, column) * by[row] * by[column]) as f32;
        }
    }

    /// The covariance after a measurement, in Joseph's form, which keeps the matrix positive for any gain:
    /// `(1 - gain row^T) P (1 - gain row^T)^T + gain gain^T noise`.
    pub(super) fn after_reading(&self, row: &[f64; STATES], gain: &[f64; STATES], noise_variance: f64) -> Self {
        let spread = self.times(row);
        let kept = |i: usize, j: usize| self.entry(i, j) - gain[i] * spread[j];
        let variance: f64 = (0..STATES).map(|j| spread[j] * row[j]).sum();
        let seen: [f64; STATES] = std::array::from_fn(|i| spread[i] - gain[i] * variance);
        let mut after = Self::default();
        for (i, j) in entries() {
            after.0[at(i, j)] = (kept(i, j) - seen[i] * gain[j] + gain[i] * gain[j] * noise_variance) as f32;
        }
        after
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{SMatrix, SVector};

    type Matrix = SMatrix<f64, STATES, STATES>;
    type Vector = SVector<f64, STATES>;

    #[test]
    fn property_it_is_what_full_matrices_give() {
        let full = |one: &Symmetric| Matrix::from_fn(|i, j| one.entry(i, j));
        let mut one = Symmetric::diagonal([0.02, 0.04, 2e-3, 4e-4, 1e-3, 5e-3]);
        let mut all = full(&one);
        for step in 0..500 {
            let wave = |k: u32| f64::from(step * (2 * k + 3) % 17) / 17.0 - 0.4;
            let row = [1.0, wave(1), -3.0 + wave(2), wave(3), 4.0 * wave(5), 3.0 * wave(6)];
            let (noise, wide) = (0.01 + 0.02 * (0.4 + wave(4)), if step % 5 == 0 { 3.0 } else { 1.0 });
            let spread = all * Vector::from(row);
            assert!((spread - Vector::from(one.times(&row))).norm() <= 1e-4 * spread.norm());
            let gain = spread / (Vector::from(row).dot(&spread) + wide * noise);
            let keep = Matrix::identity() - gain * Vector::from(row).transpose();
            all = keep * all * keep.transpose() + gain * gain.transpose() * noise;
            one = one.after_reading(&row, &gain.into(), noise);
            one.widen(2, 1e-6);
            all[(2, 2)] += 1e-6;
            one.add_square(&row, 1e-9);
            all += Vector::from(row) * Vector::from(row).transpose() * 1e-9;
            assert!((full(&one) - all).norm() <= 1e-4 * all.norm(), "{step}");
            assert!(full(&one).symmetric_eigenvalues().min() > 0.0, "{step}");
        }
        assert_eq!(one.variance(2), one.entry(2, 2));
    }
}
