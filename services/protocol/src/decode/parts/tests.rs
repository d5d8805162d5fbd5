use proptest::prelude::*;
use proptest::sample::select;
use serde_json::{Value, json};

use crate::document::examples::{CONTACTS, STATUS};
use crate::{Message, Refusal, RobotTopic, Topic, decode, decode_contacts, encode_cbor, receive, receive_contacts};

const COUNT: usize = 10;

/// The golden message with ten entries; their whiskers are their positions.
fn ten(text: &str, list: &str) -> Value {
    let mut message: Value = serde_json::from_str(text).unwrap();
    let entries = (0..COUNT).map(|whisker| {
        let mut entry = message[list][0].clone();
        entry["whisker"] = json!(whisker);
        entry
    });
    message[list] = entries.collect();
    message
}

/// Ten contacts, the fifth with `value` as the text of its ratio.
fn with_ratio(value: &[u8]) -> Vec<u8> {
    let mut message = ten(CONTACTS, "contacts");
    message["contacts"][4]["ratio"] = json!("VALUE");
    let text = message.to_string();
    let (before, after) = text.split_once("\"VALUE\"").unwrap();
    [before.as_bytes(), value, after.as_bytes()].concat()
}

/// The whiskers of the kept contacts, and the refusals.
fn received(payload: &[u8]) -> (Vec<u16>, Vec<Refusal>) {
    let received = receive_contacts(payload, Vec::new()).unwrap();
    (received.message.contacts.iter().map(|one| one.whisker).collect(), received.refused)
}

fn assert_fifth_alone_refused(payload: &[u8], expected: &str) {
    let (kept, refused) = received(payload);
    assert_eq!(kept, [0, 1, 2, 3, 5, 6, 7, 8, 9], "{expected}");
    assert_eq!(refused.iter().map(ToString::to_string).collect::<Vec<_>>(), [expected]);
    assert_eq!(decode_contacts(payload, Vec::new()).unwrap_err(), refused[0], "a strict reader refuses the message");
}

#[test]
fn regress_one_bad_contact_of_ten_is_refused_alone() {
    let number = |shown: &str| format!("contacts[4].ratio: \"{shown}\" was given, a number is required");
    for word in ["NaN", "nan", "-inf", "-Infinity", "?", ".5", "5.", "+1", "0x1F", "True", "None", "007"] {
        assert_fifth_alone_refused(&with_ratio(word.as_bytes()), &number(word));
    }
    assert_fifth_alone_refused(&with_ratio(b""), &number("nothing"));
    for (value, expected) in [
        ("\"x\"", "contacts[4].ratio: \"x\" was given, a number is required"),
        ("[]", "contacts[4].ratio: "),
        ("1.5", "contacts[4].ratio is 1.5, but must be between 0.01 and 1"),
        ("1e999", "contacts[4]: "),
        ("0.5,\"tip\":null", "contacts[4].tip: null was given, true or false is required"),
        ("0.5,\"test_id\":\"\"", "contacts[4].test_id: must have 1 to 64 characters, none of them a control character"),
    ] {
        let (kept, refused) = received(&with_ratio(value.as_bytes()));
        assert_eq!(kept, [0, 1, 2, 3, 5, 6, 7, 8, 9], "{value}");
        assert!(refused[0].to_string().starts_with(expected), "{value}: {}", refused[0]);
    }
    // A required number may not be null, an optional one may.
    let null = ten(CONTACTS, "contacts").to_string().replacen("\"strain\":0.009671", "\"strain\":null", 1);
    let (kept, refused) = received(null.as_bytes());
    assert_eq!(
        (kept.len(), refused[0].to_string()),
        (9, "contacts[0].strain: null was given, a number is required".into())
    );
}

#[test]
fn regress_bytes_that_are_no_text_spoil_their_own_contact() {
    for name in [&b"le\xfft"[..], b"le\x01t", b"le\\xt", b"le\\u00zzt"] {
        let text = ten(CONTACTS, "contacts").to_string();
        let at = text.match_indices("\"left\"").nth(4).unwrap().0;
        let payload = [&text.as_bytes()[..at], b"\"", name, b"\"", &text.as_bytes()[at + 6..]].concat();
        let (kept, refused) = received(&payload);
        assert_eq!((kept.len(), refused.len()), (9, 1), "{name:?}: {refused:?}");
        assert!(refused[0].to_string().starts_with("contacts[4].array: "), "{}", refused[0]);
    }
}

