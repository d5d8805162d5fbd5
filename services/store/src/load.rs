//! Reads a fleet's state for its recovery, and assigns numbers to robots, boots and whiskers.

use std::collections::BTreeMap;
use std::time::Duration;

use sqlx::{Database, Encode, FromRow as _, Postgres, QueryBuilder, Sqlite, Type};
use vibrissa_core::robot::event::ArrayKind;
use vibrissa_core::robot::{Numbers, RestoreError, Robot, WhiskerView};
use vibrissa_core::units::Micros;

use super::database::{Either, Link, Tx, on};
use super::from_row::from_row;
use super::set_aside::{SetAside, Tried};
use super::{Lease, Model, Store, StoreError, Writer, failed};
use vibrissa_edge::words::Word;

/// A robot's checkpoint, with everything that recovery needs.
#[derive(Debug)]
pub struct StoredRobot {
    /// Number of the robot in the database.
    pub robot_id: i64,
    /// Name of the robot.
    pub robot: String,
    /// Serialized state of the core's robot, without its whiskers; `None` before the first commit.
    pub state: Option<Vec<u8>>,
    /// Programs of the robot: a JSON list, see [`crate::programs`].
    pub software: String,
    /// Numbers of its whiskers in the database, in the order of their index.
    pub whisker_ids: Vec<i64>,
    /// Serialized states of its whiskers, in the same order.
    pub whisker_states: Vec<Vec<u8>>,
    /// States of their segmenters, in the same order; `None` where the robot states none.
    pub segmenters: Vec<Option<String>>,
    /// Serialized aggregates of their current minute and hour, in the same order; `None` before a whisker's first
    /// contact.
    pub rollups: Vec<Option<Vec<u8>>>,
    /// Numbers of its boots in the database, by boot id.
    pub boots: BTreeMap<String, i64>,
    /// Journal rows up to this number are contained in the checkpoint.
    pub journal_number: i64,
    /// Whether an operator held the robot or any of its whiskers.
    pub held: bool,
    /// Next free numbers of its trims and compensations, in case its state cannot be used.
    pub numbers: Numbers,
}

/// A robot's checkpoint, for queries about it.
#[derive(Debug)]
pub struct RobotState {
    /// Number of the robot in the database.
    pub robot_id: i64,
    head: Vec<u8>,
    whiskers: Vec<Vec<u8>>,
}

impl RobotState {
    /// Deserializes the robot. It does not receive messages.
    ///
    /// # Errors
    /// Another version of the program has written the state.
    pub fn robot(&self) -> Result<Robot, RestoreError> {
        Robot::from_bytes(&self.head, &self.whiskers, 0, Micros::default())
    }
}

/// A whisker's number in the database, and the serialized aggregates of its current minute and hour, if it had
/// contacts.
pub type NumberedWhisker = (i64, Option<Vec<u8>>);

/// Time limit for reading a whole fleet.
const LOAD_PATIENCE: Duration = Duration::from_secs(120);
/// Time limit for reading one robot or assigning numbers.
const NUMBER_PATIENCE: Duration = Duration::from_secs(5);

impl Store {
    /// The checkpoint of a robot; `None` if the robot is unknown or nothing of it was committed.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn robot_state(&self, fleet: &str, robot: &str) -> Result<Option<RobotState>, StoreError> {
        // One statement, so that the robot and its whiskers are of the same commit.
        const SQL: &str = "SELECT robot_id, CAST(-1 AS BIGINT) AS position, state FROM robots \
             WHERE fleet = $1 AND robot = $2 AND state IS NOT NULL \
             UNION ALL SELECT w.robot_id, w.position, w.state FROM whiskers w JOIN robots r ON r.robot_id = w.robot_id \
             WHERE fleet = $1 AND robot = $2 AND w.position IS NOT NULL AND w.state IS NOT NULL ORDER BY position";
        let rows: Vec<StateRow> =
            on!(&self.pool, |pool| sqlx::query_as(SQL).bind(fleet).bind(robot).fetch_all(pool).await)
                .map_err(failed("read a robot's state"))?;
        let mut rows = rows.into_iter();
        let head = rows.next().filter(|row| row.position < 0);
        let whiskers = rows.map(|row| row.state).collect();
        Ok(head.map(|head| RobotState { robot_id: head.robot_id, head: head.state, whiskers }))
    }
}

