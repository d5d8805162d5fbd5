//! Order of the estimates of the whiskers' present lengths.

use vibrissa_protocol::Estimate;

/// Epoch and version of the newest estimate of one boot.
#[derive(Debug, Default)]
pub struct EstimateOrder(Option<(u64, u64)>);

impl EstimateOrder {
    /// Whether to take an estimate: not if the robot has taken a newer one in this boot. A whisker that the estimate does
    /// not list has none.
    pub fn takes(&mut self, estimate: &Estimate) -> bool {
        let is_newer = estimate.is_newer_than(self.0);
        if is_newer {
            self.0 = Some((estimate.epoch, estimate.version));
        }
        is_newer
    }
}
