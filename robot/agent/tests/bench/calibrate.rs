//! `vibrissa-robot calibrate` with a driver on a bench, and a person who does what the program asks.

use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use rustix::process::{Pid, Signal, kill_process};
use vibrissa_robot::Config;
use vibrissa_robot::config::Sign;
use vibrissa_robot::store::file::StoreFile;

use crate::driver::{Bench, Driver, Role, ZERO_MPA};

/// A folder with an agent.toml for a driver.
struct Desk {
    folder: PathBuf,
    driver: Driver,
}

impl Desk {
    fn new(name: &str, bench: Bench) -> Self {
        let folder = std::env::temp_dir().join(format!("vibrissa-calibrate-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).unwrap();
        let regulate = !bench.regulates;
        let driver = Driver::start(Role::Board, bench);
        let text = format!(
            "fleet = \"lab\"\nrobot = \"bench\"\n\n[broker]\nurl = \"mqtt://127.0.0.1\"\n\n[outbox]\nfile = \"outbox\"\n\n\
             [driver]\ntcp = \"{}\"\nregulate = {regulate}\n\n[[arrays]]\narray = \"left\"\ntype = \"TYPE_2\"\n\n\
             [[arrays.whiskers]]\nwhisker = 0   # the only one\nlength_mm = 70.0\npressure_mpa = 0.1\n\
             pressure_max_mpa = 0.2\nplace = \"TIP\"\n",
            driver.address
        );
        std::fs::write(folder.join("agent.toml"), text).unwrap();
        Self { folder, driver }
    }

    fn file(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    fn start(&self) -> Child {
        let mut command = Command::new(env!("CARGO_BIN_EXE_vibrissa-robot"));
        command.arg("calibrate").arg("--config").arg(self.file("agent.toml"));
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    }

    /// Does what the program asks until it ends; whether it succeeded, and all that it said.
    fn follow(&self, mut child: Child, mut at: impl FnMut(&str, &Child)) -> (bool, String) {
        let mut answers = child.stdin.take().unwrap();
        let mut said = String::new();
        for line in BufReader::new(child.stdout.take().unwrap()).lines().map_while(Result::ok) {
            at(&line, &child);
            let (depth_mm, base_mm) = match () {
                () if line.contains("Leave the whisker alone") => (None, None),
                () if line.contains("touch the whisker at its tip") => (Some(1.5), None),
                () if line.contains("deflect the whisker slowly") => (Some(4.0), None),
                () if line.contains("Move the base to one end") => (None, Some(2.0)),
                () if line.contains("Move it to the other end") => (None, Some(32.5)),
                () if line.contains("[y/n]") => (None, None),
                () => {
                    said.push_str(&line);
                    said.push('\n');
                    continue;
                }
            };
            // A driver without a link says nothing.
            if depth_mm.is_some() || base_mm.is_some() {
                self.driver.change(|bench| {
                    bench.base_mm = base_mm.unwrap_or(bench.base_mm);
                    depth_mm.into_iter().for_each(|depth_mm| bench.touch(depth_mm));
                });
            }
            // A program that was stopped reads no answer.
            let _ = answers.write_all(b"y\n");
        }
        let ended = child.wait_with_output().unwrap();
        said.push_str(&String::from_utf8_lossy(&ended.stderr));
        (ended.status.success(), said)
    }

    fn config(&self) -> Config {
        Config::read(&self.file("agent.toml")).unwrap()
    }
}

impl Drop for Desk {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

fn has_lines(said: &str, lines: &[&str]) {
    for line in lines {
        assert!(said.contains(line), "{line}\nis not in\n{said}");
    }
}

#[test]
fn a_whisker_is_calibrated_step_by_step_and_the_file_is_written() {
    let desk = Desk::new("whole", Bench { end: 0.012, ..Bench::new() });
    let (succeeded, said) = desk.follow(desk.start(), |_, _| {});
    assert!(succeeded, "{said}");
    has_lines(
        &said,
        &[
            "left/0: 6 of 6 steps.",
            "left/0 gauge's zero 0.001 m/m - good",
            "left/0 rate of the strain",
            "left/0 sign FALLS - good",
            "left/0 way of the base in the touch 1.",
            "left/0 largest strain 0.012 m/m - BAD: the converter or the amplifier ends there",
            "left/0 travel of the base 30.5 mm - good",
            "left/0 pressure sensor's zero -0.00037 MPa - good",
            "left/0 fill valve",
            "from a pulse of 40 ms to the first reading that has moved; readings come every",
            "left/0 vent valve",
            "All chambers are empty, and all valves are closed.",
            "agent.toml is written. Start the agent.",
        ],
    );
    let config = desk.config();
    let whisker = config.whiskers.values().next().unwrap();
    assert_eq!((whisker.sign, whisker.pressure_zero_mpa), (Some(Sign::Falls), ZERO_MPA));
    let strain_max = config.facts.arrays[0].whiskers[0].strain_max.unwrap();
    assert!((strain_max - 0.012).abs() < 1e-5, "{strain_max}");
    let text = std::fs::read_to_string(desk.file("agent.toml")).unwrap();
    assert!(text.contains("whisker = 0   # the only one\n") && text.contains("segmenter.sign = \"FALLS\"\n"), "{text}");
    assert!(!desk.file("agent.toml.calibration").exists());
    desk.driver.until(Bench::is_safe);
    desk.driver.look(|bench| {
        assert!(bench.highest_mpa > 0.001 && bench.highest_mpa < 0.04, "a fifth of 0.2 MPa: {}", bench.highest_mpa);
        assert_eq!(bench.heard[0]["type"], "hello");
        assert!(bench.heard.iter().all(|line| line["type"] != "set_pressure" || line["pressure_mpa"] == 0.0));
    });
}

#[test]
fn after_a_signal_the_chamber_is_vented_and_the_calibration_goes_on_later() {
    let desk = Desk::new("stopped", Bench { per_mm: 0.004, ..Bench::new() });
    let (succeeded, said) = desk.follow(desk.start(), |line, child| {
        if line.contains("pressure sensor's zero") {
            desk.driver.until(|bench| bench.pressure_mpa > 0.0);
            kill_process(Pid::from_child(child), Signal::INT).unwrap();
        }
    });
    assert!(!succeeded, "{said}");
    has_lines(
        &said,
        &["left/0 sign RISES - good", "All chambers are empty", "it was stopped", "start the command again"],
    );
    desk.driver.until(Bench::is_safe);
    assert_eq!(desk.config().whiskers.values().next().unwrap().sign, None, "nothing is written yet");
    let (succeeded, said) = desk.follow(desk.start(), |_, _| {});
    assert!(succeeded && !said.contains(" sign RISES - "), "{said}");
    has_lines(&said, &["left/0: 1 of 6 steps.", "left/0 vent valve", "left/0: segmenter.sign = \"RISES\""]);
    assert_eq!(desk.config().whiskers.values().next().unwrap().sign, Some(Sign::Rises));
}

#[test]
fn a_driver_with_a_regulator_is_asked_for_a_tenth_of_the_highest_pressure() {
    let desk = Desk::new("regulated", Bench { regulates: true, ..Bench::new() });
    let (succeeded, said) = desk.follow(desk.start(), |_, _| {});
    assert!(succeeded, "{said}");
    has_lines(&said, &["from the order to the driver's regulator to the first reading", "left/0 vent valve"]);
    desk.driver.until(Bench::is_safe);
    desk.driver.look(|bench| assert!((0.001..0.0201).contains(&bench.highest_mpa), "{}", bench.highest_mpa));
}

#[test]
fn without_answers_or_beside_an_agent_nothing_is_moved() {
    let desk = Desk::new("alone", Bench::new());
    let refused = |lock: &Path| {
        let _held = StoreFile::lock(lock).unwrap();
        let ended = desk.start().wait_with_output().unwrap();
        String::from_utf8(ended.stderr).unwrap()
    };
    let said = refused(&desk.file("outbox"));
    assert!(said.contains("end the agent first") && said.contains("in use by another agent"), "{said}");
    desk.driver.look(|bench| assert_eq!(bench.heard.len(), 0));
    // `wait_with_output` closes the standard input.
    let ended = desk.start().wait_with_output().unwrap();
    let said = String::from_utf8(ended.stderr).unwrap();
    assert!(!ended.status.success() && said.contains("no answer comes any more"), "{said}");
    desk.driver.until(Bench::is_safe);
    desk.driver.look(|bench| assert!(bench.highest_mpa == 0.0, "{}", bench.highest_mpa));
}

/// An empty chamber counted as one that does not empty, and a step of the converter as air.
#[test]
fn regress_the_steps_of_a_coarse_converter_are_neither_air_nor_a_chamber_that_does_not_empty() {
    for is_shut in [false, true] {
        let bench = Bench { step_mpa: 0.001_22, is_shut, ..Bench::new() };
        let desk = Desk::new(if is_shut { "shut" } else { "coarse" }, bench);
        let (succeeded, said) = desk.follow(desk.start(), |_, _| {});
        assert!(succeeded, "{said}");
        let zero = said.lines().find_map(|line| line.strip_prefix("left/0 pressure sensor's zero ")).unwrap();
        let zero_mpa: f64 = zero.split(' ').next().unwrap().parse().unwrap();
        assert!(zero.ends_with("above or below 0") && (zero_mpa - ZERO_MPA).abs() < 0.001_22, "{zero}");
        let valves = if is_shut {
            ["left/0 fill valve - BAD: the pressure did not rise"; 2]
        } else {
            ["from a pulse of ", "left/0 vent valve "]
        };
        has_lines(&said, &valves);
        assert!(is_shut || !said.contains("valve - BAD"), "{said}");
    }
}

/// Both refused the file of a robot in Python, which names no way to a driver.
#[test]
fn regress_a_file_of_a_program_that_is_the_driver_is_checked_and_calibrate_says_what_it_lacks() {
    let desk = Desk::new("driven", Bench::new());
    let text = std::fs::read_to_string(desk.file("agent.toml")).unwrap();
    let driven: String =
        text.lines().filter(|line| !line.starts_with("tcp = ")).map(|line| format!("{line}\n")).collect();
    std::fs::write(desk.file("agent.toml"), driven.replace("regulate = true", "silent_s = 2.0")).unwrap();
    let run = |argument: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_vibrissa-robot"));
        let ended = command.arg(argument).arg("--config").arg(desk.file("agent.toml")).output().unwrap();
        let said = [ended.stdout, ended.stderr].map(|said| String::from_utf8(said).unwrap()).concat();
        (ended.status.success(), said)
    };
    let (is_good, said) = run("--check");
    assert!(is_good && said.contains("robot bench of fleet lab is well configured"), "{said}");
    assert!(said.contains("vibrissa-robot itself does not start with it"), "{said}");
    let (is_good, said) = run("calibrate");
    assert!(!is_good && said.contains("the robot's program is the driver. End it, and name a way"), "{said}");
    std::fs::write(desk.file("agent.toml"), driven.replace("regulate = true", "regulate = true\nsilent_s = 0.0"))
        .unwrap();
    let (is_good, said) = run("--check");
    assert!(!is_good && said.contains("driver.silent_s is 0"), "{said}");
}
