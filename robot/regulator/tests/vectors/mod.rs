//! The C++ regulator of the Arduino board does the same as this crate, step for step.

use std::io::Write as _;
use std::path::Path;
use std::process::{Command as Process, Stdio};

use vibrissa_regulator::{Command, Params};

use crate::chamber::{Rig, Sensor};

/// A rig's log as lines; setpoints are those of [`drive`].
fn lines(seed: u64, text: &mut String) {
    let mut rig = Rig::new(Params::default(), seed);
    rig.reading_us = 5_000;
    rig.supply_sensor = seed.is_multiple_of(3);
    if seed % 2 == 1 {
        // The board's 32 bits of time wrap around five seconds later.
        rig.now_us = 4_290_000_000;
    }
    text.push_str("new\n");
    for (mpa, slew, seconds) in [(0.08f32, 0.0f32, 8.0), (0.15, 0.02, 10.0), (0.03, 0.0, 8.0), (0.1, 0.0, 25.0)] {
        rig.regulator.set_target(mpa, slew);
        text.push_str(&format!("target {:x} {:x}\n", mpa.to_bits(), slew.to_bits()));
        if mpa == 0.1 {
            // Each stream ends with something else that fails.
            match seed % 6 {
                0 => rig.supply_mpa = 0.05,
                1 => rig.sensor = Sensor::Dead,
                2 => rig.sensor = Sensor::Frozen(0.03),
                3 => rig.leak_mpa_per_s = 0.002,
                4 => rig.fill_stuck = Some(0.0),
                _ => rig.sensor = Sensor::NotANumber,
            }
        }
        rig.keep_log = true;
        rig.log.clear();
        rig.run(seconds, |_| {});
        for (now_us, reading, supply, command, condition) in &rig.log {
            let (kind, us) = match command {
                Command::None => ("NONE", 0),
                Command::Fill(us) => ("FILL", *us),
                Command::Vent(us) => ("VENT", *us),
                Command::Close => ("CLOSE", 0),
            };
            let (reading, supply) = (reading.to_bits(), supply.unwrap_or(f32::NAN).to_bits());
            text.push_str(&format!("{now_us} {reading:x} {supply:x} {kind} {us} {}\n", condition.word()));
        }
    }
}

#[test]
fn the_regulator_in_c_plus_plus_gives_the_same_commands() {
    if !Process::new("g++").arg("--version").output().is_ok_and(|ended| ended.status.success()) {
        println!("skipped: the C++ regulator against the Rust one: needs g++");
        return;
    }
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../boards/arduino/vectors/check.cpp");
    let program = folder.join("regulator-vectors");
    // Contracted multiplications and additions would round differently.
    let flags = ["-std=c++14", "-O1", "-Wall", "-Wextra", "-Werror", "-ffp-contract=off", "-o"];
    let built = Process::new("g++").args(flags).arg(&program).arg(&source).output().unwrap();
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    let mut text = String::new();
    for seed in 0..18 {
        lines(seed, &mut text);
    }
    let mut child = Process::new(&program).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    // A difference ends the program before it has read everything.
    drop(child.stdin.take().unwrap().write_all(text.as_bytes()));
    let ended = child.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&ended.stdout);
    assert!(ended.status.success(), "{said}");
    assert!(said.contains("steps agree"), "{said}");
}
