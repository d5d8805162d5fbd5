//! Setpoints, touch tests, and the loss of the supervisor.

use vibrissa_protocol::{Estimate, OnSupervisorLoss};

use super::*;

#[test]
fn a_setpoint_is_applied_once_the_readings_have_stayed_at_it() {
    let mut bench = Bench::running();
    bench.order(1, 0.12);
    assert_eq!(bench.pressures(0), [0.12]);
    assert_eq!(bench.outcomes(), [(SetpointOutcome::Received, None), (SetpointOutcome::Applying, None)]);
    bench.hold([0.118, 0.1], 0.3);
    // Beyond the tolerance again: the time begins anew.
    bench.hold([0.115, 0.1], 0.1);
    bench.hold([0.118, 0.1], 0.5);
    assert_eq!(bench.outcomes(), []);
    bench.hold([0.118, 0.1], 0.2);
    assert_eq!(bench.outcomes(), [(SetpointOutcome::Applied, None)]);
    assert_eq!(bench.restarts, 0);
}

#[test]
fn a_setpoint_that_is_not_reached_fails_with_the_drivers_reason() {
    for (regulator, error) in [
        ("SUPPLY_LOW", SetpointError::SupplyLow),
        ("LEAK", SetpointError::Leak),
        ("FILLING", SetpointError::Fault),
        ("FAULT", SetpointError::Fault),
    ] {
        let mut bench = Bench::running();
        bench.order(1, 0.12);
        for _ in 0..80 {
            bench.run(0.1);
            bench.read(1, 0.1);
            bench.line(&format!(r#"{{"type":"pressure","whisker":0,"pressure_mpa":0.11,"regulator":"{regulator}"}}"#));
        }
        assert_eq!(bench.outcomes().last(), Some(&(SetpointOutcome::Failed, Some(error))), "{regulator}");
    }
}

#[test]
fn no_refused_setpoint_reaches_the_driver() {
    let mut bench = Bench::running();
    bench.order(5, 0.12);
    bench.take();
    let good = bench.setpoint(6, 0.13);
    let refused = [
        (bench.setpoint(4, 0.13), SetpointError::Stale),
        (Setpoint { epoch: 0, version: 99, ..good.clone() }, SetpointError::Stale),
        (Setpoint { robot_boot_id: BootId::new("b0").unwrap(), ..good.clone() }, SetpointError::WrongBoot),
        (Setpoint { whisker: 9, ..good.clone() }, SetpointError::UnknownWhisker),
        (Setpoint { version: 7, expires_us: bench.now_us, ..good.clone() }, SetpointError::Expired),
        (Setpoint { version: 8, pressure_mpa: 0.2001, ..good.clone() }, SetpointError::OutOfRange),
        (Setpoint { version: 9, pressure_mpa: -0.01, ..good }, SetpointError::OutOfRange),
    ];
    for (at, (mut setpoint, error)) in refused.into_iter().enumerate() {
        setpoint.command_id = format!("refused-{at}");
        bench.send(RobotTopic::Setpoint, &setpoint);
        assert_eq!(bench.pressures(0), [0.0; 0], "{error}");
        assert_eq!(bench.outcomes(), [(SetpointOutcome::Rejected, Some(error))]);
    }
    // The first one again is answered, and not applied again.
    bench.order(5, 0.12);
    assert_eq!(bench.pressures(0), [0.0; 0]);
    assert_eq!(bench.outcomes(), [(SetpointOutcome::Applying, None)]);
}

#[test]
fn a_newer_setpoint_supersedes_and_pressures_are_repeated() {
    let mut bench = Bench::running();
    bench.order(1, 0.12);
    bench.order(2, 0.08);
    let outcomes = bench.outcomes();
    assert_eq!(outcomes[3], (SetpointOutcome::Superseded, None), "{outcomes:?}");
    bench.hold([0.1, 0.1], 6.05);
    assert_eq!(bench.pressures(0), [0.08; 3], "every 2 s");
}

#[test]
fn without_a_driver_a_setpoint_is_refused() {
    let mut bench = Bench::new(|_| {});
    bench.step(Input::Connected);
    bench.order(1, 0.12);
    assert_eq!(bench.outcomes(), [(SetpointOutcome::Rejected, Some(SetpointError::NotReady))]);
    assert_eq!(bench.to_driver, []);
}

#[test]
fn in_a_task_setpoints_and_tests_are_declined_until_its_end() {
    let mut bench = Bench::running();
    let task = |task: bool| format!(r#"{{"type":"task","task":{task}}}"#);
    bench.line(&task(true));
    bench.take();
    bench.order(1, 0.12);
    assert_eq!(bench.outcomes(), [(SetpointOutcome::Rejected, Some(SetpointError::InTask))]);
    assert!(!bench.pressures(0).contains(&0.12), "the driver is not told");
    // The same setpoint again has the same answer, and the next one is taken after the task.
    bench.line(&task(false));
    bench.take();
    bench.order(1, 0.12);
    assert_eq!(bench.outcomes(), [(SetpointOutcome::Rejected, Some(SetpointError::InTask))]);
    bench.order(2, 0.12);
    assert_eq!(bench.outcomes().first(), Some(&(SetpointOutcome::Received, None)));
    // A driver that has gone is in no task.
    bench.line(&task(true));
    bench.step(Input::DriverEnded(0));
    bench.step(Input::DriverStarted(0));
    bench.read(0, 0.12);
    bench.take();
    bench.order(3, 0.11);
    assert_eq!(bench.outcomes().first(), Some(&(SetpointOutcome::Received, None)));
}

#[test]
fn the_loss_of_the_supervisor_is_handled_as_the_factsheet_states() {
    for (rule, pressure) in
        [(OnSupervisorLoss::Hold, 0.12), (OnSupervisorLoss::Nominal, 0.1), (OnSupervisorLoss::Vent, 0.0)]
    {
        let mut bench = Bench::new(|config| config.facts.on_supervisor_loss = rule);
        bench.step(Input::Connected);
        bench.step(Input::DriverStarted(0));
        bench.read(0, 0.12);
        bench.order(1, 0.12);
        bench.hold([0.12, 0.1], 59.0);
        assert_eq!(bench.pressures(0).last(), Some(&0.12));
        // The connection to the broker does not matter: the timer is the robot's own.
        bench.step(Input::Disconnected);
        bench.hold([0.12, 0.1], 4.0);
        assert_eq!(bench.pressures(0).last(), Some(&pressure), "{rule}");
    }
}

#[test]
fn regress_an_estimate_that_the_broker_repeats_at_each_connection_does_not_hide_a_loss() {
    let mut bench = Bench::new(|config| config.facts.on_supervisor_loss = OnSupervisorLoss::Vent);
    bench.step(Input::Connected);
    bench.step(Input::DriverStarted(0));
    bench.read(0, 0.12);
    let kept =
        Estimate { boot_id: supervisor(), seq: 0, epoch: 1, version: 1, timestamp: Timestamp(START), whiskers: vec![] };
    bench.send(RobotTopic::Estimate, &kept);
    bench.order(1, 0.12);
    for _ in 0..2 {
        bench.hold([0.12, 0.1], 25.0);
        bench.step(Input::Disconnected);
        bench.step(Input::Connected);
        bench.send(RobotTopic::Estimate, &kept);
    }
    assert_eq!(bench.pressures(0).last(), Some(&0.12));
    bench.hold([0.12, 0.1], 15.0);
    assert_eq!(bench.pressures(0).last(), Some(&0.0), "60 s after the last message of the supervisor");
    // A newer one is a message of a supervisor.
    bench.send(RobotTopic::Estimate, &Estimate { version: 2, ..kept });
    assert!(bench.agent.supervision.lost_at().is_some());
}

#[test]
fn regress_no_step_of_the_systems_clock_is_taken_for_passed_time() {
    for step_s in [70, -10, -3_600, 3_600, -(START / S).cast_signed()] {
        let mut bench = Bench::new(|config| config.facts.on_supervisor_loss = OnSupervisorLoss::Vent);
        bench.step(Input::Connected);
        bench.step(Input::DriverStarted(0));
        bench.read(0, 0.12);
        bench.order(1, 0.12);
        bench.hold([0.12, 0.1], 10.0);
        bench.take();
        bench.stepped_us = step_s * S.cast_signed();
        bench.hold([0.12, 0.1], 12.05);
        assert_eq!(bench.pressures(0), [0.12; 6], "{step_s}: told every 2 s, and not vented");
        assert_eq!(bench.statuses().len(), 6, "{step_s}");
        bench.order(2, 0.13);
        assert_eq!(bench.outcomes()[0], (SetpointOutcome::Received, None), "{step_s}: it has not expired");
        assert_eq!(bench.restarts, 0);
    }
}

#[test]
fn a_touch_test_is_given_to_the_driver_and_its_contacts_come_before_its_end() {
    let mut bench = Bench::running();
    let test = TouchTest {
        test_id: "t1".to_owned(),
        epoch: 1,
        version: 1,
        robot_boot_id: bench.agent.boot_id().clone(),
        array: left(),
        whisker: 0,
        kind: TouchTestKind::Wall,
        distances_mm: vec![50.0],
        deflections_mm: vec![1.0],
        contacts: 2,
        issued: Timestamp(START),
        expires_us: START + 30 * S,
        reason: TouchTestReason::Operator,
    };
    let request = vibrissa_protocol::Request {
        boot_id: supervisor(),
        seq: 0,
        request: RequestKind::TouchTest,
        touch_test: Some(test.clone()),
    };
    bench.send(RobotTopic::Request, &request);
    assert!(matches!(&bench.to_driver[..], [ToDriver::Test { contacts: 2, .. }]), "{:?}", bench.to_driver);
    bench.line(r#"{"type":"contact","whisker":0,"deflection_mm":1,"strain":0.01,"distance_mm":50,"test_id":"t1"}"#);
    bench.line(r#"{"type":"contact","whisker":0,"touched":false,"distance_mm":50,"test_id":"t1"}"#);
    bench.line(r#"{"type":"contact","whisker":0,"deflection_mm":1,"strain":0.01,"distance_mm":50,"test_id":"t1"}"#);
    bench.line(r#"{"type":"contact","whisker":0,"deflection_mm":1,"strain":0.01,"ratio":0.5,"test_id":"t2"}"#);
    bench.line(r#"{"type":"test_state","test_id":"t1","state":"DONE"}"#);
    // A repeated request is answered and not done again.
    bench.send(RobotTopic::Request, &request);
    let tests = bench.to_driver.iter().filter(|line| matches!(line, ToDriver::Test { .. })).count();
    let (messages, lines) = bench.take();
    let seen: Vec<String> = messages
        .iter()
        .filter_map(|message| {
            if let Message::TestState(state) = message {
                Some(state.state.to_string())
            } else if let Message::Contacts(contacts) = message {
                Some(format!("{}+{}", contacts.contacts.len(), contacts.missed.len()))
            } else {
                None
            }
        })
        .collect();
    assert_eq!((tests, &seen[..]), (1, &["ACCEPTED", "RUNNING", "1+1", "DONE", "DONE"].map(str::to_owned)[..]));
    let problems = lines.iter().filter(|line| matches!(line, ToDriver::Error { .. })).count();
    assert_eq!(problems, 2, "one touch too many, and one of another test");
}

#[test]
fn a_touch_test_fails_if_the_driver_ends_or_never_finishes_it() {
    for dies in [true, false] {
        let mut bench = Bench::running();
        let request = format!(
            r#"{{"boot_id":"s3","seq":0,"request":"TOUCH_TEST","touch_test":{{"test_id":"t1","epoch":1,"version":1,
            "robot_boot_id":"b1","array":"left","whisker":0,"kind":"WALL","distances_mm":[50],"deflections_mm":[1],
            "contacts":1,"issued":"2026-11-21T08:00:00.000Z","expires_us":{},"reason":"OPERATOR"}}}}"#,
            START + 30 * S
        );
        bench.step(Input::Message(RobotTopic::Request, request.as_bytes()));
        if dies {
            bench.step(Input::DriverEnded(0));
        } else {
            bench.hold([0.1, 0.1], 40.0);
        }
        let last =
            bench.messages.iter().rev().find_map(|m| if let Message::TestState(s) = m { Some(s.state) } else { None });
        assert_eq!(last, Some(TouchTestOutcome::Failed), "{dies}");
    }
}

#[test]
fn regress_an_order_that_a_board_refuses_fails_at_once_and_is_told_once() {
    let mut bench = Bench::running();
    let refusal =
        r#"{"type":"error","array":"left","whisker":0,"problem":"the pressure is above limit_mpa, which is 0.11"}"#;
    bench.order(1, 0.12);
    bench.line(refusal);
    let failed = (SetpointOutcome::Failed, Some(SetpointError::Fault));
    assert_eq!(bench.outcomes().last(), Some(&failed));
    bench.line(refusal);
    assert_eq!(bench.warnings.iter().filter(|text| text.contains("refuses the order of 0.12 MPa")).count(), 1);
    // The first refusal after that may be one of the earlier order.
    bench.order(2, 0.13);
    bench.line(refusal);
    assert_eq!(bench.outcomes().last(), Some(&(SetpointOutcome::Applying, None)));
    bench.line(refusal);
    assert_eq!(bench.outcomes(), [failed]);
    assert!(bench.warnings.last().is_some_and(|text| text.contains("0.13 MPa")), "{:?}", bench.warnings);
    // Without a whisker it is the answer to a person.
    bench.order(3, 0.1);
    bench.line(r#"{"type":"error","problem":"0.3 is not allowed"}"#);
    assert_eq!(bench.outcomes().last(), Some(&(SetpointOutcome::Applying, None)));
}

#[test]
fn regress_a_new_setpoint_of_the_same_pressure_ends_the_fault_of_a_driver_that_regulates() {
    for mpa in [0.1, 0.0] {
        let mut bench = Bench::running();
        bench.order(1, mpa);
        bench.line(r#"{"type":"pressure","whisker":0,"pressure_mpa":0.0,"regulator":"FAULT"}"#);
        bench.run(3.0);
        bench.take();
        bench.order(2, mpa);
        let told = bench.pressures(0);
        let step_mpa = (told[0] - mpa).abs();
        assert!(told.len() == 2 && step_mpa > 0.0 && step_mpa < 0.002 && told[1] == mpa, "{told:?}");
        // Without a fault the driver gets the new pressure alone.
        bench.line(r#"{"type":"pressure","whisker":0,"pressure_mpa":0.1,"regulator":"OK"}"#);
        bench.take();
        bench.order(3, 0.12);
        assert_eq!(bench.pressures(0), [0.12]);
    }
}
