//! `agent.toml`: one robot, its broker, and its drivers. docs/agent.md explains each key.

mod checks;
mod drivers;
mod file;
#[cfg(test)]
pub(crate) mod tests;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use serde::Deserialize;
use vibrissa_protocol::text_file::read_text;
use vibrissa_protocol::{AirControl, Name, OnSupervisorLoss, Software, SoftwareKind, plain};
use vibrissa_segmenter::Params;

use crate::contract::Facts;
use crate::mqtt::{BadBroker, Broker};
use checks::{arrays, limits, unfitting, whiskers};
use file::File;

/// Size limit of the file, bytes.
const FILE_BYTES_MAX: u64 = 1024 * 1024;

/// Why a configuration is refused.
#[derive(Debug, thiserror::Error)]
pub enum BadConfig {
    /// The file cannot be read.
    #[error("cannot read {path}: {}", plain::io(problem))]
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
    /// The drivers, at least one.
    pub drivers: Vec<DriverConfig>,
    /// Properties of the whiskers that the factsheet does not have.
    pub whiskers: BTreeMap<(Name, u16), WhiskerConfig>,
}

/// Properties of a whisker that the factsheet does not have.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct WhiskerConfig {
    /// The way in which a touch moves the strain; `None` if it is not known, or if it may be both.
    pub sign: Option<Sign>,
    /// Reading of its pressure sensor at an empty chamber, MPa.
    pub pressure_zero_mpa: f64,
}

/// The way in which a touch moves the strain that a driver sends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Sign {
    /// A touch makes it larger.
    Rises,
    /// A touch makes it smaller.
    Falls,
}

impl Sign {
    /// 1 or -1.
    #[must_use]
    pub fn factor(self) -> f64 {
        match self {
            Self::Rises => 1.0,
            Self::Falls => -1.0,
        }
    }
}

/// Bounds and times of the agent.
#[derive(Debug, Clone, PartialEq)]
pub struct Limits {
    /// Most contacts messages in the outbox.
    pub outbox_messages: usize,
    /// Most bytes of contacts messages in the outbox.
    pub outbox_bytes: usize,
    /// Most bytes of contacts on the disk, beyond those in memory.
    pub outbox_disk_bytes: u64,
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
    /// Temperature of contacts if the driver reports none, in degrees Celsius.
    pub temperature_c: f64,
    /// Parameters of the segmenter.
    pub segmenter: Params,
}

/// Times and tolerances of a driver, and of the chambers whose pressures it reads.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriverLimits {
    /// Time without a line after which the driver counts as silent, in microseconds.
    pub silent_us: u64,
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
    /// Whether the agent regulates the pressures with pulses of the valves.
    pub regulate: bool,
}

/// A driver and the way to it.
#[derive(Clone, PartialEq)]
pub struct DriverConfig {
    /// Subject of sentences about it, in logs: `the driver`, or `driver NAME`.
    pub label: String,
    /// The way to the driver.
    pub way: Way,
    /// Folder in which a child process starts.
    pub folder: PathBuf,
    /// The whiskers that it serves.
    pub whiskers: BTreeSet<(Name, u16)>,
    /// Times and tolerances.
    pub limits: DriverLimits,
    /// Whether a silent child process is killed and started again.
    pub restart: bool,
    /// The first line of a driver at a TCP port.
    pub token: Option<String>,
    /// File of the token, for warnings.
    pub token_file: Option<PathBuf>,
}

impl std::fmt::Debug for DriverConfig {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // Tokens stay out of logs.
        f.debug_struct("DriverConfig").field("way", &self.way).field("restart", &self.restart).finish_non_exhaustive()
    }
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

impl Config {
    /// Folder of the contacts that have no room in memory: beside the file of the outbox.
    #[must_use]
    pub fn spool(&self) -> Option<PathBuf> {
        let file = self.outbox_file.as_ref().filter(|_| self.limits.outbox_disk_bytes > 0)?;
        let mut name = file.clone().into_os_string();
        name.push(".spool");
        Some(PathBuf::from(name))
    }

