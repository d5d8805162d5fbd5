//! Touch tests: their states.

use vibrissa_protocol::{TouchTest, TouchTestKind, TouchTestOutcome, TouchTestReason};

use super::*;

#[test]
fn regress_times_of_states_do_not_decrease_when_a_tick_comes_late() {
    let mut bench = Bench::connected(|scenario| scenario.behaviour.touch_tests = vec![TouchTestKind::Wall]);
    bench.run(5.0);
    bench.sent();
    // The robot is 30 ms behind: a tick was due before the request comes.
    bench.now_us = bench.robot.next_deadline() + 30_000;
    let test = TouchTest {
        test_id: "t1".to_owned(),
        epoch: 1,
        version: 1,
        robot_boot_id: bench.robot.boot_id().clone(),
        array: left(),
        whisker: 0,
        kind: TouchTestKind::Wall,
        distances_mm: vec![50.0],
        deflections_mm: vec![2.0],
        contacts: 1,
        issued: Timestamp(bench.now_us),
        expires_us: bench.now_us + 30 * S,
        reason: TouchTestReason::Operator,
    };
    let request = Request { boot_id: supervisor(), seq: 0, request: RequestKind::TouchTest, touch_test: Some(test) };
    bench.send(RobotTopic::Request, &encode(&request));
    bench.run(1.0);
    let states = bench.sent().into_iter();
    let states: Vec<(TouchTestOutcome, u64)> =
        states.filter_map(|m| if let Message::TestState(s) = m { Some((s.state, s.t_us)) } else { None }).collect();
    let outcomes: Vec<TouchTestOutcome> = states.iter().map(|&(outcome, _)| outcome).collect();
    assert_eq!(outcomes, [TouchTestOutcome::Accepted, TouchTestOutcome::Running, TouchTestOutcome::Done]);
    assert!(states.is_sorted_by_key(|&(_, t_us)| t_us), "{states:?}");
}
