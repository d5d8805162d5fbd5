//! Membership of supervisors and ownership of fleets: supervisors sign in, acquire leases, and release them.

use std::sync::Arc;
use std::time::Duration;

use sqlx::sqlite::SqliteRow;
use sqlx::{Row, SqliteConnection};
use tokio::time::Instant;
use tracing::warn;
use vibrissa_host::random;
use vibrissa_protocol::Name;

mod sign_in;

use sign_in::{Answer, Question, forget_the_gone, membership, sign_in};
pub use sign_in::{LeaseRow, MemberRow, SignedIn};

use super::database::{Either, Tx, on};
use super::lease::micros;
use super::lease_watch::Renewal;
use super::model::Model;
use super::{Lease, StoreError, Writer, failed};
use crate::fault::{self, Fault};

/// A supervisor as a member of the cluster.
#[derive(Debug, Clone)]
pub struct Supervisor {
    /// Identifier of the process, unique to each start.
    pub id: Arc<str>,
    /// Name of the supervisor, for people.
    pub name: String,
    /// Fleets that it may own.
    pub fleets: Vec<Name>,
    /// Time after which its leases expire if they are not renewed.
    pub time_to_live: Duration,
}

/// State of the lease of a fleet.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FleetLease {
    /// Name of the fleet.
    pub fleet: Name,
    /// Newest epoch; 0 if the fleet never had an owner.
    pub epoch: u64,
    /// Identifier of the present or last owner; `None` if the lease was released or never acquired.
    pub owner: Option<String>,
    /// Name of the supervisor that owns or owned it, for people.
    pub holder: Option<String>,
    /// Whether the lease can be acquired now.
    pub free: bool,
    /// Time until the lease expires unless its owner renews it; `None` if it has expired or never does.
    pub free_in: Option<Duration>,
}

/// State of the cluster, from which a supervisor determines its share of the fleets.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Membership {
    /// Leases of the fleets that this supervisor may own.
    pub leases: Vec<FleetLease>,
    /// Supervisors that are present, including this one.
    pub present: Vec<Present>,
    /// How far the database's clock is ahead of this process's, in µs; `None` if that is not known: it has none of its
    /// own (SQLite), or it answered too slowly.
    pub database_ahead_us: Option<i64>,
}

/// A supervisor that is present.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Present {
    /// Identifier of its process, unique to each start.
    pub supervisor: String,
    /// Fleets that it may own.
    pub fleets: Vec<Name>,
    /// Its report on the fleets that it hears.
    pub hearing: FleetsHeard,
    /// Its report on its clock.
    pub clock: ClockReport,
}

/// A supervisor's report on its clock.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ClockReport {
    /// How far its clock is ahead of the database's, in µs, if it knows.
    pub ahead_us: Option<i64>,
    /// The same of the median clock of the robots that it hears.
    pub robots_ahead_us: Option<i64>,
    /// Most other clocks contradict its own. It may own a fleet only if that holds for all others, too.
    pub is_wrong: bool,
}

/// A supervisor's report on which fleets it receives messages of. A supervisor may own a fleet that is in neither list,
/// unless the fleet's owner does not hear it: then only supervisors with the fleet in `heard` may acquire it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct FleetsHeard {
    /// Fleets whose messages it does not receive.
    pub deaf: Vec<Name>,
    /// Fleets that it does not own and whose messages it has just proved to receive.
    pub heard: Vec<Name>,
}

impl Writer {
    /// As [`Self::sign_in_reporting`], without reports.
    ///
    /// # Errors
    /// The database does not answer within the time to live.
    pub async fn sign_in(&mut self, supervisor: &Supervisor, held: &[Lease]) -> Result<Membership, StoreError> {
        self.sign_in_reporting(supervisor, held, &FleetsHeard::default(), ClockReport::default()).await
    }

