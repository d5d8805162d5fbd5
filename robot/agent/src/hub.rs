//! Runs an agent: carries inputs to it and its outputs to the broker, the driver and the store.
//!
//! The tasks share the agent: the session with the broker, the link to each driver, and a timer. None of them waits for
//! another one: a broker that accepts no messages does not keep pressures from a driver, nor does a faulty driver.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::sync::{Notify, mpsc, watch};
use tokio::task::JoinSet;
use tokio::time::{Instant, sleep, timeout};
use vibrissa_host::random;
use vibrissa_host::task;
use vibrissa_protocol::{BootId, Name, RobotTopic};

use crate::clock::now;
use crate::config::{Config, DriverConfig, Way};
use crate::contract::{Moment, Now, Outgoing};
use crate::driver::link::{Door, Link, listen_at};
use crate::driver::{Lines, ToDriver};
use crate::monitor;
use crate::mqtt::{self, BadBroker, Endpoint, Signals};
use crate::store::file::{Damage, StoreError, StoreFile};
use crate::store::spool::Spool;
use crate::store::{Record, Stored};
use crate::{Agent, Input, Output};

/// Most messages that wait for the session. Of those beyond, contacts are sent again later, and setpoints are asked again.
const PENDING_MAX: usize = 1024;
/// Most lines that wait for the driver. A driver that reads none of so many hangs.
const TELLING_MAX: usize = 1024;
/// Time between two synchronisations of the store with the disk: a power cut loses no more than about this.
const SYNC_EVERY: Duration = Duration::from_millis(200);
/// Time after which a store that failed is tried again.
const STORE_AGAIN: Duration = Duration::from_secs(5);
/// Pauses between two attempts to reach the driver.
const LINK_PAUSE: (Duration, Duration) = (Duration::from_millis(250), Duration::from_secs(10));
/// A driver that lived for this long gets the shortest pause again.
const LIVED: Duration = Duration::from_secs(10);
/// Time between two logs of refused lines.
const REFUSAL_PAUSE: Duration = Duration::from_secs(60);
/// Longest pause of the timer.
const TIMER_MAX: Duration = Duration::from_secs(1);
/// Time that the last messages have before the end.
const STOP_TIMEOUT: Duration = Duration::from_secs(3);
/// Bytes that are read from the driver at once.
const CHUNK_BYTES: usize = 4096;

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

/// The store, with its health.
struct Store {
    file: StoreFile,
    /// Contacts that have no room in memory.
    spool: Option<Spool>,
    is_dirty: bool,
    failed_at: Option<Instant>,
}

struct State {
    agent: Agent,
    pending: VecDeque<Outgoing>,
    drivers: Vec<DriverLink>,
    store: Option<Store>,
    /// Moment at which the timer works next.
    timer_at: Moment,
}

/// The link to a driver, as the others see it.
struct DriverLink {
    label: String,
    /// Lines to it while it can be heard.
    telling: Option<mpsc::Sender<Vec<u8>>>,
    /// Asks its task to end the link.
    restart: Arc<Notify>,
    /// Time at which a refused line of it was last logged.
    refusal_logged_at: Option<Instant>,
}

impl DriverLink {
    fn new(config: &DriverConfig) -> Self {
        Self { label: config.label.clone(), telling: None, restart: Arc::default(), refusal_logged_at: None }
    }

    fn tell(&mut self, line: &ToDriver, refused: u64) {
        self.tell_refusal(line, refused);
        if let Some(telling) = &self.telling
            && telling.try_send(line.line()).is_err()
        {
            tracing::warn!("{} reads nothing", self.label);
            self.restart.notify_one();
        }
    }

