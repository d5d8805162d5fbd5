//! Setpoints of robots that the allow list excludes.

use std::collections::HashSet;

use vibrissa_core::robot::effect::{Command, CommandKey, Reason};
use vibrissa_edge::clock::wall_clock;

use super::*;
use crate::engine::allow_list::AllowList;
use crate::engine::worker::publication::Sent;
use crate::outbox::Publication;

fn command(version: u64) -> Command {
    Command {
        key: CommandKey { epoch: 7, version },
        whisker: 2,
        robot_boot_id: "b".to_owned(),
        pressure: Megapascal::known(PRESSURE_MPA),
        slew_mpa_per_s: 0.02,
        issued: wall_clock(),
        expires: Micros(0),
        reason: Reason::Release,
        compensation: None,
        gain: None,
    }
}

/// The publications of a new setpoint of the first robot.
fn setpoint(worker: &mut Worker, version: u64) -> Vec<Publication> {
    let (robots, stepper) = worker.parts();
    stepper.batch_mut().take_publications();
    stepper.publish_setpoint(robots.values_mut().next().unwrap(), &command(version), Sent::First);
    stepper.batch_mut().take_publications()
}

fn allow(worker: &mut Worker, names: Option<&[&str]>) {
    let mut list = AllowList::default();
    let names = names.map(|names| names.iter().map(|name| Name::robot(name).unwrap()).collect::<HashSet<_>>());
    list.set_listed(names);
    worker.set_allow_list(list);
}

/// A setpoint that waited for the commit or for the broker went to a robot that was excluded meanwhile, and a change of the policy
/// made new ones.
#[test]
fn regress_no_setpoint_goes_to_an_excluded_robot() {
    let mut worker = worker(1);
    let waiting = setpoint(&mut worker, 1);
    assert_eq!(waiting.iter().map(|one| (one.moves(), one.is_withdrawn())).collect::<Vec<_>>(), [(true, false)]);

    allow(&mut worker, Some(&["r1"]));
    assert!(!waiting[0].is_withdrawn(), "it is still allowed");
    allow(&mut worker, Some(&[]));
    assert!(waiting[0].is_withdrawn());
    assert!(setpoint(&mut worker, 2).is_empty());

    allow(&mut worker, None);
    let back = setpoint(&mut worker, 3);
    assert!(back.len() == 1 && !back[0].is_withdrawn(), "it is allowed again");
    assert!(waiting[0].is_withdrawn(), "what was withdrawn stays so");
}

#[test]
fn regress_no_setpoint_goes_to_a_robot_that_was_decommissioned() {
    let mut worker = worker(1);
    let waiting = setpoint(&mut worker, 1);
    let known = worker.take_out(&Name::robot("r1").unwrap()).unwrap();
    worker.forget(known);
    assert!(waiting[0].is_withdrawn());
}
