//! The `actions` table: requests of operators to the owners of fleets, which is also the audit log.
//!
//! [`Store::ask`] inserts an action for the supervisor that owns the fleet. The fleet's engine reads it with
//! [`Writer::pending`] and writes the answer in the transaction of its effects, so an action is carried out at most
//! once. An action that needs no engine is recorded as done by `record_done`, in the transaction of its effects.

use serde::Serialize;
use tokio::time::Duration;
use vibrissa_edge::clock::wall_clock;
use vibrissa_protocol::Name;

use super::database::{Tx, on};
use super::from_row::from_row;
use super::set_aside::Tried;
use super::{Lease, Model, Store, StoreError, Writer, failed};

/// Time limit for reading the pending actions.
const PATIENCE: Duration = Duration::from_secs(5);

const COLUMNS: &str = "action_id, fleet, robot, \"array\", whisker, compensation_id, alarm_id, kind, parameters, reason, \
     actor, role, request_id, idempotency_key, asked_us, expires_us, state, problem, done_us";

/// An action that a person requests.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NewAction {
    /// Name of the fleet; `None` if the action concerns no fleet.
    pub fleet: Option<String>,
    /// Name of the robot; `None` for a whole fleet.
    pub robot: Option<String>,
    /// Name of the whisker's array; `Some` exactly if `whisker` is.
    pub array: Option<String>,
    /// Number of the whisker in its array.
    pub whisker: Option<i64>,
    /// Number of the compensation in the database.
    pub compensation_id: Option<i64>,
    /// Number of the alarm in the database.
    pub alarm_id: Option<i64>,
    /// Kind of action: a word of [`vibrissa_edge::actions`], or another word if no engine is needed.
    pub kind: String,
    /// Parameters of the action: a JSON object.
    pub parameters: String,
    /// Reason that the person gave, as free text.
    pub reason: Option<String>,
    /// Person or token that requests the action.
    pub actor: String,
    /// Role in which the action is requested.
    pub role: String,
    /// Identifier of the HTTP request that carried the action.
    pub request_id: String,
    /// Key by which an actor may repeat the request without repeating the action.
    pub idempotency_key: Option<String>,
    /// Time of the request, µs since 1970 UTC by the clock of the supervisor that received it.
    pub asked_us: i64,
    /// Time from which on the action must not be carried out any more, µs since 1970 UTC by the owner's clock.
    pub expires_us: i64,
}

/// Result of inserting an action.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Asked {
    /// Inserted, with this number.
    New(i64),
    /// The same actor has requested the same action with the same idempotency key before.
    Again(Action),
    /// The same actor has used the key for a different action. Nothing was inserted.
    Different(Action),
}

from_row! {
    /// A row of the `actions` table.
    #[derive(Debug, Clone, PartialEq, Eq, Serialize)]
    pub struct Action {
        /// Number of the action; later requests have higher numbers.
        pub action_id: i64,
        /// Name of the fleet; `None` if the action concerns no fleet.
        pub fleet: Option<String>,
        /// Name of the robot; `None` for a whole fleet.
        pub robot: Option<String>,
        /// Name of the whisker's array.
        pub array: Option<String>,
        /// Number of the whisker in its array.
        pub whisker: Option<i64>,
        /// Number of the compensation.
        pub compensation_id: Option<i64>,
        /// Number of the alarm.
        pub alarm_id: Option<i64>,
        /// Kind of action: a word of [`vibrissa_edge::actions`], or another word if no engine was needed.
        pub kind: String,
        /// Parameters of the action: a JSON object.
        pub parameters: String,
        /// Reason that the person gave, as free text.
        pub reason: Option<String>,
        /// Person or token that requested the action.
        pub actor: String,
        /// Role in which the action was requested.
        pub role: String,
        /// Identifier of the HTTP request that carried the action.
        pub request_id: String,
        /// Idempotency key that the actor gave.
        pub idempotency_key: Option<String>,
        /// Time of the request, µs since 1970 UTC by the clock of the supervisor that received it.
        pub asked_us: i64,
        /// Time from which on the action must not be carried out any more, µs since 1970 UTC.
        pub expires_us: i64,
        /// State: `PENDING`, `DONE`, `REFUSED` or `EXPIRED`.
        pub state: String,
        /// Why it was refused: a code, a colon, and an explanation.
        pub problem: Option<String>,
        /// Time of the answer, µs since 1970 UTC; `None` while the action is pending.
        pub done_us: Option<i64>,
    }
}

