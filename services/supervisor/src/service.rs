//! The service put together: broker, database, the two connections, the engine, HTTP.

use std::net::SocketAddr;

use anyhow::Context;
use tokio::sync::{mpsc, watch};
use tokio::task::JoinHandle;
use tokio::time::{Duration, Instant, timeout_at};
use tracing::warn;
use uuid::Uuid;
use vibrissa_core::robot::Params;
use vibrissa_protocol::{BootId, Name};

use crate::broker::Broker;
use crate::engine::{Engine, wall_clock};
use crate::metrics::Metrics;
use crate::mqtt::{self, BrokerAddress, Connection, LinkState};
use crate::store::{DatabaseAddress, Store};

/// Publications that wait for the broker; beyond it they are dropped and made again.
const OUTBOX_MESSAGES: usize = 10_000;

/// How long everything together may take to end in good order. Cutting it off loses nothing: what is not
/// committed is not receipted, and robots send it again.
const STOP_PATIENCE: Duration = Duration::from_secs(5);

/// How long a fleet stays a silent supervisor's, unless it is told otherwise.
pub const LEASE_TIME_TO_LIVE: Duration = Duration::from_secs(2);

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
    /// An external broker; none starts the embedded one.
    pub broker: Option<BrokerAddress>,
    /// The embedded broker's port; 0 takes any free one.
    pub mqtt_port: u16,
    /// Where HTTP listens; port 0 takes any free one.
    pub http: SocketAddr,
    /// The core's parameters.
    pub params: Params,
}

/// A running service.
pub struct Service {
    /// Where the broker is.
    pub broker: BrokerAddress,
    /// Where HTTP listens.
    pub http: SocketAddr,
    /// The database.
    pub store: Store,
    /// What it counts.
    pub metrics: Metrics,
    embedded: Option<Broker>,
    stop: watch::Sender<bool>,
    tasks: [(&'static str, JoinHandle<()>); 4],
}

impl Service {
    /// Starts everything; it serves when this returns.
    ///
    /// # Errors
    /// A port is taken, or the database cannot be used.
    pub async fn start(options: ServiceOptions) -> anyhow::Result<Self> {
        let (embedded, broker) = match options.broker {
            Some(address) => (None, address),
            None => {
                let embedded = Broker::start(options.mqtt_port).await?;
                let address = embedded.address();
                (Some(embedded), BrokerAddress::new(address.ip().to_string(), address.port()))
            }
        };
        let prepared = mqtt::prepare(&broker)?;
        let metrics = Metrics::new().context("declaring the metrics")?;
        let DatabaseAddress::Sqlite(path) = &options.database else { anyhow::bail!("only SQLite yet") };
        let store = Store::open(path).await?;
        let Some(fleet) = options.fleets.first().cloned() else { anyhow::bail!("no fleet") };
        let boot_id = BootId::new(&format!("s{}", Uuid::new_v5(&Uuid::NAMESPACE_OID, &boot_seed()).simple()))?;
        let engine =
            Engine::start(fleet.clone(), boot_id.clone(), options.params, store.clone(), metrics.clone()).await?;
        let link = LinkState::default();
        let connection =
            Connection { broker: broker.clone(), prepared, fleet, boot_id, epoch: engine.epoch(), link: link.clone() };

        let (stop, stopped) = watch::channel(false);
        let (http, http_task) =
            crate::http::serve(options.http, store.clone(), metrics.clone(), link, stopped.clone()).await?;
        let (inbox, receiver_task) = mqtt::receive(&connection, metrics.clone(), stopped.clone());
        let (outbox, publications) = mpsc::channel(OUTBOX_MESSAGES);
        let publisher_task = mqtt::publish(&connection, publications);
        let engine_task = tokio::spawn(engine.run(inbox, outbox));
        // In the order in which they end: each of the first three lets go of what the next one waits for.
        let tasks = [
            ("receiver", receiver_task),
            ("engine", engine_task),
            ("publisher", publisher_task),
            ("HTTP server", http_task),
        ];
        Ok(Self { broker, http, store, metrics, embedded, stop, tasks })
    }

    /// Stops in order: no more messages in, what is there committed, receipts and good-bye out.
    pub async fn stop(self) {
        let _ = self.stop.send(true);
        let deadline = Instant::now() + STOP_PATIENCE;
        for (name, mut task) in self.tasks {
            if timeout_at(deadline, &mut task).await.is_err() {
                warn!(task = name, "did not end in time");
                task.abort();
            }
        }
        // A query of a request that is still open may hold a connection.
        let _ = tokio::time::timeout(STOP_PATIENCE, self.store.close()).await;
        if let Some(broker) = self.embedded {
            broker.stop().await;
        }
    }
}

/// What makes a boot's name its own: the time and the process.
fn boot_seed() -> Vec<u8> {
    let mut seed = wall_clock().0.to_le_bytes().to_vec();
    seed.extend(std::process::id().to_le_bytes());
    seed
}
