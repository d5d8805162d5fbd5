//! Supervision of fleets by one supervisor, without HTTP: ownership, engines, and the tasks beside them. It runs in simulated
//! time, too.

use std::sync::Arc;

use tokio::sync::watch;
use tokio::task::{JoinHandle, JoinSet};
use tokio::time::{Duration, timeout};
use tracing::error;
use vibrissa_core::robot::Params;
use vibrissa_host::{random, task};
use vibrissa_protocol::Name;
use vibrissa_store::{Store, Supervisor};

use crate::action_notifier::ActionNotifier;
use crate::archive::Archive;
use crate::black_box::{BlackBoxOptions, BlackBoxes};
use crate::clocks::{HoldBack, RobotClocks};
use crate::engine::{ContactRetention, Limits};
use crate::fleet::Shared;
use crate::kafka::Kafka;
use crate::kafka_options::KafkaOptions;
use crate::metrics::Metrics;
use crate::mqtt::{self, BrokerAddress, FleetBirths};
use crate::ownership::Ownership;
use crate::readiness::Readiness;
use crate::robots_file::RobotsFile;
use crate::thread::Threads;
use crate::trace::Traces;

/// Time limit for an orderly end of everything except the fleets.
const STOP_PATIENCE: Duration = Duration::from_secs(5);

/// Options of the supervision.
#[derive(Debug, Clone)]
pub struct SupervisionOptions {
    /// Name of this supervisor for people.
    pub name: String,
    /// The fleets to supervise; with a shared database they are shared with other supervisors.
    pub fleets: Vec<Name>,
    /// Whether fleets are supervised although the broker retains owners whom the database does not know.
    pub is_new_installation: bool,
    /// Time to live of a lease: an owner that is silent for longer loses the fleet.
    pub lease_time_to_live: Duration,
    /// Which contacts get a row of their own.
    pub keep: ContactRetention,
    /// Black boxes of robots.
    pub black_boxes: BlackBoxOptions,
    /// Limits on the number of robots.
    pub limits: Limits,
    /// The core's parameters.
    pub params: Arc<Params>,
}

/// What an installation may have beside database and broker.
#[derive(Default)]
pub(crate) struct Beside {
    pub(crate) archive: Option<Archive>,
    pub(crate) kafka: Option<Kafka>,
    pub(crate) traces: Option<Traces>,
    pub(crate) robots_file: Option<watch::Receiver<Arc<RobotsFile>>>,
}

/// The running supervision.
pub struct Supervision {
    /// Access to the database.
    pub store: Store,
    /// Metrics of the supervisor.
    pub metrics: Metrics,
    /// Problems that keep it from its work.
    pub readiness: Readiness,
    /// Connects requests for actions with the fleets' engines.
    pub action_notifier: ActionNotifier,
    /// Identifier of this start of the supervisor; the owner in the leases.
    pub supervisor: Arc<str>,
    pub(crate) hold_back: HoldBack,
    ownership: JoinHandle<()>,
    /// Tasks that use the database.
    pub(crate) database_tasks: JoinSet<()>,
}

impl Supervision {
    /// Starts the supervision with no more than database, broker and partitioned log. `is_prepared` says that the tables of the
    /// database are up to date.
    ///
    /// # Errors
    /// The broker's certificates cannot be read, or the metrics cannot be declared.
    pub fn start(
        options: SupervisionOptions,
        (store, is_prepared): (Store, bool),
        (broker, log): (BrokerAddress, &KafkaOptions),
        stopped: watch::Receiver<bool>,
    ) -> anyhow::Result<Self> {
        let metrics = Metrics::new(false)?;
        let beside = Beside { kafka: Kafka::new(log)?, ..Beside::default() };
        Self::start_with(options, (store, is_prepared), (broker, metrics), beside, stopped)
    }

    pub(crate) fn start_with(
        options: SupervisionOptions,
        (store, is_prepared): (Store, bool),
        (broker, metrics): (BrokerAddress, Metrics),
        beside: Beside,
        stopped: watch::Receiver<bool>,
    ) -> anyhow::Result<Self> {
        let prepared = mqtt::prepare(&broker)?;
        let readiness = Readiness::default();
        readiness.tells_rows(store.set_aside().clone());
        let (action_notifier, hold_back) = (ActionNotifier::default(), HoldBack::default());
        let supervisor: Arc<str> = format!("s{}", random::hex()).into();
        let mut database_tasks = JoinSet::new();
        let shared = Shared {
            store: store.clone(),
            broker,
            prepared,
            is_new_installation: options.is_new_installation,
            births: FleetBirths::default(),
            metrics: metrics.clone(),
            readiness: readiness.clone(),
            action_notifier: action_notifier.clone(),
            traces: beside.traces,
            params: options.params,
            keep: options.keep,
            archive: beside.archive,
            limits: options.limits,
            kafka: beside.kafka,
            boxes: BlackBoxes::start(options.black_boxes, store.writer(), &mut database_tasks),
            robot_clocks: RobotClocks::default(),
            hold_back: hold_back.clone(),
            robots_file: beside.robots_file,
            threads: Threads::of_all_cores(),
            supervisor: supervisor.clone(),
        };
        let member = Supervisor {
            id: supervisor.clone(),
            name: options.name,
            fleets: options.fleets,
            time_to_live: options.lease_time_to_live,
        };
        let ownership = Ownership::new(member, shared, is_prepared);
        task::spawn_in(&mut database_tasks, action_notifier.clone().watch(store.clone(), stopped.clone()));
        let ownership = task::spawn(ownership.run(stopped));
        Ok(Self { store, metrics, readiness, action_notifier, supervisor, hold_back, ownership, database_tasks })
    }

    /// Waits for the end after the stop: the fleets have finished, their leases are released, and nothing of this supervisor
    /// writes any more.
    pub async fn ended(self) {
        if let Err(problem) = self.ownership.await {
            error!(%problem, "ownership task failed, leases were not released");
        }
        let mut database_tasks = self.database_tasks;
        let ended = async { while database_tasks.join_next().await.is_some() {} };
        if timeout(STOP_PATIENCE, ended).await.is_err() {
            database_tasks.shutdown().await;
        }
    }
}
