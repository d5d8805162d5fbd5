//! What operators ask: a mailbox to the fleets' owners, which is the record of it at the same time.
//!
//! [`Store::ask`] puts an action in, for whichever supervisor owns the fleet; its engine reads [`Writer::pending`], and its
//! answer is in the transaction that has the effects, so that an action is carried out once or not at all. What needs no
//! engine is recorded as done by `record_done`, in the transaction that does it.

use serde::Serialize;
use tokio::time::Duration;

use super::batch::PolicyRow;
use super::database::{Tx, on};
use super::readings::readings;
use super::{Lease, Store, StoreError, Writer, failed};

/// How long reading what is pending may take.
const PATIENCE: Duration = Duration::from_secs(5);

const COLUMNS: &str = "action_id, fleet, robot, \"array\", whisker, compensation_id, alarm_id, kind, parameters, reason, \
     actor, role, request_id, idempotency_key, asked_us, expires_us, state, problem, done_us";

/// What somebody asks for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NewAction {
    /// The fleet; none where no fleet is concerned.
    pub fleet: Option<String>,
    /// The robot, by name; none for a whole fleet.
    pub robot: Option<String>,
    /// The whisker's array; with `whisker` or not at all.
    pub array: Option<String>,
    /// The whisker's number.
    pub whisker: Option<i64>,
    /// The compensation, by its number in the database.
    pub compensation_id: Option<i64>,
    /// The alarm.
    pub alarm_id: Option<i64>,
    /// What, in the words of [`vibrissa_edge::actions`], or another word if no engine is needed.
    pub kind: String,
    /// A JSON object.
    pub parameters: String,
    /// Why, in the person's words.
    pub reason: Option<String>,
    /// Who asks.
    pub actor: String,
    /// In which role.
    pub role: String,
    /// The request that it came with.
    pub request_id: String,
    /// Names the action, for an actor that may send it again.
    pub idempotency_key: Option<String>,
    /// When, by the clock of the supervisor that was asked: microseconds since 1970 UTC.
    pub asked_us: i64,
    /// Not to be done from then on, by the clock of the supervisor that would do it.
    pub expires_us: i64,
}

/// What became of asking.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Asked {
    /// It is there now, under this number.
    New(i64),
    /// It was there already: the same actor has asked the same under the same key.
    Again(Action),
    /// The key names something else that the actor asked: nothing was asked now.
    Different(Action),
}

readings! {
    /// An action as it is recorded.
    #[derive(Debug, Clone, PartialEq, Eq, Serialize)]
    pub struct Action {
        /// Number, in the order of asking.
        pub action_id: i64,
        /// The fleet; none where no fleet is concerned.
        pub fleet: Option<String>,
        /// The robot.
        pub robot: Option<String>,
        /// The whisker's array.
        pub array: Option<String>,
        /// The whisker's number.
        pub whisker: Option<i64>,
        /// The compensation.
        pub compensation_id: Option<i64>,
        /// The alarm.
        pub alarm_id: Option<i64>,
        /// What.
        pub kind: String,
        /// A JSON object.
        pub parameters: String,
        /// Why, in the person's words.
        pub reason: Option<String>,
        /// Who asked.
        pub actor: String,
        /// In which role.
        pub role: String,
        /// The request that it came with.
        pub request_id: String,
        /// Its name among the actor's.
        pub idempotency_key: Option<String>,
        /// When it was asked.
        pub asked_us: i64,
        /// Not to be done from then on.
        pub expires_us: i64,
        /// `PENDING`, `DONE`, `REFUSED` or `EXPIRED`.
        pub state: String,
        /// Why it was refused: a word, a colon, and a text for people.
        pub problem: Option<String>,
        /// When it was answered.
        pub done_us: Option<i64>,
    }

    /// The policy in force that an operator has set.
    #[derive(Debug, Clone, PartialEq, Serialize)]
    pub struct PolicyReading {
        /// The fleet.
        pub fleet: String,
        /// Number, from 1.
        pub version: i64,
        /// `AUTOMATIC` or `ADVISE`.
        pub mode: String,
        /// `TIP` or `MEAN`.
        pub objective: String,
        /// `NEVER`, `LAST_RESORT` or `ALLOWED`.
        pub longer_for_shorter: String,
        /// Highest mean predicted error, as a ratio.
        pub predicted_error_max: f64,
        /// Cost of a neighbour's own role, in units of mean error.
        pub own_role_cost: f64,
        /// Gain that a change must have, in units of mean error.
        pub change_margin: f64,
        /// Since when.
        pub changed_us: i64,
        /// Who set it.
        pub changed_by: String,
        /// Why.
        pub reason: Option<String>,
        /// The action that asked for it.
        pub action_id: i64,
    }
}

impl Action {
    /// Whether it waits for an answer.
    #[must_use]
    pub fn is_pending(&self) -> bool {
        self.state == "PENDING"
    }

    /// Why it was refused: the word for programs, and the text for people.
    #[must_use]
    pub fn refusal(&self) -> Option<(&str, &str)> {
        let problem = self.problem.as_deref()?;
        Some(problem.split_once(": ").unwrap_or((problem, problem)))
    }

