//! Assembles the service: broker, database, ownership of fleets, HTTP.

use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::Arc;

use anyhow::Context;
use tokio::sync::watch;
use tokio::task::JoinHandle;
use tokio::time::{Duration, timeout};
use tracing::warn;
use vibrissa_core::robot::Params;
use vibrissa_host::task;
use vibrissa_protocol::Name;

use crate::action_notifier::ActionNotifier;
use crate::archive::Archive;
pub use crate::archive_options::ArchiveOptions;
pub use crate::black_box::BlackBoxOptions;
use crate::broker::{Broker, MqttAccess};
use crate::clocks::HoldBack;
use crate::engine::{ContactRetention, Limits};
use crate::http::access::{Access, AccessOptions};
use crate::http::{App, FurtherRoutes, HttpOptions, Serving};
use crate::kafka::Kafka;
pub use crate::kafka_options::KafkaOptions;
use crate::metrics::Metrics;
use crate::mqtt::BrokerAddress;
use crate::readiness::Readiness;
use crate::replication;
use crate::robots_file;
use crate::supervision::{Beside, Supervision, SupervisionOptions};
use crate::trace::{TraceOptions, Traces};
use crate::upkeep;
use crate::webhooks::{WebhookOptions, Webhooks};
use vibrissa_edge::clock::wall_clock;
use vibrissa_store::retention::Retention;
use vibrissa_store::{DatabaseAddress, Store};

/// Time limit for an orderly end of everything except the fleets.
const STOP_PATIENCE: Duration = Duration::from_secs(5);

/// Default time to live of a fleet's lease: an owner that is silent for longer loses the fleet.
pub const LEASE_TIME_TO_LIVE: Duration = Duration::from_secs(2);

/// Which contacts the database keeps, and for how long.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct HistoryOptions {
    /// Which contacts get a row of their own.
    pub keep: ContactRetention,
    /// Retention periods of these rows and of the aggregates.
    pub retention: Retention,
    /// Archive of the contacts on an object store.
    pub archive: Option<ArchiveOptions>,
}

/// Limits on the number of robots, and the file of allowed robots.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct LimitOptions {
    /// Limits on the number of robots.
    pub limits: Limits,
    /// File of the allowed robots; `None` allows all, unless an operator has set a list over HTTP.
    pub robots_file: Option<PathBuf>,
}

/// Options of a supervisor.
#[derive(Debug, Clone)]
pub struct ServiceOptions {
    /// Name of this supervisor for people: in the database, in errors, in logs.
    pub name: String,
    /// The fleets to supervise; with PostgreSQL they are shared with other supervisors.
    pub fleets: Vec<Name>,
    /// SQLite file or PostgreSQL server.
    pub database: DatabaseAddress,
    /// Whether the database is known to be a new one: fleets are supervised although the broker retains owners whom it does
    /// not know.
    pub is_new_installation: bool,
    /// Time to live of a lease: an owner that is silent for longer loses the fleet.
    pub lease_time_to_live: Duration,
    /// Which contacts the database keeps, and for how long.
    pub history: HistoryOptions,
    /// Black boxes of robots.
    pub black_boxes: BlackBoxOptions,
    /// Limits on the number of robots, and the file of allowed robots.
    pub limits: LimitOptions,
    /// External broker; `None` starts the embedded one.
    pub broker: Option<BrokerAddress>,
    /// Port of the embedded broker; 0 takes any free one.
    pub mqtt_port: u16,
    /// The clients that the embedded broker admits.
    pub mqtt_access: MqttAccess,
    /// Listening address and connection limits of HTTP; port 0 takes any free one.
    pub http: HttpOptions,
    /// Accepted credentials of HTTP, besides the tokens in the database.
    pub access: AccessOptions,
    /// Whether Prometheus gets series for each robot and whisker: four per whisker.
    pub metrics_per_whisker: bool,
    /// The partitioned log.
    pub kafka: KafkaOptions,
    /// Hosts and pauses of webhooks.
    pub webhooks: WebhookOptions,
    /// Collector of traces; `None` disables tracing.
    pub traces: Option<TraceOptions>,
    /// The core's parameters.
    pub params: Params,
}

