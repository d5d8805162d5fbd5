//! Acknowledging, shelving and unshelving of many alarms in one transaction, with an entry in the audit log for each.

use std::collections::BTreeSet;

use super::actions::{Asked, NewAction, mark_many, record_done};
use super::alarms::Said;
use super::database::{Either, Tx, on};
use super::events::write::EventRow;
use super::list::{Filter, Selection};
use super::lists::alarms::{AlarmRow, AlarmSort, STANDING};
use super::{Store, StoreError, events, failed};
use vibrissa_edge::events::EventKind;

const WHAT: &str = "update alarms";

/// Most alarms that one request may change.
pub const AT_ONCE_MAX: u32 = 1000;

/// The alarms that a request concerns.
#[derive(Debug, Clone, PartialEq)]
pub struct Concerned {
    /// The alarms, the most urgent first, at most [`AT_ONCE_MAX`].
    pub alarms: Vec<AlarmRow>,
    /// Whether more alarms meet the conditions.
    pub more: bool,
}

/// Result of a request.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Done {
    /// The action that stands for the whole request.
    pub asked: Asked,
    /// Number of alarms that it changed.
    pub alarms: i64,
}

impl Said {
    /// The states of alarms to which it applies.
    fn states(self) -> &'static [&'static str] {
        match self {
            Self::Acknowledged => &["UNACKNOWLEDGED"],
            Self::Shelved { .. } => &["UNACKNOWLEDGED", "ACKNOWLEDGED"],
            Self::Unshelved => &["SHELVED"],
        }
    }
}

impl Store {
    /// The standing alarms that meet the filters and to which the decision applies.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn alarms_concerned(&self, filters: Vec<Filter>, said: Said) -> Result<Concerned, StoreError> {
        let sort = AlarmSort::Urgency.sort();
        let states = said.states().iter().map(|&state| state.to_owned()).collect();
        let selection = Selection { filters, sort, descending: true, after: None, limit: AT_ONCE_MAX }
            .with(Filter::IsOneOf("state", states));
        let rows = self.list::<AlarmRow>(&STANDING, &selection).await?;
        Ok(Concerned { more: rows.next.is_some(), alarms: rows.rows })
    }

    /// Applies a decision to these alarms at most once. `of_all` is the action that stands for the request, `of_each` the
    /// template of the action about each alarm. An alarm that has changed meanwhile is left out.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn say_to_alarms(
        &self,
        alarms: &[AlarmRow],
        said: Said,
        of_all: &NewAction,
        of_each: &NewAction,
    ) -> Result<Done, StoreError> {
        let now_us = of_all.asked_us;
        let mut tx = self.pool.begin().await.map_err(failed(WHAT))?;
        let asked = record_done(&mut tx, of_all, now_us).await?;
        let request_id = match &asked {
            Asked::New(parent_id) => {
                let ids = write(&mut tx, alarms, said, of_each).await.map_err(failed(WHAT))?;
                mark_many(&mut tx, *parent_id, ids.len() as i64).await.map_err(failed(WHAT))?;
                record(&mut tx, *parent_id, &ids, of_each).await.map_err(failed(WHAT))?;
                let is_changed = |one: &&AlarmRow| ids.contains(&one.alarm_id);
                let fleets: BTreeSet<&str> = alarms.iter().filter(is_changed).map(|one| one.fleet.as_str()).collect();
                for fleet in fleets {
                    let event = EventRow::new(EventKind::AlarmHandled, now_us);
                    events::write::write(&mut tx, fleet, &[event]).await.map_err(failed(WHAT))?;
                }
                &of_all.request_id
            }
            Asked::Again(action) | Asked::Different(action) => &action.request_id,
        };
        const COUNT: &str = "SELECT count(*) FROM actions WHERE request_id = $1 AND alarm_id IS NOT NULL";
        let alarms = on!(&mut tx, |tx| sqlx::query_scalar(COUNT).bind(request_id).fetch_one(&mut **tx).await)
            .map_err(failed(WHAT))?;
        tx.commit().await.map_err(failed(WHAT))?;
        Ok(Done { asked, alarms })
    }
}

/// A list of numbers for IN, which is empty only if no row may match.
fn among(ids: impl Iterator<Item = i64>) -> String {
    let ids: Vec<String> = ids.map(|id| id.to_string()).collect();
    if ids.is_empty() { "NULL".to_owned() } else { ids.join(", ") }
}

