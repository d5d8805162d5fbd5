//! Connection, factsheet, status and answers to requests.

use super::*;

#[test]
fn a_birth_is_followed_by_the_factsheet_and_a_status() {
    let mut bench = Bench::connected(|_| {});
    let [Message::Connection(birth), Message::Factsheet(facts), Message::Status(status)] = &bench.sent()[..] else {
        panic!("not a birth, a factsheet and a status")
    };
    assert_eq!((birth.state, birth.seq, birth.timestamp), (ConnectionState::Online, 0, Timestamp(START)));
    assert_eq!((facts.seq, facts.arrays[0].whiskers[1].length_mm), (0, 65.0));
    assert_eq!((status.seq, status.whiskers.len(), status.contacts_dropped), (0, 2, None));
}

#[test]
fn a_will_has_the_boot_id_of_its_birth_and_a_seq_of_its_own() {
    let mut bench = Bench::new(|_| {});
    for birth_seq in [0, 2] {
        let topic = RobotTopic::Connection.of(bench.robot.fleet(), bench.robot.name());
        let Ok(Message::Connection(will)) = decode(&topic, &bench.robot.will(START)) else { panic!("no will") };
        bench.connect();
        let Message::Connection(Connection { boot_id, seq, .. }) = &bench.messages[0] else { panic!("no birth") };
        assert_eq!((will.state, &will.boot_id), (ConnectionState::ConnectionBroken, boot_id));
        assert_eq!((*seq, will.seq), (birth_seq, birth_seq + 1));
        bench.sent();
        bench.robot.disconnected();
    }
}

#[test]
fn a_farewell_says_offline() {
    let mut bench = Bench::connected(|_| {});
    bench.sent();
    let outgoing = bench.robot.farewell(START + S);
    bench.take(outgoing);
    let [Message::Connection(farewell)] = &bench.sent()[..] else { panic!("no farewell") };
    assert_eq!((farewell.state, farewell.seq), (ConnectionState::Offline, 1));
}

#[test]
fn a_request_is_answered() {
    let mut bench = Bench::connected(|_| {});
    bench.sent();
    for request in [RequestKind::Factsheet, RequestKind::Status] {
        bench.send(RobotTopic::Request, &encode(&Request { boot_id: supervisor(), seq: 0, request, touch_test: None }));
    }
    let sent = bench.sent();
    assert!(matches!(&sent[0], Message::Factsheet(Factsheet { seq: 1, .. })));
    assert!(matches!(&sent[1], Message::Status(Status { seq: 1, .. })));
}

#[test]
fn a_refused_message_is_counted_and_changes_nothing() {
    let mut bench = Bench::connected(|_| {});
    bench.sent();
    bench.send(RobotTopic::Setpoint, b"{}");
    bench.send(RobotTopic::Request, b"nonsense");
    assert_eq!((bench.sent().len(), bench.robot.messages_refused()), (0, 2));
}

#[test]
fn a_status_comes_every_second() {
    let mut bench = Bench::connected(|_| {});
    bench.run(10.5);
    assert_eq!(bench.statuses().iter().map(|status| status.seq).collect::<Vec<_>>(), (0..11).collect::<Vec<_>>());
}

#[test]
fn a_status_comes_soon_after_a_change() {
    let event = Event::whisker_at_s(5.3, left(), 0, Change::GaugeOpen);
    let mut bench = Bench::with_events([event]);
    bench.run(5.4);
    let last = bench.statuses().pop().unwrap();
    assert_eq!((last.t_us, last.whiskers[0].gauge), (START + 5_300_000, Gauge::Open));
    assert_eq!(last.whiskers[1].gauge, Gauge::Ok);
}
