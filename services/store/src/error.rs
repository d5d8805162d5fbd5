//! Why the database cannot be used.

use std::path::PathBuf;
use std::time::Duration;

/// Why the database cannot be used. No variant shows a password.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// There is no place for it.
    #[error("cannot make the database {path}: the folder {folder} does not exist")]
    NoFolder {
        /// Which database.
        path: PathBuf,
        /// Where it would be.
        folder: PathBuf,
    },
    /// Another supervisor works with the file.
    #[error(
        "the database {path} belongs to {holder} now: stop that supervisor, give this one a file of its own, or let \
         them share a PostgreSQL with --database-url postgres://..."
    )]
    InUse {
        /// Which database.
        path: PathBuf,
        /// Who, as it says of itself.
        holder: String,
    },
    /// It cannot be opened.
    #[error("cannot open the database {database}: {source}")]
    Open {
        /// Which.
        database: String,
        /// Why.
        source: sqlx::Error,
    },
    /// Its lock cannot be taken.
    #[error("cannot lock the database with the file {path}: {source}")]
    Lock {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// Its tables cannot be brought up to date.
    #[error("cannot bring the tables of {database} up to date: {source}")]
    Migrate {
        /// Which.
        database: String,
        /// Why.
        source: sqlx::migrate::MigrateError,
    },
    /// A newer version of the program has changed its tables.
    #[error(
        "a newer vibrissa has worked with {database}: this one, {}, does not know the change {version} of its tables. \
         Start the newer one, or restore the back-up of before the upgrade",
        env!("CARGO_PKG_VERSION")
    )]
    TooNew {
        /// Which.
        database: String,
        /// The first migration that is not known here.
        version: i64,
    },
    /// The server is too old.
    #[error("{database} is PostgreSQL {version}: version 15 or newer is needed")]
    TooOld {
        /// Which.
        database: String,
        /// Its version.
        version: String,
    },
    /// A query failed.
    #[error("database, while trying to {what}: {source}")]
    Query {
        /// What it was for.
        what: &'static str,
        /// Why.
        source: sqlx::Error,
    },
    /// No answer came.
    #[error("database, while trying to {what}: no answer in {} s", patience.as_secs())]
    NoAnswer {
        /// What it was for.
        what: &'static str,
        /// How long it was waited for.
        patience: Duration,
    },
    /// The fleet is not this supervisor's any more: nothing was written.
    #[error("fleet {fleet} is not ours any more: its lease of epoch {epoch} was taken over")]
    LeaseLost {
        /// Which fleet.
        fleet: String,
        /// The epoch that it was ours in.
        epoch: u64,
    },
}

impl StoreError {
    /// The same without a word of the database's own, which may show statements and values: what clients and `/readyz` tell. The
    /// log has the whole.
    #[must_use]
    pub fn told(&self) -> String {
        match self {
            Self::Query { what, source } => format!("database, while trying to {what}: {}", outline(source)),
            Self::Open { source, .. } => format!("the database cannot be opened: {}", outline(source)),
            Self::NoFolder { .. } | Self::InUse { .. } | Self::Lock { .. } => {
                "the database's file cannot be used; the log says why".to_owned()
            }
            Self::Migrate { .. } => "the database's tables cannot be brought up to date; the log says why".to_owned(),
            Self::TooNew { .. } | Self::TooOld { .. } | Self::NoAnswer { .. } | Self::LeaseLost { .. } => {
                self.to_string()
            }
        }
    }

    /// Whether waiting can help: the server is away, starting, or too busy. The opposite is a person's affair, such
    /// as a wrong password.
    #[must_use]
    pub fn is_passing(&self) -> bool {
        match self {
            Self::NoFolder { .. }
            | Self::InUse { .. }
            | Self::Lock { .. }
            | Self::TooNew { .. }
            | Self::TooOld { .. } => false,
            Self::Open { source, .. } | Self::Query { source, .. } => passes(source),
            Self::Migrate { source, .. } => {
                matches!(source, sqlx::migrate::MigrateError::Execute(source) if passes(source))
            }
            Self::NoAnswer { .. } => true,
            Self::LeaseLost { .. } => false,
        }
    }
}

/// Why the database refuses rows for good: the same rows are refused again, whenever they come.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Rejection {
    /// The class of the error.
    pub cause: RejectionCause,
    /// The database's own code: an SQLSTATE, or SQLite's extended result code.
    pub code: String,
    /// The database's own text, for the log. It can quote values that a robot has sent.
    pub text: String,
}

/// The class of an error that rows cause by themselves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum RejectionCause {
    /// A value has no form in the database: SQLSTATE class 22, SQLite's MISMATCH and RANGE, or it cannot be encoded.
    Data,
    /// A constraint or a trigger refuses the row: SQLSTATE classes 23, 44 and P0, SQLite's CONSTRAINT.
    Constraint,
    /// The row or a value is larger than the database takes: SQLSTATE class 54, SQLite's TOOBIG.
    Size,
}

impl RejectionCause {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Data, Self::Constraint, Self::Size];

    /// In the words of the table `quarantine`, of REST and of the metric.
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
    /// Why these rows can never be written; none if another attempt may succeed.
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

/// A short description of the kind of problem, without the database's own text.
fn outline(problem: &sqlx::Error) -> String {
    if let sqlx::Error::Database(told) = problem {
        let code = told.code().unwrap_or_default();
        return match &*code {
            "" => "refused".to_owned(),
            "28P01" | "28000" => format!("password authentication failed (code {code})"),
            "3D000" => format!("there is no such database (code {code})"),
            "53300" => format!("too many connections (code {code})"),
            "57P03" => format!("the server is starting or stopping (code {code})"),
            _ => format!("refused with code {code}"),
        };
    }
    #[expect(clippy::wildcard_enum_match_arm, reason = "the library's errors: the others need no words of their own")]
    match problem {
        sqlx::Error::Io(problem) => format!("no connection ({})", problem.kind()),
        sqlx::Error::PoolTimedOut => "no free connection in time".to_owned(),
        sqlx::Error::PoolClosed => "the service stops".to_owned(),
        // sqlx may have more kinds tomorrow.
        _ => "no usable answer".to_owned(),
    }
}

/// Whether a server that gives this answer may give another one soon.
fn passes(problem: &sqlx::Error) -> bool {
    if let sqlx::Error::Database(told) = problem {
        // Connection trouble, lack of resources, shutting down or starting up, and conflicts.
        let code = told.code().unwrap_or_default();
        return ["08", "53", "57", "40", "55"].iter().any(|class| code.starts_with(class));
    }
    matches!(problem, sqlx::Error::Io(_) | sqlx::Error::PoolTimedOut | sqlx::Error::Protocol(_))
}

/// Names what a query is for, if it fails.
pub(super) fn failed(what: &'static str) -> impl FnOnce(sqlx::Error) -> StoreError {
    move |source| StoreError::Query { what, source }
}

#[cfg(test)]
mod tests {
    use super::RejectionCause::{self, Constraint, Data, Size};

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
