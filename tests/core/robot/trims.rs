//! Trims are found, and compensated for.

use vibrissa_core::mechanics::Formulation;
use vibrissa_core::policy::{Case, Refused};
use vibrissa_core::robot::Params;
use vibrissa_core::robot::effect::{AlarmKind, CommandState, Condition, Effect, Trim};
use vibrissa_evaluation::World;
use vibrissa_protocol::ArrayType;
use vibrissa_simulator::scenario::{Change, Event, Scenario};

const CUT_AT: u64 = 300;

fn cut(scenario: &mut Scenario, whisker: u16, length_mm: f64) {
    let change = Change::Trim { length_mm };
    scenario.robots[0].events.push(Event::at_contact(CUT_AT, super::name("left"), whisker, change));
}

fn run(scenario: &Scenario, contacts: u32) -> World {
    let mut world = World::new(scenario, Params::nguyen_2021(Formulation::Published));
    world.run_until_s(f64::from(contacts) / 50.0 + 0.5);
    world
}

fn trims(world: &World) -> Vec<Trim> {
    world.picked(|effect| if let Effect::Trim(trim) = effect { Some(*trim) } else { None })
}

#[test]
fn property_trims_of_2_mm_and_more_are_found_within_48_contacts_and_1_mm() {
    for seed in 0..4 {
        let mut one = super::scenario(100 + seed, ArrayType::Type2, &[70.0; 12]);
        let lengths = [68.0, 68.0, 67.5, 67.0, 66.0, 65.0, 64.0, 62.0, 60.5, 58.0, 52.0, 40.0];
        for (whisker, length_mm) in (0..).zip(lengths) {
            cut(&mut one, whisker, length_mm);
        }
        let world = run(&one, 600);
        let found = trims(&world);
        assert_eq!(found.len(), lengths.len(), "seed {seed}: one trim each: {found:#?}");
        for trim in found {
            let off_mm = (trim.length_after.length.mm() - lengths[trim.whisker]).abs();
            assert!(off_mm < 1.0, "seed {seed}, {} mm is {off_mm} mm off: {trim:?}", lengths[trim.whisker]);
            assert!(trim.contacts_to_detect <= 48, "seed {seed}: {trim:?}");
        }
    }
}

#[test]
fn a_trimmed_whisker_of_type_2_lowers_its_own_pressure_and_the_error_is_below_the_papers() {
    let mut one = super::scenario(7, ArrayType::Type2, &[70.0]);
    cut(&mut one, 0, 65.0);
    let world = run(&one, 2500);
    let decisions =
        world.picked(|effect| if let Effect::Decided(decision) = effect { Some(decision.clone()) } else { None });
    assert_eq!(decisions.len(), 1);
    let chosen = decisions[0].candidates[decisions[0].chosen.expect("served")];
    assert_eq!(chosen.case, Case::SelfCompensation);
    assert!(chosen.pressure.expect("a setpoint") < chosen.pressure_before);
    let applied = world
        .picked(|effect| matches!(effect, Effect::CommandState { state: CommandState::Applied, .. }).then_some(()));
    let sent = world.picked(|effect| matches!(effect, Effect::Command(_)).then_some(()));
    assert_eq!(applied.len(), sent.len(), "{:#?}", world.effects);
    let errors = world.picked(|effect| if let Effect::Error(error) = effect { Some(error.clone()) } else { None });
    let last = errors.last().expect("a measured error");
    assert!(last.bins.len() >= 10, "{} bins", last.bins.len());
    assert!(last.mean < 0.203_85, "{:.4} +- {:.4}", last.mean, last.sd);
    assert_eq!(world.core.whisker(0).unwrap().condition, Condition::Trimmed);
    assert_eq!(trims(&world).len(), 1, "the new pressure is no second trim");
}

#[test]
fn a_neighbour_serves_where_the_trimmed_whisker_cannot() {
    let mut one = super::scenario(8, ArrayType::Type1, &[70.0, 66.0, 70.0]);
    cut(&mut one, 0, 54.0);
    let world = run(&one, 2000);
    let decisions =
        world.picked(|effect| if let Effect::Decided(decision) = effect { Some(decision.clone()) } else { None });
    let decision = decisions.last().expect("a decision");
    let own = decision.candidates.iter().find(|one| one.whisker == 0).expect("itself");
    assert_eq!(own.refused, Some(Refused::NeedsBelowRange));
    let chosen = decision.candidates[decision.chosen.expect("served")];
    assert_eq!((chosen.whisker, chosen.case, chosen.gives_up_own_role), (1, Case::ShorterForLonger, true));
    assert!(world.picked(|effect| matches!(effect, Effect::Error(_)).then_some(())).len() > 3);
}

#[test]
fn a_whisker_cut_too_short_is_left_unserved_with_an_alarm() {
    let mut one = super::scenario(9, ArrayType::Type2, &[70.0]);
    cut(&mut one, 0, 48.0);
    let world = run(&one, 600);
    let decisions =
        world.picked(|effect| if let Effect::Decided(decision) = effect { Some(decision.clone()) } else { None });
    assert_eq!(decisions.len(), 1);
    assert_eq!(decisions[0].chosen, None);
    let own = decisions[0].candidates[0];
    assert_eq!(own.refused, Some(Refused::NeedsBelowRange));
    assert!(own.predicted_error.expect("of the clamped pressure") > 0.0);
    assert_eq!(own.pressure.expect("clamped").mpa(), 0.0);
    let alarms = world.picked(|effect| if let Effect::Alarm { kind, .. } = effect { Some(*kind) } else { None });
    assert_eq!(alarms, [AlarmKind::Uncompensated]);
}

/// Far off the length that the model is linearised at, the rest of a fitted step is no sign of erosion; and a
/// supposed small change under way must not take the cut's contacts for outliers.
#[test]
fn regress_a_very_large_cut_is_called_as_soon_as_a_smaller_one() {
    for seed in 0..60 {
        let mut one = super::scenario(60 + seed, ArrayType::Type2, &[70.0]);
        cut(&mut one, 0, 48.0);
        let found = trims(&run(&one, 400));
        assert_eq!(found.len(), 1, "seed {seed}");
        assert!(found[0].contacts_to_detect <= 40, "seed {seed}: {:?}", found[0]);
    }
}
