//! `vibrissa run` and `vibrissa demo`.

use std::net::SocketAddr;
use std::path::PathBuf;

use anyhow::{Context, bail};
use clap::{Args, ValueEnum};
use tokio::signal::unix::{SignalKind, signal};
use tracing_subscriber::EnvFilter;
use vibrissa_core::mechanics::{Formulation, Objective};
use vibrissa_core::policy::LongerForShorter;
use vibrissa_core::robot::Params;
use vibrissa_protocol::Name;

use crate::calibration_file;
use crate::demo::{self, DemoOptions};
use crate::mqtt::BrokerAddress;
use crate::service::{LEASE_TIME_TO_LIVE, Service, ServiceOptions};
use crate::store::DatabaseAddress;

/// How the paper's factor of eq. 27, 29 and 31 is read.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum FormulationArg {
    /// As printed; gives the paper's setpoints.
    Published,
    /// As Table 2 would have it.
    Consistent,
}

impl From<FormulationArg> for Formulation {
    fn from(arg: FormulationArg) -> Self {
        match arg {
            FormulationArg::Published => Self::Published,
            FormulationArg::Consistent => Self::Consistent,
        }
    }
}

/// What a setpoint is solved for.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum ObjectiveArg {
    /// Equal sensitivity at the tip, as in the paper.
    Tip,
    /// Least mean error over the contact ratios.
    Mean,
}

impl From<ObjectiveArg> for Objective {
    fn from(arg: ObjectiveArg) -> Self {
        match arg {
            ObjectiveArg::Tip => Self::Tip,
            ObjectiveArg::Mean => Self::Mean,
        }
    }
}

/// Whether a longer whisker may stand in for a shorter one.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum LongerForShorterArg {
    /// Never.
    Never,
    /// Only where nothing else serves.
    LastResort,
    /// Like the others.
    Allowed,
}

impl From<LongerForShorterArg> for LongerForShorter {
    fn from(arg: LongerForShorterArg) -> Self {
        match arg {
            LongerForShorterArg::Never => Self::Never,
            LongerForShorterArg::LastResort => Self::LastResort,
            LongerForShorterArg::Allowed => Self::Allowed,
        }
    }
}

/// Arguments of `vibrissa run`.
#[derive(Debug, Args)]
pub struct RunArgs {
    /// The fleet to supervise: the second level of its topics.
    #[arg(long, env = "VIBRISSA_FLEET", default_value = "fleet")]
    fleet: Name,
    /// The database file; made if it is not there.
    #[arg(long, env = "VIBRISSA_DATABASE", default_value = "vibrissa.sqlite3")]
    database: PathBuf,
    /// An external broker, such as mqtt://broker:1883, instead of the embedded one.
    #[arg(long, env = "VIBRISSA_MQTT_URL")]
    mqtt_url: Option<BrokerAddress>,
    /// The embedded broker's port on 127.0.0.1; 0 takes any free one.
    #[arg(long, env = "VIBRISSA_MQTT_PORT", default_value_t = 1883, conflicts_with = "mqtt_url")]
    mqtt_port: u16,
    /// Where HTTP listens.
    #[arg(long, env = "VIBRISSA_HTTP", default_value = "127.0.0.1:8080")]
    http: SocketAddr,
    /// A calibration file of `vibrissa calibrate`; may be given several times.
    #[arg(long, env = "VIBRISSA_CALIBRATION", value_delimiter = ',')]
    calibration: Vec<PathBuf>,
    #[command(flatten)]
    core: CoreArgs,
}

/// What the core is told.
#[derive(Debug, Args)]
struct CoreArgs {
    /// How the paper's equations are read.
    #[arg(long, value_enum, default_value_t = FormulationArg::Published)]
    formulation: FormulationArg,
    /// What a setpoint is solved for.
    #[arg(long, value_enum, default_value_t = ObjectiveArg::Tip)]
    objective: ObjectiveArg,
    /// Whether a longer whisker may stand in for a shorter one.
    #[arg(long, value_enum, default_value_t = LongerForShorterArg::LastResort)]
    longer_for_shorter: LongerForShorterArg,
    /// Mean number of contacts of a healthy whisker between false alarms.
    #[arg(long, default_value_t = 1e6, value_parser = at_least_1000)]
    contacts_between_false_alarms: f64,
    /// Contacts in which a whisker's offset and noise are learned before anything is called.
    #[arg(long, default_value_t = 150, value_parser = clap::value_parser!(u32).range(20..=100_000))]
    cold_start_contacts: u32,
    /// Highest mean predicted error of a compensation, as a ratio.
    #[arg(long, default_value_t = 0.5, value_parser = ratio)]
    predicted_error_max: f64,
}