#[test]
fn regress_what_cbor_has_and_json_has_not_spoils_its_own_contact() {
    let whole = receive_contacts(ten(CONTACTS, "contacts").to_string().as_bytes(), Vec::new()).unwrap().message;
    let bytes = encode_cbor(&whole);
    let at = bytes.windows(6).enumerate().filter(|(_, name)| name == b"\x65ratio").nth(4).unwrap().0 + 6;
    for (value, shown) in [
        (&b"\xfb\x7f\xf8\0\0\0\0\0\0"[..], "NaN"),
        (b"\xf9\x7c\x00", "inf"),
        (b"\xf7", "undefined"),
        (b"\x42ab", "a byte string"),
        (b"\xc1\x01", "a tag"),
        (b"\x62\xff\xff", "a text that is not UTF-8"),
    ] {
        let payload = [&bytes[..at], value, &bytes[at + 9..]].concat();
        let expected = format!("contacts[4].ratio: \"{shown}\" was given, a number is required");
        assert_fifth_alone_refused(&payload, &expected);
    }
    let null = [&bytes[..at], b"\xf6", &bytes[at + 9..]].concat();
    assert_eq!(received(&null), ((0..10).collect(), Vec::new()), "a place may be null");
}

#[test]
fn regress_whole_numbers_may_have_decimals() {
    for (from, to) in [
        (r#""t_us":1795248000123456"#, r#""t_us":1795248000123456.0"#),
        (r#""seq":1812"#, r#""seq":1.812e3"#),
        (r#""whisker":0"#, r#""whisker":-0.0"#),
    ] {
        let text = CONTACTS.replacen(from, to, 1);
        assert_eq!(decode_contacts(text.as_bytes(), Vec::new()), decode_contacts(CONTACTS.as_bytes(), Vec::new()));
    }
    for wrong in ["1795248000123456.5", "-1.0", "1e300"] {
        let text = CONTACTS.replacen("1795248000123456", wrong, 1);
        assert_eq!(received(text.as_bytes()).1.len(), 1, "{wrong}");
    }
}

#[test]
fn a_wrong_frame_refuses_the_message() {
    for (from, to, expected) in [
        (r#""seq":1812"#, r#""seq":NaN"#, "the payload is not JSON"),
        (r#""seq":1812"#, r#""seq":-1"#, "seq: -1 was given, a whole number from 0 on is required"),
        (r#""boot_id":"b7","#, "", "boot_id"),
        (r#""seq":1812"#, r#""seq":1,"seq":2"#, "seq"),
    ] {
        let refusal = receive_contacts(CONTACTS.replacen(from, to, 1).as_bytes(), Vec::new()).unwrap_err().to_string();
        assert!(refusal.contains(expected), "{refusal}");
    }
}

fn topic(kind: RobotTopic) -> Topic {
    Topic::parse(&format!("whisker/v1/f/r/{}", kind.as_str())).unwrap()
}

/// The number of entries that a reader keeps, and of those that it refuses.
fn counts(kind: RobotTopic, message: &Value) -> Result<(usize, usize), Refusal> {
    let received = receive(&topic(kind), message.to_string().as_bytes())?;
    let kept = if let Message::Contacts(contacts) = &received.message {
        contacts.contacts.len()
    } else if let Message::Status(status) = &received.message {
        status.whiskers.len()
    } else {
        panic!("{:?}", received.message)
    };
    Ok((kept, received.refused.len()))
}

proptest! {
    /// Whatever one entry becomes, the others are kept; and it is refused exactly if a strict reader refuses the message.
    #[test]
    fn property_a_wrong_entry_does_not_affect_the_others(
        is_status in any::<bool>(),
        at in 0..COUNT,
        field in any::<prop::sample::Index>(),
        value in select(vec![
            json!(null), json!(true), json!("x"), json!("\u{0}"), json!(""), json!([]), json!({}), json!(-1), json!(0),
            json!(0.5), json!(2.0), json!(1e300), json!(70_000), json!("OK"), json!([1, 2]), json!({ "OK": null }),
        ]),
        is_whole_entry in prop::bool::weighted(0.1),
    ) {
        let (kind, text, list) = match is_status {
            true => (RobotTopic::Status, STATUS, "whiskers"),
            false => (RobotTopic::Contacts, CONTACTS, "contacts"),
        };
        let mut message = ten(text, list);
        let entry = &mut message[list][at];
        if is_whole_entry {
            *entry = value;
        } else {
            let fields: Vec<String> = entry.as_object().unwrap().keys().cloned().collect();
            entry[field.get(&fields).as_str()] = value;
        }
        let is_valid = decode(&topic(kind), message.to_string().as_bytes()).is_ok();
        let expected = if is_valid { (COUNT, 0) } else { (COUNT - 1, 1) };
        prop_assert_eq!(counts(kind, &message), Ok(expected), "{}", message);
    }
}
