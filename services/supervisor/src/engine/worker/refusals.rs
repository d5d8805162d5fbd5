//! Counts of refusals, and of stored items that cannot be read, of all workers.

use std::collections::BTreeSet;

use vibrissa_store::refusals::RefusalRow;

use super::workers::Workers;
use crate::set_aside::Reader;

impl Workers {
    /// Counts a stored item of all workers that cannot be read.
    pub(crate) fn count_set_aside(&mut self, reader: Reader) {
        if let Some(worker) = self.iter_mut().next() {
            worker.stepper_mut().count_set_aside(reader, 1);
        }
    }

    /// Number of stored items that could not be read.
    pub(crate) fn set_aside(&self) -> u64 {
        self.iter().map(|worker| worker.stepper().set_aside()).sum()
    }

    /// Refusals since they were last written, as rows of at most so many robots.
    pub(crate) fn refusals(&self, robots_max: usize) -> Vec<RefusalRow> {
        let of_each = self.robots().map(|known| known.refusals.rows(known.robot_id).collect::<Vec<_>>());
        of_each.filter(|rows| !rows.is_empty()).take(robots_max).flatten().collect()
    }

    /// Notes that these rows are written.
    pub(crate) fn refusals_written(&mut self, rows: &[RefusalRow]) {
        let written: BTreeSet<i64> = rows.iter().map(|row| row.robot_id).collect();
        for known in self.robots_mut().filter(|known| written.contains(&known.robot_id)) {
            known.refusals.written();
        }
    }
}
