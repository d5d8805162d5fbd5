//! How a supervisor signs in to a database that several supervisors share.

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

/// What a shared database answers to a supervisor that signs in.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SignedIn {
    /// Leases of the supervisor's fleets.
    pub leases: Vec<LeaseRow>,
    /// Supervisors whose sign-in has not expired by the database's clock.
    pub members: Vec<MemberRow>,
    /// The database's clock, µs since 1970 UTC.
    pub database_us: i64,
    /// Fleets whose leases were renewed.
    pub renewed: Vec<String>,
}

/// The row of a lease.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LeaseRow {
    /// Name of the fleet.
    pub fleet: String,
    /// Identifier of the owner; `None` if it was released or never acquired.
    pub owner: Option<String>,
    /// Name of the owner for people.
    pub holder: Option<String>,
    /// The columns that change with each renewal.
    pub renewal: Renewal,
}

/// The row of a supervisor.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MemberRow {
    /// Identifier of its process.
    pub supervisor: String,
    /// Time until which it is present, µs since 1970 UTC by the database's clock.
    pub alive_us: i64,
    /// Time to live of its leases, µs; 0 if it states none.
    pub time_to_live_us: i64,
    /// Names of its fleets, with commas between them.
    pub fleets: String,
    /// Names of the fleets that it does not hear, with commas between them.
    pub deaf: String,
    /// Names of the fleets that it hears without owning them, with commas between them.
    pub heard: String,
    /// Its report on its clock.
    pub clock: ClockReport,
}

impl MemberRow {
    /// The row of a supervisor that signs in at a time by the database's clock.
    #[must_use]
    pub fn new(supervisor: &Supervisor, hearing: &FleetsHeard, clock: ClockReport, database_us: i64) -> Self {
        let joined = |fleets: &[Name]| fleets.iter().map(Name::as_str).collect::<Vec<_>>().join(",");
        let time_to_live_us = micros(supervisor.time_to_live);
        Self {
            supervisor: supervisor.id.to_string(),
            alive_us: database_us + time_to_live_us,
            time_to_live_us,
            fleets: joined(&supervisor.fleets),
            deaf: joined(&hearing.deaf),
            heard: joined(&hearing.heard),
            clock,
        }
    }
}

/// The time of a question to the database.
#[derive(Debug, Clone, Copy)]
pub(super) struct Question {
    pub(super) asked: Instant,
    /// The same by this process's wall clock, µs since 1970 UTC.
    asked_us: i64,
}

impl Question {
    pub(super) fn now() -> Self {
        Self { asked: Instant::now(), asked_us: wall_clock().0 as i64 }
    }

    /// How far the database's clock is ahead of this process's, in µs, by an answer that came just now. The database read
    /// its clock at some time between question and answer.
    fn ahead_us(&self, database_us: i64) -> Option<i64> {
        let took = self.asked.elapsed();
        (took <= ANSWER_MAX).then(|| database_us - self.asked_us - took.as_micros() as i64 / 2)
    }
}

/// The answer of either database.
pub(super) enum Answer {
    /// No other supervisor uses it.
    Alone(Membership),
    /// Rows, and the time of the question for them.
    Shared(SignedIn, Question),
}

/// Registers the supervisor and renews its leases; returns the state of the cluster and the renewed fleets. A row
/// that is locked by a commit of this supervisor is skipped, because the commit renews it. Each statement is its own
/// transaction, because all supervisors do this several times a second.
pub(super) async fn sign_in(
    link: &mut PgConnection,
    supervisor: &Supervisor,
    held: &[Lease],
    (hearing, clock): (&FleetsHeard, ClockReport),
) -> sqlx::Result<Answer> {
    // The database adds its own time.
    let row = MemberRow::new(supervisor, hearing, clock, 0);
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
    .bind(row.time_to_live_us)
    .bind(&*supervisor.id)
    .bind(held.iter().map(|lease| lease.fleet().as_str()).collect::<Vec<_>>())
    .bind(held.iter().map(|lease| lease.epoch() as i64).collect::<Vec<_>>())
    .bind(&supervisor.name)
    .bind(row.fleets)
    .bind(row.deaf)
    .bind(row.heard)
    .bind(clock.ahead_us)
    .bind(clock.robots_ahead_us)
    .bind(clock.is_wrong)
    .fetch_all(&mut *link)
    .await?;
    let (mut signed_in, mut question) = rows_of(&mut *link, &fleets).await?;
    if signed_in.leases.len() < fleets.len() {
        sqlx::query(
            "INSERT INTO leases (fleet, epoch, expires_us) SELECT f.fleet, 0, 0 FROM unnest($1::text[]) AS f (fleet) \
             ON CONFLICT DO NOTHING",
        )
        .bind(&fleets)
        .execute(&mut *link)
        .await?;
        (signed_in, question) = rows_of(&mut *link, &fleets).await?;
    }
    Ok(Answer::Shared(SignedIn { renewed, ..signed_in }, question))
}

