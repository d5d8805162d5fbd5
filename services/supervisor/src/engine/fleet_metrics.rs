//! Metrics of the fleet as a whole: counts of robots, whiskers and alarms, and latencies. No decision depends on them.
//!
//! Also closes minutes and hours of whiskers without contacts.

use std::collections::BTreeMap;

use vibrissa_core::policy::Case;
use vibrissa_core::robot::effect::{Command, CommandKey, CompensationError, Reason};
use vibrissa_core::robot::{Params, Robot, WhiskerView};
use vibrissa_core::units::Micros;
use vibrissa_edge::words::Word;

use super::Engine;
use super::commit::batch::Gathering;
use super::shard::{Known, Shard};
use crate::inbox::Inbox;
use crate::metrics::{INBOX, OUTBOX, RobotSample, WhiskerSample, Word as Label};
use vibrissa_edge::clock::wall_clock;

const PASCALS_PER_MEGAPASCAL: f64 = 1e6;
const METERS_PER_MILLIMETRE: f64 = 1e-3;

/// Limit of the whiskers whose minutes are closed in one commit. Their checkpoints are written with them, and a robot's
/// checkpoint includes all its changed whiskers.
const CLOSED_AT_ONCE: usize = 5000;

/// Times of a `contacts` message.
#[derive(Debug, Clone, Copy)]
pub(super) struct Taken {
    /// Time of the newest contact by the robot's clock; `None` if the message has no contacts.
    pub(super) felt: Option<Micros>,
    /// Time of receipt.
    pub(super) received: Micros,
}

/// The setpoint to which a message is an answer.
#[derive(Debug, Clone, Copy)]
pub(super) struct Answering {
    pub(super) command: CommandKey,
    /// Receipt time of the message that led to the setpoint.
    since: Micros,
    reason: Reason,
}

impl Answering {
    pub(super) fn to(command: &Command) -> Self {
        Self { command: command.key, since: command.issued, reason: command.reason }
    }
}

/// Last measured compensation errors with and without the published gain, by number of the compensation.
#[derive(Debug, Default)]
pub(super) struct Stated(BTreeMap<u32, (f64, Option<f64>)>);

impl Stated {
    /// Restores the errors from the state of a loaded robot.
    pub(super) fn of(robot: &Robot, params: &Params) -> Self {
        let mut stated = Self::default();
        for error in robot.compensations().iter().filter_map(|one| robot.error(params, one)) {
            stated.state(&error);
        }
        stated
    }

    pub(super) fn state(&mut self, error: &CompensationError) {
        self.0.insert(error.compensation, (error.mean, error.with_gain.map(|(mean, _)| mean)));
    }
}

impl Known {
    /// Target of a compensation that is in force or proposed.
    pub(super) fn target_of(&self, compensation: u32) -> Option<usize> {
        self.robot.compensations().iter().find(|one| one.id() == compensation).map(|one| one.target())
    }

    /// Case of a compensation that is in force or proposed.
    pub(super) fn case_of(&self, compensation: u32) -> Option<Case> {
        self.robot.compensations().iter().find(|one| one.id() == compensation).map(|one| one.case())
    }
}

/// Summary of the compensations of one case.
#[derive(Debug, Default)]
struct CaseSurvey {
    in_force: i64,
    predicted: Mean,
    measured: Mean,
    with_gain: Mean,
    worst: Option<f64>,
}

#[derive(Debug, Default, Clone, Copy)]
struct Mean {
    sum: f64,
    count: u32,
}

impl Mean {
    fn add(&mut self, value: f64) {
        self.sum += value;
        self.count += 1;
    }

    fn value(self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / f64::from(self.count))
    }
}

/// Counts of a fleet.
#[derive(Debug, Default)]
struct Survey {
    robots: BTreeMap<Label, i64>,
    whiskers: BTreeMap<Label, i64>,
    alarms: BTreeMap<Label, i64>,
    cases: BTreeMap<Label, CaseSurvey>,
    setpoints_under_way: i64,
}

impl Survey {
    fn add(&mut self, known: &mut Known) {
        let (_, link) = known.robot.connection_state();
        *self.robots.entry(link.word()).or_default() += 1;
        for view in views(&known.robot) {
            *self.whiskers.entry(health(&view)).or_default() += 1;
            for kind in view.standing.kinds() {
                *self.alarms.entry(kind.word()).or_default() += 1;
            }
        }
        self.setpoints_under_way += known.robot.commands_under_way().count() as i64;
        let in_force = known.robot.compensations().iter().filter(|one| !one.is_proposed());
        known.stated.0.retain(|&id, _| in_force.clone().any(|one| one.id() == id));
        for one in in_force {
            let case = self.cases.entry(one.case().word()).or_default();
            case.in_force += 1;
            let Some(&(error, with_gain)) = known.stated.0.get(&one.id()) else { continue };
            // Means over the same compensations, so that they are comparable.
            case.predicted.add(one.predicted_error());
            case.measured.add(error);
            case.worst = Some(case.worst.map_or(error, |worst| worst.max(error)));
            if let Some(with_gain) = with_gain {
                case.with_gain.add(with_gain);
            }
        }
    }
}

fn views(robot: &Robot) -> impl Iterator<Item = WhiskerView<'_>> {
    (0..robot.whisker_count()).filter_map(|index| robot.whisker(index))
}

