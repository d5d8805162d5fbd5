//! The outbox of events (table `event_outbox`): they are written in the transaction that causes them, and deleted after a
//! partitioned log has acknowledged them.
//!
//! An event is named by the epoch of the lease, the number of the transaction under the lease, and its index there. Names of
//! a fleet rise, so whoever reads the log recognises an event that was written twice.

use borsh::{BorshDeserialize, BorshSerialize};
use vibrissa_protocol::Name;

use super::batch::EventRow;
use super::database::{Either, Tx, on};
use super::from_row::from_row;
use super::tables::OutboxRow;
use super::{Lease, Store, StoreError, failed};

/// Version of a serialized event.
const VERSION: u8 = 1;
/// Rows that one query reads. A row has the events of one transaction, which the engine limits.
const ROWS_A_QUERY: i64 = 32;

/// An event that waits.
#[derive(Debug, Clone, PartialEq, Eq, BorshSerialize, BorshDeserialize)]
pub struct WaitingEvent {
    /// Name of its robot.
    pub robot: String,
    /// Whether it is about contacts, which have a topic of their own.
    pub is_contacts: bool,
    /// A JSON object.
    pub body: String,
}

/// The events of a transaction.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WaitingEvents {
    /// Epoch of the fleet's lease.
    pub epoch: i64,
    /// Number of the transaction under the lease.
    pub number: i64,
    /// The events, in order. If the rest of the row cannot be read, these are the readable ones.
    pub events: Vec<WaitingEvent>,
    /// Whether some cannot be read.
    pub is_damaged: bool,
    /// Bytes of the serialized events.
    pub bytes: i64,
}

/// Size of what waits in the outbox.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OutboxSize {
    /// Number of transactions.
    pub transactions: i64,
    /// Bytes of their serialized events.
    pub bytes: i64,
}

from_row! {
    struct StoredEvents {
        epoch: i64,
        number: i64,
        events: Vec<u8>,
    }
}

impl From<StoredEvents> for WaitingEvents {
    fn from(row: StoredEvents) -> Self {
        let StoredEvents { epoch, number, events: bytes } = row;
        let (mut rest, mut events, size) = (bytes.as_slice(), Vec::new(), bytes.len() as i64);
        let mut is_damaged = false;
        while let Some((version, event)) = rest.split_first() {
            rest = event;
            match WaitingEvent::deserialize(&mut rest) {
                Ok(event) if *version == VERSION => events.push(event),
                Ok(_) | Err(_) => {
                    is_damaged = true;
                    break;
                }
            }
        }
        Self { epoch, number, events, is_damaged, bytes: size }
    }
}

impl EventRow {
    /// Bytes that the event takes in the outbox.
    #[must_use]
    pub fn serialized_bytes(&self) -> usize {
        // The version, the kind, and a length before each of the two texts.
        const BESIDE_TEXTS: usize = 1 + 1 + 4 + 4;
        BESIDE_TEXTS + self.robot.len() + self.body.len()
    }
}

/// The row with a batch's events; `None` if it has none.
pub(crate) fn row<'b>(lease: &'b Lease, events: &[EventRow]) -> Option<OutboxRow<'b>> {
    if events.is_empty() {
        return None;
    }
    let mut bytes = Vec::with_capacity(events.iter().map(EventRow::serialized_bytes).sum());
    for EventRow { robot, is_contacts, body, .. } in events {
        // Writing to memory cannot fail.
        let _ = (VERSION, robot, is_contacts, body).serialize(&mut bytes);
    }
    Some(OutboxRow {
        fleet: lease.fleet().as_str(),
        epoch: lease.epoch() as i64,
        number: lease.next_commit(),
        events: bytes,
    })
}

