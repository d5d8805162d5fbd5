//! Calibrations that were uploaded, and those that fleets work with.

use super::actions::{Asked, NewAction, record_done};
use super::database::{Tx, on};
use super::readings::readings;
use super::{Lease, Store, StoreError, Writer, failed};
use borsh::{BorshDeserialize, BorshSerialize};
use tokio::time::Duration;

/// How long reading them may take.
const PATIENCE: Duration = Duration::from_secs(5);

/// A calibration to keep; all but the name is JSON.
#[derive(Debug, Clone)]
pub struct NewCalibration {
    /// The name that factsheets use for the model.
    pub model: String,
    /// What was measured.
    pub measurements: String,
    /// What came of it.
    pub fit: String,
    /// The numbers, as in a calibration file.
    pub calibration: String,
}

readings! {
    /// A calibration in force.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct ActiveCalibration {
        /// Number.
        pub calibration_id: i64,
        /// The numbers, as in a calibration file, in JSON.
        pub calibration: String,
    }
}

/// A calibration that is in force in a fleet from now on.
#[derive(Debug, Clone, BorshSerialize, BorshDeserialize)]
pub struct ActivationRow {
    /// Fleet.
    pub fleet: String,
    /// Model.
    pub model: String,
    /// Which.
    pub calibration_id: i64,
    /// Since when.
    pub activated_us: i64,
    /// Who asked for it.
    pub activated_by: String,
}

impl Store {
    /// The calibrations in force in a fleet.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn active_calibrations(&self, fleet: &str) -> Result<Vec<ActiveCalibration>, StoreError> {
        on!(&self.pool, |pool| sqlx::query_as(ACTIVE).bind(fleet).fetch_all(pool).await)
            .map_err(failed("read the calibrations in force"))
    }

    /// Keeps a calibration under the model's next version, with its entry in the audit log; its number. One that was kept
    /// under the same idempotency key before has the number that it got then.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn add_calibration(
        &self,
        new: &NewCalibration,
        action: &NewAction,
    ) -> Result<(Asked, Option<i64>), StoreError> {
        const WHAT: &str = "keep a calibration";
        const SQL: &str = "INSERT INTO calibrations (model, version, measurements, fit, calibration, uploaded_us, uploaded_by) \
             SELECT $1, COALESCE(max(version), 0) + 1, $2, $3, $4, $5, $6 FROM calibrations WHERE model = $1 \
             RETURNING calibration_id";
        let mut tx = self.pool.begin().await.map_err(failed(WHAT))?;
        let asked = record_done(&mut tx, action, action.asked_us).await?;
        let mut calibration_id = None;
        if let Asked::New(_) = asked {
            let id: i64 = on!(&mut tx, |tx| sqlx::query_scalar(SQL)
                .bind(&new.model)
                .bind(&new.measurements)
                .bind(&new.fit)
                .bind(&new.calibration)
                .bind(action.asked_us)
                .bind(&action.actor)
                .fetch_one(&mut **tx)
                .await)
            .map_err(failed(WHAT))?;
            calibration_id = Some(id);
        }
        tx.commit().await.map_err(failed(WHAT))?;
        Ok((asked, calibration_id))
    }
}

/// The calibrations in force in a fleet.
const ACTIVE: &str = "SELECT a.calibration_id, calibration FROM active_calibrations a \
     JOIN calibrations USING (calibration_id) WHERE fleet = $1 ORDER BY a.model";

impl Writer {
    /// The calibrations in force in the lease's fleet.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn calibrations(&mut self, lease: &Lease) -> Result<Vec<ActiveCalibration>, StoreError> {
        const WHAT: &str = "read the calibrations in force";
        let fleet = lease.fleet().as_str();
        self.attempt(WHAT, PATIENCE, async |link| {
            on!(link, |link| sqlx::query_as(ACTIVE).bind(fleet).fetch_all(link).await).map_err(failed(WHAT))
        })
        .await
    }
}

/// A calibration that is in force from now on.
pub(super) async fn write_activation(tx: &mut Tx<'_>, row: &ActivationRow) -> sqlx::Result<()> {
    on!(tx, |tx| sqlx::query(
        "INSERT INTO active_calibrations (fleet, model, calibration_id, activated_us, activated_by) \
         VALUES ($1, $2, $3, $4, $5) ON CONFLICT (fleet, model) DO UPDATE SET \
         calibration_id = excluded.calibration_id, activated_us = excluded.activated_us, \
         activated_by = excluded.activated_by",
    )
    .bind(&row.fleet)
    .bind(&row.model)
    .bind(row.calibration_id)
    .bind(row.activated_us)
    .bind(&row.activated_by)
    .execute(&mut **tx)
    .await
    .map(drop))
}
