//! Errors of the database.

use std::path::PathBuf;
use std::time::Duration;

use super::cause::{for_log, of_migration, outline};
use super::no_server::NoServer;
use vibrissa_protocol::plain;

/// Reason why the database cannot be used. No variant shows a password.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// The folder of the SQLite file does not exist.
    #[error("cannot create the database {path}: the folder {folder} does not exist")]
    NoFolder {
        /// The SQLite file.
        path: PathBuf,
        /// Folder of the file.
        folder: PathBuf,
    },
    /// Another supervisor has locked the file.
    #[error(
        "the database {path} is locked by {holder}: stop that supervisor, give this one its own file, or let both \
         share a PostgreSQL server with --database-url postgres://..."
    )]
    InUse {
        /// The SQLite file.
        path: PathBuf,
        /// Name and process of the supervisor that holds the lock.
        holder: String,
    },
    /// The database cannot be opened.
    #[error("cannot open the database {database}: {}", for_log(source))]
    Open {
        /// Address of the database, without its password.
        database: String,
        /// Error of the database.
        source: sqlx::Error,
    },
    /// The lock of the SQLite file cannot be acquired.
    #[error("cannot lock the database with the file {path}: {}", plain::io(source))]
    Lock {
        /// The lock file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A migration of the tables failed.
    #[error("cannot migrate the tables of {database}: {}", of_migration(source))]
    Migrate {
        /// Address of the database, without its password.
        database: String,
        /// Error of the migration.
        source: sqlx::migrate::MigrateError,
    },
    /// An earlier version of the program was killed before it had written the rows of its transactions.
    #[error(
        "the database {database} has transactions in its table redo whose rows are not written, and only the earlier vibrissa \
         that began them can write these: stop all supervisors, start the earlier version until /readyz answers 200, stop it with \
         SIGTERM, and start this version again"
    )]
    Unfinished {
        /// Address of the database, without its password.
        database: String,
    },
    /// The SQLite file is damaged.
    #[error(
        "the database {database} is damaged: {findings}. Stop here, keep the file, and restore the newest back-up: \
         mkdir lost && mv {database}* lost/ && cp BACK-UP {database} (docs/operations.md, Restore). Without a back-up, \
         sqlite3 {database} .recover saves the rows that can still be read. If the file is not of vibrissa, name another one \
         with --database-url"
    )]
    Damaged {
        /// The SQLite file.
        database: String,
        /// Findings of SQLite.
        findings: String,
    },
    /// The SQLite file is missing or empty, and a supervisor has worked with it before.
    #[error(
        "the database {path} is missing or has no tables, but it had: {mark} says so. Put the file back, or restore the \
         newest back-up: cp BACK-UP {path} (docs/operations.md, Restore). To begin a new installation without the old \
         data, remove {mark}"
    )]
    Vanished {
        /// The SQLite file.
        path: PathBuf,
        /// The file that says that the database had tables.
        mark: PathBuf,
    },
    /// The tables of a PostgreSQL database are incomplete.
    #[error(
        "the database {database} has lost tables, among them {table}. Restore the newest back-up with pg_restore \
         (docs/operations.md, Restore)"
    )]
    Incomplete {
        /// Address of the database, without its password.
        database: String,
        /// Name of a missing table.
        table: String,
    },
    /// The PostgreSQL database cannot store every text.
    #[error(
        "{database} stores texts in {encoding}, which lacks letters that names and notes may have: UTF8 is needed. Create the \
         database anew: createdb --encoding=UTF8 --template=template0 --locale=C.UTF-8 NAME, and move the data with pg_dump \
         and pg_restore"
    )]
    NotUtf8 {
        /// Address of the database, without its password.
        database: String,
        /// The server's encoding of the database.
        encoding: String,
    },
    /// A newer version of the program has migrated the tables.
    #[error(
        "a newer vibrissa has worked with {database}: this one, {}, does not know migration {version}. \
         Start the newer one, or restore the back-up from before the upgrade",
        env!("CARGO_PKG_VERSION")
    )]
    TooNew {
        /// Address of the database, without its password.
        database: String,
        /// Number of the first unknown migration.
        version: i64,
    },
    /// The PostgreSQL server is too old.
    #[error("{database} is PostgreSQL {version}: version 15 or newer is needed")]
    TooOld {
        /// Address of the database, without its password.
        database: String,
        /// Version of the server.
        version: String,
    },
    /// Several clients share a session of the server.
    #[error(
        "{database} is behind a connection pooler that shares sessions between clients, such as PgBouncer in transaction \
         mode: settings, prepared statements and advisory locks need a session of their own. Set pool_mode = session for \
         this database in PgBouncer, or connect to PostgreSQL directly"
    )]
    SharedSessions {
        /// Address of the database, without its password.
        database: String,
    },
    /// No server accepts writes.
    #[error("database error: cannot {what}: {source}")]
    NoServer {
        /// Purpose of the connection, as a verb phrase after "cannot".
        what: &'static str,
        /// Each server with the reason against it.
        source: NoServer,
    },
    /// A query failed.
    #[error("database error: cannot {what}: {}", for_log(source))]
    Query {
        /// Purpose of the query, as a verb phrase after "cannot".
        what: &'static str,
        /// Error of the database.
        source: sqlx::Error,
    },
    /// The database did not answer in time.
    #[error("database error: cannot {what}: no answer in {} s", patience.as_secs())]
    NoAnswer {
        /// Purpose of the query, as a verb phrase after "cannot".
        what: &'static str,
        /// Time limit that was exceeded.
        patience: Duration,
    },
    /// The journal refers to a partitioned log, and none is configured.
    #[error(
        "the journal of fleet {fleet} refers to records of Kafka: set ingest = \"kafka\" again, or stop the fleet in an orderly way first"
    )]
    NoLog {
        /// Name of the fleet.
        fleet: String,
    },
    /// The lease does not hold any more. Nothing was written.
    #[error("fleet {fleet}: the lease of epoch {epoch} {cause}")]
    LeaseLost {
        /// Name of the fleet.
        fleet: String,
        /// Epoch of the lost lease.
        epoch: u64,
        /// Cause of the loss.
        cause: LossCause,
    },
}