    /// Logs a refused line, but not each one: a faulty driver may send thousands a second.
    fn tell_refusal(&mut self, line: &ToDriver, refused: u64) {
        let ToDriver::Error { line, problem, remedy } = line else { return };
        if self.refusal_logged_at.is_some_and(|at| at.elapsed() < REFUSAL_PAUSE) {
            return;
        }
        self.refusal_logged_at = Some(Instant::now());
        let label = &self.label;
        tracing::warn!("line {line} of {label} is refused ({refused} since the start): {problem}: {remedy}");
    }
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
/// The outbox, the broker's certificates or the way to the driver cannot be used. An unreachable broker or driver is no error:
/// the agent keeps trying.
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
            Some(listener) => monitor::serve(listener, || hub.lock().agent.snapshot(now())).await,
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

/// Waits for the tasks of all drivers, which end only by a panic.
async fn all_ended(driving: &mut JoinSet<()>) {
    while let Some(ended) = driving.join_next().await {
        if let Err(problem) = ended {
            tracing::error!(%problem, "the task of a driver has ended: its whiskers are not served any more");
        }
    }
}

/// Logs what of the outbox is lost, and where the rest of the damaged file is.
fn tell_damage(path: &Path, Damage { lines, torn_bytes, aside }: &Damage) {
    let path = path.display();
    if *lines > 0 {
        let kept = match aside {
            Some(aside) => format!("the damaged file is kept as {}", aside.display()),
            None => "the damaged file could not be copied".to_owned(),
        };
        tracing::error!(
            "outbox.file: {lines} lines of {path} are damaged and left out, with the contacts in them; {kept}; check the disk"
        );
    } else if *torn_bytes > 0 {
        tracing::warn!("outbox.file: the last line of {path} is incomplete, as after a power cut, and left out");
    }
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
        if let Some(file) = &mut file {
            file.replace(records)?;
        }
        let (fleet, robot) = (agent.fleet().clone(), agent.robot().clone());
        let store = file.map(|file| Store { file, spool, is_dirty: false, failed_at: None });
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
    }

