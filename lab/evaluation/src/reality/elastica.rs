//! A planar elastica: a rod of hollow cones that a rigid object bends, however far.
//!
//! The rod is clamped at its base and does not stretch. Its angle follows from the bending moment,
//! `d theta / d s = M / (E I)`, with the true shape in the moment and the exact second moment of area. An object touches it
//! at one point, and the rod slides over it with or without friction. The equations are integrated from the contact to the
//! base, and the force is sought for which the base is where it is clamped. Nothing here comes from the core, which adds the
//! energies of straight, thin-walled pieces. So plants of this kind show an error that the core's mechanics share with
//! their own plants.
//!
//! - `whisker`: the sections of the paper's whisker under pressure.
//! - `table`: its strain by place and deflection, with interpolation.

mod table;
#[cfg(test)]
mod tests;
mod whisker;

use std::f64::consts::PI;

pub(super) use table::{Bending, Nature, Place};

/// Steps of the integration along the rod, at least.
const STEPS: f64 = 48.0;
/// Largest deflection that is sought at once, as a share of the distance along the rod.
const AT_ONCE: f64 = 0.12;
const ITERATIONS_MAX: u32 = 30;
/// Step of the numerical derivatives, relative to the unknowns.
const DERIVATIVE: f64 = 1e-6;
/// Largest error of the angle at the base, and of the deflection as a share of the distance.
const PRECISION: f64 = 1e-12;

/// A truncated hollow cone of one material.
#[derive(Debug, Clone, Copy)]
struct Section {
    length_mm: f64,
    /// Outer diameter at the end towards the base, and at the other.
    outer_mm: [f64; 2],
    /// Inner diameter at the same ends; 0 if solid.
    inner_mm: [f64; 2],
    modulus_mpa: f64,
    /// Whether the gauge reads it.
    has_gauge: bool,
}

impl Section {
    /// Bending stiffness in N mm^2, and the distance in mm of the gauge from the neutral axis.
    fn at(&self, share: f64) -> (f64, f64) {
        let within = |[near, far]: [f64; 2]| near + share * (far - near);
        let (outer_mm, inner_mm) = (within(self.outer_mm), within(self.inner_mm));
        (self.modulus_mpa * PI / 64.0 * (outer_mm.powi(4) - inner_mm.powi(4)), 0.5 * outer_mm)
    }
}

/// How an object pushes.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Push {
    /// Across the straight rod, as a weight does.
    #[cfg(test)]
    Across,
    /// Across the rod at the contact. The coefficient of friction is positive while the object moves on, which draws the rod
    /// outwards, and negative while it returns.
    Sliding(f64),
}

/// A rod that an object bends.
#[derive(Debug, Clone, Copy)]
struct Bent {
    /// Mean strain of the gauge.
    strain: f64,
    /// Distance of the contact from the base along the straight rod's axis, mm: less than along the rod.
    reach_mm: f64,
}

/// Unknown of the shooting: size of the force in N, and the angle of the rod at the contact.
type Aim = [f64; 2];

/// Angle, distances from the contact along the axis and across it, integral of the gauge's strain, and energy, which tests
/// compare with the work of the object.
type State = [f64; 5];

/// A rod, clamped at the base of its first section.
#[derive(Debug, Clone)]
struct Rod {
    sections: Vec<Section>,
}

impl Rod {
    /// The rod bent by a contact at a distance along it, so that the contact is deflected by so many mm. `None` if no such
    /// shape was found.
    fn bend(&self, along_mm: f64, deflection_mm: f64, push: Push) -> Option<Bent> {
        let aim = self.aim(along_mm, deflection_mm, push)?;
        let ([_, reach_mm, _, strain_mm, _], gauge_mm) = self.shoot(along_mm, aim, push);
        Some(Bent { strain: if gauge_mm > 0.0 { strain_mm / gauge_mm } else { 0.0 }, reach_mm })
    }

    /// Force and angle at the contact for a deflection, in steps from the straight rod.
    fn aim(&self, along_mm: f64, deflection_mm: f64, push: Push) -> Option<Aim> {
        let parts = (deflection_mm.abs() / (AT_ONCE * along_mm)).ceil().max(1.0) as u32;
        (1..=parts).try_fold([0.0; 2], |aim: Aim, part| {
            let grown = f64::from(part) / f64::from((part - 1).max(1));
            let part_mm = deflection_mm * f64::from(part) / f64::from(parts);
            self.aim_from(aim.map(|one| one * grown), along_mm, part_mm, push)
        })
    }

