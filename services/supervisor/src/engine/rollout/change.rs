//! The change of a roll-out, and the parameters that follow from it.

use std::sync::Arc;

use vibrissa_core::policy::PolicyParams;
use vibrissa_core::robot::Params;
use vibrissa_edge::actions::{self, Request, Subject};
use vibrissa_edge::calibration_file::Activation;

use super::malformed;
use crate::params::with_model;

/// The change of a roll-out.
#[derive(Debug, Clone)]
pub(in crate::engine) enum Change {
    Policy(PolicyParams),
    Calibration(Box<Activation>),
}

impl Change {
    /// Reads a change. The base is the policy in force, whose values stay where the change has none.
    pub(in crate::engine) fn read(kind: &str, json: &str, base: &Params) -> Result<Self, String> {
        match kind {
            "POLICY" => match actions::request("POLICY", json, Subject::default()) {
                Ok(Request::Policy(change)) => Ok(Self::Policy(change.over(base.policy))),
                Ok(Request::Operator(_)) => Err("MALFORMED: no policy".to_owned()),
                Err(problem) => Err(format!("MALFORMED: {problem}")),
            },
            _ => serde_json::from_str(json).map(|one| Self::Calibration(Box::new(one))).map_err(|one| malformed(&one)),
        }
    }

    /// The parameters of changed robots.
    pub(in crate::engine) fn over(&self, base: &Arc<Params>) -> Result<Arc<Params>, String> {
        match self {
            Self::Policy(policy) => Ok(Arc::new(Params { policy: *policy, ..(**base).clone() })),
            Self::Calibration(activation) => {
                with_model(base, &activation.calibration).map_err(|problem| format!("MALFORMED: {problem}"))
            }
        }
    }
}
