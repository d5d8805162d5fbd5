use super::*;
use crate::document::Channel;
use crate::document::examples::{
    CONNECTION, CONTACTS, ESTIMATE, ESTIMATE_GAIN, FACTSHEET, FACTSHEET_GAIN, MAINTENANCE, RECEIPT, SETPOINT,
    SETPOINT_GAIN, SETPOINT_STATE, STATUS, STATUS_DROPPED,
};
use crate::{ContactPlace, Distance, Segmenter};

fn topic(last: &str) -> Topic {
    Topic::parse(&format!("whisker/v1/f/r/{last}")).unwrap()
}

fn refused(last: &str, payload: &str) -> Refusal {
    decode(&topic(last), payload.as_bytes()).unwrap_err()
}

/// Refusal of the golden message with one replacement.
fn refused_after(last: &str, golden: &str, from: &str, to: &str) -> Refusal {
    assert!(golden.contains(from), "{from} is not in the golden message");
    refused(last, &golden.replacen(from, to, 1))
}

fn assert_out_of_range(refusal: &Refusal, place: &str) {
    assert!(matches!(refusal, Refusal::OutOfRange { path, .. } if path == place), "{refusal}");
}

#[test]
fn golden_messages_of_the_contract_round_trip_byte_for_byte() {
    for channel in Channel::ALL {
        let address = channel.address().replace("{fleet}", "f").replace("{robot}", "r");
        let topic = Topic::parse(&address).unwrap();
        for (name, text) in channel.examples() {
            let message = decode(&topic, text.as_bytes()).unwrap();
            assert_eq!(String::from_utf8(encode(&message)).unwrap(), *text, "{address}: {name}");
        }
    }
}

