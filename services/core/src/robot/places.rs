//! Where a robot's whiskers are among its indices: at hand for every contact, without a look at the whiskers themselves.

use super::Robot;
use super::effect::WhiskerIndex;

/// The whiskers' arrays and numbers, by index.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Places {
    of: Vec<(u16, u16)>,
    /// The first index of each array.
    firsts: Vec<u32>,
}

impl Robot {
    /// Index of a whisker.
    pub(super) fn place(&self, array: u16, number: u16) -> Option<WhiskerIndex> {
        let Places { of, firsts } = &self.places;
        let first = *firsts.get(usize::from(array))? as usize;
        // Mostly they are numbered one after another.
        let guess = first + usize::from(number.wrapping_sub(of.get(first)?.1));
        if of.get(guess) == Some(&(array, number)) {
            return Some(guess);
        }
        of[first..].iter().position(|&one| one == (array, number)).map(|at| first + at)
    }

    /// After the layout has become another.
    pub(super) fn index_places(&mut self) {
        self.places.of = self.whiskers.iter().map(|one| (one.array, one.sheet.number)).collect();
        let first = |array: usize| self.whiskers.iter().position(|one| usize::from(one.array) == array);
        let firsts = (0..self.arrays.len()).map(|array| first(array).unwrap_or(self.whiskers.len()) as u32);
        self.places.firsts = firsts.collect();
        // No contact shall have to make room.
        self.touched = Vec::with_capacity(self.whiskers.len());
        self.whiskers.iter_mut().for_each(|one| one.touched = false);
    }
}