    /// Whether that is the same, whenever and in whichever request it is asked.
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

impl Store {
    /// Asks for something: it waits for the fleet's owner, at this supervisor or another one.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn ask(&self, action: &NewAction) -> Result<Asked, StoreError> {
        const WHAT: &str = "ask for an action";
        let mut tx = self.pool.begin().await.map_err(failed(WHAT))?;
        let asked = insert(&mut tx, action, "PENDING", None).await.map_err(failed(WHAT))?;
        tx.commit().await.map_err(failed(WHAT))?;
        Ok(asked)
    }

    /// An action, answered or not; none of that number.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn action(&self, action_id: i64) -> Result<Option<Action>, StoreError> {
        let sql = format!("SELECT {COLUMNS} FROM actions WHERE action_id = $1");
        on!(&self.pool, |pool| sqlx::query_as(sqlx::AssertSqlSafe(sql)).bind(action_id).fetch_optional(pool).await)
            .map_err(failed("read an action"))
    }

    /// The policy in force of a fleet; none if it is the configuration's.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn policy(&self, fleet: &str) -> Result<Option<PolicyReading>, StoreError> {
        on!(&self.pool, |pool| sqlx::query_as(POLICY).bind(fleet).fetch_optional(pool).await)
            .map_err(failed("read the policy"))
    }
}

const POLICY: &str = "SELECT fleet, version, mode, objective, longer_for_shorter, predicted_error_max, own_role_cost, \
     change_margin, changed_us, changed_by, reason, action_id FROM policies WHERE fleet = $1 ORDER BY version DESC LIMIT 1";

impl Writer {
    /// What waits for the fleet's owner, in order, at most so many.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn pending(&mut self, lease: &Lease, most: i64) -> Result<Vec<Action>, StoreError> {
        const WHAT: &str = "read what operators ask";
        // Not as a parameter: on its account SQLite would read the statement anew each time.
        let sql = format!(
            "SELECT {COLUMNS} FROM actions WHERE fleet = $1 AND state = 'PENDING' ORDER BY action_id LIMIT {most}"
        );
        let fleet = lease.fleet().as_str();
        self.attempt(WHAT, PATIENCE, async |link| {
            on!(link, |link| sqlx::query_as(sqlx::AssertSqlSafe(sql)).bind(fleet).fetch_all(link).await)
                .map_err(failed(WHAT))
        })
        .await
    }

    /// The policy in force of the lease's fleet; none if it is the configuration's.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn policy(&mut self, lease: &Lease) -> Result<Option<PolicyReading>, StoreError> {
        const WHAT: &str = "read the policy";
        let fleet = lease.fleet().as_str();
        self.attempt(WHAT, PATIENCE, async |link| {
            on!(link, |link| sqlx::query_as(POLICY).bind(fleet).fetch_optional(link).await).map_err(failed(WHAT))
        })
        .await
    }
}

/// Records an action that needs no engine as done, in the transaction that does it: unless it is [`Asked::New`], it was
/// done before, and nothing must be done now.
pub(super) async fn record_done(tx: &mut Tx<'_>, action: &NewAction, done_us: i64) -> Result<Asked, StoreError> {
    insert(tx, action, "DONE", Some(done_us)).await.map_err(failed("record an action"))
}

async fn insert(tx: &mut Tx<'_>, action: &NewAction, state: &str, done_us: Option<i64>) -> sqlx::Result<Asked> {
    const SQL: &str = "INSERT INTO actions (fleet, robot, \"array\", whisker, compensation_id, alarm_id, kind, parameters, \
         reason, actor, role, request_id, idempotency_key, asked_us, expires_us, state, done_us) \
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, $14, $15, $16, $17) \
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

/// What became of an action.
pub(super) async fn write_answer(
    tx: &mut Tx<'_>,
    (action_id, state, problem): (i64, &str, Option<&str>),
    done_us: i64,
) -> sqlx::Result<()> {
    on!(tx, |tx| sqlx::query("UPDATE actions SET state = $1, problem = $2, done_us = $3 WHERE action_id = $4")
        .bind(state)
        .bind(problem)
        .bind(done_us)
        .bind(action_id)
        .execute(&mut **tx)
        .await
        .map(drop))
}

/// A policy that is in force from now on.
pub(super) async fn write_policy(tx: &mut Tx<'_>, policy: &PolicyRow) -> sqlx::Result<()> {
    on!(tx, |tx| {
        sqlx::query(
        "INSERT INTO policies (fleet, version, mode, objective, longer_for_shorter, predicted_error_max, own_role_cost, \
         change_margin, changed_us, changed_by, reason, action_id) \
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12)",
    )
    .bind(&policy.fleet)
    .bind(policy.version)
    .bind(policy.mode)
    .bind(policy.objective)
    .bind(policy.longer_for_shorter)
    .bind(policy.predicted_error_max)
    .bind(policy.own_role_cost)
    .bind(policy.change_margin)
    .bind(policy.changed_us)
    .bind(&policy.changed_by)
    .bind(&policy.reason)
    .bind(policy.action_id)
    .execute(&mut **tx)
    .await
    .map(drop)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::DatabaseAddress;

    #[tokio::test]
    async fn what_needs_no_engine_is_recorded_as_done_once_and_with_what_it_does_or_not_at_all() {
        let name = uuid::Uuid::new_v5(&uuid::Uuid::NAMESPACE_OID, &vibrissa_edge::ids::start_seed());
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
            // Some of them may be gone already.
            let _ = std::fs::remove_file(format!("{}{end}", file.display()));
        }
    }
}
