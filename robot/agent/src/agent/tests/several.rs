//! Several drivers of one agent: each has its whiskers, its silence and its rates, and their values are joined by time.

use std::collections::BTreeSet;

use vibrissa_protocol::{Contact, PlaceKind, Regulator};

use super::*;

/// Index of the board, which reads strain and pressure, and of the host, which moves the whiskers.
const BOARD: usize = 0;
const HOST: usize = 1;

/// The drivers of a robot with two whiskers.
fn bench(drivers: &str, place: PlaceKind) -> Bench {
    let text = EXAMPLE.replacen("    [driver]\n    command = [\"python3\", \"driver.py\"]\n", drivers, 1);
    assert_ne!(text, EXAMPLE);
    let mut bench = Bench::new(|config| {
        *config = Config::from_toml_str(&text, Path::new("")).unwrap();
        config.facts.arrays[0].whiskers.iter_mut().for_each(|whisker| whisker.place = Some(place));
    });
    bench.step(Input::Connected);
    (0..bench.agent.drivers.len()).for_each(|driver| bench.step(Input::DriverStarted(driver)));
    bench
}

const BOARD_AND_HOST: &str = "[[driver]]\nname = \"board\"\nserial = \"/dev/ttyACM0\"\n\
    [[driver]]\nname = \"host\"\ncommand = [\"host\"]\n";
const TWO_BOARDS: &str = "[[driver]]\nserial = \"/dev/ttyACM0\"\nwhiskers = [\"left/0\"]\n\
    [[driver]]\nserial = \"/dev/ttyACM1\"\nwhiskers = [\"left/1\"]\nsilent_s = 2.0\n";

impl Bench {
    fn say(&mut self, driver: usize, line: &str) {
        self.step(Input::Line(driver, Some(line.as_bytes())));
    }

