//! Strain of the gauge caused by a deflection at the contact: eq. 10-17 (normal mode) and 26-31 (under pressure).

use super::model::Model;
use super::morphology::Morphology;
use super::taper;
use crate::units::{ContactRatio, Millimetre};

/// Response to a deflection of 1 mm at one contact, with the intermediate results of the equations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Response {
    /// A: distance of the contact from the base under pressure, `a * La^q`, in mm.
    pub contact_mm: f64,
    /// Compliance of the cap (eq. 10 and 26), 1/mm.
    pub delta1_per_mm: f64,
    /// Compliance of the chamber (eq. 11 and 27), 1/mm.
    pub delta2_per_mm: f64,
    /// Compliance of the body up to the contact (eq. 12 and 28), 1/mm.
    pub delta3_per_mm: f64,
    /// Integral over the gauge's grid (eq. 16 and 30), dimensionless.
    pub kappa: f64,
    /// `f_n` or `f_c` as printed in eq. 17 and 31: integrated over the grid, not averaged. Dimensionless.
    pub f: f64,
    /// Sensitivity: mean strain over the grid per mm of deflection, `f / e`. 1/mm.
    pub strain_per_mm: f64,
}

impl Response {
    /// Force per deflection at the contact, N/mm, for a rubber of this Young's modulus (eq. 9).
    #[must_use]
    pub fn force_n_per_mm(&self, youngs_modulus_mpa: f64) -> f64 {
        let compliance_per_mm = self.delta1_per_mm + self.delta2_per_mm + self.delta3_per_mm;
        std::f64::consts::PI * youngs_modulus_mpa / compliance_per_mm
    }
}

/// The contact would lie on the chamber: the formulas are valid only beyond it (region 3).
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("the contact at {contact_mm} mm lies on the chamber, which ends at {chamber_end_mm} mm")]
pub struct ContactOnChamber {
    /// Position of the contact, in mm from the base.
    pub contact_mm: f64,
    /// `l^q`: end of the chamber, in mm from the base.
    pub chamber_end_mm: f64,
}

impl Model {
    /// Response to a contact at a distance from the base, at zero pressure (eq. 10-17).
    ///
    /// Here the whole whisker has one modulus, k2 = 1. The calibrated k2(0) is larger, so [`Model::response`] at
    /// zero pressure differs: they are the paper's two modes.
    ///
    /// Valid beyond the chamber (above l) and before the apex of the cone. A contact nearer than l is moved to l,
    /// where the body adds no compliance; for the far end see [`Model::longest`].
    #[must_use]
    pub fn normal_mode(&self, contact_distance: Millimetre) -> Response {
        let morphology = self.unpressurized();
        let farthest_mm = self.farthest_contact_mm(&morphology);
        let contact_mm = contact_distance.mm().clamp(morphology.chamber_end_mm, farthest_mm);
        self.response_at(contact_mm, &morphology)
    }

    /// Response to a contact at a ratio of a whisker's length under pressure (eq. 26-31).
    ///
    /// `length` is La at zero pressure; the contact lies at `a * (La + delta_l)`. A contact farther out than
    /// [`Model::longest`] allows is moved there.
    ///
    /// # Errors
    /// The contact would lie on the chamber.
    pub fn response(
        &self,
        ratio: ContactRatio,
        length: Millimetre,
        morphology: &Morphology,
    ) -> Result<Response, ContactOnChamber> {
        let contact_mm = self.contact_on_body_mm(ratio, length, morphology)?;
        Ok(self.response_at(contact_mm, morphology))
    }

    /// Sensitivity: strain per mm of deflection at the contact (eq. 31, averaged over the grid), 1/mm.
    ///
    /// # Errors
    /// The contact would lie on the chamber.
    pub fn sensitivity_per_mm(
        &self,
        ratio: ContactRatio,
        length: Millimetre,
        morphology: &Morphology,
    ) -> Result<f64, ContactOnChamber> {
        let contact_mm = self.contact_on_body_mm(ratio, length, morphology)?;
        Ok(self.sensitivity_at_per_mm(contact_mm, morphology))
    }

