//! Whether robots hear this supervisor, and whether their factsheets arrive.

use std::time::{Duration, Instant};

use tracing::warn;
use vibrissa_core::robot::effect::{AlarmKind, Effect};
use vibrissa_core::robot::event::Link;
use vibrissa_core::units::Micros;
use vibrissa_protocol::{Name, RobotTopic};

use super::Shard;

/// How long a robot may be announced without a factsheet: it is requested several times in between.
const FACTSHEET_PATIENCE: Duration = Duration::from_secs(30);

impl Shard {
    /// Raises the alarm of robots that do not hear their receipts, and clears it. `is_late` says that receipts could not be
    /// sent: then repeats say nothing about robots.
    pub(crate) fn judge_receipts(&mut self, now: Micros, is_late: bool) {
        for known in self.robots.values_mut().filter(|known| !known.rests) {
            if is_late {
                known.repeats.excuse();
                continue;
            }
            let Some(is_unheard) = known.repeats.take_change(now) else { continue };
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

    /// Number of robots that have announced themselves and whose factsheets have not arrived in time, and the name of one.
    pub(crate) fn without_factsheet(&mut self, now: Instant) -> (i64, Option<Name>) {
        let (mut count, mut one) = (0, None);
        for known in self.robots.values_mut() {
            let (boot_id, link) = known.robot.connection_state();
            let is_numbered = boot_id.is_none_or(|boot_id| known.boots.get(boot_id).is_some());
            let is_missing = !is_numbered && link == Link::Online && known.refused_boot.is_none();
            known.factsheet_missing = is_missing.then(|| known.factsheet_missing.unwrap_or(now));
            if known.factsheet_missing.is_some_and(|since| now.saturating_duration_since(since) >= FACTSHEET_PATIENCE) {
                count += 1;
                one.get_or_insert_with(|| known.name.clone());
            }
        }
        for name in self.announced.overdue(now, FACTSHEET_PATIENCE) {
            count += 1;
            one.get_or_insert_with(|| name.clone());
        }
        (count, one)
    }
}
