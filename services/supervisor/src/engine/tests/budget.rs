//! Bounds of the rows that a robot adds to the database.

use vibrissa_core::robot::effect::{Effect, Fault};
use vibrissa_core::robot::{ActionProblem, OperatorAction, Outcome, Place};
use vibrissa_store::batch::Record;

use super::*;

fn record_count(worker: &mut Worker, counted: impl Fn(&Record) -> bool) -> usize {
    worker.batch_mut().rows_mut().records.iter().filter(|record| counted(record)).count()
}

#[test]
fn regress_a_status_that_flaps_for_ten_minutes_adds_few_rows() {
    let ok = (RegulatorState::Ok, PRESSURE_MPA);
    // The second robot vents its whiskers and fills them again.
    for other in [(RegulatorState::Leak, PRESSURE_MPA), (RegulatorState::Ok, 0.0)] {
        flap_for_ten_minutes(ok, other);
    }
}

fn flap_for_ten_minutes(one: (RegulatorState, f64), other: (RegulatorState, f64)) {
    let (mut worker, name) = (worker(1), Name::robot("r1").unwrap());
    let mut now = Micros(1_795_260_000_000_000);
    for at in 0..2400 {
        let ((regulator, pressure_mpa), gauge) = (if at % 2 == 0 { other } else { one }, GaugeState::Ok);
        let pressure = Megapascal::known(pressure_mpa);
        let status = |whisker| WhiskerStatus { array: "a", whisker, pressure, setpoint: pressure, regulator, gauge };
        let whiskers: Vec<_> = (0..WHISKERS).map(status).collect();
        worker.step_robot(&name, now, &Event::Status { boot_id: "b", robot_time: now, whiskers: &whiskers });
        now = now.after(Micros::from_s(0.25));
        worker.tick(now, &Delayed::new(), usize::MAX);
    }
    let alarms = record_count(&mut worker, |record| matches!(record, Record::Alarm(_)));
    let changes = record_count(&mut worker, |record| matches!(record, Record::Health(_)));
    assert_eq!(alarms, usize::from(WHISKERS), "{other:?}");
    assert!(changes <= 6 * usize::from(WHISKERS), "{other:?}: {changes} changes of health");
}

/// Number of refusals on the page of robot `r1`.
fn refused(worker: &Worker, topic: &str, reason: &str) -> u64 {
    let of_these = worker.robots()["r1"].refusals.totals().filter(|total| (total.0, total.1) == (topic, reason));
    of_these.map(|(_, _, count)| count).sum()
}

#[test]
fn regress_a_change_that_is_not_recorded_is_told_on_the_robots_page() {
    let (mut worker, now) = (worker(1), Micros(1_795_260_000_000_000));
    let (robots, stepper) = worker.parts();
    let known = &mut robots["r1"];
    let change = Effect::Fault { whisker: 0, from: None, to: Some(Fault::Leak) };
    while stepper.admit(known, now, &change) {}
    assert_eq!(refused(&worker, "status", "over_budget"), 1);
}

#[test]
fn regress_new_layouts_are_charged_to_the_fleet_too() {
    let (mut worker, now) = (worker(300), Micros(1_795_260_000_000_000));
    let mut layout = factsheet();
    let sheet = layout.arrays[0].whiskers[0].clone();
    layout.arrays[0].whiskers = (0..1900).map(|number| WhiskerSheet { number, ..sheet.clone() }).collect();
    let (robots, stepper) = worker.parts();
    let admitted =
        robots.values_mut().filter_map(|known| stepper.admits_layout(known, &layout, now).then_some(())).count();
    // Each is within its robot's budget.
    assert!((100..200).contains(&admitted), "{admitted} layouts");
    let is_refused = |total: (&str, &str, u64)| (total.0, total.1) == ("factsheet", "over_budget");
    let pages = worker.robots().values().filter(|known| known.refusals.totals().any(is_refused)).count();
    assert_eq!(pages, 300 - admitted);
}

#[test]
fn regress_a_robot_whose_times_are_in_milliseconds_is_told_on_its_page() {
    let (mut worker, start) = (worker(1), Micros(1_795_260_000_000_000));
    for seq in 0..30 {
        let now = start.after(Micros::from_s(10.0 * seq as f64));
        let whisker = protocol::WhiskerStatus {
            array: Name::new("a").unwrap(),
            whisker: 0,
            pressure_mpa: PRESSURE_MPA,
            setpoint_mpa: PRESSURE_MPA,
            regulator: protocol::Regulator::Ok,
            gauge: protocol::Gauge::Ok,
            segmenter: None,
        };
        let (boot_id, t_us) = (BootId::new("b").unwrap(), now.0 / 1000);
        let status = protocol::Status { boot_id, seq, t_us, whiskers: vec![whisker], contacts_dropped: None };
        worker.handle(&raw_message(RobotTopic::Status, protocol::encode(&status), now));
    }
    assert!(refused(&worker, "status", "time_unit") > 0);
    // By its clock a setpoint would be valid for hours.
    let action = OperatorAction::Setpoint { whisker: Place { array: "a", whisker: 0 }, pressure_mpa: 0.05 };
    let outcome = worker.step_robot(&Name::robot("r1").unwrap(), start, &Event::Operator(&action));
    assert_eq!(outcome, Some(Outcome::Refused(ActionProblem::WrongTimeUnit)));
}

fn raw_message(kind: RobotTopic, payload: Vec<u8>, received: Micros) -> RawMessage {
    let robot = Name::robot("r1").unwrap();
    let topic = kind.of(&Name::new("f").unwrap(), &robot);
    RawMessage { topic, robot, kind, payload: payload.into(), received }
}

fn connection(state: protocol::ConnectionState, received: Micros) -> RawMessage {
    let connection =
        protocol::Connection { boot_id: BootId::new("b").unwrap(), seq: 0, timestamp: protocol::Timestamp(0), state };
    raw_message(RobotTopic::Connection, protocol::encode(&connection), received)
}

#[test]
fn regress_a_connection_that_flaps_is_charged_and_then_refused_until_the_budget_allows_it() {
    let mut worker = worker(1);
    // Soon after the robots' factsheets: they are not silent yet.
    let start = Micros(2);
    for at in 0..20_000 {
        let now = start.after(Micros(at));
        worker.handle(&connection(protocol::ConnectionState::ConnectionBroken, now));
        worker.handle(&connection(protocol::ConnectionState::Online, now));
    }
    assert!(worker.metrics().messages_refused.of(["over_budget"]).get() > 10_000);
    let alarms = record_count(&mut worker, |record| matches!(record, Record::RobotAlarm(_)));
    let changes = record_count(&mut worker, |record| matches!(record, Record::Health(_)));
    assert!(alarms > 100 && (alarms * 1200 + changes * 300) < 5 << 20, "{alarms} alarms, {changes} changes");
    assert!(refused(&worker, "connection", "over_budget") > 10_000, "on its page");
    let is_online = |worker: &Worker| worker.robots()["r1"].robot.connection_state().1 == Link::Online;
    assert!(!is_online(&worker));
    // The last birth is accepted later.
    worker.tick(start.after(Micros::from_s(60.0)), &Delayed::new(), usize::MAX);
    assert!(is_online(&worker));
}