/// A running service.
pub struct Service {
    /// Address of the broker.
    pub broker: BrokerAddress,
    /// Address of the HTTP server.
    pub http: SocketAddr,
    /// Address that serves only `/livez`, `/readyz` and `/metrics`, if one is configured.
    pub monitoring: Option<SocketAddr>,
    /// Access to the database.
    pub store: Store,
    /// Metrics of the service.
    pub metrics: Metrics,
    /// Problems that keep the service from its work.
    pub readiness: Readiness,
    /// Connects HTTP requests for actions with the fleets' engines.
    pub action_notifier: ActionNotifier,
    traces: Option<Traces>,
    embedded: Option<Broker>,
    stop: watch::Sender<bool>,
    supervision: Supervision,
    webhooks: JoinHandle<()>,
    http_task: JoinHandle<()>,
}

impl Service {
    /// Starts all tasks. On return, HTTP is served. Fleets are acquired in the background; [`Readiness`] shows the
    /// progress.
    ///
    /// # Errors
    /// A port is taken, or the database cannot be used. An unreachable PostgreSQL server or broker is no error: the
    /// service waits for it.
    pub async fn start(options: ServiceOptions) -> anyhow::Result<Self> {
        Self::start_with(options, FurtherRoutes::default()).await
    }

    /// Like [`Service::start`], with HTTP routes of the caller beside those of the API.
    ///
    /// # Errors
    /// Those of [`Service::start`].
    pub async fn start_with(options: ServiceOptions, further_routes: FurtherRoutes) -> anyhow::Result<Self> {
        if options.database.is_exposed() {
            warn!(database = %options.database, "database server is not verified: add ?sslmode=verify-full to its URL");
        }
        let store = Store::open(&options.database, &options.name).await?;
        store.check().await?;
        let is_prepared = match store.prepare().await {
            Ok(()) => true,
            Err(problem) if problem.is_passing() && store.is_shared() => {
                warn!(%problem, "database unreachable, waiting for it");
                false
            }
            Err(problem) => return Err(problem.into()),
        };
        let metrics = declare_metrics(&options)?;
        let access = Access::new(&options.access, options.http.listen.ip());
        if is_prepared && !access.admits_anybody(&store, wall_clock().0 as i64).await {
            anyhow::bail!(
                "HTTP would listen on {}, beyond this machine, but no credentials exist: make a token first with \
                 `vibrissa token create`, or set http.token_file or http.oidc_issuer, or listen on 127.0.0.1",
                options.http.listen
            );
        }
        let (embedded, broker) = match options.broker {
            Some(address) => (None, address),
            None => {
                let credentials = options.mqtt_access.credentials(access.is_open())?.cloned();
                let embedded = Broker::guarded(options.mqtt_port, credentials.as_ref()).await?;
                let address = embedded.address();
                let address = BrokerAddress::new(address.ip().to_string(), address.port());
                (Some(embedded), BrokerAddress { credentials, ..address })
            }
        };
        // The embedded broker retains only what this process has said.
        let is_new_installation = options.is_new_installation || embedded.is_some();
        let archive = options.history.archive.as_ref().map(Archive::open).transpose().context("archive.url")?;
        let archived = if archive.is_some() { options.fleets.clone() } else { Vec::new() };
        let database = if store.is_shared() { "postgresql" } else { "sqlite" };
        let dropped = metrics.trace_spans_dropped.clone();
        let start = |to: &TraceOptions| Traces::start(to, &options.name, database, dropped);
        let traces = options.traces.as_ref().map(start).transpose()?;
        let (stop, stopped) = watch::channel(false);
        let follow = |path| robots_file::follow(path, stopped.clone()).map_err(anyhow::Error::msg);
        let robots_file = options.limits.robots_file.map(follow).transpose().context("limits.robots_file")?;
        let params = Arc::new(options.params);
        let supervision = SupervisionOptions {
            name: options.name,
            fleets: options.fleets,
            is_new_installation,
            lease_time_to_live: options.lease_time_to_live,
            keep: options.history.keep,
            black_boxes: options.black_boxes,
            limits: options.limits.limits,
            params: params.clone(),
        };
        let (traced, kafka) = (traces.clone(), Kafka::new(&options.kafka)?);
        let beside = Beside { archive, kafka, traces: traced, robots_file: robots_file.clone() };
        let (database, broker_of) = ((store.clone(), is_prepared), (broker.clone(), metrics.clone()));
        let mut supervision = Supervision::start_with(supervision, database, broker_of, beside, stopped.clone())?;
        let (readiness, action_notifier) = (supervision.readiness.clone(), supervision.action_notifier.clone());
        let supervisor = supervision.supervisor.clone();
        let delivery = (options.webhooks.sender(), options.webhooks.pace);
        let webhooks = Webhooks::new(delivery, store.clone(), metrics.clone(), supervisor)
            .holding_back(supervision.hold_back.clone());
        let app = App::new(
            store.clone(),
            metrics.clone(),
            readiness.clone(),
            access,
            action_notifier.clone(),
            params,
            stopped.clone(),
        )
        .traced(traces.clone())
        .with_routes(further_routes)
        .allowing(robots_file)
        .delivering(webhooks.clone());
        let Serving { address: http, monitoring, task: http_task } =
            crate::http::serve(&options.http, app, stopped.clone()).await?;
        let (retention, hold_back) = (options.history.retention, supervision.hold_back.clone());
        let tasks = &mut supervision.database_tasks;
        task::spawn_in(tasks, forget_events(store.clone(), hold_back.clone(), stopped.clone()));
        let told = (metrics.clone(), readiness.clone());
        let upkeep = upkeep::run(store.clone(), (retention, hold_back), archived, told, stopped.clone());
        task::spawn_in(tasks, upkeep);
        task::spawn_in(tasks, replication::watch(store.clone(), metrics.clone(), stopped.clone()));
        let webhooks = task::spawn(webhooks.run(stopped));
        Ok(Self {
            broker,
            http,
            monitoring,
            store,
            metrics,
            readiness,
            action_notifier,
            traces,
            embedded,
            stop,
            supervision,
            webhooks,
            http_task,
        })
    }

