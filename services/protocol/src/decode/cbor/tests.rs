use proptest::prelude::*;
use serde_json::Value;

use super::*;
use crate::document::examples::{CONTACTS, CONTACTS_TOUCH_TEST};
use crate::{MissedTouch, Refusal, Topic, decode, decode_contacts, encode, encode_cbor, envelope};

/// Any JSON value in CBOR, with shortest integers as encoders write them.
fn cbor_of(value: &Value) -> Vec<u8> {
    let head = |major: u8, count: u64| {
        let kind = major << 5;
        match count {
            0..24 => vec![kind | count as u8],
            24..256 => vec![kind | 24, count as u8],
            256..65_536 => [&[kind | 25][..], &(count as u16).to_be_bytes()].concat(),
            65_536..4_294_967_296 => [&[kind | 26][..], &(count as u32).to_be_bytes()].concat(),
            _ => [&[kind | 27][..], &count.to_be_bytes()].concat(),
        }
    };
    match value {
        Value::Null => vec![0xf6],
        Value::Bool(truth) => vec![if *truth { 0xf5 } else { 0xf4 }],
        Value::Number(number) => match (number.as_u64(), number.as_i64()) {
            (Some(number), _) => head(0, number),
            (None, Some(number)) => head(1, (-1 - number) as u64),
            (None, None) => [&[0xfb][..], &number.as_f64().unwrap().to_be_bytes()].concat(),
        },
        Value::String(text) => [head(3, text.len() as u64), text.clone().into_bytes()].concat(),
        Value::Array(list) => list.iter().fold(head(4, list.len() as u64), |mut out, one| {
            out.extend(cbor_of(one));
            out
        }),
        Value::Object(map) => map.iter().fold(head(5, map.len() as u64), |mut out, (name, one)| {
            out.extend(cbor_of(&Value::String(name.clone())));
            out.extend(cbor_of(one));
            out
        }),
    }
}

fn golden() -> Value {
    serde_json::from_str(CONTACTS).unwrap()
}

fn refused(payload: &[u8]) -> Refusal {
    decode_contacts(payload, Vec::new()).unwrap_err()
}

