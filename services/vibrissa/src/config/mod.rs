//! The configuration: a TOML file, overridden by the environment, overridden by flags.
//!
//! Every setting is a [`Key`] of one table, under one name in all three places. The whole configuration is checked
//! before anything connects, and all problems are reported at once ([`Problems`]). Read in this order: [`keys`],
//! [`layers`], [`problem`]; then [`show`], which prints the values in effect with their origins.

pub mod address;
pub mod choices;
pub mod keys;
pub mod layers;
pub mod problem;
pub mod show;

mod archive;
mod database;
mod http;
mod kafka;
mod mail;
mod mqtt;
mod policy;
mod reader;
mod touch_tests;
mod traces;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use vibrissa_core::mechanics::{Formulation, Model};
use vibrissa_core::policy::PolicyParams;
use vibrissa_core::robot::Params;
use vibrissa_core::robot::params::TouchTestParams;
use vibrissa_program::log_filter::log_filter;
use vibrissa_protocol::Name;

pub use keys::Key;
pub use layers::Sources;
pub use policy::policy_over;
pub use problem::{Origin, Problem, Problems};

use self::layers::Layers;
use self::reader::Reader;
use choices::{FormulationArg, InstallationArg, KeepArg, SeriesArg};
use vibrissa_edge::calibration_file::{self, CalibrationFileError};
use vibrissa_store::DatabaseAddress;
use vibrissa_store::retention::Retention;
use vibrissa_supervisor::broker::MqttAccess;
use vibrissa_supervisor::engine::{ContactRetention, Limits};
use vibrissa_supervisor::http::HttpOptions;
use vibrissa_supervisor::http::access::AccessOptions;
use vibrissa_supervisor::mqtt::{BrokerAddress, Credentials};
use vibrissa_supervisor::robots_file::RobotsFile;
use vibrissa_supervisor::service::{BlackBoxOptions, HistoryOptions, KafkaOptions, LimitOptions, ServiceOptions};
use vibrissa_supervisor::trace::TraceOptions;
use vibrissa_supervisor::webhooks::WebhookOptions;

/// A configuration that was checked as a whole. `Debug` shows no secret.
#[derive(Debug, Clone)]
pub struct Config {
    /// Name of this supervisor.
    pub name: String,
    /// Fleets to supervise: at least one, without duplicates.
    pub fleets: Vec<Name>,
    /// Whisker models in addition to the paper's, by their names in factsheets.
    pub models: Vec<(String, Model)>,
    /// Log filter of `tracing`.
    pub log: String,
    /// Address of the database.
    pub database: DatabaseAddress,
    /// Whether the database may lack owners of fleets that the broker retains.
    pub is_new_installation: bool,
    /// Time without renewal after which another supervisor may take over a fleet.
    pub lease_time_to_live: Duration,
    /// Retention of contacts: the stored ones, and their lifetime.
    pub history: HistoryOptions,
    /// Black boxes of robots.
    pub black_boxes: BlackBoxOptions,
    /// Limits on the number of robots, and the file of allowed robots.
    pub limits: LimitOptions,
    /// External broker; `None` starts the embedded one.
    pub broker: Option<BrokerAddress>,
    /// Port of the embedded broker; 0 takes any free port.
    pub mqtt_port: u16,
    /// Credentials that clients of the embedded broker need, if there are any.
    pub mqtt_credentials: Option<Credentials>,
    /// HTTP listeners and connection limits.
    pub http: HttpOptions,
    /// Configured credentials, in addition to the tokens in the database.
    pub access: AccessOptions,
    /// Partitioned log.
    pub kafka: KafkaOptions,
    /// Hosts that webhooks may reach at private addresses, and the mail server.
    pub webhooks: WebhookOptions,
    /// Whether metrics include each robot and whisker.
    pub metrics_per_whisker: bool,
    /// Export of traces; `None` without a collector.
    pub traces: Option<TraceOptions>,
    /// Interpretation of the paper's equations.
    pub formulation: Formulation,
    /// Policy of the compensations, unless an operator has set another one.
    pub policy: PolicyParams,
    /// Mean number of contacts of a healthy whisker between false alarms.
    pub contacts_between_false_alarms: f64,
    /// Number of contacts of a whisker's cold start.
    pub cold_start_contacts: u32,
    /// Largest angle of contacts that state none, degrees.
    pub contact_angle_deg_max: f64,
    /// Touch tests and the suspicion of a lost reach.
    pub touch_tests: TouchTestParams,
    /// Files that contain passwords, tokens or private keys, each with the key of the configuration that leads there.
    pub secret_files: Vec<(Key, PathBuf)>,
}

