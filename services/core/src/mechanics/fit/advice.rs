//! The readings that would narrow an unknown's interval most.

use nalgebra::{DMatrix, DVector};

use super::bench::{BenchFit, information, spread};
use super::least_squares::{Group, Problem, Scattered};
use super::reading::{BenchContact, BenchReading, Kind, Place, Quantity};
use super::unknowns::Unknown;
use crate::units::{Megapascal, Millimetre};

/// Readings that are proposed at once.
const REPETITIONS: usize = 5;
/// Pressures that are proposed, MPa.
const PRESSURES_MPA: [f64; 7] = [0.002, 0.01, 0.02, 0.05, 0.1, 0.15, 0.2];
/// Pressures that are proposed for contacts, MPa.
const CONTACT_PRESSURES_MPA: [f64; 3] = [0.0, 0.1, 0.2];
/// Deflection that is proposed, mm: beyond it the model's straight line errs by more than 1 %.
const DEFLECTION_MM: f64 = 3.0;

/// Readings to take in addition.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Advice {
    /// The proposed reading, with the expected number.
    pub reading: BenchReading,
    /// How many times.
    pub repetitions: usize,
    /// Upper over lower end of the unknown's interval with them.
    pub span: f64,
}

impl BenchFit {
    /// The readings that would narrow an unknown's 95 % interval most; `None` if it is given.
    ///
    /// Candidates are strains without contact, elongations, and, if contacts were read, contacts at the nearest and the
    /// farthest place. Each has the scatter of its kind, or of all kinds.
    #[must_use]
    pub fn advice(&self, unknown: Unknown) -> Option<Advice> {
        let at = self.free.iter().position(|free| *free == unknown)?;
        let along = DVector::from_fn(self.free.len(), |row, _| f64::from(u8::from(row == at)));
        let with = |reading: BenchReading| {
            let groups = self.with(&reading)?;
            let covariance = information(&groups, &self.assumed).try_inverse()?;
            let (error, t) = spread(&covariance, &groups, &along);
            Some(Advice { reading, repetitions: REPETITIONS, span: (2.0 * t * error).exp() })
        };
        self.candidates().into_iter().filter_map(with).min_by(|a, b| a.span.total_cmp(&b.span))
    }

    fn candidates(&self) -> Vec<BenchReading> {
        let modelled = |pressure_mpa: f64, quantity: Quantity| {
            let pressure = Megapascal::known(pressure_mpa);
            let blank = BenchReading { pressure, pressure_sd_mpa: 0.0, quantity, value: 0.0, sd: None };
            BenchReading { value: blank.modelled(&self.model, self.gauge), ..blank }
        };
        let mut candidates: Vec<_> = PRESSURES_MPA.map(|mpa| modelled(mpa, Quantity::AxialStrain)).into();
        if self.free.contains(&Unknown::ElongationGain) {
            candidates.extend(PRESSURES_MPA.map(|mpa| modelled(mpa, Quantity::Elongation)));
        }
        for distance_mm in self.contacts_mm.into_iter().flatten() {
            let contact = BenchContact {
                place: Place::Distance(Millimetre::known(distance_mm.min(1000.0))),
                place_sd: 0.0,
                deflection_mm: DEFLECTION_MM,
                deflection_sd_mm: 0.0,
            };
            for quantity in [Quantity::ContactStrain(contact), Quantity::ContactForce(contact)] {
                candidates.extend(CONTACT_PRESSURES_MPA.map(|mpa| modelled(mpa, quantity)));
            }
        }
        candidates
    }

    /// The groups with the repeated reading in addition.
    fn with(&self, reading: &BenchReading) -> Option<Vec<Scattered>> {
        let group = Group { kind: reading.kind()?, stated: false };
        let relative = |one: &&Scattered| !one.group.stated && one.group.kind != Kind::Zero;
        let known = self.groups.iter().find(|one| one.group == group);
        let scatter = match known {
            Some(known) => known.scatter,
            None => self.groups.iter().filter(relative).map(|one| one.scatter).reduce(f64::max)?,
        };
        let readings = [*reading];
        let base = self.model.clone();
        let problem = Problem { base, readings: &readings, free: self.free.clone(), assumed: self.values };
        let unit = match group.kind {
            Kind::Axial | Kind::Elongation => 1.0,
            Kind::Zero | Kind::ContactStrain | Kind::ContactForce => reading.value,
        };
        let row = problem.weighted_jacobian(&self.values, &[1.0 / (unit * scatter)]);
        let added: DMatrix<f64> = row.transpose() * row * REPETITIONS as f64;
        let mut groups = self.groups.clone();
        match groups.iter_mut().find(|one| one.group == group) {
            Some(same) => {
                same.information += added;
                same.degrees += REPETITIONS as f64;
            }
            None => groups.push(Scattered {
                group,
                readings: REPETITIONS,
                scatter,
                degrees: REPETITIONS as f64,
                information: added,
            }),
        }
        Some(groups)
    }
}
