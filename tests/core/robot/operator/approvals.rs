//! Proposals that wait, are approved or are refused.

use vibrissa_core::policy::{Mode, Refused};
use vibrissa_core::robot::effect::{AlarmKind, EndReason};
use vibrissa_core::robot::{ActionProblem, Event, OperatorAction, Outcome};
use vibrissa_evaluation::World;
use vibrissa_protocol::ArrayType;
use vibrissa_simulator::scenario::{Change, Event as Planned};

use super::{ask, commands, cut_world, decisions, ended, params, proposal, standing};

#[test]
fn a_proposal_waits_and_is_carried_out_once_it_is_approved() {
    let mut world = cut_world(Mode::Advise, &[70.0, 66.0], &[(0, 54.0)]);
    let (id, compensator) = proposal(&world);
    assert_eq!(compensator, 1);
    assert_eq!(commands(&world), [], "nothing is sent");
    assert_eq!(standing(&world, 0), [AlarmKind::Proposed]);
    // No approval is needed any more, but one was requested before.
    world.params.policy.mode = Mode::Automatic;
    world.step(&Event::PolicyChanged);
    world.run_until_s(12.0);
    assert_eq!((proposal(&world), commands(&world)), ((id, 1), Vec::new()));
    assert_eq!(ask(&mut world, OperatorAction::Approve { compensation: id }), Outcome::Taken);
    let sent = commands(&world);
    assert_eq!(sent.iter().map(|one| (one.whisker, one.compensation)).collect::<Vec<_>>(), [(1, Some(id))]);
    assert_eq!(standing(&world, 0), []);
    let again = ask(&mut world, OperatorAction::Approve { compensation: id });
    assert_eq!(again, Outcome::Refused(ActionProblem::NotProposed));
    let refused = ask(&mut world, OperatorAction::Refuse { compensation: id });
    assert_eq!(refused, Outcome::Refused(ActionProblem::NotProposed), "it runs");
    world.run_until_s(17.0);
    assert_eq!(world.core.whisker(1).unwrap().setpoint, sent[0].pressure);
}

#[test]
fn refused_the_next_best_is_proposed_and_then_none() {
    let mut world = cut_world(Mode::Advise, &[66.0, 70.0, 65.0], &[(1, 54.0)]);
    let (first, one) = proposal(&world);
    assert_eq!(ask(&mut world, OperatorAction::Refuse { compensation: first }), Outcome::Taken);
    let (second, other) = proposal(&world);
    assert_ne!(one, other);
    let decision = decisions(&world).pop().unwrap();
    let refused = decision.candidates.iter().find(|candidate| candidate.whisker == one).unwrap();
    assert_eq!(refused.refused, Some(Refused::Operator));
    assert_eq!(ask(&mut world, OperatorAction::Refuse { compensation: second }), Outcome::Taken);
    assert_eq!(world.core.compensations(), []);
    assert_eq!(standing(&world, 1), [AlarmKind::Uncompensated]);
    assert_eq!(ended(&world), [EndReason::Refused, EndReason::Refused]);
    world.run_until_s(12.0);
    assert_eq!((world.core.compensations(), commands(&world)), (&[][..], Vec::new()), "nothing by itself");
    // Another policy: the same may be proposed again.
    world.step(&Event::PolicyChanged);
    assert!([one, other].contains(&proposal(&world).1), "either of those refused");
    assert_eq!(standing(&world, 1), [AlarmKind::Proposed]);
}

#[test]
fn refused_a_compensator_is_proposed_again_for_a_target_that_is_trimmed_again() {
    let mut scenario = crate::scenario(72, ArrayType::Type2, &[70.0]);
    for (contact, length_mm) in [(100, 66.0), (500, 62.0)] {
        let change = Change::Trim { length_mm };
        scenario.robots[0].events.push(Planned::at_contact(contact, crate::name("left"), 0, change));
    }
    let mut world = World::new(&scenario, params(Mode::Advise));
    world.run_until_s(9.0);
    let (id, _) = proposal(&world);
    ask(&mut world, OperatorAction::Refuse { compensation: id });
    assert_eq!(standing(&world, 0), [AlarmKind::Uncompensated]);
    world.run_until_s(20.0);
    assert!(proposal(&world).0 > id);
    assert_eq!(standing(&world, 0), [AlarmKind::Proposed]);
}
