//! The database: named queries for readers, one transaction for each batch of a fleet.
//!
//! [`Store`] answers queries ([`queries`], [`lists`]). A [`Writer`] has its own connection and writes for a fleet only
//! under its [`Lease`]. [`batch`] declares the rows of a transaction, [`tables`] has the statement of each, `commit`
//! writes them, and `load` reads a fleet's state for its recovery. `row` makes statements from declarations. `sqlite`
//! and `postgres` hold what else differs between the two databases. [`model`] answers in place of SQL in simulated time. No other
//! crate contains SQL.

pub mod actions;
pub mod address;
pub mod aggregates;
pub mod alarm_statistics;
pub mod alarms;
pub mod alarms_at_once;
pub mod allowed;
mod apart;
pub mod archive;
pub mod backup;
pub mod batch;
pub mod black_boxes;
pub mod bulk;
pub mod calibrations;
mod cause;
mod commit;
mod connect;
pub mod contact_uses;
mod database;
pub mod decommission;
mod epochs;
mod error;
pub mod events;
pub mod export;
pub mod fault;
pub mod from_row;
pub mod labels;
mod lease;
mod lease_watch;
pub mod list;
pub mod lists;
mod load;
mod lock;
mod log_position;
pub mod maintenance;
pub mod maintenance_facts;
mod membership;
pub mod model;
mod no_server;
pub mod notes;
pub mod overview;
pub mod policies;
mod postgres;
pub mod programs;
mod quarantine;
pub mod queries;
mod records;
pub mod refusals;
mod resolution;
pub mod retention;
pub mod rollouts;
mod row;
pub mod secret;
pub mod series;
pub mod sessions;
mod set_aside;
mod sqlite;
pub mod tables;
pub mod time;
pub mod tokens;
pub mod webhooks;
mod writer;

use std::sync::{Arc, Mutex};

use tracing::warn;

pub use address::{DatabaseAddress, PostgresAddress};
pub use apart::Refused;
pub use batch::Batch;
pub use error::{LossCause, Rejection, RejectionCause, StoreError};
pub use lease::{Lease, LeaseCounts};
pub use lease_watch::Renewal;
pub use load::{JournalReading, NumberedWhisker, RobotState, StoredRobot, StoredRobots};
pub use log_position::LogPositions;
pub use membership::{
    ClockReport, FleetLease, FleetsHeard, LeaseRow, MemberRow, Membership, Present, SignedIn, Supervisor,
};
pub use no_server::{NoServer, Refusal};
pub use postgres::Replication;
pub use resolution::Resolution;
pub use set_aside::SetAside;
pub use writer::Writer;

use connect::Options;
use database::{ACQUIRE_PATIENCE, Either, Pool, on};
use error::failed;
use lease_watch::LeaseWatch;
use model::{Model, ModelServer};

/// An open database, for queries. Clones share its connections.
#[derive(Debug, Clone)]
pub struct Store {
    pool: Pool,
    options: Arc<Options>,
    name: Arc<str>,
    set_aside: SetAside,
    /// Holds of webhooks by other supervisors.
    holds: Arc<Mutex<LeaseWatch>>,
    /// Answers in place of SQL.
    model: Option<Arc<dyn ModelServer>>,
}

impl Store {
    /// Opens the database for the supervisor `supervisor`. An SQLite file is created if it is missing, and locked; a
    /// PostgreSQL server is not contacted yet.
    ///
    /// # Errors
    /// The file or its folder cannot be used, or another supervisor has locked the file.
    pub async fn open(address: &DatabaseAddress, supervisor: &str) -> Result<Self, StoreError> {
        let name: Arc<str> = address.to_string().into();
        let (pool, options) = match address {
            DatabaseAddress::Sqlite(path) => sqlite::open(path, &name, supervisor).await?,
            DatabaseAddress::Postgres(address) => {
                let (pool, route) = postgres::open(address, supervisor);
                (pool, Either::Postgres(route))
            }
        };
        Ok(Self::of(pool, options, name))
    }

    fn of(pool: Pool, options: Options, name: Arc<str>) -> Self {
        let options = Arc::new(options);
        Self { pool, options, name, set_aside: SetAside::default(), holds: Arc::default(), model: None }
    }

    /// A database in memory, with PostgreSQL's meaning. Queries in SQL fail, because all connections are closed.
    ///
    /// # Panics
    /// There is no Tokio runtime.
    #[must_use]
    pub fn modelled(server: Arc<dyn ModelServer>) -> Self {
        let (pool, route) = postgres::closed();
        Self { model: Some(server), ..Self::of(pool, Either::Postgres(route), "model".into()) }
    }

