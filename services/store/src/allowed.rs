//! Lists of allowed robots that operators have set, and the robots that were turned away.

use sqlx::{ColumnIndex, Decode, FromRow, Row, Type};
use tokio::time::Duration;
use vibrissa_protocol::Name;

use super::actions::{Asked, NewAction, record_done};
use super::database::on;
use super::from_row::from_row;
use super::set_aside::{SetAside, Tried};
use super::{Lease, Model, Store, StoreError, Writer, failed};

/// Time limit for a query or transaction of an engine.
const PATIENCE: Duration = Duration::from_secs(5);
/// Number of versions of a fleet's list that are stored.
const VERSIONS_KEPT: i64 = 20;

from_row! {
    /// The list of allowed robots that is in force in a fleet.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct AllowedReading {
        /// Version of the fleet's list, from 1.
        pub version: i64,
        /// Names of the allowed robots, one on each line; `None` if all robots are allowed.
        pub robots: Option<String>,
        /// Time at which this version was set, µs since 1970 UTC.
        pub changed_us: i64,
        /// Person or token that set it, as in the audit log.
        pub changed_by: String,
        /// Reason that the person gave.
        pub reason: Option<String>,
    }

    /// A robot that is not allowed, and has sent messages.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct TurnedAwayReading {
        /// Name of the robot.
        pub robot: String,
        /// Number of its messages that were refused.
        pub tries: i64,
        /// Time of its first message, µs since 1970 UTC.
        pub first_us: i64,
        /// Time of its last message, µs since 1970 UTC.
        pub last_us: i64,
    }
}

/// A list as it is stored. Of a damaged one the readable names are in force: a list that cannot be read must not admit everybody.
struct StoredList {
    read: Tried<AllowedReading>,
    version: i64,
    names: Option<String>,
}

impl<'r, R: Row> FromRow<'r, R> for StoredList
where
    AllowedReading: FromRow<'r, R>,
    usize: ColumnIndex<R>,
    &'static str: ColumnIndex<R>,
    i64: for<'v> Decode<'v, R::Database> + Type<R::Database>,
    Option<Vec<u8>>: Decode<'r, R::Database>,
{
    fn from_row(row: &'r R) -> sqlx::Result<Self> {
        let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
        Ok(Self {
            read: Tried::from_row(row)?,
            version: row.try_get("version")?,
            names: row.try_get_unchecked::<Option<Vec<u8>>, _>("robots")?.map(text),
        })
    }
}

impl StoredList {
    fn of(read: AllowedReading) -> Self {
        Self { version: read.version, names: read.robots.clone(), read: Tried::Read(read) }
    }

    fn reading(self, set_aside: &SetAside) -> AllowedReading {
        let Self { read, version, names: robots } = self;
        let damaged =
            || AllowedReading { version, robots, changed_us: 0, changed_by: "unknown".to_owned(), reason: None };
        set_aside.read("allowed_robots", read).unwrap_or_else(damaged)
    }
}

/// The valid names in a stored list.
pub fn names_of(robots: &str) -> impl Iterator<Item = Name> {
    robots.lines().filter_map(|line| Name::robot(line).ok())
}

const NEWEST: &str = "SELECT version, robots, changed_us, changed_by, reason FROM allowed_robots \
     WHERE fleet = $1 AND version > $2 ORDER BY version DESC LIMIT 1";

impl Store {
    /// The list in force in a fleet; `None` if none was ever set.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn allowed_robots(&self, fleet: &str) -> Result<Option<AllowedReading>, StoreError> {
        let stored: Option<StoredList> =
            on!(&self.pool, |pool| sqlx::query_as(NEWEST).bind(fleet).bind(0_i64).fetch_optional(pool).await)
                .map_err(failed("read the list of allowed robots"))?;
        Ok(stored.map(|stored| stored.reading(&self.set_aside)))
    }

    /// The robots that were turned away, those with the newest messages first.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn turned_away(&self, fleet: &str) -> Result<Vec<TurnedAwayReading>, StoreError> {
        const SQL: &str =
            "SELECT robot, tries, first_us, last_us FROM turned_away WHERE fleet = $1 ORDER BY last_us DESC, robot";
        on!(&self.pool, |pool| sqlx::query_as(SQL).bind(fleet).fetch_all(pool).await)
            .map_err(failed("read the robots that were turned away"))
    }

    /// Sets a new list in place of version `version_before`, and records the action in the audit log. `None`, and no
    /// change, if another version is in force meanwhile.
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
        const WHAT: &str = "set the list of allowed robots";
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
    /// The list in force in the lease's fleet; `None` if it is not newer than version `after`.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn allowed_robots(&mut self, lease: &Lease, after: i64) -> Result<Option<AllowedReading>, StoreError> {
        const WHAT: &str = "read the list of allowed robots";
        let fleet = lease.fleet().as_str();
        let model = |model: &mut dyn Model| Ok(model.allowed_robots(lease, after).map(StoredList::of));
        let stored: Option<StoredList> = self
            .attempt(WHAT, PATIENCE, model, async |link| {
                on!(link, |link| sqlx::query_as(NEWEST).bind(fleet).bind(after).fetch_optional(link).await)
                    .map_err(failed(WHAT))
            })
            .await?;
        Ok(stored.map(|stored| stored.reading(&self.set_aside)))
    }

    /// Replaces the fleet's rows of robots that were turned away.
    ///
    /// # Errors
    /// The database cannot be written, or the lease is lost.
    pub async fn write_turned_away(&mut self, lease: &Lease, rows: &[TurnedAwayReading]) -> Result<(), StoreError> {
        const WHAT: &str = "write the robots that were turned away";
        const INSERT: &str =
            "INSERT INTO turned_away (fleet, robot, tries, first_us, last_us) VALUES ($1, $2, $3, $4, $5)";
        let fleet = lease.fleet().as_str();
        let model = |model: &mut dyn Model| lease.hold_in(model).map(|model| model.write_turned_away(lease, rows));
        self.attempt(WHAT, PATIENCE, model, async |link| {
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
