//! One whisker, as the board comes.

use std::process::Command;

use crate::{STEP_MPA, at, compiled, held, run, run_program, set_pressure};

#[test]
fn the_board_says_hello_and_reports_at_its_rates() {
    for board in ["uno", "mega"] {
        let Some(folder) = compiled(board) else { return };
        let lines = run(board, &folder, &format!("{}5000 !end\n", held(100, 5_000, 0.0)));
        let said: Vec<&str> =
            lines.iter().map(|(_, _, line)| line.as_str()).filter(|line| line.starts_with('{')).collect();
        assert_eq!(
            said[0],
            "{\"type\":\"hello\",\"version\":1,\"name\":\"vibrissa_board\",\"firmware_version\":\"0.2.0\",\"whiskers\":1,\
             \"configuration\":\"DEFAULT\"}"
        );
        let of = |word: &str| said.iter().filter(|line| line.contains(&format!("\"type\":\"{word}\""))).count();
        assert!((18..=20).contains(&of("pressure")), "{}", of("pressure"));
        assert!((48..=50).contains(&of("strain")), "{}", of("strain"));
        let strain = said.iter().find(|line| line.contains("\"strain\"")).expect("strain");
        assert!(strain.contains("\"every_us\":10000") && strain.matches(',').count() == 14, "{strain}");
    }
}

#[test]
fn the_board_regulates_within_a_step_and_vents_when_the_lines_stop() {
    for board in ["uno", "mega"] {
        let Some(folder) = compiled(board) else { return };
        let script = format!("{}{}30500 !end\n", held(300, 12_000, 0.08), held(12_300, 24_000, 0.031));
        let lines = run(board, &folder, &script);
        for (from_ms, to_ms, mpa) in [(6_000.0, 12_000.0, 0.08), (18_000.0, 24_000.0, 0.031)] {
            let during = || lines.iter().filter(|(ms, _, _)| (from_ms..to_ms).contains(ms));
            let read = during().filter_map(|(_, _, line)| line.split("\"pressure_mpa\":").nth(1)?.split(',').next());
            let read =
                read.map(|text| (text.parse::<f64>().unwrap_or(9.0) - mpa).abs() / STEP_MPA).fold(0.0f64, f64::max);
            assert!(read > 0.0 && read <= 1.0, "{board}: the readings are {read} steps from {mpa}");
            // Within its step the converter sees nothing.
            let away = during().map(|(_, at, _)| (at - mpa).abs() / STEP_MPA).fold(0.0, f64::max);
            assert!(away <= 1.3, "{board}: {away} steps from {mpa}");
            let switched =
                lines.iter().filter(|(ms, _, line)| (from_ms..to_ms).contains(ms) && line.starts_with("valves 1"));
            assert!(switched.count() < 6, "{board}");
            assert!(at(&lines, to_ms).1.contains("\"regulator\":\"OK\""), "{board}: {:?}", at(&lines, to_ms));
        }
        // The last line came at 22.3 s: five seconds later it vents.
        assert!((at(&lines, 27_000.0).0 - 0.031).abs() < STEP_MPA, "{board}: it vents too early");
        assert!(at(&lines, 30_000.0).0 < STEP_MPA, "{board}: {:?}", at(&lines, 30_000.0));
    }
}

