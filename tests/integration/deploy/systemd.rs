//! Checks of the systemd units of the supervisor and the agent with systemd-analyze.

use std::process::{Command, Output};

use tempfile::TempDir;

use crate::{PROGRAM, project};

/// Names of the programs, with their arguments.
const UNITS: [(&str, &str); 2] =
    [("vibrissa", "run --config /etc/vibrissa/vibrissa.toml"), ("vibrissa-robot", "--config /etc/vibrissa/agent.toml")];

/// The units, with the path of a program that exists.
fn units() -> (TempDir, Vec<String>) {
    let folder = tempfile::tempdir().unwrap();
    let unit = |(name, arguments)| {
        let text = std::fs::read_to_string(project().join(format!("deploy/systemd/{name}.service"))).unwrap();
        assert!(text.contains(&format!("ExecStart={name} {arguments}\n")));
        let path = folder.path().join(format!("{name}.service"));
        std::fs::write(&path, text.replace(&format!("={name} "), &format!("={PROGRAM} "))).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let units = UNITS.into_iter().map(unit).collect();
    (folder, units)
}

fn analyze(arguments: &[&str]) -> Output {
    let mut command = Command::new("systemd-analyze");
    command.args(arguments).output().expect("systemd-analyze must be installed for this test")
}

#[test]
fn the_unit_is_understood_without_a_warning() {
    let (_folder, units) = units();
    for unit in units {
        let ended = analyze(&["verify", "--man=no", &unit]);
        let said = String::from_utf8_lossy(&ended.stderr).into_owned();
        // Messages about other units of this machine are ignored.
        let ours: Vec<&str> = said.lines().filter(|line| line.contains("vibrissa")).collect();
        assert!(ended.status.success() && ours.is_empty(), "{said}");
    }
}

#[test]
fn the_unit_is_exposed_to_little() {
    let (_folder, units) = units();
    for unit in units {
        let ended = analyze(&["security", "--offline=true", "--threshold=20", "--no-pager", &unit]);
        assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stdout));
    }
}

fn text(path: &str) -> String {
    std::fs::read_to_string(project().join(path)).unwrap()
}

/// Five ends within 10 s, as with a full disk at the start of a robot, were the last.
#[test]
fn regress_systemd_never_gives_a_service_up() {
    for (name, _) in UNITS {
        let unit = text(&format!("deploy/systemd/{name}.service"));
        assert!(unit.contains("\nRestart=") && unit.contains("\nStartLimitIntervalSec=0\n"), "{name}");
    }
}

/// `systemd-analyze verify` takes any name. These are what drivers of Linux register: serial8250, usb-serial, cdc-acm and amba-pl011
/// (names of their terminals), i2c-dev ("i2c"), spidev ("spi") and gpiolib ("gpiochip").
#[test]
fn regress_devices_are_allowed_by_their_names_in_proc_devices() {
    let unit = text("deploy/systemd/vibrissa-robot.service");
    let allowed: Vec<&str> = unit.lines().filter_map(|line| line.strip_prefix("DeviceAllow=char-")).collect();
    let names = ["ttyS", "ttyUSB", "ttyACM", "ttyAMA", "i2c", "spi", "gpiochip"];
    assert_eq!(allowed, names.map(|name| format!("{name} rw")));
}

/// The agent could not make its socket: all but the unit's folders is read-only for it.
#[test]
fn regress_sockets_of_documents_and_launch_files_are_in_folders_of_the_unit() {
    let unit = text("deploy/systemd/vibrissa-robot.service");
    let folder = |key: &str| unit.lines().find_map(|line| line.strip_prefix(key)).unwrap();
    let allowed =
        [format!("/var/lib/{}/", folder("StateDirectory=")), format!("/run/{}/", folder("RuntimeDirectory="))];
    let launch = "robot/ros2/vibrissa_ros2/launch";
    let files = ["docs/ros2.md".to_owned(), format!("{launch}/robot.launch.py"), format!("{launch}/passive.launch.py")];
    let files: String = files.iter().map(|file| text(file)).collect();
    let sockets: Vec<&str> =
        files.split(['"', '`', ':']).filter(|word| word.starts_with('/') && word.ends_with(".sock")).collect();
    assert!(!sockets.is_empty());
    // Nodes run as another user than the service, whom its socket refuses.
    let passive = text(&format!("{launch}/passive.launch.py"));
    assert!(passive.contains("tcp:127.0.0.1") && passive.contains("\"agent_token_file\""), "{passive}");
    assert!(sockets.iter().all(|socket| allowed.iter().any(|folder| socket.starts_with(folder))), "{sockets:?}");
}
