//! The service put together: broker, database, the keeper of the leases, HTTP.

use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::Arc;

use anyhow::Context;
use tokio::sync::watch;
use tokio::task::JoinHandle;
use tokio::time::{Duration, timeout};
use tracing::{error, warn};
use uuid::Uuid;
use vibrissa_core::robot::Params;
use vibrissa_protocol::Name;

use crate::broker::Broker;
use crate::engine::{Keep, Limits};
use crate::fleet::Shared;
use crate::http::access::{Access, AccessOptions};
use crate::http::{App, HttpOptions, Serving};
use crate::mailroom::Mailroom;
use crate::metrics::Metrics;
use crate::mqtt::{self, BrokerAddress};
use crate::ownership::Ownership;
use crate::readiness::Readiness;
use crate::robots_file;
use crate::trace::{TraceOptions, Traces};
use crate::upkeep;
use vibrissa_edge::clock::wall_clock;
use vibrissa_edge::ids::start_seed;
use vibrissa_store::retention::Retention;
use vibrissa_store::{DatabaseAddress, Store, Supervisor};

/// How long everything that is not a fleet may take to end in good order.
const STOP_PATIENCE: Duration = Duration::from_secs(5);

/// How long a fleet stays a silent supervisor's, unless it is told otherwise.
pub const LEASE_TIME_TO_LIVE: Duration = Duration::from_secs(2);

/// What is kept of what whiskers felt.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct HistoryOptions {
    /// Which contacts are kept one by one.
    pub keep: Keep,
    /// For how long they are kept, and what they add up to.
    pub retention: Retention,
}

/// Limits on the number of robots, and the file of allowed robots.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct LimitOptions {
    /// Limits on the number of robots.
    pub limits: Limits,
    /// A file with the robots that are allowed; none allows all, unless people have set a list over HTTP.
    pub robots_file: Option<PathBuf>,
}

/// What to run.
#[derive(Debug, Clone)]
pub struct ServiceOptions {
    /// What this supervisor is called, for people: in the database, in errors, in logs.
    pub name: String,
    /// The fleets to supervise; with PostgreSQL they are shared with other supervisors.
    pub fleets: Vec<Name>,
    /// The database.
    pub database: DatabaseAddress,
    /// How long a fleet stays this supervisor's without a word from it.
    pub lease_time_to_live: Duration,
    /// What of contacts is kept, and for how long.
    pub history: HistoryOptions,
    /// Limits on the number of robots, and the file of allowed robots.
    pub limits: LimitOptions,
    /// An external broker; none starts the embedded one.
    pub broker: Option<BrokerAddress>,
    /// The embedded broker's port; 0 takes any free one.
    pub mqtt_port: u16,
    /// Where HTTP listens, and how many connections it takes; port 0 takes any free one.
    pub http: HttpOptions,
    /// Who is let in there, besides those whose tokens the database has.
    pub access: AccessOptions,
    /// Whether each robot and whisker is shown to Prometheus: four series a whisker.
    pub metrics_per_whisker: bool,
    /// Where traces go; nowhere if there is no collector.
    pub traces: Option<TraceOptions>,
    /// The core's parameters.
    pub params: Params,
}

/// A running service.
pub struct Service {
    /// Where the broker is.
    pub broker: BrokerAddress,
    /// Where HTTP listens.
    pub http: SocketAddr,
    /// Where only `/livez`, `/readyz` and `/metrics` are served, if anywhere.
    pub monitoring: Option<SocketAddr>,
    /// The database.
    pub store: Store,
    /// What it counts.
    pub metrics: Metrics,
    /// What keeps it from its work.
    pub readiness: Readiness,
    /// What those who ask for actions share with the fleets.
    pub mailroom: Mailroom,
    traces: Option<Traces>,
    embedded: Option<Broker>,
    stop: watch::Sender<bool>,
    ownership: JoinHandle<()>,
    http_task: JoinHandle<()>,
}

