//! Samples become contacts: with each way of telling time, and with what the driver knows of the motion.

use vibrissa_protocol::{Contact, PlaceKind, Segmenter};

use super::*;
use crate::config::Sign;

/// Samples in a line, and the time between them.
const COUNT: usize = 10;
const EVERY_US: u64 = 10_000;

/// The way in which lines of the test tell time.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Clock {
    None,
    Board,
    Agent,
}

/// A bench whose whiskers have a place.
fn bench(place: PlaceKind) -> Bench {
    bench_of(place, None)
}

/// The same, with a stated sign of the strain.
fn bench_of(place: PlaceKind, sign: Option<Sign>) -> Bench {
    let mut bench = Bench::new(|config| {
        config.facts.arrays[0].whiskers.iter_mut().for_each(|whisker| whisker.place = Some(place));
        config.whiskers.values_mut().for_each(|whisker| whisker.sign = sign);
    });
    bench.step(Input::Connected);
    bench.step(Input::DriverStarted(0));
    bench.read(0, 0.1);
    bench.take();
    bench
}

/// Way of the whisker's base at a time: 2 mm against something from 3.0 to 3.2 s, a hold, and back, or off the tip.
fn way_mm(seconds: f64, slips: bool) -> f64 {
    let way = ((seconds - 3.0) / 0.2).clamp(0.0, 1.0) * 2.0;
    if slips { way } else { way - ((seconds - 4.0) / 0.2).clamp(0.0, 1.0) * 2.0 }
}

/// Feeds six seconds with one touch; the contacts that were sent, and the problems that were answered.
fn felt(bench: &mut Bench, clock: Clock, more: &str, slips: bool) -> (Vec<Contact>, Vec<String>) {
    felt_by(bench, 0.005, clock, more, slips)
}

/// The same with so much strain a millimetre.
fn felt_by(bench: &mut Bench, per_mm: f64, clock: Clock, more: &str, slips: bool) -> (Vec<Contact>, Vec<String>) {
    felt_but(bench, per_mm, clock, more, slips, 0..0)
}

