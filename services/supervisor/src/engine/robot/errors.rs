//! Measured compensation errors of one robot, for the metrics.

use std::collections::BTreeMap;

use vibrissa_core::robot::effect::CompensationError;
use vibrissa_core::robot::{Params, Robot};

/// Last measured compensation errors with and without the published gain, by number of the compensation.
#[derive(Debug, Default)]
pub(crate) struct MeasuredErrors(BTreeMap<u32, (f64, Option<f64>)>);

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
        self.0.insert(error.compensation, (error.mean, error.with_gain.map(|(mean, _)| mean)));
    }

    /// Last error of a compensation without the gain, and with it.
    pub(crate) fn get(&self, compensation: u32) -> Option<(f64, Option<f64>)> {
        self.0.get(&compensation).copied()
    }

    /// Forgets compensations that are not in force.
    pub(crate) fn retain(&mut self, is_in_force: impl Fn(u32) -> bool) {
        self.0.retain(|&compensation, _| is_in_force(compensation));
    }
}