impl Service {
    /// Starts everything. When this returns, HTTP is served, and fleets are taken up in the background:
    /// [`Readiness`] tells.
    ///
    /// # Errors
    /// A port is taken, or the database cannot be used. A server that is away is no error: it is waited for.
    pub async fn start(options: ServiceOptions) -> anyhow::Result<Self> {
        if options.database.is_exposed() {
            warn!(database = %options.database, "not verified to be that server: add ?sslmode=verify-full to its URL");
        }
        let store = Store::open(&options.database, &options.name).await?;
        let is_prepared = match store.prepare().await {
            Ok(()) => true,
            Err(problem) if problem.is_passing() && store.is_shared() => {
                warn!(%problem, "waiting for the database");
                false
            }
            Err(problem) => return Err(problem.into()),
        };
        let metrics = declare_metrics(&options)?;
        let (embedded, broker) = match options.broker {
            Some(address) => (None, address),
            None => {
                let embedded = Broker::start(options.mqtt_port).await?;
                let address = embedded.address();
                (Some(embedded), BrokerAddress::new(address.ip().to_string(), address.port()))
            }
        };
        let prepared = mqtt::prepare(&broker)?;
        let database = if store.is_shared() { "postgresql" } else { "sqlite" };
        let dropped = metrics.trace_spans_dropped.clone();
        let start = |to: &TraceOptions| Traces::start(to, &options.name, database, dropped);
        let traces = options.traces.as_ref().map(start).transpose()?;
        let (stop, stopped) = watch::channel(false);
        let follow = |path| robots_file::follow(path, stopped.clone()).map_err(anyhow::Error::msg);
        let robots_file = options.limits.robots_file.map(follow).transpose().context("limits.robots_file")?;
        let readiness = Readiness::default();
        let mailroom = Mailroom::default();
        let params = Arc::new(options.params);
        let shared = Shared {
            store: store.clone(),
            broker: broker.clone(),
            prepared,
            metrics: metrics.clone(),
            readiness: readiness.clone(),
            mailroom: mailroom.clone(),
            traces: traces.clone(),
            params: params.clone(),
            keep: options.history.keep,
            limits: options.limits.limits,
            robots_file: robots_file.clone(),
            supervisor: format!("s{}", Uuid::new_v5(&Uuid::NAMESPACE_OID, &start_seed()).simple()).into(),
        };
        let supervisor = Supervisor {
            id: shared.supervisor.clone(),
            name: options.name,
            fleets: options.fleets,
            time_to_live: options.lease_time_to_live,
        };
        let ownership = Ownership::new(supervisor, shared, is_prepared);
        let access = Access::new(&options.access, options.http.listen.ip());
        if is_prepared && !access.admits_anybody(&store, wall_clock().0 as i64).await {
            anyhow::bail!(
                "HTTP would listen on {}, beyond this machine, and nobody could be let in: make a token first with \
                 `vibrissa token create`, or set http.token_file or http.oidc_issuer, or listen on 127.0.0.1",
                options.http.listen
            );
        }
        let app = App::new(
            store.clone(),
            metrics.clone(),
            readiness.clone(),
            access,
            mailroom.clone(),
            params,
            stopped.clone(),
        )
        .traced(traces.clone())
        .allowing(robots_file);
        let Serving { address: http, monitoring, task: http_task } =
            crate::http::serve(&options.http, app, stopped.clone()).await?;
        tokio::spawn(forget_changes(store.clone(), stopped.clone()));
        tokio::spawn(upkeep::run(store.clone(), options.history.retention, metrics.clone(), stopped.clone()));
        let ownership = tokio::spawn(ownership.run(stopped));
        Ok(Self {
            broker,
            http,
            monitoring,
            store,
            metrics,
            readiness,
            mailroom,
            traces,
            embedded,
            stop,
            ownership,
            http_task,
        })
    }

    /// Stops in order: fleets are finished and given back, then everything else ends.
    pub async fn stop(self) {
        let _ = self.stop.send(true);
        if let Err(problem) = self.ownership.await {
            error!(%problem, "the leases were not given back");
        }
        // Queries of requests that are still open may hold it up.
        let mut http_task = self.http_task;
        if timeout(STOP_PATIENCE, &mut http_task).await.is_err() {
            http_task.abort();
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

/// The metrics, with those of every fleet of the configuration, whoever has it.
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

/// How long what live pages follow is kept.
const CHANGES_KEPT: Duration = Duration::from_secs(86_400);
/// How often the rest is removed.
const CHANGES_FORGOTTEN_EVERY: Duration = Duration::from_secs(600);

/// Removes changes that nobody can have waited for, until the service stops.
async fn forget_changes(store: Store, mut stop: watch::Receiver<bool>) {
    while timeout(CHANGES_FORGOTTEN_EVERY, stop.wait_for(|&stop| stop)).await.is_err() {
        let before_us = wall_clock().0 as i64 - CHANGES_KEPT.as_micros() as i64;
        if let Err(problem) = store.forget_changes(before_us).await {
            warn!(%problem, "old changes stay for now");
        }
    }
}
