//! Bounds of the rows that a robot adds to the database.

use vibrissa_store::batch::Record;

use super::*;

fn told(shard: &mut Shard, counted: impl Fn(&Record) -> bool) -> usize {
    shard.batch_mut().rows_mut().records.iter().filter(|record| counted(record)).count()
}

#[test]
fn regress_a_status_that_flaps_for_ten_minutes_adds_few_rows() {
    let (mut shard, name) = (shard(1), Name::robot("r1").unwrap());
    let mut now = Micros(1_795_260_000_000_000);
    for at in 0..2400 {
        let (pressure, gauge) = (Megapascal::known(PRESSURE_MPA), GaugeState::Ok);
        let regulator = if at % 2 == 0 { RegulatorState::Leak } else { RegulatorState::Ok };
        let status = |whisker| WhiskerStatus { array: "a", whisker, pressure, setpoint: pressure, regulator, gauge };
        let whiskers: Vec<_> = (0..WHISKERS).map(status).collect();
        shard.step_robot(&name, now, &Event::Status { boot_id: "b", robot_time: now, whiskers: &whiskers });
        now = now.after(Micros::from_s(0.25));
        shard.tick(now, &Delayed::new(), usize::MAX);
    }
    let alarms = told(&mut shard, |record| matches!(record, Record::Alarm(_)));
    let changes = told(&mut shard, |record| matches!(record, Record::Health(_)));
    assert_eq!(alarms, usize::from(WHISKERS));
    assert!(changes <= 6 * usize::from(WHISKERS), "{changes} changes of health");
}

fn connection(state: protocol::ConnectionState, received: Micros) -> RawMessage {
    let connection =
        protocol::Connection { boot_id: BootId::new("b").unwrap(), seq: 0, timestamp: protocol::Timestamp(0), state };
    let (robot, kind) = (Name::robot("r1").unwrap(), RobotTopic::Connection);
    let topic = kind.of(&Name::new("f").unwrap(), &robot);
    RawMessage { topic, robot, kind, payload: protocol::encode(&connection).into(), received }
}

#[test]
fn regress_a_connection_that_flaps_is_charged_and_then_refused_until_the_budget_allows_it() {
    let mut shard = shard(1);
    // Soon after the robots' factsheets: they are not silent yet.
    let start = Micros(2);
    for at in 0..20_000 {
        let now = start.after(Micros(at));
        shard.handle(&connection(protocol::ConnectionState::ConnectionBroken, now));
        shard.handle(&connection(protocol::ConnectionState::Online, now));
    }
    assert!(shard.metrics().messages_refused.of(["over_budget"]).get() > 10_000);
    let alarms = told(&mut shard, |record| matches!(record, Record::RobotAlarm(_)));
    let changes = told(&mut shard, |record| matches!(record, Record::Health(_)));
    assert!(alarms > 100 && (alarms * 1200 + changes * 300) < 5 << 20, "{alarms} alarms, {changes} changes");
    let is_online = |shard: &Shard| shard.robots()["r1"].robot.connection_state().1 == Link::Online;
    assert!(!is_online(&shard));
    // The last birth is accepted later.
    shard.tick(start.after(Micros::from_s(60.0)), &Delayed::new(), usize::MAX);
    assert!(is_online(&shard));
}
