//! Tests of both ends of the inbox.

use vibrissa_host::task;
use vibrissa_protocol::Name;

use super::*;
use crate::inbox::Filling;
use crate::metrics::Metrics;

const SMALL: Bounds = Bounds { messages: 100, messages_reserved: 10, bytes: 100_000, bytes_reserved: 20_000 };

fn topic(kind: &str) -> Bytes {
    Bytes::from(format!("whisker/v1/f/r/{kind}"))
}

/// Receives `count` messages, and returns the largest number of bytes that ever waited.
fn flood(intake: &mut Intake, kind: &str, payload_bytes: usize, count: usize) -> usize {
    let payload = Bytes::from(vec![b'x'; payload_bytes]);
    let mut most = 0;
    for number in 0..count {
        intake.take(topic(kind), payload.clone());
        // In groups of seven, as messages arrive together.
        if number % 7 == 6 || number == count - 1 {
            intake.hand_over();
        }
        most = most.max(intake.shared.filling().bytes);
    }
    most
}

/// Receives messages of many robots until the inbox is full.
fn fill(intake: &mut Intake, kind: &str) {
    for robot in 0..=SMALL.messages {
        intake.take(Bytes::from(format!("whisker/v1/f/r{robot}/{kind}")), Bytes::from_static(b"x"));
    }
    intake.hand_over();
    assert_eq!(intake.shared.filling().messages, SMALL.messages);
}

async fn drain(inbox: &mut Inbox) {
    while !inbox.is_empty() {
        inbox.recv().await.unwrap();
    }
}

fn counted() -> FleetMetrics {
    Metrics::new(false).unwrap().of_fleet(&Name::new("f").unwrap())
}

fn left_out(metrics: &FleetMetrics) -> (u64, u64) {
    let refused = [INBOX_FULL, OVER_SHARE].map(|reason| metrics.messages_refused.of([reason]).get());
    (metrics.messages_shed.get(), refused.iter().sum())
}

#[tokio::test]
async fn floods_of_any_kind_stay_within_both_bounds_and_are_counted() {
    for (kind, payload_bytes) in [("status", 10), ("connection", 5_000), ("contacts", 10), ("contacts", 5_000)] {
        let metrics = counted();
        let (mut intake, mut inbox) = bounded(SMALL, metrics.clone());
        let most = flood(&mut intake, kind, payload_bytes, 5_000);
        assert!(most <= SMALL.bytes, "{kind} of {payload_bytes}: {most} bytes");
        drop(intake);
        let mut taken = 0;
        while inbox.recv().await.is_some() {
            taken += 1;
        }
        assert!((1..=SMALL.messages as u64).contains(&taken), "{kind}: {taken}");
        let (shed, refused) = left_out(&metrics);
        assert_eq!(shed + refused + taken, 5_000, "{kind}: every message is received or counted as shed");
        assert_eq!(shed == 0, kind != "contacts");
        assert_eq!(inbox.filling(), Filling { messages: 0, bytes: 0 });
    }
}

#[tokio::test]
async fn contacts_leave_room_for_everything_else() {
    for payload_bytes in [10, 5_000] {
        let metrics = counted();
        let (mut intake, _inbox) = bounded(SMALL, metrics.clone());
        flood(&mut intake, "contacts", payload_bytes, 1_000);
        flood(&mut intake, "setpoint_state", 200, SMALL.messages_reserved);
        assert_eq!(left_out(&metrics).1, 0);
    }
}

#[tokio::test]
async fn what_is_retained_is_asked_for_again_once_there_is_room() {
    let (mut intake, mut inbox) = bounded(SMALL, counted());
    fill(&mut intake, "factsheet");
    assert_eq!(intake.take_wanted(), None, "the inbox is still full");
    drain(&mut inbox).await;
    assert_eq!(intake.take_wanted(), Some(BirthCause::Shed));
    assert_eq!(intake.take_wanted(), None, "only once");
    fill(&mut intake, "status");
    drain(&mut inbox).await;
    assert_eq!(intake.take_wanted(), None, "a status is no birth");
    inbox.want_births(BirthCause::Allowed);
    assert_eq!(intake.take_wanted(), Some(BirthCause::Allowed));
    assert_eq!(intake.take_wanted(), None, "only once");
}

#[tokio::test]
async fn a_message_does_not_keep_the_buffer_alive_that_it_came_in() {
    let (mut intake, mut inbox) = bounded(SMALL, counted());
    let buffer = Bytes::from(vec![b'x'; 1_000_000]);
    intake.take(topic("status"), buffer.slice(..10));
    intake.hand_over();
    assert!(buffer.is_unique(), "the inbox must not keep the buffer alive");
    assert_eq!(inbox.recv().await.unwrap().payload.len(), 10);
}