    /// Registers a supervisor with its reports on hearing and clock, renews its leases for another time to live, and
    /// reads the owners of its fleets.
    ///
    /// # Errors
    /// The database does not answer within the time to live.
    pub async fn sign_in_reporting(
        &mut self,
        supervisor: &Supervisor,
        held: &[Lease],
        hearing: &FleetsHeard,
        clock: ClockReport,
    ) -> Result<Membership, StoreError> {
        const WHAT: &str = "renew the leases";
        let first = Question::now();
        let model = |model: &mut dyn Model| Ok(Answer::Shared(model.sign_in(supervisor, held, hearing, clock), first));
        let answer = self
            .attempt(WHAT, supervisor.time_to_live, model, async |link| {
                match link {
                    Either::Sqlite(link) => sqlite_membership(link, supervisor).await.map(Answer::Alone),
                    Either::Postgres(link) => sign_in(link, supervisor, held, (hearing, clock)).await,
                }
                .map_err(failed(WHAT))
            })
            .await?;
        let membership = match answer {
            Answer::Alone(membership) => membership,
            Answer::Shared(rows, question) => {
                for lease in held.iter().filter(|lease| rows.renewed.iter().any(|one| one == lease.fleet().as_str())) {
                    lease.confirmed(first.asked);
                }
                membership(rows, question, supervisor, &mut self.lease_watch)
            }
        };
        for lease in &membership.leases {
            self.know_epoch(&lease.fleet, lease.epoch);
        }
        Ok(membership)
    }

    /// Acquires the lease of a free fleet, in a new epoch; `None` if another supervisor was faster. A fleet that the last
    /// [`Self::sign_in_reporting`] read is free only if this process's monotonic clock says so, and if its row has not
    /// changed since.
    ///
    /// # Errors
    /// The database does not answer within the time to live.
    pub async fn acquire(&mut self, supervisor: &Supervisor, fleet: &Name) -> Result<Option<Lease>, StoreError> {
        Ok(self.acquire_several(supervisor, std::slice::from_ref(fleet)).await?.pop())
    }

    /// As [`Self::acquire`] for several fleets in one transaction, because each commit waits for the disk and for a
    /// standby. Returns the leases of those that were free.
    ///
    /// # Errors
    /// The database does not answer within the time to live.
    pub async fn acquire_several(
        &mut self,
        supervisor: &Supervisor,
        fleets: &[Name],
    ) -> Result<Vec<Lease>, StoreError> {
        const WHAT: &str = "acquire leases";
        let asked = Instant::now();
        let known = |fleet: &Name| if fault::is(Fault::EpochReuse) { 0 } else { self.highest_epoch(fleet) };
        let known: Vec<u64> = fleets.iter().map(known).collect();
        let seen: Vec<Option<Renewal>> =
            fleets.iter().map(|fleet| self.lease_watch.claim(fleet, asked).seen()).collect();
        let step = if fault::is(Fault::EpochReuse) { 1 } else { epoch_step() };
        let all = || fleets.iter().zip(&known).zip(&seen);
        let model = |model: &mut dyn Model| {
            let epochs = all().map(|((fleet, known), seen)| model.acquire(supervisor, fleet, [*known, step], *seen));
            Ok((epochs.collect(), true))
        };
        let (epochs, is_shared): (Vec<Option<i64>>, bool) = self
            .attempt(WHAT, supervisor.time_to_live, model, async |link| {
                let mut tx = link.begin().await.map_err(failed(WHAT))?;
                let sql = if matches!(tx, Either::Postgres(_)) { ACQUIRE_POSTGRES } else { ACQUIRE_SQLITE };
                let mut epochs = Vec::new();
                for ((fleet, known), seen) in all() {
                    let epoch = raise_epoch(&mut tx, sql, supervisor, (fleet, *seen), (*known, step)).await;
                    epochs.push(epoch.map_err(failed(WHAT))?);
                }
                let is_shared = matches!(tx, Either::Postgres(_));
                if let Either::Postgres(tx) = &mut tx {
                    forget_the_gone(&mut *tx).await.map_err(failed(WHAT))?;
                }
                tx.commit().await.map_err(failed(WHAT))?;
                Ok((epochs, is_shared))
            })
            .await?;
        let mut leases = Vec::new();
        for (fleet, epoch) in fleets.iter().zip(epochs) {
            if let Some(epoch) = epoch {
                self.know_epoch(fleet, epoch as u64);
                leases.push(Lease::taken(supervisor, fleet, epoch, asked, is_shared));
            }
        }
        Ok(leases)
    }

