//! A robot whose state is older than its last setpoints, because a database was restored.

use vibrissa_core::mechanics::Formulation;
use vibrissa_core::robot::effect::{AlarmKind, Command, Effect, Reason};
use vibrissa_core::robot::event::{
    ArrayKind, ArraySheet, Factsheet, GaugeState, Link, RegulatorState, Rejection, SetpointReport, Task, TouchTests,
    WhiskerSheet, WhiskerStatus,
};
use vibrissa_core::robot::{Event, Numbers, OperatorAction, Params, Place, Robot, Scope};
use vibrissa_core::units::{Megapascal, Micros, Millimetre};

pub(crate) const NOMINAL_MPA: f64 = 0.1;
/// As a compensation would have it.
const STRAY_MPA: f64 = 0.0472;

/// A robot with one whisker, and its supervisor's clock.
pub(crate) struct Taken {
    robot: Robot,
    params: Params,
    pub(crate) now: Micros,
}

impl Taken {
    /// The stored bytes of the robot and of its first whisker.
    pub(crate) fn stored(&self) -> [Vec<u8>; 2] {
        [self.robot.to_bytes().unwrap(), self.robot.whisker_to_bytes(0).unwrap()]
    }

    /// Met for the first time, in epoch 1.
    pub(crate) fn first_met() -> Self {
        let sheet = WhiskerSheet {
            number: 0,
            x_mm: 0.0,
            y_mm: 0.0,
            model: "nguyen-2021".to_owned(),
            length: Millimetre::known(70.0),
            pressure: Megapascal::known(NOMINAL_MPA),
            pressure_max: Megapascal::known(0.2),
            length_tolerance_mm: 0.5,
            strain_max: None,
            neighbours: Vec::new(),
        };
        let array =
            ArraySheet { name: "left".to_owned(), kind: ArrayKind::Type2, task: Task::Ratio, whiskers: vec![sheet] };
        let factsheet = Factsheet {
            arrays: vec![array],
            touch_tests: TouchTests::default(),
            applies_gain: false,
            air_control: Default::default(),
        };
        let params = Params::nguyen_2021(Formulation::Published);
        let mut met = Self { robot: Robot::new(1, Numbers::default()), params, now: Micros::from_s(1000.0) };
        met.step(&Event::Connection { boot_id: "b1", link: Link::Online });
        met.step(&Event::Factsheet { boot_id: "b1", factsheet: &factsheet });
        met
    }

    /// The same, taken up in another epoch.
    fn again(mut self, epoch: u64) -> Self {
        let whiskers = [self.robot.whisker_to_bytes(0).unwrap()];
        let head = self.robot.to_bytes().unwrap();
        self.robot = Robot::from_bytes(&head, &whiskers, epoch, self.now).unwrap();
        self
    }

    pub(crate) fn step(&mut self, event: &Event<'_>) -> Vec<Effect> {
        let mut effects = Vec::new();
        self.now = self.now.after(Micros::from_s(1.0));
        self.robot.step(&self.params, self.now, event, &mut effects);
        effects
    }

    /// Reports its setpoint; returns the setpoints that follow.
    pub(crate) fn holds(&mut self, mpa: f64) -> Vec<Command> {
        self.holds_as(mpa, RegulatorState::Ok)
    }

    fn holds_as(&mut self, mpa: f64, regulator: RegulatorState) -> Vec<Command> {
        let pressure = Megapascal::known(mpa);
        let status =
            WhiskerStatus { array: "left", whisker: 0, pressure, setpoint: pressure, regulator, gauge: GaugeState::Ok };
        let mut effects =
            self.step(&Event::Status { boot_id: "b1", robot_time: self.now, whiskers: std::slice::from_ref(&status) });
        effects.extend(self.step(&Event::Tick));
        commands(effects)
    }

    pub(crate) fn reports(&mut self, command: &Command, report: SetpointReport) -> Vec<Effect> {
        self.step(&Event::Setpoint { boot_id: "b1", command: command.key, report, robot_time: self.now })
    }

    /// Nothing is heard of it for so long.
    fn is_silent_for(&mut self, seconds: f64) {
        for _ in 0..10 {
            self.now = self.now.after(Micros::from_s(seconds / 10.0));
            self.step(&Event::Tick);
        }
    }

