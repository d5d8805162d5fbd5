//! Dedicated threads for work that each message wakes.
//!
//! Threads of a shared runtime wake each other to look for work, and each wake-up finds cold caches: in a fleet with
//! little traffic, that is most of a message's cost.

use std::future::Future;

use tokio::runtime::Builder;
use tokio::sync::watch;
use tokio::task::{JoinHandle, spawn_blocking};
use tracing::error;

use crate::mqtt::stopped;

/// Runs `work` in a dedicated thread until it ends or `stop` is set. `None` if it was stopped, or if the thread could
/// not be started.
pub(crate) fn spawn<T: Send + 'static>(
    name: &'static str,
    work: impl Future<Output = T> + Send + 'static,
    mut stop: watch::Receiver<bool>,
) -> JoinHandle<Option<T>> {
    spawn_blocking(move || {
        let runtime = Builder::new_current_thread().enable_all().build();
        let runtime = runtime.inspect_err(|problem| error!(%problem, thread = name, "cannot start the thread")).ok()?;
        let ended = runtime.block_on(async {
            tokio::select! {
                ended = work => Some(ended),
                () = stopped(&mut stop) => None,
            }
        });
        // Does not wait for blocking tasks such as a DNS lookup.
        runtime.shutdown_background();
        ended
    })
}

#[cfg(test)]
mod tests {
    use std::future::pending;

    use super::*;

    #[tokio::test]
    async fn work_ends_by_itself_or_is_stopped() {
        let (stop, stopping) = watch::channel(false);
        let here = std::thread::current().id();
        let elsewhere = spawn("test", async move { std::thread::current().id() != here }, stopping.clone());
        assert_eq!(elsewhere.await.unwrap(), Some(true));
        let endless = spawn("test", pending::<()>(), stopping);
        stop.send(true).unwrap();
        assert_eq!(endless.await.unwrap(), None);
    }
}
