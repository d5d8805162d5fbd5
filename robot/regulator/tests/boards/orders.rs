//! Orders that come back to back, as the agent repeats them, at any moment of the board's work.

use std::fmt::Write as _;

use crate::whiskers::{SIX, sorted};
use crate::{Lines, compiled, configure, of, run, save};

/// Bursts, and the time between two of them, in ms: a board sends its lines every 100 ms, and so each burst meets
/// another part of its work.
const BURSTS: u32 = 60;
const EVERY_MS: u32 = 127;

/// A board whose whiskers have a gauge and a slide. It is ready after 1.8 s, and each burst has three lines for each
/// whisker: one that holds no pressure, a pulse of the fill valve, and one that the board does not read.
fn bursts(count: usize, baud: u32, slide: &str) -> String {
    let mut script = format!("1000 {{\"type\":\"configure\",\"baud\":{baud}}}\n");
    for (slot, (array, whisker, _, [fill, vent, pressure])) in SIX.iter().take(count).enumerate() {
        let (index, ms) = (slot as u8, 100 + 100 * slot as u32);
        let strain = slot + if count > 2 { 8 } else { 2 };
        script += &format!("50 !chamber {slot} {fill} {vent} {pressure}\n");
        let keys = format!(
            "\"array\":\"{array}\",\"whisker\":{whisker},\"fill_pin\":{fill},\"vent_pin\":{vent},\
             \"pressure_pin\":\"A{pressure}\""
        );
        script += &configure(ms, index, &keys);
        let keys = format!(
            "\"strain_sensor\":\"ANALOG\",\"strain_pin\":\"A{strain}\",\"slide_pin\":\"{slide}\",\"slide_mm\":40"
        );
        script += &configure(ms + 50, index, &keys);
    }
    script += &save(1_200);
    for ms in (0..BURSTS).map(|burst| 2_000 + EVERY_MS * burst) {
        for (array, whisker, ..) in SIX.iter().take(count) {
            let named = format!("\"array\":\"{array}\",\"whisker\":{whisker}");
            let lines = [
                format!("\"set_pressure\",{named},\"pressure_mpa\":0.0,\"slew_mpa_per_s\":0.019999999552965164"),
                format!("\"valve\",{named},\"open\":\"FILL\",\"for_ms\":1.0"),
                format!("\"reading_gain\",{named},\"reading_gain\":1.0331499576568604"),
            ];
            for line in lines {
                writeln!(script, "{ms} {{\"type\":{line}}}").expect("a string takes it");
            }
        }
    }
    let end_ms = 2_000 + EVERY_MS * BURSTS + 500;
    sorted(script + &format!("{end_ms} !stack\n{end_ms} !end\n"))
}

/// Pulses of the fill valves.
fn pulses(lines: &Lines) -> usize {
    lines.iter().filter(|(_, _, line)| line.starts_with("valves 1 0")).count()
}

#[test]
fn regress_no_order_of_a_burst_is_lost() {
    for (board, count, baud, slide) in [("mega", 6, 250_000, "A7"), ("uno", 2, 115_200, "A4")] {
        let Some(folder) = compiled(board) else { return };
        let lines = run(board, &folder, &bursts(count, baud, slide));
        assert_eq!(of(&lines, &["\"SAVED\""]).len(), 1, "{:?}", of(&lines, &["error"]));
        let stack = lines.iter().find_map(|(_, _, line)| line.strip_prefix("stack ")?.parse::<i32>().ok());
        println!("{board} at {baud} baud: {} pulses, {stack:?} bytes of stack left", pulses(&lines));
        assert_eq!(pulses(&lines), count * BURSTS as usize, "{board} at {baud} baud");
        assert!(stack.is_some_and(|bytes| bytes >= 128), "{stack:?}");
    }
}
