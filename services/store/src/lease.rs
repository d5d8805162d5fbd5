//! Leases: the right to write for a fleet, one row for each fleet. `lease_watch` tells when one has expired.

use std::sync::atomic::{AtomicI64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use sqlx::{PgConnection, SqliteConnection};
use tokio::time::Instant;
use vibrissa_protocol::Name;

use super::database::{Either, Tx, on};
use super::model::{Model, atomically};
use super::{LossCause, StoreError, Supervisor, failed, postgres};
use crate::fault::{self, Fault};

/// The counters in the row of a lease.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LeaseCounts {
    /// Number of the owner's transactions.
    pub commits: i64,
    /// Number of transactions that assigned numbers to robots, boots and whiskers.
    pub numbers: i64,
}

/// The right to write for a fleet, until another supervisor acquires it. Clones share their state.
#[derive(Debug, Clone)]
pub struct Lease {
    fleet: Name,
    epoch: u64,
    owner: Arc<str>,
    time_to_live: Duration,
    /// Number of this lease's committed transactions, as far as known.
    commits: Arc<AtomicI64>,
    /// Least number that the row must have of transactions that assigned numbers: of those whose answers arrived.
    numbers: Arc<AtomicI64>,
    /// Time before which no other supervisor can acquire the lease; `None` for SQLite, where none ever can.
    fresh_until: Option<Arc<Mutex<Instant>>>,
}

impl Lease {
    /// A lease that a supervisor has just acquired. `asked` is the moment before the query; the time to live counts
    /// from there.
    pub(super) fn taken(supervisor: &Supervisor, fleet: &Name, epoch: i64, asked: Instant, is_shared: bool) -> Self {
        Self {
            fleet: fleet.clone(),
            epoch: epoch as u64,
            owner: supervisor.id.clone(),
            time_to_live: supervisor.time_to_live,
            commits: Arc::new(AtomicI64::new(0)),
            numbers: Arc::new(AtomicI64::new(0)),
            fresh_until: is_shared.then(|| Arc::new(Mutex::new(asked + supervisor.time_to_live))),
        }
    }

    /// Name of the fleet.
    #[must_use]
    pub fn fleet(&self) -> &Name {
        &self.fleet
    }

    /// Epoch of the lease, which rises at each change of owner.
    #[must_use]
    pub fn epoch(&self) -> u64 {
        self.epoch
    }

    /// Whether the lease certainly holds now, by this process' clock. If not, nothing may be published.
    #[must_use]
    pub fn is_fresh(&self) -> bool {
        self.fresh_until().is_none_or(|until| Instant::now() < until)
    }

    /// Until when the lease certainly holds, by this process' clock; `None` if no other supervisor can ever acquire it.
    #[must_use]
    pub fn fresh_until(&self) -> Option<Instant> {
        self.fresh_until.as_ref().map(|until| *until.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Identifier of the owner's process.
    #[must_use]
    pub fn owner(&self) -> &str {
        &self.owner
    }

    /// Time after which the lease expires if it is not renewed.
    #[must_use]
    pub fn time_to_live(&self) -> Duration {
        self.time_to_live
    }

    /// Extends the lease by a time to live from `asked`: the database has confirmed it in answer to a query begun then.
    pub(super) fn confirmed(&self, asked: Instant) {
        if let Some(until) = &self.fresh_until {
            let mut until = until.lock().unwrap_or_else(PoisonError::into_inner);
            *until = (*until).max(asked + self.time_to_live);
        }
    }

    fn lost(&self, cause: LossCause) -> StoreError {
        StoreError::LeaseLost { fleet: self.fleet.to_string(), epoch: self.epoch, cause }
    }

    /// Checks the lease and locks its row, for a transaction that may be repeated without harm, because it replaces rows
    /// or adds to counts, and that no later one needs.
    pub(super) async fn hold(&self, tx: &mut Tx<'_>) -> Result<(), StoreError> {
        const SQL: &str = "UPDATE leases SET holder = holder WHERE fleet = $1 AND epoch = $2 AND owner = $3";
        let held = on!(tx, |tx| sqlx::query(SQL)
            .bind(self.fleet().as_str())
            .bind(self.epoch as i64)
            .bind(&*self.owner)
            .execute(&mut **tx)
            .await
            .map(|done| done.rows_affected()))
        .map_err(failed("check the lease"))?;
        self.if_held(held == 1)
    }

    /// As [`Self::hold`], in a model; returns the model.
    pub(super) fn hold_in<'m>(&self, model: &'m mut dyn Model) -> Result<&'m mut dyn Model, StoreError> {
        self.if_held(model.counts(self).is_some()).map(|()| model)
    }

    fn if_held(&self, is_held: bool) -> Result<(), StoreError> {
        if is_held || fault::is(Fault::NoFence) { Ok(()) } else { Err(self.lost(LossCause::TakenOver)) }
    }

    /// As [`Self::hold`], for a transaction that assigns numbers. Later transactions refer to them, so the row counts it.
    /// Returns the count, for [`Self::numbered`].
    pub(super) async fn count_numbers(&self, tx: &mut Tx<'_>) -> Result<i64, StoreError> {
        const SQL: &str = "UPDATE leases SET numbers = numbers + 1 \
             WHERE fleet = $1 AND epoch = $2 AND owner = $3 AND numbers >= $4 RETURNING numbers";
        let known = self.known();
        let counted: Option<i64> = on!(tx, |tx| sqlx::query_scalar(SQL)
            .bind(self.fleet().as_str())
            .bind(self.epoch as i64)
            .bind(&*self.owner)
            .bind(known.numbers)
            .fetch_optional(&mut **tx)
            .await)
        .map_err(failed("check the lease"))?;
        match counted {
            Some(numbers) => Ok(numbers),
            None if fault::is(Fault::NoFence) => Ok(known.numbers),
            None => Err(self.loss(self.look(tx).await?, known)),
        }
    }

