//! Receipts that robots do not hear, and factsheets that do not arrive.

use std::time::Duration;

use tokio::time::Instant;
use tracing::warn;
use vibrissa_core::units::Micros;
use vibrissa_protocol::RobotTopic;

use super::Engine;
use super::worker::Found;
use crate::promises::Promise;

/// Receipts that have waited for longer have not reached the robots, which therefore send again.
const RECEIPTS_LATE: Duration = Duration::from_secs(2);
/// Names of these parts in the service's readiness.
const FACTSHEETS: &str = "factsheets";
const RECEIPTS: &str = "receipts";

impl Engine {
    /// Judges whether robots hear their receipts, and whether factsheets arrive.
    pub(super) fn judge_hearing(&mut self, now: Micros) {
        let is_late = self.promises.age(Promise::Receipted).is_some_and(|age| age > RECEIPTS_LATE);
        let (mut without, mut deaf) = (Found::default(), Found::default());
        for worker in self.workers.iter_mut() {
            worker.judge_receipts(now, is_late, &mut deaf);
            worker.find_without_factsheet(Instant::now(), &mut without);
        }
        self.metrics.robots_without_factsheet.set(without.count);
        let lacked = std::mem::replace(&mut self.lacked_factsheets, without.one.is_some());
        let notice = without.one.map(|robot| {
            let topic = RobotTopic::Factsheet.of(&self.fleet, &robot);
            let notice = format!(
                "{} robot(s) announced themselves, and no factsheet has arrived or was accepted: let them publish topics such \
                 as {topic} in the broker's access list, check its limit of the size of packets, and correct a refused factsheet",
                without.count
            );
            if !lacked {
                warn!(fleet = %self.fleet, "{notice}");
            }
            notice
        });
        self.readiness.notice_of(&self.fleet, FACTSHEETS, notice);
        let notice = deaf.one.map(|robot| {
            let topic = RobotTopic::Receipt.of(&self.fleet, &robot);
            format!(
                "{} robot(s) send contacts again that have receipts: let them read topics such as {topic} in the broker's \
                 access list",
                deaf.count
            )
        });
        self.readiness.notice_of(&self.fleet, RECEIPTS, notice);
    }
}
