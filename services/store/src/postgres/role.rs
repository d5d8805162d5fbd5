//! The role of a server: whether it accepts writes, and why not.

use std::time::Duration;

use sqlx::postgres::PgConnection;
use sqlx::{Executor, Row};

use crate::StoreError;
use crate::cause::{for_log, outline};

/// Reason why a server is not used.
#[derive(Debug)]
pub enum Refusal {
    /// It accepts no connection.
    Failed(sqlx::Error),
    /// It does not answer in time.
    NoAnswer(Duration),
    /// It is a standby.
    Standby,
    /// It accepts only reading transactions.
    ReadOnly,
    /// It was the leader before another one that was seen.
    Outdated {
        /// Timeline of the server.
        timeline: i64,
        /// Timeline of the other leader.
        newest: i64,
    },
}

impl std::fmt::Display for Refusal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Failed(problem) => f.write_str(&for_log(problem)),
            Self::NoAnswer(patience) => write!(f, "no answer in {} s", patience.as_secs_f32()),
            Self::Standby => f.write_str("it is a standby"),
            Self::ReadOnly => f.write_str("it is read-only"),
            Self::Outdated { timeline, newest } => {
                write!(f, "it is a former leader: its timeline is {timeline}, and {newest} was seen")
            }
        }
    }
}

impl Refusal {
    /// The reason without the database's own text.
    fn reason(&self) -> String {
        match self {
            Self::Failed(problem) => outline(problem),
            Self::NoAnswer(_) | Self::Standby | Self::ReadOnly | Self::Outdated { .. } => self.to_string(),
        }
    }
}

/// No server accepts writes: each server with the reason.
#[derive(Debug)]
pub struct NoServer(pub Vec<(String, Refusal)>);

impl std::fmt::Display for NoServer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.list(f, Refusal::to_string)
    }
}

impl std::error::Error for NoServer {}

impl NoServer {
    fn list(&self, f: &mut impl std::fmt::Write, text_of: impl Fn(&Refusal) -> String) -> std::fmt::Result {
        f.write_str("no server accepts writes")?;
        let mut mark = ':';
        for (server, refusal) in &self.0 {
            write!(f, "{mark} {server}: {}", text_of(refusal))?;
            mark = ';';
        }
        Ok(())
    }

    /// The text without the database's own.
    pub(crate) fn message(&self) -> String {
        let mut text = String::new();
        // A string accepts all text.
        let _ = self.list(&mut text, Refusal::reason);
        text
    }

    /// Whether a later attempt may succeed at one of the servers, by the errors that pass.
    pub(crate) fn is_passing(&self, passes: impl Fn(&sqlx::Error) -> bool) -> bool {
        self.0.iter().any(|(_, refusal)| match refusal {
            Refusal::Failed(problem) => passes(problem),
            Refusal::NoAnswer(_) | Refusal::Standby | Refusal::ReadOnly | Refusal::Outdated { .. } => true,
        })
    }

    /// The error of the only server, if it accepts no connection.
    fn only_error(mut self) -> Result<sqlx::Error, Self> {
        match self.0.pop() {
            Some((_, Refusal::Failed(problem))) if self.0.is_empty() => Ok(problem),
            last => {
                self.0.extend(last);
                Err(self)
            }
        }
    }

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
