//! Positions in a partitioned log (table `log_positions`): the first record of each partition whose effects are not
//! committed. They change in the transaction of the effects.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::database::{Tx, on};
use super::tables::{LOG_POSITIONS, LogPositionRow};
use super::{Lease, Model, StoreError, Writer, failed};

/// Time limit for reading or setting positions.
const PATIENCE: std::time::Duration = std::time::Duration::from_secs(5);

/// Positions that a transaction changes.
#[derive(Debug, Default, Clone, PartialEq, Eq)]
pub struct LogPositions {
    /// Name of the topic.
    pub topic: Arc<str>,
    /// The first record whose effects are not in this transaction or before it, by partition.
    pub next: BTreeMap<u32, i64>,
}

impl LogPositions {
    /// The rows of a fleet.
    pub(crate) fn rows<'b>(&'b self, lease: &'b Lease) -> impl Iterator<Item = LogPositionRow<'b>> {
        let (fleet, topic) = (lease.fleet().as_str(), &*self.topic);
        let row = move |(&partition, &next)| {
            let log_partition = i64::from(partition);
            LogPositionRow { fleet, topic, log_partition, next }
        };
        self.next.iter().map(row)
    }
}

impl Writer {
    /// The positions of a fleet in a topic, by partition. A partition of which no record is committed is missing.
    ///
    /// # Errors
    /// The database cannot be used.
    pub async fn log_positions(&mut self, lease: &Lease, topic: &str) -> Result<BTreeMap<u32, i64>, StoreError> {
        const WHAT: &str = "read the positions in the log";
        const SQL: &str = "SELECT log_partition, next FROM log_positions WHERE fleet = $1 AND topic = $2";
        let fleet = lease.fleet().as_str();
        self.attempt(
            WHAT,
            PATIENCE,
            |model| Ok(model.log_positions(lease, topic)),
            async |link| {
                let rows: Vec<(i64, i64)> =
                    on!(link, |link| sqlx::query_as(SQL).bind(fleet).bind(topic).fetch_all(link).await)
                        .map_err(failed(WHAT))?;
                Ok(rows
                    .into_iter()
                    .filter_map(|(partition, next)| Some((u32::try_from(partition).ok()?, next)))
                    .collect())
            },
        )
        .await
    }

    /// Sets positions before the effects of their records are committed, for a fault planted by a test.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn set_log_positions(&mut self, lease: &Lease, positions: &LogPositions) -> Result<(), StoreError> {
        const WHAT: &str = "set the positions in the log";
        let model = |model: &mut dyn Model| {
            model.set_log_positions(lease, positions);
            Ok(())
        };
        self.attempt(WHAT, PATIENCE, model, async |link| {
            let mut tx = link.begin().await.map_err(failed(WHAT))?;
            write(&mut tx, lease, positions).await?;
            tx.commit().await.map_err(failed(WHAT))
        })
        .await
    }
}

/// Writes the positions that change.
pub(super) async fn write(tx: &mut Tx<'_>, lease: &Lease, positions: &LogPositions) -> Result<(), StoreError> {
    let rows: Vec<LogPositionRow<'_>> = positions.rows(lease).collect();
    LOG_POSITIONS.write(tx, &rows).await.map(drop).map_err(failed("write the positions in the log"))
}
