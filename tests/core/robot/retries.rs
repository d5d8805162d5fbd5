//! Setpoints that fail: how often they are tried again, and when the alarm ends.

use vibrissa_core::robot::effect::{AlarmKind, Command, Effect};
use vibrissa_core::robot::event::{GaugeState, RegulatorState, Rejection, SetpointReport, WhiskerStatus};
use vibrissa_core::robot::{ActionProblem, Event, OperatorAction, Outcome, Place, Scope};
use vibrissa_core::units::Megapascal;

use crate::by_hand::{ARRAY, ByHand};

const WHISKER: Place<'_> = Place { array: ARRAY, whisker: 0 };
const RAISED: (bool, AlarmKind) = (true, AlarmKind::SetpointFailed);
const CLEARED: (bool, AlarmKind) = (false, AlarmKind::SetpointFailed);

/// Answer of a robot to a setpoint; `None` if it does not answer.
type RobotAnswer = Option<SetpointReport>;

const APPLIED: RobotAnswer = Some(SetpointReport::Applied(Megapascal::ZERO));
const NOT_READY: RobotAnswer = Some(SetpointReport::Rejected(Rejection::NotReady));
const IN_TASK: RobotAnswer = Some(SetpointReport::Rejected(Rejection::InTask));
const TOO_LATE: RobotAnswer = Some(SetpointReport::Rejected(Rejection::Expired));

/// A robot, and the number of its effects that were looked at.
struct Trial {
    one: ByHand,
    seen: usize,
}

/// A robot whose whisker holds 0.05 MPa by hand, and was released a moment ago: it shall go back to 0.1 MPa.
fn released() -> Trial {
    let mut one = ByHand::born(70.0);
    for _ in 0..5 {
        one.passes_s(1.0);
        one.status(0);
    }
    let command = one.asked_for(0.05).expect("a setpoint");
    answers(&mut one, &command, APPLIED);
    one.effects.clear();
    let release = OperatorAction::Release(Scope::Whisker(WHISKER));
    assert_eq!(one.step(&Event::Operator(&release)), Outcome::Taken);
    Trial { one, seen: 0 }
}

fn answers(one: &mut ByHand, command: &Command, answer: RobotAnswer) {
    let Some(report) = answer else { return };
    let event = Event::Setpoint { boot_id: "b1", command: command.key, report, robot_time: one.now };
    one.step(&event);
}

fn reports(one: &mut ByHand) {
    let (pressure, robot_time) = (Megapascal::known(0.05), one.now);
    let (regulator, gauge) = (RegulatorState::Ok, GaugeState::Ok);
    let status = WhiskerStatus { array: ARRAY, whisker: 0, pressure, setpoint: pressure, regulator, gauge };
    one.step(&Event::Status { boot_id: "b1", robot_time, whiskers: &[status] });
}

impl Trial {
    /// Lets seconds pass, in which the robot is heard where `hears` says so, and answers each setpoint. Returns the number of
    /// setpoints.
    fn pass(&mut self, seconds: u32, hears: impl Fn(u32) -> bool, answer: RobotAnswer) -> usize {
        let mut count = 0;
        for second in 0..seconds {
            let commands = self.one.commands_from(self.seen);
            self.seen = self.one.effects.len();
            count += commands.len();
            for command in &commands {
                answers(&mut self.one, command, answer);
            }
            self.one.passes_s(1.0);
            if hears(second) {
                reports(&mut self.one);
            }
            self.one.step(&Event::Tick);
        }
        count
    }

    fn asks(&mut self, action: &OperatorAction<'_>) -> Outcome {
        self.one.step(&Event::Operator(action))
    }
}

/// Alarms that were raised (true) and cleared, of setpoints alone.
fn alarms(trial: &Trial) -> Vec<(bool, AlarmKind)> {
    let alarm = |effect: &Effect| match effect {
        Effect::Alarm { kind, .. } => Some((true, *kind)),
        Effect::AlarmCleared { kind, .. } => Some((false, *kind)),
        _ => None,
    };
    trial.one.effects.iter().filter_map(alarm).filter(|(_, kind)| *kind == AlarmKind::SetpointFailed).collect()
}

