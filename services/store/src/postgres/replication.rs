//! Whether the leader waits for a standby before it acknowledges a commit.

use crate::database::{Either, on};
use crate::{Store, StoreError, failed};

/// How commits reach the standbys of a database with several servers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Replication {
    /// Setting `synchronous_standby_names` of the leader. If it is empty, a commit waits for no standby, and a failover may
    /// lose it.
    pub synchronous_standby_names: String,
    /// Number of standbys that receive the leader's changes.
    pub standbys: i64,
}

impl Replication {
    /// Whether a commit is acknowledged only after a standby has it. A writer's sessions set `synchronous_commit = on`.
    #[must_use]
    pub fn is_synchronous(&self) -> bool {
        !self.synchronous_standby_names.trim().is_empty()
    }
}

impl Store {
    /// The replication of a database with several servers; `None` for any other.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn replication(&self) -> Result<Option<Replication>, StoreError> {
        // Every role sees the number of standbys.
        const SQL: &str =
            "SELECT current_setting('synchronous_standby_names'), (SELECT count(*) FROM pg_stat_replication)";
        if !matches!(&*self.options, Either::Postgres(route) if route.has_several_servers()) {
            return Ok(None);
        }
        let found: (String, i64) = on!(&self.pool, |pool| sqlx::query_as(SQL).fetch_one(pool).await)
            .map_err(failed("read the state of the replication"))?;
        Ok(Some(Replication { synchronous_standby_names: found.0, standbys: found.1 }))
    }
}
