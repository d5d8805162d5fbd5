//! The sketch of the Arduino library, compiled for both boards and run on a simulated microcontroller whose pins move
//! the air of simulated chambers. All times are those of the simulation.

mod configuration;
mod gauges;
mod library;
mod one_whisker;
mod orders;
mod whiskers;

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;

/// A step of the board's converter, in MPa.
const STEP_MPA: f64 = 5.0 / 1024.0 / 4.0;

/// The folder of the boards for Arduino.
fn arduino() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../boards/arduino")
}

/// Compiles an example of the library; none if a program is missing.
fn compiled_example(board: &str, example: &str) -> Option<PathBuf> {
    /// Boards and examples that are compiled.
    static DONE: Mutex<Vec<String>> = Mutex::new(Vec::new());
    let has = |path: &str| Path::new(path).exists();
    let avr = has("/usr/bin/avr-g++") && has("/usr/share/arduino/hardware/arduino/avr/cores");
    if !avr || !has("/usr/include/simavr/sim_avr.h") || !has("/usr/bin/cc") {
        println!(
            "skipped: the Arduino board: needs gcc-avr, avr-libc, arduino-core-avr, libsimavr-dev, libelf-dev and cc"
        );
        return None;
    }
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("board-{board}-{example}"));
    let mut done = DONE.lock().expect("no test failed while it compiled");
    let name = format!("{board} {example}");
    if !done.contains(&name) {
        let ended =
            Command::new(arduino().join("build")).arg(board).arg(&folder).arg(example).output().expect("bash runs");
        assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
        done.push(name);
    }
    Some(folder)
}

/// The sketch, compiled; none if a program is missing.
fn compiled(board: &str) -> Option<PathBuf> {
    compiled_example(board, "vibrissa_board")
}

/// Lines of the simulator: time in ms, true pressure of the first chamber in MPa, and the rest of the line.
type Lines = Vec<(f64, f64, String)>;

fn run(board: &str, folder: &Path, script: &str) -> Lines {
    run_program(board, folder, &folder.join("vibrissa_board.elf"), script)
}

fn run_program(board: &str, folder: &Path, program: &Path, script: &str) -> Lines {
    let mut simulator = Command::new(folder.join("simulator"))
        .args([Path::new(board), program])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the simulator starts");
    let mut input = simulator.stdin.take().expect("piped");
    // It may end before it has read everything.
    let script = script.to_owned();
    let writer = std::thread::spawn(move || drop(input.write_all(script.as_bytes())));
    let ended = simulator.wait_with_output().expect("it ends");
    writer.join().expect("it writes");
    assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
    let text = String::from_utf8(ended.stdout).expect("the board writes UTF-8");
    let mut lines = Vec::new();
    for line in text.lines() {
        let mut parts = line.splitn(3, ' ');
        let (Some(ms), Some(mpa), Some(rest)) = (parts.next(), parts.next(), parts.next()) else { continue };
        if let (Ok(ms), Ok(mpa)) = (ms.parse(), mpa.parse()) {
            lines.push((ms, mpa, rest.to_owned()));
        }
    }
    // A restart may cut the line before `hello`: the agent refuses that line alone.
    for (at, (_, _, line)) in lines.iter().enumerate() {
        if !lines.get(at + 1).is_some_and(|(_, _, next)| next.starts_with("{\"type\":\"hello\"")) {
            keeps_the_interface(line);
        }
    }
    lines.retain(|(_, _, line)| !line.is_empty());
    lines
}

/// Fails if the agent would refuse the samples of this line.
fn keeps_the_interface(line: &str) {
    if let Some(every) = line.split("\"every_us\":").nth(1).and_then(|rest| rest.split(',').next()) {
        assert!(every.parse().is_ok_and(|us: u32| (500..=100_000).contains(&us)), "{line}");
    }
    let (strains, ways) = (list(line, "strain").len(), list(line, "deflection_mm").len());
    assert!(strains == 0 || ways == 0 || strains == ways, "{line}");
    assert!(!line.starts_with('{') || line.ends_with('}'), "{line}");
}

fn set_pressure(ms: u32, mpa: f64) -> String {
    format!(
        "{ms} {{\"type\":\"set_pressure\",\"array\":\"left\",\"whisker\":1,\"pressure_mpa\":{mpa},\"slew_mpa_per_s\":0}}\n"
    )
}

/// A setpoint, repeated every two seconds.
fn held(from_ms: u32, to_ms: u32, mpa: f64) -> String {
    (from_ms..to_ms).step_by(2_000).map(|ms| set_pressure(ms, mpa)).collect()
}

/// The newest pressure line up to a time.
fn at(lines: &[(f64, f64, String)], ms: f64) -> (f64, String) {
    let newest =
        lines.iter().rfind(|(at, _, line)| *at <= ms && line.contains("\"pressure\"")).expect("pressure lines");
    (newest.1, newest.2.clone())
}

/// The lines of the board that have all these parts.
fn of<'a>(lines: &'a Lines, parts: &[&str]) -> Vec<&'a str> {
    let has = |line: &&str| line.starts_with('{') && parts.iter().all(|part| line.contains(part));
    lines.iter().map(|(_, _, line)| line.as_str()).filter(has).collect()
}

/// A line `configure` for a slot.
fn configure(ms: u32, slot: u8, keys: &str) -> String {
    format!("{ms} {{\"type\":\"configure\",\"slot\":{slot},{keys}}}\n")
}

fn save(ms: u32) -> String {
    format!("{ms} {{\"type\":\"configure\",\"save\":true}}\n")
}

/// An order for any whisker.
fn order(ms: u32, array: &str, whisker: u16, mpa: f64) -> String {
    format!(
        "{ms} {{\"type\":\"set_pressure\",\"array\":\"{array}\",\"whisker\":{whisker},\"pressure_mpa\":{mpa},\
         \"slew_mpa_per_s\":0}}\n"
    )
}

/// The numbers of a list in a line.
fn list(line: &str, name: &str) -> Vec<f64> {
    let begin = format!("\"{name}\":[");
    let inside = line.split(&begin).nth(1).and_then(|rest| rest.split(']').next()).unwrap_or_default();
    inside.split(',').filter_map(|number| number.parse().ok()).collect()
}
