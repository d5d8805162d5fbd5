//! New connections for writing: to the file of SQLite, or to the server of PostgreSQL that accepts writes.

use sqlx::ConnectOptions;
use sqlx::sqlite::SqliteConnectOptions;

use super::StoreError;
use super::database::{Either, Link};
use super::error::failed;
use super::lock::FileLock;
use super::postgres::{Route, prepare_writer};

/// Options of new connections. For SQLite with the lock of the file; for PostgreSQL with the servers.
pub(super) type Options = Either<(SqliteConnectOptions, Option<FileLock>), Route>;

impl Options {
    /// Opens a connection for writing. `what` is its purpose, as a verb phrase after "cannot".
    pub(super) async fn connect(&self, what: &'static str) -> Result<Link, StoreError> {
        match self {
            Either::Sqlite((options, _)) => options.connect().await.map(Either::Sqlite).map_err(failed(what)),
            Either::Postgres(route) => {
                let mut link = route.connect().await.map_err(|none| none.preventing(what))?;
                prepare_writer(&mut link).await.map_err(failed(what))?;
                Ok(Either::Postgres(link))
            }
        }
    }
}