    /// Runs a transaction that assigns numbers in a model; as [`Self::count_numbers`], also returns the count.
    pub(super) fn numbering_in<T>(
        &self,
        model: &mut dyn Model,
        work: impl FnOnce(&mut dyn Model) -> Result<T, StoreError>,
    ) -> Result<(T, i64), StoreError> {
        let known = self.known();
        atomically(model, |model| {
            let numbers = match model.count_numbers(self, known.numbers) {
                Some(numbers) => numbers,
                None if fault::is(Fault::NoFence) => known.numbers,
                None => return Err(self.loss(model.counts(self), known)),
            };
            Ok((work(model)?, numbers))
        })
    }

    /// A transaction that assigned numbers is committed, and `numbers` is its count. From now on the row must have it.
    /// A lost answer leaves the known count lower, which is harmless: the transaction is repeated.
    pub(super) fn numbered(&self, numbers: i64) {
        self.numbers.fetch_max(numbers, Ordering::Relaxed);
    }

    fn known(&self) -> LeaseCounts {
        LeaseCounts { commits: self.commits.load(Ordering::Relaxed), numbers: self.numbers.load(Ordering::Relaxed) }
    }

    /// Begins the owner's next transaction: advances the commit counter, which makes the transaction happen exactly
    /// once, and in PostgreSQL renews the lease. Returns false if the transaction was committed before and only its
    /// answer was lost.
    pub(super) async fn begin(&self, tx: &mut Tx<'_>) -> Result<bool, StoreError> {
        if fault::is(Fault::NoFence) {
            return Ok(true);
        }
        let known = self.known();
        let counted = match tx {
            Either::Sqlite(tx) => count_sqlite(&mut *tx, self, known).await,
            Either::Postgres(tx) => count_postgres(&mut *tx, self).await,
        }
        .map_err(failed("check the lease"))?;
        if counted {
            return Ok(true);
        }
        self.why(self.look(tx).await?, known)
    }

    /// As [`Self::begin`], in a model.
    pub(super) fn begin_in(&self, model: &mut dyn Model) -> Result<bool, StoreError> {
        let known = self.known();
        if fault::is(Fault::NoFence) || model.count_commit(self, known) {
            return Ok(true);
        }
        self.why(model.counts(self), known)
    }

    /// The counters in the row; `None` if the lease does not hold any more.
    async fn look(&self, tx: &mut Tx<'_>) -> Result<Option<LeaseCounts>, StoreError> {
        const SQL: &str = "SELECT commits, numbers FROM leases WHERE fleet = $1 AND epoch = $2 AND owner = $3";
        let row: Option<(i64, i64)> = on!(tx, |tx| sqlx::query_as(SQL)
            .bind(self.fleet().as_str())
            .bind(self.epoch as i64)
            .bind(&*self.owner)
            .fetch_optional(&mut **tx)
            .await)
        .map_err(failed("check the lease"))?;
        Ok(row.map(|(commits, numbers)| LeaseCounts { commits, numbers }))
    }

    /// Distinguishes why the counter did not advance: false if this transaction was committed before, an error if the
    /// lease is lost.
    fn why(&self, row: Option<LeaseCounts>, known: LeaseCounts) -> Result<bool, StoreError> {
        let was_committed = |row: LeaseCounts| row.commits == known.commits + 1 && row.numbers >= known.numbers;
        if row.is_some_and(was_committed) { Ok(false) } else { Err(self.loss(row, known)) }
    }

    /// The loss of the lease. A counter below the known one shows that the database went back to an earlier state.
    fn loss(&self, row: Option<LeaseCounts>, known: LeaseCounts) -> StoreError {
        let lost = |row: LeaseCounts| (known.commits - row.commits).max(0) + (known.numbers - row.numbers).max(0);
        self.lost(match row.map_or(0, lost) {
            0 => LossCause::TakenOver,
            commits => LossCause::CommitsLost { commits: commits as u64 },
        })
    }

    /// Binds the first parameters of a statement that advances the counter: fleet, epoch, owner, present count, time to
    /// live, and least count of transactions that assigned numbers.
    pub(super) fn bind(&self, statement: postgres::Query) -> postgres::Query {
        let known = self.known();
        statement
            .bind(self.fleet().as_str())
            .bind(self.epoch as i64)
            .bind(&*self.owner)
            .bind(known.commits)
            .bind(micros(self.time_to_live))
            .bind(known.numbers)
    }

    /// Counts a committed transaction. `asked`, the moment before its query, also extends the lease; it is `None` if an
    /// earlier attempt had committed the transaction.
    pub(super) fn committed(&self, asked: Option<Instant>) {
        self.commits.fetch_add(1, Ordering::Relaxed);
        if let Some(asked) = asked {
            self.confirmed(asked);
        }
    }
}

async fn count_sqlite(tx: &mut SqliteConnection, lease: &Lease, known: LeaseCounts) -> sqlx::Result<bool> {
    const SQL: &str = "UPDATE leases SET commits = $4 + 1 \
         WHERE fleet = $1 AND epoch = $2 AND owner = $3 AND commits = $4 AND numbers >= $5";
    sqlx::query(SQL)
        .bind(lease.fleet().as_str())
        .bind(lease.epoch as i64)
        .bind(&*lease.owner)
        .bind(known.commits)
        .bind(known.numbers)
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