/// Actions that wait for an answer.
#[derive(Debug, Default)]
pub struct Pending {
    /// The actions, in the order of their requests.
    pub actions: Vec<Action>,
    /// Numbers of those that cannot be read.
    pub unreadable: Vec<i64>,
}

impl Action {
    /// Whether the action waits for an answer.
    #[must_use]
    pub fn is_pending(&self) -> bool {
        self.state == "PENDING"
    }

    /// Why the action was refused: the code for programs, and the explanation for people.
    #[must_use]
    pub fn refusal(&self) -> Option<(&str, &str)> {
        let problem = self.problem.as_deref()?;
        Some(problem.split_once(": ").unwrap_or((problem, problem)))
    }

    /// Whether a request asks for the same action; time, expiry, actor and request are not compared.
    fn is(&self, asked: &NewAction) -> bool {
        self.fleet == asked.fleet
            && self.robot == asked.robot
            && self.array == asked.array
            && self.whisker == asked.whisker
            && self.compensation_id == asked.compensation_id
            && self.alarm_id == asked.alarm_id
            && self.kind == asked.kind
            && self.parameters == asked.parameters
            && self.reason == asked.reason
    }
}

from_row! {
    /// A fleet whose engines have something to read.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct FleetWork {
        /// Name of the fleet.
        pub fleet: String,
        /// Whether there are pending actions whose time has come.
        pub has_actions: bool,
        /// Version of the list of allowed robots; 0 without one.
        pub allowed_version: i64,
    }
}

impl Store {
    /// The fleets that have pending actions whose time has come at `now_us`, or a list of allowed robots.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn fleets_with_work(&self, now_us: i64) -> Result<Vec<FleetWork>, StoreError> {
        if let Some(model) = &self.model {
            return model.query("read the fleets with pending actions", |model| Ok(model.fleets_with_work())).await;
        }
        const SQL: &str = "SELECT fleet, max(pending) > 0 AS has_actions, max(version) AS allowed_version FROM (\
             SELECT fleet, 1 AS pending, CAST(0 AS BIGINT) AS version FROM actions \
             WHERE state = 'PENDING' AND not_before_us <= $1 AND fleet IS NOT NULL \
             UNION ALL SELECT fleet, 0, version FROM allowed_robots) w GROUP BY fleet";
        let rows: Vec<Tried<FleetWork>> =
            on!(&self.pool, |pool| sqlx::query_as(SQL).bind(now_us).fetch_all(pool).await)
                .map_err(failed("read the fleets with pending actions"))?;
        Ok(self.set_aside.readable("actions", rows))
    }

    /// Requests an action. It stays pending until the fleet's owner, here or at another supervisor, answers it.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn ask(&self, action: &NewAction) -> Result<Asked, StoreError> {
        const WHAT: &str = "request an action";
        let mut tx = self.pool.begin().await.map_err(failed(WHAT))?;
        let asked = insert(&mut tx, action, "PENDING", None, None).await.map_err(failed(WHAT))?;
        tx.commit().await.map_err(failed(WHAT))?;
        Ok(asked)
    }

    /// The action of this number, in whatever state; `None` if there is no such action.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn action(&self, action_id: i64) -> Result<Option<Action>, StoreError> {
        if let Some(model) = &self.model {
            return model.query("read an action", |model| Ok(model.action(action_id))).await;
        }
        let sql = format!("SELECT {COLUMNS} FROM actions WHERE action_id = $1");
        on!(&self.pool, |pool| sqlx::query_as(sqlx::AssertSqlSafe(sql)).bind(action_id).fetch_optional(pool).await)
            .map_err(failed("read an action"))
    }
}

impl Store {
    /// The action that an actor requested with an idempotency key; `None` if the key is new.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn action_of_key(&self, actor: &str, key: Option<&str>) -> Result<Option<Action>, StoreError> {
        let sql = format!("SELECT {COLUMNS} FROM actions WHERE actor = $1 AND idempotency_key = $2");
        on!(&self.pool, |pool| sqlx::query_as(sqlx::AssertSqlSafe(sql))
            .bind(actor)
            .bind(key)
            .fetch_optional(pool)
            .await)
        .map_err(failed("read an action"))
    }
}

