//! Who is there and who has what: supervisors sign in, take fleets, and give them back.

use std::sync::Arc;
use std::time::Duration;

use sqlx::postgres::PgRow;
use sqlx::{PgConnection, Row, SqliteConnection};
use tokio::time::Instant;
use vibrissa_protocol::Name;

use super::database::{Either, Tx, on};
use super::lease::micros;
use super::{Lease, StoreError, Writer, failed};

/// A supervisor, as the others know it.
#[derive(Debug, Clone)]
pub struct Supervisor {
    /// One start of one supervisor.
    pub id: Arc<str>,
    /// What it is called.
    pub name: String,
    /// The fleets that it may own.
    pub fleets: Vec<Name>,
    /// How long it stays the owner of what it owns without a word.
    pub time_to_live: Duration,
}

/// Who has a fleet.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FleetLease {
    /// Fleet.
    pub fleet: Name,
    /// The newest epoch.
    pub epoch: u64,
    /// Whose it is or was.
    pub owner: Option<String>,
    /// The same, for people.
    pub holder: Option<String>,
    /// Whether it can be had.
    pub free: bool,
    /// When it can be had, if its owner falls silent now; none where that never frees it.
    pub free_in: Option<Duration>,
}

/// Everything that a supervisor must know to take its share.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Roll {
    /// The fleets that it may own.
    pub leases: Vec<FleetLease>,
    /// Those that are there, itself among them.
    pub present: Vec<Present>,
}

/// A supervisor that is there.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Present {
    /// One start of one supervisor.
    pub supervisor: String,
    /// The fleets that it may own.
    pub fleets: Vec<Name>,
    /// How it hears them.
    pub hearing: FleetsHeard,
}

/// A supervisor's reports on which fleets it hears. Fleets in neither list count as heard while their
/// owner hears them.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct FleetsHeard {
    /// Those that it does not hear.
    pub deaf: Vec<Name>,
    /// Those that it does not own, and has just proved to hear.
    pub heard: Vec<Name>,
}

impl Writer {
    /// As [`Self::sign_in_hearing`], for a supervisor that says nothing of how it hears.
    ///
    /// # Errors
    /// The database does not answer within the time to live.
    pub async fn sign_in(&mut self, supervisor: &Supervisor, held: &[Lease]) -> Result<Roll, StoreError> {
        self.sign_in_hearing(supervisor, held, &FleetsHeard::default()).await
    }

    /// Registers a supervisor and its hearing reports, renews its leases for another time to live, and reads the owners of all fleets.
    ///
    /// # Errors
    /// The database does not answer within the time to live.
    pub async fn sign_in_hearing(
        &mut self,
        supervisor: &Supervisor,
        held: &[Lease],
        hearing: &FleetsHeard,
    ) -> Result<Roll, StoreError> {
        const WHAT: &str = "keep the leases";
        let asked = Instant::now();
        let (roll, renewed) = self
            .attempt(WHAT, supervisor.time_to_live, async |link| {
                match link {
                    Either::Sqlite(link) => sqlite_roll(link, supervisor).await.map(|roll| (roll, Vec::new())),
                    Either::Postgres(link) => sign_in(link, supervisor, held, hearing).await,
                }
                .map_err(failed(WHAT))
            })
            .await?;
        for lease in held.iter().filter(|lease| renewed.iter().any(|fleet| fleet == lease.fleet().as_str())) {
            lease.confirmed(asked);
        }
        Ok(roll)
    }

    /// Takes a fleet that is free, in a new epoch; none if somebody else was quicker.
    ///
    /// # Errors
    /// The database does not answer within the time to live.
    pub async fn acquire(&mut self, supervisor: &Supervisor, fleet: &Name) -> Result<Option<Lease>, StoreError> {
        const WHAT: &str = "take a fleet";
        let asked = Instant::now();
        let (epoch, is_shared) = self
            .attempt(WHAT, supervisor.time_to_live, async |link| {
                let mut tx = link.begin().await.map_err(failed(WHAT))?;
                let sql = if matches!(tx, Either::Postgres(_)) { ACQUIRE_POSTGRES } else { ACQUIRE_SQLITE };
                let epoch = raise_epoch(&mut tx, sql, supervisor, fleet).await.map_err(failed(WHAT))?;
                let is_shared = matches!(tx, Either::Postgres(_));
                if let Either::Postgres(tx) = &mut tx {
                    forget_the_gone(&mut *tx).await.map_err(failed(WHAT))?;
                }
                tx.commit().await.map_err(failed(WHAT))?;
                Ok((epoch, is_shared))
            })
            .await?;
        Ok(epoch.map(|epoch| Lease::taken(supervisor, fleet, epoch, asked, is_shared)))
    }

