//! The part of an agent that survives a restart: unreceipted contacts messages with their boots, and the highest setpoint seen of
//! each whisker.
//!
//! [`Record`] is the pure part; [`file`] keeps records in a file, and [`spool`] contacts that have no room in memory.

pub mod file;
mod private;
pub mod spool;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;
use vibrissa_protocol::{BootId, Name};

use spool::Position;

/// One change of the state.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Record {
    /// A boot, with the numbers of births and factsheets that it has sent so far.
    Boot {
        /// The boot.
        boot_id: BootId,
        /// Births sent.
        births: u64,
        /// Factsheets sent.
        factsheets: u64,
    },
    /// A contacts message without a receipt.
    Contacts {
        /// Its boot.
        boot_id: BootId,
        /// Its number in that boot.
        seq: u64,
        /// The message.
        payload: Payload,
        /// Position on the disk after it, if it has come from there.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        spooled: Option<Position>,
    },
    /// Contacts before this position have come back from the disk.
    Spooled {
        /// Number of the segment.
        segment: u64,
        /// Bytes of it.
        bytes: u64,
    },
    /// A receipt.
    Receipt {
        /// The boot whose messages it covers.
        boot_id: BootId,
        /// All below this are covered.
        next: u64,
        /// Covered ranges beyond.
        held: Vec<(u64, u64)>,
    },
    /// The highest order seen for a whisker.
    Seen {
        /// Array of the whisker.
        array: Name,
        /// Its number.
        whisker: u16,
        /// Epoch of the supervisor.
        epoch: u64,
        /// Version of the setpoint or touch test.
        version: u64,
    },
}

/// A message as JSON.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Payload(Box<RawValue>);

impl Payload {
    /// Of an encoded message; `None` if it is no JSON.
    #[must_use]
    pub fn new(message: &[u8]) -> Option<Self> {
        let text = std::str::from_utf8(message).ok()?;
        RawValue::from_string(text.to_owned()).ok().map(Self)
    }

    /// The encoded message.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        self.0.get().as_bytes()
    }
}

impl PartialEq for Payload {
    fn eq(&self, other: &Self) -> bool {
        self.bytes() == other.bytes()
    }
}

impl PartialEq for Record {
    fn eq(&self, other: &Self) -> bool {
        serde_json::to_string(self).ok() == serde_json::to_string(other).ok()
    }
}

/// The state that records lead to.
#[derive(Debug, Default, PartialEq)]
pub struct Stored {
    /// Boots, the oldest first.
    pub boots: Vec<StoredBoot>,
    /// Highest (epoch, version) seen of each whisker.
    pub seen: BTreeMap<(Name, u16), (u64, u64)>,
    /// Position on the disk before which contacts have come back.
    pub spooled: Option<Position>,
    /// Whether contacts wait there.
    pub is_spooled: bool,
}

/// One boot.
#[derive(Debug, PartialEq)]
pub struct StoredBoot {
    /// Its id.
    pub boot_id: BootId,
    /// Births sent.
    pub births: u64,
    /// Factsheets sent.
    pub factsheets: u64,
    /// Whether a supervisor knows the boot: a receipt has come.
    pub is_known: bool,
    /// Messages without a receipt.
    pub messages: BTreeMap<u64, Payload>,
}

impl Stored {
    /// Takes a record.
    pub fn take(&mut self, record: Record) {
        match record {
            Record::Boot { boot_id, births, factsheets } => {
                let boot = self.boot(boot_id);
                (boot.births, boot.factsheets) = (births, factsheets);
            }
            Record::Contacts { boot_id, seq, payload, spooled } => {
                self.boot(boot_id).messages.insert(seq, payload);
                self.spooled = self.spooled.max(spooled);
            }
            Record::Spooled { segment, bytes } => self.spooled = self.spooled.max(Some((segment, bytes))),
            Record::Receipt { boot_id, next, held } => {
                let boot = self.boot(boot_id);
                boot.is_known = true;
                boot.messages
                    .retain(|&seq, _| seq >= next && !held.iter().any(|&(first, last)| (first..=last).contains(&seq)));
            }
            Record::Seen { array, whisker, epoch, version } => {
                let seen = self.seen.entry((array, whisker)).or_default();
                *seen = (*seen).max((epoch, version));
            }
        }
    }

    fn boot(&mut self, boot_id: BootId) -> &mut StoredBoot {
        let at = self.boots.iter().position(|boot| boot.boot_id == boot_id).unwrap_or_else(|| {
            let messages = BTreeMap::new();
            self.boots.push(StoredBoot { boot_id, births: 0, factsheets: 0, is_known: false, messages });
            self.boots.len() - 1
        });
        &mut self.boots[at]
    }
}
