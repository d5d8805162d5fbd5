//! Arbitrary payloads on each topic of the contract.

use std::sync::LazyLock;

use proptest::prelude::*;
use serde_json::{Value, json};
use vibrissa_protocol::{Topic, decode, encode, envelope};

use crate::mutation::{anything, bent_message, mutations};
use crate::{Input, cases, in_time};

/// A valid message of each kind with its topic. Mutations make long lists by repetition.
static GOOD: LazyLock<Vec<(Topic, Value)>> = LazyLock::new(|| {
    let whisker = |number: u16, neighbour: u16| {
        json!({"whisker": number, "x_mm": 0.0, "y_mm": 25.0, "model": "nguyen-2021", "length_mm": 70.0,
            "pressure_mpa": 0.1, "pressure_max_mpa": 0.2, "neighbours": [neighbour]})
    };
    let command = "0198c5d2-6c1e-7d3b-9a55-3f0f5a1f2c11";
    let messages = [
        ("r/connection", json!({"timestamp": "2026-11-21T08:00:00.000Z", "state": "ONLINE"})),
        (
            "r/factsheet",
            json!({"timestamp": "2026-11-21T08:00:00.000Z", "model": "crawler-2", "on_supervisor_loss": "HOLD", "arrays":
                [{"array": "left", "type": "TYPE_1", "whiskers": [whisker(0, 1), whisker(1, 0)]}]}),
        ),
        (
            "r/contacts",
            json!({"contacts": [{"array": "left", "whisker": 0, "t_us": 1_795_248_000_123_456_u64, "ratio": 0.85,
                "deflection_mm": 2.4, "strain": 0.009_671, "pressure_mpa": 0.1002, "temperature_c": 24.1}]}),
        ),
        (
            "r/status",
            json!({"t_us": 1_795_248_000_123_456_u64, "contacts_dropped": 3, "whiskers": [{"array": "left", "whisker": 0,
                "pressure_mpa": 0.1002, "setpoint_mpa": 0.1, "regulator": "OK", "gauge": "OK"}]}),
        ),
        ("r/receipt", json!({"robot_boot_id": "b7", "next": 1810, "held": [[1811, 1813], [1815, 1816]]})),
        (
            "r/setpoint",
            json!({"command_id": command, "epoch": 12, "version": 57, "robot_boot_id": "b7", "array": "left",
                "whisker": 0, "pressure_mpa": 0.048, "slew_mpa_per_s": 0.02, "issued": "2026-11-21T08:00:01.000Z",
                "expires_us": 1_795_248_031_000_000_u64, "reason": "SELF_COMPENSATION",
                "gain": [[0.45, 0.861], [0.7, 0.953], [1.0, 1.0]], "reading_gain": 0.887}),
        ),
        (
            "r/setpoint_state",
            json!({"command_id": command, "state": "FAILED", "error": "LEAK", "t_us": 1_795_248_002_123_456_u64,
                "pressure_mpa": 0.0481}),
        ),
        ("r/request", json!({"request": "FACTSHEET"})),
        (
            "r/request",
            json!({"request": "TOUCH_TEST", "touch_test": {"test_id": command, "epoch": 12, "version": 58,
                "robot_boot_id": "b7", "array": "left", "whisker": 0, "kind": "WALL", "distances_mm": [58.5, 62.25],
                "deflections_mm": [1.5, 2.5], "contacts": 8, "issued": "2026-11-21T08:00:01.000Z",
                "expires_us": 1_795_248_031_000_000_u64, "reason": "SUSPICION"}}),
        ),
        (
            "r/test_state",
            json!({"test_id": command, "state": "REJECTED", "error": "NOT_READY", "t_us": 1_795_248_002_123_456_u64}),
        ),
        ("supervisor/state", json!({"state": "ONLINE", "epoch": 12})),
    ];
    let whole = messages.into_iter().map(|(topic, mut message)| {
        message["boot_id"] = json!("b7");
        message["seq"] = json!(1812);
        (Topic::parse(&format!("whisker/v1/f/{topic}")).unwrap(), message)
    });
    whole.collect()
});

/// An index into the list above, and a payload.
fn payloads() -> impl Strategy<Value = (usize, Input)> {
    let kinds = || 0..GOOD.len();
    prop_oneof![
        4 => (kinds(), mutations()).prop_map(|(kind, bends)| (kind, Input(bent_message(&GOOD[kind].1, &bends)))),
        1 => (kinds(), kinds(), mutations())
            .prop_map(|(kind, other, bends)| (kind, Input(bent_message(&GOOD[other].1, &bends)))),
        1 => (kinds(), anything()).prop_map(|(kind, bytes)| (kind, Input(bytes))),
    ]
}

/// Numbers like measured ones, with all digits of a float.
fn numbers() -> impl Strategy<Value = (f64, f64)> {
    let strain = (-9.0..0.0_f64, any::<bool>()).prop_map(|(power, is_negative)| {
        10_f64.powf(power).clamp(1e-9, 1.0).copysign(if is_negative { -1.0 } else { 1.0 })
    });
    (0.01..1.0_f64, strain)
}

#[test]
fn what_is_bent_is_good_before() {
    for (topic, good) in GOOD.iter() {
        let message = decode(topic, &bent_message(good, &[])).unwrap();
        assert_eq!(serde_json::to_value(&message).unwrap(), *good);
    }
}

proptest! {
    #![proptest_config(cases(10_000))]

    #[test]
    fn a_payload_is_taken_and_kept_or_refused_briefly((kind, input) in payloads()) {
        let (topic, _) = &GOOD[kind];
        in_time(|| envelope(&input.0));
        match in_time(|| decode(topic, &input.0)) {
            Ok(message) => {
                let written = in_time(|| encode(&message));
                let again = decode(topic, &written);
                let again = again.map_err(|refusal| TestCaseError::fail(format!("wrote a message that it refuses: {refusal}")))?;
                // Timestamps are written with milliseconds, so finer digits are lost once.
                prop_assert_eq!(Input(encode(&again)), Input(written));
            }
            Err(refusal) => prop_assert!(refusal.to_string().len() < 5000, "{} bytes", refusal.to_string().len()),
        }
    }

    #[test]
    fn a_measured_number_comes_back_as_it_was((ratio, strain) in numbers()) {
        let (topic, good) = &GOOD[2];
        let mut message = good.clone();
        message["contacts"][0]["ratio"] = json!(ratio);
        message["contacts"][0]["strain"] = json!(strain);
        let decoded = decode(topic, message.to_string().as_bytes()).unwrap();
        prop_assert_eq!(serde_json::to_value(&decoded).unwrap(), message);
    }
}
