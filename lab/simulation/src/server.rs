//! The database server, and each supervisor's way to it.

use std::io;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tokio::sync::{Notify, watch};
use tokio::time::sleep;
use vibrissa_store::model::{Model, ModelServer, Way};

use crate::process::HostClock;
use crate::store::{ModelStore, Program};

/// Latency of the network in one direction.
const LATENCY: Duration = Duration::from_micros(150);
/// Time that the server takes for a request.
const WORK: Duration = Duration::from_millis(1);

/// The server; clones are the same one.
#[derive(Debug, Clone)]
pub struct StoreServer(Arc<Inner>);

#[derive(Debug)]
struct Inner {
    data: Mutex<ModelStore>,
    clock: HostClock,
    condition: Mutex<Condition>,
    leaders: watch::Sender<u64>,
}

#[derive(Debug)]
struct Condition {
    is_up: bool,
    /// Its disk is full.
    is_full: bool,
    /// Time that a request takes.
    work: Duration,
    /// The newest program that has been started with it.
    program: Program,
}

impl StoreServer {
    /// An empty database whose clock shows `clock_us`, µs since 1970 UTC.
    #[must_use]
    pub fn new(clock_us: i64) -> Self {
        Self(Arc::new(Inner {
            data: Mutex::default(),
            clock: HostClock::new(clock_us, 0),
            condition: Mutex::new(Condition { is_up: true, is_full: false, work: WORK, program: Program::Present }),
            leaders: watch::Sender::new(0),
        }))
    }

    /// The data, with the present time.
    pub fn data(&self) -> MutexGuard<'_, ModelStore> {
        let mut data = locked(&self.0.data);
        data.set_clock(self.0.clock.now_us());
        data.set_full(locked(&self.0.condition).is_full);
        data
    }

    /// Its clock.
    #[must_use]
    pub fn clock(&self) -> &HostClock {
        &self.0.clock
    }

    /// Sets whether it answers.
    pub fn set_up(&self, is_up: bool) {
        locked(&self.0.condition).is_up = is_up;
    }

    /// Sets whether its disk is full.
    pub fn set_full(&self, is_full: bool) {
        locked(&self.0.condition).is_full = is_full;
    }

    /// Sets the time that a request takes; `None` for the usual one.
    pub fn set_work(&self, work: Option<Duration>) {
        locked(&self.0.condition).work = work.unwrap_or(WORK);
    }

    /// The newest program that has been started with it: an earlier one does not start any more.
    #[must_use]
    pub fn program(&self) -> Program {
        locked(&self.0.condition).program
    }

    /// Starts the next program with it.
    pub fn upgrade(&self) {
        locked(&self.0.condition).program = Program::Next;
    }

    /// Goes back to an earlier state, as after a failover to a server that lacks the last commits.
    pub fn fail_over_to(&self, earlier: ModelStore) {
        *locked(&self.0.data) = earlier;
        self.0.leaders.send_modify(|count| *count += 1);
    }

    /// A new way to it.
    #[must_use]
    pub fn way(&self) -> Arc<StoreWay> {
        Arc::new(StoreWay {
            server: self.clone(),
            faults: Mutex::default(),
            changed: Notify::new(),
            program: Mutex::new(self.program()),
        })
    }
}

/// Faults of a way.
#[derive(Debug, Default)]
struct Faults {
    is_request_cut: bool,
    is_answer_cut: bool,
    are_answers_lost: bool,
}

/// A supervisor's way to the server.
#[derive(Debug)]
pub struct StoreWay {
    server: StoreServer,
    faults: Mutex<Faults>,
    changed: Notify,
    /// The program of the supervisor.
    program: Mutex<Program>,
}

impl StoreWay {
    /// Cuts the way of requests, or mends it.
    pub fn cut_requests(&self, is_cut: bool) {
        locked(&self.faults).is_request_cut = is_cut;
        self.changed.notify_waiters();
    }

    /// Cuts the way of answers, or mends it.
    pub fn cut_answers(&self, is_cut: bool) {
        locked(&self.faults).is_answer_cut = is_cut;
        self.changed.notify_waiters();
    }

    /// A supervisor starts: with the newest program of the database.
    pub fn start(&self) {
        *locked(&self.program) = self.server.program();
    }

    /// The version of the program that asks.
    #[must_use]
    pub fn program(&self) -> Program {
        *locked(&self.program)
    }

    /// Breaks the connection after each request, or stops to do so.
    pub fn lose_answers(&self, are_lost: bool) {
        locked(&self.faults).are_answers_lost = are_lost;
    }

    async fn pass(&self, is_cut: impl Fn(&Faults) -> bool) {
        sleep(LATENCY).await;
        loop {
            let changed = self.changed.notified();
            if !is_cut(&locked(&self.faults)) {
                return;
            }
            changed.await;
        }
    }

    fn is_up(&self) -> io::Result<()> {
        match locked(&self.server.0.condition).is_up {
            true => Ok(()),
            false => Err(io::ErrorKind::ConnectionRefused.into()),
        }
    }
}

impl ModelServer for StoreWay {
    fn reach(&self) -> Way<'_> {
        Box::pin(async {
            self.pass(|faults| faults.is_request_cut).await;
            self.is_up()?;
            let work = locked(&self.server.0.condition).work;
            sleep(work).await;
            self.is_up()
        })
    }

    fn answer(&self) -> Way<'_> {
        Box::pin(async {
            self.pass(|faults| faults.is_answer_cut).await;
            if locked(&self.faults).are_answers_lost {
                return Err(io::ErrorKind::ConnectionReset.into());
            }
            self.is_up()
        })
    }

    fn with(&self, work: &mut dyn FnMut(&mut dyn Model)) {
        let mut data = self.server.data();
        data.set_program(self.program());
        work(&mut *data);
    }

    fn leader_changes(&self) -> watch::Receiver<u64> {
        self.server.0.leaders.subscribe()
    }
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
