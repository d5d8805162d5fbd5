//! Arbitrary topics must not crash or delay the decoder.

use proptest::prelude::*;
use vibrissa_protocol::Topic;

use crate::mutation::{anything, bent_lines, mutations};
use crate::{Input, cases, in_time};

const GOOD: [&str; 4] = [
    "whisker/v1/fleet/robot-1/contacts",
    "whisker/v1/f/r/setpoint_state",
    "whisker/v1/fleet/supervisor/state",
    "whisker/v1/f/r/connection",
];

fn topics() -> impl Strategy<Value = Input> {
    let bent = (prop::sample::select(&GOOD[..]), mutations()).prop_map(|(good, bends)| bent_lines(good, &bends));
    let levels = prop::collection::vec("[a-z0-9_+#$ -]{0,70}|whisker|v1|supervisor|state|contacts|\\PC", 0..8);
    prop_oneof![2 => bent, 1 => anything(), 1 => levels.prop_map(|levels| levels.join("/").into_bytes())]
        .prop_map(Input)
}

proptest! {
    #![proptest_config(cases(8000))]

    #[test]
    fn a_topic_is_read_or_refused_briefly(input in topics()) {
        let text = String::from_utf8_lossy(&input.0);
        match in_time(|| Topic::parse(&text)) {
            Ok(topic) => {
                prop_assert_eq!(topic.to_string(), text.as_ref());
            }
            Err(refusal) => prop_assert!(refusal.to_string().len() < 5000, "{} bytes", refusal.to_string().len()),
        }
    }
}
