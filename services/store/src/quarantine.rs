//! The table of messages whose rows the database refused, of bounded size.

use super::batch::QuarantineRow;
use super::database::{Tx, on};
use super::tables::{InFleet, QUARANTINE};

/// Adds a message, and deletes the oldest messages of the fleet beyond [`QuarantineRow::ROWS_MAX`].
pub(super) async fn write(tx: &mut Tx<'_>, fleet: &str, row: &QuarantineRow) -> sqlx::Result<()> {
    const LIMIT: &str = "DELETE FROM quarantine WHERE fleet = $1 AND quarantine_id <= \
         (SELECT quarantine_id FROM quarantine WHERE fleet = $1 ORDER BY quarantine_id DESC LIMIT 1 OFFSET $2)";
    QUARANTINE.write(tx, &[(InFleet { fleet }, row)]).await?;
    on!(tx, |tx| sqlx::query(LIMIT).bind(fleet).bind(QuarantineRow::ROWS_MAX).execute(&mut **tx).await.map(drop))
}
