use std::collections::BTreeMap;

use bytes::Bytes;

use super::*;

/// Pseudorandom numbers with a fixed seed.
struct Random(u64);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % end
    }
}

const BOUNDS: Bounds = Bounds { messages: 10_000, messages_reserved: 1_000, bytes: 8 << 20, bytes_reserved: 1 << 20 };

fn topic(robot: usize, kind: &str) -> Bytes {
    Bytes::from(format!("whisker/v1/f/r{robot}/{kind}"))
}

fn message(robot: usize, kind: &str, number: u64, bytes: usize) -> Incoming {
    Incoming { topic: topic(robot, kind), payload: Bytes::from(vec![b'x'; bytes]), received: Micros(number) }
}

/// Adds a message; false if it is shed.
fn put(fair: &mut FairQueues, message: Incoming) -> bool {
    let place = fair.reserve(&message.topic, &message.payload, &BOUNDS);
    place.map(|at| fair.push(at, message)).is_ok()
}

fn robot(message: &Incoming) -> usize {
    String::from_utf8_lossy(robot_of(&message.topic))[1..].parse().unwrap()
}

fn given(fair: &mut FairQueues, most: usize) -> Vec<Incoming> {
    let mut all = Vec::new();
    fair.give(most, &mut |message| all.push(message));
    all
}

#[test]
fn brute_force_no_message_waits_for_more_than_a_turn_of_each_other_robot() {
    const KINDS: [&str; 4] = ["contacts", "status", "connection", "factsheet"];
    for seed in 0..40 {
        let mut random = Random(seed);
        let robots = 2 + random.below(10);
        let mut fair = FairQueues::default();
        // By robot: the waiting messages' numbers, and the bytes given by each other robot since the first of them came
        // to the front.
        let mut waiting: BTreeMap<usize, VecDeque<u64>> = BTreeMap::new();
        let mut since_front: BTreeMap<usize, BTreeMap<usize, usize>> = BTreeMap::new();
        let (mut number, mut cost_max) = (0, 0);
        for _ in 0..400 {
            for _ in 0..random.below(30) {
                // Robot 0 sends most messages.
                let from = if random.below(10) < 7 { 0 } else { random.below(robots) };
                let kind = KINDS[random.below(if from == 0 { 4 } else { 2 })];
                let one = message(from, kind, number, random.below(20_000));
                cost_max = cost_max.max(cost(&one));
                if put(&mut fair, one) {
                    waiting.entry(from).or_default().push_back(number);
                    since_front.entry(from).or_default();
                    number += 1;
                }
            }
            for _ in 0..random.below(25) {
                // Each message has a round of its own: this test does not check the limit per round.
                fair.begin_round(fair.round + 1);
                let Some(one) = given(&mut fair, 1).pop() else { break };
                let from = robot(&one);
                assert_eq!(waiting.get_mut(&from).unwrap().pop_front(), Some(one.received.0), "in the robot's order");
                for (other, given) in &mut since_front {
                    if *other != from && !waiting[other].is_empty() {
                        *given.entry(from).or_default() += cost(&one);
                    }
                }
                since_front.insert(from, BTreeMap::new());
                for (other, given) in &since_front {
                    // A message at the front may cost several turns; meanwhile the others have as many.
                    let turns = 1 + cost_max.div_ceil(TURN_BYTES);
                    for (&by, &bytes) in given {
                        assert!(
                            bytes <= (turns + 1) * TURN_BYTES + cost_max,
                            "seed {seed}: {other} waited for {by}: {bytes}"
                        );
                    }
                }
            }
            let left: usize = waiting.values().map(VecDeque::len).sum();
            assert_eq!((fair.waiting, fair.held().messages), (left, left));
        }
        while fair.give(100, &mut drop) > 0 {
            fair.begin_round(fair.round + 1);
        }
        assert!(fair.is_empty());
        fair.begin_round(fair.round + 1);
        assert_eq!((fair.held(), fair.by_robot.len(), fair.turns.len()), (Filling::default(), 0, 0));
    }
}

