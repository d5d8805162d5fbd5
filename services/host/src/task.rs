//! Tasks and threads. A task runs in the process of the one that starts it ([`process`]).

use std::future::{Future, poll_fn};
use std::num::NonZero;
use std::pin::pin;
use std::time::Duration;

use tokio::runtime::Handle;
use tokio::task::{AbortHandle, JoinError, JoinHandle, JoinSet};

use crate::process;

/// Starts a task in the present runtime.
#[expect(clippy::disallowed_methods, reason = "the one place where tasks start")]
pub fn spawn<T: Send + 'static>(work: impl Future<Output = T> + Send + 'static) -> JoinHandle<T> {
    let task = tokio::spawn(here(work));
    started(|| task.abort_handle());
    task
}

/// Starts a task in a runtime.
#[expect(clippy::disallowed_methods, reason = "the one place where tasks start")]
pub fn spawn_on<T: Send + 'static>(runtime: &Handle, work: impl Future<Output = T> + Send + 'static) -> JoinHandle<T> {
    let task = runtime.spawn(here(work));
    started(|| task.abort_handle());
    task
}

/// Starts a task that ends with the set, at the latest.
#[expect(clippy::disallowed_methods, reason = "the one place where tasks start")]
pub fn spawn_in<T: Send + 'static>(
    set: &mut JoinSet<T>,
    work: impl Future<Output = T> + Send + 'static,
) -> AbortHandle {
    let task = set.spawn(here(work));
    started(|| task.clone());
    task
}

/// Does work that blocks its thread. In a simulated process it blocks all.
///
/// # Errors
/// The work has panicked.
#[expect(clippy::disallowed_methods, reason = "the one place where threads block")]
pub async fn blocking<T: Send + 'static>(work: impl FnOnce() -> T + Send + 'static) -> Result<T, JoinError> {
    match process::simulated() {
        Some(_) => Ok(work()),
        None => tokio::task::spawn_blocking(work).await,
    }
}

/// Blocks the thread for this time. A simulated process goes on at once.
#[expect(clippy::disallowed_methods, reason = "the one place where threads wait")]
pub fn block_for(pause: Duration) {
    if process::simulated().is_none() {
        std::thread::sleep(pause);
    }
}

/// Number of threads that run at the same time: that of the cores. In a simulated process it is the same on every machine.
#[must_use]
#[expect(clippy::disallowed_methods, reason = "the one place that counts cores")]
pub fn cores() -> usize {
    const SIMULATED: usize = 2;
    match process::simulated() {
        Some(_) => SIMULATED,
        None => std::thread::available_parallelism().map_or(1, NonZero::get),
    }
}

/// Work that goes on in the present process, wherever it is polled.
fn here<T>(work: impl Future<Output = T>) -> impl Future<Output = T> {
    let process = process::simulated();
    async move {
        let mut work = pin!(work);
        poll_fn(|context| match &process {
            None => work.as_mut().poll(context),
            Some(process) => process::poll(process, context, |context| work.as_mut().poll(context)),
        })
        .await
    }
}

fn started(task: impl FnOnce() -> AbortHandle) {
    if let Some(process) = process::simulated() {
        process.started(task());
    }
}
