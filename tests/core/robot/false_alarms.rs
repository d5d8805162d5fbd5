//! Healthy whiskers stay healthy.

use vibrissa_core::mechanics::Formulation;
use vibrissa_core::robot::Params;
use vibrissa_core::robot::effect::{Condition, Effect};
use vibrissa_evaluation::World;
use vibrissa_protocol::ArrayType;

/// At one false alarm in a million contacts, 20 whiskers with 20,000 contacts each see 0.4 alarms on average
/// and hardly ever a false trim: an alarm must be borne out by the contacts after it.
#[test]
fn property_no_false_trim_on_20_healthy_whiskers_in_20_000_contacts_each() {
    let lengths: Vec<f64> = (0..20).map(|k| 62.0 + 0.6 * f64::from(k)).collect();
    let scenario = super::scenario(20_211, ArrayType::Type1, &lengths);
    let mut world = World::new(&scenario, Params::nguyen_2021(Formulation::Published));
    world.run_until_s(20_000.0 / 50.0 + 1.0);
    assert!(world.contacts >= 400_000, "{} contacts", world.contacts);
    assert!(world.used as f64 > 0.99 * world.contacts as f64, "{} of {} used", world.used, world.contacts);
    let wrong = world.picked(|effect| match effect {
        Effect::Condition { whisker, to, .. } if !matches!(to, Condition::Healthy | Condition::Suspected) => {
            Some((*whisker, *to))
        }
        Effect::Fault { whisker, .. } => Some((*whisker, Condition::Learning)),
        _ => None,
    });
    assert_eq!(wrong, []);
    let suspected =
        world.picked(|effect| matches!(effect, Effect::Condition { to: Condition::Suspected, .. }).then_some(()));
    assert!(suspected.len() <= 4, "{} alarms, 0.4 expected", suspected.len());
    for index in 0..20 {
        let view = world.core.whisker(index).unwrap();
        let off_mm = (view.length.length.mm() - view.sheet.length.mm()).abs();
        assert!(off_mm < 0.5, "whisker {index} is {off_mm} mm off");
    }
}
