//! `agent.toml`: one robot, its broker, and its driver. docs/agent.md explains each key.

use std::collections::BTreeSet;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use vibrissa_protocol::{
    ARRAYS_MAX, ArrayFacts, ArrayType, CONTACTS_MAX, Name, OnSupervisorLoss, PlaceKind, Task, TouchTestKind,
    WHISKERS_MAX, WhiskerFacts,
};

use vibrissa_segmenter::Params;

use crate::contract::Facts;
use crate::mqtt::{Authorities, BadBroker, Broker, ClientCertificate, password_in};

/// Why a configuration is refused.
#[derive(Debug, thiserror::Error)]
pub enum BadConfig {
    /// The file cannot be read.
    #[error("cannot read {path}: {problem}")]
    Unreadable {
        /// Path of the file.
        path: PathBuf,
        /// The error of the operating system.
        problem: std::io::Error,
    },
    /// The text is no TOML, or has an unknown or a missing key.
    #[error("{0}")]
    NotToml(String),
    /// A number is outside its range.
    #[error("{key} is {value}, but must be between {least} and {most}")]
    OutOfRange {
        /// The key.
        key: String,
        /// Its value.
        value: f64,
        /// The least permitted value.
        least: f64,
        /// The largest permitted value.
        most: f64,
    },
    /// A value does not fit the rest.
    #[error("{key}: {problem}")]
    Unfitting {
        /// The key.
        key: String,
        /// The problem.
        problem: String,
    },
    /// The broker cannot be used.
    #[error("broker: {0}")]
    Broker(#[from] BadBroker),
}

/// The whole configuration.
#[derive(Debug, Clone, PartialEq)]
pub struct Config {
    /// Name of the fleet.
    pub fleet: Name,
    /// Name of the robot.
    pub robot: Name,
    /// Properties for the factsheet.
    pub facts: Facts,
    /// The broker.
    pub broker: Broker,
    /// Bounds and times.
    pub limits: Limits,
    /// File of the outbox, if it shall survive a restart.
    pub outbox_file: Option<PathBuf>,
    /// The driver.
    pub driver: DriverConfig,
}

/// Bounds and times of the agent.
#[derive(Debug, Clone, PartialEq)]
pub struct Limits {
    /// Most contacts messages in the outbox.
    pub outbox_messages: usize,
    /// Most bytes of contacts messages in the outbox.
    pub outbox_bytes: usize,
    /// Contacts in a message, after which it is sent.
    pub contacts_per_message: usize,
    /// Age of its first contact after which a message is sent, in microseconds.
    pub message_after_us: u64,
    /// Most contacts a second; more are refused.
    pub contacts_per_s: f64,
    /// Time between two statuses, in microseconds.
    pub status_every_us: u64,
    /// Time without a message after which the supervisor counts as lost, in microseconds.
    pub supervisor_lost_after_us: u64,
    /// Time without a line after which the driver counts as silent, in microseconds.
    pub driver_silent_us: u64,
    /// Time after which `set_pressure` is repeated, in microseconds.
    pub repeat_us: u64,
    /// Largest deviation of a chamber that has its pressure, in MPa.
    pub tolerance_mpa: f64,
    /// Time within that deviation after which a setpoint is applied, in microseconds.
    pub settle_us: u64,
    /// Time beyond that of the slew after which a setpoint has failed, in microseconds.
    pub fail_after_us: u64,
    /// Slew of pressure changes without a command, in MPa/s.
    pub own_slew_mpa_per_s: f64,
    /// Temperature of contacts if the driver reports none, in degrees Celsius.
    pub temperature_c: f64,
    /// Whether the agent regulates the pressures with pulses of the valves.
    pub regulate: bool,
    /// Parameters of the segmenter.
    pub segmenter: Params,
}

/// The driver and the way to it.
#[derive(Debug, Clone, PartialEq)]
pub struct DriverConfig {
    /// The way to the driver.
    pub way: Way,
    /// Whether a silent child process is killed and started again.
    pub restart: bool,
}

/// The way to the driver.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Way {
    /// A child process: program and arguments.
    Command(Vec<String>),
    /// A Unix socket at which the agent listens.
    Unix(PathBuf),
    /// An address to which the agent connects.
    Tcp(String),
    /// A loopback address at which the agent listens.
    Listen(String),
    /// A serial device and its speed in baud.
    Serial(PathBuf, u32),
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    fleet: Name,
    robot: Name,
    #[serde(default = "default_model")]
    model: String,
    #[serde(default = "default_on_supervisor_loss")]
    on_supervisor_loss: OnSupervisorLoss,
    #[serde(default)]
    touch_tests: Vec<TouchTestKind>,
    broker: FileBroker,
    #[serde(default)]
    outbox: FileOutbox,
    #[serde(default)]
    contacts: FileContacts,
    #[serde(default)]
    segmenter: FileSegmenter,
    #[serde(default)]
    supervisor: FileSupervisor,
    driver: FileDriver,
    arrays: Vec<FileArray>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct FileBroker {
    url: String,
    username: Option<String>,
    password_file: Option<PathBuf>,
    ca_file: Option<PathBuf>,
    client_certificate_file: Option<PathBuf>,
    client_key_file: Option<PathBuf>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct FileOutbox {
    file: Option<PathBuf>,
    messages: usize,
    bytes: usize,
}

impl Default for FileOutbox {
    fn default() -> Self {
        Self { file: None, messages: 10_000, bytes: 1 << 20 }
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct FileContacts {
    per_message: usize,
    message_after_s: f64,
    per_s_max: f64,
    temperature_c: f64,
}

impl Default for FileContacts {
    fn default() -> Self {
        Self { per_message: 50, message_after_s: 0.1, per_s_max: 2000.0, temperature_c: 24.0 }
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct FileSegmenter {
    least_strain: f64,
    strain_limit: f64,
    baseline_s: f64,
    longest_s: f64,
}

impl Default for FileSegmenter {
    fn default() -> Self {
        let Params { least_strain, strain_limit, baseline_s, longest_s, .. } = Params::default();
        Self { least_strain, strain_limit, baseline_s, longest_s }
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct FileSupervisor {
    lost_after_s: f64,
    status_every_s: f64,
}

impl Default for FileSupervisor {
    fn default() -> Self {
        Self { lost_after_s: 60.0, status_every_s: 2.0 }
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct FileDriver {
    command: Option<Vec<String>>,
    unix: Option<PathBuf>,
    tcp: Option<String>,
    listen: Option<String>,
    serial: Option<PathBuf>,
    baud: Option<u32>,
    #[serde(default = "default_restart")]
    restart: bool,
    #[serde(default)]
    regulate: bool,
    #[serde(default = "default_silent_s")]
    silent_s: f64,
    #[serde(default = "default_repeat_s")]
    repeat_s: f64,
    #[serde(default = "default_tolerance_mpa")]
    tolerance_mpa: f64,
    #[serde(default = "default_settle_s")]
    settle_s: f64,
    #[serde(default = "default_fail_after_s")]
    fail_after_s: f64,
    #[serde(default = "default_own_slew")]
    own_slew_mpa_per_s: f64,
}

fn default_model() -> String {
    "robot".to_owned()
}
fn default_on_supervisor_loss() -> OnSupervisorLoss {
    OnSupervisorLoss::Hold
}
fn default_restart() -> bool {
    true
}
fn default_silent_s() -> f64 {
    5.0
}
fn default_repeat_s() -> f64 {
    2.0
}
fn default_tolerance_mpa() -> f64 {
    0.003
}
fn default_settle_s() -> f64 {
    0.5
}
fn default_fail_after_s() -> f64 {
    6.0
}
fn default_own_slew() -> f64 {
    0.02
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct FileArray {
    array: Name,
    #[serde(rename = "type")]
    array_type: ArrayType,
    task: Option<Task>,
    whiskers: Vec<FileWhisker>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct FileWhisker {
    whisker: u16,
    #[serde(default)]
    x_mm: f64,
    #[serde(default)]
    y_mm: f64,
    #[serde(default = "default_whisker_model")]
    model: String,
    length_mm: f64,
    pressure_mpa: f64,
    pressure_max_mpa: f64,
    #[serde(default)]
    neighbours: Vec<u16>,
    place: Option<PlaceKind>,
}

fn default_whisker_model() -> String {
    "nguyen-2021".to_owned()
}

type Checked = Result<(), BadConfig>;

fn within(key: impl Into<String>, value: f64, range: RangeInclusive<f64>) -> Checked {
    if range.contains(&value) {
        return Ok(());
    }
    Err(BadConfig::OutOfRange { key: key.into(), value, least: *range.start(), most: *range.end() })
}

fn unfitting(key: impl Into<String>, problem: impl Into<String>) -> BadConfig {
    BadConfig::Unfitting { key: key.into(), problem: problem.into() }
}

fn us(seconds: f64) -> u64 {
    (seconds * 1e6) as u64
}

impl Config {
    /// Reads a file. Paths in it are relative to its folder.
    ///
    /// # Errors
    /// The file, or a file that it names, cannot be read, or a key is invalid.
    pub fn read(path: &Path) -> Result<Self, BadConfig> {
        let text = std::fs::read_to_string(path)
            .map_err(|problem| BadConfig::Unreadable { path: path.to_owned(), problem })?;
        Self::from_toml_str(&text, path.parent().unwrap_or(Path::new("")))
    }

    /// Parses a configuration; paths in it are relative to `folder`.
    ///
    /// # Errors
    /// Those of [`Config::read`].
    pub fn from_toml_str(text: &str, folder: &Path) -> Result<Self, BadConfig> {
        let file: File = toml::from_str(text).map_err(|why| not_toml(text, &why))?;
        if file.robot.as_str() == Name::RESERVED {
            return Err(unfitting("robot", "this name is reserved for the supervisor"));
        }
        if !(1..=64).contains(&file.model.chars().count()) || file.model.chars().any(char::is_control) {
            return Err(unfitting("model", "must have 1 to 64 characters, none of them a control character"));
        }
        if file.touch_tests.iter().collect::<BTreeSet<_>>().len() < file.touch_tests.len() {
            return Err(unfitting("touch_tests", "names a test twice"));
        }
        let limits = limits(&file)?;
        let broker = file.broker.checked(folder)?;
        let driver = file.driver.checked(folder)?;
        let outbox_file = file.outbox.file.map(|path| folder.join(path));
        let arrays = arrays(file.arrays)?;
        let facts = Facts {
            model: file.model,
            on_supervisor_loss: file.on_supervisor_loss,
            arrays,
            touch_tests: file.touch_tests,
        };
        Ok(Self { fleet: file.fleet, robot: file.robot, facts, broker, limits, outbox_file, driver })
    }
}

/// Names the line without its content, which may be a password in the wrong place.
fn not_toml(text: &str, why: &toml::de::Error) -> BadConfig {
    let line = why.span().and_then(|span| text.get(..span.start)).map(|before| before.matches('\n').count() + 1);
    let place = line.map(|line| format!("line {line}: ")).unwrap_or_default();
    BadConfig::NotToml(format!("{place}{}", why.message()))
}

fn limits(file: &File) -> Result<Limits, BadConfig> {
    let (outbox, contacts, supervisor, driver) = (&file.outbox, &file.contacts, &file.supervisor, &file.driver);
    within("outbox.messages", outbox.messages as f64, 1.0..=1e6)?;
    within("outbox.bytes", outbox.bytes as f64, 65_536.0..=1e9)?;
    within("contacts.per_message", contacts.per_message as f64, 1.0..=CONTACTS_MAX.min(500) as f64)?;
    within("contacts.message_after_s", contacts.message_after_s, 0.01..=60.0)?;
    within("contacts.per_s_max", contacts.per_s_max, 1.0..=10_000.0)?;
    within("contacts.temperature_c", contacts.temperature_c, -100.0..=300.0)?;
    let segmenter = &file.segmenter;
    within("segmenter.least_strain", segmenter.least_strain, 0.0..=0.1)?;
    within("segmenter.strain_limit", segmenter.strain_limit, 1e-4..=1.0)?;
    within("segmenter.baseline_s", segmenter.baseline_s, 0.1..=60.0)?;
    within("segmenter.longest_s", segmenter.longest_s, 1.0..=600.0)?;
    within("supervisor.lost_after_s", supervisor.lost_after_s, 1.0..=86_400.0)?;
    within("supervisor.status_every_s", supervisor.status_every_s, 1.0..=10.0)?;
    within("driver.silent_s", driver.silent_s, 0.5..=600.0)?;
    within("driver.repeat_s", driver.repeat_s, 0.1..=60.0)?;
    within("driver.tolerance_mpa", driver.tolerance_mpa, 1e-5..=0.005)?;
    within("driver.settle_s", driver.settle_s, 0.05..=60.0)?;
    within("driver.fail_after_s", driver.fail_after_s, 0.5..=600.0)?;
    within("driver.own_slew_mpa_per_s", driver.own_slew_mpa_per_s, 1e-5..=10.0)?;
    Ok(Limits {
        outbox_messages: outbox.messages,
        outbox_bytes: outbox.bytes,
        contacts_per_message: contacts.per_message,
        message_after_us: us(contacts.message_after_s),
        contacts_per_s: contacts.per_s_max,
        status_every_us: us(supervisor.status_every_s),
        supervisor_lost_after_us: us(supervisor.lost_after_s),
        driver_silent_us: us(driver.silent_s),
        repeat_us: us(driver.repeat_s),
        tolerance_mpa: driver.tolerance_mpa,
        settle_us: us(driver.settle_s),
        fail_after_us: us(driver.fail_after_s),
        own_slew_mpa_per_s: driver.own_slew_mpa_per_s,
        temperature_c: contacts.temperature_c,
        regulate: driver.regulate,
        segmenter: Params {
            least_strain: segmenter.least_strain,
            strain_limit: segmenter.strain_limit,
            baseline_s: segmenter.baseline_s,
            longest_s: segmenter.longest_s,
            ..Params::default()
        },
    })
}

impl FileBroker {
    fn checked(&self, folder: &Path) -> Result<Broker, BadConfig> {
        let mut broker = Broker::from_url(&self.url)?;
        if let Some(path) = &self.ca_file {
            if broker.tls.is_none() {
                return Err(unfitting("broker.ca_file", "requires mqtts:// in broker.url"));
            }
            broker.tls = Some(Authorities::File(folder.join(path)));
        }
        broker.client = match (&self.client_certificate_file, &self.client_key_file) {
            (None, None) => None,
            (Some(_), Some(_)) if self.ca_file.is_none() => {
                return Err(unfitting("broker.client_certificate_file", "needs broker.ca_file"));
            }
            (Some(certificate), Some(key)) => {
                Some(ClientCertificate { certificate_file: folder.join(certificate), key_file: folder.join(key) })
            }
            (Some(_), None) => {
                return Err(unfitting("broker.client_certificate_file", "needs broker.client_key_file"));
            }
            (None, Some(_)) => {
                return Err(unfitting("broker.client_key_file", "needs broker.client_certificate_file"));
            }
        };
        broker.password_file = self.password_file.as_ref().map(|path| folder.join(path));
        broker.credentials = match (&self.username, &broker.password_file) {
            (None, None) => None,
            (Some(user), Some(path)) => Some((user.clone(), password_in(path)?)),
            (Some(_), None) => return Err(unfitting("broker.username", "needs broker.password_file")),
            (None, Some(_)) => return Err(unfitting("broker.password_file", "needs broker.username")),
        };
        Ok(broker)
    }
}

impl FileDriver {
    fn checked(self, folder: &Path) -> Result<DriverConfig, BadConfig> {
        if self.baud.is_some() && self.serial.is_none() {
            return Err(unfitting("driver.baud", "needs driver.serial"));
        }
        let mut ways = Vec::new();
        ways.extend(self.command.map(Way::Command));
        ways.extend(self.unix.map(|path| Way::Unix(folder.join(path))));
        ways.extend(self.tcp.map(Way::Tcp));
        ways.extend(self.listen.map(Way::Listen));
        ways.extend(self.serial.map(|path| Way::Serial(path, self.baud.unwrap_or(115_200))));
        let (Some(way), None) = (ways.pop(), ways.pop()) else {
            return Err(unfitting("driver", "needs exactly one of command, unix, tcp, listen and serial"));
        };
        match &way {
            Way::Command(words) if words.first().is_none_or(String::is_empty) => {
                return Err(unfitting("driver.command", "must begin with a program"));
            }
            Way::Listen(address) => {
                let address: Option<std::net::SocketAddr> = address.parse().ok();
                if !address.is_some_and(|address| address.ip().is_loopback()) {
                    return Err(unfitting("driver.listen", "must be a loopback address and a port, as 127.0.0.1:5555"));
                }
            }
            Way::Command(_) | Way::Unix(_) | Way::Tcp(_) | Way::Serial(..) => {}
        }
        Ok(DriverConfig { way, restart: self.restart })
    }
}

fn arrays(arrays: Vec<FileArray>) -> Result<Vec<ArrayFacts>, BadConfig> {
    within("number of arrays", arrays.len() as f64, 1.0..=ARRAYS_MAX as f64)?;
    let mut names = BTreeSet::new();
    let mut facts = Vec::with_capacity(arrays.len());
    for array in arrays {
        let place = format!("array {}", array.array);
        if !names.insert(array.array.clone()) {
            return Err(unfitting(place, "occurs more than once"));
        }
        within(format!("{place}: number of whiskers"), array.whiskers.len() as f64, 1.0..=WHISKERS_MAX as f64)?;
        let numbers: BTreeSet<u16> = array.whiskers.iter().map(|whisker| whisker.whisker).collect();
        if numbers.len() < array.whiskers.len() {
            return Err(unfitting(place, "has two whiskers with one number"));
        }
        let whiskers = array.whiskers.into_iter().map(|whisker| whisker.checked(&place, &numbers));
        facts.push(ArrayFacts {
            array: array.array,
            array_type: array.array_type,
            task: array.task,
            whiskers: whiskers.collect::<Result<_, _>>()?,
        });
    }
    Ok(facts)
}

impl FileWhisker {
    fn checked(self, array: &str, numbers: &BTreeSet<u16>) -> Result<WhiskerFacts, BadConfig> {
        let key = |name: &str| format!("{array} whisker {} {name}", self.whisker);
        within(key("x_mm"), self.x_mm, -100_000.0..=100_000.0)?;
        within(key("y_mm"), self.y_mm, -100_000.0..=100_000.0)?;
        within(key("length_mm"), self.length_mm, 1.0..=1000.0)?;
        within(key("pressure_max_mpa"), self.pressure_max_mpa, 0.0..=0.2)?;
        within(key("pressure_mpa"), self.pressure_mpa, 0.0..=self.pressure_max_mpa)?;
        if !(1..=64).contains(&self.model.chars().count()) || self.model.chars().any(char::is_control) {
            return Err(unfitting(key("model"), "must have 1 to 64 characters, none of them a control character"));
        }
        for neighbour in &self.neighbours {
            if *neighbour == self.whisker || !numbers.contains(neighbour) {
                return Err(unfitting(key("neighbours"), format!("{neighbour} is not another whisker of this array")));
            }
        }
        Ok(WhiskerFacts {
            whisker: self.whisker,
            x_mm: self.x_mm,
            y_mm: self.y_mm,
            model: self.model,
            length_mm: self.length_mm,
            pressure_mpa: self.pressure_mpa,
            pressure_max_mpa: self.pressure_max_mpa,
            neighbours: self.neighbours,
            place: self.place,
        })
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) const EXAMPLE: &str = r#"
        fleet = "lab"
        robot = "crawler"
        touch_tests = ["WALL"]
        [broker]
        url = "mqtt://127.0.0.1"
        [driver]
        command = ["python3", "driver.py"]
        [[arrays]]
        array = "left"
        type = "TYPE_1"
        whiskers = [
            { whisker = 0, length_mm = 70.0, pressure_mpa = 0.1, pressure_max_mpa = 0.2, neighbours = [1] },
            { whisker = 1, length_mm = 70.0, pressure_mpa = 0.1, pressure_max_mpa = 0.2 },
        ]
        "#;

    #[test]
    fn the_smallest_configuration_has_the_defaults() {
        let config = Config::from_toml_str(EXAMPLE, Path::new("/etc/x")).unwrap();
        assert_eq!(config.driver.way, Way::Command(vec!["python3".to_owned(), "driver.py".to_owned()]));
        assert_eq!((config.limits.outbox_bytes, config.limits.driver_silent_us), (1 << 20, 5_000_000));
        assert_eq!(config.facts.arrays[0].whiskers.len(), 2);
    }

    #[test]
    fn a_password_in_the_wrong_place_is_not_shown() {
        let text = EXAMPLE.replacen("url = ", "password = \"hunter2\"\nurl = ", 1);
        let problem = Config::from_toml_str(&text, Path::new("")).unwrap_err().to_string();
        assert!(problem.starts_with("line 6: unknown field `password`"), "{problem}");
        assert!(!problem.contains("hunter2"), "{problem}");
    }

    #[test]
    fn a_wrong_key_is_named() {
        for (from, to, named) in [
            ("robot =", "robbot =", "robbot"),
            ("pressure_max_mpa = 0.2 }", "pressure_max_mpa = 0.3 }", "array left whisker 1 pressure_max_mpa is 0.3"),
            (
                "length_mm = 70.0, pressure_mpa = 0.1",
                "length_mm = nan, pressure_mpa = 0.1",
                "whisker 0 length_mm is NaN",
            ),
            ("neighbours = [1]", "neighbours = [2]", "whisker 0 neighbours: 2 is not another whisker"),
            ("mqtt://127", "ftp://127", "broker: invalid broker URL"),
            ("command = [\"python3\", \"driver.py\"]", "", "exactly one of command"),
            ("command = [\"python3\", \"driver.py\"]", "listen = \"0.0.0.0:1\"", "driver.listen: must be a loopback"),
            ("[driver]", "[driver]\nsilent_s = 0.1", "driver.silent_s is 0.1, but must be between 0.5 and 600"),
            ("[driver]", "[driver]\nbaud = 9600", "driver.baud: needs driver.serial"),
            ("[driver]", "[outbox]\nbytes = 5\n[driver]", "outbox.bytes is 5"),
            ("url = ", "username = \"u\"\nurl = ", "broker.username: needs broker.password_file"),
            ("url = ", "ca_file = \"c\"\nurl = ", "broker.ca_file: requires mqtts://"),
            (
                "url = ",
                "client_key_file = \"k\"\nurl = ",
                "broker.client_key_file: needs broker.client_certificate_file",
            ),
            (
                "url = ",
                "client_certificate_file = \"c\"\nclient_key_file = \"k\"\nurl = ",
                "broker.client_certificate_file: needs broker.ca_file",
            ),
            (
                "url = ",
                "username = \"u\"\npassword_file = \"/no/such\"\nurl = ",
                "broker: cannot read the password from /no/such",
            ),
            ("\"WALL\"", "\"WALL\", \"WALL\"", "touch_tests: names a test twice"),
            ("\"crawler\"", "\"supervisor\"", "robot"),
        ] {
            let text = EXAMPLE.replacen(from, to, 1);
            assert_ne!(text, EXAMPLE);
            let problem = Config::from_toml_str(&text, Path::new("")).expect_err(named).to_string();
            assert!(problem.contains(named), "{named}: {problem}");
        }
    }
}
