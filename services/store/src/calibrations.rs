//! Uploaded calibrations, and those that are active in fleets.

use super::actions::{Asked, NewAction, record_done};
use super::database::{Tx, on};
use super::from_row::from_row;
use super::set_aside::Tried;
use super::{Lease, Model, Store, StoreError, Writer, failed};
use tokio::time::Duration;

/// Time limit for reading the active calibrations.
const PATIENCE: Duration = Duration::from_secs(5);

/// A calibration to store; all fields but the name are JSON.
#[derive(Debug, Clone)]
pub struct NewCalibration {
    /// Name of the whisker model, as factsheets use it.
    pub model: String,
    /// Measurements as uploaded.
    pub measurements: String,
    /// Result of the fit: parameters with intervals, and residuals.
    pub fit: String,
    /// Calibration in the form of a calibration file.
    pub calibration: String,
}

from_row! {
    /// A calibration that is active in a fleet.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct ActiveCalibration {
        /// Number of the calibration.
        pub calibration_id: i64,
        /// Calibration in the form of a calibration file, as JSON.
        pub calibration: String,
    }
}

/// The activation of a calibration in a fleet.
#[derive(Debug, Clone)]
pub struct ActivationRow {
    /// Name of the fleet.
    pub fleet: String,
    /// Name of the whisker model.
    pub model: String,
    /// Number of the calibration.
    pub calibration_id: i64,
    /// Time of the activation, µs since 1970 UTC by the supervisor's clock.
    pub activated_us: i64,
    /// Person or token that requested it.
    pub activated_by: String,
}

impl Store {
    /// The calibrations that are active in a fleet.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn active_calibrations(&self, fleet: &str) -> Result<Vec<ActiveCalibration>, StoreError> {
        let rows: Vec<Tried<ActiveCalibration>> =
            on!(&self.pool, |pool| sqlx::query_as(ACTIVE).bind(fleet).fetch_all(pool).await)
                .map_err(failed("read the active calibrations"))?;
        Ok(self.set_aside.readable("calibrations", rows))
    }

    /// Stores a calibration under the model's next version, and records the action in the audit log. Returns the record
    /// of the action, and the calibration's number: `None` if the idempotency key was used before, so nothing was
    /// stored.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn add_calibration(
        &self,
        new: &NewCalibration,
        action: &NewAction,
    ) -> Result<(Asked, Option<i64>), StoreError> {
        const WHAT: &str = "store a calibration";
        const SQL: &str = "INSERT INTO calibrations (model, version, measurements, fit, calibration, uploaded_us, uploaded_by) \
             SELECT $1, COALESCE(max(version), 0) + 1, $2, $3, $4, $5, $6 FROM calibrations WHERE model = $1 \
             ON CONFLICT (model, version) DO NOTHING RETURNING calibration_id";
        let mut tx = self.pool.begin().await.map_err(failed(WHAT))?;
        let asked = record_done(&mut tx, action, action.asked_us).await?;
        let mut calibration_id = None;
        if let Asked::New(_) = asked {
            // Somebody else may take the version at the same time.
            while calibration_id.is_none() {
                calibration_id = on!(&mut tx, |tx| sqlx::query_scalar(SQL)
                    .bind(&new.model)
                    .bind(&new.measurements)
                    .bind(&new.fit)
                    .bind(&new.calibration)
                    .bind(action.asked_us)
                    .bind(&action.actor)
                    .fetch_optional(&mut **tx)
                    .await)
                .map_err(failed(WHAT))?;
            }
        }
        tx.commit().await.map_err(failed(WHAT))?;
        Ok((asked, calibration_id))
    }
}

/// Query for the calibrations that are active in a fleet.
const ACTIVE: &str = "SELECT a.calibration_id, calibration FROM active_calibrations a \
     JOIN calibrations USING (calibration_id) WHERE fleet = $1 ORDER BY a.model";

impl Writer {
    /// The calibrations that are active in the lease's fleet.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn calibrations(&mut self, lease: &Lease) -> Result<Vec<ActiveCalibration>, StoreError> {
        const WHAT: &str = "read the active calibrations";
        let fleet = lease.fleet().as_str();
        let model = |model: &mut dyn Model| Ok(model.calibrations(lease).into_iter().map(Tried::Read).collect());
        let rows: Vec<Tried<ActiveCalibration>> = self
            .attempt(WHAT, PATIENCE, model, async |link| {
                on!(link, |link| sqlx::query_as(ACTIVE).bind(fleet).fetch_all(link).await).map_err(failed(WHAT))
            })
            .await?;
        Ok(self.set_aside.readable("calibrations", rows))
    }
}

/// Activates a calibration in a fleet, in place of the one of the same model.
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
