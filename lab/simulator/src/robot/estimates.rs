//! Estimates of the whiskers' present lengths.

use vibrissa_protocol::Estimate;

use super::Robot;

impl Robot {
    /// Takes an estimate that the robot accepts. A whisker that is not listed has none.
    pub(super) fn estimate(&mut self, estimate: &Estimate) {
        self.whiskers.iter_mut().for_each(|whisker| whisker.estimated_mm = None);
        for entry in &estimate.whiskers {
            let at = self.places.get(&(entry.array.clone(), entry.whisker));
            if let Some(whisker) = at.and_then(|&at| self.whiskers.get_mut(at)) {
                whisker.estimated_mm = Some(entry.length_mm);
                whisker.gain.estimated(entry.pressure_mpa, entry.reading_gain);
            }
        }
    }
}
