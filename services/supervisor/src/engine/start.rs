//! Start of an engine: the fleet is loaded as of its last commit.

use std::sync::Arc;

use tokio::runtime::Handle;
use tokio::sync::watch;
use tokio::time::Instant;
use tracing::{error, info};
use vibrissa_core::robot::Params;
use vibrissa_core::robot::effect::AlarmKind;
use vibrissa_host::task;
use vibrissa_protocol::{BootId, Name};

use super::actions::ParamsInForce;
use super::allow_list_sources::AllowListSources;
use super::birth_watch::BirthWatch;
use super::commit::committer::Committer;
use super::pipeline::Pipeline;
use super::pipeline::recovery::recover;
use super::quarantine::suspects::Suspects;
use super::robot::limits::Bucket;
use super::rollout::Rollout;
use super::worker::Worker;
use super::worker::contact_events::ContactEvents;
use super::worker::stepper::Stepper;
use super::worker::workers::Workers;
use super::{ContactRetention, Engine, Limits, fleet_metrics};
use crate::action_notifier::ActionNotifier;
use crate::black_box::BlackBoxes;
use crate::clocks::{RobotClocks, SET_FROM_US};
use crate::events::EventSink;
use crate::log_inbox::{LogSource, NextOffsets};
use crate::metrics::{FleetMetrics, Metrics};
use crate::params;
use crate::readiness::Readiness;
use crate::robots_file::RobotsFile;
use crate::set_aside::Reader;
use crate::trace::{OpenTraces, Traces};
use vibrissa_edge::clock::wall_clock;
use vibrissa_edge::words::Word as _;
use vibrissa_store::maintenance_facts::LastTest;
use vibrissa_store::{Lease, StoreError, Writer};

/// A day in µs.
const DAY_US: i64 = 86_400_000_000;
/// Largest number of workers per fleet.
const WORKERS_MAX: usize = 16;

/// Settings and connections of an engine.
pub(crate) struct EngineOptions {
    /// Ownership of the fleet.
    pub(crate) lease: Lease,
    /// Boot id of this supervisor for the fleet.
    pub(crate) boot_id: BootId,
    /// Parameters of the configuration; the fleet's policy and calibrations in the database take precedence.
    pub(crate) params: Arc<Params>,
    /// Connection to the database.
    pub(crate) writer: Writer,
    /// Metrics shared by all fleets.
    pub(crate) metrics: Metrics,
    pub(crate) readiness: Readiness,
    pub(crate) action_notifier: ActionNotifier,
    /// Which contacts get a row of their own.
    pub(crate) retention: ContactRetention,
    /// Limits on the number of robots.
    pub(crate) limits: Limits,
    /// Allowed robots, which may change later.
    pub(crate) robots_file: Option<watch::Receiver<Arc<RobotsFile>>>,
    /// Events for other programs, if they are published.
    pub(crate) events: Option<EventSink>,
    /// The partitioned log that contacts come from, if there is one.
    pub(crate) log: Option<LogSource>,
    /// Black boxes of the robots.
    pub(crate) boxes: BlackBoxes,
    /// Takes the clocks of the robots.
    pub(crate) robot_clocks: RobotClocks,
    /// Whether the contacts are archived.
    pub(crate) is_archived: bool,
    /// The last touch tests of whiskers, if facts for their maintenance are published.
    pub(crate) last_tests: Vec<LastTest>,
    /// Traces, if there is a collector; those of setpoints under way are continued.
    pub(crate) traces: Option<Traces>,
}

/// The part of a fleet that is not ready while stored items were set aside.
const STORED: &str = "stored";

/// The part of a fleet with robots that wait for a newer version of the program.
const NEWER: &str = "newer program";

/// One worker per core.
fn worker_count() -> usize {
    task::cores().min(WORKERS_MAX)
}

