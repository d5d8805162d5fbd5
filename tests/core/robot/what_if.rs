//! The predicted decision is the one that is taken.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use vibrissa_core::mechanics::Formulation;
use vibrissa_core::policy::{LongerForShorter, Refused};
use vibrissa_core::robot::effect::{Effect, Trim};
use vibrissa_core::robot::{Params, WhatIf, WhatIfError};
use vibrissa_core::units::{Micros, Millimetre};
use vibrissa_evaluation::World;
use vibrissa_evaluation::world::START_US;
use vibrissa_protocol::ArrayType;
use vibrissa_simulator::scenario::{Change, Event, Scenario};

/// Arrays of two to six whiskers of which up to four are cut, one contact a message.
fn any_scenario(seed: u64) -> (Scenario, Params) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let count = random.random_range(2..=6);
    let lengths_mm: Vec<f64> = (0..count).map(|_| random.random_range(62.0..72.0)).collect();
    let array_type = if random.random_bool(0.8) { ArrayType::Type1 } else { ArrayType::Type2 };
    let mut scenario = super::scenario(seed, array_type, &lengths_mm);
    scenario.behaviour.contacts_per_message = 1;
    for _ in 0..random.random_range(1..=4) {
        let whisker = random.random_range(0..count);
        let length_mm = lengths_mm[whisker] - random.random_range(2.5..16.0);
        let at = random.random_range(90..220);
        let event = Event::at_contact(at, super::name("left"), whisker as u16, Change::Trim { length_mm });
        scenario.robots[0].events.push(event);
    }
    let mut params = Params::nguyen_2021(Formulation::Published);
    params.detection.cold_start_contacts = 60;
    params.policy.longer_for_shorter =
        [LongerForShorter::Never, LongerForShorter::LastResort, LongerForShorter::Allowed][random.random_range(0..3)];
    (scenario, params)
}

const SECONDS: f64 = 8.0;

fn trim_of(effect: &Effect) -> Option<Trim> {
    if let Effect::Trim(trim) = effect { Some(*trim) } else { None }
}

/// The world as it was when the core had everything that it decided on at `time`, except for the decision: a
/// trim is not acted on there before its length is certain beyond all measure.
fn just_before(scenario: &Scenario, params: &Params, time: Micros) -> World {
    let mut world = World::new(scenario, params.clone());
    world.run_until_s((time.0 - START_US - 1) as f64 / 1e6);
    world.params.health.length_sd_max_mm = 0.0;
    world.params.health.length_contacts_max = u32::MAX;
    // Seconds have no microsecond to spare; half of one more does not reach the next.
    world.run_until_s((time.0 - START_US) as f64 / 1e6 + 5e-7);
    world
}

/// The decision taken at that time, in the form of a prediction.
fn done(world: &World, time: Micros) -> WhatIf {
    let mut answer =
        WhatIf { decisions: Vec::new(), ended: Vec::new(), setpoints: Vec::new(), by_objective: Vec::new() };
    for (_, effect) in world.effects.iter().filter(|(at, _)| *at == time) {
        match effect {
            Effect::Decided(decision) => answer.decisions.push((**decision).clone()),
            Effect::Ended { compensation, reason, .. } => answer.ended.push((*compensation, *reason)),
            Effect::Command(command) => answer.setpoints.push(vibrissa_core::robot::Planned {
                whisker: command.whisker,
                pressure: command.pressure,
                reason: command.reason,
                compensation: command.compensation,
                gain: command.gain,
            }),
            _ => {}
        }
    }
    answer
}

