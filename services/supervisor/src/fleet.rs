//! Supervision of one fleet, from acquisition to release of its lease: the engine and its two connections.

use std::sync::{Arc, OnceLock};

use tokio::sync::{mpsc, watch};
use tokio::task::{JoinError, JoinHandle, JoinSet};
use tokio::time::{Duration, Instant, timeout_at};
use tracing::{error, info, warn};
use vibrissa_core::robot::Params;
use vibrissa_edge::clock::wall_clock;
use vibrissa_edge::invariants::Invariant;
use vibrissa_host::task;
use vibrissa_protocol::{BootId, Name};

use crate::action_notifier::ActionNotifier;
use crate::archive::Archive;
use crate::black_box::BlackBoxes;
use crate::clocks::{HoldBack, RobotClocks};
use crate::ending::{Ending, stopped};
use crate::engine::{ContactRetention, Engine, EngineOptions, Limits};
use crate::events::EventSink;
use crate::former_owner::FormerOwners;
use crate::kafka::{Kafka, LogReader};
use crate::metrics::{FleetMetrics, Metrics};
use crate::mqtt::{self, BrokerAddress, BrokerLink, Connection, FleetBirths, Prepared};
use crate::outbox::Losses;
use crate::readiness::{Readiness, Standing};
use crate::robots_file::RobotsFile;
use crate::thread::{ThreadSlot, Threads};
use crate::trace::Traces;
use vibrissa_store::maintenance_facts::LastTest;
use vibrissa_store::{Lease, Store, StoreError};

/// Publications that may wait for the broker. Beyond this number they are dropped and made again later.
const OUTBOX_MESSAGES: usize = 10_000;

/// Batches of the log's records that may wait for the engine.
const LOG_BATCHES: usize = 4;

/// Time limit for an orderly end of a fleet. Aborting after it loses nothing: uncommitted messages have no receipt, so
/// robots send them again.
const STOP_PATIENCE: Duration = Duration::from_secs(5);
/// Time that the publisher has for its farewell, at least.
const FAREWELL_PATIENCE: Duration = Duration::from_secs(3);

/// Name of this part in the service's readiness.
const TAKING_UP: &str = "taking up";

/// Resources shared by all fleets of a supervisor.
#[derive(Debug, Clone)]
pub(crate) struct Shared {
    pub(crate) store: Store,
    pub(crate) broker: BrokerAddress,
    pub(crate) prepared: Prepared,
    /// Fleets are supervised although the broker retains owners whom the database does not know.
    pub(crate) is_new_installation: bool,
    /// Requests for births, by fleet.
    pub(crate) births: FleetBirths,
    pub(crate) metrics: Metrics,
    pub(crate) readiness: Readiness,
    pub(crate) action_notifier: ActionNotifier,
    pub(crate) traces: Option<Traces>,
    pub(crate) params: Arc<Params>,
    /// Which contacts get a row of their own.
    pub(crate) keep: ContactRetention,
    /// Limits on the number of robots.
    pub(crate) limits: Limits,
    /// Archive of the contacts, if there is one.
    pub(crate) archive: Option<Archive>,
    /// The partitioned log, if one is used.
    pub(crate) kafka: Option<Kafka>,
    /// Black boxes of the robots.
    pub(crate) boxes: BlackBoxes,
    /// Clocks of the robots that are heard.
    pub(crate) robot_clocks: RobotClocks,
    /// By how much deletions of old rows hold back.
    pub(crate) hold_back: HoldBack,
    /// Allow list of robots from a file, if one is configured.
    pub(crate) robots_file: Option<watch::Receiver<Arc<RobotsFile>>>,
    /// Threads in which the fleets work.
    pub(crate) threads: Threads,
    /// Identifier of this start of this supervisor; the owner in the leases.
    pub(crate) supervisor: Arc<str>,
}

