//! Contacts: made, stored, sent, sent again.

use super::*;

/// Contacts messages of a robot that is polled at intervals of this length.
fn payloads(seed: u64, step_us: u64) -> Vec<Vec<u8>> {
    let mut bench = Bench::new(|scenario| scenario.seed = seed);
    bench.robot.connected(START);
    let mut payloads = Vec::new();
    for now_us in (START..=START + 300 * S).step_by(step_us as usize) {
        for item in bench.robot.poll(now_us) {
            if let Outgoing::Publish { topic: RobotTopic::Contacts, payload } = item {
                payloads.push(payload);
            }
        }
        // Receipted immediately, since repeated transmissions depend on the times of the polls.
        bench.now_us = now_us;
        bench.receipt(payloads.len() as u64);
    }
    payloads
}

#[test]
fn the_same_seed_sends_the_same_contacts_byte_for_byte_however_it_is_polled() {
    let reference = payloads(7, 20_000);
    assert!(reference.len() > 100);
    assert_eq!(reference, payloads(7, 250_000));
    assert_ne!(reference, payloads(8, 20_000));
}

#[test]
fn contacts_come_at_their_rate_in_order_and_without_gaps() {
    let mut bench = Bench::connected(|_| {});
    bench.run(100.0);
    bench.receipt(0);
    assert_eq!(bench.robot.contacts_made(), 400, "two whiskers, two per second");
    let mut contacts = bench.contacts();
    contacts.sort_by_key(|message| message.seq);
    contacts.dedup();
    assert_eq!(seqs(&contacts), (0..contacts.len() as u64).collect::<Vec<_>>());
    let times: Vec<u64> = contacts.iter().flat_map(|message| &message.contacts).map(|contact| contact.t_us).collect();
    assert!(times.is_sorted() && times.len() >= 396, "{} in messages, the rest waits", times.len());
    assert!(contacts.iter().all(|message| message.contacts.len() <= 10));
}

#[test]
fn contacts_are_sent_again_until_a_receipt_covers_them() {
    let mut bench = Bench::connected(|_| {});
    bench.run(10.0);
    let sent = seqs(&bench.contacts());
    assert!(sent.iter().filter(|&&seq| seq == 0).count() > 1, "{sent:?}");
    let made = bench.robot.messages_kept() as u64;
    bench.receipt(made);
    assert_eq!(bench.robot.messages_kept(), 0);
    bench.robot.rest();
    bench.run(60.0);
    let after = seqs(&bench.contacts());
    assert!(after.iter().all(|&seq| seq >= made), "what is receipted is not sent again: {after:?}");
}

#[test]
fn a_receipt_for_another_boot_covers_nothing() {
    let mut bench = Bench::connected(|_| {});
    bench.run(10.0);
    let kept = bench.robot.messages_kept();
    let boot_id = supervisor();
    let receipt = Receipt { robot_boot_id: boot_id.clone(), boot_id, seq: 0, next: 100, held: vec![] };
    bench.send(RobotTopic::Receipt, &encode(&receipt));
    assert_eq!(bench.robot.messages_kept(), kept);
}

#[test]
fn contacts_made_without_a_connection_are_kept_and_sent_after_the_next() {
    let mut bench = Bench::new(|_| {});
    bench.run(20.0);
    assert!(bench.sent().is_empty());
    bench.connect();
    bench.run(0.1);
    assert_eq!(seqs(&bench.contacts()).len(), bench.robot.messages_kept());
}

#[test]
fn the_oldest_contacts_are_dropped_and_counted_in_the_status() {
    let mut bench = Bench::connected(|scenario| scenario.behaviour.kept_messages = 5);
    bench.run(60.0);
    let dropped = bench.robot.messages_dropped();
    assert!(dropped > 0);
    assert_eq!(bench.robot.messages_kept(), 5);
    assert_eq!(bench.statuses().pop().unwrap().contacts_dropped, Some(dropped));
}

#[test]
fn messages_lost_on_their_first_way_are_sent_again() {
    let mut bench = Bench::with_events([Event::robot_at_s(0.0, Change::Lose { fraction: 0.5, for_s: 60.0 })]);
    let mut all = Vec::new();
    for _ in 0..120 {
        bench.run(0.5);
        all.extend(seqs(&bench.contacts()));
        let mut arrived = all.clone();
        arrived.sort_unstable();
        arrived.dedup();
        let next = arrived.iter().enumerate().take_while(|&(at, &seq)| at as u64 == seq).count();
        bench.receipt(next as u64);
    }
    bench.robot.rest();
    bench.run(5.0);
    all.extend(seqs(&bench.contacts()));
    assert!(!all.is_sorted(), "some came late");
    all.sort_unstable();
    all.dedup();
    assert_eq!(all, (0..all.len() as u64).collect::<Vec<_>>());
}

#[test]
fn a_robot_that_woke_up_late_catches_up_in_bounded_steps() {
    let mut bench = Bench::connected(|_| {});
    let late_us = START + 3600 * S;
    let mut polls = 0;
    while bench.robot.next_deadline() <= late_us {
        let outgoing = bench.robot.poll(late_us);
        assert!(outgoing.len() <= STEPS_PER_POLL);
        polls += 1;
    }
    assert!(polls > 10);
    assert_eq!(bench.robot.contacts_made(), 4 * 3600);
}
