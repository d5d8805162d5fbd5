//! The database: named queries, one transaction for each batch.
//!
//! [`Store`] answers what people ask ([`read`], as [`readings`]); a [`Writer`] has a connection of its own, and
//! writes only what a [`Lease`] allows: [`batch`] is what is written, `commit` writes it, `load` reads back what
//! taking up a fleet needs. `sqlite` and `postgres` hold what differs. Nothing outside this module knows SQL.

pub mod actions;
pub mod address;
pub mod alarms;
pub mod allowed;
mod apart;
pub mod backup;
pub mod batch;
pub mod calibrations;
pub mod changes;
mod commit;
mod database;
mod error;
pub mod fault;
pub mod group;
mod lease;
pub mod list;
pub mod lists;
mod load;
mod lock;
mod partitions;
mod postgres;
mod quarantine;
pub mod read;
pub mod readings;
mod records;
mod redo;
mod resolution;
pub mod retention;
mod roll;
pub mod secret;
pub mod series;
mod sqlite;
pub mod time;
pub mod tokens;
mod writer;

use std::sync::Arc;

use tracing::warn;

pub use address::{DatabaseAddress, PostgresAddress};
pub use apart::Refused;
pub use batch::Batch;
pub use error::{Rejection, RejectionCause, StoreError};
pub use lease::Lease;
pub use load::{NumberedWhisker, RobotState, StoredRobot};
pub use resolution::Resolution;
pub use roll::{FleetLease, FleetsHeard, Present, Roll, Supervisor};
pub use writer::Writer;

use database::{ACQUIRE_PATIENCE, Either, Options, Pool, on};
use error::failed;

/// An open database, for reading.
#[derive(Debug, Clone)]
pub struct Store {
    pool: Pool,
    options: Arc<Options>,
    name: Arc<str>,
}

impl Store {
    /// Opens the database for a supervisor of that name. A file is made and locked; a server is not asked
    /// anything yet.
    ///
    /// # Errors
    /// The file or its folder cannot be used, or another supervisor has it.
    pub async fn open(address: &DatabaseAddress, supervisor: &str) -> Result<Self, StoreError> {
        let name: Arc<str> = address.to_string().into();
        let (pool, options) = match address {
            DatabaseAddress::Sqlite(path) => sqlite::open(path, &name, supervisor).await?,
            DatabaseAddress::Postgres(address) => postgres::open(address, supervisor),
        };
        Ok(Self { pool, options: Arc::new(options), name })
    }

    /// Opens the database for a moment, with its tables up to date, for a command beside the service: a file that a
    /// supervisor works with is opened beside it, and its tables are as that supervisor needs them.
    ///
    /// # Errors
    /// The database cannot be used.
    pub async fn open_for_command(address: &DatabaseAddress) -> Result<Self, StoreError> {
        match (Self::open(address, "vibrissa (a command)").await, address) {
            (Ok(store), _) => {
                store.prepare().await?;
                Ok(store)
            }
            (Err(StoreError::InUse { .. }), DatabaseAddress::Sqlite(path)) => {
                let name: Arc<str> = address.to_string().into();
                let (pool, options) = sqlite::open_beside(path, &name).await?;
                Ok(Self { pool, options: Arc::new(options), name })
            }
            (Err(problem), _) => Err(problem),
        }
    }

    /// Brings the tables up to date.
    ///
    /// # Errors
    /// The database is away, too old, or not ours; [`StoreError::is_passing`] tells the first from the others.
    pub async fn prepare(&self) -> Result<(), StoreError> {
        if let Either::Postgres(pool) = &self.pool {
            postgres::check_version(pool, &self.name).await?;
        }
        self.pool.migrate(&self.name).await?;
        let made = self.make_partitions(vibrissa_edge::clock::wall_clock().0 as i64, &mut |_| {}).await;
        if let Err(problem) = made {
            // The default partitions take what comes, and it is tried again.
            warn!(%problem, "partitions are missing");
        }
        Ok(())
    }

    /// A writer, with a connection of its own.
    #[must_use]
    pub fn writer(&self) -> Writer {
        Writer::new(self.options.clone())
    }

    /// Whether several supervisors can share it.
    #[must_use]
    pub fn is_shared(&self) -> bool {
        matches!(self.pool, Either::Postgres(_))
    }

    /// Whether it answers.
    ///
    /// # Errors
    /// It does not.
    pub async fn ping(&self) -> Result<(), StoreError> {
        const WHAT: &str = "ask whether it is there";
        let asked = async { on!(&self.pool, |pool| sqlx::query("SELECT 1").execute(pool).await.map(drop)) };
        match tokio::time::timeout(ACQUIRE_PATIENCE, asked).await {
            Ok(answered) => answered.map_err(failed(WHAT)),
            Err(_) => Err(StoreError::NoAnswer { what: WHAT, patience: ACQUIRE_PATIENCE }),
        }
    }

    /// Closes all connections, so that a file is complete by itself.
    pub async fn close(&self) {
        on!(&self.pool, |pool| pool.close().await);
    }
}