    fn standing(&self) -> Vec<AlarmKind> {
        self.robot.whisker(0).unwrap().standing.kinds().collect()
    }

    pub(crate) fn setpoint_mpa(&self) -> f64 {
        self.robot.whisker(0).unwrap().setpoint.mpa()
    }
}

pub(crate) fn commands(effects: Vec<Effect>) -> Vec<Command> {
    let command = |effect| if let Effect::Command(command) = effect { Some(*command) } else { None };
    effects.into_iter().filter_map(command).collect()
}

#[test]
fn a_pressure_that_nobody_remembers_the_reason_of_is_set_back_once() {
    let mut taken = Taken::first_met().again(2);
    let sent = taken.holds(STRAY_MPA);
    assert_eq!(sent.len(), 1, "{sent:?}");
    assert_eq!((sent[0].key.epoch, sent[0].reason, sent[0].pressure.mpa()), (2, Reason::Release, NOMINAL_MPA));
    assert_eq!(taken.setpoint_mpa(), NOMINAL_MPA, "what was learned there stays in force");
    assert_eq!(taken.holds(STRAY_MPA), [], "it is on its way");
    taken.reports(&sent[0], SetpointReport::Applied(Megapascal::known(NOMINAL_MPA)));
    assert_eq!(taken.holds(NOMINAL_MPA), []);
    // From now on its own setpoints are followed.
    assert_eq!(taken.holds(0.06), []);
    assert_eq!(taken.setpoint_mpa(), 0.06);
}

#[test]
fn a_robot_that_will_not_go_back_is_asked_three_times_and_then_believed() {
    let mut taken = Taken::first_met().again(2);
    let mut sent = Vec::new();
    for _ in 0..20 {
        sent.extend(taken.holds(STRAY_MPA));
        if let Some(last) = sent.last().cloned() {
            sent.extend(commands(taken.reports(&last, SetpointReport::Failed)));
        }
    }
    assert_eq!(sent.len(), 3, "{sent:?}");
    let standing: Vec<AlarmKind> = taken.robot.whisker(0).unwrap().standing.kinds().collect();
    assert!(standing.contains(&AlarmKind::SetpointFailed), "{standing:?}");
    assert_eq!(taken.setpoint_mpa(), STRAY_MPA);
}

#[test]
fn pressures_that_robots_go_to_by_themselves_are_followed() {
    for mpa in [NOMINAL_MPA, NOMINAL_MPA + 0.003] {
        let mut taken = Taken::first_met().again(2);
        assert_eq!(taken.holds(mpa), [], "{mpa} MPa");
        assert_eq!(taken.setpoint_mpa(), mpa);
        // Only the first status can show a forgotten setpoint.
        assert_eq!(taken.holds(STRAY_MPA), []);
        assert_eq!(taken.setpoint_mpa(), STRAY_MPA);
    }
}

#[test]
fn the_pressure_of_a_held_whisker_and_of_one_that_is_new_is_followed() {
    let mut new = Taken::first_met();
    assert_eq!(new.holds(STRAY_MPA), []);
    assert_eq!(new.setpoint_mpa(), STRAY_MPA);

    let mut held = Taken::first_met();
    held.step(&Event::Operator(&OperatorAction::Hold(Scope::Robot)));
    let mut held = held.again(2);
    assert_eq!(held.holds(STRAY_MPA), []);
    assert_eq!(held.setpoint_mpa(), STRAY_MPA);
}

#[test]
fn a_setpoint_of_a_former_epoch_that_is_stale_is_made_anew_and_one_of_this_epoch_is_given_up() {
    let mut taken = Taken::first_met().again(2);
    let sent = taken.holds(STRAY_MPA);
    let mut taken = taken.again(3);
    taken.now = taken.now.after(Micros::from_s(5.0));
    let effects = taken.reports(&sent[0], SetpointReport::Rejected(Rejection::Stale));
    assert_eq!(taken.robot.whisker(0).unwrap().standing.kinds().count(), 0, "{effects:?}");
    let anew = taken.holds(STRAY_MPA);
    assert_eq!(anew.len(), 1, "{anew:?}");
    assert_eq!((anew[0].key.epoch, anew[0].pressure.mpa()), (3, NOMINAL_MPA));
    assert!(anew[0].key.version > sent[0].key.version);
    let effects = taken.reports(&anew[0], SetpointReport::Rejected(Rejection::Stale));
    let is_told = |effect: &Effect| matches!(effect, Effect::Alarm { kind: AlarmKind::SetpointFailed, .. });
    assert!(effects.iter().any(is_told), "{effects:?}");
    assert_eq!(taken.holds(STRAY_MPA), []);
}

