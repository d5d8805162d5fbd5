//! Counts of refusals, and of stored items that cannot be read, of all workers.

use std::collections::BTreeMap;

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

    /// Refusals since they were last written, as rows of at most so many robots: those after this robot first, so that
    /// each has its turn.
    pub(crate) fn refusals(&self, robots_max: usize, after_robot_id: i64) -> Vec<RefusalRow> {
        let mut due: Vec<_> = self.robots().filter(|known| known.refusals.are_due()).collect();
        due.sort_unstable_by_key(|known| (known.robot_id <= after_robot_id, known.robot_id));
        due.iter().take(robots_max).flat_map(|known| known.refusals.rows(known.robot_id)).collect()
    }

    /// Notes that these rows are written.
    pub(crate) fn refusals_written(&mut self, rows: &[RefusalRow]) {
        let mut of_robot: BTreeMap<i64, Vec<&RefusalRow>> = BTreeMap::new();
        rows.iter().for_each(|row| of_robot.entry(row.robot_id).or_default().push(row));
        for known in self.robots_mut() {
            for row in of_robot.get(&known.robot_id).into_iter().flatten() {
                known.refusals.written(row);
            }
        }
    }
}
