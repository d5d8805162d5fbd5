//! One number read at the bench, and the model's number for it.

use super::given::Gauge;
use crate::mechanics::model::Model;
use crate::mechanics::sensitivity::ContactOnChamber;
use crate::units::{ContactRatio, Megapascal, Millimetre};

/// A number read at the bench.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BenchReading {
    /// Q: gauge pressure of the chamber.
    pub pressure: Megapascal,
    /// Standard deviation of the pressure, MPa; 0 if it is not stated.
    pub pressure_sd_mpa: f64,
    /// The quantity that was read.
    pub quantity: Quantity,
    /// The reading, in the quantity's unit.
    pub value: f64,
    /// Standard deviation of the reading in the same unit; `None` if it is not stated.
    pub sd: Option<f64>,
}

/// A quantity that a bench reads.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Quantity {
    /// Strain of the gauge without contact, m/m (eq. 32). At zero pressure it is the gauge's offset.
    AxialStrain,
    /// `delta_l(l)`: elongation at the tip, mm (eq. 24).
    Elongation,
    /// Change of the strain by a contact, m/m (eq. 31).
    ContactStrain(BenchContact),
    /// Force at the contact, N (eq. 9 with the compliances of eq. 26-28).
    ContactForce(BenchContact),
}

/// A contact at the bench.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BenchContact {
    /// Where the obstacle touches.
    pub place: Place,
    /// Standard deviation of the place, in its own unit; 0 if it is not stated.
    pub place_sd: f64,
    /// Deflection at the contact, mm.
    pub deflection_mm: f64,
    /// Standard deviation of the deflection, mm; 0 if it is not stated.
    pub deflection_sd_mm: f64,
}

/// Place of a contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Place {
    /// Distance from the base, under the pressure of the reading.
    Distance(Millimetre),
    /// Ratio of a whisker's length, which is that at zero pressure.
    Ratio(ContactRatio, Millimetre),
}

/// Kinds of readings. Those of one kind have one scatter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// Strain without contact at zero pressure.
    Zero,
    /// Strain without contact, under pressure.
    Axial,
    /// Elongation of the chamber.
    Elongation,
    /// Strain by a contact.
    ContactStrain,
    /// Force of a contact.
    ContactForce,
}

/// All kinds, in the order of their groups.
pub(super) const KINDS: [Kind; 5] =
    [Kind::Zero, Kind::Axial, Kind::Elongation, Kind::ContactStrain, Kind::ContactForce];

impl BenchReading {
    /// Kind of the reading; `None` for an elongation at zero pressure, which carries no information.
    #[must_use]
    pub fn kind(&self) -> Option<Kind> {
        let pressed = self.pressure > Megapascal::ZERO;
        match self.quantity {
            Quantity::AxialStrain => Some(if pressed { Kind::Axial } else { Kind::Zero }),
            Quantity::Elongation => pressed.then_some(Kind::Elongation),
            Quantity::ContactStrain(_) => Some(Kind::ContactStrain),
            Quantity::ContactForce(_) => Some(Kind::ContactForce),
        }
    }

    /// The contact of the reading.
    #[must_use]
    pub fn contact(&self) -> Option<&BenchContact> {
        match &self.quantity {
            Quantity::AxialStrain | Quantity::Elongation => None,
            Quantity::ContactStrain(contact) | Quantity::ContactForce(contact) => Some(contact),
        }
    }

    /// Whether any standard deviation is stated.
    pub(super) fn has_sd(&self) -> bool {
        let of_contact = self.contact().is_some_and(|contact| contact.place_sd > 0.0 || contact.deflection_sd_mm > 0.0);
        self.sd.is_some() || self.pressure_sd_mpa > 0.0 || of_contact
    }

    /// The model's number for the reading. A contact on the chamber counts as one at the chamber's end.
    #[must_use]
    pub fn modelled(&self, model: &Model, gauge: Gauge) -> f64 {
        let morphology = model.morphology(self.pressure);
        match self.quantity {
            Quantity::AxialStrain => {
                let e2_mpa = morphology.k2 * model.calibration().youngs_modulus_mpa;
                gauge.gain * model.axial_gain * self.pressure.mpa() / e2_mpa + gauge.offset
            }
            Quantity::Elongation => morphology.elongation_mm,
            Quantity::ContactStrain(contact) => {
                let response = model.response_at_most(contact.distance_mm(morphology.elongation_mm), &morphology);
                gauge.gain * response.strain_per_mm * contact.deflection_mm
            }
            Quantity::ContactForce(contact) => {
                let response = model.response_at_most(contact.distance_mm(morphology.elongation_mm), &morphology);
                response.force_n_per_mm(model.calibration().youngs_modulus_mpa) * contact.deflection_mm
            }
        }
    }

    /// Variance of the modelled number by the stated errors of pressure, place and deflection.
    pub(super) fn input_variance(&self, model: &Model, gauge: Gauge) -> f64 {
        let at = self.modelled(model, gauge);
        let moved = |reading: Self| (reading.modelled(model, gauge) - at).powi(2);
        let pressure_mpa = (self.pressure.mpa() + self.pressure_sd_mpa).min(1.0);
        let of_pressure = moved(Self { pressure: Megapascal::known(pressure_mpa), ..*self });
        let of_contact = |change: fn(BenchContact) -> BenchContact| match self.quantity {
            Quantity::AxialStrain | Quantity::Elongation => 0.0,
            Quantity::ContactStrain(contact) => {
                moved(Self { quantity: Quantity::ContactStrain(change(contact)), ..*self })
            }
            Quantity::ContactForce(contact) => {
                moved(Self { quantity: Quantity::ContactForce(change(contact)), ..*self })
            }
        };
        of_pressure + of_contact(BenchContact::one_sd_deeper) + of_contact(BenchContact::one_sd_inward)
    }
}

impl BenchContact {
    /// A: distance from the base under pressure, mm.
    #[must_use]
    pub fn distance_mm(&self, elongation_mm: f64) -> f64 {
        match self.place {
            Place::Distance(distance) => distance.mm(),
            Place::Ratio(ratio, length) => ratio.a() * (length.mm() + elongation_mm),
        }
    }

    fn one_sd_deeper(self) -> Self {
        Self { deflection_mm: self.deflection_mm + self.deflection_sd_mm, ..self }
    }

    /// Toward the base, because the tip is the end of the range.
    fn one_sd_inward(self) -> Self {
        let place = match self.place {
            Place::Distance(distance) => Place::Distance(Millimetre::known((distance.mm() - self.place_sd).max(0.0))),
            Place::Ratio(ratio, length) => {
                Place::Ratio(ContactRatio::known((ratio.a() - self.place_sd).max(f64::MIN_POSITIVE)), length)
            }
        };
        Self { place, ..self }
    }

    /// Distance of the contact under a pressure, if it lies beyond the chamber.
    ///
    /// # Errors
    /// The contact would lie on the chamber.
    pub fn check(&self, model: &Model, pressure: Megapascal) -> Result<f64, ContactOnChamber> {
        let morphology = model.morphology(pressure);
        let (contact_mm, chamber_end_mm) = (self.distance_mm(morphology.elongation_mm), morphology.chamber_end_mm);
        if contact_mm > chamber_end_mm { Ok(contact_mm) } else { Err(ContactOnChamber { contact_mm, chamber_end_mm }) }
    }
}
