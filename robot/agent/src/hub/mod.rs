//! Runs an agent: carries inputs to it and its outputs to the broker, the driver and the store.
//!
//! The tasks share the agent: the session with the broker, the link to each driver, and a timer. None of them waits for
//! another one: a broker that accepts no messages does not keep pressures from a driver, nor does a faulty driver.

mod drivers;
mod outbox;

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tokio::sync::{Notify, watch};
use tokio::task::JoinSet;
use tokio::time::{sleep, timeout};
use vibrissa_host::random;
use vibrissa_host::task;
use vibrissa_protocol::{BootId, Name, RobotTopic};

use crate::clock::now;
use crate::config::Config;
use crate::contract::{Moment, Now, Outgoing};
use crate::driver::link::{Door, listen_at};
use crate::monitor;
use crate::mqtt::{self, BadBroker, Endpoint, Signals};
use crate::store::Stored;
use crate::store::file::{StoreError, StoreFile};
use crate::store::spool::Spool;
use crate::{Agent, Input, Output};
use drivers::{DriverLink, all_ended};
use outbox::{Store, tell_damage};

/// Most messages that wait for the session. Of those beyond, contacts are sent again later, and setpoints are asked
/// again.
const PENDING_MAX: usize = 1024;
/// Longest pause of the timer.
const TIMER_MAX: Duration = Duration::from_secs(1);
/// Time that the last messages have before the end.
const STOP_TIMEOUT: Duration = Duration::from_secs(3);

/// Why an agent cannot start.
#[derive(Debug, thiserror::Error)]
pub enum CannotStart {
    /// The broker cannot be used.
    #[error("broker: {0}")]
    Broker(#[from] BadBroker),
    /// The file of the outbox cannot be used.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The way to the only driver cannot be prepared.
    #[error("{0}: {1}")]
    Driver(String, std::io::Error),
}

struct State {
    agent: Agent,
    pending: VecDeque<Outgoing>,
    drivers: Vec<DriverLink>,
    store: Option<Store>,
    /// Moment at which the timer works next.
    timer_at: Moment,
}

/// A running agent.
#[derive(Clone)]
struct Hub {
    state: Arc<Mutex<State>>,
    signals: Arc<Signals>,
    timer: Arc<Notify>,
    fleet: Name,
    robot: Name,
}

/// Runs an agent until `stopping` changes.
///
/// # Errors
/// The outbox, the broker's certificates or the way to the driver cannot be used. An unreachable broker or driver is no
/// error: the agent keeps trying.
pub async fn run(config: Config, mut stopping: watch::Receiver<bool>) -> Result<(), CannotStart> {
    let transport = config.broker.transport()?;
    let mut doors = Vec::new();
    for driver in &config.drivers {
        match Door::open(driver).await {
            Ok(door) => doors.push(Some(door)),
            // One faulty driver does not keep the others from their whiskers.
            Err(problem) if config.drivers.len() > 1 => {
                tracing::error!("{}: {problem}; trying again", driver.label);
                doors.push(None);
            }
            Err(problem) => return Err(CannotStart::Driver(driver.label.clone(), problem)),
        }
    }
    let hub = Hub::start(&config)?;
    tracing::info!(
        fleet = %hub.fleet, robot = %hub.robot, boot_id = %hub.lock().agent.boot_id(), broker = ?config.broker, "running"
    );
    // The session ends last: it carries the last messages.
    let (stop_session, session_stopping) = watch::channel(false);
    let session = mqtt::run(hub.clone(), config.broker.clone(), transport, hub.signals.clone(), session_stopping);
    let mut session = task::spawn(session);
    let monitor = monitor::socket(&config).and_then(|path| {
        let refused = |problem| tracing::warn!("no monitor: cannot listen at {}: {problem}", path.display());
        listen_at(&path).map_err(refused).ok()
    });
    let monitor = async {
        match monitor {
            Some(listener) => {
                let shown = hub.clone();
                monitor::serve(listener, move || shown.lock().agent.snapshot(now())).await;
            }
            None => std::future::pending().await,
        }
    };
    let mut driving = JoinSet::new();
    for (index, (driver, door)) in config.drivers.iter().zip(doors).enumerate() {
        task::spawn_in(&mut driving, hub.clone().drive(index, driver.clone(), door));
    }
    tokio::select! {
        _ = stopping.changed() => {}
        () = all_ended(&mut driving) => {}
        () = hub.keep_time() => {}
        () = hub.keep_store() => {}
        () = monitor => {}
    }
    tracing::info!("stopping");
    {
        let mut state = hub.lock();
        let outputs = state.agent.finish(now());
        hub.handle(&mut state, outputs);
    }
    driving.shutdown().await;
    // The contacts that waited go out with the next poll.
    sleep(Duration::from_millis(50)).await;
    let _ = stop_session.send(true);
    if timeout(STOP_TIMEOUT, &mut session).await.is_err() {
        session.abort();
    }
    hub.sync().await;
    Ok(())
}

/// A boot id that was never used before.
fn boot_id() -> BootId {
    BootId::new(&random::hex()).expect("a short text of hexadecimal digits")
}

impl Hub {
    fn start(config: &Config) -> Result<Self, CannotStart> {
        let mut stored = Stored::default();
        let mut file = None;
        if let Some(path) = &config.outbox_file {
            // The present state has at most the outbox's bytes, besides a checksum and a frame for each message.
            let bytes_max = 2 * config.limits.outbox_bytes as u64 + 65_536;
            let (opened, found, damage) = StoreFile::open(path, bytes_max)?;
            tell_damage(path, &damage);
            (file, stored) = (Some(opened), found);
        }
        let refused = |path: &Path| StoreError::refused("open", path);
        let open =
            |path: PathBuf| Spool::open(&path, stored.spooled, config.limits.outbox_disk_bytes).map_err(refused(&path));
        let spool = config.spool().map(open).transpose()?;
        stored.is_spooled = spool.as_ref().is_some_and(|spool| !spool.is_empty());
        let (agent, records) = Agent::new(config, boot_id(), stored, now());
        let (fleet, robot) = (agent.fleet().clone(), agent.robot().clone());
        let store = file.map(|file| Store::begin(file, spool, records));
        let state = State {
            agent,
            pending: VecDeque::new(),
            drivers: config.drivers.iter().map(DriverLink::new).collect(),
            store,
            timer_at: Moment::BEFORE_ALL,
        };
        Ok(Self { state: Arc::new(Mutex::new(state)), signals: Arc::default(), timer: Arc::default(), fleet, robot })
    }