/// A tick between the receipt and the hand-over was later than the message. It found whiskers silent that were not.
#[tokio::test]
async fn regress_a_message_that_is_not_handed_over_yet_is_the_oldest() {
    let (mut intake, mut inbox) = inbox(counted());
    assert_eq!(inbox.oldest(), None);
    let before = wall_clock();
    intake.take(topic("contacts"), Bytes::from_static(b"1"));
    let oldest = inbox.oldest();
    assert!(oldest.is_some_and(|oldest| (before..=wall_clock()).contains(&oldest)), "{oldest:?}");
    intake.hand_over();
    assert_eq!(inbox.oldest(), oldest);
    intake.take(topic("contacts"), Bytes::from_static(b"2"));
    assert_eq!(inbox.recv().await.map(|message| message.received), oldest);
    assert!(inbox.oldest() > oldest, "the second is received, but not handed over");
    intake.hand_over();
    drain(&mut inbox).await;
    assert_eq!(inbox.oldest(), None);
}

#[tokio::test]
async fn what_came_together_is_given_in_order_and_as_it_came() {
    let (mut intake, mut inbox) = bounded(BOUNDS, counted());
    let payload = |number: usize| Bytes::from(vec![number as u8; number % 50 * 20]);
    for number in 0..200 {
        intake.take(topic(&number.to_string()), payload(number));
    }
    assert!(inbox.is_empty(), "empty before the hand-over");
    intake.hand_over();
    let (mut all, mut counts) = (Vec::new(), Vec::new());
    drop(intake);
    loop {
        match inbox.recv_many(&mut all, 90).await {
            0 => break,
            count => counts.push(count),
        }
    }
    assert_eq!(counts, [90, 90, 20]);
    for (number, incoming) in all.iter().enumerate() {
        assert_eq!((&incoming.topic, &incoming.payload), (&topic(&number.to_string()), &payload(number)));
    }
}

#[tokio::test]
async fn regress_a_message_that_waits_for_long_keeps_no_other_alive() {
    let (mut intake, mut inbox) = bounded(BOUNDS, counted());
    let payload = Bytes::from(vec![b'x'; 1_000]);
    // One robot has sent more than it may in a round; each hand-over adds one of its messages, and many of others.
    for _ in 0..300 {
        intake.take(topic("contacts"), payload.clone());
    }
    intake.hand_over();
    while !inbox.is_throttling() {
        inbox.recv_many(&mut Vec::new(), 1_000).await;
    }
    for attempt in 0..300 {
        intake.take(topic("contacts"), payload.clone());
        for other in 0..20 {
            intake.take(Bytes::from(format!("whisker/v1/f/other-{attempt}-{other}/contacts")), payload.clone());
        }
        intake.hand_over();
        inbox.recv_many(&mut Vec::new(), 1_000).await;
    }
    inbox.begin_round(1);
    let mut left = Vec::new();
    inbox.recv_many(&mut left, 1_000).await;
    assert!(left.len() > 180, "{}", left.len());
    // The first ones were received together.
    for message in left.drain(..).skip(150) {
        drop(message.topic);
        let alone = message.payload.try_into_mut().unwrap_or_else(|_| panic!("it shares an allocation"));
        assert!(alone.capacity() < 2_000, "an allocation of {} bytes", alone.capacity());
    }
}

#[test]
fn messages_that_share_an_allocation_are_few_or_small() {
    let message = |bytes: usize| (Bytes::new(), Bytes::from(vec![0; bytes]), 0);
    assert_eq!(sharing(&[message(10), message(20), message(SHARED_BYTES)]), (2, 30));
    assert_eq!(sharing(&[message(10 * SHARED_BYTES), message(1)]), (1, 10 * SHARED_BYTES));
    assert_eq!(sharing(&[message(SHARED_BYTES - 1), message(1), message(1)]), (2, SHARED_BYTES));
}

#[tokio::test]
async fn whoever_waits_is_woken_by_a_message_and_by_the_end() {
    let (mut intake, mut inbox) = bounded(SMALL, counted());
    let waiting = task::spawn(async move {
        let first = inbox.recv().await.map(|incoming| incoming.payload.len());
        (first, inbox.recv().await.is_none())
    });
    tokio::task::yield_now().await;
    intake.take(topic("status"), Bytes::from_static(b"x"));
    intake.hand_over();
    tokio::task::yield_now().await;
    drop(intake);
    assert_eq!(waiting.await.unwrap(), (Some(1), true));
}

#[tokio::test]
async fn a_wait_that_is_given_up_loses_nothing() {
    let (mut intake, mut inbox) = bounded(SMALL, counted());
    for _ in 0..3 {
        let mut given_up = Box::pin(inbox.recv());
        assert!(futures_util::poll!(&mut given_up).is_pending());
        intake.take(topic("status"), Bytes::from_static(b"x"));
        intake.hand_over();
        drop(given_up);
        assert!(inbox.recv().await.is_some());
    }
}

#[test]
fn what_comes_when_nobody_takes_it_any_more_is_counted() {
    let metrics = counted();
    let (mut intake, inbox) = bounded(SMALL, metrics.clone());
    drop(inbox);
    flood(&mut intake, "contacts", 10, 1_000);
    assert_eq!(left_out(&metrics), (1_000, 0));
    assert_eq!(intake.shared.filling(), Filling { messages: 0, bytes: 0 });
}