/// 17 setpoints expired during a stall of the machine, and five alarms stood for good.
#[test]
fn regress_failed_setpoints_are_tried_again_until_the_robot_takes_one() {
    for answer in [None, NOT_READY, TOO_LATE] {
        let mut one = released();
        let few = one.pass(60, |_| true, answer);
        assert!((3..=4).contains(&few), "{answer:?}: {few} setpoints in a minute");
        assert_eq!(alarms(&one), [RAISED], "{answer:?}");
        let more = one.pass(7200, |_| true, answer);
        assert!((5..=9).contains(&more), "{answer:?}: {more} setpoints in two hours");
        assert_eq!(alarms(&one), [RAISED], "{answer:?}: the alarm must stand during each try");
        assert_eq!(one.pass(3700, |_| true, APPLIED), 1, "{answer:?}");
        assert_eq!(alarms(&one), [RAISED, CLEARED], "{answer:?}");
        assert_eq!(one.pass(3700, |_| true, APPLIED), 0, "{answer:?}");
    }
}

/// A robot that works is no robot that fails.
#[test]
fn a_task_of_any_length_raises_no_alarm_and_the_setpoint_comes_within_minutes_of_its_end() {
    let mut one = released();
    let in_an_hour = one.pass(3600, |_| true, IN_TASK);
    assert!((10..=20).contains(&in_an_hour), "{in_an_hour} setpoints in an hour");
    let later = one.pass(4 * 3600, |_| true, IN_TASK);
    assert!((40..=50).contains(&later), "{later} setpoints in four hours");
    assert_eq!(one.pass(310, |_| true, APPLIED), 1);
    assert_eq!(alarms(&one), []);
    assert_eq!(one.pass(3700, |_| true, APPLIED), 0);
}

/// Failures before and after a task count as they did.
#[test]
fn a_task_forgives_no_failed_try() {
    let mut one = released();
    assert!(one.pass(4, |_| true, NOT_READY) <= 2);
    one.pass(600, |_| true, IN_TASK);
    one.pass(600, |_| true, NOT_READY);
    assert_eq!(alarms(&one), [RAISED]);
    one.pass(7200, |_| true, IN_TASK);
    assert_eq!(alarms(&one), [RAISED], "no try has succeeded");
    one.pass(3700, |_| true, APPLIED);
    assert_eq!(alarms(&one), [RAISED, CLEARED]);
}

#[test]
fn after_an_outage_of_some_minutes_the_next_try_comes_within_as_long() {
    let mut one = released();
    one.pass(200, |_| true, TOO_LATE);
    assert_eq!(alarms(&one), [RAISED]);
    assert!(one.pass(200, |_| true, APPLIED) >= 1);
    assert_eq!(alarms(&one), [RAISED, CLEARED]);
}

#[test]
fn silence_during_a_try_raises_no_alarm_and_the_first_try_after_it_succeeds() {
    let mut one = released();
    let in_vain = one.pass(120, |_| false, None);
    assert!((1..=2).contains(&in_vain), "{in_vain}");
    assert_eq!(one.pass(15, |_| true, APPLIED), 1);
    assert_eq!(alarms(&one), []);
}

/// One setpoint was sent every 40 s, up to 312 times, to a robot that was heard between, and never took it.
#[test]
fn regress_a_robot_that_is_heard_now_and_then_is_not_sent_the_same_for_ever() {
    let mut one = released();
    let sent = one.pass(312 * 40, |second| second % 40 == 0, None);
    assert!(sent <= 20, "{sent} setpoints");
    assert_eq!(alarms(&one), [RAISED]);
}

#[test]
fn a_refusal_and_a_pressure_that_is_not_reached_wait_for_an_operator() {
    let refused = [Rejection::Stale, Rejection::OutOfRange].map(|why| Some(SetpointReport::Rejected(why)));
    for (answer, tries) in [(Some(SetpointReport::Failed), 3), (refused[0], 1), (refused[1], 1)] {
        let mut one = released();
        let retry = |one: &mut Trial| one.asks(&OperatorAction::Retry(WHISKER));
        assert_eq!(retry(&mut one), Outcome::Refused(ActionProblem::NoFailedSetpoint));
        assert_eq!(one.pass(7200, |_| true, answer), tries, "{answer:?}");
        assert_eq!(alarms(&one), [RAISED], "{answer:?}");
        assert_eq!(retry(&mut one), Outcome::Taken);
        assert_eq!(alarms(&one), [RAISED, CLEARED], "{answer:?}");
        assert_eq!(one.pass(60, |_| true, answer), tries, "{answer:?}");
        assert_eq!(retry(&mut one), Outcome::Taken);
        assert_eq!(one.pass(60, |_| true, APPLIED), 1, "{answer:?}");
        assert_eq!(alarms(&one), [RAISED, CLEARED, RAISED, CLEARED], "{answer:?}");
        one.asks(&OperatorAction::Hold(Scope::Whisker(WHISKER)));
        assert_eq!(retry(&mut one), Outcome::Refused(ActionProblem::NoFailedSetpoint));
    }
}
