//! The process in which a task runs: the real one, or one of several simulated ones in a single thread.
//!
//! Clock, randomness and tasks of the program come from [`clock`](crate::clock), [`random`](crate::random) and
//! [`task`](crate::task) alone. In a simulated process these ask a [`Simulated`].

use std::cell::RefCell;
use std::future::Future;
use std::io;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};

use tokio::io::{AsyncRead, AsyncWrite};
use tokio::task::AbortHandle;

use crate::time_line::TimeLine;

/// A simulated process.
pub trait Simulated: Send + Sync {
    /// Wall clock of its host, µs since 1970 UTC.
    fn host_clock_us(&self) -> i64;
    /// Its time line.
    fn time_line(&self) -> &TimeLine;
    /// Fills `bytes` with random ones.
    fn fill(&self, bytes: &mut [u8]);
    /// Whether its tasks go on now. If not, it wakes `context` when they do, or never if it is dead.
    fn goes_on(&self, context: &mut Context<'_>) -> bool;
    /// A task was started in it.
    fn started(&self, task: AbortHandle);
    /// Connects to a port of a host.
    fn connect(&self, host: &str, port: u16) -> Connecting;
}

/// A connection that carries bytes.
pub trait Stream: AsyncRead + AsyncWrite + Send + Sync + Unpin {}

impl<T: AsyncRead + AsyncWrite + Send + Sync + Unpin> Stream for T {}

/// An attempt to connect.
pub type Connecting = Pin<Box<dyn Future<Output = io::Result<Box<dyn Stream>>> + Send>>;

thread_local! {
    static CURRENT: RefCell<Option<Arc<dyn Simulated>>> = const { RefCell::new(None) };
}

/// The simulated process in which the present task runs; `None` in the real one.
#[must_use]
pub fn simulated() -> Option<Arc<dyn Simulated>> {
    CURRENT.with_borrow(Clone::clone)
}

/// Runs `work` in this process.
pub fn enter<T>(process: Option<Arc<dyn Simulated>>, work: impl FnOnce() -> T) -> T {
    /// Leaves the process also after a panic.
    struct Leave(Option<Arc<dyn Simulated>>);
    impl Drop for Leave {
        fn drop(&mut self) {
            CURRENT.set(self.0.take());
        }
    }
    let _leave = Leave(CURRENT.replace(process));
    work()
}

/// Polls a future in this process, if its tasks go on.
pub(crate) fn poll<T>(
    process: &Arc<dyn Simulated>,
    context: &mut Context<'_>,
    future: impl FnOnce(&mut Context<'_>) -> Poll<T>,
) -> Poll<T> {
    if !process.goes_on(context) {
        return Poll::Pending;
    }
    enter(Some(process.clone()), || future(context))
}
