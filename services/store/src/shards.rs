//! Division of a fleet into shards, and changes of their number.
//!
//! All rows of a fleet in `leases` have the same number of shards. It changes in one transaction, under the leases of all its
//! shards, after checkpoints of all robots were written: robots then continue from these, and the old shards' journals end.

use std::time::Duration;

use serde::Serialize;
use utoipa::ToSchema;

use super::actions::{Asked, NewAction, record_done};
use super::database::{Either, Tx, on};
use super::fault::{self, Fault};
use super::from_row::from_row;
use super::tables::{ROBOT_HASHES, RobotHash};
use super::time::Time;
use super::{Lease, Store, StoreError, Writer, failed};
use vibrissa_edge::shard::robot_hash;
use vibrissa_protocol::Name;

/// Time limit for a change of the number of shards.
const PATIENCE: Duration = Duration::from_secs(60);
/// Robots without a hash that are read at a time.
const ROBOTS_AT_A_TIME: i64 = 5000;

/// SQL condition that a robot, a row of `robots` under the given alias, belongs to a shard. The parameters are the shard's
/// number and the number of shards. Robots without a hash are in fleets with one shard.
macro_rules! of_shard {
    ($robot:literal, $number:literal, $count:literal) => {
        concat!("coalesce(", $robot, ".shard_hash, 0) % CAST(", $count, " AS BIGINT) = CAST(", $number, " AS BIGINT)")
    };
}
pub(super) use of_shard;

/// Why the number of shards did not change.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum NotDivided {
    /// Some rows of the fleet could not be written.
    #[error("the database rejects rows of some robots, which are in quarantine")]
    NotDrained,
    /// A roll-out compares robots of the whole fleet.
    #[error("a staged roll-out is open: complete it or roll it back first")]
    RolloutOpen,
    /// A shard has not executed an action on the whole fleet yet.
    #[error("a shard has not executed a change of the policy or of a calibration yet: ask again in a minute")]
    ActionPending,
}

from_row! {
    /// A robot without a hash.
    struct Unhashed {
        robot_id: i64,
        robot: String,
    }
}

from_row! {
    /// A shard of a fleet, with the supervisor that owns it.
    #[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
    pub struct ShardSummary {
        /// Number of the shard, from 0.
        #[schema(minimum = 0)]
        pub shard: i64,
        /// Name of the supervisor that holds the shard's lease now; null if none does.
        pub holder: Option<String>,
        /// Epoch of the shard's newest owner; 0 before the first.
        #[schema(minimum = 0)]
        pub epoch: i64,
        /// Whether a supervisor holds the shard's lease now.
        pub supervised: bool,
        /// Time at which this epoch began, by the database's clock; null before the first.
        pub began_at: Option<Time>,
        /// Number of robots of the shard, without decommissioned ones.
        #[schema(minimum = 0)]
        pub robots: i64,
        /// Number of shards that the fleet shall have; it differs from the present number during a change.
        #[schema(minimum = 1)]
        pub shards_wanted: i64,
    }
}

/// Result of a request for another number of shards.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ShardsSet {
    /// Stated, now or by the same request before: the supervisors change it within seconds.
    Done(Box<Asked>),
    /// No supervisor has ever supervised such a fleet.
    NoFleet,
    /// It must not change now.
    Refused(NotDivided),
}

impl Store {
    /// The shards of a fleet in order of their numbers; none if the fleet was never supervised.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn shards(&self, fleet: &Name) -> Result<Vec<ShardSummary>, StoreError> {
        let holds = match self.is_shared() {
            true => "l.owner IS NOT NULL AND l.expires_us > clock_us()",
            false => "l.owner IS NOT NULL",
        };
        let sql = format!(
            "SELECT l.shard, CASE WHEN {holds} THEN l.holder END AS holder, l.epoch, ({holds}) AS supervised, \
             e.began_us AS began_at, coalesce(r.robots, 0) AS robots, l.shards_wanted FROM leases l \
             LEFT JOIN epochs e ON e.fleet = l.fleet AND e.shard = l.shard AND e.epoch = l.epoch \
             LEFT JOIN (SELECT coalesce(shard_hash, 0) % nullif((SELECT count(*) FROM leases WHERE fleet = $1), 0) AS shard, \
              count(*) AS robots FROM robots WHERE fleet = $1 AND decommissioned_us IS NULL GROUP BY 1) r ON r.shard = l.shard \
             WHERE l.fleet = $1 ORDER BY l.shard"
        );
        on!(&self.pool, |pool| sqlx::query_as(sqlx::AssertSqlSafe(sql)).bind(fleet.as_str()).fetch_all(pool).await)
            .map_err(failed("list the shards of a fleet"))
    }

    /// States the number of shards that a fleet shall have, more or fewer than now, at most once, and records the action in
    /// the audit log. The supervisors then change it.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn set_shards(&self, fleet: &Name, count: u32, action: &NewAction) -> Result<ShardsSet, StoreError> {
        const WHAT: &str = "state the number of shards";
        const UPDATE: &str = "UPDATE leases SET shards_wanted = $2 WHERE fleet = $1";
        let mut tx = self.pool.begin().await.map_err(failed(WHAT))?;
        let asked = record_done(&mut tx, action, action.asked_us).await?;
        if !matches!(asked, Asked::New(_)) {
            return Ok(ShardsSet::Done(Box::new(asked)));
        }
        if let Some(reason) = undividable(&mut tx, fleet.as_str()).await.map_err(failed(WHAT))? {
            return Ok(ShardsSet::Refused(reason));
        }
        let changed = on!(&mut tx, |tx| sqlx::query(UPDATE)
            .bind(fleet.as_str())
            .bind(i64::from(count))
            .execute(&mut **tx)
            .await
            .map(|done| done.rows_affected()))
        .map_err(failed(WHAT))?;
        if changed == 0 {
            return Ok(ShardsSet::NoFleet);
        }
        tx.commit().await.map_err(failed(WHAT))?;
        Ok(ShardsSet::Done(Box::new(asked)))
    }
}

