//! Events of the scenario.

use super::*;

#[test]
fn a_trim_by_contact_comes_before_the_contact_of_that_index() {
    let trim = Event::at_contact(20, left(), 0, Change::Trim { length_mm: 60.0 });
    let mut bench = Bench::with_events([trim]);
    bench.run(60.0);
    assert_eq!(bench.robot.true_length_mm(&left(), 0), Some(60.0));
    assert_eq!(bench.robot.true_length_mm(&left(), 1), Some(65.0));
    let change = bench.first().changes()[0];
    let contacts = bench.contacts();
    let of_first = contacts.iter().flat_map(|m| &m.contacts).filter(|c| c.whisker == 0);
    let mut times: Vec<u64> = of_first.map(|contact| contact.t_us).collect();
    times.sort_unstable();
    times.dedup();
    assert_eq!((change.contact, change.t_us, change.length_mm), (20, times[20], 60.0));
}

#[test]
fn erosion_and_temperature_come_at_their_time() {
    let erode = Change::Erode { rate_mm_per_contact: 0.01, until_length_mm: 68.0 };
    let warm = Change::Temperature { sensitivity_factor: 1.1, temperature_c: 33.0 };
    let warm = Event { array: Some(left()), ..Event::robot_at_s(50.0, warm) };
    let mut bench = Bench::with_events([Event::whisker_at_s(10.0, left(), 0, erode), warm]);
    let before = bench.robot.whiskers()[1].plant().sensitivity_per_mm(0.8, 0.1).unwrap();
    bench.run(60.0);
    let length_mm = bench.first().plant().length_mm();
    assert!((length_mm - 69.0).abs() < 0.05, "100 contacts in 50 s: {length_mm}");
    let after = bench.robot.whiskers()[1].plant().sensitivity_per_mm(0.8, 0.1).unwrap();
    assert!((after / before - 1.1).abs() < 1e-9);
}

#[test]
fn a_restart_has_a_new_boot_id_counts_from_zero_and_loses_what_was_kept() {
    let mut bench = Bench::with_events([
        Event::robot_at_s(20.0, Change::Restart),
        Event::whisker_at_s(1.0, left(), 0, Change::Trim { length_mm: 60.0 }),
    ]);
    bench.setpoint(9, 0.05);
    bench.run(19.9);
    let (boot, kept) = (bench.robot.boot_id().clone(), bench.robot.messages_kept() as u64);
    bench.sent();
    bench.run(0.2);
    assert_eq!((bench.restarts, bench.sent().len()), (1, 0), "cut, and nothing before the next connection");
    assert_ne!(*bench.robot.boot_id(), boot);
    bench.connect();
    bench.run(30.0);
    let sent = bench.sent();
    assert!(matches!(&sent[0], Message::Connection(Connection { seq: 0, .. })));
    let Message::Status(status) = &sent[2] else { panic!("no status") };
    assert_eq!((status.seq, status.contacts_dropped), (0, Some(kept)));
    assert!(sent.iter().any(|message| matches!(message, Message::Contacts(Contacts { seq: 0, .. }))));
    assert_eq!(bench.first().regulator().target_mpa(), 0.1, "back to the factsheet's pressure");
    assert_eq!(bench.first().plant().length_mm(), 60.0, "a whisker does not grow back");
    bench.setpoint(1, 0.06);
    assert_eq!(bench.outcomes().len(), 2, "the order of the old boot is forgotten");
}

#[test]
fn a_robot_that_notices_nothing_says_ok_of_a_leak_and_of_a_broken_gauge() {
    let broken = [
        Event::whisker_at_s(1.0, left(), 0, Change::Leak { rate_mpa_per_s: 0.005 }),
        Event::whisker_at_s(1.0, left(), 1, Change::GaugeOpen),
    ];
    let conditions = |notices_faults| {
        let mut bench = Bench::connected(|scenario| {
            scenario.behaviour.notices_faults = notices_faults;
            scenario.robots[0].events.extend(broken.clone());
        });
        bench.run(60.0);
        let statuses = bench.statuses();
        let of =
            |at: usize| statuses.iter().map(move |status| (status.whiskers[at].regulator, status.whiskers[at].gauge));
        (of(0).any(|(regulator, _)| regulator == Regulator::Leak), of(1).any(|(_, gauge)| gauge != Gauge::Ok))
    };
    assert_eq!(conditions(true), (true, true));
    assert_eq!(conditions(false), (false, false));
}

