//! Contacts messages that violate the contract.

use serde_json::{Value, json};
use vibrissa_protocol::{ArrayType, Contact, Message, RobotTopic, encode, encode_cbor};
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::{until, until_true};
use vibrissa_tests::web::try_get;

use super::{Names, assert_recorded, counts, good, names, start, template};

/// A message with something wrong, the reason of the refusal, and its contacts that are recorded nevertheless.
type Junk = (Vec<u8>, &'static str, Names);

/// A message whose second contact has another value in a field, or lacks the field, and the first contact.
fn spoilt(robot: &mut HandRobot, field: &str, value: Option<Value>) -> (Vec<u8>, Names) {
    let mut message = template(robot);
    let first = names(&serde_json::from_value(message.clone()).unwrap())[..1].to_vec();
    let contact = message["contacts"][1].as_object_mut().unwrap();
    match value {
        Some(value) => contact.insert(field.to_owned(), value),
        None => contact.remove(field),
    };
    (message.to_string().into_bytes(), first)
}

/// Messages with something wrong and a readable number.
fn readable_junk(robot: &mut HandRobot) -> Vec<Junk> {
    let spoilt: Vec<Junk> = [
        ("ratio", Some(json!(0)), "out_of_range"),
        ("ratio", Some(json!(1.2)), "out_of_range"),
        ("ratio", Some(json!("NaN")), "malformed"),
        ("distance_mm", Some(json!(50.0)), "malformed"),
        ("tip", Some(json!(true)), "malformed"),
        ("deflection_mm", Some(json!(-2.4)), "out_of_range"),
        ("deflection_mm", Some(json!(0.0)), "out_of_range"),
        ("strain", Some(json!(1.5)), "out_of_range"),
        ("strain", Some(json!(null)), "malformed"),
        ("strain", None, "malformed"),
        ("pressure_mpa", Some(json!(-0.01)), "out_of_range"),
        ("temperature_c", Some(json!([24.1])), "malformed"),
        ("whisker", Some(json!("0")), "malformed"),
        ("whisker", Some(json!(65_536)), "malformed"),
        ("array", Some(json!("left front")), "malformed"),
        ("t_us", Some(json!(-1)), "malformed"),
    ]
    .into_iter()
    .map(|(field, value, reason)| {
        let (payload, kept) = spoilt(robot, field, value);
        (payload, reason, kept)
    })
    .collect();
    let mut junk: Vec<(Vec<u8>, &str)> = Vec::new();

    // Fields in the contract's order, so that the number comes before the invalid part.
    let contacts = vec![Contact { ratio: Some(0.75), ..robot.contact(0) }];
    let whole = String::from_utf8(encode(&robot.message(contacts))).unwrap();
    junk.push((whole.replace("0.75", "NaN").into_bytes(), "malformed"));
    let contacts = vec![robot.contact(0)];
    let mut half = encode(&robot.message(contacts));
    half.truncate(half.len() / 2);
    junk.push((half, "not_json"));
    let contacts = vec![Contact { ratio: Some(1.2), ..robot.contact(0) }];
    junk.push((encode_cbor(&robot.message(contacts)), "out_of_range"));
    let contacts = vec![Contact { strain: f64::NAN, ..robot.contact(0) }];
    junk.push((encode_cbor(&robot.message(contacts)), "malformed"));
    let contacts = vec![robot.contact(0)];
    let mut half = encode_cbor(&robot.message(contacts));
    half.truncate(half.len() / 2);
    junk.push((half, "not_cbor"));
    let mut scalar = template(robot);
    scalar["contacts"] = json!("many");
    junk.push((scalar.to_string().into_bytes(), "malformed"));
    let contacts = vec![robot.contact(0); 1001];
    junk.push((encode(&robot.message(contacts)), "too_many"));
    let mut large = template(robot);
    large["padding"] = json!("x".repeat(1 << 20));
    junk.push((large.to_string().into_bytes(), "too_large"));
    spoilt.into_iter().chain(junk.into_iter().map(|(payload, reason)| (payload, reason, Names::new()))).collect()
}

#[tokio::test]
async fn contacts_in_cbor_are_recorded_and_receipted_as_those_in_json() {
    let (running, mut robot) = start("r").await;
    let mut expected = good(&mut robot).await;
    for _ in 0..3 {
        let contacts = vec![robot.contact(0), robot.contact(1)];
        let message = robot.message(contacts);
        expected.extend(names(&message));
        // The same message in the other encoding is the same message.
        robot.say(RobotTopic::Contacts, encode_cbor(&message)).await;
        robot.say(RobotTopic::Contacts, encode(&message)).await;
        expected.extend(good(&mut robot).await);
    }
    let receipt = robot.receipted().await;
    assert!(receipt.held.is_empty(), "{receipt:?}");
    assert_recorded(&running, &expected).await;
    assert_eq!(running.metrics().await.refused(), counts(&[]));
    running.service.stop().await;
}

#[tokio::test]
async fn regress_a_bad_contact_is_refused_alone_under_its_reason_and_the_good_ones_around_it_are_recorded_once() {
    let (running, mut robot) = start("r").await;
    let mut expected = good(&mut robot).await;
    let mut reasons = Vec::new();
    for (payload, reason, kept) in readable_junk(&mut robot) {
        robot.say(RobotTopic::Contacts, payload).await;
        reasons.push(reason);
        expected.extend(kept);
        expected.extend(good(&mut robot).await);
    }
    robot.receipted().await;
    assert_recorded(&running, &expected).await;
    assert_eq!(running.metrics().await.refused(), counts(&reasons));
    running.service.stop().await;
}

#[tokio::test]
async fn a_refused_message_whose_number_can_be_read_is_receipted() {
    let (running, mut robot) = start("r").await;
    let mut expected = Names::new();
    for (payload, _, kept) in readable_junk(&mut robot) {
        robot.say(RobotTopic::Contacts, payload).await;
        expected.extend(kept);
    }
    let receipt = robot.receipted().await;
    assert!(receipt.held.is_empty(), "{receipt:?}");
    assert_recorded(&running, &expected).await;
    running.service.stop().await;
}

#[tokio::test]
async fn regress_refused_contacts_are_counted_by_robot_and_reason() {
    let (running, mut robot) = start("r").await;
    for value in ["null", "NaN", "\"x\"", "1.5"] {
        let contacts = (0..10).map(|_| Contact { strain: 0.125, ..robot.contact(0) }).collect();
        let text = String::from_utf8(encode(&robot.message(contacts))).unwrap();
        robot.say(RobotTopic::Contacts, text.replacen("0.125", value, 1).into_bytes()).await;
    }
    robot.receipted().await;
    assert_eq!(running.database.contacts().await.len(), 36);
    let counts = until("the refusals are written", async || {
        let refusals = running.list("fleets/f/robots/r/refusals").await;
        let mut counts: Vec<(String, u64)> =
            refusals.iter().map(|one| (one["reason"].to_string(), one["refused"].as_u64().unwrap())).collect();
        counts.sort();
        let sum: u64 = counts.iter().map(|(_, count)| count).sum();
        (sum == 4).then_some((counts, refusals))
    });
    let (counts, refusals) = counts.await;
    assert_eq!(counts, [("\"malformed\"".to_owned(), 3), ("\"out_of_range\"".to_owned(), 1)]);
    assert!(refusals.iter().all(|one| one["problem"].as_str().unwrap().starts_with("contacts[0].strain")));
    assert_eq!(running.metric("vibrissa_contacts_refused_total{fleet=\"f\"}").await, 4.0);
    until_true("the notice", async || {
        let (status, body) = try_get(running.service.http, "/readyz").await.unwrap();
        let part = "messages of robot f/r are refused (contacts, ";
        status == 200 && body.contains(part) && body.contains("contacts[0].strain")
    })
    .await;
    running.service.stop().await;
}

#[tokio::test]
async fn a_message_whose_number_cannot_be_read_stops_no_later_one() {
    let (running, mut robot) = start("r").await;
    let mut unnumbered = template(&mut robot);
    unnumbered.as_object_mut().unwrap().remove("seq");
    let mut lifted = unnumbered.clone();
    // The robot has used this number, so the supervisor would wait for its message.
    lifted["seq"] = json!(1);
    lifted["contacts"] = json!([]);
    robot.say(RobotTopic::Contacts, lifted.to_string()).await;

    let mut beyond = unnumbered.clone();
    beyond["seq"] = json!(1_u64 << 53);
    let mut negative = unnumbered.clone();
    negative["seq"] = json!(-1);
    let junk: [(Vec<u8>, &str); 9] = [
        (unnumbered.to_string().into_bytes(), "malformed"),
        (beyond.to_string().into_bytes(), "out_of_range"),
        (negative.to_string().into_bytes(), "malformed"),
        (Vec::new(), "not_json"),
        (b"hello".to_vec(), "not_json"),
        (b"[]".to_vec(), "malformed"),
        (b"{}".to_vec(), "malformed"),
        (vec![0xff; 100], "not_json"),
        (vec![b'['; 1 << 20], "too_large"),
    ];
    let mut expected = good(&mut robot).await;
    let mut reasons = Vec::new();
    for (payload, reason) in junk {
        robot.say(RobotTopic::Contacts, payload).await;
        reasons.push(reason);
        expected.extend(good(&mut robot).await);
    }
    robot.receipted().await;
    assert_recorded(&running, &expected).await;
    assert_eq!(running.metrics().await.refused(), counts(&reasons));
    running.service.stop().await;
}

#[tokio::test]
async fn a_contact_of_an_unknown_whisker_costs_only_itself() {
    let (running, mut robot) = start("r").await;
    let mut contacts: Vec<Contact> = (0..4).map(|_| robot.contact(1)).collect();
    contacts[0].whisker = 99;
    contacts[2].array = "right".parse().unwrap();
    let message = robot.send(contacts).await;
    robot.receipted().await;
    let expected = names(&message).into_iter().filter(|name| name.2 % 2 == 1).collect();
    assert_recorded(&running, &expected).await;
    assert_eq!(running.metrics().await.refused(), counts(&["unknown_whisker"; 2]));
    running.service.stop().await;
}

#[tokio::test]
async fn a_second_message_of_the_same_number_changes_nothing() {
    let (running, mut robot) = start("r").await;
    let contacts = vec![robot.contact(0), robot.contact(1)];
    let first = robot.send(contacts).await;
    let mut another = first.clone();
    another.contacts[0].ratio = Some(0.5);
    for again in [&first, &another, &first] {
        robot.say(RobotTopic::Contacts, encode(again)).await;
    }
    let mut expected = names(&first);
    expected.extend(good(&mut robot).await);
    robot.receipted().await;
    assert_recorded(&running, &expected).await;
    assert_eq!(running.database.contacts().await[0].strain, first.contacts[0].strain);
    assert_eq!(running.metric("vibrissa_messages_duplicate_total{fleet=\"f\"}").await, 3.0);
    running.service.stop().await;
}

#[tokio::test]
async fn contacts_beyond_a_gap_are_held_until_it_is_closed() {
    let (running, mut robot) = start("r").await;
    let contacts = vec![robot.contact(0), robot.contact(1)];
    let missing = robot.message(contacts);
    let mut expected = good(&mut robot).await;
    let held = vec![(missing.seq + 1, missing.seq + 1)];
    robot
        .hear("a receipt with a gap", |heard| match &heard.message {
            Message::Receipt(receipt) => (receipt.next == missing.seq && receipt.held == held).then_some(()),
            _ => None,
        })
        .await;
    robot.say(RobotTopic::Contacts, encode(&missing)).await;
    expected.extend(names(&missing));
    assert!(robot.receipted().await.held.is_empty());
    assert_recorded(&running, &expected).await;
    running.service.stop().await;
}

#[tokio::test]
async fn contacts_under_another_robots_boot_are_not_taken() {
    let (running, mut one) = start("one").await;
    let mut other = HandRobot::born(running.port(), "other", array(ArrayType::Type1, &[70.0, 65.0])).await;
    let mut expected = good(&mut one).await;
    let foreign = serde_json::to_value(one.message(vec![])).unwrap();
    let mut bad = foreign.clone();
    bad["contacts"] = json!("many");
    other.say(RobotTopic::Contacts, foreign.to_string()).await;
    other.say(RobotTopic::Contacts, bad.to_string()).await;
    // The number is still unused on the robot's own topic.
    one.say(RobotTopic::Contacts, foreign.to_string()).await;
    one.receipted().await;
    expected.extend(good(&mut other).await);
    other.receipted().await;
    assert_recorded(&running, &expected).await;
    assert_eq!(running.metrics().await.refused(), counts(&["unknown_boot", "malformed", "unknown_boot"]));
    assert_eq!(running.metric("vibrissa_messages_duplicate_total{fleet=\"f\"}").await, 0.0);
    running.service.stop().await;
}
