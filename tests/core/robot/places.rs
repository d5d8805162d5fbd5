//! Robots that know less of a contact's place than its ratio to the present length.

use vibrissa_core::mechanics::Formulation;
use vibrissa_core::robot::Params;
use vibrissa_core::robot::effect::{Condition, ContactUse, Effect, Trim};
use vibrissa_core::robot::event::{Contact, ContactPlace, Distance, Event};
use vibrissa_core::units::{ContactRatio, Micros, Millimetre, Strain};
use vibrissa_evaluation::World;
use vibrissa_protocol::ArrayType;
use vibrissa_simulator::places::Places;
use vibrissa_simulator::scenario::{Change, Event as Planned};

const CUT_AT: u64 = 300;
const LENGTHS_MM: [f64; 6] = [68.0, 66.0, 65.0, 62.0, 58.0, 54.0];

/// Whole whiskers of 70 mm, cut to other lengths at their 300th contact.
fn cut_world(seed: u64, places: Places) -> World {
    let mut scenario = crate::scenario(seed, ArrayType::Type2, &[70.0; LENGTHS_MM.len()]);
    scenario.behaviour.places = places;
    for (whisker, length_mm) in (0..).zip(LENGTHS_MM) {
        let change = Change::Trim { length_mm };
        scenario.robots[0].events.push(Planned::at_contact(CUT_AT, crate::name("left"), whisker, change));
    }
    let mut world = World::new(&scenario, Params::nguyen_2021(Formulation::Published));
    world.run_until_s(14.0);
    world
}

fn trims(world: &World) -> Vec<Trim> {
    world.picked(|effect| if let Effect::Trim(trim) = effect { Some(*trim) } else { None })
}

#[test]
fn property_a_cut_is_found_from_contacts_at_the_tip() {
    for places in [Places::Tip, Places::TipDistance] {
        for seed in 0..3 {
            let world = cut_world(seed, places);
            let found = trims(&world);
            assert_eq!(found.len(), LENGTHS_MM.len(), "{places:?}, seed {seed}: {found:#?}");
            for trim in found {
                let off_mm = (trim.length_after.length.mm() - LENGTHS_MM[trim.whisker]).abs();
                assert!(off_mm < 1.0 && trim.contacts_to_detect <= 40, "{places:?}, seed {seed}: {trim:?}");
            }
        }
    }
}

#[test]
fn property_a_measured_distance_of_the_tip_tells_a_length_that_the_sensitivity_does_not() {
    // The rubber differs from the model by up to 3 %: the slope that tells the length is wrong, a measured distance is not.
    let error_mm = |places| {
        let errors: Vec<f64> = (0..3)
            .flat_map(|seed| {
                let world = cut_world(seed, places);
                let length_mm = |whisker| world.core.whisker(whisker).unwrap().length.length.mm();
                (0..LENGTHS_MM.len())
                    .map(|whisker| (length_mm(whisker) - LENGTHS_MM[whisker]).abs())
                    .collect::<Vec<_>>()
            })
            .collect();
        errors.iter().sum::<f64>() / errors.len() as f64
    };
    let (by_sensitivity, measured) = (error_mm(Places::Tip), error_mm(Places::TipDistance));
    assert!(measured < 0.7 * by_sensitivity, "{measured} mm, {by_sensitivity} mm");
}

#[test]
fn property_distances_alone_call_no_cut() {
    for seed in 0..3 {
        let world = cut_world(seed, Places::Distance);
        assert!(world.used > world.contacts / 2, "{} of {}", world.used, world.contacts);
        assert_eq!(trims(&world), []);
        for whisker in 0..LENGTHS_MM.len() {
            let view = world.core.whisker(whisker).unwrap();
            assert!(matches!(view.condition, Condition::Healthy | Condition::Suspected), "seed {seed}: {view:?}");
            assert!((view.length.length.mm() - 70.0).abs() < 0.5, "seed {seed}: {view:?}");
        }
    }
}

#[test]
fn contacts_without_a_place_are_recorded_and_not_used() {
    let world = cut_world(1, Places::Unknown);
    assert!(world.contacts > 1000, "{}", world.contacts);
    assert_eq!((world.used, trims(&world)), (0, vec![]));
    assert_eq!(world.core.whisker(0).unwrap().condition, Condition::Learning);
}

#[test]
fn a_distance_beyond_the_estimated_length_is_not_used() {
    let mut world = cut_world(1, Places::Tip);
    let boot_id = world.robot.boot_id().to_string();
    let mut uses = Vec::new();
    for (seq, distance_mm) in (1_000_000..).zip([40.0, 53.0, 62.0, 70.0]) {
        let contact = Contact {
            array: "left",
            whisker: 5,
            robot_time: Micros(world.robot.start_us() + 14_000_000),
            place: ContactPlace::Distance(Distance { at: Millimetre::known(distance_mm), sd_mm: 0.5 }),
            deflection: Millimetre::known(3.0),
            strain: Strain::known(0.01),
            pressure: world.core.whisker(5).unwrap().setpoint,
            is_test: false,
            angle_is_stated: false,
            saturated: false,
            temperature_c: None,
        };
        let event = Event::Contacts { boot_id: &boot_id, seq, contacts: &[contact], missed: &[] };
        let mut effects = Vec::new();
        world.core.step(&world.params, contact.robot_time, &event, &mut effects);
        uses.extend(effects.iter().filter_map(|effect| match effect {
            Effect::Contact(contact) => Some((contact.used, contact.ratio.map(ContactRatio::a))),
            _ => None,
        }));
    }
    let is_beyond: Vec<bool> = uses.iter().map(|(used, _)| *used == ContactUse::BeyondTip).collect();
    assert_eq!(is_beyond, [false, false, true, true], "{uses:?}");
    assert!(uses[0].1.is_some_and(|ratio| (ratio - 40.0 / 54.0).abs() < 0.02), "{uses:?}");
    assert_eq!(uses[2].1, None);
}