/// Result of reading a configuration.
pub struct Reading {
    /// The configuration, or all its problems.
    pub config: Result<Config, Problems>,
    /// Warnings for standard error.
    pub warnings: Vec<String>,
}

/// Merges the layers and checks the result. Reads the files that keys name; connects to nothing.
#[must_use]
pub fn read(sources: &Sources) -> Reading {
    let mut layers = Layers::new(sources);
    let warnings = std::mem::take(&mut layers.warnings);
    let mut reader = Reader::new(layers);
    let config = config(&mut reader);
    let config = match (config, reader.problems.is_empty()) {
        (Some(config), true) => Ok(config),
        _ => Err(Problems(reader.problems)),
    };
    Reading { config, warnings }
}

/// Reads every key before it gives up, so that all problems are reported.
fn config(reader: &mut Reader) -> Option<Config> {
    let name = reader.parsed(Key::Name, supervisor_name);
    let fleets = fleets(reader);
    let formulation = reader.word::<FormulationArg>(Key::ModelFormulation).map(Formulation::from);
    let models = models(reader, formulation.unwrap_or_default());
    let log = reader.parsed(Key::Log, log_filter);
    let database = database::database(reader);
    let installation = reader.word::<InstallationArg>(Key::DatabaseInstallation);
    let lease = reader.number(Key::LeaseTimeToLiveS);
    let keep = reader.word::<KeepArg>(Key::ContactsKeep);
    let keep = keep.map(ContactRetention::from);
    let (contacts_days, minutes_days) = (reader.whole(Key::ContactsDays), reader.whole(Key::RollupsMinutesDays));
    let (black_box_days, records_days) = (reader.whole(Key::BlackBoxDays), reader.whole(Key::RecordsDays));
    let black_boxes = black_boxes(reader);
    let limits = limits(reader);
    let (broker, mqtt_credentials) = mqtt::broker(reader);
    let mqtt_port = reader.whole(Key::MqttPort).and_then(|port| u16::try_from(port).ok());
    let http = http::listeners(reader);
    let access = http::access(reader);
    let kafka = kafka::kafka(reader);
    let archive = archive::archive(reader, keep);
    let allowed_hosts = reader.texts(Key::WebhooksAllowedHosts);
    let mail = mail::mail(reader);
    let series = reader.word::<SeriesArg>(Key::MetricsSeries);
    let traces = traces::traces(reader);
    let policy = policy::policy(reader);
    let contacts_between_false_alarms = reader.number(Key::DetectionContactsBetweenFalseAlarms);
    let cold_start_contacts = reader.whole(Key::DetectionColdStartContacts);
    let contact_angle_deg_max = reader.number(Key::DetectionContactAngleDegMax);
    let touch_tests = touch_tests::touch_tests(reader);
    Some(Config {
        name: name?,
        fleets: fleets?,
        models: models?,
        log: log?,
        database: database?,
        is_new_installation: installation? == InstallationArg::New,
        lease_time_to_live: Duration::from_secs_f64(lease?),
        history: HistoryOptions {
            keep: keep?,
            archive: archive?,
            retention: Retention {
                contacts_days: contacts_days?,
                minutes_days: minutes_days?,
                black_boxes_days: black_box_days?,
                records_days: records_days?,
            },
        },
        black_boxes: black_boxes?,
        limits: limits?,
        broker,
        mqtt_port: mqtt_port?,
        mqtt_credentials,
        http: http?,
        access: access?,
        kafka: kafka?,
        webhooks: WebhookOptions { allowed_hosts: allowed_hosts?, mail: mail?, ..WebhookOptions::default() },
        metrics_per_whisker: series? == SeriesArg::Whiskers,
        traces: traces?,
        formulation: formulation?,
        policy: policy?,
        contacts_between_false_alarms: contacts_between_false_alarms?,
        cold_start_contacts: cold_start_contacts?,
        contact_angle_deg_max: contact_angle_deg_max?,
        touch_tests: touch_tests?,
        secret_files: std::mem::take(&mut reader.secret_files),
    })
}

fn black_boxes(reader: &mut Reader) -> Option<BlackBoxOptions> {
    let (seconds, memory_mib) = (reader.whole(Key::BlackBoxSeconds), reader.whole(Key::BlackBoxMemoryMib));
    Some(BlackBoxOptions { seconds: seconds?, memory_mib: memory_mib? })
}

