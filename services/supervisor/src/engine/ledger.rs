//! The budget of a robot and of a fleet: bytes that their effects may add to the database, at once and over time.
//!
//! [`cost`] has the price of every effect, in one place. Repetitive effects beyond a budget are not recorded; others always
//! are, and charge the account all the same, so repetitive ones wait longer. The births and new layouts of a robot whose
//! account is empty are refused. Nothing that decides is lost: rows about repetitive changes are for people only, because the
//! robot's checkpoint has its state.
//!
//! Contacts are not charged. Receipts promise their rows, the inbox bounds their rate, and `contacts.days` their number.

use vibrissa_core::robot::effect::{Condition, Effect};
use vibrissa_core::units::Micros;

/// Bytes at once, and the bytes per second that refill an empty account.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Budget {
    pub(crate) at_once: i64,
    pub(crate) per_second: i64,
}

/// A robot's budget: as many changes as two outages of a robot of 1,900 whiskers cause at once, then 88 MB a day.
pub(crate) const ROBOT: Budget = Budget { at_once: 4 << 20, per_second: 1 << 10 };
/// A fleet's budget, or that of each of its workers: an outage of all 10,000 robots of 24 whiskers, then 45 GB a day.
pub(crate) const FLEET: Budget = Budget { at_once: 256 << 20, per_second: 512 << 10 };

/// Bytes of a whisker's or a robot's row with its state.
const LAYOUT_ROW: i64 = 1024;
/// Bytes of a row with its indices and its entry in the feed of changes.
const ROW: i64 = 300;

/// The bytes that a robot or a fleet may still add to the database.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Account {
    /// Bytes charged and not refilled yet, and the time of that; an unused account is full.
    owed: f64,
    at: Micros,
}

impl Account {
    /// Charges bytes. Beyond twice the budget nothing more is owed, so that an account recovers.
    pub(crate) fn charge(&mut self, budget: Budget, now: Micros, bytes: i64) {
        let owed = self.owed_at(budget, now) + bytes as f64;
        (self.owed, self.at) = (owed.min(2.0 * budget.at_once as f64), now);
    }

    /// Whether bytes are within the budget. A full account affords any number once.
    pub(crate) fn affords(&self, budget: Budget, now: Micros, bytes: i64) -> bool {
        let owed = self.owed_at(budget, now);
        owed <= 0.0 || owed + bytes as f64 <= budget.at_once as f64
    }

    fn owed_at(&self, budget: Budget, now: Micros) -> f64 {
        (self.owed - now.since(self.at).as_s() * budget.per_second as f64).max(0.0)
    }
}

/// The bytes that an effect adds to the database, about, and whether it may be left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Cost {
    /// It is always recorded.
    Necessary(i64),
    /// It tells of a change that comes and goes, and may be left out.
    Repetitive(i64),
}

/// The price of an effect.
pub(crate) fn cost(effect: &Effect) -> Cost {
    match effect {
        Effect::Contact(_)
        | Effect::UnknownWhisker { .. }
        | Effect::BadTime { .. }
        | Effect::MissedTouch { .. }
        | Effect::Resend(_)
        | Effect::AskForFactsheet => Cost::Necessary(0),
        Effect::Condition { from: Condition::Suspected, to: Condition::Healthy, .. }
        | Effect::Condition { from: Condition::Healthy, to: Condition::Suspected, .. }
        | Effect::Fault { .. } => Cost::Repetitive(ROW),
        Effect::Condition { .. }
        | Effect::Approved { .. }
        | Effect::Ended { .. }
        | Effect::TestState { .. }
        | Effect::CommandState { .. }
        | Effect::Response(_) => Cost::Necessary(ROW),
        // With their events for webhooks and other programs.
        Effect::Alarm { .. }
        | Effect::AlarmCleared { .. }
        | Effect::RobotAlarm { .. }
        | Effect::RobotAlarmCleared { .. }
        | Effect::Gone { .. }
        | Effect::Trim(_)
        | Effect::Command(_)
        | Effect::Refined(_)
        | Effect::Test(_)
        | Effect::TestProposed(_) => Cost::Necessary(2 * ROW),
        Effect::Decided(decision) => Cost::Necessary(ROW * (2 + decision.candidates.len() as i64)),
        Effect::Error(error) => Cost::Necessary(ROW * (1 + error.bins.len() as i64)),
    }
}