/// The same without some lines, each of 0.1 s.
fn felt_but(
    bench: &mut Bench,
    per_mm: f64,
    clock: Clock,
    more: &str,
    slips: bool,
    missing: std::ops::Range<usize>,
) -> (Vec<Contact>, Vec<String>) {
    let begin_us = bench.now_us;
    let (mut contacts, mut problems) = (Vec::new(), Vec::new());
    for block in (0..60).filter(|block| !missing.contains(block)) {
        let seconds = |at: usize| (block * COUNT + at) as f64 * 0.01;
        // After a slip-off the whisker is free within 20 ms.
        let deflection = |at: usize| if slips && seconds(at) > 4.0 { 0.0 } else { way_mm(seconds(at), slips) };
        let noise = |at: usize| if (block * 7 + at * 3) % 5 < 2 { 2e-6 } else { -1e-6 };
        let list = |value: &dyn Fn(usize) -> f64| {
            (0..COUNT).map(|at| format!("{:.7}", value(at))).collect::<Vec<String>>().join(",")
        };
        let strain = list(&|at| 1e-3 + per_mm * deflection(at) + noise(at));
        let way = list(&|at| 40.0 + way_mm(seconds(at), slips));
        bench.now_us =
            bench.now_us.max(begin_us + (block as u64 + 1) * COUNT as u64 * EVERY_US + (block as u64 % 3) * 3_000);
        let first_us = begin_us + block as u64 * COUNT as u64 * EVERY_US;
        let time = match clock {
            Clock::None => String::new(),
            Clock::Board => format!(r#","t_ms":{}"#, 5_000 + (first_us - begin_us) / 1000),
            Clock::Agent => format!(r#","t_us":{first_us}"#),
        };
        let more = more.replace("WAY", &format!("[{way}]"));
        bench
            .line(&format!(r#"{{"type":"strain","whisker":0,"strain":[{strain}],"every_us":{EVERY_US}{time}{more}}}"#));
        bench.read(0, 0.1);
        let (messages, lines) = bench.take();
        for message in messages {
            if let Message::Contacts(message) = message {
                bench.receipt("b1", message.seq + 1);
                contacts.extend(message.contacts);
            }
        }
        problems.extend(
            lines.into_iter().filter_map(
                |line| {
                    if let ToDriver::Error { problem, .. } = line { Some(problem) } else { None }
                },
            ),
        );
    }
    (contacts, problems)
}

#[test]
fn a_touch_becomes_one_contact_whatever_tells_the_time() {
    for clock in [Clock::None, Clock::Board, Clock::Agent] {
        let mut bench = bench(PlaceKind::Distance);
        let begin_us = bench.now_us;
        let (contacts, problems) = felt(&mut bench, clock, r#","deflection_mm":WAY,"distance_mm":52.5"#, false);
        assert_eq!((contacts.len(), problems), (1, vec![]), "{clock:?}");
        let contact = &contacts[0];
        assert_eq!((contact.distance_mm, contact.tip, contact.pressure_mpa), (Some(52.5), false, 0.1));
        assert!((contact.strain - 0.01).abs() < 2e-4 && (contact.deflection_mm - 2.0).abs() < 0.1, "{contact:?}");
        let seconds = (contact.t_us - begin_us) as f64 / 1e6;
        assert!((3.1..4.2).contains(&seconds), "{clock:?}: {seconds} s");
    }
}

#[test]
fn regress_a_contact_with_a_gap_is_shown_as_one_that_could_not_be_sent() {
    let mut bench = bench_of(PlaceKind::Distance, Some(Sign::Rises));
    let more = r#","deflection_mm":WAY,"distance_mm":52.5"#;
    let (contacts, _) = felt_but(&mut bench, 0.005, Clock::Agent, more, false, 33..38);
    assert_eq!(contacts, []);
    let view = bench.agent.snapshot(Now::of_us(bench.now_us));
    assert_eq!(
        view.whiskers[0].unused.get("samples were missing in a contact or right after it"),
        Some(&1),
        "{view:?}"
    );
    assert_eq!(bench.agent.counts().contacts_unusable, 1);
}

#[test]
fn a_strain_that_falls_in_a_touch_is_positive_for_the_supervisor_if_that_is_stated() {
    let more = r#","deflection_mm":WAY,"distance_mm":52.5"#;
    for (sign, per_mm) in [(None, 0.005), (Some(Sign::Rises), 0.005), (Some(Sign::Falls), -0.005)] {
        let (contacts, problems) = felt_by(&mut bench_of(PlaceKind::Distance, sign), per_mm, Clock::Agent, more, false);
        assert_eq!((contacts.len(), problems), (1, vec![]), "{sign:?}");
        assert!((contacts[0].strain - 0.01).abs() < 2e-4, "{sign:?}: {:?}", contacts[0]);
    }
}

#[test]
fn regress_a_gauge_that_goes_against_its_stated_sign_is_told_once_and_shown() {
    let more = r#","deflection_mm":WAY,"distance_mm":52.5"#;
    for (sign, per_mm) in [(Sign::Rises, -0.005), (Sign::Falls, 0.005)] {
        let mut bench = bench_of(PlaceKind::Distance, Some(sign));
        let contacts: Vec<Contact> =
            (0..25).flat_map(|_| felt_by(&mut bench, per_mm, Clock::Agent, more, false).0).collect();
        assert_eq!(contacts.len(), 25, "{sign:?}");
        assert!(contacts.iter().all(|contact| (contact.strain + 0.01).abs() < 4e-4), "{sign:?}: {contacts:?}");
        let told = "whisker left/0: touches move the strain against segmenter.sign";
        assert!(bench.warnings.len() == 1 && bench.warnings[0].starts_with(told), "{sign:?}: {:?}", bench.warnings);
        let view = &bench.agent.snapshot(Now::of_us(bench.now_us)).whiskers[0];
        assert_eq!(view.segmenter, Some(Segmenter::Inverted), "{sign:?}");
        assert!(view.advice.as_ref().is_some_and(|advice| advice.contains("segmenter.sign")), "{view:?}");
    }
}

#[test]
fn a_slip_off_is_a_contact_at_the_tip_and_other_touches_of_such_whiskers_are_left_out() {
    let more = r#","deflection_mm":WAY"#;
    let (contacts, problems) = felt(&mut bench(PlaceKind::Tip), Clock::Board, more, true);
    assert_eq!((contacts.len(), problems), (1, vec![]));
    assert!(contacts[0].tip && contacts[0].distance_mm.is_none(), "{:?}", contacts[0]);
    assert_eq!(felt(&mut bench(PlaceKind::Tip), Clock::Board, more, false), (vec![], vec![]));
}

#[test]
fn what_a_contact_lacks_is_told_and_counted() {
    let mut distant = bench(PlaceKind::Distance);
    let (contacts, problems) = felt(&mut distant, Clock::Board, r#","deflection_mm":WAY"#, false);
    let lacking = "not its distance from the base";
    assert!(contacts.is_empty() && problems.len() == 1 && problems[0].contains(lacking), "{problems:?}");
    assert_eq!(distant.agent.counts().contacts_unusable, 1);
    // Without a deflection, one touch does not tell which level of the strain is rest.
    assert_eq!(felt(&mut bench(PlaceKind::Distance), Clock::Board, "", false), (vec![], vec![]));
    let (contacts, _) = felt(&mut bench(PlaceKind::Unknown), Clock::Board, r#","deflection_mm":WAY"#, false);
    assert_eq!(contacts.len(), 1);
}

#[test]
fn lines_of_a_wrong_shape_are_refused() {
    let mut bench = bench(PlaceKind::Distance);
    for (line, problem) in [
        (r#""strain":[]"#, "0 samples, but a line has 1 to 1000"),
        (r#""strain":[0.1,0.2]"#, "several samples need every_us"),
        (r#""strain":[0.1,0.2],"every_us":1"#, "every_us is 1, but must be between 500 and 100000"),
        (r#""strain":[0.1,0.2],"every_us":1000,"strain_2":[0.1]"#, "strain_2 has 1 values, and strain has 2"),
        (r#""strain":[0.1],"t_us":1,"t_ms":1"#, "t_us and t_ms exclude each other"),
        (r#""strain":["a"]"#, "Samples"),
    ] {
        bench.line(&format!(r#"{{"type":"strain","whisker":0,{line}}}"#));
        let problems = bench.problems();
        assert!(problems.len() == 1 && problems[0].contains(problem), "{line}: {problems:?}");
    }
}

#[test]
fn regress_single_samples_without_a_time_have_that_of_their_receipt() {
    let mut bench = bench(PlaceKind::Unknown);
    let mut contacts = 0;
    for at in 0..600_u64 {
        bench.run(0.01);
        let (way, noise) = (way_mm(at as f64 * 0.01, false), if at % 5 < 2 { 2e-6 } else { -1e-6 });
        let strain = 1e-3 + 0.005 * way + noise;
        bench.line(&format!(r#"{{"type":"strain","whisker":0,"strain":{strain:.7},"deflection_mm":{way}}}"#));
        if at % 10 == 0 {
            bench.read(0, 0.1);
        }
        for message in bench.contacts() {
            bench.receipt("b1", message.seq + 1);
            contacts += message.contacts.len();
        }
    }
    assert_eq!(contacts, 1);
}

#[test]
fn a_restarted_board_begins_a_new_stream() {
    let mut bench = bench(PlaceKind::Distance);
    let more = r#","deflection_mm":WAY,"distance_mm":52.5"#;
    assert_eq!(felt(&mut bench, Clock::Board, more, false).0.len(), 1);
    // The board's clock begins at the same time again.
    assert_eq!(felt(&mut bench, Clock::Board, more, false).0.len(), 1);
}

#[test]
fn regress_a_converter_that_ends_below_the_deflection_is_a_saturated_gauge() {
    let mut bench = bench(PlaceKind::Distance);
    // 4 mm of deflection at 0.0046 a millimetre, where the converter ends at 0.005.
    let (mut gauges, mut contacts) = (Vec::new(), Vec::new());
    for block in 0..60_usize {
        let way = |at: usize| way_mm((block * COUNT + at) as f64 * 0.01, false) * 2.0;
        let strains: Vec<String> = (0..COUNT)
            .map(|at| format!("{:.6}", (0.0046 * way(at) + ((at % 3) as f64 - 1.0) * 1e-5).min(0.005)))
            .collect();
        let ways: Vec<String> = (0..COUNT).map(|at| way(at).to_string()).collect();
        bench.run(0.1);
        bench.read(0, 0.1);
        bench.read(1, 0.1);
        bench.line(&format!(
            r#"{{"type":"strain","whisker":0,"strain":[{}],"deflection_mm":[{}],"distance_mm":50,"every_us":10000}}"#,
            strains.join(","),
            ways.join(",")
        ));
        let messages = bench.take().0;
        gauges.extend(messages.iter().filter_map(|message| {
            if let Message::Status(status) = message { Some(status.whiskers[0].gauge) } else { None }
        }));
        contacts.extend(
            messages
                .into_iter()
                .filter_map(|one| if let Message::Contacts(one) = one { Some(one.contacts) } else { None }),
        );
    }
    let contacts = contacts.concat();
    assert!(gauges.contains(&vibrissa_protocol::Gauge::Saturated), "{gauges:?}");
    assert!(bench.warnings.len() == 1 && bench.warnings[0].contains("stays at 0.005"), "{:?}", bench.warnings);
    // Its strain is a lower bound. Without a receipt it is sent again.
    assert_eq!(bench.agent.counts().contacts, 1);
    assert!(contacts[0].saturated && contacts[0].strain < 0.006 && contacts[0].deflection_mm > 3.9, "{contacts:?}");
}