impl Writer {
    /// States the number of shards that a fleet shall have at least. Owners give the fleet up when it differs from the
    /// present number, and one of them changes it with [`Self::divide`].
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn want_shards(&mut self, fleet: &Name, least: u32) -> Result<(), StoreError> {
        const WHAT: &str = "state the number of shards";
        const INSERT: &str = "INSERT INTO leases (fleet, epoch, expires_us) SELECT CAST($1 AS TEXT), 0, 0 \
             WHERE NOT EXISTS (SELECT 1 FROM leases WHERE fleet = $1) ON CONFLICT DO NOTHING";
        const UPDATE: &str = "UPDATE leases SET shards_wanted = $2 WHERE fleet = $1 AND shards_wanted < $2";
        self.attempt(WHAT, PATIENCE, async |link| {
            let mut tx = link.begin().await.map_err(failed(WHAT))?;
            on!(&mut tx, |tx| sqlx::query(INSERT).bind(fleet.as_str()).execute(&mut **tx).await.map(drop))
                .map_err(failed(WHAT))?;
            on!(&mut tx, |tx| sqlx::query(UPDATE)
                .bind(fleet.as_str())
                .bind(i64::from(least))
                .execute(&mut **tx)
                .await
                .map(drop))
            .map_err(failed(WHAT))?;
            tx.commit().await.map_err(failed(WHAT))
        })
        .await
    }

    /// Gives up a change of a fleet's number of shards.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn keep_shards(&mut self, fleet: &Name) -> Result<(), StoreError> {
        const WHAT: &str = "keep the number of shards";
        const SQL: &str = "UPDATE leases SET shards_wanted = shards WHERE fleet = $1";
        self.attempt(WHAT, PATIENCE, async |link| {
            on!(link, |link| sqlx::query(SQL).bind(fleet.as_str()).execute(link).await.map(drop)).map_err(failed(WHAT))
        })
        .await
    }

    /// Changes the number of a fleet's shards, under the leases of all of them, which end by it. Checkpoints of all robots
    /// must have been written under these leases. The new shards begin with epochs above those of the old ones. Returns the
    /// reason if it must not change now.
    ///
    /// # Errors
    /// The database cannot be written, or a lease is lost.
    pub async fn divide(&mut self, held: &[Lease], count: u32) -> Result<Result<(), NotDivided>, StoreError> {
        const WHAT: &str = "change the number of shards";
        let Some(first) = held.first() else { return Ok(Ok(())) };
        self.attempt(WHAT, PATIENCE, async |link| {
            let mut tx = link.begin().await.map_err(failed(WHAT))?;
            for lease in held {
                lease.hold(&mut tx).await?;
            }
            let fleet = first.fleet().as_str();
            if let Some(reason) = undividable(&mut tx, fleet).await.map_err(failed(WHAT))? {
                return Ok(Err(reason));
            }
            hash_robots(&mut tx, fleet).await.map_err(failed(WHAT))?;
            write_leases(&mut tx, fleet, count).await.map_err(failed(WHAT))?;
            fault::strike(Fault::DivisionCut);
            tx.commit().await.map_err(failed(WHAT))?;
            fault::strike(Fault::DivisionDone);
            Ok(Ok(()))
        })
        .await
    }
}

/// Kinds of actions on a whole fleet whose effects reach all its robots.
const OF_ALL_SHARDS: [&str; 2] = ["POLICY", "CALIBRATION"];
/// Time for which the action of a shard waits for the shard's owner, beyond the expiry of the fleet's action, µs: a year.
pub(super) const SHARD_WAITS_US: i64 = 365 * 86_400 * 1_000_000;