/// Returns the numbers of the alarms that were changed.
async fn write(tx: &mut Tx<'_>, alarms: &[AlarmRow], said: Said, action: &NewAction) -> sqlx::Result<BTreeSet<i64>> {
    let ids = among(alarms.iter().map(|one| one.alarm_id));
    let still = match said {
        Said::Acknowledged => format!("alarm_id IN ({ids}) AND cleared_us IS NULL AND acknowledged_us IS NULL"),
        Said::Shelved { .. } | Said::Unshelved => format!("alarm_id IN ({ids}) AND cleared_us IS NULL"),
    };
    // Others may change these alarms at the same time; SQLite has one writer.
    let lock = if matches!(tx, Either::Postgres(_)) { " FOR UPDATE" } else { "" };
    let sql = format!("SELECT alarm_id FROM alarms WHERE {still} ORDER BY alarm_id{lock}");
    let changed: Vec<i64> =
        on!(&mut *tx, |tx| sqlx::query_scalar(sqlx::AssertSqlSafe(sql)).fetch_all(&mut **tx).await)?;
    let ids = among(changed.iter().copied());
    match said {
        Said::Acknowledged => {
            let sql = format!(
                "UPDATE alarms SET acknowledged_us = $1, acknowledged_by = $2, acknowledged_reason = $3 \
                 WHERE alarm_id IN ({ids})"
            );
            on!(&mut *tx, |tx| sqlx::query(sqlx::AssertSqlSafe(sql))
                .bind(action.asked_us)
                .bind(&action.actor)
                .bind(&action.reason)
                .execute(&mut **tx)
                .await
                .map(drop))?;
        }
        Said::Shelved { until_us } => {
            let sql = format!(
                "INSERT INTO alarm_shelves (whisker_id, robot_id, kind, shelved_us, until_us, shelved_by, reason) \
                 SELECT whisker_id, robot_id, kind, $1, $2, $3, $4 FROM alarms WHERE alarm_id IN ({ids})"
            );
            on!(&mut *tx, |tx| sqlx::query(sqlx::AssertSqlSafe(sql))
                .bind(action.asked_us)
                .bind(until_us)
                .bind(&action.actor)
                .bind(action.reason.as_deref().unwrap_or_default())
                .execute(&mut **tx)
                .await
                .map(drop))?;
        }
        Said::Unshelved => {
            let sql = format!(
                "UPDATE alarm_shelves SET until_us = $1 WHERE until_us > $1 AND EXISTS (SELECT 1 FROM alarms a \
                 WHERE a.alarm_id IN ({ids}) AND a.kind = alarm_shelves.kind \
                 AND (a.whisker_id = alarm_shelves.whisker_id OR a.robot_id = alarm_shelves.robot_id))"
            );
            on!(&mut *tx, |tx| sqlx::query(sqlx::AssertSqlSafe(sql))
                .bind(action.asked_us)
                .execute(&mut **tx)
                .await
                .map(drop))?;
        }
    }
    Ok(changed.into_iter().collect())
}

/// Records an action about each alarm, as parts of the request's.
async fn record(tx: &mut Tx<'_>, parent_id: i64, ids: &BTreeSet<i64>, action: &NewAction) -> sqlx::Result<()> {
    let sql = format!(
        "INSERT INTO actions (fleet, robot, \"array\", whisker, alarm_id, kind, parameters, reason, actor, role, request_id, \
         asked_us, expires_us, state, done_us, parent_id) \
         SELECT r.fleet, r.robot, y.\"array\", w.whisker, a.alarm_id, $1, $2, $3, $4, $5, $6, $7, $8, 'DONE', $7, $9 \
         FROM alarms a LEFT JOIN whiskers w ON w.whisker_id = a.whisker_id LEFT JOIN arrays y ON y.array_id = w.array_id \
         JOIN robots r ON r.robot_id = coalesce(a.robot_id, w.robot_id) WHERE a.alarm_id IN ({}) ORDER BY a.alarm_id",
        among(ids.iter().copied())
    );
    on!(tx, |tx| sqlx::query(sqlx::AssertSqlSafe(sql))
        .bind(&action.kind)
        .bind(&action.parameters)
        .bind(&action.reason)
        .bind(&action.actor)
        .bind(&action.role)
        .bind(&action.request_id)
        .bind(action.asked_us)
        .bind(action.expires_us)
        .bind(parent_id)
        .execute(&mut **tx)
        .await
        .map(drop))
}
