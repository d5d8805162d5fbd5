//! The files for ROS users have the fields of the messages, in their order: CDR has no names.

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::{contact, header};
use crate::messages::{Estimate, Fault, Strain, TouchTestFeedback, TouchTestGoal, TouchTestResult};

/// Types and names of the fields in a definition.
fn fields(definition: &str) -> Vec<(&str, &str)> {
    let without_comments = definition.lines().map(|line| line.split('#').next().unwrap_or_default().trim());
    without_comments.filter(|line| !line.contains('=')).filter_map(|line| line.split_once(' ')).collect()
}

/// Compares a definition with a message that has 1 in each number, a text in each text, and one element in each list.
fn check<M: Serialize + DeserializeOwned + std::fmt::Debug>(definition: &str, message: &M) {
    let value = serde_json::to_value(message).expect("JSON");
    let text = format!("{message:?}");
    let fields = fields(definition);
    assert_eq!(value.as_object().expect("an object").len(), fields.len(), "{definition}");
    let at: Vec<_> = fields.iter().map(|(_, name)| text.find(&format!("{name}: "))).collect();
    assert!(at.iter().all(Option::is_some) && at.is_sorted(), "{text}: {at:?}");
    for (kind, name) in fields {
        let field = &value[name];
        let has_kind = match kind {
            "std_msgs/Header" => field["stamp"].is_object(),
            "string" => field.is_string(),
            "float64" => field.is_f64(),
            "float64[]" => field[0].is_f64(),
            "bool" => field.is_boolean(),
            "Contact[]" => field[0]["deflection_m"].is_f64(),
            // The widths of integers: the greatest value fits, and the next one does not.
            "uint8" | "uint16" | "uint32" => {
                let bits: u32 = kind[4..].parse().expect("a width");
                let takes = |number: u64| {
                    let mut changed = value.clone();
                    changed[name] = number.into();
                    serde_json::from_value::<M>(changed).is_ok()
                };
                takes((1 << bits) - 1) && !takes(1 << bits)
            }
            other => panic!("the type {other}"),
        };
        assert!(has_kind, "{kind} {name}: {field}");
    }
}

#[test]
fn the_definitions_for_ros_users_have_the_same_fields_in_the_same_order() {
    let text = || "x".to_owned();
    check(include_str!("../../vibrissa_msgs/msg/Contact.msg"), &contact());
    let strain = Strain {
        header: header(),
        strain: vec![1.0],
        strain_2: vec![1.0],
        every_us: 1,
        deflection_m: vec![1.0],
        distance_m: vec![1.0],
        test_id: text(),
    };
    check(include_str!("../../vibrissa_msgs/msg/Strain.msg"), &strain);
    let fault = Fault { header: header(), array: text(), whisker: 1, gauge: text(), regulator: text() };
    check(include_str!("../../vibrissa_msgs/msg/Fault.msg"), &fault);
    let estimate = Estimate {
        header: header(),
        array: text(),
        whisker: 1,
        length_m: 1.0,
        length_low_m: 1.0,
        length_high_m: 1.0,
        condition: text(),
        gain_ratio: vec![1.0],
        gain: vec![1.0],
    };
    check(include_str!("../../vibrissa_msgs/msg/Estimate.msg"), &estimate);
    let action = include_str!("../../vibrissa_msgs/action/TouchTest.action");
    let parts: Vec<&str> = action.split("---").collect();
    let goal = TouchTestGoal {
        test_id: text(),
        array: text(),
        whisker: 1,
        kind: 1,
        distances_m: vec![1.0],
        deflections_m: vec![1.0],
        contacts: 1,
    };
    check(parts[0], &goal);
    check(parts[1], &TouchTestResult { contacts: vec![contact()], problem: text() });
    check(parts[2], &TouchTestFeedback { contacts: 1 });
}