#[test]
fn property_what_would_be_done_is_what_is_then_done() {
    let (mut compared, mut served, mut ended) = (0, 0, 0);
    for seed in 0..100 {
        let (scenario, params) = any_scenario(seed);
        let mut world = World::new(&scenario, params.clone());
        world.run_until_s(SECONDS);
        let trims: Vec<(Micros, Trim)> =
            world.effects.iter().filter_map(|(at, effect)| Some((*at, trim_of(effect)?))).collect();
        for (time, trim) in &trims {
            let before = just_before(&scenario, &params, *time);
            let unchanged = before.core.clone();
            let asked = before.core.what_if(&params, trim.whisker, trim.length_after.length).expect("an answer");
            assert_eq!(before.core, unchanged);
            let by_objective = asked.by_objective.clone();
            assert_eq!(asked, WhatIf { by_objective, ..done(&world, *time) }, "seed {seed}, {trim:?}");
            compared += 1;
            served += usize::from(asked.decisions.iter().any(|decision| decision.chosen.is_some()));
            ended += asked.ended.len();
        }
    }
    assert!(compared > 150 && served > 100 && ended > 1, "{compared} compared, {served} served, {ended} ended");
}

/// The compensation with an objective is the one that a robot gets with it.
#[test]
fn property_each_objective_is_answered_as_it_would_be_decided() {
    use vibrissa_core::mechanics::Objective;
    for seed in 0..20 {
        let (mut scenario, mut params) = any_scenario(seed);
        scenario.robots[0].events.clear();
        let mut world = World::new(&scenario, params.clone());
        world.run_until_s(SECONDS);
        let length = Millimetre::known(world.core.whisker(0).expect("one").length.length.mm() - 6.0);
        let asked = world.core.what_if(&params, 0, length).expect("an answer");
        let objectives: Vec<Objective> = asked.by_objective.iter().map(|one| one.0).collect();
        assert_eq!(objectives, [Objective::Tip, Objective::Mean, Objective::Shape]);
        for (objective, best) in asked.by_objective {
            scenario.robots[0].applies_gain = objective == Objective::Shape;
            params.policy.objective = objective;
            let mut world = World::new(&scenario, params.clone());
            world.run_until_s(SECONDS);
            let own = world.core.what_if(&params, 0, length).expect("an answer");
            let decision = own.decisions.iter().find(|one| one.target == 0).expect("a decision");
            let chosen = decision.chosen.map(|at| &decision.candidates[at]);
            assert_eq!(best.map(|one| one.compensator), chosen.map(|one| one.whisker), "seed {seed} {objective:?}");
            let Some((best, chosen)) = best.zip(chosen) else { continue };
            assert_eq!((Some(best.pressure), Some(best.predicted_error)), (chosen.pressure, chosen.predicted_error));
            assert_eq!(best.predicted_error_interval, chosen.predicted_error_interval);
            assert_eq!(best.reading_gain.is_some(), objective == Objective::Shape);
        }
    }
}

fn calm() -> World {
    let scenario = super::scenario(61, ArrayType::Type1, &[70.0, 66.0]);
    let mut world = World::new(&scenario, Params::nguyen_2021(Formulation::Published));
    world.run_until_s(8.0);
    world
}

#[test]
fn a_cut_into_the_chamber_is_answered_and_one_that_does_not_shorten_is_refused() {
    let world = calm();
    let ask = |whisker, length_mm| world.core.what_if(&world.params, whisker, Millimetre::known(length_mm));
    for length_mm in [0.0, 1.0, 5.0] {
        let answer = ask(0, length_mm).expect("an answer");
        let own = answer.decisions[0].candidates.iter().find(|one| one.whisker == 0).expect("asked");
        assert_eq!(own.refused, Some(Refused::CutIntoChamber), "{length_mm} mm");
        assert_eq!(own.predicted_error, None);
        assert_eq!(answer.setpoints.iter().map(|one| one.whisker).collect::<Vec<_>>(), [1], "the neighbour serves");
    }
    assert!(matches!(ask(0, 71.0), Err(WhatIfError::NotShorter { asked_mm: 71.0, .. })));
    assert_eq!(ask(7, 60.0), Err(WhatIfError::UnknownWhisker(7)));
}

#[test]
fn a_robot_that_is_offline_is_answered_too_and_nobody_there_can_serve() {
    let mut world = calm();
    world.silent_for_s(20.0);
    let answer = world.core.what_if(&world.params, 0, Millimetre::known(65.0)).expect("an answer");
    assert_eq!(answer.decisions[0].chosen, None);
    assert_eq!(answer.setpoints, []);
}
