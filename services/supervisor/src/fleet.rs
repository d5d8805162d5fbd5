//! One fleet under supervision, from taking it up to giving it back: the engine and its two connections.

use std::sync::{Arc, OnceLock};

use tokio::sync::{mpsc, watch};
use tokio::task::JoinHandle;
use tokio::time::{Duration, Instant, timeout_at};
use tracing::{error, info, warn};
use vibrissa_core::robot::Params;
use vibrissa_protocol::BootId;

use crate::ending::Ending;
use crate::engine::{Engine, Keep, Limits};
use crate::mailroom::Mailroom;
use crate::metrics::{FleetMetrics, Metrics};
use crate::mqtt::{self, BrokerAddress, Connection, LinkState, Prepared, stopped};
use crate::readiness::{Readiness, Standing};
use crate::robots_file::RobotsFile;
use crate::thread;
use crate::trace::Traces;
use vibrissa_store::{Lease, Store, StoreError};

/// Publications that wait for the broker; beyond it they are dropped and made again.
const OUTBOX_MESSAGES: usize = 10_000;

/// How long a fleet may take to end in good order. Cutting it off loses nothing: what is not committed is not
/// receipted, and robots send it again.
const STOP_PATIENCE: Duration = Duration::from_secs(5);

/// The part of readiness that is kept here.
const TAKING_UP: &str = "taking up";

/// What all fleets of a supervisor share.
#[derive(Debug, Clone)]
pub(crate) struct Shared {
    pub(crate) store: Store,
    pub(crate) broker: BrokerAddress,
    pub(crate) prepared: Prepared,
    pub(crate) metrics: Metrics,
    pub(crate) readiness: Readiness,
    pub(crate) mailroom: Mailroom,
    pub(crate) traces: Option<Traces>,
    pub(crate) params: Arc<Params>,
    /// Which contacts are kept one by one.
    pub(crate) keep: Keep,
    /// Limits on the number of robots.
    pub(crate) limits: Limits,
    /// The allow list of robots from a file, if there is one.
    pub(crate) robots_file: Option<watch::Receiver<Arc<RobotsFile>>>,
    /// One start of one supervisor.
    pub(crate) supervisor: Arc<str>,
}

/// A fleet that is supervised here.
#[derive(Debug)]
pub(crate) struct Fleet {
    lease: Lease,
    /// State of the fleet's broker connections; not set while it is being taken up.
    link: Arc<OnceLock<LinkState>>,
    stop: watch::Sender<bool>,
    task: JoinHandle<()>,
}

impl Fleet {
    /// Takes it up. What that needs from the database and the broker is waited for in the background, so that
    /// the lease is kept meanwhile.
    pub(crate) fn start(lease: Lease, shared: &Shared) -> Self {
        let (stop, stopping) = watch::channel(false);
        // Ready means: robots are heard.
        shared.readiness.set_of(lease.fleet(), TAKING_UP, Some("its robots are being taken up".to_owned()));
        shared.readiness.stands(lease.fleet(), Standing::Owned { epoch: lease.epoch() });
        let link = Arc::new(OnceLock::new());
        let task = tokio::spawn(supervise(lease.clone(), shared.clone(), link.clone(), stopping));
        Self { lease, link, stop, task }
    }

    /// State of the fleet's broker connections; `None` while it is being taken up.
    pub(crate) fn link(&self) -> Option<&LinkState> {
        self.link.get()
    }

    /// The right to it.
    pub(crate) fn lease(&self) -> &Lease {
        &self.lease
    }

    /// Whether it has ended by itself, because it was taken over.
    pub(crate) fn is_over(&self) -> bool {
        self.task.is_finished()
    }

    /// Ends in order: no more messages in, what is there committed, receipts and good-bye out.
    pub(crate) async fn stop(self) -> Lease {
        // Without a receiver it has ended already.
        let _ = self.stop.send(true);
        if let Err(problem) = self.task.await {
            error!(fleet = %self.lease.fleet(), %problem, "supervision ended abnormally");
        }
        self.lease
    }
}

