//! The strain of one whisker by place and deflection, tabulated for each pressure.
//!
//! The table is over the distance of the contact along the whisker, so one serves all lengths. Where an object stands, the
//! whisker is longer than the way to it.

use std::cell::RefCell;
use std::f64::consts::PI;

use vibrissa_core::mechanics::{Calibration, Geometry};

use super::Push;
use super::whisker::{LONGEST_MM, Stretched};

/// Nodes over the distance and over the deflection.
const PLACES: usize = 12;
const DEFLECTIONS: usize = 6;
/// Largest deflection of a table, mm; larger ones read as it does.
pub(super) const DEEPEST_MM: f64 = 6.5;
/// Repetitions that find the place of a contact to 1e-6 mm.
const REPETITIONS: u32 = 6;
/// Number of tables in memory: of the nominal pressure, a setpoint, and one on the way, with both signs of the friction.
const KEPT: usize = 6;

/// How the gauge of one whisker answers to contacts, at any length and pressure.
#[derive(Debug)]
pub(in crate::reality) struct Bending {
    geometry: Geometry,
    calibration: Calibration,
    nature: Nature,
    /// Tables of the last pressures, the newest last.
    kept: RefCell<Vec<Table>>,
}

/// Properties of the whiskers of a row besides their mechanics.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::reality) struct Nature {
    /// Coefficient of friction.
    pub friction: f64,
    /// Share of its thickness under pressure that the wall has by its volume, and not by eq. 18 to 20.
    pub by_volume: f64,
}

/// A contact of a whisker.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::reality) struct Place {
    /// Distance of the object from the base, as a share of the whisker's length under pressure.
    pub ratio: f64,
    /// Length of the whisker without pressure, mm.
    pub length_mm: f64,
    pub pressure_mpa: f64,
}

impl Bending {
    pub(in crate::reality) fn new(geometry: Geometry, calibration: Calibration, nature: Nature) -> Self {
        Self { geometry, calibration, nature, kept: RefCell::default() }
    }

    /// Strain per mm of deflection at a deflection, 1/mm, also where the object returns, so that the friction has turned.
    /// `None` on the chamber.
    pub(in crate::reality) fn per_mm(&self, place: Place, deflection_mm: f64, returns: bool) -> Option<f64> {
        let friction = if returns { -self.nature.friction } else { self.nature.friction };
        let mut kept = self.kept.borrow_mut();
        let is_it = |table: &Table| table.pressure_mpa == place.pressure_mpa && table.friction == friction;
        let table = match kept.iter().position(is_it) {
            Some(at) => kept.remove(at),
            None => {
                let by_volume = self.nature.by_volume;
                let whisker = Stretched::new(&self.geometry, &self.calibration, by_volume, place.pressure_mpa);
                Table::new(&whisker, place.pressure_mpa, friction)
            }
        };
        let log_per_mm = table.log_per_mm(place, deflection_mm);
        if kept.len() == KEPT {
            kept.remove(0);
        }
        kept.push(table);
        log_per_mm.map(f64::exp)
    }

    /// Log of the same, mean over the deflections of a range and both ways.
    pub(in crate::reality) fn mean_log_per_mm(&self, place: Place, (low_mm, high_mm): (f64, f64)) -> Option<f64> {
        // Gauss-Legendre.
        let points = [-(0.6_f64.sqrt()), 0.0, 0.6_f64.sqrt()].into_iter().zip([5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0]);
        points
            .map(|(point, weight)| {
                let deflection_mm = 0.5 * (low_mm + high_mm + point * (high_mm - low_mm));
                let [moves, returns] = [false, true].map(|returns| self.per_mm(place, deflection_mm, returns));
                Some(0.5 * weight * (moves?.ln() + returns?.ln()))
            })
            .sum()
    }
}

/// Polynomial interpolation between Chebyshev nodes in an interval.
#[derive(Debug, Clone, Copy)]
struct Nodes<const N: usize> {
    from: f64,
    to: f64,
}

impl<const N: usize> Nodes<N> {
    fn angle(k: usize) -> f64 {
        PI * (k as f64 + 0.5) / N as f64
    }

    fn each(self) -> [f64; N] {
        std::array::from_fn(|k| 0.5 * (self.from + self.to) + 0.5 * (self.to - self.from) * Self::angle(k).cos())
    }

    /// Weights of the nodes at a place; they sum to 1.
    fn weights(self, at: f64) -> [f64; N] {
        let nodes = self.each();
        if let Some(hit) = nodes.iter().position(|&node| (at - node).abs() < 1e-12) {
            return std::array::from_fn(|k| f64::from(u8::from(k == hit)));
        }
        let raw: [f64; N] = std::array::from_fn(|k| {
            let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
            sign * Self::angle(k).sin() / (at - nodes[k])
        });
        let sum: f64 = raw.iter().sum();
        raw.map(|one| one / sum)
    }
}

/// Log of the strain per mm of deflection, and by how much the way to the object is shorter than the whisker up to the contact,
/// per square of the deflection.
type Cell = [f64; 2];

#[derive(Debug)]
struct Table {
    pressure_mpa: f64,
    friction: f64,
    elongation_mm: f64,
    chamber_end_mm: f64,
    /// Over the logarithm of the distance along the whisker.
    places: Nodes<PLACES>,
    deflections: Nodes<DEFLECTIONS>,
    cells: [[Cell; DEFLECTIONS]; PLACES],
}

impl Table {
    fn new(whisker: &Stretched, pressure_mpa: f64, friction: f64) -> Self {
        let places = Nodes { from: whisker.chamber_end_mm.ln(), to: LONGEST_MM.ln() };
        let deflections = Nodes { from: 0.0, to: DEEPEST_MM };
        let cells = places.each().map(|log_mm| {
            let along_mm = log_mm.exp();
            deflections.each().map(|deflection_mm| {
                let bent = whisker.rod.bend(along_mm, deflection_mm, Push::Sliding(friction));
                bent.map_or([f64::NAN; 2], |bent| {
                    [(bent.strain / deflection_mm).ln(), (along_mm - bent.reach_mm) / deflection_mm.powi(2)]
                })
            })
        });
        let &Stretched { elongation_mm, chamber_end_mm, .. } = whisker;
        Self { pressure_mpa, friction, elongation_mm, chamber_end_mm, places, deflections, cells }
    }

    fn log_per_mm(&self, place: Place, deflection_mm: f64) -> Option<f64> {
        let whole_mm = place.length_mm + self.elongation_mm;
        let reach_mm = place.ratio * whole_mm;
        if reach_mm <= self.chamber_end_mm {
            return None;
        }
        let deflection_mm = deflection_mm.min(DEEPEST_MM);
        let by_deflection = self.deflections.weights(deflection_mm);
        let here = self.cells.map(|row| {
            let sum = |k: usize| row.iter().zip(by_deflection).map(|(cell, weight)| cell[k] * weight).sum::<f64>();
            [sum(0), sum(1)]
        });
        let at = |along_mm: f64| {
            let weights = self.places.weights(along_mm.ln());
            [0, 1].map(|k| here.iter().zip(weights).map(|(cell, weight)| cell[k] * weight).sum::<f64>())
        };
        // Where the whisker is too short for the object, its tip stays on it.
        let last_mm = whole_mm.min(LONGEST_MM);
        let mut along_mm = reach_mm.min(last_mm);
        for _ in 0..REPETITIONS {
            let [_, shorter] = at(along_mm);
            along_mm = (reach_mm + shorter * deflection_mm.powi(2)).min(last_mm);
        }
        Some(at(along_mm)[0])
    }
}
