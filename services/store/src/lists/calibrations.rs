//! Calibrations that were uploaded.

use serde::Serialize;
use utoipa::ToSchema;

use super::sorts;
use crate::list::List;
use crate::readings::readings;
use crate::time::Time;

readings! {
    /// A calibration of a whisker model.
    #[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
    #[schema(as = Calibration)]
    pub struct CalibrationRow {
        /// Number.
        pub calibration_id: i64,
        /// The name that factsheets use for the model.
        pub model: String,
        /// Counts from 1 for each model.
        pub version: i64,
        /// When it was uploaded.
        pub uploaded_at: Time,
        /// By whom.
        pub uploaded_by: String,
        /// Those of your fleets that work with it, separated by commas; null if none does.
        pub active_in: Option<String>,
    }

    /// What came of its measurements.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct CalibrationText {
        /// Model.
        pub model: String,
        /// What was measured, JSON.
        pub measurements: String,
        /// What came of it, JSON.
        pub fit: String,
        /// The numbers, JSON.
        pub calibration: String,
    }
}

sorts! {
    /// What a list of calibrations may be sorted by.
    pub enum CalibrationSort {
        /// The order of uploading.
        CalibrationId = "calibration_id" Whole Down,
        /// The model's name.
        Model = "model" Text Up,
    }
}

/// Calibrations that were uploaded.
pub static CALIBRATIONS: List = List {
    what: "list the calibrations",
    select: "SELECT c.calibration_id, c.model, version, uploaded_us AS uploaded_at, uploaded_by, \
             (SELECT string_agg(fleet, ',' ORDER BY fleet) FROM active_calibrations a \
              WHERE a.calibration_id = c.calibration_id) AS active_in FROM calibrations c",
    sorts: CalibrationSort::SORTS,
    id: "calibration_id",
};

/// What is in them.
pub static CALIBRATION_TEXTS: List = List {
    what: "read a calibration",
    select: "SELECT calibration_id, model, measurements, fit, calibration FROM calibrations",
    sorts: CalibrationSort::SORTS,
    id: "calibration_id",
};
