//! Publications: setpoints, receipts, requests. They leave with the sealed batch, after its commit.

use std::time::Duration;

use tokio::time::Instant;
use vibrissa_core::robot::effect::{Command, TouchTest};
use vibrissa_core::units::Micros;
use vibrissa_host::clock::host_clock_us;
use vibrissa_protocol::{self as protocol, BootId, Name, RequestKind, RobotTopic, Timestamp};
use vibrissa_store::fault::{self, Fault};

use super::Worker;
use super::stepper::Stepper;
use crate::engine::commit::checkpoint::CheckpointRate;
use crate::engine::commit::transaction::SealedTransaction;
use crate::engine::robot::KnownRobot;
use crate::engine::robot::seqs::Seqs;
use crate::outbox::{Publication, Stopwatch, ToRobot};
use vibrissa_edge as edge;
use vibrissa_edge::clock::wall_clock;
use vibrissa_edge::contract::setpoint_reason;
use vibrissa_edge::ids::{command_id, command_uuid};
use vibrissa_edge::invariants::Invariant::PressureInRange;
use vibrissa_edge::invariants::is_pressure_in_range;
use vibrissa_edge::words::Word;

/// Limit of `held` ranges in a receipt; the core keeps no more.
const HELD_MAX: usize = 64;

/// Whether a setpoint is sent for the first time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sent {
    First,
    Again,
}

/// Receipts and waiting checkpoints are part of a transaction.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Receipts {
    /// Time of sealing.
    pub(crate) now: Micros,
    /// Limit of the worker's robots that get receipts.
    pub(crate) robots_max: usize,
}

impl Worker {
    pub(super) fn is_receipt_due(&self) -> bool {
        !self.stepper.receipts_due.is_empty()
    }

    /// Adds receipts to the open batch, which are published after the commit and state how far the contacts of each
    /// boot are committed. At most `most` robots, or a quarter of those due if that is more, get theirs now: the broker
    /// forwards each receipt as a message, and a later receipt covers more contacts.
    pub(crate) fn publish_receipts(&mut self, most: usize) {
        let due = &mut self.stepper.receipts_due;
        let most = most.max(due.len() / 4).min(due.len());
        let later = due.split_off(most);
        for name in std::mem::replace(due, later) {
            let Some(known) = self.robots.get_mut(&name) else { continue };
            for boot_id in std::mem::take(&mut known.receipts_due) {
                self.stepper.publish_receipt(known, boot_id.as_str());
            }
        }
    }

    /// Seals the open batch by appending it to those of other workers, with the checkpoints that are due.
    pub(crate) fn seal_into(
        &mut self,
        transaction: &mut SealedTransaction,
        rate: &mut CheckpointRate,
        receipts: Option<Receipts>,
    ) {
        self.stepper.batch.write_decided_checkpoints(&mut self.robots, rate);
        if let Some(Receipts { now, robots_max }) = receipts {
            self.stepper.batch.write_due_checkpoints(&mut self.robots, now, rate);
            self.publish_receipts(robots_max);
        }
        self.stepper.batch.seal_into(transaction);
        transaction.push_spans(self.stepper.seal_spans());
    }
}

impl Stepper {
    /// Publishes a setpoint, unless it has expired, its pressure is not one of the whisker, or the allow list excludes the robot.
    pub(crate) fn publish_setpoint(&mut self, known: &mut KnownRobot, command: &Command, sent: Sent) {
        if known.is_excluded {
            return;
        }
        let Some(whisker) = known.robot.whisker(command.whisker) else { return };
        let (pressure_mpa, limit_mpa) = (command.pressure.mpa(), whisker.sheet.pressure_max.mpa());
        if !is_pressure_in_range(pressure_mpa, limit_mpa) {
            if sent == Sent::First {
                let what = format!("a setpoint of {pressure_mpa} MPa, and the limit is {limit_mpa} MPa");
                self.metrics.violations.count(PressureInRange, &known.full_name_of(command.whisker), &what);
            }
            return;
        }
        let (Ok(array), Ok(robot_boot_id)) = (Name::new(whisker.array), BootId::new(&command.robot_boot_id)) else {
            return;
        };
        let under_way = known.robot.commands_under_way().count();
        let valid_for = known.robot.valid_for(self.params_of(&known.name), command.whisker, command.pressure);
        let id = command_uuid(&self.fleet, &known.name, command.key);
        let until = known.commands.until(command, id, (wall_clock(), valid_for), under_way);
        if until <= Instant::now() {
            // The core's clock may be behind, and the robot's may be wrong: the monotonic clock decides.
            self.metrics.setpoints_expired_unsent.inc();
            return;
        }
        let (gain, reading_gain) = edge::gain(command.gain.as_ref());
        let expires_us = match fault::is(Fault::ExpiryByHostClock) {
            true => host_clock_us() as u64 + valid_for.0,
            false => command.expires.0,
        };
        let setpoint = protocol::Setpoint {
            boot_id: self.boot_id.clone(),
            seq: known.seqs.next_setpoint(),
            command_id: id.to_string(),
            epoch: command.key.epoch,
            version: command.key.version,
            robot_boot_id,
            array,
            whisker: whisker.sheet.number,
            pressure_mpa,
            slew_mpa_per_s: command.slew_mpa_per_s,
            issued: Timestamp(command.issued.0),
            expires_us,
            reason: setpoint_reason(command.reason),
            gain,
            reading_gain,
        };
        let stopwatch = match sent {
            Sent::First => {
                let seconds = self.metrics.setpoint_publication_seconds.of(command.reason.word());
                Some(Stopwatch { since: command.issued, seconds })
            }
            Sent::Again => {
                self.metrics.setpoints_resent.inc();
                None
            }
        };
        let publication = Publication::new(known.name.clone(), ToRobot::Setpoint(Box::new(setpoint)));
        let withdrawal = Some(known.withdrawal.clone());
        self.batch.publish_setpoint(Publication { until: Some(until), stopwatch, withdrawal, ..publication });
        if let Some(traces) = &mut self.traces {
            traces.sending(&known.name, command);
        }
    }