/// The fault, if there is one, else the condition.
fn health(view: &WhiskerView<'_>) -> Label {
    view.fault.map_or(view.condition.word(), Word::word)
}

impl Engine {
    /// Counts robots, whiskers, alarms and compensations.
    pub(super) fn survey_robots(&mut self) {
        let mut survey = Survey::default();
        for known in self.shards.iter_mut().flat_map(|shard| shard.robots.values_mut()) {
            survey.add(known);
        }
        let count = |counts: &BTreeMap<Label, i64>, word| counts.get(word).copied().unwrap_or_default();
        self.metrics.robots.set_all(|word| count(&survey.robots, word));
        self.metrics.whiskers.set_all(|word| count(&survey.whiskers, word));
        self.metrics.alarms_standing.set_all(|word| count(&survey.alarms, word));
        self.metrics.setpoints_under_way.set(survey.setpoints_under_way);
        let cases = &survey.cases;
        self.metrics.compensations_in_force.set_all(|case| cases.get(case).map_or(0, |one| one.in_force));
        let mean = |which: fn(&CaseSurvey) -> Option<f64>| move |case| cases.get(case).and_then(which);
        self.metrics.compensation_error_mean_ratio.set_all(mean(|one| one.measured.value()));
        self.metrics.compensation_error_worst_ratio.set_all(mean(|one| one.worst));
        self.metrics.compensation_error_with_gain_mean_ratio.set_all(mean(|one| one.with_gain.value()));
        self.metrics.compensation_predicted_error_mean_ratio.set_all(mean(|one| one.predicted.value()));
        if let Some(whiskers) = &self.program.whiskers {
            let known = self.shards.iter().flat_map(|shard| shard.robots.values());
            whiskers.show(self.fleet.as_str(), known.map(|known| sample(known.name.as_str(), known)).collect());
        }
    }

    /// Closes finished minutes and hours, including those of silent whiskers; in a large fleet a limited number at a
    /// time.
    pub(super) fn close_history(&mut self, now: Micros) {
        let mut left = CLOSED_AT_ONCE;
        for Shard { robots, gathering, .. } in &mut self.shards {
            for known in robots.values_mut().filter(|known| !known.rests) {
                if known.history.close(now, &known.whisker_ids, &mut left, &mut gathering.batch) {
                    gathering.store_next(known);
                    left = left.saturating_sub(known.whisker_ids.len());
                }
            }
        }
        self.gathered(0);
    }

    /// Updates the gauges of the queues.
    pub(super) fn survey_queues(&self, inbox: &Inbox) {
        let Some(outbox) = &self.outbox else { return };
        let (filling, capacity) = (inbox.filling(), inbox.capacity());
        let waiting = outbox.max_capacity() - outbox.capacity();
        let of = |inbox: usize, outbox: usize| {
            move |queue| match queue {
                INBOX => inbox as i64,
                OUTBOX => outbox as i64,
                _ => 0,
            }
        };
        self.metrics.queue_messages.set_all(of(filling.messages, waiting));
        self.metrics.queue_capacity_messages.set_all(of(capacity.messages, outbox.max_capacity()));
        self.metrics.inbox_bytes.set(filling.bytes as i64);
        self.metrics.inbox_capacity_bytes.set(capacity.bytes as i64);
    }

    /// Updates the gauges of the parameters in force.
    pub(super) fn show_params(&self) {
        let policy = &self.params.policy;
        self.metrics.policy_mode.set_all(|mode| i64::from(mode == policy.mode.word()));
        self.metrics.policy_version.set(self.policy_version);
        self.metrics.compensation_error_limit_ratio.set(policy.predicted_error_max);
        self.metrics.detector_arl_contacts.set(self.params.detection.contacts_between_false_alarms);
    }

    /// Observes the latencies of the `contacts` messages that are committed now.
    pub(super) fn time_taken(&self, taken: &[Taken]) {
        let now = wall_clock();
        for taken in taken {
            self.metrics.received_to_commit_seconds.observe(now.since(taken.received).as_s());
            if let Some(felt) = taken.felt {
                self.metrics.contact_to_commit_seconds.observe(now.since(felt).as_s());
            }
            self.metrics.last_contact_timestamp_seconds.set(taken.received.as_s());
        }
    }
}

impl Gathering {
    /// Observes the time until a setpoint was applied.
    pub(super) fn time_applied(&self, command: CommandKey) {
        if let Some(answering) = self.answering.filter(|answering| answering.command == command) {
            let seconds = wall_clock().since(answering.since).as_s();
            self.metrics.setpoint_application_seconds.of(answering.reason.word()).observe(seconds);
        }
    }
}

fn sample(robot: &str, known: &Known) -> RobotSample {
    let whiskers = views(&known.robot).map(|view| WhiskerSample {
        array: view.array.to_owned(),
        whisker: view.sheet.number,
        length_m: view.length.length.mm() * METERS_PER_MILLIMETRE,
        pressure_pa: view.pressure.map(|pressure| pressure.mpa() * PASCALS_PER_MEGAPASCAL),
        setpoint_pa: view.setpoint.mpa() * PASCALS_PER_MEGAPASCAL,
        health: health(&view),
    });
    let heard = views(&known.robot).filter_map(|view| view.heard).max();
    RobotSample { robot: robot.to_owned(), heard_s: heard.map(Micros::as_s), whiskers: whiskers.collect() }
}
