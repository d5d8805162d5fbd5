//! Threads of their own for what is woken by each message.
//!
//! Threads of a shared runtime wake each other to look for work, and each wake-up finds everything cold: in a fleet that does
//! little, that is most of what a message costs.

use std::future::Future;

use tokio::runtime::Builder;
use tokio::sync::watch;
use tokio::task::{JoinHandle, spawn_blocking};
use tracing::error;

use crate::mqtt::stopped;

/// Does `work` in a thread of its own until it ends or is to `stop`; none if it was stopped, or if there is no thread for it.
pub(crate) fn spawn<T: Send + 'static>(
    name: &'static str,
    work: impl Future<Output = T> + Send + 'static,
    mut stop: watch::Receiver<bool>,
) -> JoinHandle<Option<T>> {
    spawn_blocking(move || {
        let runtime = Builder::new_current_thread().enable_all().build();
        let runtime = runtime.inspect_err(|problem| error!(%problem, thread = name, "cannot be started")).ok()?;
        let ended = runtime.block_on(async {
            tokio::select! {
                ended = work => Some(ended),
                () = stopped(&mut stop) => None,
            }
        });
        // Whoever looks a host's address up is not waited for.
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
