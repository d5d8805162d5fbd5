//! What this supervisor and its robots do not hear of each other: receipts, factsheets, and all that comes while this
//! supervisor is deaf or stands still.

use std::time::Duration;

use tokio::time::Instant;
use tracing::{info, warn};
use vibrissa_core::units::Micros;
use vibrissa_edge::clock::wall_clock;
use vibrissa_protocol::{Name, RobotTopic};
use vibrissa_store::fault::{self, Fault};

use super::Engine;
use super::worker::Found;
use crate::inbox::Inbox;
use crate::promises::Promise;

/// Receipts that have waited for longer have not reached the robots, which therefore send again.
const RECEIPTS_LATE: Duration = Duration::from_secs(2);
/// The engine does something four times in a second. If it did not for so long, this process stood still or waited for the
/// database, and messages of that time come later or not at all.
const STANDSTILL: Duration = Duration::from_secs(2);
/// Names of these parts in the service's readiness.
const FACTSHEETS: &str = "factsheets";
const RECEIPTS: &str = "receipts";

impl Engine {
    /// Blames no robot for a time in which this process stood still: before anything is judged by the present time.
    pub(super) fn excuse_own_standstill(&mut self) {
        let now = Instant::now();
        let stood_still = now.saturating_duration_since(std::mem::replace(&mut self.awake, now));
        if stood_still > STANDSTILL && !fault::is(Fault::StandstillCounts) {
            let seconds = stood_still.as_secs_f32();
            info!(fleet = %self.fleet, seconds, "supervision stood still: no robot is blamed for silence until now");
            self.restart_silence_timers();
            self.workers.iter_mut().for_each(|worker| worker.excuse_standstill(now));
        }
    }

    /// Restarts silence timers after the broker was unreachable or messages were shed, because the robots may have
    /// sent.
    pub(super) fn restart_silence_timers_if_deaf(&mut self, inbox: &Inbox) {
        let (robots, others) = inbox.take_shed();
        let is_log_away = self.log.as_ref().is_some_and(|log| !log.link().hears());
        if !inbox.link().hears() || others > 0 || is_log_away {
            return self.restart_silence_timers();
        }
        let now = wall_clock();
        let names = robots.iter().filter_map(|shed| Name::robot(std::str::from_utf8(&shed.robot).ok()?).ok());
        for name in names {
            self.workers.of(&name).restart_silence_timer(&name, now);
        }
    }

    /// Restarts the silence timers of all robots, because this supervisor was deaf.
    pub(super) fn restart_silence_timers(&mut self) {
        self.workers.restart_silence_timers(wall_clock());
    }

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
