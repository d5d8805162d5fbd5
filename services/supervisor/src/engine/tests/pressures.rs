//! Setpoints whose pressure is not one of the whisker.

use vibrissa_core::robot::effect::{Command, CommandKey, Reason};
use vibrissa_edge::clock::wall_clock;
use vibrissa_edge::invariants::Invariant::PressureInRange;

use super::*;
use crate::engine::worker::publication::Sent;

#[test]
fn a_setpoint_beyond_the_limit_of_its_whisker_is_counted_once_and_not_published() {
    let mut worker = worker(1);
    let metrics = worker.metrics().clone();
    let (robots, stepper) = worker.parts();
    let known = robots.values_mut().next().unwrap();
    let command = |version: u64, pressure_mpa: f64| Command {
        key: CommandKey { epoch: 7, version },
        whisker: 2,
        robot_boot_id: "b".to_owned(),
        pressure: Megapascal::known(pressure_mpa),
        slew_mpa_per_s: 0.02,
        issued: wall_clock(),
        expires: Micros(0),
        reason: Reason::Release,
        compensation: None,
        gain: None,
    };
    stepper.batch_mut().take_publications();
    stepper.publish_setpoint(known, &command(1, 0.2), Sent::First);
    assert_eq!((stepper.batch_mut().take_publications().len(), metrics.violations.of(PressureInRange)), (1, 0));
    for sent in [Sent::First, Sent::Again, Sent::Again] {
        stepper.publish_setpoint(known, &command(2, 0.2 + 1e-9), sent);
        assert_eq!((stepper.batch_mut().take_publications().len(), metrics.violations.of(PressureInRange)), (0, 1));
    }
    stepper.batch_mut().set_number(8);
    stepper.publish_setpoint(known, &command(3, 0.0), Sent::First);
    let transactions: Vec<i64> = stepper.batch_mut().take_publications().iter().map(|one| one.transaction).collect();
    assert_eq!(transactions, [8], "the publication belongs to the open batch");
}
