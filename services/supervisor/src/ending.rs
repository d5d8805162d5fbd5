//! The end of a fleet's engine, and of other work.

use tokio::sync::watch;

/// Reason why an engine has ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Ending {
    /// The service stops or releases the fleet; all received messages are committed.
    Stopped,
    /// Another supervisor has acquired the fleet's lease.
    LeaseLost,
}

/// Returns when the flag is set, or when its sender is gone.
pub(crate) async fn stopped(stop: &mut watch::Receiver<bool>) {
    let _ = stop.wait_for(|&stop| stop).await;
}
