//! Parameters in force: those of the configuration, overridden by the calibrations and the policy that operators have
//! set.

use std::sync::Arc;

use tracing::error;
use vibrissa_core::mechanics::{Formulation, Model};
use vibrissa_core::robot::Params;
use vibrissa_protocol::plain;

use vibrissa_edge::calibration_file::CalibrationFile;
use vibrissa_store::calibrations::ActiveCalibration;
use vibrissa_store::policies::PolicyReading;

/// The parameters with the calibration of a model replaced or added.
pub(crate) fn with_model(params: &Params, file: &CalibrationFile) -> Result<Arc<Params>, String> {
    let formulation = params.models.first().map_or_else(Formulation::default, |(_, model)| model.formulation());
    let model = Model::new(file.geometry(), file.calibration(), formulation).map_err(|problem| problem.to_string())?;
    let mut params = params.clone();
    match params.models.iter_mut().find(|(name, _)| **name == file.name) {
        Some((_, known)) => *known = model,
        None => params.models.push((Arc::new(file.name.clone()), model)),
    }
    Ok(Arc::new(params))
}

/// The parameters with the calibrations that are active in the fleet, and the number of those that cannot be used.
pub(crate) fn with_calibrations(params: Arc<Params>, active: &[ActiveCalibration]) -> (Arc<Params>, u64) {
    let mut unusable = 0;
    let params = active.iter().fold(params, |params, one| {
        let read = serde_json::from_str(&one.calibration).map_err(|problem| plain::data(&problem.to_string()));
        read.and_then(|file| with_model(&params, &file)).unwrap_or_else(|problem| {
            error!(
                calibration = one.calibration_id,
                problem, "cannot use an active calibration, using the one of the configuration"
            );
            unusable += 1;
            params
        })
    });
    (params, unusable)
}

/// The parameters with the policy that an operator has set, if there is one.
pub(crate) fn with_policy(params: Arc<Params>, set: Option<&PolicyReading>) -> Arc<Params> {
    let Some(set) = set else { return params };
    let Some(policy) = set.params() else {
        error!(
            fleet = set.fleet,
            version = set.version,
            "unknown words in a policy, using the one of the configuration"
        );
        return params;
    };
    Arc::new(Params { policy, ..(*params).clone() })
}
