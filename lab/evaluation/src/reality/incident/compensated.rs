//! The compensation of a whisker that was cut: its readings, and its errors as predicted, measured and true.

use vibrissa_core::mechanics::CONTACT_RATIOS;
use vibrissa_core::robot::Compensation;

use super::{Case, Trial};
use crate::reality::row::Incident;
use crate::reality::truth::Reference;
use crate::reality::whisker::Whisker;

/// Rounds of contacts from the first setpoint to the first look at readings and errors.
pub(super) const SOON_ROUNDS: u64 = 300;

/// Measured, predicted and true error of a compensation at one time, as ratios.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Compensated {
    /// Prediction of the decision, its 95 % interval, and the truth at the pressure that was decided.
    pub predicted: (f64, (f64, f64), f64),
    /// Last measurement, with its standard deviation.
    pub measured: Option<(f64, f64)>,
    /// Truth at the pressure that is held.
    pub truth: f64,
    /// Mean error of the readings with the last published gain.
    pub reading: Option<f64>,
}

/// Predicted error of a compensation, at the decision of the core.
#[derive(Clone, Copy)]
pub(super) struct Prediction {
    pub compensator: usize,
    pub error: f64,
    pub interval: (f64, f64),
    /// The true error at the time of the decision.
    pub truth: f64,
    pub reference: Reference,
}

impl Trial {
    /// The compensation of a case that is in force, and its prediction.
    fn in_force(&self, case: &Case) -> Option<(&Compensation, Prediction)> {
        let all = self.robot.core.compensations();
        let running = all.iter().find(|one| one.target() == case.whisker && !one.is_proposed())?;
        let decided = case.predicted.filter(|made| running.compensator() == made.compensator)?;
        Some((running, decided))
    }

    /// The compensator of a compensation, and the pressure in MPa that its regulator aims at.
    fn server(&self, running: &Compensation) -> (&Whisker, f64) {
        let compensator = running.compensator();
        (&self.robot.whiskers[compensator], self.robot.air[compensator].target_mpa())
    }

    /// The compensation of a case, as it is in force now.
    pub(super) fn compensated(&self, case: &Case) -> Option<Compensated> {
        self.in_force(case).map(|(running, decided)| {
            let (one, held_mpa) = self.server(running);
            let measured = self.robot.core.error(&self.robot.params, running);
            // A worn whisker has lost more than at the decision.
            let is_worn = matches!(self.incident, Incident::Erosion(_));
            let reference = if is_worn { Reference::new(case.whole, one) } else { decided.reference };
            Compensated {
                predicted: (decided.error, decided.interval, decided.truth),
                measured: measured.map(|error| (error.mean, error.sd)),
                truth: reference.error(one, held_mpa, running.reading_gain().unwrap_or(1.0)),
                reading: case.gain.map(|gain| reference.reading_error(one, held_mpa, &gain)),
            }
        })
    }

    /// Mean error of the readings in the place of a whisker: of its compensator with the gain in force, else its own.
    pub(super) fn present_reading_error(&self, at: usize) -> f64 {
        let case = &self.cases[at];
        let running = self.robot.core.compensations().iter().find(|one| one.target() == case.whisker);
        let server = running.map_or(case.whisker, |one| one.compensator());
        let gain = case.gain.filter(|_| running.is_some()).unwrap_or([1.0; CONTACT_RATIOS.len()]);
        let (one, held_mpa) = (&self.robot.whiskers[server], self.robot.air[server].target_mpa());
        Reference::new(case.whole, one).reading_error(one, held_mpa, &gain)
    }
}
