//! The strain of a true whisker: by the core's mechanics with other parameters, or by an elastica.

use vibrissa_core::mechanics::{ByRatio, CONTACT_RATIOS, Model, Morphology};
use vibrissa_core::units::{ContactRatio, Megapascal, Millimetre};

use super::elastica::{Bending, Nature, Place};
use super::nuisances::Nuisances;

/// How the gauge of a whisker answers to contacts.
#[derive(Debug)]
pub(super) enum Mechanics {
    /// As the core computes it.
    Core {
        model: Box<Model>,
        /// Chamber at the pressure of the last contact: pressures seldom change.
        morphology: Box<Morphology>,
    },
    /// As the equations of an elastica say.
    Elastica(Box<Bending>),
}

impl Mechanics {
    pub(super) fn new(model: Model, nominal_mpa: f64, nuisances: &Nuisances) -> Self {
        if nuisances.elastica {
            let (geometry, calibration) = (*model.geometry(), *model.calibration());
            let nature = Nature { friction: nuisances.friction, by_volume: nuisances.wall_by_volume };
            Self::Elastica(Box::new(Bending::new(geometry, calibration, nature)))
        } else {
            let morphology = Box::new(model.morphology(Megapascal::known(nominal_mpa)));
            Self::Core { model: Box::new(model), morphology }
        }
    }

    /// Strain per mm of a deflection in mm, 1/mm, and where the object returns; `None` on the chamber.
    pub(super) fn per_mm(&mut self, place: Place, deflection_mm: f64, returns: bool) -> Option<f64> {
        match self {
            Self::Core { model, morphology } => {
                if morphology.pressure.mpa() != place.pressure_mpa {
                    **morphology = model.morphology(Megapascal::known(place.pressure_mpa.clamp(0.0, 1.0)));
                }
                let (ratio, length) = (ContactRatio::known(place.ratio), Millimetre::known(place.length_mm));
                model.sensitivity_per_mm(ratio, length, morphology).ok()
            }
            Self::Elastica(bending) => bending.per_mm(place, deflection_mm, returns),
        }
    }

    /// Log of the strain per mm by contact ratio, for a length and a pressure: the mean over these deflections.
    pub(super) fn log_per_mm(&self, length_mm: f64, pressure_mpa: f64, deflections_mm: (f64, f64)) -> ByRatio {
        match self {
            Self::Core { model, .. } => {
                model.log_sensitivities(Millimetre::known(length_mm), Megapascal::known(pressure_mpa))
            }
            Self::Elastica(bending) => CONTACT_RATIOS
                .map(|ratio| bending.mean_log_per_mm(Place { ratio, length_mm, pressure_mpa }, deflections_mm)),
        }
    }
}
