//! The position of Kafka's publisher in the log, one for each fleet (table `event_positions`).
//!
//! Events up to the position are acknowledged by Kafka. Events of contacts are removed with its advance; nobody else reads
//! them.

use super::{EVENTS, EVENTS_A_QUERY, Position, Positioned, StoredEvent, select, settled};
use crate::database::on;
use crate::{Store, StoreError, failed};

/// Size of the events that wait for Kafka.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Waiting {
    /// Number of events.
    pub events: i64,
    /// Bytes of their data.
    pub bytes: i64,
}

/// The oldest waiting events of a fleet.
#[derive(Debug, Clone, Default)]
pub struct WaitingEvents {
    /// Those that can be read, in order.
    pub events: Vec<StoredEvent>,
    /// Position of the last one, readable or not; `None` if none waits.
    pub last: Option<Position>,
    /// Number of those that cannot be read.
    pub unreadable: u64,
}

impl Store {
    /// States at a time, µs since 1970 UTC, that Kafka follows a fleet's events: those from now on, unless its position is
    /// known.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn follow_events(&self, fleet: &str, now_us: i64) -> Result<(), StoreError> {
        if let Some(model) = &self.model {
            return model.query("follow the events of a fleet", |_| Ok(())).await;
        }
        const SQL: &str = "INSERT INTO event_positions (fleet, tx, event_id, seen_us) \
             SELECT CAST($1 AS TEXT), coalesce(max(tx), 0), coalesce(max(event_id), 0), CAST($2 AS BIGINT) FROM events \
             WHERE event_id = (SELECT max(event_id) FROM events WHERE fleet = $1) \
             ON CONFLICT (fleet) DO UPDATE SET seen_us = excluded.seen_us";
        on!(&self.pool, |pool| sqlx::query(SQL).bind(fleet).bind(now_us).execute(pool).await.map(drop))
            .map_err(failed("follow the events of a fleet"))
    }

    /// The oldest events of a fleet that Kafka has not acknowledged.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn waiting_events(&self, fleet: &str) -> Result<WaitingEvents, StoreError> {
        let end = format!(
            "JOIN event_positions p ON p.fleet = e.fleet WHERE e.fleet = $1 AND (e.tx, e.event_id) > (p.tx, p.event_id) {} \
             ORDER BY e.tx, e.event_id LIMIT {EVENTS_A_QUERY}",
            settled(&self.pool)
        );
        let rows: Vec<Positioned<StoredEvent>> =
            on!(&self.pool, |pool| sqlx::query_as(select(&end)).bind(fleet).fetch_all(pool).await)
                .map_err(failed("read the events for Kafka"))?;
        let (last, all) = (rows.last().map(|row| row.at), rows.len());
        let events: Vec<StoredEvent> =
            rows.into_iter().filter_map(|row| self.set_aside.read(EVENTS, row.event)).collect();
        let unreadable = (all - events.len()) as u64;
        Ok(WaitingEvents { events, last, unreadable })
    }

    /// Size of a fleet's waiting events.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn waiting_size(&self, fleet: &str) -> Result<Waiting, StoreError> {
        const SQL: &str = "SELECT count(*), CAST(coalesce(sum(length(e.data)), 0) AS BIGINT) FROM events e \
             JOIN event_positions p ON p.fleet = e.fleet WHERE e.fleet = $1 AND (e.tx, e.event_id) > (p.tx, p.event_id)";
        let (events, bytes): (i64, i64) = on!(&self.pool, |pool| sqlx::query_as(SQL).bind(fleet).fetch_one(pool).await)
            .map_err(failed("measure the events for Kafka"))?;
        Ok(Waiting { events, bytes })
    }

    /// Advances the position of a fleet: Kafka has acknowledged all events up to it. A position that a later owner has advanced
    /// further stays.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn events_are_published(&self, fleet: &str, last: Position) -> Result<(), StoreError> {
        const WHAT: &str = "advance the position of the events for Kafka";
        const ADVANCE: &str =
            "UPDATE event_positions SET tx = $2, event_id = $3 WHERE fleet = $1 AND (tx, event_id) < ($2, $3)";
        const CONTACTS: &str =
            "DELETE FROM events WHERE fleet = $1 AND (tx, event_id) <= ($2, $3) AND audience = 'KAFKA'";
        let mut tx = self.pool.begin().await.map_err(failed(WHAT))?;
        for sql in [ADVANCE, CONTACTS] {
            on!(&mut tx, |tx| sqlx::query(sql)
                .bind(fleet)
                .bind(last.tx)
                .bind(last.event_id)
                .execute(&mut **tx)
                .await
                .map(drop))
            .map_err(failed(WHAT))?;
        }
        tx.commit().await.map_err(failed(WHAT))
    }
}