    /// Reads a file. Paths in it are relative to its folder.
    ///
    /// # Errors
    /// The file, or a file that it names, cannot be read, or a key is invalid.
    pub fn read(path: &Path) -> Result<Self, BadConfig> {
        Self::from_toml_str(&text(path)?, path.parent().unwrap_or(Path::new("")))
    }

    /// Reads a file for a program that is the driver itself and connects to `socket`. The file needs no way to the driver;
    /// another way in it has no effect.
    ///
    /// # Errors
    /// Those of [`Config::read`], and several drivers.
    pub fn read_driven_at(path: &Path, socket: PathBuf) -> Result<Self, BadConfig> {
        let mut file = parsed(&text(path)?)?;
        file.driver.driven_at(socket)?;
        Self::checked(file, path.parent().unwrap_or(Path::new("")))
    }

    /// Reads a file of either kind; whether it names no way to a driver, so that only a program that is the driver itself
    /// can use it.
    ///
    /// # Errors
    /// Those of [`Config::read`] and [`Config::read_driven_at`].
    pub fn read_either(path: &Path) -> Result<(Self, bool), BadConfig> {
        if parsed(&text(path)?)?.driver.has_way() {
            return Ok((Self::read(path)?, false));
        }
        Ok((Self::read_driven_at(path, PathBuf::from("driver"))?, true))
    }

    /// Parses a configuration; paths in it are relative to `folder`.
    ///
    /// # Errors
    /// Those of [`Config::read`].
    pub fn from_toml_str(text: &str, folder: &Path) -> Result<Self, BadConfig> {
        Self::checked(parsed(text)?, folder)
    }

    fn checked(file: File, folder: &Path) -> Result<Self, BadConfig> {
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
        let outbox_file = file.outbox.file.map(|path| folder.join(path));
        let whiskers = whiskers(&file.arrays);
        let arrays = arrays(file.arrays)?;
        let drivers = file.driver.checked(folder, &arrays)?;
        check_air(file.air_control, file.on_supervisor_loss, &drivers)?;
        let facts = Facts {
            model: file.model,
            on_supervisor_loss: file.on_supervisor_loss,
            arrays,
            touch_tests: file.touch_tests,
            applies_gain: file.applies_gain,
            air_control: file.air_control,
            software: vec![agent_software()],
        };
        Ok(Self { fleet: file.fleet, robot: file.robot, facts, broker, limits, outbox_file, drivers, whiskers })
    }
}

/// A robot without air neither regulates nor changes the pressure when the supervisor is lost.
/// This program, as the factsheet names it.
fn agent_software() -> Software {
    let (name, version) = (env!("CARGO_PKG_NAME").to_owned(), env!("CARGO_PKG_VERSION").to_owned());
    Software { kind: SoftwareKind::Agent, name, version }
}

fn check_air(air: Option<AirControl>, loss: OnSupervisorLoss, drivers: &[DriverConfig]) -> Result<(), BadConfig> {
    let regulates = drivers.iter().any(|driver| driver.limits.regulate);
    if air == Some(AirControl::None) && (loss != OnSupervisorLoss::Hold || regulates) {
        return Err(unfitting(
            "air_control",
            "NONE allows neither another on_supervisor_loss than HOLD nor driver.regulate",
        ));
    }
    Ok(())
}

fn text(path: &Path) -> Result<String, BadConfig> {
    read_text(path, FILE_BYTES_MAX).map_err(|problem| BadConfig::Unreadable { path: path.to_owned(), problem })
}

/// An error names the line without its content, which may be a password in the wrong place.
fn parsed(text: &str) -> Result<File, BadConfig> {
    toml::from_str(text).map_err(|why| BadConfig::NotToml(plain::in_file(text, why.span(), why.message())))
}