#[test]
fn regress_the_board_keeps_its_limit_and_answers_an_order_above_it() {
    let Some(folder) = compiled("uno") else { return };
    let mut script = held(300, 4_000, 0.05);
    for (index, line) in [
        "{\"type\":\"set_pressure\",\"whisker\":1,\"pressure_mpa\":0.9,\"slew_mpa_per_s\":0}",
        "{\"type\":\"set_pressure\",\"whisker\":1,\"pressure_mpa\":\"much\"}",
        "{\"type\":\"set_pressure\",\"whisker\":2,\"pressure_mpa\":0.1,\"slew_mpa_per_s\":0}",
        "{\"type\":\"set_pressure\",\"array\":\"right\",\"whisker\":1,\"pressure_mpa\":0.1,\"slew_mpa_per_s\":0}",
        "{\"type\":\"valve\",\"whisker\":1,\"open\":\"FILL\",\"for_ms\":5000}",
        "{\"type\":",
        "not JSON",
    ]
    .iter()
    .enumerate()
    {
        script += &format!("{} {line}\n", 4_300 + 100 * index);
    }
    script += &format!("5200 {}\n", "x".repeat(390));
    script += &format!("{}8000 !end\n", set_pressure(5_500, 0.05));
    let lines = run("uno", &folder, &script);
    let highest = lines.iter().map(|(_, mpa, _)| *mpa).fold(0.0, f64::max);
    assert!(highest < 0.05 + 2.0 * STEP_MPA, "{highest}");
    assert!((at(&lines, 8_000.0).0 - 0.05).abs() <= STEP_MPA, "{:?}", at(&lines, 8_000.0));
    // The one above the limit has an answer.
    let refused =
        lines.iter().filter(|(_, _, line)| line.contains("\"type\":\"error\",\"array\":\"left\",\"whisker\":1,"));
    assert_eq!(refused.count(), 1);
}

#[test]
fn regress_an_order_above_the_limit_by_the_zero_of_the_sensor_is_obeyed_as_the_limit() {
    let Some(folder) = compiled("uno") else { return };
    let script = format!("{}16000 !end\n", held(300, 16_000, 0.200_8));
    let lines = run("uno", &folder, &script);
    let highest = lines.iter().map(|(_, mpa, _)| *mpa).fold(0.0, f64::max);
    assert!(highest < 0.2 + 1.3 * STEP_MPA, "{highest}");
    // The watchdog would have vented the chamber since 5 s.
    assert!((at(&lines, 16_000.0).0 - 0.2).abs() <= 1.3 * STEP_MPA, "{:?}", at(&lines, 16_000.0));
}

#[test]
fn a_pulse_by_hand_ends_by_itself() {
    let Some(folder) = compiled("uno") else { return };
    let script =
        "300 {\"type\":\"valve\",\"array\":\"left\",\"whisker\":1,\"open\":\"FILL\",\"for_ms\":120}\n3000 !end\n";
    let lines = run("uno", &folder, script);
    let changes: Vec<(f64, &str)> = lines
        .iter()
        .filter(|(ms, _, line)| *ms > 100.0 && line.starts_with("valves"))
        .map(|(ms, _, line)| (*ms, line.as_str()))
        .collect();
    assert_eq!(changes.iter().map(|(_, line)| *line).collect::<Vec<_>>(), ["valves 1 0", "valves 0 0"]);
    let open_ms = changes[1].0 - changes[0].0;
    assert!((119.0..124.0).contains(&open_ms), "{open_ms} ms");
}

#[test]
fn a_dead_sensor_and_a_lost_supply_are_reported() {
    let Some(folder) = compiled("uno") else { return };
    let script = format!("{}9000 !sensor 0\n12000 !end\n", held(300, 12_000, 0.08));
    let lines = run("uno", &folder, &script);
    let (mpa, line) = at(&lines, 12_000.0);
    assert!(line.contains("\"regulator\":\"FAULT\"") && mpa < STEP_MPA, "{mpa} {line}");
    let script = format!("200 !supply 0\n{}14000 !end\n", held(300, 14_000, 0.08));
    let lines = run("uno", &folder, &script);
    let (_, line) = at(&lines, 14_000.0);
    assert!(line.contains("\"regulator\":\"SUPPLY_LOW\""), "{line}");
}

