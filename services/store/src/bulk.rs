//! Bulk actions on robots, whiskers or fleets: one entry of the audit log stands for the request, and each subject has an
//! action of its own, which the owner of its fleet executes like any other.

use serde::Serialize;
use utoipa::ToSchema;

pub use super::actions::ChildAction;
use super::actions::{Asked, NewAction, insert_child, mark_many, record_done};
use super::database::on;
use super::events::write::EventRow;
use super::from_row::from_row;
use super::{Store, StoreError, events, failed};
use vibrissa_edge::events::EventKind;

/// Most actions of requests for many that may wait at a time.
pub const WAITING_MAX: i64 = 2000;
/// Most different reasons that [`Store::bulk_refusals`] returns.
pub const REFUSALS_MAX: i64 = 20;

/// Result of a request for many.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum BulkAsked {
    /// Recorded, now or by the same request before.
    Done(Box<Asked>),
    /// So many actions wait already that these would be too many. Nothing was recorded.
    TooMany(i64),
}

from_row! {
    /// Number of subjects that were refused for the same reason.
    #[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
    pub struct Refusals {
        /// Why they were refused: a code, a colon, and an explanation.
        pub problem: String,
        /// Number of subjects.
        #[schema(minimum = 1)]
        pub subjects: i64,
    }
}

impl Store {
    /// Records a request for many, with an action for each subject, at most once.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn ask_many(&self, parent: &NewAction, children: &[ChildAction]) -> Result<BulkAsked, StoreError> {
        const WHAT: &str = "request bulk actions";
        const WAITING: &str = "SELECT count(*) FROM actions WHERE state = 'PENDING' AND parent_id IS NOT NULL \
             AND expires_us > $1";
        let mut tx = self.pool.begin().await.map_err(failed(WHAT))?;
        let asked = record_done(&mut tx, parent, parent.asked_us).await?;
        if let Asked::New(parent_id) = asked {
            let waiting: i64 =
                on!(&mut tx, |tx| sqlx::query_scalar(WAITING).bind(parent.asked_us).fetch_one(&mut **tx).await)
                    .map_err(failed(WHAT))?;
            if waiting > 0 && waiting + children.len() as i64 > WAITING_MAX {
                tx.rollback().await.map_err(failed(WHAT))?;
                return Ok(BulkAsked::TooMany(waiting));
            }
            mark_many(&mut tx, parent_id, children.len() as i64).await.map_err(failed(WHAT))?;
            for child in children {
                insert_child(&mut tx, parent_id, child).await.map_err(failed(WHAT))?;
            }
        }
        tx.commit().await.map_err(failed(WHAT))?;
        Ok(BulkAsked::Done(Box::new(asked)))
    }

    /// Withdraws the actions of a request for many that are still pending, at most once, and records that. Returns their
    /// number. An action that its owner executes at this moment is done after all, and its answer then says so.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn stop_bulk(
        &self,
        parent_id: i64,
        fleets: &[String],
        action: &NewAction,
    ) -> Result<(Asked, i64), StoreError> {
        const WHAT: &str = "stop bulk actions";
        const SQL: &str = "UPDATE actions SET state = 'REFUSED', problem = $1, done_us = $2 \
             WHERE parent_id = $3 AND state = 'PENDING'";
        let now_us = action.asked_us;
        let mut tx = self.pool.begin().await.map_err(failed(WHAT))?;
        let asked = record_done(&mut tx, action, now_us).await?;
        let mut stopped = 0;
        if let Asked::New(_) = asked {
            stopped = on!(&mut tx, |tx| sqlx::query(SQL)
                .bind(format!("STOPPED: {} stopped the rest", action.actor))
                .bind(now_us)
                .bind(parent_id)
                .execute(&mut **tx)
                .await
                .map(|done| done.rows_affected() as i64))
            .map_err(failed(WHAT))?;
            for fleet in fleets {
                let event = EventRow::new(EventKind::Action, now_us);
                events::write::write(&mut tx, fleet, &[event]).await.map_err(failed(WHAT))?;
            }
        }
        tx.commit().await.map_err(failed(WHAT))?;
        Ok((asked, stopped))
    }

    /// The fleets of a request for many.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn bulk_fleets(&self, parent_id: i64) -> Result<Vec<String>, StoreError> {
        const SQL: &str =
            "SELECT DISTINCT fleet FROM actions WHERE parent_id = $1 AND fleet IS NOT NULL ORDER BY fleet";
        on!(&self.pool, |pool| sqlx::query_scalar(SQL).bind(parent_id).fetch_all(pool).await)
            .map_err(failed("read the fleets of bulk actions"))
    }

    /// Why subjects of a request for many were refused, the most frequent reason first.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn bulk_refusals(&self, parent_id: i64) -> Result<Vec<Refusals>, StoreError> {
        let sql = format!(
            "SELECT coalesce(problem, 'UNKNOWN: no reason is known') AS problem, count(*) AS subjects FROM actions \
             WHERE parent_id = $1 AND state = 'REFUSED' GROUP BY problem ORDER BY subjects DESC, problem \
             LIMIT {REFUSALS_MAX}"
        );
        on!(&self.pool, |pool| sqlx::query_as(sqlx::AssertSqlSafe(sql)).bind(parent_id).fetch_all(pool).await)
            .map_err(failed("read the refusals of bulk actions"))
    }
}