impl EngineOptions {
    /// Loads every robot of a fleet as of the last commit.
    ///
    /// # Errors
    /// The database cannot be used, or the lease is lost.
    pub(crate) async fn start(self) -> Result<Engine, StoreError> {
        let Self { lease, boot_id, mut writer, metrics: program, readiness, action_notifier, .. } = self;
        let (fleet, epoch) = (lease.fleet().clone(), lease.epoch());
        // Before anything is read, so that no change is missed.
        let action_sent = action_notifier.subscribe(lease.fleet());
        let metrics = program.of_fleet(lease.fleet());
        let policy = writer.policy(&lease).await?;
        let unreadable_policies = policy.iter().filter(|policy| policy.params().is_none()).count() as u64;
        metrics.set_aside(Reader::Policy, unreadable_policies);
        let params = params::with_policy(self.params, policy.as_ref());
        let (params, unusable) = params::with_calibrations(params, &writer.calibrations(&lease).await?);
        metrics.set_aside(Reader::Calibration, unusable);
        let policy_version = match policy {
            Some(policy) => policy.version,
            None => writer.policy_version(&lease).await?,
        };
        let stepper = || {
            let (fleet, boot_id, params) = (fleet.clone(), boot_id.clone(), params.clone());
            Stepper::new(fleet, boot_id, params, metrics.clone())
        };
        let count = worker_count();
        let mut workers = Workers::new((0..count).map(|_| Worker::new(stepper(), epoch, count)).collect());
        for worker in workers.iter_mut() {
            worker.stepper_mut().set_publishes_maintenance(self.limits.maintenance_every.is_some());
            if let Some(sink) = &self.events {
                worker.stepper_mut().set_contact_events(ContactEvents::new(sink.clone()));
            }
        }
        let (rollout, unreadable_rollouts) = open_rollout(&mut writer, &lease, &params, &metrics).await?;
        workers.set_trial(rollout.as_ref().map(Rollout::trial).as_ref());
        let allowed = writer.allowed_robots(&lease, 0).await?;
        let last = recover(&mut writer, &lease, &mut workers, self.log.as_ref()).await?;
        workers.know_tests(&self.last_tests);
        let of_log = self.log.as_ref().map_or(0, LogSource::set_aside);
        let set_aside = unreadable_policies + unusable + unreadable_rollouts + workers.set_aside() + of_log;
        if set_aside > 0 {
            let what = format!("{set_aside} stored items cannot be read and are set aside: see the log");
            readiness.tell_set_aside(lease.fleet(), STORED, &what);
        }
        readiness.notice_of(lease.fleet(), NEWER, workers.left_to_newer_program());
        // Also without an archive here: the last owner may have had one.
        let contacts_from_us = writer.archive_floor(&fleet).await?;
        let mut log_from = NextOffsets::new();
        if let Some(log) = &self.log {
            workers.use_log();
            log_from = writer.log_positions(&lease, log.topic()).await?;
        }
        workers.set_retention(self.retention);
        let boxes = self.boxes.of_fleet(&lease, &metrics.black_boxes_lost);
        writer.end_black_boxes(&lease).await?;
        let unheard = writer.robots_with_alarm(&lease, AlarmKind::ReceiptsUnheard.word()).await?;
        for known in workers.robots_mut().filter(|known| unheard.contains(&known.robot_id)) {
            known.repeats.take_up(wall_clock());
        }
        for worker in workers.iter_mut() {
            worker.stepper_mut().set_boxes(boxes.clone());
        }
        info!(fleet = %lease.fleet(), epoch, robots = workers.robot_count(), "fleet loaded, supervision starts");
        // As if a contact had just arrived, so that a silent fleet counts as silent from now on.
        metrics.last_contact_timestamp_seconds.set(wall_clock().as_s());
        let committer = Committer::new(lease.clone(), writer, program.clone(), self.log.clone());
        let background = Handle::current();
        let mut pipeline = Pipeline::new(committer, last, metrics.clone(), background.clone());
        // Contacts that a host receives before its clock is set would be deleted as old.
        let is_clock_set = wall_clock().0 as i64 >= SET_FROM_US;
        let last_owner_us = i64::try_from(epoch.saturating_mul(1000)).unwrap_or_default();
        let set_from_us = if is_clock_set { 0 } else { last_owner_us.saturating_sub(DAY_US) };
        pipeline.set_contacts_from(contacts_from_us.max(set_from_us));
        if let Some(log) = &self.log {
            pipeline.use_log(log.topic());
        }
        workers.set_number(pipeline.open_number());
        fleet_metrics::show_params(&metrics, &params, policy_version);
        fleet_metrics::survey_robots(&mut workers, &fleet, &program, &metrics);
        if let Some(traces) = &self.traces {
            trace(&mut workers, &fleet, traces);
        }
        let new_robots_per_minute = self.limits.new_robots_per_minute;
        Ok(Engine {
            allow_list: AllowListSources::new(fleet.clone(), allowed.as_ref(), self.robots_file, &mut workers),
            suspects: Suspects::new(lease, metrics.clone(), readiness.clone()),
            readiness,
            in_force: ParamsInForce { params, policy_version },
            rollout,
            action_sent,
            action_notifier,
            birth_watch: BirthWatch::new(),
            limits: self.limits,
            new_robots: Bucket::new(new_robots_per_minute, new_robots_per_minute),
            robot_clocks: self.robot_clocks,
            survey_from: Instant::now(),
            refusals_told_from: Instant::now(),
            refusals_written_to: 0,
            is_archived: self.is_archived,
            awake: Instant::now(),
            fleet,
            workers,
            pipeline,
            background,
            boxes,
            log_from,
            log: self.log,
            lacked_factsheets: false,
            events: self.events.map(|sink| sink.committed),
            program,
            promises: metrics.promises.clone(),
            metrics,
        })
    }
}

/// The roll-out that the last owner left running or paused. One that this program cannot read stays as it is: its robots get
/// the parameters in force in the fleet, and the result has 1 as the number of unreadable ones.
async fn open_rollout(
    writer: &mut Writer,
    lease: &Lease,
    params: &Arc<Params>,
    metrics: &FleetMetrics,
) -> Result<(Option<Rollout>, u64), StoreError> {
    let Some(row) = writer.open_rollout(lease).await? else { return Ok((None, 0)) };
    let rollout_id = row.rollout_id;
    match Rollout::restored(row, params) {
        Ok(rollout) => Ok((Some(rollout), 0)),
        Err(problem) => {
            error!(fleet = %lease.fleet(), rollout_id, problem, "cannot go on with a roll-out");
            metrics.set_aside(Reader::Rollout, 1);
            Ok((None, 1))
        }
    }
}

/// Adds traces, which continue those of setpoints under way.
fn trace(workers: &mut Workers, fleet: &Name, traces: &Traces) {
    for worker in workers.iter_mut() {
        let (robots, stepper) = worker.parts();
        let mut open = OpenTraces::new(traces.clone(), fleet.clone());
        for known in robots.values() {
            open.take_up(&known.name, known.robot_id, &known.robot);
        }
        stepper.set_traces(open);
    }
}
