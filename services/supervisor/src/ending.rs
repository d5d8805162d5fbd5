//! The end of a fleet's supervision here.

/// Why an engine has ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// The service stops or gives the fleet back; every message that was taken is committed.
    Stopped,
    /// The fleet is somebody else's.
    LeaseLost,
}
