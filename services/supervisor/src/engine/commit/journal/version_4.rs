//! Entries of version 4, whose references to a partitioned log do not name the partition.

use borsh::BorshDeserialize;
use vibrissa_core::units::Micros;

use super::{JournalContact, JournalEvent, JournalStatus};
use crate::engine::part::Part;
use crate::log_inbox::LogRange;

#[derive(BorshDeserialize)]
pub(super) struct Entry {
    robot_id: i64,
    now: Micros,
    event: Event,
}

#[derive(BorshDeserialize)]
enum Event {
    Tick,
    Contacts { boot: i64, seq: u64, contacts: Vec<JournalContact> },
    Status { boot: i64, robot_time: Micros, whiskers: Vec<JournalStatus> },
    Log { from: i64, to: i64, part: Part, except: Vec<i64> },
    TickAll { part: Part },
}

impl Entry {
    /// The entry, whose records are in this partition.
    pub(super) fn of_partition(self, partition: u32) -> super::Entry {
        let event = match self.event {
            Event::Tick => JournalEvent::Tick,
            Event::Contacts { boot, seq, contacts } => JournalEvent::Contacts { boot, seq, contacts },
            Event::Status { boot, robot_time, whiskers } => JournalEvent::Status { boot, robot_time, whiskers },
            Event::Log { from, to, part, except } => {
                JournalEvent::Log { range: LogRange { partition, from, to }, part, except }
            }
            Event::TickAll { part } => JournalEvent::TickAll { part },
        };
        super::Entry { robot_id: self.robot_id, now: self.now, event }
    }
}