async fn supervise(lease: Lease, shared: Shared, heard: Arc<OnceLock<LinkState>>, mut stop: watch::Receiver<bool>) {
    let fleet = lease.fleet().clone();
    let metrics = shared.metrics.of_fleet(&fleet);
    let engine = tokio::select! {
        engine = take_up(&lease, &shared) => engine,
        () = stopped(&mut stop) => None,
    };
    if let Some((engine, boot_id)) = engine {
        let connection = Connection {
            broker: shared.broker.clone(),
            prepared: shared.prepared.clone(),
            fleet: fleet.clone(),
            boot_id,
            epoch: lease.epoch(),
            link: heard.get_or_init(LinkState::default).clone(),
        };
        shared.readiness.listens(&fleet, connection.link.clone());
        shared.readiness.set_of(&fleet, TAKING_UP, None);
        run(engine, &connection, &metrics, stop).await;
    }
    shared.readiness.forget(&fleet);
    metrics.forget();
    if let Some(whiskers) = &shared.metrics.whiskers {
        whiskers.show(fleet.as_str(), Vec::new());
    }
    info!(%fleet, epoch = lease.epoch(), "supervised here no more");
}

/// Loads the fleet; waits for a database that is away.
async fn take_up(lease: &Lease, shared: &Shared) -> Option<(Engine, BootId)> {
    // New with each epoch: its numbers of messages begin anew.
    let boot_id = match BootId::new(&format!("{}-{}", shared.supervisor, lease.epoch())) {
        Ok(boot_id) => boot_id,
        Err(problem) => {
            error!(%problem, "no boot id");
            return None;
        }
    };
    let mut backoff = crate::backoff::Backoff::default();
    loop {
        let started = Engine::start(
            lease.clone(),
            boot_id.clone(),
            shared.params.clone(),
            shared.store.writer(),
            shared.metrics.clone(),
            shared.readiness.clone(),
            shared.mailroom.clone(),
        );
        match started.await {
            Ok(engine) => {
                let engine = engine.keeping(shared.keep).limited(shared.limits).allowing(shared.robots_file.clone());
                return Some((engine.traced(shared.traces.as_ref()), boot_id));
            }
            Err(problem @ StoreError::LeaseLost { .. }) => {
                warn!(%problem, "not taken up");
                return None;
            }
            Err(problem) => {
                shared.metrics.database_failed();
                error!(%problem, fleet = %lease.fleet(), "cannot take the fleet up; trying again");
                shared.readiness.set_of(lease.fleet(), TAKING_UP, Some(problem.told()));
                backoff.wait().await;
            }
        }
    }
}

/// Runs until told to stop, or until the fleet is somebody else's.
async fn run(engine: Engine, connection: &Connection, metrics: &FleetMetrics, mut stop: watch::Receiver<bool>) {
    let (hang_up, hanging_up) = watch::channel(false);
    let (inbox, receiving) = mqtt::receive(connection, metrics.clone(), hanging_up);
    let (outbox, publications) = mpsc::channel(OUTBOX_MESSAGES);
    let mut publisher = mqtt::publish(connection, metrics.clone(), publications);
    let (cut_off, cutting_off) = watch::channel(false);
    // Together: a message of a fleet that does little wakes one thread then.
    let working = async move {
        let receiver = tokio::spawn(receiving);
        let ending = engine.run(inbox, outbox).await;
        receiver.abort();
        ending
    };
    let mut engine = thread::spawn("fleet", working, cutting_off);
    tokio::select! {
        () = stopped(&mut stop) => {}
        ended = &mut engine => {
            if let Ok(Some(Ending::LeaseLost)) = ended {
                warn!(fleet = %connection.fleet, epoch = connection.epoch, "taken over by another supervisor");
            }
        }
    }
    let _ = hang_up.send(true);
    let deadline = Instant::now() + STOP_PATIENCE;
    // In the order in which they end: the receiver first, and each lets go of what the next one waits for.
    if !engine.is_finished() {
        end_by(deadline, "engine", &mut engine).await;
        let _ = cut_off.send(true);
    }
    end_by(deadline, "publisher", &mut publisher).await;
}

async fn end_by<T>(deadline: Instant, name: &str, task: &mut JoinHandle<T>) {
    if timeout_at(deadline, &mut *task).await.is_err() {
        warn!(task = name, "did not end in time");
        task.abort();
    }
}
