//! The role of a server: whether it accepts writes, and the error if none does.

use sqlx::postgres::PgConnection;
use sqlx::{Executor, Row};

use crate::StoreError;
use crate::no_server::{NoServer, Refusal};

impl NoServer {
    /// The error of an operation that needs a server. `what` is a verb phrase after "cannot".
    pub(crate) fn preventing(self, what: &'static str) -> StoreError {
        match self.only_error() {
            Ok(source) => StoreError::Query { what, source },
            Err(source) => StoreError::NoServer { what, source },
        }
    }

    /// The error of opening the database.
    pub(super) fn keeping_closed(self, database: &str) -> StoreError {
        match self.only_error() {
            Ok(source) => StoreError::Open { database: database.to_owned(), source },
            Err(source) => StoreError::NoServer { what: "open the database", source },
        }
    }
}

/// A server that accepts writes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Leader {
    /// Identifier of the cluster, the same at all its servers.
    pub(super) cluster: i64,
    /// Number that rises with each promotion of a standby.
    pub(super) timeline: i64,
}

/// Asks a server whether it accepts writes.
pub(super) async fn ask(link: &mut PgConnection) -> Result<Leader, Refusal> {
    // Without a prepared statement, which a pooler may refuse.
    const SQL: &str = "SELECT pg_is_in_recovery(), current_setting('transaction_read_only') = 'on', \
        (SELECT system_identifier FROM pg_control_system()), CASE WHEN pg_is_in_recovery() THEN 0 ELSE \
        ('x' || lpad(left(pg_walfile_name(pg_current_wal_insert_lsn()), 8), 16, '0'))::bit(64)::bigint END";
    let asked = async {
        let row = link.fetch_one(sqlx::raw_sql(SQL)).await?;
        Ok((row.try_get(0)?, row.try_get(1)?, row.try_get(2)?, row.try_get(3)?))
    };
    let (is_standby, is_read_only, cluster, timeline): (bool, bool, i64, i64) = asked.await.map_err(Refusal::Failed)?;
    match (is_standby, is_read_only) {
        (true, _) => Err(Refusal::Standby),
        (false, true) => Err(Refusal::ReadOnly),
        (false, false) => Ok(Leader { cluster, timeline }),
    }
}
