//! The keys of `agent.toml`, with their defaults.

use std::path::PathBuf;

use serde::de::value::MapAccessDeserializer;
use serde::de::{MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};
use vibrissa_protocol::{AirControl, ArrayType, Name, OnSupervisorLoss, PlaceKind, Task, TouchTestKind};
use vibrissa_segmenter::Params;

use super::Sign;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct File {
    pub(super) fleet: Name,
    pub(super) robot: Name,
    #[serde(default = "default_model")]
    pub(super) model: String,
    #[serde(default = "default_on_supervisor_loss")]
    pub(super) on_supervisor_loss: OnSupervisorLoss,
    #[serde(default)]
    pub(super) touch_tests: Vec<TouchTestKind>,
    #[serde(default)]
    pub(super) applies_gain: bool,
    pub(super) air_control: Option<AirControl>,
    pub(super) broker: FileBroker,
    #[serde(default)]
    pub(super) outbox: FileOutbox,
    #[serde(default)]
    pub(super) contacts: FileContacts,
    #[serde(default)]
    pub(super) segmenter: FileSegmenter,
    #[serde(default)]
    pub(super) supervisor: FileSupervisor,
    #[serde(default)]
    pub(super) driver: Drivers,
    pub(super) arrays: Vec<FileArray>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FileBroker {
    pub(super) url: String,
    pub(super) username: Option<String>,
    pub(super) password_file: Option<PathBuf>,
    pub(super) ca_file: Option<PathBuf>,
    pub(super) client_certificate_file: Option<PathBuf>,
    pub(super) client_key_file: Option<PathBuf>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct FileOutbox {
    pub(super) file: Option<PathBuf>,
    pub(super) messages: usize,
    pub(super) bytes: usize,
    pub(super) disk_bytes: u64,
}

impl Default for FileOutbox {
    fn default() -> Self {
        Self { file: None, messages: 10_000, bytes: 1 << 20, disk_bytes: 1 << 30 }
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct FileContacts {
    pub(super) per_message: usize,
    pub(super) message_after_s: f64,
    pub(super) per_s_max: f64,
    pub(super) temperature_c: f64,
}

impl Default for FileContacts {
    fn default() -> Self {
        Self { per_message: 50, message_after_s: 0.1, per_s_max: 2000.0, temperature_c: 24.0 }
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct FileSegmenter {
    pub(super) least_strain: f64,
    pub(super) strain_limit: f64,
    pub(super) baseline_s: f64,
    pub(super) longest_s: f64,
}

impl Default for FileSegmenter {
    fn default() -> Self {
        let Params { least_strain, strain_limit, baseline_s, longest_s, .. } = Params::default();
        Self { least_strain, strain_limit, baseline_s, longest_s }
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct FileSupervisor {
    pub(super) lost_after_s: f64,
    pub(super) status_every_s: f64,
}

impl Default for FileSupervisor {
    fn default() -> Self {
        Self { lost_after_s: 60.0, status_every_s: 2.0 }
    }
}

/// One `[driver]`, or several `[[driver]]`; none if the file has no such key.
#[derive(Debug, Default)]
pub(super) struct Drivers {
    pub(super) drivers: Vec<FileDriver>,
    /// Whether it is a list: then errors name the position.
    pub(super) is_list: bool,
}

impl<'de> Deserialize<'de> for Drivers {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(DriversVisitor)
    }
}

/// An untagged enumeration would hide which key is wrong.
struct DriversVisitor;

impl<'de> Visitor<'de> for DriversVisitor {
    type Value = Drivers;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("a table [driver], or a list of tables [[driver]]")
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Drivers, A::Error> {
        let driver = FileDriver::deserialize(MapAccessDeserializer::new(map))?;
        Ok(Drivers { drivers: vec![driver], is_list: false })
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Drivers, A::Error> {
        let mut drivers = Vec::new();
        while let Some(driver) = list.next_element()? {
            drivers.push(driver);
        }
        Ok(Drivers { drivers, is_list: true })
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FileDriver {
    pub(super) name: Option<Name>,
    pub(super) whiskers: Option<Vec<String>>,
    pub(super) command: Option<Vec<String>>,
    pub(super) unix: Option<PathBuf>,
    pub(super) tcp: Option<String>,
    pub(super) listen: Option<String>,
    pub(super) serial: Option<PathBuf>,
    pub(super) baud: Option<u32>,
    pub(super) token_file: Option<PathBuf>,
    #[serde(default = "default_restart")]
    pub(super) restart: bool,
    #[serde(default)]
    pub(super) regulate: bool,
    #[serde(default = "default_silent_s")]
    pub(super) silent_s: f64,
    #[serde(default = "default_repeat_s")]
    pub(super) repeat_s: f64,
    #[serde(default = "default_tolerance_mpa")]
    pub(super) tolerance_mpa: f64,
    #[serde(default = "default_settle_s")]
    pub(super) settle_s: f64,
    #[serde(default = "default_fail_after_s")]
    pub(super) fail_after_s: f64,
    #[serde(default = "default_own_slew")]
    pub(super) own_slew_mpa_per_s: f64,
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
pub(super) struct FileArray {
    pub(super) array: Name,
    #[serde(rename = "type")]
    pub(super) array_type: ArrayType,
    pub(super) task: Option<Task>,
    pub(super) whiskers: Vec<FileWhisker>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FileWhisker {
    pub(super) whisker: u16,
    #[serde(default)]
    pub(super) x_mm: f64,
    #[serde(default)]
    pub(super) y_mm: f64,
    #[serde(default = "default_whisker_model")]
    pub(super) model: String,
    pub(super) length_mm: f64,
    pub(super) length_tolerance_mm: Option<f64>,
    pub(super) pressure_mpa: f64,
    pub(super) pressure_max_mpa: f64,
    #[serde(default)]
    pub(super) neighbours: Vec<u16>,
    pub(super) strain_max: Option<f64>,
    pub(super) place: Option<PlaceKind>,
    #[serde(default)]
    pub(super) pressure_zero_mpa: f64,
    #[serde(default)]
    pub(super) segmenter: FileWhiskerSegmenter,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FileWhiskerSegmenter {
    pub(super) sign: Option<Sign>,
}

fn default_whisker_model() -> String {
    "nguyen-2021".to_owned()
}
