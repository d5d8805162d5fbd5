//! Operators' actions and their consequences, in worlds whose truth is known.

mod approvals;
mod by_hand;
mod watched;

use vibrissa_core::mechanics::Formulation;
use vibrissa_core::policy::Mode;
use vibrissa_core::robot::effect::{AlarmKind, Command, Decision, Effect, EndReason};
use vibrissa_core::robot::{Event, OperatorAction, Outcome, Params, Place};
use vibrissa_evaluation::World;
use vibrissa_protocol::ArrayType;
use vibrissa_simulator::scenario::{Change, Event as Planned};

fn at(whisker: u16) -> Place<'static> {
    Place { array: "left", whisker }
}

fn ask(world: &mut World, action: OperatorAction<'_>) -> Outcome {
    world.step(&Event::Operator(&action))
}

fn params(mode: Mode) -> Params {
    let mut params = Params::nguyen_2021(Formulation::Published);
    params.detection.cold_start_contacts = 60;
    params.policy.mode = mode;
    params
}

/// Whiskers of these lengths, cut at the 100th contact.
fn cut_world(mode: Mode, lengths_mm: &[f64], cuts: &[(u16, f64)]) -> World {
    let mut scenario = crate::scenario(71, ArrayType::Type1, lengths_mm);
    for &(whisker, length_mm) in cuts {
        let change = Change::Trim { length_mm };
        scenario.robots[0].events.push(Planned::at_contact(100, crate::name("left"), whisker, change));
    }
    let mut world = World::new(&scenario, params(mode));
    world.run_until_s(10.0);
    world
}

fn commands(world: &World) -> Vec<Command> {
    world.picked(|effect| if let Effect::Command(command) = effect { Some((**command).clone()) } else { None })
}

fn decisions(world: &World) -> Vec<Decision> {
    world.picked(|effect| if let Effect::Decided(decision) = effect { Some((**decision).clone()) } else { None })
}

fn ended(world: &World) -> Vec<EndReason> {
    world.picked(|effect| if let Effect::Ended { reason, .. } = effect { Some(*reason) } else { None })
}

/// The alarms that stand for a whisker.
fn standing(world: &World, index: usize) -> Vec<AlarmKind> {
    world.core.whisker(index).expect("there").standing.kinds().collect()
}

/// The only compensation that waits for approval: its number and compensator.
fn proposal(world: &World) -> (u32, usize) {
    let waiting: Vec<_> = world.core.compensations().iter().filter(|one| one.is_proposed()).collect();
    assert_eq!(waiting.len(), 1, "{waiting:?}");
    (waiting[0].id(), waiting[0].compensator())
}