/// The membership, of rows that were read just now.
pub(super) fn membership(
    rows: SignedIn,
    question: Question,
    supervisor: &Supervisor,
    watch: &mut LeaseWatch,
) -> Membership {
    let SignedIn { leases, members, database_us, .. } = rows;
    let (now, is_known) = (Instant::now(), !(leases.is_empty() && members.is_empty()));
    let time_to_live = |owner: Option<&str>| {
        let row = members.iter().find(|row| Some(row.supervisor.as_str()) == owner);
        let stated = row.map_or(0, |row| row.time_to_live_us);
        if stated > 0 { Duration::from_micros(stated as u64) } else { supervisor.time_to_live }
    };
    let leases = leases.into_iter().filter_map(|row| {
        let fleet = Name::new(&row.fleet).ok()?;
        let left_us = row.renewal.expires_us - database_us;
        let reading = Reading { renewal: row.renewal, left_us, time_to_live: time_to_live(row.owner.as_deref()) };
        let free_in = watch.lease(&fleet, &reading, now);
        Some(FleetLease {
            fleet,
            epoch: row.renewal.epoch as u64,
            owner: row.owner,
            holder: row.holder,
            free: free_in.is_zero(),
            free_in: Some(free_in).filter(|free_in| !free_in.is_zero()),
        })
    });
    let leases = leases.collect();
    let names = |list: &str| list.split(',').filter_map(|fleet| Name::new(fleet).ok()).collect::<Vec<_>>();
    watch.retain_members(|member| members.iter().any(|row| row.supervisor == member));
    let present = members.iter().filter(|row| {
        let (id, left_us) = (row.supervisor.as_str(), row.alive_us - database_us);
        let reading = Reading { renewal: row.alive_us, left_us, time_to_live: time_to_live(Some(id)) };
        id == &*supervisor.id || watch.is_alive(id, &reading, now)
    });
    let present = present.map(|row| Present {
        supervisor: row.supervisor.clone(),
        fleets: names(&row.fleets),
        hearing: FleetsHeard { deaf: names(&row.deaf), heard: names(&row.heard) },
        clock: row.clock,
    });
    let present = present.collect();
    Membership { leases, present, database_ahead_us: question.ahead_us(database_us).filter(|_| is_known) }
}

/// Deletes supervisors that ended without signing out a day ago or more; each start has a new identifier.
pub(super) async fn forget_the_gone(tx: &mut PgConnection) -> sqlx::Result<()> {
    sqlx::query("DELETE FROM supervisors WHERE alive_us < clock_us() - 86400000000").execute(tx).await.map(drop)
}

/// Rows of leases, and of present supervisors, whose `fleet` is null, in one query, because it runs several times a
/// second.
async fn rows_of(link: &mut PgConnection, fleets: &[&str]) -> sqlx::Result<(SignedIn, Question)> {
    let question = Question::now();
    let rows = sqlx::query(
        "SELECT fleet, epoch, owner, holder, commits, expires_us, clock_us() AS database_us, \
         NULL::text AS fleets, NULL::text AS deaf, NULL::text AS heard, NULL::bigint AS time_to_live_us, \
         NULL::bigint AS clock_ahead_us, NULL::bigint AS robots_ahead_us, NULL::boolean AS clock_wrong \
         FROM leases WHERE fleet = ANY($1) \
         UNION ALL SELECT NULL, NULL, supervisor, NULL, NULL, alive_us, \
         clock_us(), fleets, deaf, heard, time_to_live_us, clock_ahead_us, robots_ahead_us, clock_wrong \
         FROM supervisors WHERE alive_us > clock_us()",
    )
    .bind(fleets)
    .fetch_all(link)
    .await?;
    let mut read = SignedIn {
        leases: Vec::new(),
        members: Vec::new(),
        database_us: rows.first().map_or(0, |row| row.get("database_us")),
        renewed: Vec::new(),
    };
    for row in &rows {
        match row.get::<Option<String>, _>("fleet") {
            Some(fleet) => read.leases.push(lease_row(fleet, row)),
            None => read.members.push(member_row(row)),
        }
    }
    Ok((read, question))
}

fn lease_row(fleet: String, row: &PgRow) -> LeaseRow {
    let renewal = Renewal { epoch: row.get("epoch"), commits: row.get("commits"), expires_us: row.get("expires_us") };
    LeaseRow { fleet, owner: row.get("owner"), holder: row.get("holder"), renewal }
}

fn member_row(row: &PgRow) -> MemberRow {
    MemberRow {
        supervisor: row.get("owner"),
        alive_us: row.get("expires_us"),
        time_to_live_us: row.get("time_to_live_us"),
        fleets: row.get("fleets"),
        deaf: row.get("deaf"),
        heard: row.get("heard"),
        clock: ClockReport {
            ahead_us: row.get("clock_ahead_us"),
            robots_ahead_us: row.get("robots_ahead_us"),
            is_wrong: row.get("clock_wrong"),
        },
    }
}
