//! Growing pauses between attempts to reach a service.

use std::time::Duration;

/// Pauses of 0.1 s, doubled each time, up to 5 s.
#[derive(Debug, Default)]
pub(crate) struct Backoff {
    tries: u32,
}

impl Backoff {
    /// Waits for the next pause.
    pub(crate) async fn wait(&mut self) {
        let wait = Duration::from_millis(100 << self.tries.min(6)).min(Duration::from_secs(5));
        self.tries += 1;
        tokio::time::sleep(wait).await;
    }
}
