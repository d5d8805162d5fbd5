//! A supervisor of the simulation: a host, its ways to broker, log and store, and the process that runs there.

use std::sync::Arc;
use std::time::Duration;

use tokio::sync::watch;
use vibrissa_core::mechanics::Formulation;
use vibrissa_core::robot::Params;
use vibrissa_host::task;
use vibrissa_protocol::Name;
use vibrissa_store::Store;
use vibrissa_supervisor::engine::{ContactRetention, Limits};
use vibrissa_supervisor::kafka_options::KafkaOptions;
use vibrissa_supervisor::mqtt::BrokerAddress;
use vibrissa_supervisor::service::{BlackBoxOptions, LEASE_TIME_TO_LIVE};
use vibrissa_supervisor::supervision::{Supervision, SupervisionOptions};
use vibrissa_supervisor::webhooks::{Sender, Webhooks};

use crate::broker::{ModelBroker, Route};
use crate::log::{ModelLog, TOPIC};
use crate::process::{HostClock, LOG_HOST, Process, Routes};
use crate::receivers::{PACE, Receivers};
use crate::server::{StoreServer, StoreWay};

/// Latency between supervisor and broker or log in one direction.
const LATENCY: Duration = Duration::from_micros(200);

/// A supervisor, running or not.
#[derive(Debug)]
pub struct Member {
    /// Its name, for people.
    pub name: String,
    /// The clock of its host.
    pub host: Arc<HostClock>,
    /// Its ways to broker and log.
    pub routes: Routes,
    /// Where it finds the log, if contacts come from there.
    log: KafkaOptions,
    /// Its way to the store.
    pub way: Arc<StoreWay>,
    receivers: Receivers,
    fleets: Vec<Name>,
    running: Option<Running>,
    starts: u64,
    seed: u64,
}

/// The process of a supervisor.
#[derive(Debug)]
struct Running {
    process: Arc<Process>,
    stop: watch::Sender<bool>,
}

impl Member {
    /// A supervisor that does not run yet.
    #[must_use]
    pub fn new(
        number: usize,
        (seed, at_us, drift_ppm): (u64, i64, i64),
        fleets: &[Name],
        (broker, server, receivers): (&ModelBroker, &StoreServer, &Receivers),
        (log, is_from_log): (&ModelLog, bool),
    ) -> Self {
        let (brokers, ingest) = (vec![format!("{LOG_HOST}:9092")], is_from_log.then(|| TOPIC.to_owned()));
        Self {
            name: format!("supervisor-{number}"),
            host: Arc::new(HostClock::new(at_us, drift_ppm)),
            routes: Routes { broker: Route::new(broker.clone(), LATENCY), log: Route::new(log.clone(), LATENCY) },
            log: KafkaOptions { brokers, ingest, ..KafkaOptions::default() },
            way: server.way(),
            receivers: receivers.clone(),
            fleets: fleets.to_vec(),
            running: None,
            starts: 0,
            seed: seed.wrapping_mul(31).wrapping_add(number as u64),
        }
    }

    /// Starts it, unless it runs.
    ///
    /// # Panics
    /// The supervision cannot start, although it needs neither files nor sockets.
    pub fn start(&mut self) {
        if self.process().is_some() {
            return;
        }
        self.starts += 1;
        self.way.start();
        let process = Process::new(self.seed.wrapping_add(self.starts << 32), self.host.clone(), self.routes.clone());
        let (stop, stopped) = watch::channel(false);
        let options = SupervisionOptions {
            name: self.name.clone(),
            fleets: self.fleets.clone(),
            is_new_installation: true,
            lease_time_to_live: LEASE_TIME_TO_LIVE,
            keep: ContactRetention::All,
            black_boxes: BlackBoxOptions { seconds: 0, memory_mib: 0 },
            limits: Limits::default(),
            params: Arc::new(Params::nguyen_2021(Formulation::Consistent)),
        };
        let store = Store::modelled(self.way.clone());
        let broker = BrokerAddress::new("broker", 1883);
        let delivery = (Sender::over(Arc::new(self.receivers.clone())), PACE);
        process.enter(|| {
            let supervision = Supervision::start(options, (store, true), (broker, &self.log), stopped.clone());
            let supervision = supervision.expect("a supervision without files");
            let (store, metrics) = (supervision.store.clone(), supervision.metrics.clone());
            task::spawn(Webhooks::new(delivery, store, metrics, supervision.supervisor.clone()).run(stopped));
            task::spawn(supervision.ended());
        });
        self.running = Some(Running { process, stop });
    }

    /// Its process; `None` if it does not run.
    #[must_use]
    pub fn process(&self) -> Option<&Arc<Process>> {
        self.running.as_ref().map(|running| &running.process).filter(|process| !process.is_dead())
    }

    /// Tells it to end in order.
    pub fn stop(&mut self) {
        if let Some(running) = &self.running {
            let _ = running.stop.send(true);
        }
    }

    /// Kills it now.
    pub fn kill(&mut self) {
        if let Some(running) = self.running.take() {
            running.process.kill();
        }
    }
}