/// Cause of the loss of a lease.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LossCause {
    /// Another supervisor has acquired it.
    TakenOver,
    /// The database went back to an earlier state, as after a failover without synchronous replication.
    CommitsLost {
        /// Number of transactions that were acknowledged and do not exist any more.
        commits: u64,
    },
}

impl std::fmt::Display for LossCause {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::TakenOver => f.write_str("was taken over by another supervisor"),
            Self::CommitsLost { commits } => write!(
                f,
                "does not hold any more: the database has lost its last {commits} acknowledged transactions, as after a \
                 failover without synchronous replication"
            ),
        }
    }
}

impl StoreError {
    /// The error without the database's own text, which may show statements and values: for clients and `/readyz`.
    /// The log has the full text.
    #[must_use]
    pub fn message(&self) -> String {
        match self {
            Self::Query { what, source } => format!("database error: cannot {what}: {}", outline(source)),
            Self::Open { source, .. } => format!("cannot open the database: {}", outline(source)),
            Self::NoFolder { .. }
            | Self::InUse { .. }
            | Self::Lock { .. }
            | Self::Unfinished { .. }
            | Self::Damaged { .. }
            | Self::Vanished { .. } => "cannot use the database's file; see the log".to_owned(),
            Self::Migrate { .. } => "cannot migrate the database's tables; see the log".to_owned(),
            Self::NoServer { what, source } => format!("database error: cannot {what}: {}", source.message()),
            Self::TooNew { .. }
            | Self::TooOld { .. }
            | Self::Incomplete { .. }
            | Self::NotUtf8 { .. }
            | Self::SharedSessions { .. }
            | Self::NoAnswer { .. }
            | Self::NoLog { .. }
            | Self::LeaseLost { .. } => self.to_string(),
        }
    }

