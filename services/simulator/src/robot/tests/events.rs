//! What happens to a robot.

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
