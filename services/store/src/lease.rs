//! Who may write for a fleet: one row for each, by the database's clock.

use std::sync::atomic::{AtomicI64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use sqlx::{PgConnection, SqliteConnection};
use tokio::time::Instant;
use vibrissa_protocol::Name;

use super::database::{Either, Tx, on};
use super::{StoreError, Supervisor, failed, postgres};
use crate::fault::{self, Fault};

/// The right to write for a fleet, until somebody else has it. Clones are the same right.
#[derive(Debug, Clone)]
pub struct Lease {
    fleet: Name,
    epoch: u64,
    owner: Arc<str>,
    time_to_live: Duration,
    /// Transactions that are known as committed.
    commits: Arc<AtomicI64>,
    /// Nobody else can have it before; none where nobody else ever can.
    fresh_until: Option<Arc<Mutex<Instant>>>,
}

impl Lease {
    /// What a supervisor has just taken, having asked at that moment. What cannot be shared never expires.
    pub(super) fn taken(supervisor: &Supervisor, fleet: &Name, epoch: i64, asked: Instant, is_shared: bool) -> Self {
        Self {
            fleet: fleet.clone(),
            epoch: epoch as u64,
            owner: supervisor.id.clone(),
            time_to_live: supervisor.time_to_live,
            commits: Arc::new(AtomicI64::new(0)),
            fresh_until: is_shared.then(|| Arc::new(Mutex::new(asked + supervisor.time_to_live))),
        }
    }

    /// The fleet.
    #[must_use]
    pub fn fleet(&self) -> &Name {
        &self.fleet
    }

    /// Rises at each change of owner.
    #[must_use]
    pub fn epoch(&self) -> u64 {
        self.epoch
    }

    /// Whether it certainly holds now, by this process' clock: what is stale is not published.
    #[must_use]
    pub fn is_fresh(&self) -> bool {
        let Some(until) = &self.fresh_until else { return true };
        Instant::now() < *until.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whose it is.
    pub(super) fn owner(&self) -> &str {
        &self.owner
    }

    /// How long it lasts without a word.
    pub(super) fn time_to_live(&self) -> Duration {
        self.time_to_live
    }

    /// The database has confirmed it for another time to live, counted from before it was asked.
    pub(super) fn confirmed(&self, asked: Instant) {
        if let Some(until) = &self.fresh_until {
            let mut until = until.lock().unwrap_or_else(PoisonError::into_inner);
            *until = (*until).max(asked + self.time_to_live);
        }
    }

    fn lost(&self) -> StoreError {
        StoreError::LeaseLost { fleet: self.fleet.to_string(), epoch: self.epoch }
    }

    /// Locks the row for a transaction that writes numbers only, which may be written twice.
    pub(super) async fn hold(&self, tx: &mut Tx<'_>) -> Result<(), StoreError> {
        const SQL: &str = "UPDATE leases SET holder = holder WHERE fleet = $1 AND epoch = $2 AND owner = $3";
        let held = on!(tx, |tx| sqlx::query(SQL)
            .bind(self.fleet.as_str())
            .bind(self.epoch as i64)
            .bind(&*self.owner)
            .execute(&mut **tx)
            .await
            .map(|done| done.rows_affected()))
        .map_err(failed("check the lease"))?;
        if held == 1 || fault::is(Fault::NoFence) { Ok(()) } else { Err(self.lost()) }
    }

    /// Begins the next transaction of the owner: counts it, which makes it happen once, and keeps the lease for
    /// another time to live. False if it was committed before, although its answer was lost.
    pub(super) async fn begin(&self, tx: &mut Tx<'_>) -> Result<bool, StoreError> {
        if fault::is(Fault::NoFence) {
            return Ok(true);
        }
        let before = self.commits.load(Ordering::Relaxed);
        let counted = match tx {
            Either::Sqlite(tx) => count_sqlite(&mut *tx, self, before).await,
            Either::Postgres(tx) => count_postgres(&mut *tx, self).await,
        }
        .map_err(failed("check the lease"))?;
        if counted {
            return Ok(true);
        }
        self.look_why(tx, before).await
    }

    /// What does not count itself was committed before, or belongs to somebody else.
    async fn look_why(&self, tx: &mut Tx<'_>, before: i64) -> Result<bool, StoreError> {
        const SQL: &str = "SELECT commits FROM leases WHERE fleet = $1 AND epoch = $2 AND owner = $3";
        let commits: Option<i64> = on!(tx, |tx| sqlx::query_scalar(SQL)
            .bind(self.fleet.as_str())
            .bind(self.epoch as i64)
            .bind(&*self.owner)
            .fetch_optional(&mut **tx)
            .await)
        .map_err(failed("check the lease"))?;
        if commits == Some(before + 1) { Ok(false) } else { Err(self.lost()) }
    }

    /// Gives a statement that counts the next transaction what it asks for first: fleet, epoch, owner, count before and time to live.
    pub(super) fn bind(&self, statement: postgres::Statement) -> postgres::Statement {
        statement
            .bind(self.fleet.as_str())
            .bind(self.epoch as i64)
            .bind(&*self.owner)
            .bind(self.commits.load(Ordering::Relaxed))
            .bind(micros(self.time_to_live))
    }

    /// The next transaction is committed: by the attempt that asked the database at that moment, which keeps the
    /// lease; or, with none, by one before it whose moment is not known.
    pub(super) fn committed(&self, asked: Option<Instant>) {
        self.commits.fetch_add(1, Ordering::Relaxed);
        if let Some(asked) = asked {
            self.confirmed(asked);
        }
    }
}

async fn count_sqlite(tx: &mut SqliteConnection, lease: &Lease, before: i64) -> sqlx::Result<bool> {
    sqlx::query("UPDATE leases SET commits = $4 + 1 WHERE fleet = $1 AND epoch = $2 AND owner = $3 AND commits = $4")
        .bind(lease.fleet.as_str())
        .bind(lease.epoch as i64)
        .bind(&*lease.owner)
        .bind(before)
        .execute(tx)
        .await
        .map(|done| done.rows_affected() == 1)
}

async fn count_postgres(tx: &mut PgConnection, lease: &Lease) -> sqlx::Result<bool> {
    lease.bind(sqlx::query(postgres::COUNTED)).execute(tx).await.map(|done| done.rows_affected() == 1)
}

pub(super) fn micros(time: Duration) -> i64 {
    i64::try_from(time.as_micros()).unwrap_or(i64::MAX)
}