#[test]
fn a_robot_that_floods_takes_half_of_the_room_and_leaves_the_rest_to_the_others() {
    for kind in ["contacts", "status", "factsheet"] {
        let mut fair = FairQueues::default();
        let taken = (0..20_000).filter(|&number| put(&mut fair, message(0, kind, number, 1_000))).count();
        assert!(fair.held().bytes <= BOUNDS.bytes / 2 + 2_000, "{kind}: {taken} messages");
        for robot in 1..500 {
            assert!(put(&mut fair, message(robot, "contacts", 0, 3_000)), "{kind}: robot {robot}");
        }
        let (shed, others) = fair.take_shed();
        assert_eq!((shed.len(), others), (1, 0));
        assert_eq!((shed[0].robot.as_slice(), shed[0].messages), (&b"r0"[..], 20_000 - taken as u64));
        assert_eq!(fair.take_shed(), (Vec::new(), 0));
    }
}

#[test]
fn a_robot_gives_no_more_than_its_bytes_for_a_round_and_goes_on_in_the_next() {
    let mut fair = FairQueues::default();
    for number in 0..400 {
        put(&mut fair, message(0, "contacts", number, 3_000));
    }
    put(&mut fair, message(1, "contacts", 1_000, 3_000));
    let count = |all: &[Incoming], from| all.iter().filter(|one| robot(one) == from).count();
    let first = given(&mut fair, 1_000);
    let most = ROUND_BYTES / 3_000 + 1;
    assert!((most / 2..=most).contains(&count(&first, 0)), "{}", count(&first, 0));
    assert_eq!(count(&first, 1), 1);
    assert!(given(&mut fair, 1_000).is_empty(), "the rest waits for another round");
    assert!(!fair.is_empty() && fair.is_throttling());
    assert_eq!(fair.oldest(), None, "throttled messages do not count");
    let next = first.iter().filter(|one| robot(one) == 0).map(|one| one.received.0 + 1).max().unwrap();
    assert_eq!(fair.delayed().collect::<Vec<_>>(), [(&b"r0"[..], Micros(next))]);
    put(&mut fair, message(2, "status", 2_000, 10));
    assert_eq!(fair.oldest(), Some(Micros(2_000)));
    assert_eq!(given(&mut fair, 1_000).len(), 1);
    fair.begin_round(1);
    assert_eq!(given(&mut fair, 1_000).len(), count(&first, 0));
    for round in 2..10 {
        fair.begin_round(round);
        given(&mut fair, 1_000);
    }
    assert!(fair.is_empty() && !fair.is_throttling());
    assert_eq!(fair.delayed().count(), 0);
}

#[test]
fn regress_a_robot_whose_queue_was_empty_has_no_second_share_of_the_round() {
    let mut fair = FairQueues::default();
    let mut first = 0;
    for number in 0..400 {
        put(&mut fair, message(0, "contacts", number, 3_000));
        first += given(&mut fair, 1_000).len();
    }
    assert!((50..=ROUND_BYTES / 3_000 + 1).contains(&first), "{first}");
    fair.begin_round(1);
    assert!(given(&mut fair, 1_000).len() >= first - 1);
}

#[test]
fn a_message_that_is_larger_than_all_limits_of_a_turn_goes_through() {
    let mut fair = FairQueues::default();
    assert!(put(&mut fair, message(0, "factsheet", 0, 2 << 20)));
    put(&mut fair, message(0, "contacts", 1, 10));
    put(&mut fair, message(1, "contacts", 2, 10));
    let order: Vec<u64> = given(&mut fair, 10).iter().map(|one| one.received.0).collect();
    assert_eq!(order, [2, 0], "the small one first; the message after the large one waits for another round");
    fair.begin_round(1);
    assert_eq!(given(&mut fair, 10).len(), 1);
}

#[test]
fn queues_of_robots_that_were_made_up_are_not_kept() {
    let mut fair = FairQueues::default();
    for robot in 0..100_000 {
        assert!(put(&mut fair, message(robot, "status", 0, 10)));
        assert_eq!(given(&mut fair, 1).len(), 1);
    }
    assert!(fair.queues.len() <= IDLE_MAX + 2 && fair.by_robot.len() <= IDLE_MAX + 1, "{}", fair.queues.len());
    fair.begin_round(1);
    assert!(fair.by_robot.is_empty());
}
