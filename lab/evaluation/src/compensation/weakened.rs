//! Whiskers that keep their place but lose sensitivity, or wear off: the gain makes up for it.

use rayon::prelude::*;
use vibrissa_core::mechanics::{CONTACT_RATIOS, Formulation};
use vibrissa_core::robot::Params;
use vibrissa_core::robot::effect::Effect;
use vibrissa_simulator::scenario::{Change, Event, Rubber};

use super::{CONTACTS_PER_SECOND, Case, START_MPA, Trial, Truth, WHOLE_CONTACTS, plants, scenario};
use crate::World;

/// Share of its sensitivity that a stiffened whisker keeps.
pub const STIFFENED_TO: f64 = 0.6;
/// Length at which the wear ends, mm.
pub const WORN_TO_MM: f64 = 60.0;
/// Wear, mm per contact.
const WEAR_MM: f64 = 0.002;
/// Contacts after the change begins.
const CONTACTS_AFTER: f64 = 8000.0;

/// Change of the whisker.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Loss {
    /// It keeps [`STIFFENED_TO`] of its sensitivity.
    Stiffened,
    /// It wears off to [`WORN_TO_MM`].
    Worn,
}

/// Relative errors of the reading against that of the whole whisker: means over the contact ratios.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Readout {
    /// Without any gain or change of air, at the end.
    pub unserved: f64,
    /// 800 contacts after the change began.
    pub early: f64,
    /// At the end.
    pub end: f64,
    /// Number of setpoints sent.
    pub setpoints: usize,
}

/// Runs both losses on the plants of a seed.
pub fn evaluate(seed: u64, count: usize, done: &(dyn Fn() + Sync)) -> Vec<(Loss, Readout)> {
    let plants: Vec<(usize, Rubber)> = plants(seed, count).into_iter().enumerate().collect();
    [Loss::Stiffened, Loss::Worn]
        .into_iter()
        .flat_map(|loss| plants.iter().map(move |&(plant, rubber)| (loss, plant, rubber)))
        .collect::<Vec<_>>()
        .into_par_iter()
        .map(|(loss, plant, rubber)| {
            let readout = run(loss, plant, rubber, seed);
            done();
            (loss, readout)
        })
        .collect()
}

/// Runs one loss on one plant.
#[must_use]
pub fn run(loss: Loss, plant: usize, rubber: Rubber, seed: u64) -> Readout {
    let seed = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(1000 * (loss as u64 + 1) + plant as u64);
    let whole_mm = Case::Itself.target_mm();
    let trial = Trial { case: Case::Itself, length_mm: whole_mm, plant, rubber, seed };
    let mut scenario = scenario(&trial);
    scenario.robots[0].applies_gain = true;
    let whole_s = WHOLE_CONTACTS as f64 / CONTACTS_PER_SECOND;
    let [event] = &mut scenario.robots[0].events[..] else { unreachable!("one cut") };
    *event = match loss {
        Loss::Stiffened => Event {
            array: event.array.clone(),
            ..Event::robot_at_s(whole_s, Change::Temperature { sensitivity_factor: STIFFENED_TO, temperature_c: 24.0 })
        },
        Loss::Worn => Event {
            change: Change::Erode { rate_mm_per_contact: WEAR_MM, until_length_mm: WORN_TO_MM },
            ..event.clone()
        },
    };
    let mut world = World::new(&scenario, Params::nguyen_2021(Formulation::Published));
    world.run_until_s(whole_s + 800.0 / CONTACTS_PER_SECOND);
    let early = error(&world, loss, &trial);
    world.run_until_s(whole_s + CONTACTS_AFTER / CONTACTS_PER_SECOND);
    Readout {
        unserved: reading_error(&world, loss, &trial, START_MPA, 1.0),
        early,
        end: error(&world, loss, &trial),
        setpoints: world.picked(|effect| matches!(effect, Effect::Command(_)).then_some(())).len(),
    }
}

/// Error with the present pressure and the gain in force.
fn error(world: &World, loss: Loss, trial: &Trial) -> f64 {
    let gain = world.core.compensations().first().and_then(|one| one.reading_gain()).unwrap_or(1.0);
    reading_error(world, loss, trial, world.robot.whiskers()[0].regulator().pressure_mpa(), gain)
}

fn reading_error(world: &World, loss: Loss, trial: &Trial, pressure_mpa: f64, gain: f64) -> f64 {
    let length_mm = world.robot.whiskers()[0].plant().length_mm();
    let truth = Truth::new(&Trial { length_mm, ..*trial });
    let (_, target) = truth.before_and_target();
    let factor = if loss == Loss::Stiffened { STIFFENED_TO * gain } else { gain };
    let after = truth.after(pressure_mpa, Some(&[factor; CONTACT_RATIOS.len()]));
    let errors: Vec<f64> =
        after.iter().zip(target).filter_map(|(after, target)| Some(((*after)? / target? - 1.0).abs())).collect();
    errors.iter().sum::<f64>() / errors.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stiffened_and_a_worn_whisker_read_as_before() {
        let rubber = plants(5, 1)[0];
        for loss in [Loss::Stiffened, Loss::Worn] {
            let readout = run(loss, 0, rubber, 5);
            assert!(readout.unserved > 0.15, "{loss:?}: {readout:?}");
            assert!(readout.end < 0.03, "{loss:?}: {readout:?}");
            assert!(readout.setpoints < 60, "{loss:?}: {readout:?}");
        }
    }
}
