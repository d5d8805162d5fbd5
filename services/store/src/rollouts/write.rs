//! Writes a roll-out, and the actions by which the further shards of its fleet follow.

use super::{RolloutChange, RolloutEvent, RolloutRow, StageOfShard};
use crate::database::{Tx, on};
use crate::shards::SHARD_WAITS_US;

/// Events by which robots change.
const CHANGING: [&str; 4] = ["STARTED", "ADVANCED", "COMPLETED", "ROLLED_BACK"];

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
    if let Some(event) = event.as_ref().filter(|event| CHANGING.contains(&event.event.as_str())) {
        ask_shards(tx, row, event).await?;
    }
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

/// Adds an action for each further shard of the fleet, so that its robots follow. The row is not written yet, so the database
/// still has the place of the stage before.
async fn ask_shards(tx: &mut Tx<'_>, row: &RolloutRow, event: &RolloutEvent) -> sqlx::Result<()> {
    const SHARDS: &str = "SELECT shard FROM leases WHERE fleet = $1 AND shard > 0 ORDER BY shard";
    const BEFORE: &str = "SELECT place_max FROM rollouts WHERE rollout_id = $1";
    const INSERT: &str = "INSERT INTO actions (fleet, kind, parameters, reason, actor, role, request_id, asked_us, expires_us, \
         state, parent_id, not_before_us, shard) SELECT fleet, 'ROLLOUT_STAGE', $2, $3, $4, role, request_id, $5, $6, \
         'PENDING', action_id, 0, $7 FROM actions WHERE action_id = $1";
    let shards: Vec<i64> = on!(&mut *tx, |tx| sqlx::query_scalar(SHARDS).bind(&row.fleet).fetch_all(&mut **tx).await)?;
    if shards.is_empty() {
        return Ok(());
    }
    let place_before: Option<i64> =
        on!(&mut *tx, |tx| sqlx::query_scalar(BEFORE).bind(row.rollout_id).fetch_optional(&mut **tx).await)?;
    let stage = StageOfShard {
        rollout_id: row.rollout_id,
        kind: row.kind.clone(),
        change: row.change.clone(),
        event: event.event.clone(),
        place_before: place_before.filter(|_| event.event != "ROLLED_BACK"),
        place_max: row.place_max,
    };
    let parameters = serde_json::to_string(&stage).map_err(|problem| sqlx::Error::Encode(Box::new(problem)))?;
    for shard in shards {
        on!(&mut *tx, |tx| sqlx::query(INSERT)
            .bind(row.rollout_id)
            .bind(&parameters)
            .bind(&event.detail)
            .bind(&event.actor)
            .bind(row.updated_us)
            .bind(row.updated_us.saturating_add(SHARD_WAITS_US))
            .bind(shard)
            .execute(&mut **tx)
            .await
            .map(drop))?;
    }
    Ok(())
}
