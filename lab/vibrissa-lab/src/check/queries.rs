//! Queries on the messages received from a robot.

use tokio::time::Instant;
use vibrissa_edge::clock::wall_clock;
use vibrissa_protocol::{Connection, Message, Name, Status, SupervisorPresence, WhiskerStatus};

use super::listener::Listener;

impl Listener {
    /// Epoch of the supervisor that owns the fleet now.
    pub(super) fn supervised(&self) -> Option<u64> {
        self.supervisor.as_ref().filter(|state| state.state == SupervisorPresence::Online).map(|state| state.epoch)
    }

    /// Connection messages since a position in the log, each with its position and the retain flag.
    pub(super) fn connections(&self, mark: usize) -> impl Iterator<Item = (usize, &Connection, bool)> {
        self.log.iter().enumerate().skip(mark).filter_map(|(at, entry)| match &entry.message {
            Message::Connection(connection) => Some((at, connection, entry.retained)),
            Message::Factsheet(_)
            | Message::Contacts(_)
            | Message::Status(_)
            | Message::SetpointState(_)
            | Message::TestState(_)
            | Message::Receipt(_)
            | Message::Setpoint(_)
            | Message::Request(_)
            | Message::Estimate(_)
            | Message::Maintenance(_)
            | Message::SupervisorState(_)
            | Message::SupervisorRequest(_) => None,
        })
    }

    /// Statuses since a position in the log.
    pub(super) fn statuses(&self, mark: usize) -> impl Iterator<Item = (&Status, Instant)> {
        self.log[mark..].iter().filter_map(|entry| match &entry.message {
            Message::Status(status) => Some((status, entry.at)),
            Message::Connection(_)
            | Message::Factsheet(_)
            | Message::Contacts(_)
            | Message::SetpointState(_)
            | Message::TestState(_)
            | Message::Receipt(_)
            | Message::Setpoint(_)
            | Message::Request(_)
            | Message::Estimate(_)
            | Message::Maintenance(_)
            | Message::SupervisorState(_)
            | Message::SupervisorRequest(_) => None,
        })
    }

    /// The whisker's entry in the newest status, and the time of its arrival.
    pub(super) fn newest(&self, mark: usize, (array, whisker): (&Name, u16)) -> Option<(WhiskerStatus, Instant)> {
        let (status, at) = self.statuses(mark).last()?;
        let entry = status.whiskers.iter().find(|one| one.array == *array && one.whisker == whisker)?;
        Some((entry.clone(), at))
    }

    /// The robot's clock now, from its newest status; this machine's clock if there was no status.
    pub(super) fn robot_clock_us(&self) -> u64 {
        let newest = self.statuses(0).last().map(|(status, at)| status.t_us + at.elapsed().as_micros() as u64);
        newest.unwrap_or_else(|| wall_clock().0)
    }
}
