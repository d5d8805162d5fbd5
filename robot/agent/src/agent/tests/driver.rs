//! Drivers that speak, are silent, flood, or leave.

use vibrissa_protocol::{Estimate, Gauge, Regulator, SoftwareKind, WhiskerCondition, WhiskerEstimate};

use super::*;

#[test]
fn a_driver_is_greeted_with_all_it_needs() {
    let mut bench = Bench::running();
    bench.order(1, 0.12);
    let estimate = WhiskerEstimate {
        array: left(),
        whisker: 1,
        length_mm: 61.0,
        length_low_mm: 60.5,
        length_high_mm: 61.5,
        condition: WhiskerCondition::Trimmed,
        pressure_mpa: 0.1,
        gain: vec![(0.5, 0.9)],
        reading_gain: None,
        response: Vec::new(),
    };
    let of = |version| Estimate {
        boot_id: supervisor(),
        seq: 0,
        epoch: 1,
        version,
        timestamp: Timestamp(START),
        whiskers: vec![WhiskerEstimate { length_mm: 60.5 + version as f64 / 10.0, ..estimate.clone() }],
    };
    for version in [5, 4] {
        bench.send(RobotTopic::Estimate, &of(version));
    }
    bench.step(Input::DriverEnded(0));
    bench.take();
    bench.step(Input::DriverStarted(0));
    let lines: Vec<String> =
        bench.to_driver.iter().map(|line| String::from_utf8(line.line()).unwrap().trim_end().to_owned()).collect();
    assert_eq!(
        lines,
        [
            r#"{"type":"hello","version":1,"whiskers":[{"array":"left","whisker":0,"pressure_mpa":0.12,"pressure_max_mpa":0.2},{"array":"left","whisker":1,"pressure_mpa":0.1,"pressure_max_mpa":0.2}]}"#,
            r#"{"type":"set_pressure","array":"left","whisker":0,"pressure_mpa":0.12,"slew_mpa_per_s":0.02}"#,
            r#"{"type":"set_pressure","array":"left","whisker":1,"pressure_mpa":0.1,"slew_mpa_per_s":0.02}"#,
            r#"{"type":"estimate","array":"left","whisker":1,"length_mm":61.0,"length_low_mm":60.5,"length_high_mm":61.5,"condition":"TRIMMED","gain":[[0.5,0.9]]}"#,
        ]
    );
}

