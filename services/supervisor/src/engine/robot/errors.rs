//! Measured compensation errors of one robot, for the metrics.

use std::collections::BTreeMap;

use vibrissa_core::robot::effect::CompensationError;
use vibrissa_core::robot::{Params, Robot};

/// Last measured errors of a compensation (Eq. 35), as ratios.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MeasuredError {
    /// Error of the reading.
    pub(crate) reading: f64,
    /// Error with the published gain.
    pub(crate) with_gain: Option<f64>,
    /// Error of the air alone, where the robot applies a gain.
    pub(crate) air_alone: Option<f64>,
}

/// Last measured errors by number of the compensation.
#[derive(Debug, Default)]
pub(crate) struct MeasuredErrors(BTreeMap<u32, MeasuredError>);

impl MeasuredErrors {
    /// Restores the errors from the state of a loaded robot.
    pub(crate) fn of(robot: &Robot, params: &Params) -> Self {
        let mut errors = Self::default();
        for error in robot.compensations().iter().filter_map(|one| robot.error(params, one)) {
            errors.measured(&error);
        }
        errors
    }

    /// Adds a measurement, which replaces earlier ones of its compensation.
    pub(crate) fn measured(&mut self, error: &CompensationError) {
        let mean = |one: Option<(f64, f64)>| one.map(|(mean, _)| mean);
        let measured =
            MeasuredError { reading: error.mean, with_gain: mean(error.with_gain), air_alone: mean(error.air_alone) };
        self.0.insert(error.compensation, measured);
    }

    /// Last errors of a compensation.
    pub(crate) fn get(&self, compensation: u32) -> Option<MeasuredError> {
        self.0.get(&compensation).copied()
    }

    /// Forgets compensations that are not in force.
    pub(crate) fn retain(&mut self, is_in_force: impl Fn(u32) -> bool) {
        self.0.retain(|&compensation, _| is_in_force(compensation));
    }
}
