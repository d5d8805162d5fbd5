//! What a robot did, written down where it does it: for tests that hold it against what others recorded.
//!
//! It knows nothing of the rules by which the robot takes or refuses a setpoint, so that a robot that breaks
//! them is found out by whoever reads it.

use vibrissa_protocol::{BootId, Contacts, Setpoint};

/// One entry, in the order in which things happened.
#[derive(Debug, Clone, PartialEq)]
pub enum JournalEntry {
    /// Contacts were felt; they have this number, whether or not they can be sent.
    Felt(Contacts),
    /// A setpoint arrived, whatever comes of it.
    Heard(HeardSetpoint),
    /// A regulator was given a setpoint's pressure as its target.
    Applied(HeardSetpoint),
}

/// A setpoint with the circumstances.
#[derive(Debug, Clone, PartialEq)]
pub struct HeardSetpoint {
    /// When, by the robot's clock: microseconds since 1970 UTC.
    pub at_us: u64,
    /// The robot's boot at that moment.
    pub boot_id: BootId,
    /// The setpoint as it arrived.
    pub setpoint: Setpoint,
}

/// The entries since they were last taken; nothing is written unless it is kept.
#[derive(Debug, Default)]
pub(crate) struct Journal {
    kept: bool,
    entries: Vec<JournalEntry>,
}

impl Journal {
    pub(crate) fn new(kept: bool) -> Self {
        Self { kept, entries: Vec::new() }
    }

    pub(crate) fn write(&mut self, entry: impl FnOnce() -> JournalEntry) {
        if self.kept {
            self.entries.push(entry());
        }
    }

    pub(crate) fn take(&mut self) -> Vec<JournalEntry> {
        std::mem::take(&mut self.entries)
    }
}
