//! Record of a robot's actions, for tests that compare it with the supervisor's records.
//!
//! It is independent of the rules by which the robot accepts setpoints, so it exposes a robot that breaks them.

use vibrissa_protocol::{BootId, Contacts, Setpoint};

/// One entry, in chronological order.
#[derive(Debug, Clone, PartialEq)]
pub enum JournalEntry {
    /// Contacts were made and have this sequence number, whether or not they can be sent.
    Felt(Contacts),
    /// A setpoint arrived, accepted or not.
    Heard(HeardSetpoint),
    /// A regulator was given a setpoint's pressure as its target.
    Applied(HeardSetpoint),
}

/// A setpoint with its circumstances.
#[derive(Debug, Clone, PartialEq)]
pub struct HeardSetpoint {
    /// Time by the robot's clock, in microseconds since 1970 UTC.
    pub at_us: u64,
    /// Boot of the robot at that time.
    pub boot_id: BootId,
    /// The setpoint as it arrived.
    pub setpoint: Setpoint,
}

/// The entries since the last [`Journal::take`]; none unless `kept` is set.
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