    /// Highest epoch of a fleet that this process has seen; 0 before the first.
    fn highest_epoch(&self, fleet: &Name) -> u64 {
        self.highest_epochs.get(fleet).copied().unwrap_or_default()
    }

    fn know_epoch(&mut self, fleet: &Name, epoch: u64) {
        let last = self.last_epochs.insert(fleet.clone(), epoch).unwrap_or_default();
        if last > epoch {
            warn!(
                %fleet, epoch, before = last,
                "the database has lost commits: it knows only an earlier epoch of the fleet"
            );
        }
        let highest = self.highest_epoch(fleet).max(epoch);
        self.highest_epochs.insert(fleet.clone(), highest);
    }

    /// Releases a lease, so that the fleet can be acquired at once.
    ///
    /// # Errors
    /// The database does not answer within the time to live.
    pub async fn release(&mut self, lease: &Lease) -> Result<(), StoreError> {
        const WHAT: &str = "release a lease";
        const SQL: &str =
            "UPDATE leases SET owner = NULL, expires_us = 0 WHERE fleet = $1 AND epoch = $2 AND owner = $3";
        let model = |model: &mut dyn Model| {
            model.release(lease);
            Ok(())
        };
        self.attempt(WHAT, lease.time_to_live(), model, async |link| {
            on!(link, |link| sqlx::query(SQL)
                .bind(lease.fleet().as_str())
                .bind(lease.epoch() as i64)
                .bind(lease.owner())
                .execute(link)
                .await
                .map(drop))
            .map_err(failed(WHAT))
        })
        .await
    }

    /// Removes a supervisor from the members.
    ///
    /// # Errors
    /// The database does not answer within the time to live.
    pub async fn sign_out(&mut self, supervisor: &Supervisor) -> Result<(), StoreError> {
        const WHAT: &str = "sign out";
        const SQL: &str = "DELETE FROM supervisors WHERE supervisor = $1";
        let model = |model: &mut dyn Model| {
            model.sign_out(supervisor);
            Ok(())
        };
        self.attempt(WHAT, supervisor.time_to_live, model, async |link| {
            on!(link, |link| sqlx::query(SQL).bind(&*supervisor.id).execute(link).await.map(drop)).map_err(failed(WHAT))
        })
        .await
    }
}

// An epoch is the time at which it began, in ms since 1970, or a step more than the previous epoch if that is not lower.
// A plain counter would restart when a back-up is restored: epochs and versions would repeat, and robots would refuse
// lower ones and take equal ones for duplicates. The time is higher than any earlier epoch, whatever happened to the
// database, unless a clock was ahead by more than the age of the back-up. After a failover that lost the last commits, this
// age is short and the clock another server's: so an epoch is also higher than all that this process knows. If the clock went
// back, too, two supervisors may begin an epoch above the same one, the first of which is lost: so the step is random.

/// Step above the previous epoch, 1 to 1000.
fn epoch_step() -> u64 {
    1 + u64::from_ne_bytes(random::bytes()) % 1000
}

/// SQLite: the lock of the file stands for the lease, so its holder may acquire every fleet.
const ACQUIRE_SQLITE: &str = "INSERT INTO leases (fleet, epoch, owner, holder) \
    VALUES ($1, max($4, $5 + $9), $2, $3) \
    ON CONFLICT (fleet) DO UPDATE SET epoch = max(epoch + $9, excluded.epoch), owner = excluded.owner, \
    holder = excluded.holder, commits = 0, numbers = 0 RETURNING epoch";

