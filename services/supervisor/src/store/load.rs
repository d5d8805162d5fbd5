//! What a start needs: an epoch, numbers for new things, and every robot as it was committed last.

use std::collections::BTreeMap;

use sqlx::Row;
use vibrissa_core::robot::event::{ArrayKind, WhiskerSheet};
use vibrissa_core::robot::{Numbers, Robot};

use super::{Store, StoreError, failed};
use crate::words::Word;

/// A robot as it was committed last.
#[derive(Debug)]
pub struct StoredRobot {
    /// Number.
    pub robot_id: i64,
    /// Fleet.
    pub fleet: String,
    /// Name.
    pub robot: String,
    /// The core's bytes; none before the first commit.
    pub state: Option<Vec<u8>>,
    /// Numbers of its whiskers, in the order of their index.
    pub whisker_ids: Vec<i64>,
    /// The core's bytes of its whiskers, in the same order.
    pub whisker_states: Vec<Vec<u8>>,
    /// Numbers of its boots.
    pub boots: BTreeMap<String, i64>,
    /// The first free numbers of its trims and compensations, for when its state cannot be used.
    pub numbers: Numbers,
}

impl Store {
    /// A new epoch, higher than every one before.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn begin_epoch(&self, boot_id: &str, now_us: i64) -> Result<u64, StoreError> {
        sqlx::query("INSERT INTO supervisors (boot_id, started_us) VALUES (?, ?)")
            .bind(boot_id)
            .bind(now_us)
            .execute(&self.pool)
            .await
            .map(|written| written.last_insert_rowid() as u64)
            .map_err(failed("begin a new epoch"))
    }

    /// Every robot of a fleet.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn robots(&self, fleet: &str) -> Result<Vec<StoredRobot>, StoreError> {
        const WHAT: &str = "load the robots";
        let rows = sqlx::query(
            "SELECT robot_id, fleet, robot, state, \
             (SELECT max(trim_id) FROM trims t WHERE t.robot_id = r.robot_id) AS last_trim, \
             (SELECT max(compensation_id) FROM compensations c WHERE c.robot_id = r.robot_id) AS last_compensation \
             FROM robots r WHERE fleet = ?",
        )
        .bind(fleet)
        .fetch_all(&self.pool)
        .await
        .map_err(failed(WHAT))?;
        let mut robots: BTreeMap<i64, StoredRobot> = BTreeMap::new();
        for row in &rows {
            let robot = StoredRobot {
                robot_id: row.get("robot_id"),
                fleet: row.get("fleet"),
                robot: row.get("robot"),
                state: row.get("state"),
                whisker_ids: Vec::new(),
                whisker_states: Vec::new(),
                boots: BTreeMap::new(),
                numbers: Numbers {
                    next_trim: next_number(row.get("last_trim")),
                    next_compensation: next_number(row.get("last_compensation")),
                },
            };
            robots.insert(robot.robot_id, robot);
        }
        let whiskers = sqlx::query(
            "SELECT robot_id, whisker_id, w.state FROM whiskers w JOIN robots USING (robot_id) \
             WHERE fleet = ? AND position IS NOT NULL AND w.state IS NOT NULL ORDER BY robot_id, position",
        )
        .bind(fleet)
        .fetch_all(&self.pool)
        .await
        .map_err(failed(WHAT))?;
        for row in &whiskers {
            if let Some(robot) = robots.get_mut(&row.get("robot_id")) {
                robot.whisker_ids.push(row.get("whisker_id"));
                robot.whisker_states.push(row.get("state"));
            }
        }
        let boots =
            sqlx::query("SELECT robot_id, boot, b.boot_id FROM boots b JOIN robots USING (robot_id) WHERE fleet = ?")
                .bind(fleet)
                .fetch_all(&self.pool)
                .await
                .map_err(failed(WHAT))?;
        for row in &boots {
            if let Some(robot) = robots.get_mut(&row.get("robot_id")) {
                robot.boots.insert(row.get("boot_id"), row.get("boot"));
            }
        }
        Ok(robots.into_values().collect())
    }

    /// The number of a robot, new or known.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn robot_id(&self, fleet: &str, robot: &str) -> Result<i64, StoreError> {
        sqlx::query(
            "INSERT INTO robots (fleet, robot) VALUES (?, ?) \
             ON CONFLICT (fleet, robot) DO UPDATE SET robot = excluded.robot RETURNING robot_id",
        )
        .bind(fleet)
        .bind(robot)
        .fetch_one(&self.pool)
        .await
        .map(|row| row.get(0))
        .map_err(failed("number a robot"))
    }

    /// The number of a robot's boot, new or known.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn boot(&self, robot_id: i64, boot_id: &str, now_us: i64) -> Result<i64, StoreError> {
        sqlx::query(
            "INSERT INTO boots (robot_id, boot_id, first_seen_us) VALUES (?, ?, ?) \
             ON CONFLICT (robot_id, boot_id) DO UPDATE SET boot_id = excluded.boot_id RETURNING boot",
        )
        .bind(robot_id)
        .bind(boot_id)
        .bind(now_us)
        .fetch_one(&self.pool)
        .await
        .map(|row| row.get(0))
        .map_err(failed("number a boot"))
    }

    /// The numbers of a robot's whiskers, new or known, in the order of their index.
    ///
    /// What is on the robot is brought up to date; the states follow with the batch that takes the new layout
    /// in, so that a crash in between leaves the old layout whole.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn whisker_ids(&self, robot_id: i64, robot: &Robot) -> Result<Vec<i64>, StoreError> {
        const WHAT: &str = "number the whiskers";
        let mut transaction = self.pool.begin().await.map_err(failed(WHAT))?;
        let mut ids = Vec::with_capacity(robot.whisker_count());
        for view in (0..robot.whisker_count()).filter_map(|index| robot.whisker(index)) {
            let array_id = array_id(&mut transaction, robot_id, view.array, view.kind).await.map_err(failed(WHAT))?;
            let id = whisker_id(&mut transaction, robot_id, array_id, view.sheet).await.map_err(failed(WHAT))?;
            ids.push(id);
        }
        transaction.commit().await.map_err(failed(WHAT))?;
        Ok(ids)
    }
}

