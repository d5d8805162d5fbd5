//! The module `vibrissa_robot._native`: the agent in a thread of the Python process.
//!
//! Python is its driver and reaches it at a Unix socket, by the lines of the driver interface.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};

use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use tokio::sync::watch;
use tracing_subscriber::EnvFilter;
use vibrissa_robot::config::BadConfig;
use vibrissa_robot::{Config, ending, exposure, hub};

/// Why the agent has ended; shared with its thread.
type Failure = Arc<Mutex<Option<String>>>;

fn set(failure: &Failure, problem: String) {
    *failure.lock().unwrap_or_else(PoisonError::into_inner) = Some(problem);
}

fn run(config: Config, stopping: watch::Receiver<bool>, failure: &Failure) {
    let run = || {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().max_blocking_threads(2).build();
        let runtime = runtime.map_err(|problem| problem.to_string())?;
        runtime.block_on(hub::run(config, stopping)).map_err(|problem| problem.to_string())
    };
    // Nobody joins this thread before the robot is closed, so a panic must be told, too.
    set(failure, ending::reason(run));
}

/// The agent of one robot.
#[pyclass(frozen)]
struct Agent {
    stop: watch::Sender<bool>,
    thread: Mutex<Option<JoinHandle<()>>>,
    failure: Failure,
}

#[pymethods]
impl Agent {
    /// Starts an agent that listens for its driver at a Unix socket.
    #[new]
    fn start(config: PathBuf, socket: PathBuf, log: &str) -> PyResult<Self> {
        let filter = EnvFilter::try_new(log).map_err(|problem| PyValueError::new_err(format!("log: {problem}")))?;
        // The first agent of a process decides; a program may also have a subscriber of its own.
        let _ = vibrissa_program::log::start(filter);
        let named = |problem: BadConfig| PyValueError::new_err(format!("{}: {problem}", config.display()));
        let read = Config::read_driven_at(&config, socket).map_err(named)?;
        exposure::warn(&config, &read);
        let (stop, stopping) = watch::channel(false);
        let failure = Failure::default();
        let shared = Arc::clone(&failure);
        let thread = thread::Builder::new().name("vibrissa-robot".to_owned());
        let thread = thread.spawn(move || run(read, stopping, &shared));
        let thread = thread.map_err(|problem| PyRuntimeError::new_err(problem.to_string()))?;
        Ok(Self { stop, thread: Mutex::new(Some(thread)), failure })
    }

    /// Why the agent has ended; None while it runs.
    fn failure(&self) -> Option<String> {
        self.failure.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Stops the agent: it says farewell to the supervisor, and stores contacts without a receipt.
    fn stop(&self, py: Python<'_>) {
        py.detach(|| {
            // An error here means that the agent has already ended.
            let _ = self.stop.send(true);
            let thread = self.thread.lock().unwrap_or_else(PoisonError::into_inner).take();
            let _ = thread.map(JoinHandle::join);
        });
    }
}

/// The agent in a thread of this process.
#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Agent>()
}
