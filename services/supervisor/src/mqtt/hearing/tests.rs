use super::*;

fn kinds() -> impl Iterator<Item = RobotTopic> {
    RobotTopic::ALL.into_iter().filter(|kind| kind.is_from_robot())
}

/// A state whose first probes were sent, and the time of that.
fn probing() -> (Hearing, Instant) {
    let now = Instant::now();
    let mut hearing = Hearing::new(&Name::new("f").unwrap(), kinds(), now);
    assert_eq!(hearing.tick(now + PERIOD), Tick::Wait, "no probe before the subscription");
    hearing.subscribed(now);
    assert_eq!(hearing.tick(now), Tick::Probe);
    assert!(!hearing.is_proven());
    (hearing, now)
}

/// Lets the probes of the topics that `which` selects come back.
fn deliver(hearing: &mut Hearing, which: impl Fn(RobotTopic) -> bool) {
    let probes: Vec<(String, Vec<u8>)> =
        hearing.probes().map(|(topic, payload)| (topic.to_owned(), payload.to_owned())).collect();
    for (topic, payload) in probes {
        if which(RobotTopic::probed_on(&topic).unwrap()) {
            assert!(hearing.take(topic.as_bytes(), &payload));
        }
    }
}

fn flood(hearing: &mut Hearing, messages: usize) {
    for _ in 0..messages {
        assert!(!hearing.take(b"whisker/v1/f/r/contacts", b"{}"));
    }
}

/// Calls `tick` whenever it is due until there is something to do; returns that and its time.
fn until_done(hearing: &mut Hearing, mut between: impl FnMut(&mut Hearing)) -> (Tick, Instant) {
    loop {
        between(hearing);
        let due = hearing.due();
        match hearing.tick(due) {
            Tick::Wait => {}
            done @ (Tick::Probe | Tick::Unsubscribed | Tick::Deaf { .. }) => return (done, due),
        }
    }
}

#[test]
fn probes_that_come_back_prove_hearing_until_the_next_round() {
    let (mut hearing, sent) = probing();
    deliver(&mut hearing, |_| true);
    assert!(hearing.is_proven() && hearing.round_trip().is_some());
    assert_eq!(until_done(&mut hearing, |_| {}), (Tick::Probe, sent + PERIOD));
    assert!(!hearing.is_proven(), "each round needs its own proof");
}

#[test]
fn each_topic_that_is_lost_is_named_after_two_seconds() {
    for lost in kinds() {
        let (mut hearing, sent) = probing();
        deliver(&mut hearing, |kind| kind != lost);
        let deaf = Tick::Deaf { topics: vec![lost], is_silent: false };
        assert_eq!(until_done(&mut hearing, |_| {}), (deaf, sent + PATIENCE));
    }
}

#[test]
fn silence_is_told_apart_from_a_lost_topic() {
    let deaf = |is_silent| Tick::Deaf { topics: kinds().collect(), is_silent };
    let (mut hearing, sent) = probing();
    assert_eq!(until_done(&mut hearing, |_| {}), (deaf(true), sent + PATIENCE));
    let (mut hearing, sent) = probing();
    hearing.acknowledged();
    assert_eq!(until_done(&mut hearing, |_| {}), (deaf(false), sent + PATIENCE));
}

#[test]
fn a_robots_message_proves_its_filter_and_no_other() {
    let (mut hearing, _) = probing();
    deliver(&mut hearing, |kind| kind != RobotTopic::Contacts && kind != RobotTopic::Status);
    flood(&mut hearing, 1);
    let (done, _) = until_done(&mut hearing, |_| {});
    assert_eq!(done, Tick::Deaf { topics: vec![RobotTopic::Status], is_silent: false });
}

#[test]
fn probes_behind_a_queue_are_waited_for() {
    let (mut hearing, _) = probing();
    let mut looks = 0;
    let (done, _) = until_done(&mut hearing, |hearing| {
        looks += 1;
        flood(hearing, 5_000);
        if looks == 10 {
            deliver(hearing, |_| true);
        }
    });
    assert_eq!((done, looks), (Tick::Probe, 10), "the next round begins after the probes came");
}

