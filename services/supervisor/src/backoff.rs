//! Patience with what is away.

use std::time::Duration;

/// Waits longer each time, up to 5 s.
#[derive(Debug, Default)]
pub(crate) struct Backoff {
    tries: u32,
}

impl Backoff {
    /// Waits.
    pub(crate) async fn wait(&mut self) {
        let wait = Duration::from_millis(100 << self.tries.min(6)).min(Duration::from_secs(5));
        self.tries += 1;
        tokio::time::sleep(wait).await;
    }
}
