//! The table of messages whose rows the database refused, of bounded size.

use super::batch::QuarantineRow;
use super::database::{Tx, on};

/// Adds a message, and deletes the oldest messages of the fleet beyond [`QuarantineRow::ROWS_MAX`].
pub(super) async fn write(tx: &mut Tx<'_>, fleet: &str, row: &QuarantineRow) -> sqlx::Result<()> {
    const INSERT: &str = "INSERT INTO quarantine (fleet, robot, topic, boot_id, seq, received_us, quarantined_us, cause, \
         code, payload) VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10)";
    const LIMIT: &str = "DELETE FROM quarantine WHERE fleet = $1 AND quarantine_id <= \
         (SELECT quarantine_id FROM quarantine WHERE fleet = $1 ORDER BY quarantine_id DESC LIMIT 1 OFFSET $2)";
    on!(&mut *tx, |tx| sqlx::query(INSERT)
        .bind(fleet)
        .bind(&row.robot)
        .bind(row.topic)
        .bind(&row.boot_id)
        .bind(row.seq)
        .bind(row.received_us)
        .bind(row.quarantined_us)
        .bind(row.cause)
        .bind(&row.code)
        .bind(&row.payload)
        .execute(&mut **tx)
        .await
        .map(drop))?;
    on!(tx, |tx| sqlx::query(LIMIT).bind(fleet).bind(QuarantineRow::ROWS_MAX).execute(&mut **tx).await.map(drop))
}
