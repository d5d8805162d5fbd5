//! Labels of robots: set and removed with an entry in the audit log in the same transaction.

use serde::Serialize;
use vibrissa_edge::labels::{LabelKey, LabelValue, Labels};

use super::actions::{Asked, NewAction, record_done};
use super::database::on;
use super::events::write::EventRow;
use super::from_row::text_columns;
use super::{Store, StoreError, events, failed};
use vibrissa_edge::events::EventKind;

const WHAT: &str = "change the labels of a robot";

/// The labels of a robot, as its row has them.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct RobotLabels(pub Labels);

impl From<String> for RobotLabels {
    fn from(lines: String) -> Self {
        Self(Labels::from_lines(&lines))
    }
}

text_columns!(RobotLabels);

/// A change of the labels of a robot.
#[derive(Debug, Clone, Copy)]
pub enum LabelChange<'a> {
    /// Sets the value of a key.
    Set(&'a LabelKey, &'a LabelValue),
    /// Removes a key.
    Remove(&'a LabelKey),
}

/// Result of a change.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Labelled {
    /// Changed, now or by the same request before.
    Done(Box<Asked>),
    /// There is no such robot.
    NoRobot,
    /// The robot has the greatest number of labels.
    TooMany,
    /// The robot has no such label.
    NoLabel,
}

impl Store {
    /// Changes the labels of a robot at most once, and records the action in the audit log.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn change_labels(
        &self,
        (fleet, robot): (&str, &str),
        change: LabelChange<'_>,
        action: &NewAction,
    ) -> Result<Labelled, StoreError> {
        const READ: &str = "SELECT robot_id, labels FROM robots WHERE fleet = $1 AND robot = $2";
        const WRITE: &str = "UPDATE robots SET labels = $1 WHERE robot_id = $2";
        let mut tx = self.pool.begin().await.map_err(failed(WHAT))?;
        let asked = record_done(&mut tx, action, action.asked_us).await?;
        if !matches!(asked, Asked::New(_)) {
            return Ok(Labelled::Done(Box::new(asked)));
        }
        // The entry of the audit log is written first, so SQLite has its write lock. PostgreSQL locks the robot's row.
        let sql = if self.is_shared() { format!("{READ} FOR UPDATE") } else { READ.to_owned() };
        let known: Option<(i64, String)> = on!(&mut tx, |tx| sqlx::query_as(sqlx::AssertSqlSafe(sql))
            .bind(fleet)
            .bind(robot)
            .fetch_optional(&mut **tx)
            .await)
        .map_err(failed(WHAT))?;
        let Some((robot_id, lines)) = known else { return Ok(Labelled::NoRobot) };
        let mut labels = Labels::from_lines(&lines);
        match change {
            LabelChange::Set(key, value) if !labels.set(key, value) => return Ok(Labelled::TooMany),
            LabelChange::Remove(key) if !labels.remove(key) => return Ok(Labelled::NoLabel),
            LabelChange::Set(..) | LabelChange::Remove(_) => {}
        }
        on!(&mut tx, |tx| sqlx::query(WRITE).bind(labels.lines()).bind(robot_id).execute(&mut **tx).await.map(drop))
            .map_err(failed(WHAT))?;
        let now_us = action.asked_us;
        let event = EventRow::new(EventKind::Action, now_us).of_robot(robot_id);
        events::write::write(&mut tx, fleet, &[event]).await.map_err(failed(WHAT))?;
        tx.commit().await.map_err(failed(WHAT))?;
        Ok(Labelled::Done(Box::new(asked)))
    }
}