    /// Whether a later attempt may succeed, because the server is unreachable, starting or overloaded. False if a
    /// person must act, for example because of a wrong password.
    #[must_use]
    pub fn is_passing(&self) -> bool {
        match self {
            Self::NoFolder { .. }
            | Self::InUse { .. }
            | Self::Lock { .. }
            | Self::Unfinished { .. }
            | Self::Damaged { .. }
            | Self::Vanished { .. }
            | Self::TooNew { .. }
            | Self::TooOld { .. }
            | Self::Incomplete { .. }
            | Self::NotUtf8 { .. }
            | Self::SharedSessions { .. } => false,
            Self::NoServer { source, .. } => source.is_passing(passes),
            Self::Open { source, .. } | Self::Query { source, .. } => passes(source),
            Self::Migrate { source, .. } => {
                matches!(source, sqlx::migrate::MigrateError::Execute(source) if passes(source))
            }
            Self::NoAnswer { .. } => true,
            Self::NoLog { .. } | Self::LeaseLost { .. } => false,
        }
    }
}

/// A permanent refusal of rows: the database will refuse the same rows whenever they are written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Rejection {
    /// Class of the error.
    pub cause: RejectionCause,
    /// Error code of the database: an SQLSTATE, or SQLite's extended result code.
    pub code: String,
    /// Text of the database, for the log only: it can quote values that a robot has sent.
    pub text: String,
}

impl Rejection {
    /// Whether a key of the table `setpoints` refuses the row: a setpoint with the same name, or with the same robot, epoch and
    /// version, is there already. Both databases name the key in the text, and PostgreSQL does so in each language.
    #[must_use]
    pub fn is_of_setpoint_key(&self) -> bool {
        match self.code.as_str() {
            "23505" => self.text.contains("setpoints_"),
            // Primary key, unique.
            "1555" | "2067" => self.text.contains(" setpoints."),
            _ => false,
        }
    }
}

/// Class of an error that is caused by the rows themselves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum RejectionCause {
    /// The database cannot represent a value: SQLSTATE class 22, SQLite's MISMATCH and RANGE, or an encoding error.
    Data,
    /// A constraint or a trigger refuses the row: SQLSTATE classes 23, 44 and P0, SQLite's CONSTRAINT.
    Constraint,
    /// The row or a value is too large: SQLSTATE class 54, SQLite's TOOBIG.
    Size,
}

impl RejectionCause {
    /// All classes of errors.
    pub const ALL: [Self; 3] = [Self::Data, Self::Constraint, Self::Size];

    /// Word of the table `quarantine`, of the REST API and of the metrics.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Data => "DATA",
            Self::Constraint => "CONSTRAINT",
            Self::Size => "SIZE",
        }
    }

    fn of_sqlstate(code: &str) -> Option<Self> {
        match code.get(..2)? {
            "22" => Some(Self::Data),
            "23" | "44" | "P0" => Some(Self::Constraint),
            "54" => Some(Self::Size),
            _ => None,
        }
    }

    fn of_sqlite(code: &str) -> Option<Self> {
        // The low byte of an extended result code is the primary one: sqlite.org/rescode.html.
        match code.parse::<u32>().ok()? & 0xff {
            20 | 25 => Some(Self::Data),
            19 => Some(Self::Constraint),
            18 => Some(Self::Size),
            _ => None,
        }
    }
}

impl StoreError {
    /// The refusal, if the database will never accept these rows; `None` if another attempt may succeed.
    #[must_use]
    pub fn rejection(&self) -> Option<Rejection> {
        let Self::Query { source, .. } = self else { return None };
        if let sqlx::Error::Encode(problem) = source {
            let (code, text) = ("ENCODE".to_owned(), problem.to_string());
            return Some(Rejection { cause: RejectionCause::Data, code, text });
        }
        let sqlx::Error::Database(problem) = source else { return None };
        let code = problem.code()?.into_owned();
        let is_sqlite = problem.try_downcast_ref::<sqlx::sqlite::SqliteError>().is_some();
        let cause = if is_sqlite { RejectionCause::of_sqlite(&code) } else { RejectionCause::of_sqlstate(&code) };
        Some(Rejection { cause: cause?, code, text: problem.message().to_owned() })
    }
}