/// A fleet that this supervisor owns.
#[derive(Debug)]
pub(crate) struct Fleet {
    lease: Lease,
    /// State of the fleet's broker connections; not set before the engine has started.
    link: Arc<OnceLock<BrokerLink>>,
    stop: watch::Sender<bool>,
    task: JoinHandle<()>,
    metrics: FleetMetrics,
}

impl Fleet {
    /// Starts the engine in the background, because it may have to wait for the database and the broker. Leases are
    /// renewed meanwhile.
    pub(crate) fn start(lease: Lease, shared: &Shared) -> Self {
        let (stop, stopping) = watch::channel(false);
        // The fleet is ready when its robots are heard.
        shared.readiness.set_of(lease.fleet(), TAKING_UP, Some("loading its robots".to_owned()));
        shared.readiness.stands(lease.fleet(), Standing::Owned { epoch: lease.epoch() });
        let link = Arc::new(OnceLock::new());
        let task = task::spawn(supervise(lease.clone(), shared.clone(), link.clone(), stopping));
        let metrics = shared.metrics.of_fleet(lease.fleet());
        Self { lease, link, stop, task, metrics }
    }

    /// State of the fleet's broker connections; `None` before the engine has started.
    pub(crate) fn link(&self) -> Option<&BrokerLink> {
        self.link.get()
    }

    /// The lease under which this supervisor owns the fleet.
    pub(crate) fn lease(&self) -> &Lease {
        &self.lease
    }

    /// Whether supervision has ended without [`Fleet::stop`], because another supervisor acquired the lease.
    pub(crate) fn is_over(&self) -> bool {
        self.task.is_finished()
    }

    /// Stops in order: no more messages are received, the rest is committed, receipts and the status of the supervisor
    /// are published.
    pub(crate) async fn stop(self) -> Lease {
        // An error means that the task has already ended and dropped the receiver.
        let _ = self.stop.send(true);
        if let Err(problem) = self.task.await {
            error!(fleet = %self.lease.fleet(), %problem, "supervision task failed");
            note_panic(Some(&problem), "supervision", self.lease.fleet(), &self.metrics);
        }
        self.lease
    }
}

async fn supervise(lease: Lease, shared: Shared, heard: Arc<OnceLock<BrokerLink>>, mut stop: watch::Receiver<bool>) {
    let fleet = lease.fleet().clone();
    let metrics = shared.metrics.of_fleet(&fleet);
    let events = shared.kafka.as_ref().and_then(|kafka| kafka.sink(&fleet, &metrics));
    let log = shared.kafka.as_ref().and_then(|kafka| kafka.reader(&fleet, &metrics, &shared.readiness));
    let taking_up = async {
        former_owners(&fleet, &shared, &heard).await;
        take_up(&lease, &shared, events.as_ref(), log.as_ref()).await
    };
    let engine = tokio::select! {
        engine = taking_up => engine,
        () = stopped(&mut stop) => None,
    };
    let place = shared.threads.place();
    let place = place.inspect_err(|problem| error!(%problem, %fleet, "cannot start a thread for the fleet"));
    if let Some(((engine, boot_id), place)) = engine.zip(place.ok()) {
        let connection = Connection {
            births: shared.births.of(&fleet),
            epoch: lease.epoch(),
            hears_contacts: log.is_none(),
            occupancy: place.occupancy(),
            link: heard.get_or_init(BrokerLink::default).clone(),
            ..Connection::new(shared.broker.clone(), shared.prepared.clone(), fleet.clone(), boot_id)
        };
        for node in shared.broker.nodes() {
            metrics.mqtt_node_failures.know(&node.to_string());
        }
        shared.readiness.listens(&fleet, connection.link.clone(), metrics.promises.clone());
        shared.readiness.set_of(&fleet, TAKING_UP, None);
        let archiving = shared
            .archive
            .as_ref()
            .map(|archive| task::spawn(archive.clone().run(lease.clone(), shared.store.clone(), metrics.clone())));
        // Dropped at the end of supervision: what is not published yet waits in the log of events.
        let _publishing = match (&shared.kafka, events) {
            (Some(kafka), Some(sink)) => kafka.publish(&shared.store, &fleet, &metrics, sink),
            _ => None,
        };
        run((engine, place, log), &connection, &metrics, stop).await;
        if let Some(task) = archiving {
            // The next owner writes an unfinished file again.
            task.abort();
        }
    }
    shared.readiness.forget(&fleet);
    shared.robot_clocks.forget(&fleet);
    metrics.forget();
    if let Some(whiskers) = &shared.metrics.whiskers {
        whiskers.show(&fleet, Vec::new());
    }
    info!(%fleet, epoch = lease.epoch(), "fleet supervision ended");
}