/// Some robots of a fleet.
#[derive(Debug, Default)]
pub struct StoredRobots {
    /// The robots, in the order of their numbers.
    pub robots: Vec<StoredRobot>,
    /// Number of the last robot that was read, or set aside; `None` if there is none.
    pub last: Option<i64>,
}

from_row! {
    /// The row of a robot.
    struct RobotHead {
        robot_id: i64,
        robot: String,
        state: Option<Vec<u8>>,
        software: String,
        journal_number: i64,
        is_held: i32,
        last_trim: Option<i64>,
        last_compensation: Option<i64>,
    }

    /// A robot of whose row more than this cannot be read.
    struct RobotName {
        robot_id: i64,
        robot: String,
    }

    /// The row of a whisker.
    struct WhiskerHead {
        robot_id: i64,
        whisker_id: i64,
        state: Vec<u8>,
        segmenter: Option<String>,
        rollup: Option<Vec<u8>>,
    }

    /// The row of a boot.
    struct BootNumber {
        robot_id: i64,
        boot: i64,
        boot_id: String,
    }
}

impl From<RobotHead> for StoredRobot {
    fn from(row: RobotHead) -> Self {
        Self {
            robot_id: row.robot_id,
            robot: row.robot,
            state: row.state,
            software: row.software,
            whisker_ids: Vec::new(),
            whisker_states: Vec::new(),
            segmenters: Vec::new(),
            rollups: Vec::new(),
            boots: BTreeMap::new(),
            journal_number: row.journal_number,
            held: row.is_held != 0,
            numbers: Numbers {
                next_trim: next_number(row.last_trim),
                next_compensation: next_number(row.last_compensation),
            },
        }
    }
}

impl From<RobotName> for RobotHead {
    /// A state without bytes is one that cannot be read.
    fn from(RobotName { robot_id, robot }: RobotName) -> Self {
        let (state, software) = (Some(Vec::new()), String::new());
        let (last_trim, last_compensation) = (None, None);
        Self { robot_id, robot, state, software, journal_number: 0, is_held: 0, last_trim, last_compensation }
    }
}

from_row! {
    /// A row of the journal.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct JournalReading {
        /// Number of the transaction, which rises within a fleet.
        pub number: i64,
        /// Kafka partition to which ranges without their own partition refer.
        pub log_partition: i64,
        /// Events in the supervisor's own format.
        pub entries: Vec<u8>,
    }
}

from_row! {
    /// State of a robot (position -1) or of one of its whiskers.
    struct StateRow {
        robot_id: i64,
        position: i64,
        state: Vec<u8>,
    }
}

