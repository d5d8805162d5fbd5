use proptest::prelude::*;

use super::*;
use crate::document::examples::CONTACTS;
use crate::encode;

fn plain(text: &str) -> Option<Contacts> {
    contacts(text, &mut Vec::new())
}

/// Whether the fast reader accepts a message; if so, the full reader must give the same values to the last bit.
fn is_plain_and_the_same(text: &str) -> bool {
    let Some(plain) = plain(text) else { return false };
    let full: Contacts = serde_json::from_str(text).unwrap_or_else(|problem| panic!("{problem}: {text}"));
    assert_eq!(plain, full, "{text}");
    let bits = |message: &Contacts| -> Vec<u64> {
        let of =
            |one: &Contact| [one.ratio.unwrap(), one.deflection_mm, one.strain, one.pressure_mpa, one.temperature_c];
        message.contacts.iter().flat_map(of).map(f64::to_bits).collect()
    };
    assert_eq!(bits(&plain), bits(&full), "{text}");
    true
}

#[test]
fn golden_messages_are_plain_with_and_without_white_space() {
    assert!(is_plain_and_the_same(CONTACTS));
    let spaced = CONTACTS.replace(':', ": ").replace(',', ", \n").replace('{', "{\t").replace('}', "\r }");
    assert!(is_plain_and_the_same(&format!("  {spaced}  ")));
    assert!(is_plain_and_the_same(r#"{"boot_id":"b","seq":0,"contacts":[ ]}"#));
}

#[test]
fn what_is_not_plain_is_left_to_the_full_reader() {
    for (from, to) in [
        (r#""left""#, r#""l\u0065ft""#),
        (r#""seq""#, r#""colour":1,"seq""#),
        (r#""ratio":0.85,"#, ""),
        (r#""ratio":0.85,"#, r#""ratio":0.85,"ratio":0.85,"#),
        (r#""whisker":0,"t_us":1795248000123456,"#, r#""t_us":1795248000123456,"whisker":0,"#),
        (r#""whisker":0"#, r#""whisker":65536"#),
        (r#""whisker":0"#, r#""whisker":-0"#),
        (r#""seq":1812"#, r#""seq":1812.0"#),
        (r#""seq":1812"#, r#""seq":01812"#),
        (r#""seq":1812"#, r#""seq":18446744073709551616"#),
        (r#""b7""#, r#""b7"#),
        ("]}", "]}}"),
        ("]}", "],}"),
        ("}]", "},]"),
        ("}]", "}{}]"),
    ] {
        assert!(CONTACTS.contains(from), "{from}");
        assert_eq!(plain(&CONTACTS.replacen(from, to, 1)), None, "{to}");
    }
}

#[test]
fn numbers_are_read_as_json_has_them() {
    for number in ["0", "-0", "7", "-7.25", "1e5", "1E-5", "2.5e+3", "0.1", "5e-324", "1.7976931348623157e308"] {
        assert!(is_plain_and_the_same(&CONTACTS.replace("0.85", number)), "{number}");
    }
    // Halfway between two floating-point numbers, or nearly so.
    for number in ["9007199254740993", "0.5000000000000001665334536937734810635447502136230468750001", "1e23"] {
        assert!(is_plain_and_the_same(&CONTACTS.replace("0.85", number)), "{number}");
    }
    for none in
        ["", "-", "01", "-01", "1.", ".5", "+1", "1e", "1e+", "1e400", "-1e400", "NaN", "inf", "0x1", "1_0", "1 0"]
    {
        assert_eq!(plain(&CONTACTS.replace("0.85", none)), None, "{none}");
    }
}

#[test]
fn a_list_is_used_again_and_holds_nothing_of_before() {
    let mut list = plain(CONTACTS).unwrap().contacts;
    list.extend_from_within(..);
    let capacity = list.capacity();
    let message = contacts(CONTACTS, &mut list).unwrap();
    assert_eq!((message.contacts.len(), message.contacts.capacity()), (1, capacity));
    assert!(list.is_empty());
}

fn any_contact() -> impl Strategy<Value = Contact> {
    let number =
        prop_oneof![any::<f64>().prop_filter("JSON has only finite ones", |number| number.is_finite()), 0.0..1.0];
    ("[A-Za-z0-9_-]{1,64}", any::<u16>(), any::<u64>(), prop::collection::vec(number, 5)).prop_map(
        |(array, whisker, t_us, numbers)| Contact {
            array: Name::new(&array).unwrap(),
            whisker,
            t_us,
            ratio: Some(numbers[0]),
            ratio_sd: None,
            distance_mm: None,
            distance_sd_mm: None,
            tip: false,
            deflection_mm: numbers[1],
            strain: numbers[2],
            saturated: false,
            pressure_mpa: numbers[3],
            temperature_c: numbers[4],
            angle_deg: None,
            angle_sd_deg: None,
            test_id: None,
        },
    )
}

fn any_message() -> impl Strategy<Value = Contacts> {
    ("[^\\x00-\\x1f\\x7f-\\x9f]{1,64}", 0..10_u64.pow(18), prop::collection::vec(any_contact(), 0..5)).prop_map(
        |(boot_id, seq, contacts)| Contacts {
            boot_id: BootId::new(&boot_id).unwrap(),
            seq,
            contacts,
            missed: Vec::new(),
        },
    )
}

proptest! {
    #[test]
    fn property_what_robots_write_is_read_as_the_full_reader_does(message in any_message()) {
        let text = String::from_utf8(encode(&message)).unwrap();
        let needs_more = text.contains('\\') || message.contacts.iter().any(|one| one.t_us >= 10_u64.pow(18));
        prop_assert_eq!(is_plain_and_the_same(&text), !needs_more);
    }

    /// After any corruption of a message, the fast reader accepts nothing that the full reader refuses, and gives
    /// equal values.
    #[test]
    fn property_nothing_else_is_taken(
        message in any_message(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), "[-+.eE0-9{}\\[\\]:,\" \\\\a-z\u{e9}]{0,3}", 0..3_usize), 1..4),
    ) {
        let mut text: Vec<char> = String::from_utf8(encode(&message)).unwrap().chars().collect();
        for (at, new, removed) in changes {
            let at = at.index(text.len());
            text.splice(at..(at + removed).min(text.len()), new.chars());
            text.push(' ');
        }
        is_plain_and_the_same(&text.into_iter().collect::<String>());
    }
}