impl Writer {
    /// At most `most` pending actions for the lease's fleet whose time has come, in the order of their requests; without those
    /// of some robots.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn pending(&mut self, lease: &Lease, most: i64, without: &[Name]) -> Result<Pending, StoreError> {
        const WHAT: &str = "read pending actions";
        // A name has no characters that end a text.
        let names: Vec<String> = without.iter().map(|name| format!("'{name}'")).collect();
        let of_others = match names.is_empty() {
            true => String::new(),
            false => format!("AND (robot IS NULL OR robot NOT IN ({})) ", names.join(", ")),
        };
        // The limit is not a parameter: with a parameter there, SQLite would prepare the statement anew each time.
        let sql = format!(
            "SELECT {COLUMNS} FROM actions WHERE fleet = $1 AND state = 'PENDING' AND not_before_us <= $2 {of_others}\
             ORDER BY action_id LIMIT {most}"
        );
        let (fleet, now_us) = (lease.fleet().as_str(), wall_clock().0 as i64);
        let model =
            |model: &mut dyn Model| Ok(model.pending(lease, most, without).into_iter().map(Tried::Read).collect());
        let rows: Vec<Tried<Action>> = self
            .attempt(WHAT, PATIENCE, model, async |link| {
                on!(link, |link| sqlx::query_as(sqlx::AssertSqlSafe(sql))
                    .bind(fleet)
                    .bind(now_us)
                    .fetch_all(link)
                    .await)
                .map_err(failed(WHAT))
            })
            .await?;
        let mut pending = Pending::default();
        for row in rows {
            match row {
                Tried::Read(action) => pending.actions.push(action),
                Tried::Unreadable(row) => {
                    self.set_aside.add("actions", &row);
                    pending.unreadable.extend(row.id);
                }
            }
        }
        Ok(pending)
    }
}

/// Records an action that needs no engine as done, in the transaction of its effects. Unless the result is
/// [`Asked::New`], the action was done before, and the caller must not repeat its effects.
pub(super) async fn record_done(tx: &mut Tx<'_>, action: &NewAction, done_us: i64) -> Result<Asked, StoreError> {
    insert(tx, action, "DONE", Some(done_us), None).await.map_err(failed("record an action"))
}

/// An action of a request for many.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChildAction {
    /// Action of the subject.
    pub action: NewAction,
    /// Time before which it must not be executed, µs since 1970 UTC by the owner's clock.
    pub not_before_us: i64,
}

/// Inserts an action of a request for many.
pub(super) async fn insert_child(tx: &mut Tx<'_>, parent_id: i64, child: &ChildAction) -> sqlx::Result<()> {
    insert(tx, &child.action, "PENDING", None, Some((parent_id, child.not_before_us))).await.map(drop)
}

/// Marks an action as the request for many.
pub(super) async fn mark_many(tx: &mut Tx<'_>, parent_id: i64, subjects: i64) -> sqlx::Result<()> {
    const SQL: &str = "UPDATE actions SET subjects = $1 WHERE action_id = $2";
    on!(tx, |tx| sqlx::query(SQL).bind(subjects).bind(parent_id).execute(&mut **tx).await.map(drop))
}

