//! The assignment of compensators, in arrays with more than one possibility.

use vibrissa_core::mechanics::Formulation;
use vibrissa_core::policy::{Case, LongerForShorter, Refused};
use vibrissa_core::robot::Params;
use vibrissa_core::robot::effect::{Decision, Effect};
use vibrissa_evaluation::World;
use vibrissa_protocol::ArrayType;
use vibrissa_simulator::scenario::{Change, Event};

fn after_cuts(lengths_mm: &[f64], cuts: &[(u64, u16, f64)], longer_for_shorter: LongerForShorter) -> World {
    let mut scenario = super::scenario(41, ArrayType::Type1, lengths_mm);
    for &(at, whisker, length_mm) in cuts {
        let event = Event::at_contact(at, super::name("left"), whisker, Change::Trim { length_mm });
        scenario.robots[0].events.push(event);
    }
    let mut params = Params::nguyen_2021(Formulation::Published);
    params.policy.longer_for_shorter = longer_for_shorter;
    let mut world = World::new(&scenario, params);
    world.run_until_s(25.0);
    world
}

fn decisions(world: &World) -> Vec<Decision> {
    world.picked(|effect| if let Effect::Decided(decision) = effect { Some((**decision).clone()) } else { None })
}

fn chosen(decision: &Decision) -> Option<(usize, Case)> {
    decision.chosen.map(|at| (decision.candidates[at].whisker, decision.candidates[at].case))
}

#[test]
fn paper_a_longer_neighbour_serves_as_the_last_resort_only() {
    // 66 mm cut to 52 mm: too short for itself; the only neighbour is longer.
    let cuts = [(300, 0, 52.0)];
    let last_resort = decisions(&after_cuts(&[66.0, 70.0], &cuts, LongerForShorter::LastResort));
    assert_eq!(last_resort.iter().map(chosen).collect::<Vec<_>>(), [Some((1, Case::LongerForShorter))]);
    let never = decisions(&after_cuts(&[66.0, 70.0], &cuts, LongerForShorter::Never));
    assert_eq!(never.iter().map(chosen).collect::<Vec<_>>(), [None]);
    let neighbour = never[0].candidates.iter().find(|one| one.whisker == 1).expect("asked all the same");
    assert_eq!(neighbour.refused, Some(Refused::CaseNotAllowed));
}

#[test]
fn a_shorter_neighbour_comes_before_a_longer_one() {
    let all = decisions(&after_cuts(&[70.0, 66.0, 63.0], &[(300, 1, 50.0)], LongerForShorter::LastResort));
    assert_eq!(all.iter().map(chosen).collect::<Vec<_>>(), [Some((2, Case::ShorterForLonger))]);
}

#[test]
fn one_neighbour_serves_one_whisker_and_the_other_is_left_with_an_alarm() {
    let world = after_cuts(&[70.0, 65.0, 70.0], &[(300, 0, 54.0), (500, 2, 54.0)], LongerForShorter::LastResort);
    let all = decisions(&world);
    assert_eq!(all.iter().map(chosen).collect::<Vec<_>>(), [Some((1, Case::ShorterForLonger)), None]);
    let loser = all[1].candidates.iter().find(|one| one.whisker == 1).expect("asked");
    assert_eq!(loser.refused, Some(Refused::CostsMore));
    assert_eq!(world.core.compensations().len(), 1);
}

#[test]
fn a_second_cut_is_decided_anew_and_the_neighbour_takes_over() {
    let world = after_cuts(&[70.0, 65.0], &[(300, 0, 66.0), (800, 0, 54.0)], LongerForShorter::LastResort);
    let all = decisions(&world);
    let expected = [Some((0, Case::SelfCompensation)), Some((1, Case::ShorterForLonger))];
    assert_eq!(all.iter().map(chosen).collect::<Vec<_>>(), expected, "{all:#?}");
    let own = world.core.whisker(0).unwrap();
    assert_eq!(own.setpoint, own.sheet.pressure, "released to its nominal pressure");
}