#[test]
fn unknown_fields_are_ignored() {
    let text = CONTACTS.replace(r#""seq""#, r#""colour":{"a":[1]},"seq""#);
    assert!(decode(&topic("contacts"), text.as_bytes()).is_ok());
}

#[test]
fn dropped_contacts_are_optional_in_a_status() {
    let text = STATUS.replace(r#""whiskers""#, r#""contacts_dropped":3,"whiskers""#);
    let Message::Status(status) = decode(&topic("status"), text.as_bytes()).unwrap() else { panic!("no status") };
    assert_eq!(status.contacts_dropped, Some(3));
}

#[test]
fn what_is_not_json_is_refused() {
    for payload in ["", "{", "nonsense", &format!("{CONTACTS} more"), "{\"boot_id\":\"\u{1}\"}"] {
        assert_eq!(refused("contacts", payload).label(), "not_json", "{payload}");
    }
    assert_eq!(decode(&topic("contacts"), b"{\"boot_id\":\"\xff\"}").unwrap_err().label(), "not_json");
}

#[test]
fn regress_what_is_not_json_is_told_without_the_words_of_the_library() {
    for (payload, part) in
        [("", "send all of it"), ("{", "up to the }"), ("nonsense", "true, false and null"), ("{a:1}", "double quotes")]
    {
        let text = refused("contacts", payload).to_string();
        assert!(text.starts_with("the payload is not JSON: ") && text.contains(part), "{payload}: {text}");
        assert!(text.contains(" at line 1 column ") && !text.contains("EOF"), "{payload}: {text}");
    }
    let entry = refused_after("contacts", CONTACTS, "\"ratio\":", "\"ratio\":NaN,\"x\":").to_string();
    assert!(!entry.contains("expected value"), "{entry}");
}

#[test]
fn a_malformed_message_is_refused_with_the_place() {
    for (from, to, place) in [
        (r#""strain":0.009671,"#, "", "contacts[0]"),
        (r#""ratio":0.85"#, r#""ratio":"0.85""#, "contacts[0].ratio"),
        (r#""whisker":0"#, r#""whisker":65536"#, "contacts[0].whisker"),
        (r#""whisker":0"#, r#""whisker":-1"#, "contacts[0].whisker"),
        (r#""array":"left""#, r#""array":"le/ft""#, "contacts[0].array"),
        (r#""boot_id":"b7""#, r#""boot_id":"""#, "boot_id"),
        (r#""seq":1812"#, r#""seq":-1"#, "seq"),
    ] {
        let refusal = refused_after("contacts", CONTACTS, from, to);
        assert!(matches!(&refusal, Refusal::Malformed { path, .. } if path == place), "{refusal}");
        assert_eq!(refusal.label(), "malformed");
    }
    assert_eq!(refused_after("connection", CONNECTION, "ONLINE", "AWAY").label(), "malformed");
    assert_eq!(refused_after("connection", CONNECTION, "T08", " 08").label(), "malformed");
    assert_eq!(refused_after("factsheet", FACTSHEET, "crawler-2", "").label(), "malformed");
    assert_eq!(refused_after("estimate", ESTIMATE, "TRIMMED", "LONGER").label(), "malformed");
    assert_eq!(refused_after("estimate", ESTIMATE, "[0.45,", "[1.0,").label(), "malformed");
    assert_eq!(refused_after("estimate", ESTIMATE, r#""version":5,"#, "").label(), "malformed");
    assert_eq!(refused_after("maintenance", MAINTENANCE, "ERODING", "OLD").label(), "malformed");
    assert_eq!(refused_after("maintenance", MAINTENANCE, "T22:14", " 22:14").label(), "malformed");
}

#[test]
fn numbers_out_of_range_are_refused_with_the_place() {
    for (from, to, place) in [
        (r#""seq":1812"#, r#""seq":9007199254740992"#, "seq"),
        (r#""t_us":1795248000123456"#, r#""t_us":9007199254740992"#, "contacts[0].t_us"),
        ("0.85", "0", "contacts[0].ratio"),
        ("0.85", "1.001", "contacts[0].ratio"),
        ("0.85", "0.0099", "contacts[0].ratio"),
        ("0.85", "5e-324", "contacts[0].ratio"),
        ("2.4", "0", "contacts[0].deflection_mm"),
        ("2.4", "1000.5", "contacts[0].deflection_mm"),
        ("2.4", "0.0099", "contacts[0].deflection_mm"),
        ("2.4", "1e-9", "contacts[0].deflection_mm"),
        ("0.009671", "5e-324", "contacts[0].strain"),
        ("0.009671", "-9.9e-10", "contacts[0].strain"),
        ("0.009671", "-1.5", "contacts[0].strain"),
        ("0.1002", "-0.001", "contacts[0].pressure_mpa"),
        ("0.1002", "1.1", "contacts[0].pressure_mpa"),
        ("24.1", "1e6", "contacts[0].temperature_c"),
    ] {
        assert_out_of_range(&refused_after("contacts", CONTACTS, from, to), place);
    }
    for (angle, place) in [(r#""angle_deg":76"#, "angle_deg"), (r#""angle_deg":5,"angle_sd_deg":0"#, "angle_sd_deg")] {
        let refused = refused_after("contacts", CONTACTS, r#""strain""#, &format!(r#"{angle},"strain""#));
        assert_out_of_range(&refused, &format!("contacts[0].{place}"));
    }
    for (from, to, place) in
        [("70.0", "0", "factory_length_mm"), (":4.2", ":-0.1", "wear_mm"), ("5200.0", "1e10", "contacts_left")]
    {
        assert_out_of_range(&refused_after("maintenance", MAINTENANCE, from, to), &format!("whiskers[0].{place}"));
    }
    assert_out_of_range(&refused_after("factsheet", FACTSHEET, "65.0", "0"), "arrays[0].whiskers[1].length_mm");
    assert_out_of_range(&refused_after("factsheet", FACTSHEET, "65.0", "1e-300"), "arrays[0].whiskers[1].length_mm");
    let place = "arrays[0].whiskers[0].pressure_mpa";
    assert_out_of_range(&refused_after("factsheet", FACTSHEET, ":0.1,", ":0.3,"), place);
    for strain_max in ["0.0", "-0.01", "1.5"] {
        let refused = refused_after("factsheet", FACTSHEET_GAIN, "0.02", strain_max);
        assert_out_of_range(&refused, "arrays[0].whiskers[0].strain_max");
    }
    for tolerance_mm in ["-0.1", "20.5"] {
        let refused = refused_after("factsheet", FACTSHEET_GAIN, "0.3", tolerance_mm);
        assert_out_of_range(&refused, "arrays[0].whiskers[0].length_tolerance_mm");
    }
    assert_out_of_range(&refused_after("status", STATUS, "0.1002", "7"), "whiskers[0].pressure_mpa");
    assert_out_of_range(&refused_after("receipt", RECEIPT, "[1811,1813]", "[5,4]"), "held[0]");
    assert_out_of_range(&refused_after("setpoint", SETPOINT, "0.02", "0"), "slew_mpa_per_s");
    assert_out_of_range(&refused_after("setpoint", SETPOINT, "0.45", "0"), "gain[0].ratio");
    for (from, to, place) in [
        ("62.1,", "0,", "length_mm"),
        ("62.1,", "61.8,", "length_mm"),
        ("62.1,", "62.39,", "length_mm"),
        ("61.82", "-0.1", "length_low_mm"),
        ("62.38", "2001", "length_high_mm"),
        ("0.048", "1.1", "pressure_mpa"),
        ("0.45", "0", "gain[0].ratio"),
        ("1.02", "0", "gain[0].factor"),
    ] {
        assert_out_of_range(&refused_after("estimate", ESTIMATE, from, to), &format!("whiskers[0].{place}"));
    }
    assert_out_of_range(
        &refused_after("estimate", ESTIMATE, r#""version":5"#, r#""version":9007199254740992"#),
        "version",
    );
}

#[test]
fn numbers_at_the_limits_are_taken() {
    for (from, to) in [
        ("0.85", "0.01"),
        ("0.85", "1"),
        ("2.4", "0.01"),
        ("2.4", "1000"),
        ("0.009671", "0"),
        ("0.009671", "-0.0"),
        ("0.009671", "1e-9"),
        ("0.009671", "-1e-9"),
        ("0.009671", "-1"),
    ] {
        let text = CONTACTS.replace(from, to);
        assert!(decode(&topic("contacts"), text.as_bytes()).is_ok(), "{from} as {to}");
    }
}

#[test]
fn no_text_may_have_control_characters() {
    let free_texts = [
        ("factsheet", FACTSHEET, r#""model":""#),
        ("factsheet", FACTSHEET, r#""boot_id":""#),
        ("contacts", CONTACTS, r#""boot_id":""#),
        ("setpoint", SETPOINT, r#""command_id":""#),
        ("setpoint_state", SETPOINT_STATE, r#""command_id":""#),
    ];
    for (kind, text, field) in free_texts {
        let places: Vec<usize> = text.match_indices(field).map(|(at, _)| at + field.len()).collect();
        assert!(!places.is_empty(), "{kind} has {field}");
        for at in places {
            for control in [r"\u0000", r"\u001b", r"\u007f", r"\u0085", "\u{9b}"] {
                let spoilt = format!("{}{control}{}", &text[..at], &text[at..]);
                let refusal = decode(&topic(kind), spoilt.as_bytes()).expect_err(&spoilt);
                assert_eq!(refusal.label(), "malformed", "{kind} {field} {control}: {refusal}");
            }
        }
    }
}

#[test]
fn a_refusal_tells_what_where_and_what_is_allowed() {
    let refusal = refused_after("contacts", CONTACTS, "0.85", "1.2");
    assert_eq!(refusal.to_string(), "contacts[0].ratio is 1.2, but must be between 0.01 and 1");
    let refusal = refused_after("contacts", CONTACTS, "0.009671", "1e-12").to_string();
    assert!(
        refusal.starts_with("contacts[0].strain is 0.000000000001, but must be 0, or in magnitude between 1e-9 and 1"),
        "{refusal}"
    );
    let refusal = refused_after("contacts", CONTACTS, r#""strain":0.009671,"#, "");
    assert!(refusal.to_string().starts_with("contacts[0]: missing field `strain`"), "{refusal}");
}

#[test]
fn a_contact_states_one_place_or_none() {
    let place_of = |fields: &str| {
        let text = CONTACTS.replace(r#""ratio":0.85,"#, fields);
        match decode(&topic("contacts"), text.as_bytes()) {
            Ok(Message::Contacts(contacts)) => {
                // It is written as it was read.
                assert_eq!(encode(&contacts), text.as_bytes());
                Ok(contacts.contacts[0].place())
            }
            other => Err(other.unwrap_err().to_string()),
        }
    };
    let at = |mm, sd_mm| Distance { mm, sd_mm };
    assert_eq!(place_of(r#""ratio":0.85,"#), Ok(ContactPlace::Ratio { ratio: 0.85, sd: None }));
    assert_eq!(place_of(r#""ratio":0.85,"ratio_sd":0.02,"#), Ok(ContactPlace::Ratio { ratio: 0.85, sd: Some(0.02) }));
    assert_eq!(place_of(r#""distance_mm":51.5,"#), Ok(ContactPlace::Distance(at(51.5, None))));
    assert_eq!(
        place_of(r#""distance_mm":51.5,"distance_sd_mm":0.4,"#),
        Ok(ContactPlace::Distance(at(51.5, Some(0.4))))
    );
    assert_eq!(place_of(r#""tip":true,"#), Ok(ContactPlace::Tip(None)));
    assert_eq!(place_of(r#""distance_mm":64.5,"tip":true,"#), Ok(ContactPlace::Tip(Some(at(64.5, None)))));
    assert_eq!(place_of(""), Ok(ContactPlace::Unknown));
    for (fields, problem) in [
        (r#""ratio":0.85,"distance_mm":50.0,"#, "distance_mm: a contact has a ratio or a distance, not both"),
        (r#""ratio":0.85,"tip":true,"#, "tip: a contact at the tip has no ratio: it is 1"),
        (r#""ratio_sd":0.02,"#, "ratio_sd: a contact without ratio has no ratio_sd"),
        (r#""distance_sd_mm":0.5,"#, "distance_sd_mm: a contact without distance_mm has no distance_sd_mm"),
        (r#""distance_mm":0.0,"#, "distance_mm is 0, but must be between 0.1 and 1000 mm"),
        (r#""distance_mm":50.0,"distance_sd_mm":0,"#, "distance_sd_mm is 0, but must be above 0 and at most 100 mm"),
    ] {
        assert_eq!(place_of(fields), Err(format!("contacts[0].{problem}")));
    }
}

#[test]
fn a_payload_over_the_limit_is_refused_unread() {
    let payload = " ".repeat(PAYLOAD_MAX_BYTES + 1);
    assert_eq!(refused("contacts", &payload).label(), "too_large");
}

#[test]
fn too_long_a_batch_is_refused() {
    let start = CONTACTS.find("[{").unwrap();
    let one = &CONTACTS[start + 1..CONTACTS.len() - 2];
    let batch = |count| format!("{}[{}]}}", &CONTACTS[..start], vec![one; count].join(","));
    assert!(decode(&topic("contacts"), batch(1000).as_bytes()).is_ok());
    assert_eq!(refused("contacts", &batch(1001)).label(), "too_many");
}

#[test]
fn a_factsheet_with_the_same_whisker_or_array_twice_is_refused() {
    let refusal = refused_after("factsheet", FACTSHEET, r#""whisker":1"#, r#""whisker":0"#);
    assert!(
        matches!(&refusal, Refusal::Duplicate { path, .. } if path == "arrays[0].whiskers[1].whisker"),
        "{refusal}"
    );
    let array = FACTSHEET[FACTSHEET.find("[{").unwrap() + 1..].strip_suffix("]}").unwrap();
    let refusal = refused("factsheet", &FACTSHEET.replacen(array, &format!("{array},{array}"), 1));
    assert!(matches!(&refusal, Refusal::Duplicate { path, .. } if path == "arrays[1].array"), "{refusal}");
}

#[test]
fn a_neighbour_must_be_another_whisker_of_the_array() {
    for neighbour in ["[7]", "[0]"] {
        let refusal = refused_after("factsheet", FACTSHEET, "[1]", neighbour);
        assert!(
            matches!(&refusal, Refusal::WrongNeighbour { path, .. } if path == "arrays[0].whiskers[0].neighbours[0]"),
            "{refusal}"
        );
    }
}

#[test]
fn a_setpoints_pressure_is_left_to_the_robot_to_reject() {
    let text = SETPOINT.replace("0.048", "7.5");
    assert!(decode(&topic("setpoint"), text.as_bytes()).is_ok());
}

#[test]
fn the_points_of_a_response_are_checked() {
    let point = "[40.1,0.00601,0.0002]";
    for (to, place) in [
        ("[0.05,0.00601,0.0002]", "distance_mm"),
        ("[40.1,0.0,0.0002]", "strain_per_mm"),
        ("[40.1,11.0,0.0002]", "strain_per_mm"),
        ("[40.1,0.00601,0.0]", "sd_per_mm"),
    ] {
        let refusal = refused_after("estimate", ESTIMATE_GAIN, point, to);
        assert_out_of_range(&refusal, &format!("whiskers[0].response[1].{place}"));
    }
    // Neither a distance that does not rise nor a strain that does not fall.
    for to in ["[15.2,0.00601,0.0002]", "[40.1,0.00894,0.0002]", "[40.1,0.00601]"] {
        assert_eq!(refused_after("estimate", ESTIMATE_GAIN, point, to).label(), "malformed", "{to}");
    }
    let many: Vec<String> = (0..16).map(|at| format!("[{}.0,0.0{},0.0001]", 20 + at, 80 - at)).collect();
    let refusal = refused_after("estimate", ESTIMATE_GAIN, point, &format!("{point},{}", many.join(",")));
    assert!(matches!(&refusal, Refusal::TooMany { most: 16, .. }), "{refusal}");
}

#[test]
fn a_status_may_state_the_segmenter() {
    for (text, segmenter) in [(STATUS_DROPPED, Some(Segmenter::Noisy)), (STATUS, None)] {
        let Message::Status(status) = decode(&topic("status"), text.as_bytes()).unwrap() else { panic!("no status") };
        assert_eq!(status.whiskers[0].segmenter, segmenter);
    }
}

#[test]
fn the_ratios_of_a_gain_must_rise() {
    assert_eq!(refused_after("setpoint", SETPOINT, "0.7", "0.4").label(), "malformed");
}

#[test]
fn a_rejection_must_say_why() {
    assert_eq!(refused_after("setpoint_state", SETPOINT_STATE, "APPLIED", "REJECTED").label(), "malformed");
    let text = SETPOINT_STATE.replace("APPLIED\"", "REJECTED\",\"error\":\"STALE\"");
    assert!(decode(&topic("setpoint_state"), text.as_bytes()).is_ok());
}

#[test]
fn every_label_is_listed() {
    let samples =
        [refused("contacts", "{"), refused_after("contacts", CONTACTS, "0.85", "2"), Topic::parse("x").unwrap_err()];
    assert!(samples.iter().all(|refusal| Refusal::LABELS.contains(&refusal.label())));
}

#[test]
fn the_envelope_of_a_refused_message_can_still_be_read() {
    let expected = Some(Envelope { boot_id: BootId::new("b7").unwrap(), seq: 1812 });
    assert_eq!(envelope(CONTACTS.replace("0.85", "2").as_bytes()), expected);
    assert_eq!(envelope(br#"{"x":[{}],"seq":1812,"boot_id":"b7","contacts": broken"#), expected);
    for none in ["", "[]", r#"{"boot_id":"b7"}"#, r#"{"seq":1}"#, r#"{"seq":1.5,"boot_id":"b"}"#] {
        assert_eq!(envelope(none.as_bytes()), None, "{none}");
    }
}

#[test]
fn a_refusal_does_not_repeat_a_long_field() {
    let refusal = refused_after("connection", CONNECTION, "ONLINE", &"x".repeat(100_000)).to_string();
    assert!(refusal.len() < 500 && refusal.contains("is not allowed") && refusal.contains("column"), "{refusal}");
}

#[test]
fn a_number_keeps_its_last_digit() {
    let text = CONTACTS.replace("0.85", "0.21263524826581306");
    let message = decode(&topic("contacts"), text.as_bytes()).unwrap();
    assert_eq!(String::from_utf8(encode(&message)).unwrap(), text);
}

#[test]
fn fields_may_come_in_any_order_and_names_with_escapes() {
    let golden = decode(&topic("contacts"), CONTACTS.as_bytes());
    let text = CONTACTS
        .replace(r#""boot_id":"b7","seq":1812,"#, "")
        .replace("}]}", r#"}],"seq":1812,"boot_id":"\u0062\u0037"}"#);
    assert_eq!(decode(&topic("contacts"), text.as_bytes()), golden);
    let text = CONTACTS.replace(r#""whisker":0,"#, "").replace("}]}", r#","whisker":0}]}"#);
    assert_eq!(decode(&topic("contacts"), text.as_bytes()), golden);
}

#[test]
fn a_list_of_contacts_is_used_again() {
    let first = decode_contacts(CONTACTS.as_bytes(), Vec::new()).unwrap();
    assert_eq!(decode_contacts(CONTACTS.as_bytes(), first.contacts.clone()), Ok(first));
    assert_eq!(decode_contacts(b"{", Vec::new()).unwrap_err(), refused("contacts", "{"));
}

#[test]
fn a_robot_applies_gains_only_if_its_factsheet_says_so() {
    for (text, applies) in [(FACTSHEET.to_owned(), false), (FACTSHEET_GAIN.to_owned(), true)] {
        let Message::Factsheet(sheet) = decode(&topic("factsheet"), text.as_bytes()).unwrap() else { panic!() };
        assert_eq!(sheet.applies_gain, applies, "{text}");
    }
    for wrong in ["1", "null", r#""yes""#] {
        let refusal = refused_after("factsheet", FACTSHEET_GAIN, "true", wrong);
        assert!(matches!(&refusal, Refusal::Malformed { path, .. } if path == "applies_gain"), "{refusal}");
    }
}

#[test]
fn a_reading_gain_outside_its_range_or_no_number_is_refused_by_its_name() {
    for (kind, text, place) in
        [("setpoint", SETPOINT_GAIN, "reading_gain"), ("estimate", ESTIMATE_GAIN, "whiskers[0].reading_gain")]
    {
        for bad in ["0", "0.0499", "20.01", "-1", "1e300"] {
            assert_out_of_range(&refused_after(kind, text, "0.887", bad), place);
        }
        for bad in [r#""0.887""#, "[0.887]", "true", "{}"] {
            let refusal = refused_after(kind, text, "0.887", bad);
            assert!(matches!(&refusal, Refusal::Malformed { path, .. } if path == place), "{refusal}");
        }
        for bad in ["NaN", "Infinity", "1e999"] {
            assert_eq!(refused_after(kind, text, "0.887", bad).label(), "not_json", "{bad}");
        }
        for good in ["0.05", "20", "1", "null"] {
            let text = text.replacen("0.887", good, 1);
            assert!(decode(&topic(kind), text.as_bytes()).is_ok(), "{text}");
        }
    }
    let Message::Setpoint(setpoint) = decode(&topic("setpoint"), SETPOINT.as_bytes()).unwrap() else { panic!() };
    assert_eq!(setpoint.reading_gain, None);
}