impl Writer {
    /// At most `most` robots of the lease's fleet with numbers above `after`, in the order of their numbers. While the lease
    /// holds, no other supervisor writes them.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn robots(&mut self, lease: &Lease, after: i64, most: i64) -> Result<StoredRobots, StoreError> {
        const WHAT: &str = "load the robots";
        let set_aside = self.set_aside.clone();
        let load = async |link: &mut Link| robots(link, lease, (after, most), &set_aside).await.map_err(failed(WHAT));
        self.attempt(WHAT, LOAD_PATIENCE, |model| Ok(model.robots(lease, after, most)), load).await
    }

    /// The robot of this number in the lease's fleet; `None` if there is no such robot.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn robot(&mut self, lease: &Lease, robot_id: i64) -> Result<Option<StoredRobot>, StoreError> {
        const WHAT: &str = "load a robot";
        let set_aside = self.set_aside.clone();
        let load =
            async |link: &mut Link| robots(link, lease, (robot_id - 1, 1), &set_aside).await.map_err(failed(WHAT));
        let model = |model: &mut dyn Model| Ok(model.robots(lease, robot_id - 1, 1));
        let next = self.attempt(WHAT, NUMBER_PATIENCE, model, load).await?.robots.pop();
        Ok(next.filter(|robot| robot.robot_id == robot_id))
    }

    /// At most `most` rows of the fleet's journal after number `after`, in order.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn journal(&mut self, lease: &Lease, after: i64, most: i64) -> Result<Vec<JournalReading>, StoreError> {
        const WHAT: &str = "read the journal";
        const SQL: &str = "SELECT number, log_partition, entries FROM journal WHERE fleet = $1 AND number > $2 \
             ORDER BY number LIMIT $3";
        let fleet = lease.fleet().as_str();
        self.attempt(
            WHAT,
            LOAD_PATIENCE,
            |model| Ok(model.journal(lease, after, most)),
            async |link| {
                on!(link, |link| sqlx::query_as(SQL).bind(fleet).bind(after).bind(most).fetch_all(link).await)
                    .map_err(failed(WHAT))
            },
        )
        .await
    }

    /// Number of a robot's boot in the database; an unknown boot is inserted.
    ///
    /// # Errors
    /// The database cannot be written, or the lease is lost.
    pub async fn boot(&mut self, lease: &Lease, robot_id: i64, boot_id: &str, now_us: i64) -> Result<i64, StoreError> {
        const WHAT: &str = "assign a number to a boot";
        const SQL: &str = "INSERT INTO boots (robot_id, boot_id, first_seen_us) VALUES ($1, $2, $3) \
             ON CONFLICT (robot_id, boot_id) DO UPDATE SET boot_id = excluded.boot_id RETURNING boot";
        let model = |model: &mut dyn Model| lease.numbering_in(model, |model| Ok(model.boot(robot_id, boot_id)?));
        let work = async |link: &mut Link| {
            let (mut tx, numbers) = numbering(link, lease, WHAT).await?;
            let boot = on!(&mut tx, |tx| sqlx::query_scalar(SQL)
                .bind(robot_id)
                .bind(boot_id)
                .bind(now_us)
                .fetch_one(&mut **tx)
                .await)
            .map_err(failed(WHAT))?;
            tx.commit().await.map_err(failed(WHAT))?;
            Ok((boot, numbers))
        };
        let (boot, numbers) = self.attempt(WHAT, NUMBER_PATIENCE, model, work).await?;
        lease.numbered(numbers);
        Ok(boot)
    }

    /// Numbers of a robot's whiskers in the database, in the order of their index, each with its last committed
    /// aggregates; unknown whiskers are inserted.
    ///
    /// Updates the properties that the factsheet states. The states follow in the batch with the new layout, so that
    /// a crash in between leaves the old layout intact.
    ///
    /// # Errors
    /// The database cannot be written, or the lease is lost.
    pub async fn whisker_ids(
        &mut self,
        lease: &Lease,
        robot_id: i64,
        robot: &Robot,
    ) -> Result<Vec<NumberedWhisker>, StoreError> {
        const WHAT: &str = "assign numbers to whiskers";
        let model = |model: &mut dyn Model| lease.numbering_in(model, |model| Ok(model.whisker_ids(robot_id, robot)?));
        let work = async |link: &mut Link| {
            let (mut tx, numbers) = numbering(link, lease, WHAT).await?;
            let ids = number_whiskers(&mut tx, robot_id, robot).await.map_err(failed(WHAT))?;
            tx.commit().await.map_err(failed(WHAT))?;
            Ok((ids, numbers))
        };
        let (ids, numbers) = self.attempt(WHAT, NUMBER_PATIENCE, model, work).await?;
        lease.numbered(numbers);
        Ok(ids)
    }
}

/// Begins a transaction that assigns numbers. It has locked the lease's row; its count is for [`Lease::numbered`].
pub(super) async fn numbering<'c>(
    link: &'c mut Link,
    lease: &Lease,
    what: &'static str,
) -> Result<(Tx<'c>, i64), StoreError> {
    let mut tx = link.begin().await.map_err(failed(what))?;
    let numbers = lease.count_numbers(&mut tx).await?;
    Ok((tx, numbers))
}

