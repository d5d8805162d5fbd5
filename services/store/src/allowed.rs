//! Allow lists of robots that people have set, and the robots turned away.

use tokio::time::Duration;
use vibrissa_protocol::Name;

use super::actions::{Asked, NewAction, record_done};
use super::database::on;
use super::readings::readings;
use super::{Lease, Store, StoreError, Writer, failed};

/// How long reading or writing of an engine may take.
const PATIENCE: Duration = Duration::from_secs(5);
/// Versions of a fleet's list to keep.
const VERSIONS_KEPT: i64 = 20;

readings! {
    /// The list in force of a fleet.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct AllowedReading {
        /// Number, from 1.
        pub version: i64,
        /// Names, one on each line; none if everybody is allowed.
        pub robots: Option<String>,
        /// When this version was set, in microseconds since 1970 UTC.
        pub changed_us: i64,
        /// The actor who set it, as the audit log names them.
        pub changed_by: String,
        /// The reason that they gave.
        pub reason: Option<String>,
    }

    /// A robot that is not allowed, and has tried.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct TurnedAwayReading {
        /// The robot's name.
        pub robot: String,
        /// Messages of it.
        pub tries: i64,
        /// When it tried first.
        pub first_us: i64,
        /// When it tried last.
        pub last_us: i64,
    }
}

/// The names in a stored list.
pub fn names_of(robots: &str) -> impl Iterator<Item = Name> {
    robots.lines().filter_map(|line| Name::robot(line).ok())
}

const NEWEST: &str = "SELECT version, robots, changed_us, changed_by, reason FROM allowed_robots \
     WHERE fleet = $1 AND version > $2 ORDER BY version DESC LIMIT 1";

impl Store {
    /// The list in force of a fleet; none if there never was one.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn allowed_robots(&self, fleet: &str) -> Result<Option<AllowedReading>, StoreError> {
        on!(&self.pool, |pool| sqlx::query_as(NEWEST).bind(fleet).bind(0_i64).fetch_optional(pool).await)
            .map_err(failed("read which robots are allowed"))
    }

    /// The robots turned away, the last to try first.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn turned_away(&self, fleet: &str) -> Result<Vec<TurnedAwayReading>, StoreError> {
        const SQL: &str =
            "SELECT robot, tries, first_us, last_us FROM turned_away WHERE fleet = $1 ORDER BY last_us DESC, robot";
        on!(&self.pool, |pool| sqlx::query_as(SQL).bind(fleet).fetch_all(pool).await)
            .map_err(failed("read who was turned away"))
    }

    /// Sets another list, in place of the version that was read, with its entry in the audit log; none if another one is in
    /// force meanwhile.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn set_allowed_robots(
        &self,
        fleet: &str,
        version_before: i64,
        robots: Option<&str>,
        action: &NewAction,
    ) -> Result<Option<Asked>, StoreError> {
        const WHAT: &str = "set which robots are allowed";
        const INSERT: &str = "INSERT INTO allowed_robots (fleet, version, robots, changed_us, changed_by, reason, action_id) \
             SELECT $1, $2 + 1, $3, $4, $5, $6, $7 \
             WHERE (SELECT coalesce(max(version), 0) FROM allowed_robots WHERE fleet = $1) = $2 ON CONFLICT DO NOTHING";
        const FORGET: &str = "DELETE FROM allowed_robots WHERE fleet = $1 AND version <= $2";
        let mut tx = self.pool.begin().await.map_err(failed(WHAT))?;
        let asked = record_done(&mut tx, action, action.asked_us).await?;
        if let Asked::New(action_id) = asked {
            let written = on!(&mut tx, |tx| sqlx::query(INSERT)
                .bind(fleet)
                .bind(version_before)
                .bind(robots)
                .bind(action.asked_us)
                .bind(&action.actor)
                .bind(&action.reason)
                .bind(action_id)
                .execute(&mut **tx)
                .await
                .map(|done| done.rows_affected()))
            .map_err(failed(WHAT))?;
            if written == 0 {
                tx.rollback().await.map_err(failed(WHAT))?;
                return Ok(None);
            }
            on!(&mut tx, |tx| sqlx::query(FORGET)
                .bind(fleet)
                .bind(version_before + 1 - VERSIONS_KEPT)
                .execute(&mut **tx)
                .await
                .map(drop))
            .map_err(failed(WHAT))?;
        }
        tx.commit().await.map_err(failed(WHAT))?;
        Ok(Some(asked))
    }
}

impl Writer {
    /// The list in force of the lease's fleet, if it is newer than that version.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn allowed_robots(&mut self, lease: &Lease, after: i64) -> Result<Option<AllowedReading>, StoreError> {
        const WHAT: &str = "read which robots are allowed";
        let fleet = lease.fleet().as_str();
        self.attempt(WHAT, PATIENCE, async |link| {
            on!(link, |link| sqlx::query_as(NEWEST).bind(fleet).bind(after).fetch_optional(link).await)
                .map_err(failed(WHAT))
        })
        .await
    }

    /// Writes who was turned away, in place of those who are there.
    ///
    /// # Errors
    /// The database cannot be written, or the fleet is not ours any more.
    pub async fn write_turned_away(&mut self, lease: &Lease, rows: &[TurnedAwayReading]) -> Result<(), StoreError> {
        const WHAT: &str = "write who was turned away";
        const INSERT: &str =
            "INSERT INTO turned_away (fleet, robot, tries, first_us, last_us) VALUES ($1, $2, $3, $4, $5)";
        let fleet = lease.fleet().as_str();
        self.attempt(WHAT, PATIENCE, async |link| {
            let mut tx = link.begin().await.map_err(failed(WHAT))?;
            lease.hold(&mut tx).await?;
            on!(&mut tx, |tx| sqlx::query("DELETE FROM turned_away WHERE fleet = $1")
                .bind(fleet)
                .execute(&mut **tx)
                .await
                .map(drop))
            .map_err(failed(WHAT))?;
            for row in rows {
                on!(&mut tx, |tx| sqlx::query(INSERT)
                    .bind(fleet)
                    .bind(&row.robot)
                    .bind(row.tries)
                    .bind(row.first_us)
                    .bind(row.last_us)
                    .execute(&mut **tx)
                    .await
                    .map(drop))
                .map_err(failed(WHAT))?;
            }
            tx.commit().await.map_err(failed(WHAT))
        })
        .await
    }
}