#[test]
fn of_a_silent_whisker_nothing_is_told_until_its_silence_is_over() {
    let mut bench = Bench::with_events([Event::whisker_at_s(10.0, left(), 0, Change::Silent { for_s: 10.0 })]);
    bench.run(30.0);
    let (mut contacts, mut entries) = (Vec::new(), Vec::new());
    for message in bench.sent() {
        if let Message::Contacts(batch) = message {
            contacts.extend(batch.contacts.into_iter().map(|one| (one.whisker, one.t_us)));
        } else if let Message::Status(status) = message {
            entries.extend(status.whiskers.iter().map(|one| (one.whisker, status.t_us)));
        }
    }
    for times in [contacts, entries] {
        let count = |whisker, from_s: u64| {
            let within = START + from_s * S + 1..START + (from_s + 10) * S;
            times.iter().filter(|(of, t_us)| *of == whisker && within.contains(t_us)).count()
        };
        assert!(count(0, 0) > 5 && count(0, 10) == 0 && count(0, 20) > 5, "{:?}", [0, 10, 20].map(|at| count(0, at)));
        assert!(count(1, 10) > 5, "the other one goes on");
    }
}

#[test]
fn a_gauge_can_be_repaired() {
    let mut bench = Bench::with_events([
        Event::whisker_at_s(5.0, left(), 0, Change::GaugeShort),
        Event::whisker_at_s(10.0, left(), 0, Change::GaugeOk),
    ]);
    bench.run(9.0);
    assert_eq!(bench.first().plant().gauge(), Gauge::Short);
    bench.run(2.0);
    assert_eq!(bench.first().plant().gauge(), Gauge::Ok);
}

#[test]
fn a_replaced_whisker_is_whole_and_tight_and_its_gauge_works() {
    let mut bench = Bench::with_events([]);
    let drift = Change::BaselineDrift { strain_per_contact: 1e-6, until_strain: 1e-4 };
    let trim = Change::Trim { length_mm: 60.0 };
    for change in [trim, Change::Leak { rate_mpa_per_s: 0.002 }, Change::GaugeOpen, drift] {
        bench.robot.happen_soon(Some(left()), Some(0), change, START).unwrap();
    }
    bench.run(30.0);
    let condition = |bench: &Bench| (bench.first().regulator().condition(), bench.first().plant().gauge());
    assert_eq!((condition(&bench), bench.first().plant().length_mm()), ((Regulator::Leak, Gauge::Open), 60.0));
    let begun_us = START + 30 * S;
    bench.robot.happen_soon(Some(left()), Some(0), Change::Replace, begun_us).unwrap();
    bench.run(60.0);
    assert_eq!((condition(&bench), bench.first().plant().length_mm()), ((Regulator::Ok, Gauge::Ok), 70.0));
    assert_eq!(bench.first().plant().baseline_strain(), 0.0);
    let changes: Vec<(u64, f64)> = bench.first().changes().iter().map(|one| (one.t_us, one.length_mm)).collect();
    assert_eq!(changes, [(START, 60.0), (begun_us, 70.0)]);
}

#[test]
fn what_cannot_happen_is_refused() {
    let mut bench = Bench::with_events([]);
    let mut refused =
        |array, whisker, change| bench.robot.happen_soon(array, whisker, change, START).unwrap_err().to_string();
    assert!(refused(Some(left()), Some(9), Change::Replace).contains("array left has no whisker 9"));
    assert!(refused(Some(left()), Some(0), Change::Trim { length_mm: 30.0 }).contains("length_mm is 30"));
    assert!(refused(None, Some(0), Change::GaugeOpen).contains("needs array and whisker"));
}

