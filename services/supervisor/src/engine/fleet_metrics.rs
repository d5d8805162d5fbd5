//! Metrics of the fleet as a whole: counts of robots, whiskers and alarms, and latencies. No decision depends on them.

use std::collections::BTreeMap;
use std::time::Duration;

use tracing::debug;
use vibrissa_core::robot::effect::AlarmKind;
use vibrissa_core::robot::{Params, Robot, WhiskerView};
use vibrissa_core::units::Micros;
use vibrissa_edge::presence::Presence;
use vibrissa_edge::words::Word;
use vibrissa_protocol::Name;

use super::message::MessageTimes;
use super::robot::KnownRobot;
use super::worker::workers::Workers;
use crate::clocks::ROBOTS_MAX;
use crate::inbox::Inbox;
use crate::metrics::{FleetMetrics, INBOX, Metrics, OUTBOX, RobotSample, WhiskerSample, Word as Label};
use vibrissa_edge::clock::wall_clock;

const PASCALS_PER_MEGAPASCAL: f64 = 1e6;
const METERS_PER_MILLIMETRE: f64 = 1e-3;

impl FleetMetrics {
    /// Counts a refused message, and logs the reason at level debug.
    pub(super) fn refuse(&self, reason: &'static str, problem: impl std::fmt::Display, topic: &str) {
        self.messages_refused.count([reason]);
        debug!(reason, %problem, topic, "message refused");
    }
}

/// Summary of the compensations of one case.
#[derive(Debug, Default)]
struct CaseSurvey {
    in_force: i64,
    predicted: Mean,
    measured: Mean,
    with_gain: Mean,
    air_alone: Mean,
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
    /// Time of the oldest gap in a robot's numbers, and of the oldest setpoint under way.
    gap_since: Option<Micros>,
    issued: Option<Micros>,
}