/// At most `most` robots of a fleet with numbers above `after`. One damaged row costs its robot what it has learned, and
/// keeps no other robot from being loaded.
async fn robots(
    link: &mut Link,
    lease: &Lease,
    (after, most): (i64, i64),
    set_aside: &SetAside,
) -> sqlx::Result<StoredRobots> {
    const ROBOTS: &str = "SELECT robot_id, robot, state, software, journal_number, \
         CASE WHEN r.held OR EXISTS (SELECT 1 FROM whiskers w WHERE w.robot_id = r.robot_id AND w.held) \
         THEN 1 ELSE 0 END AS is_held, \
         (SELECT max(trim_id) FROM trims t WHERE t.robot_id = r.robot_id) AS last_trim, \
         (SELECT max(compensation_id) FROM compensations c WHERE c.robot_id = r.robot_id) AS last_compensation \
         FROM robots r WHERE fleet = $1 AND decommissioned_us IS NULL AND r.robot_id > $2 ORDER BY r.robot_id LIMIT $3";
    const WHISKERS: &str = "SELECT w.robot_id, whisker_id, w.state, w.segmenter, w.rollup FROM whiskers w \
         JOIN robots r ON r.robot_id = w.robot_id AND position IS NOT NULL AND w.state IS NOT NULL \
         WHERE fleet = $1 AND w.robot_id BETWEEN $2 AND $3 ORDER BY w.robot_id, position";
    const BOOTS: &str = "SELECT b.robot_id, boot, b.boot_id FROM boots b JOIN robots r ON r.robot_id = b.robot_id \
         WHERE fleet = $1 AND b.robot_id BETWEEN $2 AND $3";
    macro_rules! rows {
        ($link:expr, $sql:expr, $from:expr, $to:expr) => {{
            let query = sqlx::query($sql).bind(lease.fleet().as_str());
            query.bind($from).bind($to).fetch_all($link).await?
        }};
    }
    let (mut robots, mut bounds) = (BTreeMap::new(), None);
    let mut seen = |robot_id: i64| bounds = Some((bounds.map_or(robot_id, |(first, _)| first), robot_id));
    on!(&mut *link, |link| for row in rows!(&mut *link, ROBOTS, after, most) {
        let head = match Tried::<RobotHead>::from_row(&row)? {
            Tried::Read(head) => head,
            Tried::Unreadable(problem) => {
                set_aside.add("robots", &problem);
                problem.id.into_iter().for_each(&mut seen);
                let Ok(name) = RobotName::from_row(&row) else { continue };
                name.into()
            }
        };
        seen(head.robot_id);
        robots.insert(head.robot_id, StoredRobot::from(head));
    });
    let Some((first, last)) = bounds else { return Ok(StoredRobots::default()) };
    on!(&mut *link, |link| for row in rows!(&mut *link, WHISKERS, first, last) {
        let whisker = match Tried::<WhiskerHead>::from_row(&row)? {
            Tried::Read(whisker) => whisker,
            Tried::Unreadable(problem) => {
                set_aside.add("whiskers", &problem);
                let Some(robot_id) = problem.id else { continue };
                // A state without bytes cannot be read.
                WhiskerHead { robot_id, whisker_id: 0, state: Vec::new(), segmenter: None, rollup: None }
            }
        };
        if let Some(robot) = robots.get_mut(&whisker.robot_id) {
            robot.whisker_ids.push(whisker.whisker_id);
            robot.whisker_states.push(whisker.state);
            robot.segmenters.push(whisker.segmenter);
            robot.rollups.push(whisker.rollup);
        }
    });
    on!(link, |link| for row in rows!(link, BOOTS, first, last) {
        let Some(boot) = set_aside.read("boots", Tried::<BootNumber>::from_row(&row)?) else { continue };
        if let Some(robot) = robots.get_mut(&boot.robot_id) {
            robot.boots.insert(boot.boot_id, boot.boot);
        }
    });
    Ok(StoredRobots { robots: robots.into_values().collect(), last: Some(last) })
}

/// The number after the last one. A number in the database has the robot's number in its upper 32 bits.
pub(super) fn next_number(last: Option<i64>) -> u32 {
    last.map_or(0, |last| (last as u32).wrapping_add(1))
}

