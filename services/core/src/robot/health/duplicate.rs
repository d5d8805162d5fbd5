//! Two robots under one name, as from copies of one disk. Each connects with its own boot, and takes the other's place.
//!
//! A boot that a newer one has replaced does not come back: a robot has one boot at a time. If replaced boots say again and
//! again that they are online, there are two robots. Then nothing is learned and no setpoint goes out: contacts of either would
//! be mixed into one history, and nobody knows whose chamber a setpoint would move. Contacts are not receipted, so the robots
//! keep them. The connection's state means nothing meanwhile, so neither silence nor a lost connection is an alarm.

use borsh::{BorshDeserialize, BorshSerialize};

use crate::robot::Robot;
use crate::robot::effect::{AlarmKind, Effect};
use crate::units::Micros;

/// Births of replaced boots, each at most [`WINDOW`] after the one before, that show two robots. A single one may be a message
/// that the broker has kept.
const RETURNS: u8 = 3;
/// Without such a birth for this long there is one robot again.
const WINDOW: Micros = Micros(60_000_000);

/// Watch for a second robot of the same name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, BorshSerialize, BorshDeserialize)]
pub(in crate::robot) struct DuplicateWatch {
    /// Births of replaced boots in a row.
    returns: u8,
    /// Time of the last one.
    last: Micros,
    /// The alarm stands.
    pub stands: bool,
}

crate::optional_parts::optional_fields!(DuplicateWatch: last; returns: *returns > 0, stands: *stands);

impl Robot {
    /// Whether a newer boot has replaced this one. Only the newest replaced boots are known.
    #[must_use]
    pub fn is_replaced(&self, boot_id: &str) -> bool {
        self.head.boot_id.as_ref().is_some_and(|newest| *newest != *boot_id) && self.head.sequences.is_old(boot_id)
    }

    /// Two robots use the name: nothing is learned, and no setpoint goes out.
    pub(in crate::robot) fn is_duplicated(&self) -> bool {
        self.head.duplicate.stands
    }

    /// A replaced boot says that it is online.
    pub(in crate::robot) fn boot_returned(&mut self, now: Micros, effects: &mut Vec<Effect>) {
        let watch = &mut self.head.duplicate;
        let goes_on = watch.returns > 0 && now.since(watch.last) <= WINDOW;
        watch.returns = if goes_on { watch.returns.saturating_add(1) } else { 1 };
        watch.last = now;
        if watch.returns >= RETURNS && !watch.stands {
            watch.stands = true;
            if std::mem::take(&mut self.head.silent) {
                // It was thrown off by the other one.
                effects.push(Effect::RobotAlarmCleared { kind: AlarmKind::RobotSilent });
            }
            effects.push(Effect::RobotAlarm { kind: AlarmKind::DuplicateRobot });
        }
    }

    /// Ends the alarm once only one robot has been heard for a while.
    pub(in crate::robot) fn tell_duplicate(&mut self, now: Micros, effects: &mut Vec<Effect>) {
        if !self.is_duplicated() || now.since(self.head.duplicate.last) <= WINDOW {
            return;
        }
        self.head.duplicate = DuplicateWatch::default();
        self.listen_from(now);
        effects.push(Effect::RobotAlarmCleared { kind: AlarmKind::DuplicateRobot });
    }
}
