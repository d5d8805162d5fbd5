//! Planted faults, which the invariants must detect: otherwise a run without violations would show nothing.

use std::time::{Duration, Instant};

use vibrissa_simulation::invariants::Invariant;
use vibrissa_simulation::plan::{Kind, Plan, Sizes};
use vibrissa_simulation::shrink::shrink;
use vibrissa_simulation::world::run;
use vibrissa_simulator::scenario::Misbehaviour;
use vibrissa_store::fault::{Fault, planted};

use crate::LOST_EPOCHS;

/// Histories until a fault must be found.
const MOST: u64 = 100;

/// Runs histories until one violates the expected invariant.
fn is_found(name: &str, expected: Invariant, history: impl Fn(Plan) -> Vec<Invariant>) {
    let begun = Instant::now();
    let found = (1..=MOST).find(|&seed| history(Plan::draw(seed, Sizes::default())).contains(&expected));
    println!("{name}: seed {found:?} after {:.1} s", begun.elapsed().as_secs_f64());
    assert!(found.is_some(), "{name}: no history of {MOST} violates: {expected}");
}

fn violated(plan: &Plan) -> Vec<Invariant> {
    run(plan).violations.iter().map(|violation| violation.invariant).collect()
}

fn fault_is_found(fault: Fault, expected: Invariant) {
    is_found(&format!("{fault:?}"), expected, |plan| planted(fault, || violated(&plan)));
}

/// As [`fault_is_found`], with these kinds of faults in the place of all: with all kinds it takes some 50 histories.
fn fault_is_found_by(kinds: &[Kind], fault: Fault, expected: Invariant) {
    is_found(&format!("{fault:?}"), expected, |plan| planted(fault, || violated(&plan.only(kinds))));
}

fn misbehaviour_is_found(misbehaviour: Misbehaviour, expected: Invariant) {
    let name = format!("{misbehaviour:?}");
    is_found(&name, expected, |plan| violated(&Plan { misbehaviour: Some(misbehaviour), ..plan }));
}

#[test]
fn a_receipt_before_the_commit_is_found() {
    fault_is_found(Fault::ReceiptBeforeCommit, Invariant::ReceiptAfterCommit);
}

#[test]
fn transactions_without_a_fence_are_found() {
    fault_is_found(Fault::NoFence, Invariant::ContactOnce);
}

#[test]
fn rows_before_the_fence_are_found() {
    fault_is_found(Fault::RowsBeforeFence, Invariant::ContactOnce);
}

#[test]
fn an_epoch_that_is_given_twice_is_found() {
    fault_is_found_by(&LOST_EPOCHS, Fault::EpochReuse, Invariant::EpochOnce);
}

#[test]
fn setpoints_that_expire_by_the_wrong_clock_are_found() {
    fault_is_found_by(&[Kind::HostClockStepped], Fault::ExpiryByHostClock, Invariant::SetpointExpires);
}

#[test]
fn robots_that_are_silent_because_the_supervisor_stands_still_are_found() {
    fault_is_found_by(&[Kind::SupervisorFrozen], Fault::StandstillCounts, Invariant::FaultIsTrue);
}

#[test]
fn events_that_count_as_delivered_before_the_request_are_found() {
    fault_is_found(Fault::DeliveredBeforeRequest, Invariant::WebhookDelivered);
}

#[test]
fn webhooks_that_nobody_holds_are_found() {
    fault_is_found_by(&[Kind::ReceiverSlow, Kind::ReceiverSilent], Fault::NoHold, Invariant::WebhookOnce);
}

#[test]
fn a_history_that_overwrites_states_of_a_newer_program_is_shrunk() {
    let sizes = Sizes { supervisors: 3, robots: 6, length: Duration::from_secs(60), are_fixed: true };
    let kinds = [Kind::SupervisorUpgraded, Kind::SupervisorKilled, Kind::SupervisorFrozen];
    // A seed that is found with these sizes and kinds.
    let plan = Plan::draw(6, sizes).only(&kinds);
    let smallest = planted(Fault::NewerStateRead, || shrink(&plan, Invariant::NewerStateKept, run(&plan)));
    let (strikes, violations) = (&smallest.0.strikes, &smallest.1.violations);
    assert!(violations.iter().any(|one| one.invariant == Invariant::NewerStateKept), "{violations:?}");
    assert!(strikes.len() <= 12 && strikes.len() < plan.strikes.len(), "{strikes:?}");
}

#[test]
fn robots_that_take_any_setpoint_are_found() {
    misbehaviour_is_found(Misbehaviour::TakesAnySetpoint, Invariant::SetpointOnce);
}

#[test]
fn robots_without_a_buffer_are_found() {
    misbehaviour_is_found(Misbehaviour::SendsOnce, Invariant::ContactRecorded);
}
