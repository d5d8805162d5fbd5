//! The limit of the events that wait for Kafka: while it is reached, contacts are left out.

use std::sync::atomic::{AtomicBool, AtomicI64, Ordering};

use tracing::{info, warn};
use vibrissa_protocol::Name;
use vibrissa_store::events::write::EventRow;

use crate::metrics::FleetMetrics;

/// Room for a fleet's contacts among the waiting events. The engine adds what it writes, the publisher takes away what the log has
/// acknowledged.
///
/// The size is an estimate: an event counts before its transaction is committed. The publisher measures it from time to time.
#[derive(Debug)]
pub(crate) struct OutboxRoom {
    pub(crate) fleet: Name,
    pub(crate) metrics: FleetMetrics,
    /// Bytes of waiting events from which contacts are left out, until half of them wait.
    pub(crate) bytes_max: i64,
    /// Bytes of waiting events.
    pub(crate) bytes: AtomicI64,
    /// Whether contacts are left out.
    pub(crate) is_full: AtomicBool,
}

impl OutboxRoom {
    /// Counts an event that the engine adds.
    pub(crate) fn add(&self, event: &EventRow) {
        self.bytes.fetch_add(event.data.len() as i64, Ordering::Relaxed);
    }

    /// Whether contacts must be left out. Says so when that changes.
    pub(crate) fn is_full(&self) -> bool {
        let bytes = self.bytes.load(Ordering::Relaxed);
        let was_full = self.is_full.load(Ordering::Relaxed);
        // Half of the limit, so that a log that is too slow makes few and long gaps.
        let is_full = bytes >= if was_full { self.bytes_max / 2 } else { self.bytes_max };
        // Several threads step the robots of a fleet; one of them says it.
        let changes = |from, to| self.is_full.compare_exchange(from, to, Ordering::Relaxed, Ordering::Relaxed).is_ok();
        if is_full != was_full && changes(was_full, is_full) {
            let (fleet, left_out) = (&self.fleet, self.metrics.contacts_left_out.get());
            if is_full {
                warn!(%fleet, bytes, "too many events wait for the log, contacts are left out; all other events are kept");
            } else {
                info!(%fleet, bytes, left_out, "contacts are published again; left_out counts those since the start");
            }
        }
        is_full
    }

    /// Leaves contacts out.
    pub(crate) fn leave_out(&self, contacts: u64) {
        self.metrics.contacts_left_out.inc_by(contacts);
    }
}
