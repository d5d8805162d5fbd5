//! `vibrissa-robot discover`: the serial devices of this machine, and what speaks there.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::Duration;

use tokio::io::AsyncReadExt;
use tokio::task::JoinSet;
use tokio::time::{Instant, timeout_at};
use vibrissa_host::task;

use crate::driver::link::serial;
use crate::driver::{FromDriver, Lines};

/// Folder with lasting names of USB devices.
const BY_ID: &str = "/dev/serial/by-id";
/// Beginnings of the names of serial devices that a board may have.
const NAMES: [&str; 5] = ["ttyACM", "ttyUSB", "ttyAMA", "serial", "rfcomm"];
/// Speeds to try, the usual one first.
const BAUDS: [u32; 6] = [115_200, 9_600, 57_600, 250_000, 500_000, 1_000_000];
/// Time for the first speed: a board may restart when its device is opened.
const FIRST: Duration = Duration::from_secs(5);
/// Time for each other speed.
const OTHER: Duration = Duration::from_secs(2);

/// Findings at a device.
#[derive(Debug, Default)]
struct Heard {
    bytes: usize,
    lines: usize,
    refused: usize,
    name: Option<String>,
    words: BTreeSet<String>,
    whiskers: BTreeSet<String>,
}

impl Heard {
    fn take(&mut self, line: &[u8]) {
        let Ok(word) = FromDriver::read(line) else {
            self.refused += 1;
            return;
        };
        self.lines += 1;
        let (kind, origin) = match word {
            FromDriver::Hello(hello) => {
                self.name = Some(hello.name);
                ("hello", None)
            }
            FromDriver::Contact(line) => ("contact", Some(line.origin())),
            FromDriver::Strain(line) => ("strain", Some(line.origin())),
            FromDriver::Motion(line) => ("motion", Some(line.origin())),
            FromDriver::Pressure(line) => ("pressure", Some(line.origin())),
            FromDriver::Fault(line) => ("fault", Some(line.origin())),
            FromDriver::TestState(_) => ("test_state", None),
            FromDriver::Driving(_) => ("driving", None),
            FromDriver::Task(_) => ("task", None),
            FromDriver::Locate(line) => ("locate", Some(line.origin())),
            FromDriver::Configured(_) => ("configured", None),
            FromDriver::Configuration(_) => ("configuration", None),
            FromDriver::Error(_) => ("error", None),
        };
        self.words.insert(kind.to_owned());
        let place = origin.map(|origin| match origin.array {
            Some(array) => format!("{array}/{}", origin.whisker),
            None => origin.whisker.to_string(),
        });
        self.whiskers.extend(place);
    }

    fn text(&self, baud: u32) -> String {
        let list = |names: &BTreeSet<String>| names.iter().map(String::as_str).collect::<Vec<&str>>().join(", ");
        if self.lines > 0 {
            let name = self.name.as_ref().map_or_else(String::new, |name| format!(" {name:?}"));
            return format!(
                "a driver{name} at {baud} baud: {} of whiskers {}; {} other lines",
                list(&self.words),
                list(&self.whiskers),
                self.refused
            );
        }
        if self.bytes == 0 {
            return "nothing speaks: a board that waits for an order, or another device".to_owned();
        }
        format!("{} bytes that are no lines of the driver interface: another device, or another speed", self.bytes)
    }
}

/// The serial devices of this machine, each once, by its lasting name if it has one.
fn devices() -> Vec<PathBuf> {
    let entries = |folder: &str| {
        let read = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let mut paths: Vec<PathBuf> = read.map(|entry| entry.path()).collect();
        paths.sort();
        paths
    };
    let is_serial = |path: &PathBuf| {
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        NAMES.iter().any(|begin| name.starts_with(begin)) && !path.is_dir()
    };
    let mut seen = BTreeSet::new();
    let all = entries(BY_ID).into_iter().chain(entries("/dev").into_iter().filter(is_serial));
    all.filter(|path| path.canonicalize().is_ok_and(|device| seen.insert(device))).collect()
}

async fn listen(path: &Path, baud: u32, time: Duration) -> std::io::Result<Heard> {
    let mut link = serial(path, baud)?;
    let (mut heard, mut lines, mut buffer) = (Heard::default(), Lines::default(), [0; 4096]);
    let until = Instant::now() + time;
    while let Ok(read) = timeout_at(until, link.reader.read(&mut buffer)).await {
        let read = read?;
        if read == 0 {
            break;
        }
        heard.bytes += read;
        lines.push(&buffer[..read]).into_iter().flatten().for_each(|line| heard.take(&line));
    }
    Ok(heard)
}

/// The speaker at a device.
async fn explore(path: PathBuf) -> String {
    let shown = path.display();
    let mut last = String::new();
    for (baud, time) in BAUDS.into_iter().zip([FIRST].into_iter().chain(std::iter::repeat(OTHER))) {
        match listen(&path, baud, time).await {
            Ok(heard) => {
                last = heard.text(baud);
                // Silence has no speed.
                if heard.lines > 0 || heard.bytes == 0 {
                    break;
                }
            }
            Err(problem) => {
                let may_not = problem.kind() == std::io::ErrorKind::PermissionDenied;
                let advice = if may_not { ": add this user to the group dialout" } else { "" };
                // It names the device.
                return format!("{problem}{advice}");
            }
        }
    }
    format!("{shown}: {last}")
}

/// Listens at the serial devices of this machine, or at the given ones, and prints what speaks there.
pub async fn discover(given: Vec<PathBuf>) {
    let devices = if given.is_empty() { devices() } else { given };
    if devices.is_empty() {
        println!("no serial device: plug a board in, and look at the end of dmesg");
    }
    let mut found = JoinSet::new();
    for path in devices {
        task::spawn_in(&mut found, explore(path));
    }
    while let Some(text) = found.join_next().await {
        if let Ok(text) = text {
            println!("{text}");
        }
    }
}
