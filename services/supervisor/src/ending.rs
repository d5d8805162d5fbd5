//! The end of a fleet's supervision here.

/// Why an engine has ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// It was told to, and everything that it had is committed.
    Stopped,
    /// The fleet is somebody else's.
    LeaseLost,
}