#[test]
fn a_resting_robot_goes_on_at_another_rate() {
    let mut bench = Bench::with_events([]);
    bench.run(10.0);
    bench.robot.rest();
    let before = bench.robot.contacts_made();
    bench.run(10.0);
    assert_eq!(bench.robot.contacts_made(), before);
    bench.robot.touch_at_rate(5.0, START + 20 * S);
    bench.run(10.0);
    let made = bench.robot.contacts_made() - before;
    let expected = 50 * bench.robot.whiskers().len() as u64;
    assert!(made.abs_diff(expected) <= expected / 20, "{made} of {expected}");
}

#[test]
fn a_deflection_scale_is_of_an_array() {
    let scale = Change::DeflectionScale { factor: 1.2 };
    let scale = Event { array: Some(left()), ..Event::robot_at_s(0.0, scale) };
    let deflections = |events: Vec<Event>| {
        let mut bench = Bench::with_events(events);
        bench.run(20.0);
        bench
            .contacts()
            .into_iter()
            .flat_map(|message| message.contacts)
            .map(|one| one.deflection_mm)
            .collect::<Vec<_>>()
    };
    let (scaled, plain) = (deflections(vec![scale]), deflections(Vec::new()));
    assert_eq!(scaled.len(), plain.len());
    assert!(scaled.iter().zip(&plain).all(|(one, other)| (one / other - 1.2).abs() < 2e-3));
}

#[test]
fn a_robot_that_is_taken_up_is_in_a_new_boot_and_nothing_happens_to_it_twice() {
    let scenario = |scenario: &mut Scenario| {
        scenario.robots[0].events.extend([
            Event::at_contact(20, left(), 0, Change::Trim { length_mm: 60.0 }),
            Event::at_contact(60, left(), 0, Change::Trim { length_mm: 55.0 }),
            Event::robot_at_s(5.0, Change::SupplyLow { supply_mpa: 0.05 }),
            Event::whisker_at_s(40.0, left(), 1, Change::GaugeOpen),
        ]);
    };
    let mut before = Bench::connected(scenario);
    before.setpoint(1, 0.05);
    before.run(20.0);
    assert!(before.robot.take_change() && !before.robot.take_change());
    let text = serde_json::to_string(&before.robot.state()).unwrap();

    let mut after = Bench::new(scenario);
    after.now_us = START + 30 * S;
    let state = serde_json::from_str(&text).unwrap();
    after.robot = Robot::resume(after.robot.config.clone(), after.robot.seed, &state, after.now_us).unwrap();
    assert_eq!(after.robot.true_length_mm(&left(), 0), Some(60.0));
    assert_eq!(after.first().changes(), before.first().changes());
    assert_eq!(after.first().plant().contacts(), before.first().plant().contacts());
    assert_eq!(after.first().regulator().pressure_mpa(), before.first().regulator().pressure_mpa());
    assert_eq!(after.first().regulator().target_mpa(), 0.1, "as after every restart");
    assert_ne!(after.robot.boot_id(), before.robot.boot_id());
    after.connect();
    after.run(9.0);
    assert_eq!((after.robot.whiskers()[1].plant().gauge(), after.first().changes().len()), (Gauge::Ok, 1));
    // The scenario's second 40 counts from the robot's first start, and so do its contacts.
    after.run(2.0);
    assert_eq!(after.robot.whiskers()[1].plant().gauge(), Gauge::Open);
    after.run(20.0);
    assert_eq!(after.robot.true_length_mm(&left(), 0), Some(55.0));
    assert_eq!(after.first().changes()[1].contact, 60);
    let statuses = after.statuses();
    assert!(statuses.iter().all(|status| status.boot_id == *after.robot.boot_id()));
    assert!(statuses.len() > 20 && statuses[0].seq == 0);
}
