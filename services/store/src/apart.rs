//! Writes a batch robot by robot after the database has refused it as a whole. The rows of all robots that the
//! database accepts are committed in one transaction; the other robots are named.
//!
//! ```text
//! whole batch refused ──▶ all robots ──refused──▶ first half ──taken──▶ (stays in the transaction)
//!                                            └──▶ second half ──refused──▶ ... ──▶ one robot ──refused──▶ named, left out
//! ```
//! Each attempt is a savepoint of one transaction: a half that was accepted need not be written again, and rows of
//! two robots that conflict with each other are found as well.

use std::collections::{HashMap, HashSet};
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use tokio::time::Instant;

use super::batch::{Batch, JournalRow, Owner, Owners, Parts, Record, Rows};
use super::database::{Either, Link, Tx, on};
use super::model::{Model, atomically};
use super::{Lease, Rejection, StoreError, Writer, commit, events, failed, log_position, records};

/// Time limit for one attempt.
const PATIENCE: std::time::Duration = std::time::Duration::from_secs(30);
/// Most numbers in the list of one query.
const NUMBERS_A_QUESTION: usize = 500;

/// Rows of one owner that the database refused.
#[derive(Debug, Clone)]
pub struct Refused {
    /// Owner of the rows that were left out.
    pub owner: Owner,
    /// Error of the database.
    pub rejection: Rejection,
}

impl Writer {
    /// Writes a batch without the rows that the database refuses, and names their owners in `refused`. Afterwards the
    /// batch contains the rows that were written. Pass the same `refused` to each attempt: if an attempt was
    /// committed but its answer was lost, the next one finds the owners there.
    ///
    /// # Errors
    /// The database cannot be written now, or the lease is lost; the batch is unchanged.
    pub async fn commit_apart(
        &mut self,
        lease: &Lease,
        batch: &mut Batch,
        split_journal: impl Fn(&[u8]) -> Vec<(i64, Vec<u8>)>,
        refused: &mut Vec<Refused>,
    ) -> Result<(), StoreError> {
        let ids = Sought::of(batch);
        let ids_in_model = |model: &mut dyn Model| Ok(model.owners(&ids.whiskers, &ids.actions, &ids.commands));
        let owners =
            self.attempt("find the owners of rows", PATIENCE, ids_in_model, async |link| ids.find(link).await).await?;
        let parts = Parts::of(std::mem::take(batch), &owners, split_journal);
        let (asked, noted) = (Instant::now(), Mutex::new(&mut *refused));
        let model = |model: &mut dyn Model| write_model(model, lease, &parts, (asked, &noted));
        let written = async |link: &mut Link| write(link, lease, &parts, &noted).await;
        let written = self.attempt("commit", PATIENCE, model, written).await;
        let left_out: HashSet<Owner> = match &written {
            Ok(_) => refused.iter().map(|one| one.owner).collect(),
            Err(_) => HashSet::new(),
        };
        *batch = parts.without(&left_out);
        lease.committed(written?);
        Ok(())
    }
}

async fn write(
    link: &mut Link,
    lease: &Lease,
    parts: &Parts<'_>,
    noted: &Noted<'_>,
) -> Result<Option<Instant>, StoreError> {
    let asked = Instant::now();
    let mut tx = link.begin().await.map_err(failed("begin a transaction"))?;
    if !lease.begin(&mut tx).await? {
        tx.rollback().await.map_err(failed("roll back"))?;
        return Ok(None);
    }
    let mut refused = Vec::new();
    // Ranges of owners that remain to be tried; the first range is the last element.
    let mut waiting = Vec::from([Range { start: 0, end: parts.len() }]);
    while let Some(range) = waiting.pop() {
        if range.is_empty() {
            continue;
        }
        savepoint(&mut tx, "SAVEPOINT half").await?;
        let written = write_range(&mut tx, lease, parts, range.clone()).await;
        let Err(problem) = written else {
            savepoint(&mut tx, "RELEASE SAVEPOINT half").await?;
            continue;
        };
        let Some(rejection) = problem.rejection() else { return Err(problem) };
        savepoint(&mut tx, "ROLLBACK TO SAVEPOINT half").await?;
        savepoint(&mut tx, "RELEASE SAVEPOINT half").await?;
        if range.len() == 1 {
            refused.push(Refused { owner: parts.owner(range.start), rejection });
        } else {
            let middle = range.start + range.len() / 2;
            waiting.push(middle..range.end);
            waiting.push(range.start..middle);
        }
    }
    log_position::write(&mut tx, lease, &parts.rest().log).await?;
    commit::write_done(&mut tx, lease, parts.rest(), refused.is_empty()).await?;
    note(noted, refused);
    tx.commit().await.map_err(failed("commit"))?;
    Ok(Some(asked))
}

