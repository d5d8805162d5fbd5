//! State of a transport's connection.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether a transport hears the robots: it is connected, and its subscriptions are proven or all its partitions
/// answer. The transport sets it, and the engine reads it. Clones share their state.
#[derive(Debug, Clone, Default)]
pub struct LinkState(Arc<AtomicBool>);

impl LinkState {
    /// Sets whether the robots are heard. Returns whether they were before.
    pub(crate) fn set(&self, hears: bool) -> bool {
        self.0.swap(hears, Ordering::Relaxed)
    }

    /// Whether the robots are heard.
    #[must_use]
    pub fn hears(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
