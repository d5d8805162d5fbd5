//! The sketch on a simulated microcontroller, in lock step: it runs to a time, and then waits for the next one.

use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::Mutex;

/// The simulator with the sketch.
pub(crate) struct Microcontroller {
    simulator: Child,
    orders: ChildStdin,
    lines: BufReader<ChildStdout>,
    /// Orders that are not sent yet, with their times in ms.
    waiting: Vec<(f64, String)>,
}

/// The folder with the compiled sketch and its simulator; none if a program is missing.
fn compiled(board: &str) -> Option<PathBuf> {
    static DONE: Mutex<Vec<String>> = Mutex::new(Vec::new());
    let has = |path: &str| Path::new(path).exists();
    let avr = has("/usr/bin/avr-g++") && has("/usr/share/arduino/hardware/arduino/avr/cores");
    if !avr || !has("/usr/include/simavr/sim_avr.h") || !has("/usr/bin/cc") {
        println!(
            "skipped: the way of a board: needs gcc-avr, avr-libc, arduino-core-avr, libsimavr-dev, libelf-dev and cc"
        );
        return None;
    }
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("desk-{board}"));
    let mut done = DONE.lock().unwrap();
    if !done.iter().any(|one| one == board) {
        let build = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robot/boards/arduino/build");
        let ended = Command::new(build).arg(board).arg(&folder).output().unwrap();
        assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
        done.push(board.to_owned());
    }
    Some(folder)
}

impl Microcontroller {
    /// Starts a board, `uno` or `mega`; none if a program is missing.
    pub(crate) fn start(board: &str) -> Option<Self> {
        let folder = compiled(board)?;
        let mut simulator = Command::new(folder.join("simulator"))
            .args([Path::new(board), &folder.join("vibrissa_board.elf")])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let (orders, lines) = (simulator.stdin.take().unwrap(), simulator.stdout.take().unwrap());
        Some(Self { simulator, orders, lines: BufReader::new(lines), waiting: Vec::new() })
    }

    /// A line to the board, or an order to its simulator, at a time in ms since the start.
    pub(crate) fn at(&mut self, ms: f64, what: &str) {
        self.waiting.push((ms, what.to_owned()));
    }

    /// Runs to a time; the lines of the board, and the true pressures of its chambers then.
    pub(crate) fn run_to(&mut self, ms: f64) -> (Vec<String>, Vec<f64>) {
        self.at(ms, "!pressures");
        // The simulator reads an order once the one before is done.
        self.waiting.sort_by(|(one, _), (other, _)| one.total_cmp(other));
        let due = self.waiting.partition_point(|(at, _)| *at <= ms);
        let script: String = self.waiting.drain(..due).map(|(ms, what)| format!("{ms:.1} {what}\n")).collect();
        self.orders.write_all(script.as_bytes()).unwrap();
        let mut said = Vec::new();
        loop {
            let mut line = String::new();
            assert!(self.lines.read_line(&mut line).unwrap() > 0, "the simulator has ended");
            // After the time and the pressure of the first chamber.
            let Some(rest) = line.trim_end_matches('\n').splitn(3, ' ').nth(2) else { continue };
            if let Some(pressures) = rest.strip_prefix("pressures ") {
                return (said, pressures.split(' ').map(|number| number.parse().unwrap()).collect());
            }
            if !rest.starts_with("valves ") {
                said.push(rest.to_owned());
            }
        }
    }
}

impl Drop for Microcontroller {
    fn drop(&mut self) {
        // It may have ended.
        let _ = self.simulator.kill();
        let _ = self.simulator.wait();
    }
}
