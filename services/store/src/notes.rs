//! Notes on robots: added and removed with an entry in the audit log in the same transaction.

use super::actions::{Asked, NewAction, record_done};
use super::database::{Tx, on};
use super::events::write::EventRow;
use super::{Store, StoreError, events, failed};
use vibrissa_edge::events::EventKind;

/// Most notes of a robot.
pub const NOTES_MAX: i64 = 100;

const WHAT: &str = "change the notes on a robot";

/// A change of the notes on a robot.
#[derive(Debug, Clone, Copy)]
pub enum NoteChange<'a> {
    /// Adds a note with a text.
    Add(&'a str),
    /// Removes the note of this number.
    Remove(i64),
}

/// Result of a change.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Noted {
    /// Changed, now or by the same request before.
    Done(Box<Asked>),
    /// There is no such robot.
    NoRobot,
    /// The robot has [`NOTES_MAX`] notes.
    TooMany,
    /// The robot has no such note.
    NoNote,
}

impl Store {
    /// Changes the notes on a robot at most once, and records the action in the audit log.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn change_notes(
        &self,
        (fleet, robot): (&str, &str),
        change: NoteChange<'_>,
        action: &NewAction,
    ) -> Result<Noted, StoreError> {
        const READ: &str = "SELECT robot_id FROM robots WHERE fleet = $1 AND robot = $2";
        let mut tx = self.pool.begin().await.map_err(failed(WHAT))?;
        let asked = record_done(&mut tx, action, action.asked_us).await?;
        let Asked::New(action_id) = asked else { return Ok(Noted::Done(Box::new(asked))) };
        // The entry of the audit log is written first, so SQLite has its write lock. PostgreSQL locks the robot's row:
        // otherwise two requests at once could pass the limit.
        let sql = if self.is_shared() { format!("{READ} FOR NO KEY UPDATE") } else { READ.to_owned() };
        let known: Option<i64> = on!(&mut tx, |tx| sqlx::query_scalar(sqlx::AssertSqlSafe(sql))
            .bind(fleet)
            .bind(robot)
            .fetch_optional(&mut **tx)
            .await)
        .map_err(failed(WHAT))?;
        let Some(robot_id) = known else { return Ok(Noted::NoRobot) };
        let changed = match change {
            NoteChange::Add(text) => insert(&mut tx, robot_id, action_id, text, action).await,
            NoteChange::Remove(note_id) => delete(&mut tx, robot_id, note_id).await,
        }
        .map_err(failed(WHAT))?;
        if changed == 0 {
            return Ok(match change {
                NoteChange::Add(_) => Noted::TooMany,
                NoteChange::Remove(_) => Noted::NoNote,
            });
        }
        let now_us = action.asked_us;
        let event = EventRow::new(EventKind::Action, now_us).of_robot(robot_id);
        events::write::write(&mut tx, fleet, &[event]).await.map_err(failed(WHAT))?;
        tx.commit().await.map_err(failed(WHAT))?;
        Ok(Noted::Done(Box::new(asked)))
    }
}

/// Inserts a note unless the robot has [`NOTES_MAX`]; the number of rows.
async fn insert(tx: &mut Tx<'_>, robot_id: i64, action_id: i64, text: &str, action: &NewAction) -> sqlx::Result<u64> {
    const SQL: &str = "INSERT INTO notes (robot_id, written_us, author, text, action_id) SELECT $1, $2, $3, $4, $5 \
                       WHERE (SELECT count(*) FROM notes WHERE robot_id = $1) < $6";
    on!(tx, |tx| sqlx::query(SQL)
        .bind(robot_id)
        .bind(action.asked_us)
        .bind(&action.actor)
        .bind(text)
        .bind(action_id)
        .bind(NOTES_MAX)
        .execute(&mut **tx)
        .await
        .map(|done| done.rows_affected()))
}

/// Deletes a note of a robot; the number of rows.
async fn delete(tx: &mut Tx<'_>, robot_id: i64, note_id: i64) -> sqlx::Result<u64> {
    const SQL: &str = "DELETE FROM notes WHERE robot_id = $1 AND note_id = $2";
    on!(tx, |tx| sqlx::query(SQL)
        .bind(robot_id)
        .bind(note_id)
        .execute(&mut **tx)
        .await
        .map(|done| done.rows_affected()))
}
