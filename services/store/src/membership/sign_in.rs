//! How a supervisor signs in to PostgreSQL, which several supervisors share.

use std::time::Duration;

use sqlx::postgres::PgRow;
use sqlx::{PgConnection, Row};
use tokio::time::Instant;
use vibrissa_edge::clock::wall_clock;
use vibrissa_protocol::Name;

use super::{ClockReport, FleetLease, FleetsHeard, Membership, Present, Supervisor};
use crate::Lease;
use crate::lease::micros;
use crate::lease_watch::{LeaseWatch, Reading, Renewal};

/// An answer of the database that took longer says too little about its clock.
const ANSWER_MAX: Duration = Duration::from_millis(500);

/// Registers the supervisor and renews its leases; returns the state of the cluster and the renewed fleets. A row
/// that is locked by a commit of this supervisor is skipped, because the commit renews it. Each statement is its own
/// transaction, because all supervisors do this several times a second.
pub(super) async fn sign_in(
    link: &mut PgConnection,
    supervisor: &Supervisor,
    held: &[Lease],
    (hearing, clock): (&FleetsHeard, ClockReport),
    watch: &mut LeaseWatch,
) -> sqlx::Result<(Membership, Vec<String>)> {
    let joined = |fleets: &[Name]| fleets.iter().map(Name::as_str).collect::<Vec<_>>().join(",");
    let fleets: Vec<&str> = supervisor.fleets.iter().map(Name::as_str).collect();
    let renewed = sqlx::query_scalar(
        "WITH present AS (INSERT INTO supervisors (supervisor, holder, fleets, alive_us, deaf, heard, \
         time_to_live_us, clock_ahead_us, robots_ahead_us, clock_wrong) \
         VALUES ($2, $5, $6, clock_us() + $1, $7, $8, $1, $9, $10, $11) ON CONFLICT (supervisor) DO UPDATE SET \
         alive_us = excluded.alive_us, deaf = excluded.deaf, heard = excluded.heard, \
         clock_ahead_us = excluded.clock_ahead_us, robots_ahead_us = excluded.robots_ahead_us, \
         clock_wrong = excluded.clock_wrong) \
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
    .bind(clock.ahead_us)
    .bind(clock.robots_ahead_us)
    .bind(clock.is_wrong)
    .fetch_all(&mut *link)
    .await?;
    let (mut rows, mut ahead_us) = rows_of(&mut *link, &fleets).await?;
    let has_lease = |fleet: &&str| rows.iter().any(|row| row.get::<Option<&str>, _>("fleet") == Some(*fleet));
    if !fleets.iter().all(has_lease) {
        sqlx::query(
            "INSERT INTO leases (fleet, epoch, expires_us) SELECT f.fleet, 0, 0 FROM unnest($1::text[]) AS f (fleet) \
             ON CONFLICT DO NOTHING",
        )
        .bind(&fleets)
        .execute(&mut *link)
        .await?;
        (rows, ahead_us) = rows_of(&mut *link, &fleets).await?;
    }
    Ok((membership(&rows, ahead_us, supervisor, watch), renewed))
}

/// The membership, of rows that were read just now.
fn membership(
    rows: &[PgRow],
    database_ahead_us: Option<i64>,
    supervisor: &Supervisor,
    watch: &mut LeaseWatch,
) -> Membership {
    let now = Instant::now();
    let members = || rows.iter().filter(|row| !is_lease(row));
    let time_to_live = |owner: Option<&str>| {
        let row = members().find(|row| row.get::<Option<&str>, _>("owner") == owner);
        let stored_us = row.map_or(0, |row| row.get::<i64, _>("time_to_live_us"));
        if stored_us > 0 { Duration::from_micros(stored_us as u64) } else { supervisor.time_to_live }
    };
    let leases = rows.iter().filter(|row| is_lease(row)).filter_map(|row| {
        let fleet = Name::new(row.get("fleet")).ok()?;
        let renewal =
            Renewal { epoch: row.get("epoch"), commits: row.get("commits"), expires_us: row.get("expires_us") };
        let left_us = row.get("left_us");
        let reading = Reading { renewal, left_us, time_to_live: time_to_live(row.get("owner")) };
        let free_in = watch.lease(&fleet, &reading, now);
        Some(FleetLease {
            fleet,
            epoch: row.get::<i64, _>("epoch") as u64,
            owner: row.get("owner"),
            holder: row.get("holder"),
            free: free_in.is_zero(),
            free_in: Some(free_in).filter(|free_in| !free_in.is_zero()),
        })
    });
    let leases = leases.collect();
    let names = |row: &PgRow, column: &str| {
        row.get::<&str, _>(column).split(',').filter_map(|fleet| Name::new(fleet).ok()).collect::<Vec<_>>()
    };
    watch.retain_members(|member| members().any(|row| row.get::<Option<&str>, _>("owner") == Some(member)));
    let present = members().filter(|row| {
        let id: &str = row.get("owner");
        let time_to_live = time_to_live(Some(id));
        let reading = Reading { renewal: row.get("expires_us"), left_us: row.get("left_us"), time_to_live };
        id == &*supervisor.id || watch.is_alive(id, &reading, now)
    });
    let present = present.map(|row| Present {
        supervisor: row.get("owner"),
        fleets: names(row, "fleets"),
        hearing: FleetsHeard { deaf: names(row, "deaf"), heard: names(row, "heard") },
        clock: ClockReport {
            ahead_us: row.get("clock_ahead_us"),
            robots_ahead_us: row.get("robots_ahead_us"),
            is_wrong: row.get("clock_wrong"),
        },
    });
    let present = present.collect();
    Membership { leases, present, database_ahead_us }
}

/// Deletes supervisors that ended without signing out a day ago or more; each start has a new identifier.
pub(super) async fn forget_the_gone(tx: &mut PgConnection) -> sqlx::Result<()> {
    sqlx::query("DELETE FROM supervisors WHERE alive_us < clock_us() - 86400000000").execute(tx).await.map(drop)
}

/// Rows of leases, and of present supervisors, whose `fleet` is null, in one query, because it runs several times a
/// second. Also how far the database's clock is ahead of this process's, in µs.
async fn rows_of(link: &mut PgConnection, fleets: &[&str]) -> sqlx::Result<(Vec<PgRow>, Option<i64>)> {
    let (asked, asked_us) = (Instant::now(), wall_clock().0 as i64);
    let rows = sqlx::query(
        "SELECT fleet, epoch, owner, holder, commits, expires_us, \
         expires_us - clock_us() AS left_us, clock_us() AS database_us, \
         NULL::text AS fleets, NULL::text AS deaf, NULL::text AS heard, NULL::bigint AS time_to_live_us, \
         NULL::bigint AS clock_ahead_us, NULL::bigint AS robots_ahead_us, NULL::boolean AS clock_wrong \
         FROM leases WHERE fleet = ANY($1) \
         UNION ALL SELECT NULL, NULL, supervisor, NULL, NULL, alive_us, alive_us - clock_us(), \
         clock_us(), fleets, deaf, heard, time_to_live_us, clock_ahead_us, robots_ahead_us, clock_wrong \
         FROM supervisors WHERE alive_us > clock_us()",
    )
    .bind(fleets)
    .fetch_all(link)
    .await?;
    let took = asked.elapsed();
    let ahead_us = rows.first().filter(|_| took <= ANSWER_MAX).map(|row| {
        // The database read its clock at some time between question and answer.
        row.get::<i64, _>("database_us") - asked_us - took.as_micros() as i64 / 2
    });
    Ok((rows, ahead_us))
}

fn is_lease(row: &PgRow) -> bool {
    row.get::<Option<&str>, _>("fleet").is_some()
}