/// Waits while the database does not know the fleet's former owner.
async fn former_owners(fleet: &Name, shared: &Shared, heard: &OnceLock<BrokerLink>) {
    let Ok(boot_id) = BootId::new(&shared.supervisor) else { return };
    if shared.is_new_installation {
        return;
    }
    let Shared { store, metrics, readiness, .. } = shared;
    let connection = Connection::new(shared.broker.clone(), shared.prepared.clone(), fleet.clone(), boot_id);
    FormerOwners { store, metrics, readiness, part: TAKING_UP, connection, heard }.await_known().await;
}

/// Settings of the engine of a fleet.
fn engine_options(
    lease: &Lease,
    boot_id: &BootId,
    shared: &Shared,
    (events, log): (Option<&EventSink>, Option<&LogReader>),
    last_tests: Vec<LastTest>,
) -> EngineOptions {
    EngineOptions {
        lease: lease.clone(),
        boot_id: boot_id.clone(),
        params: shared.params.clone(),
        writer: shared.store.writer(),
        metrics: shared.metrics.clone(),
        readiness: shared.readiness.clone(),
        action_notifier: shared.action_notifier.clone(),
        retention: shared.keep,
        limits: shared.limits,
        robots_file: shared.robots_file.clone(),
        events: events.cloned(),
        log: log.map(LogReader::source),
        boxes: shared.boxes.clone(),
        robot_clocks: shared.robot_clocks.clone(),
        is_archived: shared.archive.is_some(),
        last_tests,
        traces: shared.traces.clone(),
    }
}

/// Loads the fleet; retries while the database is unreachable.
async fn take_up(
    lease: &Lease,
    shared: &Shared,
    events: Option<&EventSink>,
    log: Option<&LogReader>,
) -> Option<(Engine, BootId)> {
    // New with each epoch, because the message numbers start again.
    let boot_id = match BootId::new(&format!("{}-{}", shared.supervisor, lease.epoch())) {
        Ok(boot_id) => boot_id,
        Err(problem) => {
            error!(%problem, "cannot make a boot id");
            return None;
        }
    };
    let mut backoff = crate::backoff::Backoff::default();
    loop {
        let loading = async {
            if events.is_some() {
                shared.store.follow_events(lease.fleet().as_str(), wall_clock().0 as i64).await?;
            }
            let last_tests = match shared.limits.maintenance_every {
                Some(_) => shared.store.last_tests(lease.fleet().as_str()).await?,
                None => Vec::new(),
            };
            engine_options(lease, &boot_id, shared, (events, log), last_tests).start().await
        };
        match loading.await {
            Ok(engine) => return Some((engine, boot_id)),
            Err(problem @ StoreError::LeaseLost { .. }) => {
                warn!(%problem, "fleet not loaded, lease lost");
                return None;
            }
            Err(problem) => {
                shared.metrics.database_failed();
                error!(%problem, fleet = %lease.fleet(), "cannot load the fleet, retrying");
                shared.readiness.set_of(lease.fleet(), TAKING_UP, Some(problem.message()));
                backoff.wait().await;
            }
        }
    }
}