/// Inserts an action; one of a request for many has the request's number, and a time before which it is not executed.
async fn insert(
    tx: &mut Tx<'_>,
    action: &NewAction,
    state: &str,
    done_us: Option<i64>,
    of_many: Option<(i64, i64)>,
) -> sqlx::Result<Asked> {
    const SQL: &str = "INSERT INTO actions (fleet, robot, \"array\", whisker, compensation_id, alarm_id, kind, parameters, \
         reason, actor, role, request_id, idempotency_key, asked_us, expires_us, state, done_us, parent_id, not_before_us) \
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, $14, $15, $16, $17, $18, $19) \
         ON CONFLICT (actor, idempotency_key) DO NOTHING RETURNING action_id";
    let new: Option<i64> = on!(&mut *tx, |tx| sqlx::query_scalar(SQL)
        .bind(&action.fleet)
        .bind(&action.robot)
        .bind(&action.array)
        .bind(action.whisker)
        .bind(action.compensation_id)
        .bind(action.alarm_id)
        .bind(&action.kind)
        .bind(&action.parameters)
        .bind(&action.reason)
        .bind(&action.actor)
        .bind(&action.role)
        .bind(&action.request_id)
        .bind(&action.idempotency_key)
        .bind(action.asked_us)
        .bind(action.expires_us)
        .bind(state)
        .bind(done_us)
        .bind(of_many.map(|(parent_id, _)| parent_id))
        .bind(of_many.map_or(0, |(_, not_before_us)| not_before_us))
        .fetch_optional(&mut **tx)
        .await)?;
    if let Some(action_id) = new {
        return Ok(Asked::New(action_id));
    }
    let sql = format!("SELECT {COLUMNS} FROM actions WHERE actor = $1 AND idempotency_key = $2");
    let known: Action = on!(tx, |tx| sqlx::query_as(sqlx::AssertSqlSafe(sql))
        .bind(&action.actor)
        .bind(&action.idempotency_key)
        .fetch_one(&mut **tx)
        .await)?;
    Ok(if known.is(action) { Asked::Again(known) } else { Asked::Different(known) })
}

/// Writes the answer of an action.
pub(super) async fn write_answer(
    tx: &mut Tx<'_>,
    (action_id, state, problem): (i64, &str, Option<&str>),
    done_us: i64,
) -> sqlx::Result<()> {
    const SQL: &str = "UPDATE actions SET state = $1, problem = $2, done_us = $3 WHERE action_id = $4";
    on!(tx, |tx| sqlx::query(SQL)
        .bind(state)
        .bind(problem)
        .bind(done_us)
        .bind(action_id)
        .execute(&mut **tx)
        .await
        .map(drop))
}

/// Names the touch test that an action requested.
pub(super) async fn write_test(tx: &mut Tx<'_>, action_id: i64, test_id: &str) -> sqlx::Result<()> {
    const SQL: &str = "UPDATE actions SET test_id = $1 WHERE action_id = $2";
    on!(tx, |tx| sqlx::query(SQL).bind(test_id).bind(action_id).execute(&mut **tx).await.map(drop))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::DatabaseAddress;

    #[tokio::test]
    async fn what_needs_no_engine_is_recorded_as_done_once_and_with_what_it_does_or_not_at_all() {
        let name = vibrissa_host::random::hex();
        let file = std::env::temp_dir().join(format!("vibrissa-actions-{name}.sqlite3"));
        let store = Store::open(&DatabaseAddress::Sqlite(file.clone()), "test").await.unwrap();
        store.prepare().await.unwrap();
        let action = NewAction {
            fleet: None,
            robot: None,
            array: None,
            whisker: None,
            compensation_id: None,
            alarm_id: Some(3),
            kind: "ACKNOWLEDGE".to_owned(),
            parameters: "{}".to_owned(),
            reason: None,
            actor: "ann".to_owned(),
            role: "OPERATOR".to_owned(),
            request_id: "q".to_owned(),
            idempotency_key: Some("k".to_owned()),
            asked_us: 5,
            expires_us: 9,
        };
        let mut given_up = store.pool.begin().await.unwrap();
        assert!(matches!(record_done(&mut given_up, &action, 6).await.unwrap(), Asked::New(_)));
        drop(given_up);
        let mut tx = store.pool.begin().await.unwrap();
        let Asked::New(action_id) = record_done(&mut tx, &action, 7).await.unwrap() else { panic!("new") };
        tx.commit().await.unwrap();
        let known = store.action(action_id).await.unwrap().unwrap();
        assert_eq!((known.state.as_str(), known.done_us, known.alarm_id), ("DONE", Some(7), Some(3)));
        let mut tx = store.pool.begin().await.unwrap();
        assert_eq!(record_done(&mut tx, &action, 8).await.unwrap(), Asked::Again(known));
        drop(tx);
        store.close().await;
        for end in ["", "-wal", "-shm", ".lock"] {
            // Some of these files may not exist.
            let _ = std::fs::remove_file(format!("{}{end}", file.display()));
        }
    }
}
