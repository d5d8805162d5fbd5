//! How fast a whisker erodes, and when it leaves the compensable range.

use vibrissa_core::estimation::Erosion;
use vibrissa_core::mechanics::{Formulation, Model, Target, compensable_range};
use vibrissa_core::robot::Params;
use vibrissa_core::robot::effect::Condition;
use vibrissa_core::units::{Megapascal, Millimetre};
use vibrissa_evaluation::World;
use vibrissa_protocol::ArrayType;
use vibrissa_simulator::scenario::{Change, Event};

const RATES_MM: [f64; 4] = [0.002, 0.003, 0.005, 0.008];

/// One whisker of an array erodes, at the rate of its place; were it all of them, it would be the array's.
fn eroding(seed: u64, whisker: usize, contacts: f64) -> World {
    let mut one = super::scenario(seed, ArrayType::Type2, &[70.0; RATES_MM.len()]);
    let change = Change::Erode { rate_mm_per_contact: RATES_MM[whisker], until_length_mm: 45.0 };
    one.robots[0].events.push(Event::at_contact(300, super::name("left"), whisker as u16, change));
    let mut params = Params::nguyen_2021(Formulation::Published);
    // At a constant pressure: while setpoints follow, the model's error by pressure counts as length.
    params.refinement.erosion_step_mm = f64::INFINITY;
    let mut world = World::new(&one, params);
    world.run_until_s(contacts / 50.0);
    world
}

fn of(world: &World, whisker: usize) -> Option<Erosion> {
    let view = world.core.whisker(whisker).unwrap();
    (view.condition == Condition::Eroding).then_some(view.erosion).flatten()
}

#[test]
fn property_the_rate_of_erosion_is_told_and_its_interval_covers_the_truth() {
    let (mut reported, mut covered) = (0, 0);
    for seed in 0..10 {
        for (whisker, rate) in RATES_MM.into_iter().enumerate() {
            let world = eroding(200 + seed, whisker, 2000.0);
            let Some(erosion) = of(&world, whisker) else { continue };
            let estimated_rate = erosion.mm_per_contact;
            reported += 1;
            covered += u32::from((estimated_rate.low..=estimated_rate.high).contains(&rate));
            assert!((estimated_rate.mean / rate - 1.0).abs() < 0.35, "seed {seed}, {rate} mm: {estimated_rate:?}");
        }
    }
    println!("{covered} of {reported}");
    assert!(reported >= 36, "{reported}");
    assert!(f64::from(covered) >= 0.9 * f64::from(reported), "{covered} of {reported}");
}

#[test]
fn property_the_contacts_left_are_those_after_which_it_is_too_short() {
    let model = Model::nguyen_2021(Formulation::Published);
    let target = Target { length: Millimetre::known(70.0), pressure: Megapascal::known(0.1) };
    let shortest_mm = compensable_range(&model, target, Megapascal::ZERO, Megapascal::EXAMINED_MAX).0.mm();
    let (mut reported, mut covered) = (0, 0);
    for seed in 0..10 {
        for (whisker, rate) in RATES_MM.into_iter().enumerate() {
            let world = eroding(300 + seed, whisker, 1200.0);
            let Some(erosion) = of(&world, whisker) else { continue };
            let truth = (world.robot.whiskers()[whisker].plant().length_mm() - shortest_mm).max(0.0) / rate;
            let left = erosion.contacts_left;
            reported += 1;
            covered += u32::from(left.low.unwrap() <= truth && left.high.is_none_or(|high| truth <= high));
        }
    }
    println!("{covered} of {reported}");
    assert!(reported >= 30, "{reported}");
    assert!(f64::from(covered) >= 0.9 * f64::from(reported), "{covered} of {reported}");
}

#[test]
fn a_whisker_that_is_too_short_already_has_no_contacts_left() {
    let world = eroding(41, 3, 2800.0);
    let left = of(&world, 3).expect("it erodes").contacts_left;
    assert_eq!((left.mean, left.low, left.high), (Some(0.0), Some(0.0), Some(0.0)), "18 mm shorter");
}

#[test]
fn a_whisker_that_does_not_erode_has_no_rate() {
    let one = super::scenario(42, ArrayType::Type2, &[70.0]);
    let mut world = World::new(&one, Params::nguyen_2021(Formulation::Published));
    world.run_until_s(20.0);
    assert_eq!(world.core.whisker(0).unwrap().erosion, None);
}