/// Writes events. Those of the same transaction that were written before stay in front.
pub(crate) async fn write(tx: &mut Tx<'_>, lease: &Lease, events: &[EventRow]) -> Result<(), StoreError> {
    let Some(row) = row(lease, events) else { return Ok(()) };
    // SQLite's || makes a text of two blobs, hence the cast; the bytes are unchanged.
    let sql = match tx {
        Either::Sqlite(_) => {
            "INSERT INTO event_outbox (fleet, epoch, number, events) VALUES ($1, $2, $3, $4) \
             ON CONFLICT (fleet, epoch, number) \
             DO UPDATE SET events = CAST(event_outbox.events || excluded.events AS BLOB)"
        }
        Either::Postgres(_) => {
            "INSERT INTO event_outbox (fleet, epoch, number, events) VALUES ($1, $2, $3, $4) \
             ON CONFLICT (fleet, epoch, number) DO UPDATE SET events = event_outbox.events || excluded.events"
        }
    };
    on!(tx, |tx| sqlx::query(sql)
        .bind(row.fleet)
        .bind(row.epoch)
        .bind(row.number)
        .bind(&row.events)
        .execute(&mut **tx)
        .await
        .map(drop))
    .map_err(failed("write events"))
}

impl Store {
    /// The oldest waiting events of a fleet.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn waiting_events(&self, fleet: &Name) -> Result<Vec<WaitingEvents>, StoreError> {
        let sql = format!(
            "SELECT epoch, number, events FROM event_outbox WHERE fleet = $1 ORDER BY epoch, number LIMIT {ROWS_A_QUERY}"
        );
        let sql = sqlx::AssertSqlSafe(sql);
        let rows: Vec<StoredEvents> =
            on!(&self.pool, |pool| sqlx::query_as(sql).bind(fleet.as_str()).fetch_all(pool).await)
                .map_err(failed("read the outbox of events"))?;
        Ok(rows.into_iter().map(Into::into).collect())
    }

    /// Size of a fleet's waiting events. It reads each row's length, but not its events.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn outbox_size(&self, fleet: &Name) -> Result<OutboxSize, StoreError> {
        const SQL: &str = "SELECT count(*), CAST(COALESCE(sum(length(events)), 0) AS BIGINT) FROM event_outbox \
             WHERE fleet = $1";
        let (transactions, bytes): (i64, i64) =
            on!(&self.pool, |pool| sqlx::query_as(SQL).bind(fleet.as_str()).fetch_one(pool).await)
                .map_err(failed("measure the outbox of events"))?;
        Ok(OutboxSize { transactions, bytes })
    }

    /// Deletes events that the log has acknowledged, and all older ones of the fleet. No lease is needed: they are
    /// published, whoever deletes them.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn events_are_published(&self, fleet: &Name, rows: &[WaitingEvents]) -> Result<(), StoreError> {
        const WHAT: &str = "delete published events";
        const SQL: &str = "DELETE FROM event_outbox WHERE fleet = $1 AND (epoch, number) <= ($2, $3)";
        let Some(newest) = rows.last() else { return Ok(()) };
        on!(&self.pool, |pool| sqlx::query(SQL)
            .bind(fleet.as_str())
            .bind(newest.epoch)
            .bind(newest.number)
            .execute(pool)
            .await
            .map(drop))
        .map_err(failed(WHAT))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_are_read_as_they_were_written_up_to_a_damaged_one() {
        let event = |number: i64| WaitingEvent {
            robot: format!("r{number}"),
            is_contacts: number == 1,
            body: format!(r#"{{"n":{number}}}"#),
        };
        let bytes = |event: &WaitingEvent| borsh::to_vec(&(VERSION, event)).unwrap();
        let whole = [bytes(&event(0)), bytes(&event(1))].concat();
        let read = |events: &[u8]| WaitingEvents::from(StoredEvents { epoch: 1, number: 2, events: events.to_vec() });
        assert_eq!((read(&whole).events, read(&whole).is_damaged), (vec![event(0), event(1)], false));
        for (damaged, left) in [(&whole[..whole.len() - 1], 1), (&[&whole[..], &[7]].concat(), 2)] {
            let read = read(damaged);
            assert_eq!((read.events.len(), read.is_damaged), (left, true));
        }
    }

    #[test]
    fn an_event_knows_its_size() {
        let event =
            EventRow { robot_id: 1, robot: "robot".to_owned(), is_contacts: true, body: r#"{"n":1}"#.to_owned() };
        let bytes = borsh::to_vec(&(VERSION, &event.robot, event.is_contacts, &event.body)).unwrap();
        assert_eq!(event.serialized_bytes(), bytes.len());
    }
}
