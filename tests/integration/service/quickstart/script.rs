//! The Python block of the document, and an environment in which it runs.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use tempfile::TempDir;
use vibrissa_tests::process::{Launch, Process};
use vibrissa_tests::python::environment;

/// The document's robot as a process: robot `r` of fleet `f`.
pub(super) struct Script {
    pub(super) process: Process,
    folder: TempDir,
}

impl Script {
    /// Starts the robot; whisker 1 loses 5 mm after this many seconds.
    pub(super) fn start(broker_port: u16, cut_after_s: f64) -> Self {
        Self::run(&block(), broker_port, cut_after_s)
    }

    /// The same with contacts in CBOR.
    pub(super) fn start_with_cbor(broker_port: u16, cut_after_s: f64) -> Self {
        let lines = block();
        let json = lines.lines().find(|line| line.starts_with("    payload = ")).expect("the line of contacts");
        Self::run(&lines.replace(json, blocks()[1].trim_end()), broker_port, cut_after_s)
    }

    /// The same on a machine whose clock somebody sets all the time, an hour ahead or back.
    pub(super) fn start_while_the_clock_is_set(broker_port: u16, cut_after_s: f64) -> Self {
        const SET: &str = r#"
import itertools, random, time
def set_meanwhile(right, hour):  # right at the first call alone
    sets = itertools.chain([0], (random.choice([-hour, hour]) for _ in itertools.count()))
    return lambda: right() + next(sets)
time.time, time.time_ns = set_meanwhile(time.time, 3600), set_meanwhile(time.time_ns, 3600 * 10**9)
"#;
        Self::run(&format!("{SET}{}", block()), broker_port, cut_after_s)
    }

    fn run(lines: &str, broker_port: u16, cut_after_s: f64) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("robot.py");
        fs::write(&path, lines).unwrap();
        let environment = [
            ("BROKER_PORT", broker_port.to_string()),
            ("FLEET", "f".to_owned()),
            ("ROBOT", "r".to_owned()),
            ("CUT_AFTER_S", cut_after_s.to_string()),
        ];
        let process = Process::start(Launch {
            program: python().to_owned(),
            arguments: vec![path.to_str().unwrap().to_owned()],
            environment: environment.map(|(name, value)| (name.to_owned(), value)).to_vec(),
            log: folder.path().join("log"),
        });
        Self { process, folder }
    }

    /// Errors that the robot has printed.
    pub(super) fn complaints(&self) -> String {
        fs::read_to_string(self.folder.path().join("log")).unwrap()
    }
}

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The document's Python blocks: the robot, its contacts in CBOR, and its handling of estimates.
fn blocks() -> [String; 3] {
    let document = fs::read_to_string(repository().join("docs/robot-quickstart.md")).unwrap();
    let blocks: Vec<String> = document
        .split("```python\n")
        .skip(1)
        .map(|rest| rest.split_once("```").expect("the end of the block").0.to_owned())
        .collect();
    blocks.try_into().expect("three blocks of Python")
}

/// The robot with its handling of estimates, inserted as the document says.
fn block() -> String {
    let [robot, _, estimates] = blocks();
    let (before, after) = robot.split_once("\nseqs[").expect("the line below HANDLERS");
    assert!(before.lines().last().is_some_and(|line| line.starts_with("HANDLERS = ")), "{before}");
    format!("{before}\n{estimates}seqs[{after}")
}

/// Path of a Python with the packages that the block needs.
fn python() -> &'static Path {
    static PYTHON: OnceLock<PathBuf> = OnceLock::new();
    PYTHON.get_or_init(|| environment("requirements.txt", env!("CARGO_TARGET_TMPDIR")).join("python"))
}

#[test]
fn the_whole_robot_has_less_than_100_lines_that_fit_a_screen() {
    let [robot, cbor, estimates] = blocks();
    assert!(robot.lines().count() < 100, "{} lines", robot.lines().count());
    assert!(estimates.lines().count() < 20, "{} lines", estimates.lines().count());
    assert!([robot, cbor, estimates].iter().flat_map(|block| block.lines()).all(|line| line.chars().count() <= 120));
}

/// The block's functions with estimates in any order.
#[test]
fn its_robot_orders_estimates_divides_by_the_newest_length_and_applies_gains() {
    const BEFORE: &str = "import types\nARRAY, LEVEL, HANDLERS, NOMINAL_MPA = 'left', '', {}, 0.1\n";
    const AFTER: &str = r#"
w = types.SimpleNamespace(number=1, gain=None)
def tell(epoch, version, length_mm, gain, **more):
    entry = {"array": "left", "whisker": 1, "length_mm": length_mm, "gain": gain, **more}
    HANDLERS["estimate"]({"epoch": epoch, "version": version, "whiskers": [entry]})
assert contact_ratio(w, 30.0) is None and corrected(w, 0.5, 0.01) == 0.01
tell(7, 3, 60.0, [[0.5, 1.0], [0.7, 1.2], [1.0, 1.1]])
tell(7, 2, 50.0, [])
tell(6, 9, 50.0, [])
assert contact_ratio(w, 30.0) == 0.5
for ratio, factor in [(0.4, 1.0), (0.5, 1.0), (0.6, 1.1), (0.7, 1.2), (0.85, 1.15), (1.0, 1.1), (1.1, 1.1)]:
    assert abs(corrected(w, ratio, 0.01) - 0.01 * factor) < 1e-12, (ratio, corrected(w, ratio, 0.01))
tell(8, 0, 40.0, [])
assert contact_ratio(w, 30.0) == 0.75 and corrected(w, 0.6, 0.01) == 0.01
for version, pressure_mpa, factor in [(1, 0.08, 1.0), (2, 0.1, 1.5)]:
    tell(8, version, 40.0, [], pressure_mpa=pressure_mpa, reading_gain=1.5)
    assert reading_gain(w) == factor, pressure_mpa
w.gain = 0.8  # a setpoint was applied in this boot: the estimate may be older
assert abs(corrected(w, 0.6, 0.01) - 0.008) < 1e-12
print("all is well")
"#;
    let [_, _, estimates] = blocks();
    let script = format!("{BEFORE}{estimates}{AFTER}");
    let ran = std::process::Command::new(python()).args(["-c", &script]).output().unwrap();
    let (stdout, complaint) = (String::from_utf8_lossy(&ran.stdout), String::from_utf8_lossy(&ran.stderr));
    assert_eq!(stdout.trim(), "all is well", "{complaint}");
}
