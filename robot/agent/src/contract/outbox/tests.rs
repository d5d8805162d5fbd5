//! Receipts, repetitions and bounds.

use vibrissa_protocol::BootId;

use super::*;

const S: u64 = 1_000_000;

fn at(us: u64) -> Moment {
    Moment::of_us(us)
}

fn receipt(next: u64, held: &[(u64, u64)]) -> Receipt {
    let boot = BootId::new("b").unwrap();
    Receipt { boot_id: boot.clone(), seq: 0, robot_boot_id: boot, next, held: held.to_vec() }
}

/// An outbox with messages 0.. sent at 100 s; the payload of each is its number.
fn outbox(count: u64, most: usize) -> Outbox {
    let mut outbox = Outbox::new(most);
    (0..count).for_each(|seq| outbox.keep(seq, vec![seq as u8], Some(at(100 * S))));
    outbox
}

fn numbers(payloads: &[Vec<u8>]) -> Vec<u8> {
    payloads.iter().map(|payload| payload[0]).collect()
}

#[test]
fn a_receipt_covers_what_is_below_next_and_what_is_held() {
    let mut outbox = outbox(10, 100);
    outbox.receipt(&receipt(3, &[(5, 6), (9, 20)]), at(100 * S));
    assert_eq!(outbox.messages.keys().copied().collect::<Vec<_>>(), [3, 4, 7, 8]);
    assert_eq!(outbox.by_sent.len(), 4);
    assert_eq!(outbox.newest_covered(), Some(9));
    outbox.receipt(&receipt(10, &[]), at(100 * S));
    assert_eq!((outbox.len(), outbox.resend_at()), (0, None));
}

#[test]
fn uncovered_messages_are_sent_again_oldest_first() {
    let mut outbox = outbox(5, 100);
    outbox.receipt(&receipt(0, &[(1, 2)]), at(100 * S));
    assert_eq!(outbox.resend_at(), Some(at(101 * S)));
    assert_eq!(numbers(&outbox.resend(at(101 * S))), [0, 3, 4]);
}

#[test]
fn the_pause_doubles_while_no_receipt_comes_up_to_its_longest() {
    let mut outbox = outbox(1, 100);
    let mut sent_s = vec![];
    for _ in 0..8 {
        let due = outbox.resend_at().unwrap();
        assert_eq!(outbox.resend(due).len(), 1);
        sent_s.push(due.as_us() / S - 100);
    }
    assert_eq!(sent_s, [1, 2, 4, 8, 16, 32, 62, 92]);
}

#[test]
fn a_receipt_that_covers_something_starts_the_pause_over() {
    let mut outbox = outbox(3, 100);
    for at_s in [101, 102, 104, 108] {
        outbox.resend(at(at_s * S));
    }
    outbox.receipt(&receipt(1, &[]), at(108 * S));
    assert_eq!(outbox.resend_at(), Some(at(109 * S)));
}

#[test]
fn a_gap_is_filled_although_receipts_keep_coming() {
    let mut outbox = outbox(2, 100);
    outbox.receipt(&receipt(0, &[(1, 1)]), at(100 * S));
    for seq in 2..12 {
        let now = at(100 * S + seq * 100_000);
        outbox.keep(seq, vec![seq as u8], Some(now));
        outbox.receipt(&receipt(0, &[(1, seq)]), now);
    }
    assert_eq!(outbox.resend_at(), Some(at(101 * S)));
    assert_eq!(numbers(&outbox.resend(at(101 * S + 100_000))), [0]);
}

#[test]
fn after_a_connection_windows_follow_at_the_pace_of_receipts() {
    let mut outbox = outbox(200, 1000);
    outbox.reconnected();
    assert_eq!(outbox.resend_at(), Some(at(0)));
    assert_eq!(numbers(&outbox.resend(at(200 * S))), (0..64).collect::<Vec<u8>>());
    assert_eq!(outbox.resend_at(), Some(at(201 * S)), "not more before a receipt or a pause");
    outbox.receipt(&receipt(10, &[]), at(200 * S));
    assert_eq!(outbox.resend_at(), Some(at(0)));
    assert_eq!(numbers(&outbox.resend(at(200 * S))), (64..128).collect::<Vec<u8>>());
}

#[test]
fn regress_a_slow_supervisor_gets_no_repetitions_while_its_receipts_arrive() {
    let mut outbox = outbox(0, 1000);
    (0..200).for_each(|seq| outbox.keep(seq, vec![seq as u8], Some(at(100 * S))));
    // Eight messages in a second, so that the last receipt comes after 25 s.
    let mut sent_again = 0;
    for arrived in 1..=200 {
        let now = at(100 * S + arrived * S / 8);
        if outbox.resend_at().is_some_and(|due| due <= now) {
            sent_again += outbox.resend(now).len();
        }
        outbox.receipt(&receipt(arrived, &[]), now);
    }
    assert_eq!((outbox.len(), sent_again), (0, 0));
}

#[test]
fn a_lost_message_is_sent_again_while_receipts_for_others_arrive() {
    let (mut outbox, mut again) = (outbox(0, 1000), 0);
    for seq in 0..40 {
        let now = at(100 * S + seq * S / 4);
        outbox.keep(seq, vec![seq as u8], Some(now));
        // Number 5 never arrives; the others have a receipt 2 s later.
        if let Some(arrived) = seq.checked_sub(8) {
            let held = if arrived > 5 { vec![(6, arrived)] } else { Vec::new() };
            outbox.receipt(&receipt(arrived.min(5), &held), now);
        }
        // Then a receipt for number 6 has shown the loss.
        if seq >= 14 && outbox.resend_at().is_some_and(|due| due <= now) {
            assert_eq!(numbers(&outbox.resend(now)), [5]);
            again += 1;
        }
    }
    assert_eq!((outbox.len(), again), (9, 3), "number 5 after each time that messages need, and eight on their way");
}

#[test]
fn regress_the_oldest_come_again_a_second_after_a_receipt_for_the_newest_on_a_slow_network() {
    let mut outbox = outbox(1, 1000);
    // Messages need 20 s.
    outbox.receipt(&receipt(1, &[]), at(120 * S));
    (1..=200).for_each(|seq| outbox.keep(seq, vec![seq as u8], Some(at(120 * S))));
    for _ in 0..5 {
        let due = outbox.resend_at().unwrap();
        assert_eq!(numbers(&outbox.resend(due))[0], 1);
    }
    let mut now = at(155 * S);
    outbox.receipt(&receipt(1, &[(200, 200)]), now);
    let mut sent = Vec::new();
    while now <= at(156 * S) {
        sent.extend(numbers(&outbox.resend(now)));
        now = outbox.resend_at().unwrap().max(now + 1);
    }
    assert!(sent.contains(&1), "{sent:?}");
}

#[test]
fn beyond_the_most_the_oldest_are_dropped_and_counted() {
    let mut outbox = outbox(7, 5);
    assert_eq!((outbox.len(), outbox.dropped()), (5, 2));
    assert_eq!(numbers(&outbox.resend(at(101 * S))), [2, 3, 4, 5, 6]);
}

#[test]
fn a_restart_loses_what_is_kept_and_counts_it() {
    let mut outbox = outbox(4, 5);
    outbox.restart();
    assert_eq!((outbox.len(), outbox.dropped(), outbox.resend_at()), (0, 4, None));
}