    /// Sensitivity in 1/mm and its slope d ln s / d ln A over the contact distance A = a * La^q.
    ///
    /// The slope is negative: nearer contacts cause more strain. With `La^q = La + delta_l` the slope over the
    /// length is `d ln s / d La = slope / La^q`, for any ratio.
    ///
    /// # Errors
    /// The contact would lie on the chamber.
    pub fn sensitivity_and_slope(
        &self,
        ratio: ContactRatio,
        length: Millimetre,
        morphology: &Morphology,
    ) -> Result<(f64, f64), ContactOnChamber> {
        let contact_mm = self.contact_on_body_mm(ratio, length, morphology)?;
        let (delta3, delta3_slope) = taper::body_delta3(self.geometry(), contact_mm - morphology.chamber_end_mm);
        let delta = self.cap.at(contact_mm) + morphology.chamber.at(contact_mm) + delta3;
        let delta_slope = self.cap.slope_at(contact_mm) + morphology.chamber.slope_at(contact_mm) + delta3_slope;
        let kappa = morphology.gauge.at(contact_mm);
        let kappa_slope = morphology.gauge.slope_at(contact_mm);
        let sensitivity = morphology.gauge_factor * kappa / (delta * self.geometry().e_mm);
        Ok((sensitivity, contact_mm * (kappa_slope / kappa - delta_slope / delta)))
    }

    /// Response to a contact at a distance from the base under pressure. A contact nearer than the chamber's end, or
    /// farther out than the model is valid, is moved there.
    pub(super) fn response_at_most(&self, contact_mm: f64, morphology: &Morphology) -> Response {
        let farthest_mm = self.farthest_contact_mm(morphology).max(morphology.chamber_end_mm);
        self.response_at(contact_mm.clamp(morphology.chamber_end_mm, farthest_mm), morphology)
    }

    /// [`Self::sensitivity_per_mm`] of a contact known to lie beyond the chamber.
    pub(super) fn sensitivity_at_per_mm(&self, contact_mm: f64, morphology: &Morphology) -> f64 {
        self.response_at(contact_mm, morphology).strain_per_mm
    }

    /// Sensitivity at the tip of a whisker that is not cut into its chamber, so the contact lies beyond it.
    pub(super) fn tip_sensitivity_per_mm(&self, length: Millimetre, morphology: &Morphology) -> f64 {
        let tip_mm = length.mm().min(self.longest_mm()) + morphology.elongation_mm;
        self.sensitivity_at_per_mm(tip_mm, morphology)
    }

    fn response_at(&self, contact_mm: f64, morphology: &Morphology) -> Response {
        let beyond_mm = contact_mm - morphology.chamber_end_mm;
        let delta1_per_mm = self.cap.at(contact_mm);
        let delta2_per_mm = morphology.chamber.at(contact_mm);
        let (delta3_per_mm, _) = taper::body_delta3(self.geometry(), beyond_mm);
        let kappa = morphology.gauge.at(contact_mm);
        let f = morphology.gauge_factor * kappa / (delta1_per_mm + delta2_per_mm + delta3_per_mm);
        let strain_per_mm = f / self.geometry().e_mm;
        Response { contact_mm, delta1_per_mm, delta2_per_mm, delta3_per_mm, kappa, f, strain_per_mm }
    }

    /// `A = a * La^q` in mm, if it lies beyond the chamber.
    fn contact_on_body_mm(
        &self,
        ratio: ContactRatio,
        length: Millimetre,
        morphology: &Morphology,
    ) -> Result<f64, ContactOnChamber> {
        let contact_mm = ratio.a() * (length.mm() + morphology.elongation_mm);
        let chamber_end_mm = morphology.chamber_end_mm;
        if contact_mm > chamber_end_mm {
            Ok(contact_mm.min(self.farthest_contact_mm(morphology)))
        } else {
            Err(ContactOnChamber { contact_mm, chamber_end_mm })
        }
    }

    /// Position of the longest whisker's tip under pressure, in mm.
    fn farthest_contact_mm(&self, morphology: &Morphology) -> f64 {
        self.longest_mm() + morphology.elongation_mm
    }
}