/// Adds the actions of a fleet's other shards to an action on the whole fleet. Holds the first lease's row, so that the number
/// of shards does not change meanwhile.
pub(super) async fn ask_shards(tx: &mut Tx<'_>, action_id: i64, action: &NewAction) -> sqlx::Result<()> {
    const INSERT: &str = "INSERT INTO actions (fleet, kind, parameters, reason, actor, role, request_id, asked_us, expires_us, \
         state, parent_id, not_before_us, shard) SELECT fleet, kind, parameters, reason, actor, role, request_id, asked_us, \
         expires_us + $2, state, action_id, not_before_us, $3 FROM actions WHERE action_id = $1";
    let Some(fleet) = &action.fleet else { return Ok(()) };
    if action.robot.is_some() || !OF_ALL_SHARDS.contains(&action.kind.as_str()) {
        return Ok(());
    }
    let sql = match tx {
        Either::Sqlite(_) => "SELECT shards FROM leases WHERE fleet = $1 AND shard = 0",
        Either::Postgres(_) => "SELECT shards FROM leases WHERE fleet = $1 AND shard = 0 FOR SHARE",
    };
    let count: Option<i64> = on!(&mut *tx, |tx| sqlx::query_scalar(sql).bind(fleet).fetch_optional(&mut **tx).await)?;
    for shard in 1..count.unwrap_or(1) {
        on!(&mut *tx, |tx| sqlx::query(INSERT)
            .bind(action_id)
            .bind(SHARD_WAITS_US)
            .bind(shard)
            .execute(&mut **tx)
            .await
            .map(drop))?;
    }
    Ok(())
}

async fn undividable(tx: &mut Tx<'_>, fleet: &str) -> sqlx::Result<Option<NotDivided>> {
    const ACTIONS: &str = "SELECT count(*) FROM actions WHERE fleet = $1 AND state = 'PENDING' AND shard IS NOT NULL";
    const ROLLOUTS: &str = "SELECT count(*) FROM rollouts WHERE fleet = $1 AND state IN ('RUNNING', 'PAUSED')";
    let count = async |tx: &mut Tx<'_>, sql: &'static str| -> sqlx::Result<i64> {
        on!(tx, |tx| sqlx::query_scalar(sql).bind(fleet).fetch_one(&mut **tx).await)
    };
    if count(tx, ACTIONS).await? > 0 {
        return Ok(Some(NotDivided::ActionPending));
    }
    Ok((count(tx, ROLLOUTS).await? > 0).then_some(NotDivided::RolloutOpen))
}

/// Writes the hashes of robots from before there were shards.
async fn hash_robots(tx: &mut Tx<'_>, fleet: &str) -> sqlx::Result<()> {
    let sql =
        format!("SELECT robot_id, robot FROM robots WHERE fleet = $1 AND shard_hash IS NULL LIMIT {ROBOTS_AT_A_TIME}");
    loop {
        let sql = sqlx::AssertSqlSafe(sql.clone());
        let robots: Vec<Unhashed> = on!(&mut *tx, |tx| sqlx::query_as(sql).bind(fleet).fetch_all(&mut **tx).await)?;
        if robots.is_empty() {
            return Ok(());
        }
        let hash =
            |one: &Unhashed| RobotHash { robot_id: one.robot_id, shard_hash: i64::from(robot_hash(fleet, &one.robot)) };
        let rows: Vec<RobotHash> = robots.iter().map(hash).collect();
        ROBOT_HASHES.write(tx, &rows).await?;
    }
}

/// Ends the journals, and replaces the fleet's leases by free ones of `count` shards.
async fn write_leases(tx: &mut Tx<'_>, fleet: &str, count: u32) -> sqlx::Result<()> {
    const NEWEST: &str = "SELECT max(epoch) FROM leases WHERE fleet = $1";
    const JOURNAL: &str = "DELETE FROM journal WHERE fleet = $1";
    const DELETE: &str = "DELETE FROM leases WHERE fleet = $1";
    const INSERT: &str = "INSERT INTO leases (fleet, shard, shards, shards_wanted, epoch, expires_us) \
         VALUES ($1, $2, $3, $3, $4, 0)";
    let epoch: i64 = on!(&mut *tx, |tx| sqlx::query_scalar(NEWEST).bind(fleet).fetch_one(&mut **tx).await)?;
    on!(&mut *tx, |tx| sqlx::query(JOURNAL).bind(fleet).execute(&mut **tx).await.map(drop))?;
    on!(&mut *tx, |tx| sqlx::query(DELETE).bind(fleet).execute(&mut **tx).await.map(drop))?;
    for number in 0..count {
        on!(&mut *tx, |tx| sqlx::query(INSERT)
            .bind(fleet)
            .bind(i64::from(number))
            .bind(i64::from(count))
            .bind(epoch)
            .execute(&mut **tx)
            .await
            .map(drop))?;
    }
    Ok(())
}