#[test]
fn a_burst_does_not_hide_a_lost_topic_and_a_probe_that_it_drops_is_sent_again() {
    for dropped_rounds in [1, usize::MAX] {
        let (mut hearing, sent) = probing();
        let mut rounds = 0;
        let (done, at) = loop {
            deliver(&mut hearing, |kind| kind != RobotTopic::Factsheet || rounds >= dropped_rounds);
            if hearing.is_proven() {
                break (Tick::Wait, sent);
            }
            rounds += 1;
            match until_done(&mut hearing, |hearing| flood(hearing, 5_000)) {
                (Tick::Probe, _) => {}
                done => break done,
            }
        };
        if dropped_rounds == 1 {
            assert_eq!((done, rounds), (Tick::Wait, 1));
        } else {
            assert_eq!(done, Tick::Deaf { topics: vec![RobotTopic::Factsheet], is_silent: false });
            assert!(at >= sent + QUEUE_MAX && at <= sent + QUEUE_MAX + PERIOD, "{:?}", at - sent);
        }
    }
}

#[test]
fn no_queue_is_endless() {
    let (mut hearing, sent) = probing();
    let (done, at) = until_done(&mut hearing, |hearing| flood(hearing, 5_000));
    assert!(matches!(done, Tick::Deaf { is_silent: false, .. }), "{done:?}");
    assert_eq!(at, sent + QUEUE_MAX);
}

#[test]
fn a_process_that_stood_still_gives_its_probes_another_chance() {
    let (mut hearing, sent) = probing();
    let late = sent + Duration::from_secs(60);
    assert_eq!(hearing.tick(late), Tick::Wait);
    deliver(&mut hearing, |_| true);
    assert_eq!(hearing.tick(late + PATIENCE), Tick::Probe);
}

#[test]
fn a_refused_probe_is_no_deafness_and_no_proof() {
    let (mut hearing, sent) = probing();
    deliver(&mut hearing, |kind| kind != RobotTopic::Status);
    hearing.refused();
    flood(&mut hearing, 1);
    assert!(!hearing.is_proven());
    assert_eq!(until_done(&mut hearing, |_| {}), (Tick::Probe, sent + PERIOD));
}

#[test]
fn nobody_elses_probe_answers_ours_and_no_other_message_passes_as_one() {
    let (mut hearing, sent) = probing();
    let foreign = [HEAD, random_hex().as_bytes(), TAIL].concat();
    for kind in kinds() {
        let topic = kind.probe_topic(&Name::new("f").unwrap());
        assert!(hearing.take(topic.as_bytes(), &foreign), "a probe of another supervisor");
        for payload in [&b"{}"[..], b"{\"probe\":\"\"}", br#"{"boot_id":"b","seq":0,"contacts":[]}"#] {
            assert!(!hearing.take(topic.as_bytes(), payload), "a message that goes to the inbox");
        }
    }
    assert!(!hearing.is_proven());
    let (done, at) = until_done(&mut hearing, |_| {});
    assert_eq!((done, at), (Tick::Deaf { topics: kinds().collect(), is_silent: true }, sent + PATIENCE));
}

#[test]
fn an_old_probe_does_not_answer_a_new_round() {
    let (mut hearing, sent) = probing();
    let old: Vec<(String, Vec<u8>)> =
        hearing.probes().map(|(topic, payload)| (topic.to_owned(), payload.to_owned())).collect();
    deliver(&mut hearing, |_| true);
    assert_eq!(hearing.tick(sent + PERIOD), Tick::Probe);
    for (topic, payload) in old {
        assert!(hearing.take(topic.as_bytes(), &payload));
    }
    assert!(!hearing.is_proven());
}

#[test]
fn regress_subscriptions_that_a_node_does_not_acknowledge_have_a_time_limit() {
    let now = Instant::now();
    let mut hearing = Hearing::new(&Name::new("f").unwrap(), kinds(), now);
    hearing.asked(now);
    assert_eq!(until_done(&mut hearing, |_| {}), (Tick::Unsubscribed, now + UNANSWERED));
    // Messages that come before the answer, and a standstill of the process, give it more time.
    flood(&mut hearing, 1);
    assert_eq!(until_done(&mut hearing, |_| {}), (Tick::Unsubscribed, now + 2 * UNANSWERED));
    let woken = now + 4 * UNANSWERED;
    assert_eq!(hearing.tick(woken), Tick::Wait);
    hearing.subscribed(woken);
    hearing.asked(woken);
    assert_eq!(until_done(&mut hearing, |_| {}), (Tick::Probe, woken));
}