/// Reads the file of allowed robots only to report errors in it. The service reads it again.
fn limits(reader: &mut Reader) -> Option<LimitOptions> {
    let robots_per_fleet = reader.whole(Key::LimitsRobotsPerFleet);
    let new_robots_per_minute = reader.whole(Key::LimitsNewRobotsPerMinute);
    let maintenance_every_s = reader.whole(Key::MqttMaintenanceEveryS);
    let robots_file = reader.file(Key::LimitsRobotsFile);
    if let Some(Err(problem)) = robots_file.as_deref().map(RobotsFile::read) {
        reader.refuse(Key::LimitsRobotsFile, problem);
    }
    Some(LimitOptions {
        limits: Limits {
            robots_per_fleet: robots_per_fleet?,
            new_robots_per_minute: new_robots_per_minute?,
            maintenance_every: maintenance_every_s
                .map(u64::from)
                .map(Duration::from_secs)
                .filter(|every| !every.is_zero()),
        },
        robots_file,
    })
}

fn supervisor_name(text: &str) -> Result<String, &'static str> {
    let good = text.chars().count() <= 255 && !text.contains(char::is_control);
    good.then(|| text.to_owned()).ok_or("must have at most 255 characters, and no control characters")
}

fn fleets(reader: &mut Reader) -> Option<Vec<Name>> {
    let texts = reader.texts(Key::Fleets)?;
    if texts.is_empty() {
        reader.refuse(Key::Fleets, "must name at least one fleet");
    }
    let mut seen = BTreeSet::new();
    let mut fleets = Vec::new();
    for text in texts {
        match Name::new(&text) {
            Ok(fleet) if seen.insert(fleet.clone()) => fleets.push(fleet),
            Ok(fleet) => reader.refuse(Key::Fleets, format!("names the fleet {fleet} twice: leave one out")),
            Err(problem) => reader.refuse(Key::Fleets, problem.to_string()),
        }
    }
    Some(fleets)
}

fn models(reader: &mut Reader, formulation: Formulation) -> Option<Vec<(String, Model)>> {
    let built_in = Params::nguyen_2021(formulation).models;
    let mut models: Vec<(String, Model)> = Vec::new();
    for text in reader.texts(Key::Calibrations)? {
        let loaded = calibration_file::load(Path::new(&text), formulation).map_err(|problem| match problem {
            // The full error would show a line of the file, which may be the wrong file.
            CalibrationFileError::Parse { reason, .. } => format!("calibration file {text}: {reason}"),
            problem @ (CalibrationFileError::Read { .. }
            | CalibrationFileError::Name { .. }
            | CalibrationFileError::Model { .. }) => problem.to_string(),
        });
        let unique = loaded.and_then(|(name, model)| {
            if built_in.iter().any(|(taken, _)| **taken == name) || models.iter().any(|(taken, _)| *taken == name) {
                return Err(format!(
                    "calibration file {text}: there is a model {name:?} already; give it another name"
                ));
            }
            Ok((name, model))
        });
        match unique {
            Ok(model) => models.push(model),
            Err(problem) => reader.refuse(Key::Calibrations, problem),
        }
    }
    Some(models)
}

impl Config {
    /// Parameters of the core.
    #[must_use]
    pub fn params(&self) -> Params {
        let mut params = Params::nguyen_2021(self.formulation);
        params.models.extend(self.models.iter().map(|(name, model)| (Arc::new(name.clone()), model.clone())));
        params.policy = self.policy;
        params.detection.contacts_between_false_alarms = self.contacts_between_false_alarms;
        params.detection.cold_start_contacts = self.cold_start_contacts;
        params.detection.contact_angle_deg_max = self.contact_angle_deg_max;
        params.touch_tests = self.touch_tests;
        params
    }
}

impl From<Config> for ServiceOptions {
    fn from(config: Config) -> Self {
        let params = config.params();
        Self {
            name: config.name,
            fleets: config.fleets,
            database: config.database,
            is_new_installation: config.is_new_installation,
            lease_time_to_live: config.lease_time_to_live,
            history: config.history,
            black_boxes: config.black_boxes,
            limits: config.limits,
            broker: config.broker,
            mqtt_port: config.mqtt_port,
            mqtt_access: MqttAccess::AsHttp(config.mqtt_credentials),
            http: config.http,
            access: config.access,
            kafka: config.kafka,
            metrics_per_whisker: config.metrics_per_whisker,
            webhooks: config.webhooks,
            traces: config.traces,
            params,
        }
    }
}

#[cfg(test)]
mod tests;
