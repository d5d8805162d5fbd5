//! Receipts that robots do not hear, and factsheets that do not arrive.

use std::time::{Duration, Instant};

use vibrissa_core::units::Micros;
use vibrissa_protocol::RobotTopic;

use super::Engine;
use crate::promises::Promise;

/// Receipts that have waited for longer have not reached the robots, which therefore send again.
const RECEIPTS_LATE: Duration = Duration::from_secs(2);
/// Name of this part in the service's readiness.
const PART: &str = "engine";

impl Engine {
    /// Judges whether robots hear their receipts, and whether factsheets arrive.
    pub(super) fn judge_hearing(&mut self, now: Micros) {
        let is_late = self.metrics.promises.age(Promise::Receipted).is_some_and(|age| age > RECEIPTS_LATE);
        let (mut missing, mut one) = (0, None);
        for shard in self.shards.iter_mut() {
            shard.judge_receipts(now, is_late);
            let (count, name) = shard.without_factsheet(Instant::now());
            missing += count;
            one = one.or(name);
        }
        self.metrics.robots_without_factsheet.set(missing);
        let notice = one.map(|robot| {
            let topic = RobotTopic::Factsheet.of(&self.fleet, &robot);
            format!(
                "{missing} robot(s) announced themselves, and no factsheet has arrived: let them publish topics such as \
                 {topic} in the broker's access list, and check its limit of the size of packets"
            )
        });
        self.readiness.notice_of(&self.place, PART, notice);
    }
}
