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

/// The factsheet named the built-in calibration, so that a supervisor took a whisker of another rubber for one of the paper's.
#[test]
fn regress_the_factsheet_names_the_calibration_of_the_scenario() {
    let own = r#"
name = "own"
c = 1.0
a = 1.3
b_per_mpa = 12.0
youngs_modulus_mpa = 1.2
elongation_gain_mm = 40.0
"#;
    for (calibration, name) in [(None, "nguyen-2021"), (Some(toml::from_str(own).unwrap()), "own")] {
        let mut bench = Bench::connected(|scenario| scenario.calibration = calibration);
        let messages = bench.sent();
        let facts =
            messages.iter().find_map(|one| if let Message::Factsheet(facts) = one { Some(facts) } else { None });
        assert!(facts.unwrap().arrays[0].whiskers.iter().all(|whisker| whisker.model == name), "{name}");
    }
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

fn birth_request() -> Vec<u8> {
    let (boot_id, timestamp, request) = (supervisor(), Timestamp(START), SupervisorRequestKind::Birth);
    encode(&SupervisorRequest { boot_id, seq: 0, epoch: 1, timestamp, request })
}

/// Time until the answer to a request for births, in seconds. Further requests come before it.
fn answered_after_s(seed: u64) -> f64 {
    let mut bench = Bench::connected(|scenario| scenario.seed = seed);
    bench.run(0.3);
    bench.sent();
    let (asked_us, boot_id) = (bench.now_us, bench.robot.boot_id().clone());
    for _ in 0..3 {
        bench.robot.receive_request_to_all(&birth_request(), bench.now_us);
    }
    bench.run(2.5);
    let mut sent = bench.sent();
    sent.retain(|message| matches!(message, Message::Connection(_) | Message::Factsheet(_)));
    let [Message::Connection(birth), Message::Factsheet(facts)] = &sent[..] else {
        panic!("not one birth and one factsheet: {sent:?}")
    };
    assert_eq!((birth.state, &birth.boot_id, birth.seq), (ConnectionState::Online, &boot_id, 2));
    assert_eq!((&facts.boot_id, facts.seq), (&boot_id, 1));
    (birth.timestamp.0 - asked_us) as f64 / 1e6
}

#[test]
fn requests_for_births_are_answered_once_in_the_same_boot_within_two_seconds_at_random_times() {
    let mut delays_s: Vec<f64> = (1..=20).map(answered_after_s).collect();
    assert_eq!(answered_after_s(5), delays_s[4], "the seed decides");
    delays_s.sort_by(f64::total_cmp);
    assert!(delays_s[0] < 0.7 && delays_s[19] > 1.3 && delays_s[19] < 2.0, "{delays_s:?}");
}

#[test]
fn a_robot_that_is_not_connected_answers_with_the_birth_of_its_next_connection_alone() {
    let mut bench = Bench::connected(|_| {});
    bench.robot.receive_request_to_all(&birth_request(), bench.now_us);
    bench.robot.disconnected();
    bench.sent();
    bench.run(3.0);
    assert!(bench.sent().is_empty());
    bench.connect();
    bench.run(3.0);
    assert_eq!(bench.sent().iter().filter(|message| matches!(message, Message::Connection(_))).count(), 1);
}

#[test]
fn a_request_to_all_that_is_refused_is_counted_and_changes_nothing() {
    let mut bench = Bench::connected(|_| {});
    bench.run(0.1);
    bench.sent();
    for payload in [&b"{}"[..], b"nonsense", br#"{"boot_id":"s","seq":0,"epoch":1,"request":"DANCE"}"#] {
        bench.robot.receive_request_to_all(payload, bench.now_us);
    }
    bench.run(3.0);
    assert!(!bench.sent().iter().any(|message| matches!(message, Message::Connection(_) | Message::Factsheet(_))));
    assert_eq!(bench.robot.messages_refused(), 3);
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
