//! Uploaded calibrations of whisker models.

use serde::Serialize;
use utoipa::ToSchema;

use super::sorts;
use crate::from_row::from_row;
use crate::list::List;
use crate::time::Time;

from_row! {
    /// An uploaded calibration of a whisker model.
    #[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
    #[schema(as = Calibration)]
    pub struct CalibrationRow {
        /// Number of the calibration.
        pub calibration_id: i64,
        /// Name of the whisker model, as factsheets use it.
        pub model: String,
        /// Version of the calibration, counted from 1 for each model.
        pub version: i64,
        /// Time of the upload, by the supervisor's clock.
        pub uploaded_at: Time,
        /// Person or token that uploaded it.
        pub uploaded_by: String,
        /// Names of the fleets in which it is active, among those visible to you, separated by commas; null if there
        /// is no such fleet.
        pub active_in: Option<String>,
    }

    /// Measurements, fit and parameters of a calibration, as JSON texts.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct CalibrationText {
        /// Name of the whisker model.
        pub model: String,
        /// Uploaded measurements, as JSON.
        pub measurements: String,
        /// Result of the fit (parameters with intervals, residuals), as JSON.
        pub fit: String,
        /// Calibration in the form of a calibration file, as JSON.
        pub calibration: String,
    }
}

sorts! {
    /// Sort keys of the list of calibrations.
    pub enum CalibrationSort {
        /// By number, which is the order of the uploads.
        CalibrationId = "calibration_id" Whole Down,
        /// By name of the model.
        Model = "model" Text Up,
    }
}

/// All uploaded calibrations.
pub static CALIBRATIONS: List = List {
    what: "list the calibrations",
    select: "SELECT c.calibration_id, c.model, version, uploaded_us AS uploaded_at, uploaded_by, \
             (SELECT string_agg(fleet, ',' ORDER BY fleet) FROM active_calibrations a \
              WHERE a.calibration_id = c.calibration_id) AS active_in FROM calibrations c",
    details: "",
    keys: &[],
    sorts: CalibrationSort::SORTS,
    id: "calibration_id",
};

/// Measurements, fits and parameters of all uploaded calibrations.
pub static CALIBRATION_TEXTS: List = List {
    what: "read a calibration",
    select: "SELECT calibration_id, model, measurements, fit, calibration FROM calibrations",
    details: "",
    keys: &[],
    sorts: CalibrationSort::SORTS,
    id: "calibration_id",
};