/// Runs the engine until `stop`, or until another supervisor acquires the lease.
async fn run(
    (engine, place, log): (Engine, ThreadSlot, Option<LogReader>),
    connection: &Connection,
    metrics: &FleetMetrics,
    mut stop: watch::Receiver<bool>,
) {
    let (hang_up, hanging_up) = watch::channel(false);
    let (inbox, receiving) = mqtt::receive(connection, metrics.clone(), hanging_up);
    let (outbox, publications) = mpsc::channel(OUTBOX_MESSAGES);
    let losses = Losses::default();
    let mut publisher = mqtt::publish(connection, metrics.clone(), publications, losses.clone());
    let (cut_off, cutting_off) = watch::channel(false);
    let (fleet, of_fleet) = (connection.fleet.clone(), metrics.clone());
    // Receiver and engine share a thread, so that a message of a quiet fleet wakes only one.
    let working = async move {
        // Ends with the engine.
        let mut beside = JoinSet::new();
        task::spawn_in(&mut beside, receiving);
        let batches = log.zip(engine.log_from()).map(|(log, from)| {
            let (sender, batches) = mpsc::channel(LOG_BATCHES);
            task::spawn_in(&mut beside, log.run(from, sender));
            batches
        });
        let ending = engine.run((inbox, batches), outbox, losses).await;
        while let Some(ended) = beside.try_join_next() {
            note_panic(ended.err().as_ref(), "receiver", &fleet, &of_fleet);
        }
        ending
    };
    let mut engine = place.spawn(working, cutting_off);
    let mut published = None;
    tokio::select! {
        () = stopped(&mut stop) => {}
        // It ends after the engine: otherwise no setpoint would leave any more, and nobody would notice.
        ended = &mut publisher => published = Some(ended),
        ended = &mut engine => {
            if let Ok(Some(Ending::LeaseLost)) = ended {
                warn!(fleet = %connection.fleet, epoch = connection.epoch, "fleet lease lost to another supervisor");
            }
            note_panic(ended.err().as_ref(), "engine", &connection.fleet, metrics);
        }
    }
    let _ = hang_up.send(true);
    let deadline = Instant::now() + STOP_PATIENCE;
    // In the order in which they end: the receiver first; each one releases the channel that the next one waits for.
    if !engine.is_finished() {
        let problem = end_by(deadline, "engine", &mut engine).await;
        note_panic(problem.as_ref(), "engine", &connection.fleet, metrics);
        let _ = cut_off.send(true);
    }
    let problem = match published {
        Some(ended) => ended.err(),
        // An engine that takes all the time leaves enough for the farewell.
        None => end_by(deadline.max(Instant::now() + FAREWELL_PATIENCE), "publisher", &mut publisher).await,
    };
    note_panic(problem.as_ref(), "publisher", &connection.fleet, metrics);
}

/// Waits for the end of a task, and aborts it after the deadline. Returns the error of a task that has failed.
async fn end_by<T>(deadline: Instant, name: &str, task: &mut JoinHandle<T>) -> Option<JoinError> {
    match timeout_at(deadline, &mut *task).await {
        Ok(ended) => ended.err(),
        Err(_) => {
            warn!(task = name, "task did not end in time, aborting it");
            task.abort();
            None
        }
    }
}

/// Counts a task that has panicked.
fn note_panic(problem: Option<&JoinError>, name: &str, fleet: &Name, metrics: &FleetMetrics) {
    if let Some(problem) = problem.filter(|problem| problem.is_panic()) {
        metrics.violations.count(Invariant::NoPanic, fleet, &format_args!("{name}: {problem}"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn a_task_that_has_panicked_is_counted_and_one_that_was_aborted_is_not() {
        let fleet = Name::new("f").unwrap();
        let metrics = Metrics::new(false).unwrap().of_fleet(&fleet);
        let deadline = Instant::now() + STOP_PATIENCE;
        let endless = task::spawn(std::future::pending::<()>());
        endless.abort();
        for (mut task, count) in
            [(task::spawn(async {}), 0), (endless, 0), (task::spawn(async { panic!("planted") }), 1)]
        {
            let problem = end_by(deadline, "task", &mut task).await;
            note_panic(problem.as_ref(), "task", &fleet, &metrics);
            assert_eq!(metrics.violations.of(Invariant::NoPanic), count);
        }
    }
}