#[test]
fn versions_of_agent_driver_and_firmware_reach_the_factsheet_once() {
    let mut bench = Bench::running();
    let factsheets = |bench: &mut Bench| -> Vec<Vec<(SoftwareKind, String, String)>> {
        let (messages, _) = bench.take();
        let sheets = messages.into_iter().filter_map(|message| {
            let Message::Factsheet(sheet) = message else { return None };
            Some(sheet.software)
        });
        sheets.map(|all| all.into_iter().map(|one| (one.kind, one.name, one.version)).collect()).collect()
    };
    let agent = (SoftwareKind::Agent, "vibrissa-robot".to_owned(), env!("CARGO_PKG_VERSION").to_owned());
    bench.take();
    let hello =
        r#"{"type":"hello","version":1,"name":"gripper","software_version":"1.4.0","firmware_version":"7\u0007"}"#;
    bench.line(hello);
    let driver = (SoftwareKind::Driver, "gripper".to_owned(), "1.4.0".to_owned());
    let firmware = (SoftwareKind::Firmware, "gripper".to_owned(), "7".to_owned());
    assert_eq!(factsheets(&mut bench), [vec![agent.clone(), driver, firmware]]);
    bench.line(hello);
    assert_eq!(factsheets(&mut bench), Vec::<Vec<_>>::new(), "nothing new");
    let long = "9".repeat(100);
    bench.line(&format!(r#"{{"type":"hello","version":1,"name":"","firmware_version":"{long}"}}"#));
    let firmware = (SoftwareKind::Firmware, "the driver".to_owned(), "9".repeat(64));
    assert_eq!(factsheets(&mut bench), [vec![agent, firmware]]);
}

#[test]
fn contacts_take_the_newest_readings_and_are_sent_together() {
    let mut bench = Bench::running();
    bench.line(r#"{"type":"pressure","whisker":1,"pressure_mpa":0.09,"temperature_c":31.5}"#);
    bench.touch(1);
    bench.touch(0);
    assert_eq!(bench.contacts(), []);
    bench.run(0.1);
    let sent = bench.contacts();
    assert_eq!((sent.len(), sent[0].contacts.len()), (1, 2));
    assert_eq!((sent[0].contacts[0].pressure_mpa, sent[0].contacts[0].temperature_c), (0.09, 31.5));
    assert_eq!((sent[0].contacts[1].pressure_mpa, sent[0].contacts[1].temperature_c), (0.1, 24.0));
    for _ in 0..50 {
        bench.touch(0);
    }
    assert_eq!(bench.contacts()[0].contacts.len(), 50, "a full message does not wait");
}

#[test]
fn a_silent_driver_is_reported_at_once_and_given_up() {
    let mut bench = Bench::running();
    bench.hold([0.1, 0.1], 3.0);
    bench.line(r#"{"type":"fault","whisker":1,"gauge":"OPEN"}"#);
    bench.run(0.2);
    let status = bench.statuses().pop().unwrap();
    assert_eq!((status.whiskers[0].regulator, status.whiskers[1].gauge), (Regulator::Ok, Gauge::Open));
    bench.run(4.7);
    assert_eq!(bench.restarts, 0);
    // Noise is no sign of life.
    bench.line("\u{1}@~");
    bench.take();
    bench.run(0.5);
    assert_eq!(bench.restarts, 1);
    let status = bench.statuses().pop().unwrap();
    assert!(status.whiskers.iter().all(|whisker| whisker.regulator == Regulator::Fault), "{status:?}");
    bench.order(1, 0.12);
    assert_eq!(bench.outcomes(), [(SetpointOutcome::Rejected, Some(SetpointError::NotReady))]);
    // It is greeted when it speaks again.
    bench.read(0, 0.1);
    assert!(matches!(bench.to_driver.first(), Some(ToDriver::Hello { .. })), "{:?}", bench.to_driver);
}

#[test]
fn one_whisker_whose_pressure_is_not_read_is_reported_alone() {
    let mut bench = Bench::running();
    for _ in 0..60 {
        bench.run(0.1);
        bench.read(0, 0.1);
    }
    let status = bench.statuses().pop().unwrap();
    let regulators: Vec<Regulator> = status.whiskers.iter().map(|whisker| whisker.regulator).collect();
    assert_eq!(regulators, [Regulator::Ok, Regulator::Fault]);
}

#[test]
fn bad_lines_are_answered_with_their_number_and_a_remedy() {
    let mut bench = Bench::running();
    for (line, problem) in [
        ("{}", "missing field `type`"),
        ("{\"type\":\"jump\"}", "\"jump\" is no word of a driver"),
        ("[1]", "was given"),
        ("{\"type\":\"hello\",\"version\":2}", "version 2 of the interface is not known"),
        ("{\"type\":\"strain\",\"whisker\":0,\"strain\":[0.1]}", "agent.toml states place RATIO"),
        ("{\"type\":\"pressure\",\"whisker\":7,\"pressure_mpa\":0.1}", "the robot has no whisker left/7"),
        ("{\"type\":\"pressure\",\"whisker\":0,\"pressure_mpa\":NaN}", "a value is required"),
        ("{\"type\":\"pressure\",\"whisker\":0,\"pressure_mpa\":1e999}", "a number is too large"),
        (
            "{\"type\":\"pressure\",\"whisker\":0,\"pressure_mpa\":-0.1}",
            "pressure_mpa is -0.1, but must be between 0 and 1",
        ),
        ("{\"type\":\"fault\",\"whisker\":0}", "neither gauge nor regulator"),
        ("{\"type\":\"contact\",\"whisker\":0,\"strain\":0.1,\"ratio\":0.5}", "missing field `deflection_mm`"),
        (
            "{\"type\":\"contact\",\"whisker\":0,\"strain\":0.1,\"deflection_mm\":1,\"tip\":true}",
            "the place is TIP, but agent.toml states RATIO",
        ),
        ("{\"type\":\"contact\",\"whisker\":0,\"strain\":2,\"deflection_mm\":1,\"ratio\":0.5}", "strain"),
        (
            "{\"type\":\"contact\",\"whisker\":0,\"strain\":0.1,\"deflection_mm\":1,\"ratio\":0.5,\"test_id\":\"x\"}",
            "no touch test \"x\"",
        ),
        ("{\"type\":\"test_state\",\"test_id\":\"x\",\"state\":\"DONE\"}", "no touch test \"x\""),
    ] {
        bench.run(0.1);
        bench.line(line);
        let problems = bench.problems();
        assert!(problems.len() == 1 && problems[0].contains(problem), "{line}: {problems:?}");
    }
    bench.step(Input::Line(0, None));
    assert!(bench.problems()[0].contains("longer than 65536 bytes"));
    assert_eq!(bench.agent.counts().lines_refused, 16);
    assert_eq!(bench.contacts(), []);
}

#[test]
fn regress_an_empty_chamber_reads_the_zero_of_its_sensor() {
    for (reading, taken) in [(-0.00037, true), (-0.01, true), (-0.0101, false), (-1.0, false)] {
        let mut bench = Bench::running();
        bench.run(2.0);
        bench.take();
        bench.read(0, reading);
        bench.line(&format!(
            r#"{{"type":"contact","whisker":1,"strain":0.01,"deflection_mm":1,"ratio":0.5,"pressure_mpa":{reading}}}"#
        ));
        assert_eq!(bench.problems().len(), if taken { 0 } else { 2 }, "{reading}");
        bench.step(Input::Message(RobotTopic::Request, br#"{"boot_id":"s3","seq":0,"request":"STATUS"}"#));
        let status = bench.statuses().pop().unwrap();
        assert_eq!(status.whiskers[0].pressure_mpa, if taken { 0.0 } else { 0.1 });
        assert_eq!(bench.warnings.len(), if taken { 2 } else { 0 }, "{:?}", bench.warnings);
    }
}

#[test]
fn the_zero_of_a_sensor_is_in_no_pressure_of_the_contract_and_in_each_order() {
    for zero_mpa in [-0.000_5, 0.002] {
        let mut bench =
            Bench::new(|config| config.whiskers.values_mut().for_each(|one| one.pressure_zero_mpa = zero_mpa));
        bench.step(Input::Connected);
        bench.step(Input::DriverStarted(0));
        assert_eq!(bench.pressures(0), [0.1 + zero_mpa], "the sensor reads this at 0.1 MPa");
        bench.take();
        // With the noise of an empty chamber, and in a full one.
        for (reading, pressure_mpa) in [(zero_mpa, 0.0), (zero_mpa - 0.000_05, 0.0), (0.1 + zero_mpa, 0.1)] {
            bench.read(0, reading);
            bench.touch(0);
            bench.run(0.2);
            let contact = &bench.contacts().pop().unwrap().contacts[0];
            assert!((contact.pressure_mpa - pressure_mpa).abs() < 1e-12, "{reading}: {contact:?}");
            bench.receipt("b1", 100);
        }
        assert_eq!(bench.warnings, [""; 0]);
        bench.order(1, 0.0);
        assert_eq!(bench.pressures(0).last(), Some(&0.0), "an empty chamber is empty");
    }
}

#[test]
fn regress_a_driver_whose_values_are_refused_is_not_silent() {
    for (line, restarts) in [
        (r#"{"type":"pressure","whisker":0,"pressure_mpa":7.0}"#, 0),
        (r#"{"type":"pressure","whisker":0,"pressure_mpa":"much"}"#, 0),
        (r#"{"type":"jump"}"#, 0),
        ("\u{1}@~", 1),
        (r#"{"pressure_mpa":0.1}"#, 1),
    ] {
        let mut bench = Bench::running();
        for _ in 0..70 {
            bench.run(0.1);
            bench.line(line);
        }
        assert_eq!(bench.restarts, restarts, "{line}");
        // Its chambers are not read, whatever it says.
        let status = bench.statuses().pop().unwrap();
        assert!(status.whiskers.iter().all(|whisker| whisker.regulator == Regulator::Fault), "{status:?}");
    }
}

#[test]
fn regress_a_whisker_that_is_not_read_while_the_broker_is_away_takes_no_time() {
    let mut bench = Bench::running();
    bench.step(Input::Disconnected);
    for _ in 0..100 {
        // `run` demands that each deadline passes.
        bench.run(0.1);
        bench.read(0, 0.1);
    }
    bench.step(Input::Connected);
    let status = bench.statuses().pop().unwrap();
    assert_eq!(status.whiskers[1].regulator, Regulator::Fault);
}

#[test]
fn regress_a_gauge_whose_touches_are_compressions_is_told_once() {
    let mut bench = Bench::running();
    for _ in 0..40 {
        bench.line(r#"{"type":"contact","whisker":1,"strain":-0.01,"deflection_mm":1,"ratio":0.5}"#);
    }
    assert!(bench.warnings.len() == 1 && bench.warnings[0].contains("whisker left/1: touches are compressions"));
}

#[test]
fn a_driver_that_divides_by_the_length_sends_distances_without_one() {
    let mut bench = Bench::running();
    bench.read(0, 0.1);
    bench.line("{\"type\":\"contact\",\"whisker\":0,\"strain\":0.1,\"deflection_mm\":1,\"distance_mm\":50}");
    bench.run(0.2);
    let contacts = bench.contacts();
    assert_eq!(
        contacts.iter().flat_map(|one| &one.contacts).map(|one| one.distance_mm).collect::<Vec<_>>(),
        [Some(50.0)]
    );
    assert_eq!(bench.agent.counts().lines_refused, 0);
}

#[test]
fn regress_a_driver_may_stamp_by_a_system_clock_that_was_set_meanwhile() {
    for step_s in [70, -70] {
        let mut bench = Bench::running();
        bench.stepped_us = step_s * S.cast_signed();
        let system_us = START.saturating_add_signed(bench.stepped_us) - S / 2;
        bench.line(&format!(
            r#"{{"type":"contact","whisker":0,"deflection_mm":1,"strain":0.01,"ratio":0.5,"t_us":{system_us}}}"#
        ));
        bench.run(0.2);
        let times: Vec<u64> = bench.contacts().iter().flat_map(|one| &one.contacts).map(|one| one.t_us).collect();
        assert_eq!(times, [START - S / 2], "half a second ago by the robot's clock");
    }
}

#[test]
fn regress_a_device_that_echoes_gets_no_more_lines_than_another_one() {
    let lines_of = |echoes: bool, speaks: bool| {
        let mut bench = Bench::new(|_| {});
        bench.step(Input::Connected);
        bench.step(Input::DriverStarted(0));
        let (mut sent, mut problems) = (0, Vec::new());
        for tenth in 0..200 {
            bench.run(0.1);
            if speaks && tenth % 3 == 0 {
                bench.read(0, 0.1);
                bench.read(1, 0.1);
            }
            // Each line comes back within the tenth of a second, and so does each answer to it.
            let mut round = 0;
            while !bench.to_driver.is_empty() && round < 20 {
                let lines = std::mem::take(&mut bench.to_driver);
                sent += lines.len();
                for line in lines {
                    if let ToDriver::Error { problem, .. } = &line {
                        problems.push(problem.clone());
                    }
                    if echoes {
                        bench.step(Input::Line(0, Some(line.line().trim_ascii_end())));
                    }
                }
                round += 1;
            }
        }
        (sent, problems, bench.agent.counts().lines_echoed)
    };
    for speaks in [true, false] {
        let (quiet, _, _) = lines_of(false, speaks);
        let (sent, problems, echoed) = lines_of(true, speaks);
        assert_eq!((problems.len(), echoed), (1, sent as u64), "{problems:?}");
        assert!(problems[0].contains("own lines back"), "{problems:?}");
        assert!(sent <= quiet + 1, "{sent} lines instead of {quiet}");
    }
}

#[test]
fn each_line_to_a_driver_is_recognised_when_it_comes_back() {
    let mut bench = Bench::running();
    bench.step(Input::DriverEnded(0));
    bench.step(Input::DriverStarted(0));
    bench.line("x");
    for line in bench.take().1 {
        assert!(crate::driver::told::is_own(&line.line()), "{line:?}");
    }
    for line in [&br#"{"type":"hello","version":1,"name":"d"}"#[..], b"{}", br#"{"type":"hello","version":1}"#] {
        assert!(!crate::driver::told::is_own(line));
    }
}

#[test]
fn a_driver_that_says_hello_all_the_time_is_greeted_five_times_a_second() {
    let mut bench = Bench::running();
    (0..100).for_each(|_| bench.line(r#"{"type":"hello","version":1}"#));
    let greetings = bench.to_driver.iter().filter(|line| matches!(line, ToDriver::Hello { .. })).count();
    assert_eq!(greetings, 5);
}

#[test]
fn regress_an_ordinary_start_reports_no_fault() {
    for (reads_after_s, regulators) in
        [(0.5, [Regulator::Ok; 2]), (8.0, [Regulator::Ok; 2]), (9.0, [Regulator::Fault; 2])]
    {
        let mut bench = Bench::new(|_| {});
        bench.step(Input::Connected);
        bench.step(Input::DriverStarted(0));
        bench.step(Input::Message(RobotTopic::Request, br#"{"boot_id":"s3","seq":0,"request":"STATUS"}"#));
        bench.run(reads_after_s);
        if reads_after_s < 9.0 {
            assert_eq!(bench.statuses().len(), 0, "nothing is known yet");
            bench.read(0, 0.1);
            assert_eq!(bench.statuses().len(), 0, "not of the other one");
            bench.read(1, 0.1);
        }
        let first = bench.statuses().remove(0);
        assert_eq!(first.seq, 0);
        assert_eq!(first.whiskers.iter().map(|one| one.regulator).collect::<Vec<_>>(), regulators);
    }
}

#[test]
fn regress_a_driver_that_restarts_within_seconds_is_no_fault() {
    let mut bench = Bench::running();
    let mut statuses = Vec::new();
    bench.hold([0.1, 0.1], 3.0);
    for _ in 0..3 {
        bench.step(Input::DriverEnded(0));
        bench.run(5.0);
        statuses.extend(bench.statuses());
        // A contact without a pressure is refused until the pressure is read.
        bench.step(Input::DriverStarted(0));
        bench.touch(0);
        assert_eq!(bench.problems().len(), 1);
        bench.run(1.0);
        bench.hold([0.1, 0.1], 2.0);
    }
    statuses.extend(bench.statuses());
    assert!(
        statuses.len() >= 6 && statuses.iter().all(|one| one.whiskers[0].regulator == Regulator::Ok),
        "{statuses:?}"
    );
    // Nor does a driver hide its absence by restarts without end.
    for _ in 0..7 {
        bench.step(Input::DriverEnded(0));
        bench.run(1.5);
        bench.step(Input::DriverStarted(0));
        bench.run(1.5);
    }
    let last = bench.statuses().pop().unwrap();
    assert!(last.whiskers.iter().all(|whisker| whisker.regulator == Regulator::Fault), "{last:?}");
    bench.order(1, 0.12);
    bench.step(Input::DriverEnded(0));
    bench.read(0, 0.1);
    bench.read(1, 0.1);
    bench.run(0.2);
    assert_eq!(bench.statuses().pop().unwrap().whiskers[0].regulator, Regulator::Filling);
}

#[test]
fn a_flood_of_contacts_and_of_bad_lines_is_limited_and_counted() {
    let mut bench = Bench::new(|config| config.limits.contacts_per_s = 100.0);
    bench.step(Input::DriverStarted(0));
    bench.read(0, 0.1);
    (0..1000).for_each(|_| bench.touch(0));
    assert_eq!((bench.agent.counts().contacts, bench.agent.counts().lines_refused), (100, 900));
    assert_eq!(bench.problems().len(), 20, "the others are only counted");
}

#[test]
fn the_outbox_is_bounded_and_drops_the_oldest() {
    let mut bench = Bench::new(|config| config.limits.outbox_bytes = 65_536);
    bench.step(Input::DriverStarted(0));
    bench.read(0, 0.1);
    for _ in 0..2000 {
        bench.touch(0);
        bench.run(0.1);
        bench.read(0, 0.1);
    }
    assert!(bench.agent.outbox.bytes() <= 65_536 && bench.agent.outbox.bytes() > 60_000);
    assert_eq!(bench.agent.messages_kept() as u64 + bench.agent.messages_dropped(), 2000);
    bench.step(Input::Connected);
    let status = bench.statuses().pop().unwrap();
    assert_eq!(status.contacts_dropped, Some(bench.agent.messages_dropped()));
}

#[test]
fn regress_a_gauge_that_was_bad_is_good_once_its_driver_begins_anew_without_a_fault() {
    let gauge = |bench: &mut Bench| {
        bench.run(1.0);
        bench.hold([0.1, 0.1], 0.5);
        bench.statuses().pop().unwrap().whiskers[0].gauge
    };
    for ends in [true, false] {
        let mut bench = Bench::running();
        bench.line(r#"{"type":"fault","whisker":0,"gauge":"OPEN"}"#);
        assert_eq!(gauge(&mut bench), Gauge::Open);
        // A board that stays at its port is started by its button: only its hello shows it.
        if ends {
            bench.step(Input::DriverEnded(0));
            bench.step(Input::DriverStarted(0));
        } else {
            bench.line(r#"{"type":"hello","version":1,"name":"board"}"#);
        }
        assert_eq!(gauge(&mut bench), Gauge::Ok);
        bench.line(r#"{"type":"fault","whisker":0,"gauge":"OPEN"}"#);
        assert_eq!(gauge(&mut bench), Gauge::Open, "it is bad still");
    }
}

/// The next reading without a condition ended the fault of the regulator.
#[test]
fn regress_a_fault_of_the_regulator_lasts_until_the_driver_tells_another_condition() {
    let regulator = |bench: &mut Bench| {
        bench.hold([0.1, 0.1], 1.5);
        bench.statuses().pop().unwrap().whiskers[0].regulator
    };
    for end in [
        r#"{"type":"fault","whisker":0,"regulator":"OK"}"#,
        r#"{"type":"pressure","whisker":0,"pressure_mpa":0.1,"regulator":"OK"}"#,
        r#"{"type":"hello","version":1,"name":"board"}"#,
    ] {
        let mut bench = Bench::running();
        bench.line(r#"{"type":"fault","whisker":0,"regulator":"LEAK"}"#);
        assert_eq!(regulator(&mut bench), Regulator::Leak);
        assert_eq!(regulator(&mut bench), Regulator::Leak);
        bench.line(end);
        assert_eq!(regulator(&mut bench), Regulator::Ok, "{end}");
    }
}

#[test]
fn a_driver_that_begins_anew_takes_no_fault_back_that_another_one_has_reported() {
    let mut bench = Bench::running();
    bench.line(r#"{"type":"fault","whisker":0,"gauge":"SHORT"}"#);
    bench.agent.chambers[0].begin(1);
    assert_eq!(bench.agent.chambers[0].condition(Now::of_us(bench.now_us)).1, Gauge::Short);
}

/// Neither the log nor the monitor said a word: the broker takes the contacts, and nobody receipts them.
#[test]
fn regress_a_supervisor_that_never_answers_is_told_once_with_what_to_do() {
    let mut bench = Bench::running();
    let told = |bench: &Bench| bench.warnings.iter().filter(|one| one.starts_with("no supervisor answers")).count();
    let advice = |bench: &Bench| {
        let snapshot = bench.agent.snapshot(Now::of_us(bench.now_us));
        snapshot.whiskers.into_iter().map(|whisker| whisker.advice.unwrap_or_default()).collect::<Vec<_>>()
    };
    bench.touch(0);
    bench.hold([0.1; 2], 59.0);
    assert_eq!(told(&bench), 0, "{:?}", bench.warnings);
    bench.hold([0.1; 2], 70.0);
    assert_eq!(told(&bench), 1, "{:?}", bench.warnings);
    let expected = format!(
        "no supervisor answers for fleet {fleet}: start one with this fleet, or let the robot read whisker/v1/{fleet}/{robot}/receipt \
         in the broker's access list",
        fleet = bench.agent.fleet,
        robot = bench.agent.robot
    );
    assert_eq!(advice(&bench), [expected.clone(), expected.clone()]);
    bench.receipt("b1", 1);
    assert_eq!(bench.warnings.last().map(String::as_str), Some("a supervisor answers"));
    assert!(!advice(&bench).contains(&expected));
    // A connection that is lost answers nothing, and is told in another way.
    bench.touch(0);
    bench.hold([0.1; 2], 30.0);
    bench.step(Input::Disconnected);
    bench.hold([0.1; 2], 120.0);
    bench.step(Input::Connected);
    bench.hold([0.1; 2], 30.0);
    assert_eq!(told(&bench), 1, "{:?}", bench.warnings);
}
