//! Where a robot's whiskers are among its indices.

use crate::robot::Robot;
use crate::robot::effect::WhiskerIndex;

/// The whiskers' arrays and numbers, by index: searched where numbers do not follow one another, without a look at the
/// whiskers themselves.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(in crate::robot) struct Places(Vec<(u16, u16)>);

impl Robot {
    /// Index of a whisker.
    pub(in crate::robot) fn place(&self, array: u16, number: u16) -> Option<WhiskerIndex> {
        let (first, first_number) = self.arrays.get(usize::from(array))?.first;
        let first = first as usize;
        // Mostly they are numbered one after another. Then it is the whisker that is looked at next anyway.
        let guess = first + usize::from(number.wrapping_sub(first_number));
        if self.whiskers.get(guess).is_some_and(|one| (one.array, one.sheet.number) == (array, number)) {
            return Some(guess);
        }
        let rest = self.places.0.get(first..)?;
        rest.iter().position(|&one| one == (array, number)).map(|at| first + at)
    }

    /// After the layout has become another.
    pub(in crate::robot) fn index_places(&mut self) {
        self.places.0 = self.whiskers.iter().map(|one| (one.array, one.sheet.number)).collect();
        for (index, array) in self.arrays.iter_mut().enumerate() {
            let first = self.places.0.iter().position(|&(of, _)| usize::from(of) == index);
            let first = first.unwrap_or(self.whiskers.len());
            array.first = (first as u32, self.places.0.get(first).map_or(0, |&(_, number)| number));
        }
        self.touched.clear();
        self.whiskers.iter_mut().for_each(|one| one.touched = false);
    }
}