    /// The same by Newton's method from a guess.
    fn aim_from(&self, guess: Aim, along_mm: f64, deflection_mm: f64, push: Push) -> Option<Aim> {
        let missed = |aim: Aim| {
            let ([angle, _, across_mm, ..], _) = self.shoot(along_mm, aim, push);
            [angle, (across_mm - deflection_mm) / along_mm]
        };
        let (stiffness, _) = self.sections[0].at(0.0);
        let steps = [DERIVATIVE * stiffness * deflection_mm.abs() / along_mm.powi(3), DERIVATIVE];
        let mut aim = guess;
        for _ in 0..ITERATIONS_MAX {
            let miss = missed(aim);
            if miss.iter().all(|one| one.abs() < PRECISION) {
                return Some(aim);
            }
            let [by_force, by_angle] = [0, 1].map(|unknown| {
                let mut beside = aim;
                beside[unknown] += steps[unknown];
                let there = missed(beside);
                [0, 1].map(|k| (there[k] - miss[k]) / steps[unknown])
            });
            let determinant = by_force[0] * by_angle[1] - by_force[1] * by_angle[0];
            aim[0] -= (miss[0] * by_angle[1] - miss[1] * by_angle[0]) / determinant;
            aim[1] -= (by_force[0] * miss[1] - by_force[1] * miss[0]) / determinant;
        }
        None
    }

    /// Integrates from the contact to the base (Runge-Kutta of fourth order); also gives the length of the gauge.
    fn shoot(&self, along_mm: f64, aim: Aim, push: Push) -> (State, f64) {
        let [axial_n, across_n] = force(aim, push);
        let mut state = [aim[1], 0.0, 0.0, 0.0, 0.0];
        let mut gauge_mm = 0.0;
        let mut ends_mm = self.sections.iter().map(|one| one.length_mm).sum::<f64>();
        for section in self.sections.iter().rev() {
            ends_mm -= section.length_mm;
            let length_mm = (along_mm - ends_mm).min(section.length_mm);
            if length_mm <= 0.0 {
                continue;
            }
            let steps = (STEPS * length_mm / along_mm).ceil();
            let step_mm = length_mm / steps;
            let rate = |[angle, axial_mm, across_mm, ..]: State, at_mm: f64| {
                let (stiffness, lever_mm) = section.at(at_mm / section.length_mm);
                let moment = axial_mm * across_n - across_mm * axial_n;
                let curvature = moment / stiffness;
                let read = if section.has_gauge { lever_mm * curvature } else { 0.0 };
                let (sine, cosine) = angle.sin_cos();
                [-curvature, cosine, sine, read, 0.5 * moment * curvature]
            };
            let moved = |from: State, by: State, mm: f64| {
                let mut to = from;
                to.iter_mut().zip(by).for_each(|(one, rate)| *one += mm * rate);
                to
            };
            let mut at_mm = length_mm;
            for _ in 0..steps as u32 {
                let half_mm = 0.5 * step_mm;
                let first = rate(state, at_mm);
                let second = rate(moved(state, first, half_mm), at_mm - half_mm);
                let third = rate(moved(state, second, half_mm), at_mm - half_mm);
                let fourth = rate(moved(state, third, step_mm), at_mm - step_mm);
                for (one, mm) in [(first, step_mm), (second, 2.0 * step_mm), (third, 2.0 * step_mm), (fourth, step_mm)]
                {
                    state = moved(state, one, mm / 6.0);
                }
                at_mm -= step_mm;
            }
            gauge_mm += if section.has_gauge { length_mm } else { 0.0 };
        }
        (state, gauge_mm)
    }
}

/// Force of the object on the rod along the axis and across it, N.
fn force([size_n, angle]: Aim, push: Push) -> [f64; 2] {
    let from_across = match push {
        #[cfg(test)]
        Push::Across => 0.0,
        Push::Sliding(friction) => angle - friction.atan(),
    };
    [-size_n * from_across.sin(), size_n * from_across.cos()]
}