fn at_least_1000(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    (1e3..=1e12).contains(&value).then_some(value).ok_or_else(|| "must be between 1e3 and 1e12".to_owned())
}

fn ratio(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    (0.0..=10.0).contains(&value).then_some(value).ok_or_else(|| "must be between 0 and 10".to_owned())
}

impl RunArgs {
    fn options(self) -> anyhow::Result<ServiceOptions> {
        let mut params = Params::nguyen_2021(self.core.formulation.into());
        for path in &self.calibration {
            let (name, model) = calibration_file::load(path, self.core.formulation.into())?;
            if params.model(&name).is_some() {
                bail!("calibration file {}: there is a model {name:?} already; give it another name", path.display());
            }
            params.models.push((name, model));
        }
        params.policy.objective = self.core.objective.into();
        params.policy.longer_for_shorter = self.core.longer_for_shorter.into();
        params.policy.predicted_error_max = self.core.predicted_error_max;
        params.detection.contacts_between_false_alarms = self.core.contacts_between_false_alarms;
        params.detection.cold_start_contacts = self.core.cold_start_contacts;
        Ok(ServiceOptions {
            name: "vibrissa".to_owned(),
            fleets: vec![self.fleet],
            database: DatabaseAddress::Sqlite(self.database),
            lease_time_to_live: LEASE_TIME_TO_LIVE,
            broker: self.mqtt_url,
            mqtt_port: self.mqtt_port,
            http: self.http,
            params,
        })
    }
}

/// Supervises until SIGTERM or Ctrl-C.
///
/// # Errors
/// Something cannot be started.
pub fn run(args: RunArgs) -> anyhow::Result<()> {
    log("info");
    let options = args.options()?;
    runtime()?.block_on(async {
        let service = Service::start(options).await?;
        let (broker, http) = (&service.broker, service.http);
        println!("vibrissa: MQTT on {}:{}, HTTP on http://{http}", broker.host, broker.port);
        let mut terminate = signal(SignalKind::terminate()).context("waiting for SIGTERM")?;
        tokio::select! {
            interrupted = tokio::signal::ctrl_c() => interrupted.context("waiting for Ctrl-C")?,
            _ = terminate.recv() => {}
        }
        service.stop().await;
        Ok(())
    })
}

/// Arguments of `vibrissa demo`.
#[derive(Debug, Args)]
pub struct DemoArgs {
    /// Where the database and the picture go.
    #[arg(long, default_value = "vibrissa-demo")]
    folder: PathBuf,
    /// Seed of the simulation: the same seed makes the same contacts.
    #[arg(long, default_value_t = 2021)]
    seed: u64,
    /// The embedded broker's port on 127.0.0.1; 0 takes any free one.
    #[arg(long, default_value_t = 0)]
    mqtt_port: u16,
    /// Where HTTP listens; port 0 takes any free one.
    #[arg(long, default_value = "127.0.0.1:0")]
    http: SocketAddr,
    /// Go on serving after the report.
    #[arg(long)]
    serve: bool,
}

/// Runs the demo; true if it went as expected.
///
/// # Errors
/// Something cannot be started.
pub fn demo(args: DemoArgs) -> anyhow::Result<bool> {
    log("error");
    let options = DemoOptions {
        folder: args.folder,
        seed: args.seed,
        mqtt_port: args.mqtt_port,
        http: args.http,
        serve: args.serve,
    };
    runtime()?.block_on(demo::run(&options))
}

/// Logs to standard error; `RUST_LOG` overrides the level.
fn log(default: &str) {
    let filter = EnvFilter::try_from_default_env()
        .unwrap_or_else(|_| EnvFilter::new(format!("{default},mqtt5=warn,rumqttc=warn")));
    tracing_subscriber::fmt().with_env_filter(filter).with_writer(std::io::stderr).init();
}

fn runtime() -> anyhow::Result<tokio::runtime::Runtime> {
    tokio::runtime::Builder::new_multi_thread().enable_all().build().context("starting the runtime")
}