    /// Opens the database for a command beside the service, and migrates its tables. An SQLite file that a supervisor
    /// has locked is opened without the lock; its tables are left to that supervisor.
    ///
    /// # Errors
    /// The database cannot be used.
    pub async fn open_for_command(address: &DatabaseAddress) -> Result<Self, StoreError> {
        match (Self::open(address, "vibrissa (a command)").await, address) {
            (Ok(store), _) => {
                store.prepare().await?;
                // A long command does not keep a supervisor from its start.
                if let Either::Sqlite((_, Some(lock))) = &*store.options {
                    lock.release();
                }
                Ok(store)
            }
            (Err(StoreError::InUse { .. }), DatabaseAddress::Sqlite(path)) => {
                let name: Arc<str> = address.to_string().into();
                let (pool, options) = sqlite::open_beside(path, &name).await?;
                Ok(Self::of(pool, options, name))
            }
            (Err(problem), _) => Err(problem),
        }
    }

    /// Looks for damage of a SQLite file, for at most 10 s. PostgreSQL checks its own files.
    ///
    /// # Errors
    /// The file is damaged.
    pub async fn check(&self) -> Result<(), StoreError> {
        match &*self.options {
            Either::Sqlite((options, _)) => sqlite::check(options).await,
            Either::Postgres(_) => Ok(()),
        }
    }

    /// Migrates the tables to the newest version.
    ///
    /// # Errors
    /// The database is unreachable, too old, behind a pooler that shares sessions, or not one of vibrissa;
    /// [`StoreError::is_passing`] is true only for the first.
    pub async fn prepare(&self) -> Result<(), StoreError> {
        if let Some(model) = &self.model {
            return model.query("migrate the tables", |_| Ok(())).await;
        }
        if let Either::Postgres(route) = &*self.options {
            postgres::check(route, &self.name).await?;
        }
        if let Either::Sqlite(pool) = &self.pool {
            sqlite::check_tables(pool, &self.options).await?;
        }
        self.pool.migrate(&self.name).await?;
        if let Either::Postgres(pool) = &self.pool {
            postgres::protect_audit_log(pool).await.map_err(failed("protect the audit log"))?;
        }
        if let Either::Sqlite((_, Some(lock))) = &*self.options {
            lock.set_installed()?;
        }
        let made = self.make_partitions(vibrissa_edge::clock::wall_clock().0 as i64, &mut |_| {}).await;
        if let Err(problem) = made {
            // The default partitions store the rows meanwhile, and upkeep tries again.
            warn!(%problem, "cannot create partitions, the default ones are used");
        }
        Ok(())
    }

    /// A writer with its own connection.
    #[must_use]
    pub fn writer(&self) -> Writer {
        Writer::new(self.options.clone(), self.set_aside.clone(), self.model.clone())
    }

    /// The rows that could not be read.
    #[must_use]
    pub fn set_aside(&self) -> &SetAside {
        &self.set_aside
    }

    /// Ends an operation with an error if the database gets a new leader meanwhile: the former one may never answer.
    ///
    /// # Errors
    /// Those of the operation, or a new leader.
    pub async fn with_leader<T>(&self, work: impl Future<Output = Result<T, StoreError>>) -> Result<T, StoreError> {
        let mut watching = self.writer();
        tokio::select! {
            done = work => done,
            () = watching.new_leader() => Err(failed("finish at the former leader")(writer::former_leader())),
        }
    }

    /// Whether several supervisors can share this database: true for PostgreSQL.
    #[must_use]
    pub fn is_shared(&self) -> bool {
        matches!(self.pool, Either::Postgres(_))
    }

    /// Checks that the database answers.
    ///
    /// # Errors
    /// The database does not answer within three seconds, or answers with an error.
    pub async fn ping(&self) -> Result<(), StoreError> {
        const WHAT: &str = "check the connection";
        if let Some(model) = &self.model {
            return model.query(WHAT, |_| Ok(())).await;
        }
        let asked = async { on!(&self.pool, |pool| sqlx::query("SELECT 1").execute(pool).await.map(drop)) };
        match tokio::time::timeout(ACQUIRE_PATIENCE, asked).await {
            Ok(answered) => answered.map_err(failed(WHAT)),
            Err(_) => Err(StoreError::NoAnswer { what: WHAT, patience: ACQUIRE_PATIENCE }),
        }
    }

    /// Closes all connections for queries, and unlocks an SQLite file; SQLite then needs no files beside the database
    /// file. Writers must have ended: another supervisor may write from now on.
    pub async fn close(&self) {
        on!(&self.pool, |pool| pool.close().await);
        if let Either::Sqlite((_, Some(lock))) = &*self.options {
            lock.release();
        }
    }
}

#[cfg(test)]
mod schema;
