//! True error of a compensation: that of the plant itself, without noise.

use vibrissa_core::mechanics::{ByRatio, CONTACT_RATIOS, ErrorProfile, Formulation, Model};
use vibrissa_core::units::{Megapascal, Millimetre};

use super::{Case, START_MPA, Trial, TrueError};

/// Number of steps in the search for the best single pressure: 0.25 kPa each up to 0.2 MPa, and 0.125 kPa each up to
/// 0.1 MPa, the limit of a whisker that serves itself.
const BRUTE_FORCE_STEPS: u32 = 800;

/// The plant of a trial with its reference sensitivities.
pub struct Truth {
    model: Model,
    case: Case,
    length_mm: f64,
    /// Sensitivities of the compensator at [`START_MPA`], per mm.
    before: ByRatio,
    /// Sensitivities of the uncut target at [`START_MPA`], per mm.
    target: ByRatio,
}

impl Truth {
    /// The plant of a trial.
    #[must_use]
    pub fn new(trial: &Trial) -> Self {
        let model =
            trial.rubber.model(&Model::nguyen_2021(Formulation::Consistent)).expect("factors that a scenario may have");
        let before = per_mm(&model, trial.length_mm, START_MPA);
        let target = per_mm(&model, trial.case.target_mm(), START_MPA);
        Self { model, case: trial.case, length_mm: trial.length_mm, before, target }
    }

    /// Eq. 35 at a pressure, with an optional gain on the compensator's strain.
    ///
    /// Strain is linear in the deflection, so the paper's deflections (0 to 6 mm in steps of 0.1 mm) cancel in the
    /// ratio.
    #[must_use]
    pub fn error(&self, pressure_mpa: f64, gain: Option<&[f64; CONTACT_RATIOS.len()]>) -> TrueError {
        ErrorProfile::new(&self.after(pressure_mpa, gain), &self.before, &self.target)
    }

    /// Mean of Eq. 35 at a pressure, with the single gain that makes this mean least on this plant.
    #[must_use]
    pub fn best_gain_error(&self, pressure_mpa: f64) -> f64 {
        let after = self.after(pressure_mpa, None);
        // Each error is an absolute value and linear in the gain on both sides of 0, so their mean is least where one
        // is 0.
        let gains = (0..CONTACT_RATIOS.len()).filter_map(|k| Some(self.target[k]? / after[k]?));
        gains
            .map(|gain| self.error(pressure_mpa, Some(&[gain; CONTACT_RATIOS.len()])).mean)
            .fold(f64::INFINITY, f64::min)
    }

    /// Sensitivities at a pressure, with an optional gain on the strain; per mm.
    #[must_use]
    pub fn after(&self, pressure_mpa: f64, gain: Option<&[f64; CONTACT_RATIOS.len()]>) -> ByRatio {
        let bare = per_mm(&self.model, self.length_mm, pressure_mpa);
        std::array::from_fn(|k| Some(bare[k]? * gain.map_or(1.0, |gain| gain[k])))
    }

    /// Sensitivities of the compensator before the compensation, and of the target; per mm.
    #[must_use]
    pub fn before_and_target(&self) -> (ByRatio, ByRatio) {
        (self.before, self.target)
    }

    /// Pressure with the least mean error if no gain is applied, MPa; found by brute force.
    #[must_use]
    pub fn best_mpa(&self) -> f64 {
        let highest_mpa = self.case.highest_mpa();
        let pressures =
            (0..=BRUTE_FORCE_STEPS).map(|step| highest_mpa * f64::from(step) / f64::from(BRUTE_FORCE_STEPS));
        let errors = pressures.map(|mpa| (mpa, self.error(mpa, None).mean));
        errors.min_by(|one, other| one.1.total_cmp(&other.1)).map_or(START_MPA, |best| best.0)
    }
}

fn per_mm(model: &Model, length_mm: f64, pressure_mpa: f64) -> ByRatio {
    let logs = model.log_sensitivities(Millimetre::known(length_mm), Megapascal::known(pressure_mpa));
    logs.map(|log| log.map(f64::exp))
}