    /// Sends the setpoints under way again after a birth or a restored connection: the robot may have reported their
    /// results while no supervisor listened, and repeats its report for the same `command_id`.
    pub(super) fn resend_setpoints(&mut self, known: &mut KnownRobot) {
        let under_way: Vec<Command> = known.robot.commands_to_repeat().cloned().collect();
        for command in &under_way {
            self.publish_setpoint(known, command, Sent::Again);
        }
    }

    pub(super) fn publish_request(&mut self, robot: &Name, seqs: &mut Seqs, request: RequestKind) {
        let (boot_id, seq) = (self.boot_id.clone(), seqs.next_request());
        let request = protocol::Request { boot_id, seq, request, touch_test: None };
        self.batch.publish(Publication::new(robot.clone(), ToRobot::Request(request)));
    }

    /// Requests a touch test, unless the allow list excludes the robot. The broker forgets it when the robot would reject it as
    /// expired.
    pub(super) fn publish_test(&mut self, known: &mut KnownRobot, test: &TouchTest) {
        if known.is_excluded {
            return;
        }
        let test_id = command_id(&self.fleet, &known.name, test.key);
        let sender = (self.boot_id.clone(), known.seqs.next_request());
        let Some(request) = edge::touch_tests::request(&known.robot, test, test_id, sender) else { return };
        let valid_for = Duration::from_micros(self.params.command.time_to_live.0);
        let publication = Publication::new(known.name.clone(), ToRobot::Request(request));
        let (until, withdrawal) = (Some(Instant::now() + valid_for), Some(known.withdrawal.clone()));
        self.batch.publish(Publication { until, withdrawal, ..publication });
    }

    /// Clears the retained messages of a robot that has left for good: new clients must not take it for a present one.
    pub(super) fn clear_retained(&mut self, robot: &Name) {
        // Without the setting an older access list may not let it write the optional topic.
        let is_written = |kind: &RobotTopic| *kind != RobotTopic::Maintenance || self.publishes_maintenance;
        let kinds = RobotTopic::ALL.into_iter().filter(|kind| kind.is_retained() && is_written(kind));
        for kind in kinds.collect::<Vec<_>>() {
            self.batch.publish(Publication::new(robot.clone(), ToRobot::Cleared(kind)));
        }
    }

    /// Marks the contacts of a boot as due for a receipt.
    pub(crate) fn receipt(&mut self, known: &mut KnownRobot, boot_id: &str) {
        if known.receipts_due.is_empty() {
            self.receipts_due.push(known.name.clone());
        }
        if !known.receipts_due.iter().any(|due| *due == *boot_id) {
            known.receipts_due.push(boot_id.into());
        }
    }

    pub(super) fn publish_receipt(&mut self, known: &mut KnownRobot, boot_id: &str) {
        let (Some(sequence), Ok(robot_boot_id)) = (known.robot.sequence(boot_id), BootId::new(boot_id)) else {
            return;
        };
        let receipt = protocol::Receipt {
            boot_id: self.boot_id.clone(),
            seq: known.seqs.next_receipt(),
            robot_boot_id,
            next: sequence.next(),
            held: sequence.held().iter().copied().take(HELD_MAX).collect(),
        };
        known.repeats.receipted(known.boot(boot_id), receipt.next, wall_clock());
        self.batch.publish(Publication::new(known.name.clone(), ToRobot::Receipt(receipt)));
        self.metrics.receipts_sent.inc();
    }
}
