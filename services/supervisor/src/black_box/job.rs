//! Work for the writer of boxes.

use prometheus::IntCounter;
use tokio::sync::oneshot;
use vibrissa_core::units::Micros;
use vibrissa_protocol::Name;
use vibrissa_store::Lease;

use super::tape::TapeCopy;

/// Work for the writer.
#[derive(Debug)]
pub(super) enum Job {
    /// Writes a box.
    Write(Box<BoxToWrite>),
    /// Answers when all earlier boxes are written.
    Flush(oneshot::Sender<()>),
}

/// A box to write: a copy of the robot's tape, and what the row says about it.
#[derive(Debug)]
pub(super) struct BoxToWrite {
    pub(super) lease: Lease,
    pub(super) lost: IntCounter,
    pub(super) robot_id: i64,
    pub(super) robot: Name,
    pub(super) whisker_id: i64,
    pub(super) cause: &'static str,
    pub(super) event: Micros,
    pub(super) from: Micros,
    pub(super) ends: Micros,
    pub(super) left_out: u64,
    pub(super) state: &'static str,
    pub(super) base: [Option<Vec<u8>>; 2],
    pub(super) tape: TapeCopy,
}