    fn press(&mut self, driver: usize, whisker: u16) {
        self.say(driver, &format!(r#"{{"type":"pressure","whisker":{whisker},"pressure_mpa":0.1}}"#));
    }

    /// Contacts that were sent, each once: without a receipt they are sent again.
    fn sent(&mut self) -> Vec<Contact> {
        let messages = self.contacts().into_iter().map(|message| (message.seq, message.contacts));
        messages.collect::<BTreeMap<_, _>>().into_values().flatten().collect()
    }
}

/// Problems that a driver was told.
fn problems_of(lines: &[ToDriver]) -> Vec<&str> {
    lines
        .iter()
        .filter_map(|line| if let ToDriver::Error { problem, .. } = line { Some(&**problem) } else { None })
        .collect()
}

#[test]
fn each_board_is_told_of_its_own_whiskers_only() {
    let mut bench = bench(TWO_BOARDS, PlaceKind::Ratio);
    let told = |lines: &[ToDriver]| {
        lines
            .iter()
            .filter_map(|line| if let ToDriver::SetPressure { whisker, .. } = line { Some(*whisker) } else { None })
            .collect::<Vec<u16>>()
    };
    assert_eq!((told(&bench.to_driver), told(&bench.to_others)), (vec![0], vec![1]));
    bench.press(0, 1);
    assert_eq!(problems_of(&bench.to_driver), ["driver 1 does not serve whisker left/1"]);
}

#[test]
fn regress_a_silent_board_does_not_stop_another_one() {
    let mut bench = bench(TWO_BOARDS, PlaceKind::Ratio);
    bench.press(0, 0);
    bench.press(1, 1);
    for _ in 0..60 {
        bench.run(0.1);
        bench.press(0, 0);
    }
    assert_eq!(bench.restarts, 1, "of the silent one, after its own time");
    let status = bench.statuses().pop().unwrap();
    let regulators: Vec<Regulator> = status.whiskers.iter().map(|whisker| whisker.regulator).collect();
    assert_eq!(regulators, [Regulator::Ok, Regulator::Fault]);
    bench.order(1, 0.12);
    assert!(bench.outcomes().contains(&(SetpointOutcome::Applying, None)));
    let setpoint = Setpoint { whisker: 1, ..bench.setpoint(2, 0.12) };
    bench.send(RobotTopic::Setpoint, &setpoint);
    assert_eq!(bench.outcomes(), [(SetpointOutcome::Rejected, Some(SetpointError::NotReady))]);
}

#[test]
fn a_flood_of_one_driver_leaves_the_rates_of_another_one() {
    let mut bench = bench(TWO_BOARDS, PlaceKind::Ratio);
    bench.press(0, 0);
    bench.press(1, 1);
    for _ in 0..5_000 {
        bench.say(0, "nonsense");
        bench.touch(0);
    }
    bench.take();
    bench.say(1, r#"{"type":"contact","whisker":1,"deflection_mm":2.0,"strain":0.01,"ratio":0.8}"#);
    bench.run(0.2);
    assert!(bench.sent().iter().any(|contact| contact.whisker == 1));
}

/// Strain of the board and motion of `host` for six seconds with one touch; `late_us` is how late the host's lines
/// come.
fn touch_of_two(bench: &mut Bench, host: usize, late_us: u64, gap_blocks: std::ops::Range<u64>, value: &str) {
    touch_of_two_then(bench, host, late_us, gap_blocks, value, |_, _| {});
}

/// The same; `then` follows each tenth of a second.
fn touch_of_two_then(
    bench: &mut Bench,
    host: usize,
    late_us: u64,
    gap_blocks: std::ops::Range<u64>,
    value: &str,
    then: impl Fn(&mut Bench, u64),
) {
    let begin_us = bench.now_us;
    let way_mm = |s: f64| ((s - 3.0) / 0.2).clamp(0.0, 1.0) * 2.0 - ((s - 4.0) / 0.2).clamp(0.0, 1.0) * 2.0;
    let motion = |block: u64| {
        let seconds = block as f64 * 0.1;
        format!(
            r#"{{"type":"motion","whisker":0,"deflection_mm":{},{value},"t_us":{}}}"#,
            40.0 + way_mm(seconds),
            begin_us + block * 100_000
        )
    };
    for block in 0..75_u64 {
        let now_us = begin_us + (block + 1) * 100_000;
        bench.run((now_us - bench.now_us) as f64 / 1e6);
        let samples: Vec<String> = (0..10)
            .map(|at| {
                let index = block * 10 + at;
                let noise = if (index * 3) % 5 < 2 { 2e-6 } else { -1e-6 };
                format!("{:.7}", 1e-3 + 0.005 * way_mm(index as f64 * 0.01) + noise)
            })
            .collect();
        bench.say(
            BOARD,
            &format!(
                r#"{{"type":"strain","whisker":0,"strain":[{}],"every_us":10000,"t_ms":{}}}"#,
                samples.join(","),
                7_000 + block * 100
            ),
        );
        bench.press(BOARD, 0);
        let heard = (block * 100_000).checked_sub(late_us).map(|us| us / 100_000);
        if let Some(heard) = heard.filter(|heard| !gap_blocks.contains(heard)) {
            bench.say(host, &motion(heard));
        }
        then(bench, block);
    }
}

#[test]
fn regress_strain_of_a_board_and_motion_of_a_host_become_one_contact() {
    for late_us in [0, 300_000, 800_000] {
        for (place, value) in [(PlaceKind::Distance, r#""distance_mm":52.5"#), (PlaceKind::Ratio, r#""ratio":0.75"#)] {
            let mut bench = bench(BOARD_AND_HOST, place);
            let begin_us = bench.now_us;
            touch_of_two(&mut bench, HOST, late_us, 0..0, value);
            let sent = bench.sent();
            assert_eq!(sent.len(), 1, "{late_us} {place}: {:?} {:?}", bench.to_driver, bench.to_others);
            let contact = &sent[0];
            let expected = if place == PlaceKind::Ratio { (Some(0.75), None) } else { (None, Some(52.5)) };
            assert_eq!((contact.ratio, contact.distance_mm), expected);
            assert!((contact.strain - 0.01).abs() < 3e-4 && (contact.deflection_mm - 2.0).abs() < 0.15, "{contact:?}");
            let seconds = (contact.t_us - begin_us) as f64 / 1e6;
            assert!((3.1..4.3).contains(&seconds), "{seconds}");
        }
    }
}

#[test]
fn strain_and_motion_in_lines_of_one_driver_become_one_contact_too() {
    let mut bench = bench(BOARD_AND_HOST, PlaceKind::Distance);
    touch_of_two(&mut bench, BOARD, 300_000, 0..0, r#""distance_mm":52.5"#);
    let sent = bench.sent();
    assert_eq!(sent.len(), 1, "{:?}", bench.to_driver);
    assert!((sent[0].deflection_mm - 2.0).abs() < 0.15 && sent[0].distance_mm == Some(52.5), "{:?}", sent[0]);
}

#[test]
fn without_the_motion_of_its_time_no_contact_is_sent() {
    let mut bench = bench(BOARD_AND_HOST, PlaceKind::Distance);
    // The motion stops before the touch.
    touch_of_two(&mut bench, HOST, 0, 25..75, r#""distance_mm":52.5"#);
    assert_eq!(bench.sent(), []);
    assert_eq!(bench.agent.counts().contacts, 0);
}

#[test]
fn parts_of_a_contact_are_joined_by_time_in_either_order() {
    let strain = |t_us: u64| format!(r#"{{"type":"contact","whisker":0,"strain":0.01,"t_us":{t_us}}}"#);
    let place =
        |t_us: u64| format!(r#"{{"type":"contact","whisker":0,"deflection_mm":2.0,"ratio":0.8,"t_us":{t_us}}}"#);
    for (board_first, apart_us, joined) in [(true, 0, 1), (false, 250_000, 1), (true, 250_000, 1), (true, 350_000, 0)] {
        let mut bench = bench(BOARD_AND_HOST, PlaceKind::Ratio);
        bench.press(BOARD, 0);
        let t_us = bench.now_us;
        bench.now_us += 400_000;
        let lines = [(BOARD, strain(t_us)), (HOST, place(t_us + apart_us))];
        let order = if board_first { [0, 1] } else { [1, 0] };
        order.into_iter().for_each(|at| bench.say(lines[at].0, &lines[at].1));
        bench.run(2.0);
        let sent = bench.sent();
        assert_eq!(sent.len(), joined, "{apart_us}");
        assert!(sent.iter().all(|one| (one.strain, one.deflection_mm, one.t_us) == (0.01, 2.0, t_us)), "{sent:?}");
        assert_eq!(bench.agent.counts().contacts_unusable, if joined == 0 { 2 } else { 0 });
    }
}

#[test]
fn regress_parts_beyond_those_that_wait_are_counted_too() {
    let mut bench = bench(BOARD_AND_HOST, PlaceKind::Ratio);
    bench.press(BOARD, 0);
    (0..65).for_each(|_| bench.say(BOARD, r#"{"type":"contact","whisker":0,"strain":0.01}"#));
    assert_eq!(bench.agent.counts().contacts_unusable, 1);
    bench.run(2.0);
    assert_eq!(bench.agent.counts().contacts_unusable, 65);
}

/// Contacts of a board whose whisker is tapped for 0.1 s each second, as stones under a wheel do.
fn tapped(bench: &mut Bench) -> usize {
    for block in 0..200_u64 {
        let list = |value: &dyn Fn(f64) -> f64| {
            let values = (0..10).map(|at| format!("{:.7}", value((block * 10 + at) as f64 * 0.01)));
            values.collect::<Vec<String>>().join(",")
        };
        let depth_mm = |s: f64| 2.0 * (1.0 - ((s % 1.0 - 0.5) / 0.05).abs()).max(0.0);
        let strain = list(&|s| {
            let noise = if ((s * 100.0) as u64).is_multiple_of(3) { 2e-6 } else { -1e-6 };
            1e-3 + 0.001 * depth_mm(s) + noise
        });
        // A way through the air shows which level is rest.
        let way = list(&|s| 20.0 + (s - 0.1).clamp(0.0, 0.3) * 10.0 + depth_mm(s));
        bench.run(0.1);
        bench.press(BOARD, 0);
        bench.say(
            BOARD,
            &format!(
                r#"{{"type":"strain","whisker":0,"strain":[{strain}],"deflection_mm":[{way}],"distance_mm":50,"every_us":10000}}"#
            ),
        );
    }
    bench.run(0.5);
    bench.sent().len()
}

#[test]
fn a_robot_that_says_it_drives_has_fewer_contacts_of_its_jolts() {
    let contacts = |says: Option<bool>| {
        let mut bench = bench(BOARD_AND_HOST, PlaceKind::Distance);
        says.into_iter().for_each(|says| bench.say(HOST, &format!(r#"{{"type":"driving","driving":{says}}}"#)));
        tapped(&mut bench)
    };
    let (unsaid, standing, driving) = (contacts(None), contacts(Some(false)), contacts(Some(true)));
    assert!(unsaid >= 12 && standing >= 12, "{unsaid} and {standing} of 20");
    assert!(driving < standing, "{driving} of {standing}");
}

#[test]
fn a_driver_that_has_gone_drives_no_more() {
    let mut bench = bench(BOARD_AND_HOST, PlaceKind::Distance);
    bench.say(HOST, r#"{"type":"driving","driving":true}"#);
    assert_eq!(bench.agent.drives(0), Some(true));
    bench.step(Input::DriverEnded(HOST));
    assert_eq!(bench.agent.drives(0), None);
    bench.step(Input::DriverStarted(HOST));
    assert_eq!(bench.agent.drives(0), None, "it has to say so again");
}

#[test]
fn two_drivers_do_not_read_one_pressure_and_one_takes_over_from_another() {
    let mut bench = bench(BOARD_AND_HOST, PlaceKind::Ratio);
    bench.press(BOARD, 0);
    bench.press(HOST, 0);
    assert_eq!(problems_of(&bench.to_others), ["driver board reads the pressure of this whisker already"]);
    bench.step(Input::DriverEnded(BOARD));
    bench.press(HOST, 0);
    bench.order(1, 0.1);
    assert!(bench.outcomes().contains(&(SetpointOutcome::Applying, None)));
}

/// A request for a touch test of two touches.
fn request(version: u64) -> vibrissa_protocol::Request {
    let test = TouchTest {
        test_id: format!("t{version}"),
        epoch: 1,
        version,
        robot_boot_id: bench_boot(),
        array: left(),
        whisker: 0,
        kind: TouchTestKind::Wall,
        distances_mm: vec![50.0],
        deflections_mm: vec![1.0],
        contacts: 2,
        issued: Timestamp(START),
        expires_us: START + 60 * S,
        reason: TouchTestReason::Operator,
    };
    let touch_test = Some(test);
    vibrissa_protocol::Request { boot_id: supervisor(), seq: 0, request: RequestKind::TouchTest, touch_test }
}

#[test]
fn regress_the_last_touch_of_a_test_counts_although_its_strain_comes_after_done() {
    const DONE: &str = r#"{"type":"test_state","test_id":"t5","state":"DONE"}"#;
    // The touch ends after 4.2 s.
    for (late_us, done) in [(0, 40), (300_000, 42)] {
        let mut bench = bench(BOARD_AND_HOST, PlaceKind::Distance);
        bench.press(BOARD, 0);
        bench.send(RobotTopic::Request, &request(5));
        touch_of_two_then(&mut bench, HOST, late_us, 0..0, r#""distance_mm":52.5,"test_id":"t5""#, |bench, block| {
            if block == done {
                bench.say(HOST, DONE);
            }
        });
        let told = told_of_tests(&mut bench);
        assert_eq!(told, ["ACCEPTED", "RUNNING", "t5", "DONE"], "{late_us}: {:?}", bench.to_others);
    }
}

#[test]
fn a_test_that_is_done_does_not_fail_with_its_driver() {
    let mut bench = bench(BOARD_AND_HOST, PlaceKind::Distance);
    bench.press(BOARD, 0);
    bench.say(BOARD, r#"{"type":"strain","whisker":0,"strain":0.001}"#);
    bench.send(RobotTopic::Request, &request(5));
    bench.say(HOST, r#"{"type":"test_state","test_id":"t5","state":"DONE"}"#);
    assert_eq!(told_of_tests(&mut bench), ["ACCEPTED", "RUNNING"], "strain may come");
    bench.step(Input::DriverEnded(HOST));
    assert_eq!(told_of_tests(&mut bench), ["DONE"]);
}

/// States of touch tests, and the tests of contacts, in the order in which they were first sent.
fn told_of_tests(bench: &mut Bench) -> Vec<String> {
    let told = bench.take().0.into_iter().filter_map(|message| {
        if let Message::TestState(state) = message {
            Some(state.state.to_string())
        } else if let Message::Contacts(message) = message {
            message.contacts[0].test_id.clone()
        } else {
            None
        }
    });
    let mut told: Vec<String> = told.collect();
    // Without a receipt a contact is sent again.
    let mut seen = BTreeSet::new();
    told.retain(|one| seen.insert(one.clone()));
    told
}

#[test]
fn a_touch_test_fails_with_the_driver_that_does_it() {
    let mut bench = bench(BOARD_AND_HOST, PlaceKind::Ratio);
    bench.press(BOARD, 0);
    for (ended, outcomes) in [(BOARD, 0), (HOST, 1)] {
        bench.send(RobotTopic::Request, &request(5 + ended as u64));
        bench.say(HOST, &format!(r#"{{"type":"test_state","test_id":"t{}","state":"RUNNING"}}"#, 5 + ended));
        bench.take();
        bench.step(Input::DriverEnded(ended));
        let failed =
            bench.take().0.into_iter().filter(
                |message| matches!(message, Message::TestState(state) if state.state == TouchTestOutcome::Failed),
            );
        assert_eq!(failed.count(), outcomes);
        bench.step(Input::DriverStarted(ended));
        bench.press(BOARD, 0);
        while !bench.agent.under_way.is_empty() {
            bench.say(HOST, r#"{"type":"test_state","test_id":"t5","state":"DONE"}"#);
        }
    }
}

fn bench_boot() -> BootId {
    BootId::new("b1").unwrap()
}
