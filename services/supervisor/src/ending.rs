//! The end of a fleet's engine.

/// Reason why an engine has ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Ending {
    /// The service stops or releases the fleet; all received messages are committed.
    Stopped,
    /// Another supervisor has acquired the fleet's lease.
    LeaseLost,
}
