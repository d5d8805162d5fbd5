//! Messages received from a robot, and their parts.

use tokio::time::Instant;
use vibrissa_protocol::{Factsheet, Gauge, Message, Name, Regulator, Status, WhiskerFacts};

/// A valid message.
#[derive(Debug, Clone)]
pub(super) struct Entry {
    pub(super) at: Instant,
    pub(super) message: Message,
    pub(super) retained: bool,
}

/// All whiskers on a factsheet.
pub(super) fn whiskers(factsheet: &Factsheet) -> impl Iterator<Item = (&Name, u16)> {
    factsheet.arrays.iter().flat_map(|array| array.whiskers.iter().map(move |one| (&array.array, one.whisker)))
}

/// A whisker's facts on a factsheet.
pub(super) fn facts<'a>(factsheet: &'a Factsheet, (array, whisker): (&Name, u16)) -> Option<&'a WhiskerFacts> {
    let arrays = factsheet.arrays.iter().filter(|one| one.array == *array);
    arrays.flat_map(|one| &one.whiskers).find(|one| one.whisker == whisker)
}

/// Conditions of regulator and gauge of all whiskers in a status.
pub(super) fn conditions(status: &Status) -> Vec<(Regulator, Gauge)> {
    status.whiskers.iter().map(|one| (one.regulator, one.gauge)).collect()
}