#[test]
fn golden_bytes_of_a_message() {
    let message: Contacts = serde_json::from_str(r#"{"boot_id":"b7","seq":1812,"contacts":[]}"#).unwrap();
    let bytes = b"\xa3\x67boot_id\x62b7\x63seq\x19\x07\x14\x68contacts\x80";
    assert_eq!(encode_cbor(&message), bytes);
    assert_eq!(decode_contacts(bytes, Vec::new()), Ok(message));
}

#[test]
fn golden_messages_are_the_same_in_both_encodings() {
    for text in [CONTACTS, CONTACTS_TOUCH_TEST] {
        let message = decode_contacts(text.as_bytes(), Vec::new()).unwrap();
        assert_eq!(decode_contacts(&encode_cbor(&message), Vec::new()), Ok(message));
    }
    let message = decode_contacts(CONTACTS.as_bytes(), Vec::new()).unwrap();
    assert_eq!(contacts(&encode_cbor(&message), &mut Vec::new()), Some(message), "the fast reader takes it");
}

#[test]
fn numbers_may_be_shorter_or_whole_and_lists_of_unknown_length() {
    let with = |ratio: &[u8]| {
        let mut bytes = cbor_of(&golden());
        let at = bytes.windows(6).position(|name| name == b"\x65ratio").unwrap() + 6;
        bytes.splice(at..at + 9, ratio.iter().copied());
        decode_contacts(&bytes, Vec::new()).map(|message| message.contacts[0].ratio.unwrap())
    };
    assert_eq!(with(b"\xf9\x38\x00"), Ok(0.5));
    assert_eq!(with(b"\xf9\x00\x01").unwrap_err().label(), "out_of_range");
    assert_eq!(with(b"\xfa\x3f\x00\x00\x00"), Ok(0.5));
    assert_eq!(with(b"\x01"), Ok(1.0));
    assert_eq!(with(b"\x20").unwrap_err().to_string(), "contacts[0].ratio is -1, but must be between 0.01 and 1");
    for not_a_number in [&b"\xf9\x7e\x00"[..], b"\xfa\x7f\x80\x00\x00", b"\xfb\x7f\xf0\x00\x00\x00\x00\x00\x00"] {
        assert_eq!(with(not_a_number).unwrap_err().label(), "malformed", "only its contact is refused");
    }
    // Map and list end with a byte of their own, and a text comes in two pieces.
    let bytes = b"\xbf\x67boot_id\x7f\x61b\x617\xff\x63seq\x01\x68contacts\x9f\xff\xff";
    assert_eq!(decode_contacts(bytes, Vec::new()).unwrap().boot_id.as_str(), "b7");
}

#[test]
fn halves_have_the_values_of_the_standard() {
    for (bits, value) in [
        (0x0000, 0.0),
        (0x3c00, 1.0),
        (0x3e00, 1.5),
        (0x7bff, 65504.0),
        (0x0001, 5.960_464_477_539_063e-8),
        (0x0400, 0.000_061_035_156_25),
        (0xc400, -4.0),
    ] {
        assert_eq!(input::of_half(bits), value, "{bits:x}");
    }
    assert!(input::of_half(0x7c00).is_infinite() && input::of_half(0x7e00).is_nan());
}

#[test]
fn errors_are_those_of_json_with_the_same_places() {
    type Change = fn(&mut Value);
    let changes: [(&str, Change); 6] = [
        ("contacts[0]: missing field `strain`: add it", |one| {
            drop(one["contacts"][0].as_object_mut().unwrap().remove("strain"))
        }),
        ("contacts[0].whisker: 65536 was given, a whole number from 0 to 65535 is required", |one| {
            one["contacts"][0]["whisker"] = 65536.into()
        }),
        ("contacts[0].ratio is 1.2, but must be between 0.01 and 1", |one| one["contacts"][0]["ratio"] = 1.2.into()),
        ("contacts[0].ratio: \"x\" was given, a number is required", |one| one["contacts"][0]["ratio"] = "x".into()),
        ("seq is 9007199254740992, but must be an integer from 0 and below 2^53", |one| {
            one["seq"] = (1_u64 << 53).into()
        }),
        ("contacts has 1001 entries, but must have at most 1000", |one| {
            let first = one["contacts"][0].clone();
            one["contacts"] = Value::Array(vec![first; 1001]);
        }),
    ];
    for (problem, change) in changes {
        let mut message = golden();
        change(&mut message);
        let refusal = refused(&cbor_of(&message)).to_string();
        assert_eq!(refusal, problem);
        let of_json = refused(message.to_string().as_bytes()).to_string();
        assert!(of_json.starts_with(problem), "{of_json}");
    }
}

#[test]
fn what_json_does_not_have_is_refused_with_its_position() {
    for (bytes, problem) in [
        (&b"\xa1\x63seq"[..], "the message ends early, or a value is not well-formed, at byte 5"),
        (b"\xa1\x63seq\x41\x00", "a byte string, but JSON has no such value, at byte 5"),
        (b"\xa1\x63seq\xc1\x01", "a tag, but the contract has none, at byte 5"),
        (b"\xa1\x63seq\xf7", "a value that JSON does not have, at byte 5"),
        (b"\xa1\x01\x01", "the name of a field must be a text, at byte 1"),
        (b"\xa1\x62\xff\xff\x01", "the name of a field must be a text, at byte 1"),
        (b"\xa0\x00", "unexpected bytes after the message, at byte 1"),
    ] {
        assert_eq!(refused(bytes).to_string(), format!("the payload is not CBOR of the contract: {problem}"));
    }
    let deep = [[0xa1, 0x61, b'x'].repeat(80_000), vec![0xa0]].concat();
    assert!(refused(&deep).to_string().contains("nested too deeply"));
}

#[test]
fn only_contacts_may_be_in_cbor() {
    let status = Topic::parse("whisker/v1/f/r/status").unwrap();
    let refusal = decode(&status, &cbor_of(&golden())).unwrap_err();
    assert_eq!(refusal.to_string(), "the payload is not JSON: it begins like CBOR, which is for `contacts` only");
}

#[test]
fn the_envelope_of_a_refused_message_can_still_be_read() {
    let whole = cbor_of(&golden());
    let expected = envelope(CONTACTS.as_bytes());
    assert!(expected.is_some());
    assert_eq!(envelope(&encode_cbor(&decode_contacts(&whole, Vec::new()).unwrap())), expected);
    // Broken after the two fields.
    let broken = b"\xa3\x67boot_id\x62b7\x63seq\x19\x07\x14\x68contacts\xff";
    assert_eq!(envelope(broken), expected);
    assert_eq!(envelope(b"\xa1\x63seq"), None);
}

fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![
        any::<f64>().prop_filter("finite", |number| number.is_finite()),
        0.0..1.0,
        (0..100_i32).prop_map(f64::from)
    ]
}

