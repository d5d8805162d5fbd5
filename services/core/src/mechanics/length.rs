//! Length from sensitivity, and the lengths for which the model is valid.

use super::model::Model;
use super::morphology::Morphology;
use super::root;
use crate::units::{ContactRatio, Millimetre};

/// Usable share of the body's cone: beyond it the tip would be thinner than a hundredth of D3.
const USABLE_SHARE_OF_CONE: f64 = 0.99;
/// Least distance of a length from a limit, in mm.
const BEYOND_MM: f64 = 1e-6;
/// Tolerance of a solved length, in mm.
const LENGTH_TOLERANCE_MM: f64 = 1e-10;

/// The remaining whisker does not reach beyond its chamber: the air escapes and the model is invalid.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("a whisker of {length_mm} mm is cut into its chamber, which ends at {chamber_end_mm} mm")]
pub struct CutIntoChamber {
    /// The remaining length, in mm.
    pub length_mm: f64,
    /// l: where the chamber ends at zero pressure, in mm.
    pub chamber_end_mm: f64,
}

/// Why no length gives a sensitivity.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum LengthError {
    /// The sensitivity is not a positive number.
    #[error("a sensitivity must be above 0 per mm, not {per_mm}")]
    NotPositive {
        /// The given sensitivity, in 1/mm.
        per_mm: f64,
    },
    /// More sensitive than the shortest whisker that has this contact ratio beyond its chamber.
    #[error("more sensitive than any whisker with a contact beyond its chamber: the shortest is {} mm", nearest.mm())]
    ShorterThanChamber {
        /// The shortest length of the model.
        nearest: Millimetre,
    },
    /// Less sensitive than the longest whisker that the cone allows.
    #[error("less sensitive than the longest whisker of this cone, {} mm", nearest.mm())]
    LongerThanCone {
        /// The longest length of the model.
        nearest: Millimetre,
    },
    /// At this contact ratio the contact lies on the chamber even of the longest whisker.
    #[error("at this contact ratio the contact lies on the chamber even of the longest whisker, {} mm", nearest.mm())]
    RatioOnChamber {
        /// The longest length of the model.
        nearest: Millimetre,
    },
}

impl LengthError {
    /// Length with the nearest sensitivity; `None` if the sensitivity is not positive.
    #[must_use]
    pub fn nearest(&self) -> Option<Millimetre> {
        match self {
            Self::NotPositive { .. } => None,
            Self::ShorterThanChamber { nearest }
            | Self::LongerThanCone { nearest }
            | Self::RatioOnChamber { nearest } => Some(*nearest),
        }
    }
}

impl Model {
    /// Checks that the whisker is not cut into its chamber: its remaining length must exceed l.
    ///
    /// # Errors
    /// The whisker is cut into its chamber.
    pub fn check_length(&self, length: Millimetre) -> Result<(), CutIntoChamber> {
        let chamber_end_mm = self.geometry().l_mm;
        if length.mm() > chamber_end_mm {
            Ok(())
        } else {
            Err(CutIntoChamber { length_mm: length.mm(), chamber_end_mm })
        }
    }

    /// Longest whisker for which the model is valid: 0.99 of its cone, at most 1000 mm. Toward the apex the
    /// sensitivity of the tip would fall to zero.
    #[must_use]
    pub fn longest(&self) -> Millimetre {
        Millimetre::known(self.longest_mm().min(1000.0))
    }

    /// Length La with the given sensitivity at a contact ratio, to 1e-10 mm: the inverse of
    /// [`Model::sensitivity_per_mm`].
    ///
    /// The sensitivity falls with the contact distance, so there is at most one solution.
    ///
    /// # Errors
    /// No length of the model has this sensitivity; [`LengthError::nearest`] has the nearest one.
    pub fn length_from_sensitivity(
        &self,
        sensitivity_per_mm: f64,
        ratio: ContactRatio,
        morphology: &Morphology,
    ) -> Result<Millimetre, LengthError> {
        if !(sensitivity_per_mm.is_finite() && sensitivity_per_mm > 0.0) {
            return Err(LengthError::NotPositive { per_mm: sensitivity_per_mm });
        }
        let longest = self.longest();
        let on_chamber_mm = morphology.chamber_end_mm / ratio.a() - morphology.elongation_mm;
        let shortest_mm = on_chamber_mm.max(self.geometry().l_mm) + BEYOND_MM;
        if shortest_mm >= longest.mm() {
            return Err(LengthError::RatioOnChamber { nearest: longest });
        }
        // In logarithms the curve is nearly straight, so that few steps suffice.
        let excess = |length_mm: f64| {
            let contact_mm = ratio.a() * (length_mm + morphology.elongation_mm);
            (self.sensitivity_at_per_mm(contact_mm, morphology) / sensitivity_per_mm).ln()
        };
        let (at_shortest, at_longest) = (excess(shortest_mm), excess(longest.mm()));
        if at_shortest < 0.0 {
            return Err(LengthError::ShorterThanChamber { nearest: Millimetre::known(shortest_mm) });
        }
        if at_longest > 0.0 {
            return Err(LengthError::LongerThanCone { nearest: longest });
        }
        let ends = ((shortest_mm, at_shortest), (longest.mm(), at_longest));
        Ok(Millimetre::known(root::root(ends.0, ends.1, LENGTH_TOLERANCE_MM, excess)))
    }

    pub(super) fn longest_mm(&self) -> f64 {
        self.geometry().l_mm + USABLE_SHARE_OF_CONE * self.geometry().l3_mm
    }
}
