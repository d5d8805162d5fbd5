//! Setpoints: accepted, applied, answered.

use super::*;

#[test]
fn a_setpoint_is_received_applied_and_then_held() {
    let mut bench = Bench::connected(|_| {});
    bench.run(1.0);
    bench.sent();
    bench.setpoint(1, 0.048);
    bench.run(8.0);
    let states = bench.states();
    let outcomes: Vec<SetpointOutcome> = states.iter().map(|state| state.state).collect();
    assert_eq!(outcomes, [SetpointOutcome::Received, SetpointOutcome::Applying, SetpointOutcome::Applied]);
    assert_eq!(states.iter().map(|state| state.seq).collect::<Vec<_>>(), [0, 1, 2]);
    assert!((states[2].pressure_mpa.unwrap() - 0.048).abs() <= 0.003);
    assert!((bench.first().regulator().pressure_mpa() - 0.048).abs() < 0.004);
    assert_eq!(bench.robot.whiskers()[1].regulator().target_mpa(), 0.1, "the other one is left alone");
}

#[test]
fn the_same_command_again_is_answered_again_and_not_applied_again() {
    let mut bench = Bench::connected(|_| {});
    let setpoint = bench.setpoint(1, 0.048);
    bench.run(8.0);
    bench.setpoint(2, 0.1);
    bench.run(8.0);
    bench.sent();
    bench.send(RobotTopic::Setpoint, &encode(&setpoint));
    assert_eq!(bench.outcomes(), [("command-1".to_owned(), SetpointOutcome::Applied, None)]);
    assert_eq!(bench.first().regulator().target_mpa(), 0.1);
}

#[test]
fn a_setpoint_that_breaks_a_rule_is_rejected_with_its_reason() {
    let mut bench = Bench::connected(|_| {});
    let good = bench.setpoint(5, 0.05);
    bench.run(8.0);
    bench.sent();
    for (number, setpoint, error) in [
        (1, Setpoint { version: 5, ..good.clone() }, SetpointError::Stale),
        (2, Setpoint { version: 6, expires_us: bench.now_us, ..good.clone() }, SetpointError::Expired),
        (
            3,
            Setpoint { version: 7, pressure_mpa: 0.21, expires_us: u64::MAX >> 12, ..good.clone() },
            SetpointError::OutOfRange,
        ),
        (4, Setpoint { version: 8, whisker: 9, ..good.clone() }, SetpointError::UnknownWhisker),
        (5, Setpoint { version: 9, robot_boot_id: supervisor(), ..good }, SetpointError::WrongBoot),
    ] {
        let setpoint = Setpoint { command_id: format!("wrong-{number}"), ..setpoint };
        bench.send(RobotTopic::Setpoint, &encode(&setpoint));
        let expected = (setpoint.command_id, SetpointOutcome::Rejected, Some(error));
        assert_eq!(bench.outcomes(), [expected]);
    }
    assert_eq!(bench.first().regulator().target_mpa(), 0.05, "none was applied");
}

#[test]
fn a_setpoint_replaced_while_it_is_applied_is_superseded() {
    let mut bench = Bench::connected(|_| {});
    bench.setpoint(1, 0.048);
    bench.run(0.5);
    bench.setpoint(2, 0.06);
    bench.run(8.0);
    let outcomes: Vec<(String, SetpointOutcome)> = bench.outcomes().into_iter().map(|(id, o, _)| (id, o)).collect();
    let of = |version: u32, outcome| (format!("command-{version}"), outcome);
    assert_eq!(
        outcomes,
        [
            of(1, SetpointOutcome::Received),
            of(1, SetpointOutcome::Applying),
            of(2, SetpointOutcome::Received),
            of(1, SetpointOutcome::Superseded),
            of(2, SetpointOutcome::Applying),
            of(2, SetpointOutcome::Applied),
        ]
    );
}

#[test]
fn a_setpoint_that_the_supply_cannot_give_fails() {
    let mut bench = Bench::with_events([Event::robot_at_s(1.0, Change::SupplyLow { supply_mpa: 0.12 })]);
    bench.run(2.0);
    bench.setpoint(1, 0.18);
    bench.run(30.0);
    let last = bench.states().pop().unwrap();
    assert_eq!((last.state, last.error), (SetpointOutcome::Failed, Some(SetpointError::SupplyLow)));
}

#[test]
fn a_setpoint_that_a_leaking_chamber_cannot_hold_fails() {
    let leak = Change::Leak { rate_mpa_per_s: 0.05 };
    let mut bench = Bench::with_events([Event::whisker_at_s(1.0, left(), 0, leak)]);
    bench.run(2.0);
    bench.setpoint(1, 0.15);
    bench.run(30.0);
    let last = bench.statuses().pop().unwrap();
    assert_eq!(last.whiskers[0].regulator, Regulator::Leak);
    bench.setpoint(2, 0.16);
    bench.run(30.0);
    let last = bench.states().pop().unwrap();
    assert_eq!((last.state, last.error), (SetpointOutcome::Failed, Some(SetpointError::Leak)));
}

#[test]
fn regress_a_request_to_all_robots_is_no_sign_of_the_robots_own_supervisor() {
    let mut bench = Bench::connected(|scenario| scenario.robots[0].on_supervisor_loss = OnSupervisorLoss::Vent);
    bench.setpoint(1, 0.05);
    bench.run(50.0);
    // A supervisor whose lease has just ended asks for births.
    let request = vibrissa_protocol::SupervisorRequest {
        boot_id: BootId::new("another").unwrap(),
        seq: 0,
        epoch: 9,
        timestamp: vibrissa_protocol::Timestamp(bench.now_us),
        request: vibrissa_protocol::SupervisorRequestKind::Birth,
    };
    bench.robot.receive_request_to_all(&vibrissa_protocol::encode(&request), bench.now_us);
    bench.run(9.0);
    assert_eq!(bench.first().regulator().target_mpa(), 0.05);
    bench.run(2.0);
    assert_eq!(bench.first().regulator().target_mpa(), 0.0, "its own supervisor has been silent for 60 s");
}

#[test]
fn without_the_supervisor_a_robot_does_what_its_factsheet_says() {
    for (on_loss, expected_mpa) in
        [(OnSupervisorLoss::Hold, 0.05), (OnSupervisorLoss::Nominal, 0.1), (OnSupervisorLoss::Vent, 0.0)]
    {
        let mut bench = Bench::connected(|scenario| scenario.robots[0].on_supervisor_loss = on_loss);
        bench.setpoint(1, 0.05);
        bench.run(59.0);
        assert_eq!(bench.first().regulator().target_mpa(), 0.05);
        bench.run(2.0);
        assert_eq!(bench.first().regulator().target_mpa(), expected_mpa, "{on_loss}");
    }
}
