//! Whether robots hear this supervisor, and whether their factsheets arrive.

use std::time::Duration;

use tokio::time::Instant;
use tracing::warn;
use vibrissa_core::robot::effect::{AlarmKind, Effect};
use vibrissa_core::robot::event::Link;
use vibrissa_core::units::Micros;
use vibrissa_protocol::{Name, RobotTopic};

use super::Worker;

/// How long a robot may be announced without a factsheet: it is requested several times in between.
const FACTSHEET_PATIENCE: Duration = Duration::from_secs(30);

/// Robots with a trouble: their number, and the name of one.
#[derive(Debug, Default)]
pub(crate) struct Found {
    pub(crate) count: i64,
    pub(crate) one: Option<Name>,
}

impl Found {
    fn add(&mut self, robot: &Name) {
        self.count += 1;
        self.one.get_or_insert_with(|| robot.clone());
    }
}

impl Worker {
    /// Raises the alarm of robots that do not hear their receipts, and clears it. Adds those whose alarm stands to `deaf`.
    /// `is_late` says that receipts could not be sent: then repeats say nothing about robots.
    pub(crate) fn judge_receipts(&mut self, now: Micros, is_late: bool, deaf: &mut Found) {
        for known in self.robots.values_mut().filter(|known| !known.rests) {
            let change = if is_late { None } else { known.repeats.take_change(now) };
            if known.repeats.stands() {
                deaf.add(&known.name);
            }
            if is_late {
                known.repeats.excuse();
            }
            let Some(is_unheard) = change else { continue };
            let kind = AlarmKind::ReceiptsUnheard;
            let effect = if is_unheard {
                let topic = RobotTopic::Receipt.of(&self.stepper.fleet, &known.name).to_string();
                warn!(robot = %known.full_name(), topic, "the robot sends contacts again that were receipted on this topic");
                Effect::RobotAlarm { kind }
            } else {
                Effect::RobotAlarmCleared { kind }
            };
            self.stepper.record(known, now, effect, None);
        }
    }

    /// Forgets repeated contacts and how long factsheets are missing, because this supervisor stood still until `now`.
    pub(crate) fn excuse_standstill(&mut self, now: Instant) {
        for known in self.robots.values_mut() {
            known.repeats.excuse();
            known.factsheet_missing = known.factsheet_missing.map(|_| now);
        }
        self.announced.excuse_standstill(now);
    }

    /// Adds the robots that have announced themselves and whose factsheets have not arrived in time.
    pub(crate) fn find_without_factsheet(&mut self, now: Instant, without: &mut Found) {
        for known in self.robots.values_mut() {
            let (boot_id, link) = known.robot.connection_state();
            let is_numbered = boot_id.is_none_or(|boot_id| known.boots.get(boot_id).is_some());
            // A broker may break the connection because of the factsheet, again and again.
            let is_expected = link == Link::Online || (link == Link::Broken && known.factsheet_missing.is_some());
            let is_missing = !is_numbered && is_expected && known.refused_boot.is_none();
            known.factsheet_missing = is_missing.then(|| known.factsheet_missing.unwrap_or(now));
            if known.factsheet_missing.is_some_and(|since| now.saturating_duration_since(since) >= FACTSHEET_PATIENCE) {
                without.add(&known.name);
            }
        }
        self.announced.overdue(now, FACTSHEET_PATIENCE).for_each(|name| without.add(name));
    }
}