/// The number after the last one, of which the database's number has the robot's in front.
fn next_number(last: Option<i64>) -> u32 {
    last.map_or(0, |last| (last as u32).wrapping_add(1))
}

async fn array_id(tx: &mut sqlx::SqliteConnection, robot_id: i64, array: &str, kind: ArrayKind) -> sqlx::Result<i64> {
    sqlx::query(
        "INSERT INTO arrays (robot_id, array, array_type) VALUES (?, ?, ?) \
         ON CONFLICT (robot_id, array) DO UPDATE SET array_type = excluded.array_type RETURNING array_id",
    )
    .bind(robot_id)
    .bind(array)
    .bind(kind.word())
    .fetch_one(tx)
    .await
    .map(|row| row.get(0))
}

async fn whisker_id(
    tx: &mut sqlx::SqliteConnection,
    robot_id: i64,
    array_id: i64,
    sheet: &WhiskerSheet,
) -> sqlx::Result<i64> {
    sqlx::query(
        "INSERT INTO whiskers (array_id, robot_id, whisker, x_mm, y_mm, model, whole_length_mm, \
         nominal_pressure_mpa, pressure_max_mpa, length_mm, length_sd_mm, condition, setpoint_mpa) \
         VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?7, 0, 'LEARNING', ?8) \
         ON CONFLICT (array_id, whisker) DO UPDATE SET x_mm = excluded.x_mm, y_mm = excluded.y_mm, \
         model = excluded.model, whole_length_mm = excluded.whole_length_mm, \
         nominal_pressure_mpa = excluded.nominal_pressure_mpa, pressure_max_mpa = excluded.pressure_max_mpa \
         RETURNING whisker_id",
    )
    .bind(array_id)
    .bind(robot_id)
    .bind(i64::from(sheet.number))
    .bind(sheet.x_mm)
    .bind(sheet.y_mm)
    .bind(&sheet.model)
    .bind(sheet.length.mm())
    .bind(sheet.pressure.mpa())
    .bind(sheet.pressure_max.mpa())
    .fetch_one(tx)
    .await
    .map(|row| row.get(0))
}
