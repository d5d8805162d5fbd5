//! Appends events to the log.

use sqlx::AssertSqlSafe;

use super::VERSION;
pub use crate::batch::EventRow;
use crate::database::{Tx, on};
use crate::tables::{EVENTS, InFleet};

/// Appends the events of a fleet, in their order.
pub(crate) async fn write(tx: &mut Tx<'_>, fleet: &str, events: &[EventRow]) -> sqlx::Result<()> {
    let rows: Vec<(InFleet<'_>, &EventRow)> = events.iter().map(|event| (InFleet { fleet }, event)).collect();
    EVENTS.write(tx, &rows).await.map(drop)
}

/// Clears the standing alarms of a robot and its whiskers, or of one whisker, each with its event.
pub(crate) async fn clear_alarms(tx: &mut Tx<'_>, whose: Whose<'_>, cleared_us: i64) -> sqlx::Result<()> {
    const WHOSE: &str = "cleared_us IS NULL AND (whisker_id IN (SELECT w.whisker_id FROM whiskers w \
         JOIN arrays a ON a.array_id = w.array_id WHERE w.robot_id = $1 \
         AND (CAST($3 AS TEXT) IS NULL OR a.\"array\" = $3 AND w.whisker = $4)) OR robot_id = $1 AND CAST($3 AS TEXT) IS NULL)";
    let insert = format!(
        "INSERT INTO events (recorded_us, version, kind, audience, word, fleet, robot_id, whisker_id, data) \
         SELECT CAST($2 AS BIGINT), {VERSION}, 'ALARM_CLEARED', 'PEOPLE', kind, (SELECT fleet FROM robots WHERE robot_id = $1), \
         CAST($1 AS BIGINT), whisker_id, '{{}}' FROM alarms WHERE {WHOSE} ORDER BY alarm_id"
    );
    let cleared = format!("UPDATE alarms SET cleared_us = $2 WHERE {WHOSE}");
    let (robot_id, place) = match whose {
        Whose::Robot(robot_id) => (robot_id, None),
        Whose::Whisker { robot_id, array, whisker } => (robot_id, Some((array, whisker))),
    };
    let (array, whisker) = (place.map(|(array, _)| array), place.map(|(_, whisker)| whisker));
    for sql in [insert, cleared] {
        on!(&mut *tx, |tx| sqlx::query(AssertSqlSafe(sql))
            .bind(robot_id)
            .bind(cleared_us)
            .bind(array)
            .bind(whisker)
            .execute(&mut **tx)
            .await
            .map(drop))?;
    }
    Ok(())
}

/// The robot or the whisker of the alarms to clear.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Whose<'a> {
    /// Those of a robot and of all its whiskers.
    Robot(i64),
    /// Those of a whisker, found by its name, because it may have no index any more.
    Whisker { robot_id: i64, array: &'a str, whisker: i64 },
}