/// A manual setpoint of hours ago, which a restored database still has, is not sent now.
#[test]
fn a_manual_setpoint_of_a_former_epoch_is_not_sent_anew() {
    for is_refused in [true, false] {
        let mut asked = Taken::first_met();
        asked.holds(NOMINAL_MPA);
        let whisker = Place { array: "left", whisker: 0 };
        let effects = asked.step(&Event::Operator(&OperatorAction::Setpoint { whisker, pressure_mpa: 0.06 }));
        let sent = commands(effects);
        assert_eq!(sent.len(), 1, "{sent:?}");
        let mut taken = asked.again(2);
        if is_refused {
            taken.reports(&sent[0], SetpointReport::Rejected(Rejection::Stale));
        } else {
            taken.now = taken.now.after(Micros::from_s(3600.0));
        }
        assert_eq!(taken.holds(NOMINAL_MPA), []);
        assert_eq!(taken.holds(NOMINAL_MPA), []);
        assert!(taken.robot.whisker(0).unwrap().held, "it stays held");
    }
}

/// One that is held at its nominal pressure, and known so.
fn known() -> Taken {
    let mut known = Taken::first_met();
    for _ in 0..3 {
        assert_eq!(known.holds(NOMINAL_MPA), []);
    }
    known
}

#[test]
fn regress_a_whisker_that_was_vented_during_a_silence_is_filled_again() {
    for is_restart in [true, false] {
        let mut taken = known();
        taken.is_silent_for(100.0);
        if is_restart {
            taken = taken.again(2);
        }
        let sent = [taken.holds(0.0), taken.holds(0.0)].concat();
        assert_eq!(sent.len(), 1, "{is_restart}: {sent:?}");
        assert_eq!((sent[0].reason, sent[0].pressure.mpa()), (Reason::Release, NOMINAL_MPA));
        taken.reports(&sent[0], SetpointReport::Applied(Megapascal::known(NOMINAL_MPA)));
        assert_eq!((taken.holds(NOMINAL_MPA), taken.standing()), (vec![], vec![]));
    }
}

#[test]
fn regress_a_vented_whisker_that_is_not_filled_again_has_an_alarm_until_it_is_released() {
    let place = Place { array: "left", whisker: 0 };
    for (is_held, silent_s, regulator) in
        [(true, 100.0, RegulatorState::Ok), (false, 0.0, RegulatorState::Ok), (false, 100.0, RegulatorState::Fault)]
    {
        let mut taken = known();
        if is_held {
            taken.step(&Event::Operator(&OperatorAction::Hold(Scope::Whisker(place))));
        }
        taken.is_silent_for(silent_s);
        assert_eq!(taken.holds_as(0.0, regulator), []);
        // Neither a restart nor time ends it.
        let mut taken = taken.again(2);
        for _ in 0..100 {
            assert_eq!(taken.holds(0.0), []);
        }
        assert_eq!(taken.standing(), [AlarmKind::Vented], "{is_held} {silent_s} {regulator:?}");
        let mut sent = commands(taken.step(&Event::Operator(&OperatorAction::Release(Scope::Whisker(place)))));
        sent.extend(taken.holds(0.0));
        assert_eq!((sent.len(), sent[0].pressure.mpa()), (1, NOMINAL_MPA), "{sent:?}");
        taken.reports(&sent[0], SetpointReport::Applied(Megapascal::known(NOMINAL_MPA)));
        assert_eq!((taken.holds(NOMINAL_MPA), taken.standing()), (vec![], vec![]));
    }
}

#[test]
fn a_whisker_that_an_operator_has_emptied_was_not_vented() {
    let mut taken = known();
    let whisker = Place { array: "left", whisker: 0 };
    let sent = commands(taken.step(&Event::Operator(&OperatorAction::Setpoint { whisker, pressure_mpa: 0.0 })));
    taken.reports(&sent[0], SetpointReport::Applied(Megapascal::known(0.0)));
    taken.is_silent_for(100.0);
    assert_eq!((taken.holds(0.0), taken.standing()), (vec![], vec![]));
}