async fn array_id(tx: &mut Tx<'_>, robot_id: i64, array: &str, kind: ArrayKind) -> sqlx::Result<i64> {
    const SQL: &str = "INSERT INTO arrays (robot_id, \"array\", array_type) VALUES ($1, $2, $3) \
         ON CONFLICT (robot_id, \"array\") DO UPDATE SET array_type = excluded.array_type RETURNING array_id";
    on!(tx, |tx| sqlx::query_scalar(SQL).bind(robot_id).bind(array).bind(kind.word()).fetch_one(&mut **tx).await)
}

/// Inserts or updates a robot's whiskers with few statements; returns their numbers in the order of their index.
async fn number_whiskers(tx: &mut Tx<'_>, robot_id: i64, robot: &Robot) -> sqlx::Result<Vec<NumberedWhisker>> {
    let views: Vec<WhiskerView<'_>> = (0..robot.whisker_count()).filter_map(|index| robot.whisker(index)).collect();
    let mut array_ids = BTreeMap::new();
    for view in &views {
        if !array_ids.contains_key(view.array) {
            array_ids.insert(view.array, array_id(tx, robot_id, view.array, view.kind).await?);
        }
    }
    let mut numbers: BTreeMap<(i64, i64), NumberedWhisker> = BTreeMap::new();
    for views in views.chunks(WHISKERS_A_STATEMENT) {
        let rows: Vec<(i64, i64, i64, Option<Vec<u8>>)> = match tx {
            Either::Sqlite(tx) => {
                upsert::<Sqlite>(robot_id, views, &array_ids)
                    .build_query_as()
                    .persistent(false)
                    .fetch_all(&mut **tx)
                    .await
            }
            Either::Postgres(tx) => {
                upsert::<Postgres>(robot_id, views, &array_ids)
                    .build_query_as()
                    .persistent(false)
                    .fetch_all(&mut **tx)
                    .await
            }
        }?;
        let numbered = |(array_id, whisker, whisker_id, rollup)| ((array_id, whisker), (whisker_id, rollup));
        numbers.extend(rows.into_iter().map(numbered));
    }
    let mut number = |view: &WhiskerView<'_>| {
        let key = (array_ids.get(view.array).copied()?, i64::from(view.sheet.number));
        numbers.remove(&key)
    };
    views.iter().map(|view| number(view).ok_or(sqlx::Error::RowNotFound)).collect()
}

/// Most rows of one statement: each binds 9 values, and SQLite accepts 32,766.
const WHISKERS_A_STATEMENT: usize = 1000;

fn upsert<'a, DB: Database>(
    robot_id: i64,
    views: &'a [WhiskerView<'a>],
    array_ids: &BTreeMap<&str, i64>,
) -> QueryBuilder<DB>
where
    i64: for<'q> Encode<'q, DB> + Type<DB>,
    f64: for<'q> Encode<'q, DB> + Type<DB>,
    String: for<'q> Encode<'q, DB> + Type<DB>,
{
    let mut sql = QueryBuilder::<DB>::new(
        "INSERT INTO whiskers (array_id, robot_id, whisker, x_mm, y_mm, model, whole_length_mm, \
         nominal_pressure_mpa, pressure_max_mpa, length_mm, length_sd_mm, condition, setpoint_mpa) ",
    );
    sql.push_values(views, |mut row, view| {
        let sheet = view.sheet;
        row.push_bind(array_ids.get(view.array).copied().unwrap_or_default())
            .push_bind(robot_id)
            .push_bind(i64::from(sheet.number))
            .push_bind(sheet.x_mm)
            .push_bind(sheet.y_mm)
            .push_bind(sheet.model.to_string())
            .push_bind(sheet.length.mm())
            .push_bind(sheet.pressure.mpa())
            .push_bind(sheet.pressure_max.mpa())
            .push_bind(sheet.length.mm())
            .push("0, 'LEARNING'")
            .push_bind(sheet.pressure.mpa());
    });
    sql.push(
        " ON CONFLICT (array_id, whisker) DO UPDATE SET x_mm = excluded.x_mm, y_mm = excluded.y_mm, \
         model = excluded.model, whole_length_mm = excluded.whole_length_mm, \
         nominal_pressure_mpa = excluded.nominal_pressure_mpa, pressure_max_mpa = excluded.pressure_max_mpa, \
         absent_us = NULL \
         RETURNING array_id, whisker, whisker_id, rollup",
    );
    sql
}