fn any_contact() -> impl Strategy<Value = Contact> {
    let some = || prop::option::of(any_number());
    let text = "[A-Za-z0-9_-]{1,64}";
    (
        text,
        any::<u16>(),
        any::<u64>(),
        (some(), some(), some(), some()),
        (some(), some()),
        any::<(bool, bool)>(),
        prop::option::of(".{0,20}"),
        prop::collection::vec(any_number(), 4),
    )
        .prop_map(
            |(
                array,
                whisker,
                t_us,
                (ratio, ratio_sd, distance_mm, distance_sd_mm),
                (angle_deg, angle_sd_deg),
                (tip, saturated),
                test_id,
                numbers,
            )| Contact {
                array: Name::new(&array).unwrap(),
                whisker,
                t_us,
                ratio,
                ratio_sd,
                distance_mm,
                distance_sd_mm,
                tip,
                deflection_mm: numbers[0],
                strain: numbers[1],
                saturated,
                pressure_mpa: numbers[2],
                temperature_c: numbers[3],
                angle_deg,
                angle_sd_deg,
                test_id,
            },
        )
}

fn any_missed() -> impl Strategy<Value = MissedTouch> {
    (
        "[a-z]{1,9}",
        any::<u16>(),
        any::<u64>(),
        any_number(),
        prop::option::of(any_number()),
        prop::option::of(".{0,20}"),
    )
        .prop_map(|(array, whisker, t_us, distance_mm, distance_sd_mm, test_id)| MissedTouch {
            array: Name::new(&array).unwrap(),
            whisker,
            t_us,
            distance_mm,
            distance_sd_mm,
            test_id,
        })
}

fn any_message() -> impl Strategy<Value = Contacts> {
    let missed = prop_oneof![3 => Just(Vec::new()), 1 => prop::collection::vec(any_missed(), 1..3)];
    ("[^\\x00-\\x1f\\x7f-\\x9f]{1,64}", any::<u64>(), prop::collection::vec(any_contact(), 0..5), missed).prop_map(
        |(boot_id, seq, contacts, missed)| Contacts { boot_id: BootId::new(&boot_id).unwrap(), seq, contacts, missed },
    )
}

/// The outcome of a message, with the bits of its numbers; refusals without the position in a text.
fn outcome(payload: &[u8]) -> Result<String, String> {
    match decode_contacts(payload, Vec::new()) {
        Ok(message) => Ok(format!("{message:?}")),
        Err(refusal) => Err(refusal.without_position().to_string()),
    }
}

proptest! {
    /// A message of any values, in range or not, has the same outcome in both encodings, and JSON written from CBOR is the
    /// same message.
    #[test]
    fn property_both_encodings_are_the_same_message(message in any_message()) {
        let (text, bytes) = (encode(&message), encode_cbor(&message));
        prop_assert_eq!(outcome(&bytes), outcome(&text));
        prop_assert_eq!(String::from_utf8(json::of(&bytes).unwrap()).unwrap(), String::from_utf8(text.clone()).unwrap());
        // As other encoders write it: other order of the fields, whole numbers as integers.
        let value: Value = serde_json::from_slice(&text).unwrap();
        prop_assert_eq!(outcome(&cbor_of(&value)), outcome(value.to_string().as_bytes()));
    }

    /// The fast reader takes nothing that the full one refuses, and reads the same values.
    #[test]
    fn property_the_fast_reader_agrees_with_the_full_one(
        message in any_message(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..3),
    ) {
        let mut bytes = encode_cbor(&message);
        for (at, byte) in changes {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        if let Some(fast) = contacts(&bytes, &mut Vec::new()) {
            let text = json::of(&bytes).map_err(TestCaseError::fail)?;
            let full: Contacts = serde_json::from_slice(&text).map_err(|problem| TestCaseError::fail(problem.to_string()))?;
            prop_assert_eq!(format!("{fast:?}"), format!("{full:?}"));
        }
    }

    /// Any bytes have an outcome, and a short error.
    #[test]
    fn property_any_bytes_are_taken_or_refused_briefly(first in 0xa0..=0xbf_u8, rest in prop::collection::vec(any::<u8>(), 0..200)) {
        let bytes = [vec![first], rest].concat();
        let _ = envelope(&bytes);
        if let Err(refusal) = outcome(&bytes) {
            prop_assert!(refusal.len() < 1000, "{}", refusal);
        }
    }
}