    fn handle(&self, state: &mut State, outputs: Vec<Output>) {
        let mut records = Vec::new();
        let (mut to_disk, mut from_disk) = (Vec::new(), 0);
        for output in outputs {
            match output {
                Output::Spool(contacts) => to_disk.push(contacts),
                Output::TakeBack(messages) => from_disk += messages,
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
        }
        self.spool(state, &to_disk);
        self.take_back(state, from_disk);
        if !state.pending.is_empty() {
            self.signals.wake.notify_one();
        }
        if state.agent.next_deadline() < state.timer_at {
            self.timer.notify_one();
        }
    }

    /// Writes contacts to the disk, and counts those that have no room there.
    fn spool(&self, state: &mut State, contacts: &[Vec<u8>]) {
        let Some(spool) = state.store.as_mut().and_then(|store| store.spool.as_mut()) else { return };
        let mut lost = 0;
        for message in contacts {
            match spool.append(message) {
                Ok(dropped) => lost += dropped,
                Err(problem) => {
                    tracing::error!(%problem, "contacts are lost: they cannot be written to the outbox on disk");
                    lost += 1;
                }
            }
        }
        if lost > 0 {
            let outputs = state.agent.step(now(), Input::LostOnDisk(lost));
            self.handle(state, outputs);
        }
    }

    /// Gives the agent messages back from the disk.
    fn take_back(&self, state: &mut State, messages: usize) {
        for _ in 0..messages {
            let Some(spool) = state.store.as_mut().and_then(|store| store.spool.as_mut()) else { return };
            let back = spool.take().unwrap_or_else(|problem| {
                tracing::error!(%problem, "contacts are lost: they cannot be read from the outbox on disk");
                None
            });
            let back = back.as_ref().map(|(contacts, position)| (&contacts[..], *position));
            let outputs = state.agent.step(now(), Input::CameBack(back));
            self.handle(state, outputs);
            if back.is_none() {
                return;
            }
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

    /// Synchronises the store with the disk, and replaces its file when it is full.
    async fn keep_store(&self) {
        loop {
            sleep(SYNC_EVERY).await;
            {
                let mut state = self.lock();
                let State { agent, store, .. } = &mut *state;
                if let Some(store) = store {
                    store.renew(|| agent.records());
                }
            }
            self.sync().await;
        }
    }

    async fn sync(&self) {
        let (file, spooled, done) = {
            let mut state = self.lock();
            let Some(store) = &mut state.store else { return };
            let spool = store.spool.as_mut();
            let (spooled, done) = spool.map_or((None, vec![]), |spool| (spool.unsynced(), spool.done()));
            (store.unsynced(), spooled, done)
        };
        let synced = task::blocking(move || {
            [spooled, file].into_iter().flatten().try_for_each(|file| file.and_then(|file| file.sync_data()))?;
            // What was in them is on the disk in the file of the outbox.
            done.iter().try_for_each(std::fs::remove_file)
        })
        .await;
        match synced {
            Ok(Ok(())) => {}
            Ok(Err(problem)) => tracing::error!(%problem, "cannot synchronise the outbox with the disk"),
            Err(problem) => tracing::error!(%problem, "cannot synchronise the outbox with the disk"),
        }
    }

    /// Reaches a driver again and again.
    async fn drive(self, driver: usize, config: DriverConfig, mut door: Option<Door>) {
        let may_restart = config.restart || !matches!(config.way, Way::Command(_));
        let (label, restart) = (&config.label, self.lock().drivers[driver].restart.clone());
        let mut pause = LINK_PAUSE.0;
        loop {
            let began = Instant::now();
            if door.is_none() {
                door = Door::open(&config).await.inspect_err(|problem| tracing::debug!("{label}: {problem}")).ok();
            }
            let link = match &door {
                Some(door) => {
                    door.link().await.inspect_err(|problem| tracing::warn!("cannot reach {label}: {problem}")).ok()
                }
                None => None,
            };
            if let Some(mut link) = link {
                let (sender, lines) = mpsc::channel(TELLING_MAX);
                self.lock().drivers[driver].telling = Some(sender);
                self.step(Input::DriverStarted(driver));
                tracing::info!("{label} can be heard");
                let reason = self.talk(driver, &mut link, lines, may_restart.then_some(&*restart)).await;
                tracing::warn!(reason, "{label} has gone");
                self.lock().drivers[driver].telling = None;
                self.step(Input::DriverEnded(driver));
                link.close().await;
                if !may_restart {
                    tracing::error!("{label} is not started again: driver.restart is false");
                    return std::future::pending().await;
                }
            }
            if began.elapsed() >= LIVED {
                pause = LINK_PAUSE.0;
            }
            sleep(pause).await;
            pause = (2 * pause).min(LINK_PAUSE.1);
        }
    }

    /// Carries lines until the link ends; returns the reason. Lines are read no faster than they are handled.
    /// `restart` asks for the end of the link, if that may happen.
    async fn talk(
        &self,
        driver: usize,
        link: &mut Link,
        mut lines: mpsc::Receiver<Vec<u8>>,
        restart: Option<&Notify>,
    ) -> &'static str {
        let (reader, writer) = (&mut link.reader, &mut link.writer);
        let read = async {
            let (mut buffer, mut cut) = (vec![0; CHUNK_BYTES], Lines::default());
            loop {
                match reader.read(&mut buffer).await {
                    Ok(0) => return "it has closed its output",
                    Ok(read) => {
                        for line in cut.push(&buffer[..read]) {
                            self.step(Input::Line(driver, line.as_deref()));
                        }
                    }
                    Err(_) => return "its output cannot be read",
                }
            }
        };
        let write = async {
            while let Some(line) = lines.recv().await {
                if writer.write_all(&line).await.is_err() || writer.flush().await.is_err() {
                    // What it still says counts; the end of its output ends the link.
                    break;
                }
            }
            std::future::pending().await
        };
        let restarted = async {
            match restart {
                Some(restart) => restart.notified().await,
                None => std::future::pending().await,
            }
            "it is silent or reads nothing"
        };
        tokio::select! {
            reason = read => reason,
            reason = write => reason,
            reason = restarted => reason,
        }
    }
}

impl Store {
    /// The file, if records were appended that may not be on the disk yet.
    fn unsynced(&mut self) -> Option<std::io::Result<std::fs::File>> {
        std::mem::take(&mut self.is_dirty).then(|| self.file.synced())
    }

    fn append(&mut self, records: &[Record]) {
        if records.is_empty() || self.failed_at.is_some() {
            return;
        }
        self.is_dirty = true;
        if let Err(problem) = self.file.append(records) {
            tracing::error!(%problem, "a restart would lose contacts from now on");
            self.failed_at = Some(Instant::now());
        }
    }

    /// Replaces the file when it is full, or some time after it has failed.
    fn renew(&mut self, records: impl FnOnce() -> Vec<Record>) {
        let is_due = self.failed_at.map_or_else(|| self.file.is_full(), |at| at.elapsed() >= STORE_AGAIN);
        if !is_due {
            return;
        }
        match self.file.replace(records()) {
            Ok(()) => {
                if self.failed_at.take().is_some() {
                    tracing::info!("the outbox is stored again");
                }
            }
            Err(problem) => {
                tracing::error!(%problem, "a restart would lose contacts");
                self.failed_at = Some(Instant::now());
            }
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