/// Whether the same statement may succeed later.
fn passes(problem: &sqlx::Error) -> bool {
    if let sqlx::Error::Database(error) = problem {
        // Connection failures (08), lack of resources (53), shutdown or start (57), serialisation failures (40),
        // locks (55), a server that became read-only (25006).
        let code = error.code().unwrap_or_default();
        return ["08", "53", "57", "40", "55", "25006"].iter().any(|class| code.starts_with(class));
    }
    matches!(problem, sqlx::Error::Io(_) | sqlx::Error::PoolTimedOut | sqlx::Error::Protocol(_))
}

/// Turns the error of a query into a [`StoreError`] that names its purpose.
pub(super) fn failed(what: &'static str) -> impl FnOnce(sqlx::Error) -> StoreError {
    move |source| StoreError::Query { what, source }
}

#[cfg(test)]
mod tests {
    use super::Rejection;
    use super::RejectionCause::{self, Constraint, Data, Size};

    #[test]
    fn golden_the_keys_of_setpoints_are_known_by_the_texts_of_both_databases() {
        let refused = |code: &str, text: &str| {
            let (code, text) = (code.to_owned(), text.to_owned());
            Rejection { cause: Constraint, code, text }.is_of_setpoint_key()
        };
        for (code, text) in [
            ("23505", "duplicate key value violates unique constraint \"setpoints_pkey\""),
            ("23505", "doppelter Schlüsselwert verletzt Unique-Constraint »setpoints_robot_id_epoch_version_key«"),
            ("1555", "UNIQUE constraint failed: setpoints.command_id"),
            ("2067", "UNIQUE constraint failed: setpoints.robot_id, setpoints.epoch, setpoints.version"),
        ] {
            assert!(refused(code, text), "{text}");
        }
        for (code, text) in [
            ("23505", "duplicate key value violates unique constraint \"setpoint_states_pkey\""),
            ("23505", "duplicate key value violates unique constraint \"trims_pkey\""),
            ("23503", "insert on table \"setpoints\" violates foreign key constraint \"setpoints_robot_id_fkey\""),
            ("2067", "UNIQUE constraint failed: trims.trim_id"),
            ("1299", "NOT NULL constraint failed: setpoints.reason"),
        ] {
            assert!(!refused(code, text), "{text}");
        }
    }

    #[test]
    fn only_errors_that_rows_cause_by_themselves_are_rejections() {
        let postgres = [
            ("22021", Some(Data)),
            ("22003", Some(Data)),
            ("23502", Some(Constraint)),
            ("23505", Some(Constraint)),
            ("44000", Some(Constraint)),
            ("P0001", Some(Constraint)),
            ("54000", Some(Size)),
            ("40001", None),
            ("42P01", None),
            ("53100", None),
            ("57P01", None),
            ("08006", None),
            ("2", None),
            ("", None),
        ];
        for (code, cause) in postgres {
            assert_eq!(RejectionCause::of_sqlstate(code), cause, "SQLSTATE {code}");
        }
        // NOT NULL, unique, trigger, mismatch, too big; busy, full, read-only, I/O.
        let sqlite =
            [("1299", Some(Constraint)), ("2067", Some(Constraint)), ("1811", Some(Constraint)), ("20", Some(Data))];
        let passing = [("18", Some(Size)), ("5", None), ("13", None), ("8", None), ("778", None), ("x", None)];
        for (code, cause) in sqlite.into_iter().chain(passing) {
            assert_eq!(RejectionCause::of_sqlite(code), cause, "SQLite {code}");
        }
    }
}