    /// Gives a fleet back: it can be had at once.
    ///
    /// # Errors
    /// The database does not answer within the time to live.
    pub async fn release(&mut self, lease: &Lease) -> Result<(), StoreError> {
        const WHAT: &str = "give a fleet back";
        const SQL: &str =
            "UPDATE leases SET owner = NULL, expires_us = 0 WHERE fleet = $1 AND epoch = $2 AND owner = $3";
        self.attempt(WHAT, lease.time_to_live(), async |link| {
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

    /// Says that a supervisor is leaving.
    ///
    /// # Errors
    /// The database does not answer within the time to live.
    pub async fn sign_out(&mut self, supervisor: &Supervisor) -> Result<(), StoreError> {
        const WHAT: &str = "sign out";
        const SQL: &str = "DELETE FROM supervisors WHERE supervisor = $1";
        self.attempt(WHAT, supervisor.time_to_live, async |link| {
            on!(link, |link| sqlx::query(SQL).bind(&*supervisor.id).execute(link).await.map(drop)).map_err(failed(WHAT))
        })
        .await
    }
}

// An epoch is the time at which it began, in milliseconds since 1970, or one more than the epoch before if that is not
// higher. Counted from one, it would begin again where a back-up was taken: a database that is restored would give epochs
// and versions that robots have seen already, of which they refuse the lower ones and take the others for repeats. So it
// is higher than any before, whatever became of the database, as long as no clock was ahead by more than the back-up is old.

/// SQLite's lock is the lease: whoever has the file may have every fleet.
const ACQUIRE_SQLITE: &str = "INSERT INTO leases (fleet, epoch, owner, holder) VALUES ($1, $4, $2, $3) \
    ON CONFLICT (fleet) DO UPDATE SET epoch = max(epoch + 1, excluded.epoch), owner = excluded.owner, \
    holder = excluded.holder, commits = 0 RETURNING epoch";

/// A row that is locked is somebody's who is at work. Our own may have been taken without our hearing of it.
const ACQUIRE_POSTGRES: &str = "UPDATE leases SET epoch = greatest(epoch + 1, clock_us() / 1000), owner = $2, \
    holder = $3, commits = 0, expires_us = clock_us() + $4 WHERE fleet = (SELECT fleet FROM leases WHERE fleet = $1 \
    AND (owner = $2 OR expires_us <= clock_us()) FOR UPDATE SKIP LOCKED) RETURNING epoch";

async fn raise_epoch(
    tx: &mut Tx<'_>,
    sql: &'static str,
    supervisor: &Supervisor,
    fleet: &Name,
) -> sqlx::Result<Option<i64>> {
    let now_us = vibrissa_edge::clock::wall_clock().0 as i64;
    // What each statement has as its fourth value.
    let fourth =
        if matches!(tx, Either::Postgres(_)) { micros(supervisor.time_to_live) } else { (now_us / 1000).max(1) };
    const HISTORY: &str = "INSERT INTO epochs (fleet, epoch, owner, holder, began_us) VALUES ($1, $2, $3, $4, $5)";
    let epoch: Option<i64> = on!(&mut *tx, |tx| sqlx::query_scalar(sql)
        .bind(fleet.as_str())
        .bind(&*supervisor.id)
        .bind(&supervisor.name)
        .bind(fourth)
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

async fn sqlite_roll(link: &mut SqliteConnection, supervisor: &Supervisor) -> sqlx::Result<Roll> {
    let rows = sqlx::query("SELECT fleet, epoch, owner, holder FROM leases").fetch_all(link).await?;
    let leases = supervisor.fleets.iter().map(|fleet| {
        let row = rows.iter().find(|row| row.get::<&str, _>("fleet") == fleet.as_str());
        let owner: Option<String> = row.and_then(|row| row.get("owner"));
        FleetLease {
            fleet: fleet.clone(),
            epoch: row.map_or(0, |row| row.get::<i64, _>("epoch")) as u64,
            free: owner.as_deref() != Some(&*supervisor.id),
            free_in: None,
            owner,
            holder: row.and_then(|row| row.get("holder")),
        }
    });
    // Nobody else could have them: it does not matter how they are heard.
    let (supervisor, fleets) = (supervisor.id.to_string(), supervisor.fleets.clone());
    let present = vec![Present { supervisor, fleets, hearing: FleetsHeard::default() }];
    Ok(Roll { leases: leases.collect(), present })
}

/// The roll, and the fleets whose leases were renewed. A row that a commit of ours has locked is left to it. Each statement
/// stands by itself: it is done several times a second, by everybody.
async fn sign_in(
    link: &mut PgConnection,
    supervisor: &Supervisor,
    held: &[Lease],
    hearing: &FleetsHeard,
) -> sqlx::Result<(Roll, Vec<String>)> {
    let joined = |fleets: &[Name]| fleets.iter().map(Name::as_str).collect::<Vec<_>>().join(",");
    let fleets: Vec<&str> = supervisor.fleets.iter().map(Name::as_str).collect();
    let renewed = sqlx::query_scalar(
        "WITH present AS (INSERT INTO supervisors (supervisor, holder, fleets, alive_us, deaf, heard) \
         VALUES ($2, $5, $6, clock_us() + $1, $7, $8) ON CONFLICT (supervisor) DO UPDATE SET \
         alive_us = excluded.alive_us, deaf = excluded.deaf, heard = excluded.heard) \
         UPDATE leases SET expires_us = clock_us() + $1 WHERE fleet IN (SELECT l.fleet FROM leases l \
         JOIN unnest($3::text[], $4::bigint[]) AS h (fleet, epoch) ON l.fleet = h.fleet AND l.epoch = h.epoch \
         WHERE owner = $2 FOR UPDATE OF l SKIP LOCKED) RETURNING fleet",
    )
    .bind(micros(supervisor.time_to_live))
    .bind(&*supervisor.id)
    .bind(held.iter().map(|lease| lease.fleet().as_str()).collect::<Vec<_>>())
    .bind(held.iter().map(|lease| lease.epoch() as i64).collect::<Vec<_>>())
    .bind(&supervisor.name)
    .bind(fleets.join(","))
    .bind(joined(&hearing.deaf))
    .bind(joined(&hearing.heard))
    .fetch_all(&mut *link)
    .await?;
    let mut rows = rows_of(&mut *link, &fleets).await?;
    if rows.iter().filter(|row| is_lease(row)).count() < fleets.len() {
        sqlx::query(
            "INSERT INTO leases (fleet, epoch, expires_us) SELECT unnest($1::text[]), 0, 0 ON CONFLICT DO NOTHING",
        )
        .bind(&fleets)
        .execute(&mut *link)
        .await?;
        rows = rows_of(&mut *link, &fleets).await?;
    }
    let leases = rows.iter().filter(|row| is_lease(row)).filter_map(|row| {
        Some(FleetLease {
            fleet: Name::new(row.get("fleet")).ok()?,
            epoch: row.get::<i64, _>("epoch") as u64,
            owner: row.get("owner"),
            holder: row.get("holder"),
            free: row.get::<i64, _>("left_us") <= 0,
            free_in: u64::try_from(row.get::<i64, _>("left_us")).ok().map(Duration::from_micros),
        })
    });
    let names = |row: &PgRow, column: &str| {
        row.get::<&str, _>(column).split(',').filter_map(|fleet| Name::new(fleet).ok()).collect::<Vec<_>>()
    };
    let present = rows.iter().filter(|row| !is_lease(row)).map(|row| Present {
        supervisor: row.get("owner"),
        fleets: names(row, "fleets"),
        hearing: FleetsHeard { deaf: names(row, "deaf"), heard: names(row, "heard") },
    });
    Ok((Roll { leases: leases.collect(), present: present.collect() }, renewed))
}

/// Supervisors that were killed long ago: whoever comes again comes under a new name.
async fn forget_the_gone(tx: &mut PgConnection) -> sqlx::Result<()> {
    sqlx::query("DELETE FROM supervisors WHERE alive_us < clock_us() - 86400000000").execute(tx).await.map(drop)
}

/// The leases of fleets, and whoever is there: the rows without a fleet. Asked for in one go, several times a second.
async fn rows_of(link: &mut PgConnection, fleets: &[&str]) -> sqlx::Result<Vec<PgRow>> {
    sqlx::query(
        "SELECT fleet, epoch, owner, holder, expires_us - clock_us() AS left_us, NULL::text AS fleets, \
         NULL::text AS deaf, NULL::text AS heard FROM leases WHERE fleet = ANY($1) \
         UNION ALL SELECT NULL, NULL, supervisor, NULL, NULL, fleets, deaf, heard FROM supervisors \
         WHERE alive_us > clock_us()",
    )
    .bind(fleets)
    .fetch_all(link)
    .await
}

fn is_lease(row: &PgRow) -> bool {
    row.get::<Option<&str>, _>("fleet").is_some()
}
