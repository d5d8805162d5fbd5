//! Writes a roll-out.

use super::RolloutChange;
use crate::database::{Tx, on};

/// Writes the state of a roll-out, and its event.
pub(crate) async fn write(tx: &mut Tx<'_>, change: &RolloutChange) -> sqlx::Result<()> {
    const STATE: &str = "INSERT INTO rollouts (rollout_id, fleet, kind, change, state, stage, place_max, level, robots, looks, \
         probability, changed_robots, unchanged_robots, changed_error, unchanged_error, started_us, stage_us, updated_us, \
         started_by, reason) \
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, $14, $15, $16, $17, $18, $19, $20) \
         ON CONFLICT (rollout_id) DO UPDATE SET state = excluded.state, stage = excluded.stage, \
         place_max = excluded.place_max, looks = excluded.looks, probability = excluded.probability, \
         changed_robots = excluded.changed_robots, unchanged_robots = excluded.unchanged_robots, \
         changed_error = excluded.changed_error, unchanged_error = excluded.unchanged_error, \
         stage_us = excluded.stage_us, updated_us = excluded.updated_us";
    const EVENT: &str = "INSERT INTO rollout_events (rollout_id, recorded_us, event, stage, actor, detail) \
         VALUES ($1, $2, $3, $4, $5, $6)";
    let RolloutChange { row, event } = change;
    on!(&mut *tx, |tx| sqlx::query(STATE)
        .bind(row.rollout_id)
        .bind(&row.fleet)
        .bind(&row.kind)
        .bind(&row.change)
        .bind(&row.state)
        .bind(&row.stage)
        .bind(row.place_max)
        .bind(row.level)
        .bind(row.robots)
        .bind(row.looks)
        .bind(row.compared.probability)
        .bind(row.compared.changed_robots)
        .bind(row.compared.unchanged_robots)
        .bind(row.compared.changed_error)
        .bind(row.compared.unchanged_error)
        .bind(row.started_us)
        .bind(row.stage_us)
        .bind(row.updated_us)
        .bind(&row.started_by)
        .bind(&row.reason)
        .execute(&mut **tx)
        .await
        .map(drop))?;
    let Some(event) = event else { return Ok(()) };
    on!(tx, |tx| sqlx::query(EVENT)
        .bind(row.rollout_id)
        .bind(row.updated_us)
        .bind(&event.event)
        .bind(&row.stage)
        .bind(&event.actor)
        .bind(&event.detail)
        .execute(&mut **tx)
        .await
        .map(drop))
}