/// As [`write`], into a model, one robot after the other; `asked` is the moment before its query.
fn write_model(
    model: &mut dyn Model,
    lease: &Lease,
    parts: &Parts<'_>,
    (asked, noted): (Instant, &Noted<'_>),
) -> Result<Option<Instant>, StoreError> {
    atomically(model, |model| {
        if !lease.begin_in(model)? {
            return Ok(None);
        }
        let mut refused = Vec::new();
        for at in 0..parts.len() {
            let written = atomically(model, |model| {
                model.write(lease, &parts.rows(at..at + 1))?;
                if let Some(row) = journal_of(parts, at..at + 1) {
                    model.write_journal(lease, &row, true)?;
                }
                Ok(())
            });
            let Err(problem) = written else { continue };
            let Some(rejection) = problem.rejection() else { return Err(problem) };
            refused.push(Refused { owner: parts.owner(at), rejection });
        }
        commit::end_model(model, lease, parts.rest(), refused.is_empty());
        note(noted, refused);
        Ok(Some(asked))
    })
}

/// Owners whose rows the newest attempt has left out. They are noted before the end of its transaction, whose answer may be
/// lost.
type Noted<'r> = Mutex<&'r mut Vec<Refused>>;

fn note(noted: &Noted<'_>, refused: Vec<Refused>) {
    **noted.lock().unwrap_or_else(PoisonError::into_inner) = refused;
}

/// The row of the journal with the entries of a range of owners; `None` without any.
fn journal_of(parts: &Parts<'_>, range: Range<usize>) -> Option<JournalRow> {
    let (number, entries) = (parts.journal_number()?, parts.journal(range));
    (!entries.is_empty()).then_some(JournalRow { number, entries })
}

async fn savepoint(tx: &mut Tx<'_>, sql: &'static str) -> Result<(), StoreError> {
    on!(tx, |tx| sqlx::raw_sql(sql).execute(&mut **tx).await.map(drop)).map_err(failed("set a savepoint"))
}

async fn write_range(tx: &mut Tx<'_>, lease: &Lease, parts: &Parts<'_>, range: Range<usize>) -> Result<(), StoreError> {
    let rows: Rows<'_> = parts.rows(range.clone());
    commit::write_contacts(tx, rows.contacts).await?;
    records::write(tx, lease.fleet().as_str(), &rows).await?;
    if let Some(row) = journal_of(parts, range) {
        append_journal(tx, lease, &row).await?;
    }
    events::write::write(tx, lease.fleet().as_str(), rows.events).await.map_err(failed("write events"))
}

/// Appends entries to a row of the journal; other robots' entries may have created that row before.
async fn append_journal(tx: &mut Tx<'_>, lease: &Lease, row: &JournalRow) -> Result<(), StoreError> {
    let sql = match tx {
        // SQLite's || makes a text of two blobs, hence the cast; the bytes are unchanged.
        Either::Sqlite(_) => {
            "INSERT INTO journal (fleet, number, entries) VALUES ($1, $2, $3) \
             ON CONFLICT (fleet, number) \
             DO UPDATE SET entries = CAST(journal.entries || excluded.entries AS BLOB)"
        }
        Either::Postgres(_) => {
            "INSERT INTO journal (fleet, number, entries) VALUES ($1, $2, $3) \
             ON CONFLICT (fleet, number) \
             DO UPDATE SET entries = journal.entries || excluded.entries"
        }
    };
    on!(tx, |tx| sqlx::query(sql)
        .bind(lease.fleet().as_str())
        .bind(row.number)
        .bind(&row.entries)
        .execute(&mut **tx)
        .await
        .map(drop))
    .map_err(failed("write the journal"))
}

/// Rows of a batch whose robots only the database knows.
struct Sought {
    whiskers: Vec<i64>,
    actions: Vec<i64>,
    commands: Vec<String>,
}

impl Sought {
    fn of(batch: &Batch) -> Self {
        let mut whiskers: Vec<i64> = batch.whisker_ids().collect();
        whiskers.sort_unstable();
        whiskers.dedup();
        let (mut actions, mut commands) = (Vec::new(), Vec::new());
        for record in &batch.records {
            if let Record::Answer { action_id, robot_id: 0, .. } = record {
                actions.push(*action_id);
            } else if let Record::SetpointState(row) = record
                && row.robot_id == 0
            {
                commands.push(row.command_id.clone());
            }
        }
        Self { whiskers, actions, commands }
    }

    async fn find(&self, link: &mut Link) -> Result<Owners, StoreError> {
        const WHISKERS: &str = "SELECT whisker_id, robot_id FROM whiskers WHERE whisker_id IN ";
        const ACTIONS: &str = "SELECT a.action_id, r.robot_id FROM actions a \
             JOIN robots r ON r.fleet = a.fleet AND r.robot = a.robot WHERE a.action_id IN ";
        Ok(Owners {
            whiskers: pairs(link, WHISKERS, &self.whiskers).await?,
            actions: pairs(link, ACTIONS, &self.actions).await?,
            commands: commands(link, &self.commands).await?,
        })
    }
}

async fn pairs(link: &mut Link, sql: &str, numbers: &[i64]) -> Result<HashMap<i64, i64>, StoreError> {
    let mut found = HashMap::with_capacity(numbers.len());
    for numbers in numbers.chunks(NUMBERS_A_QUESTION) {
        // The statement contains only numbers, no text from outside.
        let list: Vec<String> = numbers.iter().map(i64::to_string).collect();
        let sql = sqlx::AssertSqlSafe(format!("{sql}({})", list.join(", ")));
        let rows: Vec<(i64, i64)> =
            on!(&mut *link, |link| sqlx::query_as(sql).persistent(false).fetch_all(&mut *link).await)
                .map_err(failed("find the owners of rows"))?;
        found.extend(rows);
    }
    Ok(found)
}

async fn commands(link: &mut Link, commands: &[String]) -> Result<HashMap<String, i64>, StoreError> {
    const SQL: &str = "SELECT robot_id FROM setpoints WHERE command_id = $1";
    let mut found = HashMap::new();
    for command_id in commands {
        let robot_id: Option<i64> =
            on!(&mut *link, |link| sqlx::query_scalar(SQL).bind(command_id).fetch_optional(&mut *link).await)
                .map_err(failed("find the robot of a setpoint"))?;
        if let Some(robot_id) = robot_id {
            found.insert(command_id.clone(), robot_id);
        }
    }
    Ok(found)
}