    /// Stops in order: the fleets finish and release their leases, then everything else ends.
    pub async fn stop(self) {
        let _ = self.stop.send(true);
        // Before the database is closed, because closing it lets another supervisor write.
        self.supervision.ended().await;
        // Open requests may hold it up with their queries.
        let mut http_task = self.http_task;
        if timeout(STOP_PATIENCE, &mut http_task).await.is_err() {
            http_task.abort();
        }
        // An attempt may be under way; its event is delivered again after the next start.
        let mut webhooks = self.webhooks;
        if timeout(STOP_PATIENCE, &mut webhooks).await.is_err() {
            webhooks.abort();
        }
        let _ = timeout(STOP_PATIENCE, self.store.close()).await;
        if let Some(traces) = self.traces {
            traces.stop().await;
        }
        if let Some(broker) = self.embedded {
            broker.stop().await;
        }
    }
}

/// Declares the metrics, including those of each configured fleet, whoever owns it.
fn declare_metrics(options: &ServiceOptions) -> anyhow::Result<Metrics> {
    let metrics = Metrics::new(options.metrics_per_whisker).context("declaring the metrics")?;
    let database = match options.database {
        DatabaseAddress::Sqlite(_) => "SQLITE",
        DatabaseAddress::Postgres { .. } => "POSTGRESQL",
    };
    metrics.is(&options.name, database, if options.broker.is_some() { "EXTERNAL" } else { "EMBEDDED" });
    for fleet in &options.fleets {
        metrics.of_fleet(fleet).lease_held.set(0);
    }
    Ok(metrics)
}

/// Interval between two removals of old events.
const EVENTS_FORGOTTEN_EVERY: Duration = Duration::from_secs(600);

/// Removes old events, until the service stops.
async fn forget_events(store: Store, hold_back: HoldBack, mut stop: watch::Receiver<bool>) {
    while timeout(EVENTS_FORGOTTEN_EVERY, stop.wait_for(|&stop| stop)).await.is_err() {
        let old_by_us = hold_back.old_by_us(wall_clock().0 as i64);
        if let Err(problem) = store.with_leader(store.forget_events(old_by_us)).await {
            warn!(%problem, "cannot remove old events, retrying later");
        }
    }
}
