//! A simulated process: its host's clock, its randomness, its tasks, and its ways to the servers. It can be frozen, and killed at any
//! await point.

use std::sync::atomic::{AtomicI64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Waker};

use rand::{RngCore as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use tokio::task::AbortHandle;
use tokio::time::Instant;
use vibrissa_host::TimeLine;
use vibrissa_host::process::{self, Connecting, Simulated, Stream};

use crate::broker::Route;

/// Finished tasks are forgotten when there are this many.
const TASKS: usize = 256;

/// The wall clock of a host.
#[derive(Debug)]
pub struct HostClock {
    began: Instant,
    at_us: AtomicI64,
    /// How much faster than true time it runs, in millionths.
    drift_ppm: i64,
}

impl HostClock {
    /// A clock that shows `at_us`, µs since 1970 UTC, now, and runs `drift_ppm` millionths too fast.
    #[must_use]
    pub fn new(at_us: i64, drift_ppm: i64) -> Self {
        Self { began: Instant::now(), at_us: AtomicI64::new(at_us), drift_ppm }
    }

    /// Its time, µs since 1970 UTC.
    #[must_use]
    pub fn now_us(&self) -> i64 {
        let since_us = i64::try_from(self.began.elapsed().as_micros()).unwrap_or(i64::MAX);
        self.at_us.load(Ordering::Relaxed) + since_us + since_us / 1_000_000 * self.drift_ppm
    }

    /// Steps it ahead by so many µs.
    pub fn step(&self, by_us: i64) {
        self.at_us.fetch_add(by_us, Ordering::Relaxed);
    }
}

/// Host of the partitioned log.
pub const LOG_HOST: &str = "log";

/// A host's ways to the servers.
#[derive(Debug, Clone)]
pub struct Routes {
    /// To the broker, whatever its host is called.
    pub broker: Route,
    /// To the partitioned log, at [`LOG_HOST`].
    pub log: Route,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    Running,
    Frozen,
    Dead,
}

#[derive(Debug)]
struct Life {
    state: State,
    /// Number of freezes that have not ended.
    freezes: u32,
    /// Polls of its tasks until it is killed.
    polls_left: Option<u64>,
    /// Tasks that wait for the end of the freeze.
    waiting: Vec<Waker>,
    tasks: Vec<AbortHandle>,
}

/// A process, which is alive from its start to [`Process::kill`].
#[derive(Debug)]
pub struct Process {
    host: Arc<HostClock>,
    line: TimeLine,
    random: Mutex<ChaCha8Rng>,
    life: Mutex<Life>,
    routes: Routes,
}

impl Process {
    /// A new process on this host, with these ways to the servers.
    #[must_use]
    pub fn new(seed: u64, host: Arc<HostClock>, routes: Routes) -> Arc<Self> {
        let life = Life { state: State::Running, freezes: 0, polls_left: None, waiting: Vec::new(), tasks: Vec::new() };
        let line = TimeLine::from(host.now_us());
        Arc::new(Self {
            host,
            line,
            random: Mutex::new(ChaCha8Rng::seed_from_u64(seed)),
            life: Mutex::new(life),
            routes,
        })
    }

    /// Runs `work` in this process. The tasks that it starts belong to the process.
    pub fn enter<T>(self: &Arc<Self>, work: impl FnOnce() -> T) -> T {
        process::enter(Some(self.clone()), work)
    }

    /// Kills it at its next poll but `polls`.
    pub fn kill_after(&self, polls: u64) {
        self.life().polls_left = Some(polls);
    }

    /// Kills it: no task of it goes on.
    pub fn kill(&self) {
        let tasks = self.life().end();
        tasks.iter().for_each(AbortHandle::abort);
    }

    /// Whether it was killed.
    #[must_use]
    pub fn is_dead(&self) -> bool {
        self.life().state == State::Dead
    }

    /// Stops all of its tasks until [`Process::thaw`] was called as often.
    pub fn freeze(&self) {
        let mut life = self.life();
        life.freezes += 1;
        if life.state == State::Running {
            life.state = State::Frozen;
        }
    }

    /// Lets its tasks go on.
    pub fn thaw(&self) {
        let waiting = {
            let mut life = self.life();
            life.freezes = life.freezes.saturating_sub(1);
            if life.freezes > 0 {
                return;
            }
            if life.state == State::Frozen {
                life.state = State::Running;
            }
            std::mem::take(&mut life.waiting)
        };
        waiting.into_iter().for_each(Waker::wake);
    }

    fn life(&self) -> MutexGuard<'_, Life> {
        self.life.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Life {
    fn end(&mut self) -> Vec<AbortHandle> {
        self.state = State::Dead;
        self.waiting.clear();
        std::mem::take(&mut self.tasks)
    }
}

impl Simulated for Process {
    fn host_clock_us(&self) -> i64 {
        self.host.now_us()
    }

    fn time_line(&self) -> &TimeLine {
        &self.line
    }

    fn fill(&self, bytes: &mut [u8]) {
        self.random.lock().unwrap_or_else(PoisonError::into_inner).fill_bytes(bytes);
    }

    fn goes_on(&self, context: &mut Context<'_>) -> bool {
        let ended = {
            let mut life = self.life();
            match life.state {
                State::Dead => return false,
                State::Frozen => {
                    life.waiting.push(context.waker().clone());
                    return false;
                }
                State::Running => match &mut life.polls_left {
                    None => return true,
                    Some(0) => life.end(),
                    Some(left) => {
                        *left -= 1;
                        return true;
                    }
                },
            }
        };
        ended.iter().for_each(AbortHandle::abort);
        false
    }

    fn started(&self, task: AbortHandle) {
        let mut life = self.life();
        if life.state == State::Dead {
            drop(life);
            return task.abort();
        }
        if life.tasks.len() >= TASKS && life.tasks.len().is_power_of_two() {
            life.tasks.retain(|task| !task.is_finished());
        }
        life.tasks.push(task);
    }

    fn connect(&self, host: &str, _port: u16) -> Connecting {
        let route = if host == LOG_HOST { &self.routes.log } else { &self.routes.broker }.clone();
        Box::pin(async move { route.connect().await.map(|end| Box::new(end) as Box<dyn Stream>) })
    }
}
