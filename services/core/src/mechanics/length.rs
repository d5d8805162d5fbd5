//! From a sensitivity back to the length, and which lengths the model holds for.

use super::model::Model;
use super::morphology::Morphology;
use super::root;
use crate::units::{ContactRatio, Millimetre};

/// The cone's last hundredth is no whisker: its tip would be thinner than a hundredth of D3.
const USABLE_SHARE_OF_CONE: f64 = 0.99;
/// How far beyond a limit a length must lie: a millionth of a millimetre.
const BEYOND_MM: f64 = 1e-6;
/// To what a length is solved.
const LENGTH_TOLERANCE_MM: f64 = 1e-10;

/// What remains of the whisker does not reach beyond its chamber: the air is out, the model invalid.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("a whisker of {length_mm} mm is cut into its chamber, which ends at {chamber_end_mm} mm")]
pub struct CutIntoChamber {
    /// The remaining length, in mm.
    pub length_mm: f64,
    /// l: where the chamber ends at zero pressure, in mm.
    pub chamber_end_mm: f64,
}

/// Why no length explains a sensitivity.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum LengthError {
    /// Not a number above zero.
    #[error("a sensitivity must be above 0 per mm, not {per_mm}")]
    NotPositive {
        /// What was given, in 1/mm.
        per_mm: f64,
    },
    /// More sensitive than the shortest whisker with a contact beyond its chamber.
    #[error("more sensitive than any whisker that is felt beyond its chamber: the nearest is {} mm", nearest.mm())]
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
    /// At this contact ratio even the longest whisker is touched on its chamber.
    #[error("at this contact ratio even the longest whisker, {} mm, is touched on its chamber", nearest.mm())]
    RatioOnChamber {
        /// The longest length of the model.
        nearest: Millimetre,
    },
}

impl LengthError {
    /// The length whose sensitivity comes nearest; none where nothing was measured.
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
    /// Refuses a whisker cut into its chamber: its remaining length must lie beyond l.
    ///
    /// # Errors
    /// It does not.
    pub fn check_length(&self, length: Millimetre) -> Result<(), CutIntoChamber> {
        let chamber_end_mm = self.geometry().l_mm;
        if length.mm() > chamber_end_mm {
            Ok(())
        } else {
            Err(CutIntoChamber { length_mm: length.mm(), chamber_end_mm })
        }
    }

    /// The longest whisker that the model answers for: 0.99 of its cone (and at most 1000 mm). Toward
    /// the cone's point the sensitivity of the tip would fall to zero.
    #[must_use]
    pub fn longest(&self) -> Millimetre {
        Millimetre::known(self.longest_mm().min(1000.0))
    }

    /// The length La whose sensitivity at a contact ratio is the given one: the inverse of
    /// [`Model::sensitivity_per_mm`], to 1e-10 mm.
    ///
    /// The sensitivity falls with the contact distance, so there is at most one.
    ///
    /// # Errors
    /// No length of the model has this sensitivity; [`LengthError::nearest`] is the one that comes nearest.
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
        // In logarithms the curve is nearly straight: few steps.
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