/// PostgreSQL: skips a row that is locked, because its owner is committing. A lease of our own can be acquired again:
/// the answer to an earlier attempt may have been lost. The last three parameters are the row that was seen to be free;
/// without one the clock decides.
const ACQUIRE_POSTGRES: &str = "UPDATE leases SET epoch = greatest(epoch + $9::bigint, clock_us() / 1000, $5 + $9::bigint), owner = $2, \
    holder = $3, commits = 0, numbers = 0, expires_us = clock_us() + $4 WHERE fleet = (SELECT fleet FROM leases \
    WHERE fleet = $1 AND (owner = $2 OR CASE \
    WHEN $6::bigint IS NULL THEN expires_us <= clock_us() \
    ELSE epoch = $6 AND commits = $7::bigint AND expires_us = $8::bigint END) \
    FOR UPDATE SKIP LOCKED) RETURNING epoch";

async fn raise_epoch(
    tx: &mut Tx<'_>,
    sql: &'static str,
    supervisor: &Supervisor,
    (fleet, seen): (&Name, Option<Renewal>),
    (known, step): (u64, u64),
) -> sqlx::Result<Option<i64>> {
    let now_us = vibrissa_edge::clock::wall_clock().0 as i64;
    // The fourth parameter: time to live in µs (PostgreSQL), or the time in ms since 1970 (SQLite).
    let fourth =
        if matches!(tx, Either::Postgres(_)) { micros(supervisor.time_to_live) } else { (now_us / 1000).max(1) };
    const HISTORY: &str = "INSERT INTO epochs (fleet, epoch, owner, holder, began_us) VALUES ($1, $2, $3, $4, $5)";
    let epoch: Option<i64> = on!(&mut *tx, |tx| sqlx::query_scalar(sql)
        .bind(fleet.as_str())
        .bind(&*supervisor.id)
        .bind(&supervisor.name)
        .bind(fourth)
        .bind(known as i64)
        .bind(seen.map(|seen| seen.epoch))
        .bind(seen.map(|seen| seen.commits))
        .bind(seen.map(|seen| seen.expires_us))
        .bind(step as i64)
        .fetch_optional(&mut **tx)
        .await)?;
    if let Some(epoch) = epoch {
        on!(tx, |tx| sqlx::query(HISTORY)
            .bind(fleet.as_str())
            .bind(epoch)
            .bind(&*supervisor.id)
            .bind(&supervisor.name)
            .bind(now_us)
            .execute(&mut **tx)
            .await
            .map(drop))?;
    }
    Ok(epoch)
}

async fn sqlite_membership(link: &mut SqliteConnection, supervisor: &Supervisor) -> sqlx::Result<Membership> {
    const SQL: &str = "SELECT fleet, epoch, owner, holder FROM leases";
    let rows = sqlx::query(SQL).fetch_all(link).await?;
    let leases = supervisor.fleets.iter().map(|fleet| {
        let row = rows.iter().find(|row| row.try_get("fleet").is_ok_and(|name: &str| name == fleet.as_str()));
        // Nobody else has the file, so a damaged row must not keep the fleet from being supervised.
        let text = |column| row.and_then(|row: &SqliteRow| row.try_get(column).ok().flatten());
        let owner: Option<String> = text("owner");
        FleetLease {
            fleet: fleet.clone(),
            epoch: row.and_then(|row| row.try_get::<i64, _>("epoch").ok()).unwrap_or_default() as u64,
            free: owner.as_deref() != Some(&*supervisor.id),
            free_in: None,
            owner,
            holder: text("holder"),
        }
    });
    // No other supervisor can own the fleets, so hearing does not matter.
    let (supervisor, fleets) = (supervisor.id.to_string(), supervisor.fleets.clone());
    let present = vec![Present { supervisor, fleets, ..Present::default() }];
    Ok(Membership { leases: leases.collect(), present, database_ahead_us: None })
}
