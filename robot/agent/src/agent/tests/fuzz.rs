//! Lines that no driver should send, and noise of a serial line.

use proptest::prelude::*;

use super::*;
use crate::driver::{LINE_MAX_BYTES, Lines};

const GOOD: &str =
    r#"{"type":"contact","whisker":0,"deflection_mm":2.0,"strain":0.01,"ratio":0.8,"t_us":1795248000000000}"#;

/// Pieces of lines that are wrong in the ways of programs, people and cables.
fn piece() -> impl Strategy<Value = Vec<u8>> {
    let word = prop_oneof![
        Just("contact"),
        Just("strain"),
        Just("pressure"),
        Just("fault"),
        Just("hello"),
        Just("test_state"),
        Just("set_pressure"),
    ];
    let value = prop_oneof![
        Just("NaN".to_owned()),
        Just("-Infinity".to_owned()),
        Just("1e999".to_owned()),
        Just("-1e400".to_owned()),
        Just("18446744073709551616".to_owned()),
        Just("null".to_owned()),
        Just("\"\\ud800\"".to_owned()),
        Just("[[[]]]".to_owned()),
        any::<f64>().prop_map(|number| number.to_string()),
        any::<i64>().prop_map(|number| number.to_string()),
        "[ -~]{0,20}".prop_map(|text| format!("{text:?}")),
    ];
    let field = prop_oneof![
        Just("array"),
        Just("whisker"),
        Just("t_us"),
        Just("t_ms"),
        Just("strain"),
        Just("deflection_mm"),
        Just("ratio"),
        Just("distance_mm"),
        Just("pressure_mpa"),
        Just("version"),
        Just("test_id"),
        Just("touched"),
    ];
    let object = (word, prop::collection::vec((field, value), 0..6)).prop_map(|(word, fields)| {
        let fields: String = fields.iter().map(|(name, value)| format!(",\"{name}\":{value}")).collect();
        format!("{{\"type\":\"{word}\"{fields}}}").into_bytes()
    });
    let nested = (1_usize..2000).prop_map(|depth| {
        format!("{{\"type\":\"fault\",\"x\":{}{}}}", "[".repeat(depth), "]".repeat(depth)).into_bytes()
    });
    let cut = (0..GOOD.len()).prop_map(|length| GOOD.as_bytes()[..length].to_vec());
    prop_oneof![
        3 => prop::collection::vec(any::<u8>(), 0..200),
        5 => object,
        1 => nested,
        2 => cut,
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    /// No noise stops the agent or takes a good line with it, each bad line is counted, and no bad number gets through.
    #[test]
    fn noise_between_good_lines_costs_no_good_line(pieces in prop::collection::vec(piece(), 0..30), chunk in 1_usize..97) {
        let mut stream = Vec::new();
        for piece in &pieces {
            stream.extend_from_slice(piece);
            // Noise ends somewhere; the next line begins after a line feed.
            stream.push(b'\n');
            stream.extend_from_slice(GOOD.as_bytes());
            stream.push(b'\n');
        }
        let mut bench = Bench::running();
        let (mut lines, mut given) = (Lines::default(), 0);
        for chunk in stream.chunks(chunk) {
            for line in lines.push(chunk) {
                given += 1;
                bench.step(Input::Line(0, line.as_deref()));
            }
        }
        bench.run(0.2);
        let counts = bench.agent.counts();
        let sent: Vec<Contacts> = bench.contacts();
        let good = sent.iter().flat_map(|message| &message.contacts).filter(|one| one.strain == 0.01).count();
        prop_assert!(good >= pieces.len(), "{} of {}", good, pieces.len());
        // `running` gives two readings.
        prop_assert_eq!(counts.lines, given + 2);
        prop_assert!(counts.lines_refused <= given);
    }

    /// Whatever the network sends, the agent keeps the contract and no pressure beyond the limits reaches the driver.
    #[test]
    fn no_message_moves_a_valve_beyond_its_limits(
        messages in prop::collection::vec((0_u64..5, 0_u64..5, -0.1..0.4_f64, 0_u16..3, any::<bool>(), -5_i64..5), 1..30),
    ) {
        let mut bench = Bench::running();
        let mut highest = None;
        for (at, (epoch, version, pressure_mpa, whisker, is_right_boot, ahead_s)) in messages.into_iter().enumerate() {
            let mut setpoint = bench.setpoint(version, pressure_mpa);
            (setpoint.epoch, setpoint.whisker, setpoint.command_id) = (epoch, whisker, format!("c{at}"));
            setpoint.expires_us = bench.now_us.saturating_add_signed(ahead_s * 1_000_000);
            if !is_right_boot {
                setpoint.robot_boot_id = BootId::new("b0").unwrap();
            }
            bench.take();
            bench.send(RobotTopic::Setpoint, &setpoint);
            if whisker != 0 {
                continue;
            }
            let may = is_right_boot && Some((epoch, version)) > highest && ahead_s > 0 && (0.0..=0.2).contains(&pressure_mpa);
            prop_assert_eq!(bench.pressures(0), if may { vec![pressure_mpa] } else { vec![] });
            if is_right_boot {
                highest = highest.max(Some((epoch, version)));
            }
        }
    }
}

#[test]
fn a_line_without_an_end_takes_little_memory() {
    let mut lines = Lines::default();
    for _ in 0..10 * LINE_MAX_BYTES / 64 {
        assert!(lines.push(&[b'['; 64]).is_empty());
    }
    assert_eq!(lines.push(b"\n").len(), 1);
}