impl Survey {
    fn add(&mut self, known: &mut KnownRobot) {
        let (_, link) = known.robot.connection_state();
        let is_silent = known.robot.standing().any(|kind| kind == AlarmKind::RobotSilent);
        *self.robots.entry(Presence::of(link, is_silent).word()).or_default() += 1;
        let receipts = known.repeats.stands().then_some(AlarmKind::ReceiptsUnheard);
        for kind in known.robot.standing().chain(receipts) {
            *self.alarms.entry(kind.word()).or_default() += 1;
        }
        for view in views(&known.robot) {
            *self.whiskers.entry(health(&view)).or_default() += 1;
            for kind in view.standing.kinds() {
                *self.alarms.entry(kind.word()).or_default() += 1;
            }
        }
        let oldest = |one: Option<Micros>, other: Option<Micros>| one.into_iter().chain(other).min();
        self.gap_since = oldest(self.gap_since, known.robot.gap_since());
        for command in known.robot.commands_under_way() {
            self.setpoints_under_way += 1;
            self.issued = oldest(self.issued, Some(command.issued));
        }
        let in_force = known.robot.compensations().iter().filter(|one| !one.is_proposed());
        known.errors.retain(|id| in_force.clone().any(|one| one.id() == id));
        for one in in_force {
            let case = self.cases.entry(one.case().word()).or_default();
            case.in_force += 1;
            let Some(error) = known.errors.get(one.id()) else { continue };
            // Means over the same compensations, so that they are comparable.
            case.predicted.add(one.predicted_error());
            case.measured.add(error.reading);
            case.worst = Some(case.worst.map_or(error.reading, |worst| worst.max(error.reading)));
            error.with_gain.into_iter().for_each(|error| case.with_gain.add(error));
            error.air_alone.into_iter().for_each(|error| case.air_alone.add(error));
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

/// Counts robots, whiskers, alarms and compensations.
pub(super) fn survey_robots(workers: &mut Workers, fleet: &Name, program: &Metrics, metrics: &FleetMetrics) {
    let mut survey = Survey::default();
    for known in workers.robots_mut().filter(|known| !known.is_excluded) {
        survey.add(known);
    }
    let count = |counts: &BTreeMap<Label, i64>, word| counts.get(word).copied().unwrap_or_default();
    metrics.robots.set_all(|word| count(&survey.robots, word));
    metrics.whiskers.set_all(|word| count(&survey.whiskers, word));
    metrics.alarms_standing.set_all(|word| count(&survey.alarms, word));
    metrics.setpoints_under_way.set(survey.setpoints_under_way);
    let now = wall_clock();
    let age = |since: Micros| Duration::from_micros(now.since(since).0);
    metrics.promises.surveyed(survey.gap_since.map(age), survey.issued.map(age));
    let cases = &survey.cases;
    metrics.compensations_in_force.set_all(|case| cases.get(case).map_or(0, |one| one.in_force));
    let mean = |which: fn(&CaseSurvey) -> Option<f64>| move |case| cases.get(case).and_then(which);
    metrics.compensation_error_mean_ratio.set_all(mean(|one| one.measured.value()));
    metrics.compensation_error_worst_ratio.set_all(mean(|one| one.worst));
    metrics.compensation_error_with_gain_mean_ratio.set_all(mean(|one| one.with_gain.value()));
    metrics.compensation_air_error_mean_ratio.set_all(mean(|one| one.air_alone.value()));
    metrics.compensation_predicted_error_mean_ratio.set_all(mean(|one| one.predicted.value()));
    if let Some(whiskers) = &program.whiskers {
        whiskers.show(fleet, workers.in_service().map(|known| sample(known.name.as_str(), known)).collect());
    }
}

/// How far the clocks of some robots are ahead, in µs.
pub(super) fn clocks_ahead_us(workers: &Workers, now: Micros) -> Vec<i64> {
    workers.robots().filter_map(|known| known.robot.clock_ahead_us(now)).take(ROBOTS_MAX).collect()
}

/// Updates the gauges of the queues; `outbox` is the number of publications that wait, and their limit.
pub(super) fn show_queues(metrics: &FleetMetrics, inbox: &Inbox, outbox: Option<(usize, usize)>) {
    let Some((waiting, outbox_capacity)) = outbox else { return };
    let (filling, capacity) = (inbox.filling(), inbox.capacity());
    let of = |inbox: usize, outbox: usize| {
        move |queue| match queue {
            INBOX => inbox as i64,
            OUTBOX => outbox as i64,
            _ => 0,
        }
    };
    metrics.queue_messages.set_all(of(filling.messages, waiting));
    metrics.queue_capacity_messages.set_all(of(capacity.messages, outbox_capacity));
    metrics.inbox_bytes.set(filling.bytes as i64);
    metrics.inbox_capacity_bytes.set(capacity.bytes as i64);
}

/// Updates the gauges of the parameters in force.
pub(super) fn show_params(metrics: &FleetMetrics, params: &Params, policy_version: i64) {
    let policy = &params.policy;
    metrics.policy_mode.set_all(|mode| i64::from(mode == policy.mode.word()));
    metrics.policy_version.set(policy_version);
    metrics.compensation_error_limit_ratio.set(policy.predicted_error_max);
    metrics.detector_arl_contacts.set(params.detection.contacts_between_false_alarms);
}

/// Observes the latencies of the `contacts` messages that are committed now.
pub(super) fn observe_commit(metrics: &FleetMetrics, times: &[MessageTimes]) {
    let now = wall_clock();
    for times in times {
        metrics.received_to_commit_seconds.observe(now.since(times.received).as_s());
        if let Some(newest_contact) = times.newest_contact {
            metrics.contact_to_commit_seconds.observe(now.since(newest_contact).as_s());
        }
        metrics.last_contact_timestamp_seconds.set(times.received.as_s());
    }
}

fn sample(robot: &str, known: &KnownRobot) -> RobotSample {
    let whiskers = views(&known.robot).map(|view| WhiskerSample {
        array: view.array.to_owned(),
        whisker: view.sheet.number,
        length_m: view.length.length.mm() * METERS_PER_MILLIMETRE,
        pressure_pa: view.pressure.map(|pressure| pressure.mpa() * PASCALS_PER_MEGAPASCAL),
        setpoint_pa: view.setpoint.mpa() * PASCALS_PER_MEGAPASCAL,
        health: health(&view),
    });
    let heard = views(&known.robot).filter_map(|view| view.heard).max();
    RobotSample {
        robot: robot.to_owned(),
        heard_s: heard.map(Micros::as_s),
        refused: known.refusals.totals().collect(),
        whiskers: whiskers.collect(),
    }
}