/// The price of a layout with so many whiskers that have no rows yet.
pub(crate) fn layout_cost(new_whiskers: usize) -> i64 {
    LAYOUT_ROW.saturating_mul(new_whiskers as i64)
}

/// Charges an effect to the accounts of a robot and its fleet. Returns false if it is not recorded.
pub(crate) fn admit(robot: &mut Account, fleet: &mut Account, now: Micros, effect: &Effect) -> bool {
    let bytes = match cost(effect) {
        Cost::Necessary(0) => return true,
        Cost::Necessary(bytes) => bytes,
        Cost::Repetitive(bytes) => {
            if !(robot.affords(ROBOT, now, bytes) && fleet.affords(FLEET, now, bytes)) {
                return false;
            }
            bytes
        }
    };
    robot.charge(ROBOT, now, bytes);
    fleet.charge(FLEET, now, bytes);
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use vibrissa_core::robot::effect::{AlarmKind, Fault};

    const START: Micros = Micros(1_795_260_000_000_000);
    const CHANGE: Effect = Effect::Fault { whisker: 0, from: None, to: Some(Fault::Leak) };
    const ALARM: Effect = Effect::Alarm { whisker: 0, kind: AlarmKind::Fault(Fault::Leak) };

    fn at(seconds: f64) -> Micros {
        START.after(Micros::from_s(seconds))
    }

    #[test]
    fn regress_a_robot_that_changes_without_end_adds_no_more_than_its_budget() {
        let (mut robot, mut fleet) = (Account::default(), Account::default());
        let mut recorded = 0;
        // Ten minutes of 1,900 whiskers, ten changes each a second.
        for ms in (0..600_000).step_by(100) {
            for _ in 0..1900 {
                recorded += i64::from(admit(&mut robot, &mut fleet, at(f64::from(ms) / 1e3), &CHANGE));
            }
        }
        assert!(recorded * ROW <= ROBOT.at_once + 600 * ROBOT.per_second, "{recorded} rows");
        assert!(recorded * ROW >= ROBOT.at_once, "{recorded} rows");
        // Another robot is not affected, and an alarm is always recorded.
        assert!(admit(&mut Account::default(), &mut fleet, at(600.0), &CHANGE));
        assert!(admit(&mut robot, &mut fleet, at(600.0), &ALARM));
    }

    #[test]
    fn an_account_recovers_from_whatever_it_owes() {
        let mut robot = Account::default();
        robot.charge(ROBOT, START, i64::MAX);
        let recovered_s = (ROBOT.at_once / ROBOT.per_second) as f64;
        assert!(!robot.affords(ROBOT, at(recovered_s - 10.0), ROW));
        assert!(robot.affords(ROBOT, at(recovered_s + 10.0), ROW));
        // A clock that steps back refills nothing, and stops nothing for good.
        robot.charge(ROBOT, Micros(0), ROW);
        assert!(robot.affords(ROBOT, at(0.0), ROW));
    }

    #[test]
    fn a_full_account_affords_a_layout_of_any_size_once() {
        let mut robot = Account::default();
        let bytes = layout_cost(65_536);
        assert!(robot.affords(ROBOT, START, bytes));
        robot.charge(ROBOT, START, bytes);
        assert!(!robot.affords(ROBOT, START, layout_cost(1)));
    }

    #[test]
    fn property_no_account_gives_more_than_its_budget() {
        for (at_once, per_second) in [(1000, 1), (300, 100), (5000, 5000)] {
            let budget = Budget { at_once, per_second };
            let (mut account, mut given) = (Account::default(), 0);
            for step in 0..20_000_i64 {
                let (now, bytes) = (at(step as f64 * 0.037), 1 + step * 7919 % 293);
                if account.affords(budget, now, bytes) {
                    account.charge(budget, now, bytes);
                    given += bytes;
                }
                let over_time = (step as f64 * 0.037 * per_second as f64) as i64;
                assert!(given <= at_once + over_time + 293, "{given} after {step} steps");
            }
        }
    }
}