    /// Even after a panic during an access, the agent's state is the best one available.
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Gives the agent an input. Messages for the broker wait until the session takes them.
    fn step(&self, input: Input<'_>) {
        let mut state = self.lock();
        let outputs = state.agent.step(now(), input);
        self.handle(&mut state, outputs);
        self.take_back(&mut state);
    }

    fn handle(&self, state: &mut State, outputs: Vec<Output>) {
        let mut records = Vec::new();
        let (mut to_disk, mut is_asked_back) = (Vec::new(), false);
        for output in outputs {
            match output {
                Output::Spool(contacts) => to_disk.push(contacts),
                Output::TakeBack => is_asked_back = true,
                // All records are written before any of the messages is taken.
                Output::Store(record) => records.push(record),
                Output::Publish(topic, payload) if state.pending.len() < PENDING_MAX => {
                    state.pending.push_back(Outgoing::Publish { topic, payload });
                }
                Output::Publish(..) => {}
                Output::Reconnect => {
                    tracing::info!("the supervisor misses an earlier boot: another one begins");
                    state.pending.push_back(Outgoing::Restart);
                }
                Output::Tell(driver, line) => {
                    let refused = state.agent.counts().lines_refused;
                    state.drivers[driver].tell(&line, refused);
                }
                Output::Warn(text) => tracing::warn!("{text}"),
                Output::RestartDriver(driver, reason) => {
                    tracing::warn!("{reason}");
                    state.drivers[driver].restart.notify_one();
                }
            }
        }
        if let Some(store) = &mut state.store {
            store.append(&records);
            store.owes |= is_asked_back;
        }
        self.spool(state, &to_disk);
        if !state.pending.is_empty() {
            self.signals.wake.notify_one();
        }
        if state.agent.next_deadline() < state.timer_at {
            self.timer.notify_one();
        }
    }

    /// Gives the agent an input from the session, and returns all messages that wait.
    fn answer(&self, input: Input<'_>) -> Vec<Outgoing> {
        self.step(input);
        self.lock().pending.drain(..).collect()
    }

    async fn keep_time(&self) {
        loop {
            self.step(Input::Tick);
            let ahead = {
                let mut state = self.lock();
                let now = now().at;
                let ahead = Duration::from_micros(state.agent.next_deadline().since(now));
                let ahead = ahead.clamp(Duration::from_millis(5), TIMER_MAX);
                state.timer_at = now + ahead.as_micros() as u64;
                ahead
            };
            let _ = timeout(ahead, self.timer.notified()).await;
        }
    }
}

impl Endpoint for Hub {
    fn fleet(&self) -> Name {
        self.fleet.clone()
    }

    fn robot(&self) -> Name {
        self.robot.clone()
    }

    fn will(&self, now: Now) -> Vec<u8> {
        self.lock().agent.will(now)
    }

    fn connected(&self, _: Now) -> Vec<Outgoing> {
        tracing::info!("connected to the broker");
        self.lock().pending.clear();
        self.answer(Input::Connected)
    }

    fn disconnected(&self) {
        self.step(Input::Disconnected);
        self.lock().pending.clear();
    }

    fn poll(&self, _: Now) -> (Vec<Outgoing>, Moment) {
        // The timer has a task of its own.
        (self.lock().pending.drain(..).collect(), Moment::NEVER)
    }

    fn receive(&self, topic: RobotTopic, payload: &[u8], _: Now) -> Vec<Outgoing> {
        self.answer(Input::Message(topic, payload))
    }

    fn receive_request_to_all(&self, payload: &[u8], _: Now) {
        self.step(Input::RequestToAll(payload, u64::from_ne_bytes(random::bytes())));
    }

    fn farewell(&self, now: Now) -> Vec<Outgoing> {
        let mut state = self.lock();
        let farewell = state.agent.farewell(now).map(|payload| (RobotTopic::Connection, payload));
        let farewell = farewell.map(|(topic, payload)| Outgoing::Publish { topic, payload });
        state.pending.drain(..).chain(farewell).collect()
    }
}
