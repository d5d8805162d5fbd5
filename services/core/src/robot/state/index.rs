//! Index of a robot's whiskers by array and number.

use crate::robot::Robot;
use crate::robot::effect::WhiskerIndex;

/// Arrays and numbers of the whiskers, in the order of their indices, so that a search need not read the whiskers
/// themselves.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(in crate::robot) struct WhiskerIndexTable {
    /// Array and number of each whisker.
    whiskers: Vec<(u16, u16)>,
    /// Index and number of the first whisker of each array.
    arrays: Vec<(u32, u16)>,
}

impl Robot {
    /// Index of a whisker.
    pub(in crate::robot) fn place(&self, array: u16, number: u16) -> Option<WhiskerIndex> {
        let &(first, first_number) = self.index.arrays.get(usize::from(array))?;
        let first = first as usize;
        // Whiskers are mostly numbered without gaps. The guess then reads only the whisker that the caller reads next.
        let guess = first + usize::from(number.wrapping_sub(first_number));
        if self.whiskers.get(guess).is_some_and(|one| (one.array, one.sheet.number) == (array, number)) {
            return Some(guess);
        }
        let rest = self.index.whiskers.get(first..)?;
        rest.iter().position(|&one| one == (array, number)).map(|at| first + at)
    }

    /// Renews the index after a change of the layout.
    pub(in crate::robot) fn renew_index(&mut self) {
        let whiskers: Vec<(u16, u16)> = self.whiskers.iter().map(|one| (one.array, one.sheet.number)).collect();
        let first_of = |array: usize| {
            let first = whiskers.iter().position(|&(of, _)| usize::from(of) == array).unwrap_or(whiskers.len());
            (first as u32, whiskers.get(first).map_or(0, |&(_, number)| number))
        };
        let arrays = (0..self.head.arrays.len()).map(first_of).collect();
        self.index = WhiskerIndexTable { whiskers, arrays };
    }
}