#[test]
fn regress_lines_that_are_no_orders_for_the_board_do_not_feed_its_watchdog() {
    let Some(folder) = compiled("uno") else { return };
    for line in [
        "{\"type\":\"estimate\",\"array\":\"left\",\"whisker\":1,\"length_mm\":60.2}",
        "{\"type\":\"set_pressure\",\"array\":\"left\",\"whisker\":2,\"pressure_mpa\":0.05,\"slew_mpa_per_s\":0}",
        "{\"type\":\"set_pressure\",\"array\":\"left\",\"whisker\":1,\"pressure_mpa\":0.9}",
        "{\"type\":\"set_pressure\",\"array\":\"left\",\"whisker\":1,\"pressure_mpa\":0.0",
        "{\"type\":\"x\"}",
    ] {
        let mut script = held(300, 4_000, 0.05);
        (5_000..10_500).step_by(1_000).for_each(|ms| script += &format!("{ms} {line}\n"));
        let lines = run("uno", &folder, &(script + "10600 !end\n"));
        assert!((at(&lines, 7_000.0).0 - 0.05).abs() <= STEP_MPA, "{line}: {:?}", at(&lines, 7_000.0));
        // The last order came at 2.3 s.
        assert!(at(&lines, 10_500.0).0 < STEP_MPA, "{line}: {:?}", at(&lines, 10_500.0));
    }
}

/// docs/driver-interface.md, its driver in C.
const INTERFACE: &str = include_str!("../../../../docs/driver-interface.md");

#[test]
fn regress_the_driver_in_c_of_the_document_works_on_a_microcontroller() {
    let Some(folder) = compiled("mega") else { return };
    let source = INTERFACE.split("```c\n").nth(1).and_then(|rest| rest.split("```").next()).expect("a driver in C");
    let board = r#"
        #define F_CPU 16000000UL
        #include <avr/io.h>
        #include <util/delay.h>
        static int put(char c, FILE *f) { (void)f; while (!(UCSR0A & (1 << UDRE0))); UDR0 = c; return 0; }
        static FILE out = FDEV_SETUP_STREAM(put, NULL, _FDEV_SETUP_WRITE);
        static double held[3] = {0.1, 0.1, -0.0004};
        double read_mpa(int whisker) { return held[whisker]; }
        void set_mpa(int whisker, double mpa, double slew) { if (slew == 0.02) held[whisker] = mpa; }
        static char heard[200];
        static int length, is_whole;
        static void hear(void) {
            if (is_whole || !(UCSR0A & (1 << RXC0))) return;
            char c = UDR0;
            if (c == '\n') is_whole = 1;
            else if (length < (int)sizeof heard - 1) heard[length++] = c;
        }
        int read_line(char *line, int size) {
            if (!is_whole) return 0;
            heard[length] = 0;
            length = is_whole = 0;
            strncpy(line, heard, size);
            return 1;
        }
        int main(void) {
            UCSR0B = 1 << TXEN0 | 1 << RXEN0;
            UBRR0 = 8;
            stdout = &out;
            for (;;) {
                loop();
                for (int i = 0; i < 2000; i++) { hear(); _delay_us(20); }
            }
        }
        "#;
    let (c, elf) = (folder.join("document.c"), folder.join("document.elf"));
    std::fs::write(&c, format!("{source}{board}")).expect("a file is written");
    let mut compiler = Command::new("avr-gcc");
    compiler.args(["-mmcu=atmega2560", "-Os", "-std=gnu11", "-Wall", "-Werror", "-o"]).arg(&elf).arg(&c).arg("-lm");
    let ended = compiler.output().expect("avr-gcc runs");
    assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
    let script = format!("{}900 !end\n", set_pressure(200, 0.12).replace(":0}", ":0.02}"));
    let lines = run_program("mega", &folder, &elf, &script);
    let said: Vec<&str> =
        lines.iter().map(|(_, _, line)| line.as_str()).filter(|line| line.contains("pressure")).collect();
    for expected in [
        "{\"type\":\"pressure\",\"whisker\":0,\"pressure_mpa\":0.100000}",
        "{\"type\":\"pressure\",\"whisker\":1,\"pressure_mpa\":0.120000}",
        "{\"type\":\"pressure\",\"whisker\":2,\"pressure_mpa\":0.000000}",
    ] {
        assert!(said.iter().any(|line| line.ends_with(expected)), "{expected}: {said:?}");
    }
}
