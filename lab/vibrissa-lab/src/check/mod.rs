//! Tests whether a robot conforms to the contract, rule by rule, in place of its supervisor. For robot developers.
//!
//! It receives all messages of the robot ([`listener`]: rules for every message). Then it tests, in this order,
//! contacts and receipts ([`contacts`]), status and requests ([`opening`]), setpoints ([`setpoints`], [`refusals`]),
//! touch tests ([`touch_tests`]), the gain of readings ([`gains`]), and a restart ([`restart`]).
//!
//! If somebody helps at the robot ([`action`]), it also tests a closed air supply ([`supply`]), a full memory ([`memory`]),
//! the loss of the supervisor ([`silence`]), the end of the robot's program ([`farewell`]), and estimates of lengths
//! ([`estimates`]). A relay records the robot's topics ([`own_level`]).
//!
//! **Epochs.** Until it restarts, a robot refuses setpoints of an epoch below the highest that it has seen for a
//! whisker. Therefore the check uses the *last supervisor's own epoch*, which the broker retains, with versions far
//! above those that supervisors count from one. Every supervisor takes a fleet over in a new epoch, higher by at least
//! one, so that the robot obeys the next one at once. The price: if the last supervisor was only disconnected and
//! returns in its old epoch, the robot refuses its setpoints as STALE.

mod action;
mod arrival;
mod assisted;
mod bench;
mod contacts;
mod divisor;
mod estimates;
mod farewell;
mod gains;
mod ledger;
mod listener;
mod log;
mod memory;
mod opening;
mod own_level;
mod queries;
mod refusals;
mod report;
mod restart;
mod setpoints;
mod silence;
mod supply;
mod timings;
mod touch_tests;
mod touched;

use anyhow::Context;
use tokio::time::Instant;
use vibrissa_protocol::{Message, Name, RobotTopic, Topic};

pub use action::{Action, Progress, Spot};
pub use arrival::wait_for_robot;
pub use report::{Finding, Outcome, Report};
pub use timings::{Help, Timings};

use assisted::Told;
use bench::{Bench, Trial};
use vibrissa_edge::clock::wall_clock;
use vibrissa_supervisor::mqtt::{Connection, RelayRecord, TestClient};

/// Options of a check.
#[derive(Debug, Clone)]
pub struct CheckOptions {
    /// Fleet of the robot.
    pub fleet: Name,
    /// Name of the robot.
    pub robot: Name,
    /// Whisker on which setpoints are tried; by default the first of the factsheet.
    pub whisker: Option<(Name, u16)>,
    /// Epoch of these setpoints; by default the last supervisor's, or 0 if the broker knows none.
    pub epoch: Option<u64>,
    /// Help at the robot, without which some rules are not tested.
    pub help: Help,
    /// Record of the relay through which the robot reaches the broker.
    pub relay: Option<RelayRecord>,
    /// Time limits of the check.
    pub timings: Timings,
}

/// Checks a robot until the end or until `stop`. Then it restores the pressure and reports what was found so far.
///
/// # Errors
/// There is no broker, a supervisor owns the fleet, the robot is not connected, or it has seen a higher epoch.
pub async fn check(
    connection: &Connection,
    options: CheckOptions,
    progress: &mut (dyn FnMut(Progress) + Send),
    stop: impl Future<Output = ()>,
) -> anyhow::Result<Report> {
    let begun = Instant::now();
    let (fleet, robot) = (options.fleet.clone(), options.robot.clone());
    let of_robot = RobotTopic::ALL.into_iter().filter(|kind| kind.is_from_robot()).map(|kind| kind.of(&fleet, &robot));
    let supervisor = Topic::SupervisorState { fleet: fleet.clone() };
    let topics: Vec<String> = of_robot.chain([supervisor]).map(|topic| topic.to_string()).collect();
    let client = TestClient::open(connection, &topics).await?;
    let retains = client.retains();
    let mut bench = Bench::new(client, options, connection.boot_id.clone());
    bench.heard.retains = retains;
    let ended = tokio::select! {
        ended = run(&mut bench, connection, progress) => Some(ended),
        () = stop => None,
    };
    let unseen = match &ended {
        Some(_) => "not observed",
        None => "the check was interrupted",
    };
    let is_interrupted = ended.is_none();
    let undone = put_back(&mut bench).await;
    bench.own_level();
    if let Some(ended) = ended {
        // Without a report, the helper must be told all the same.
        undone.into_iter().fold(ended, |ended, undone| ended.context(undone))?;
    } else {
        bench.heard.findings.note("interrupted: the missing rules were not tested".to_owned());
    }
    let (whisker, epoch) =
        (bench.trial.as_ref().map(|trial| format!("{}/{}", trial.array, trial.whisker)), bench.epoch);
    let (findings, notes) = bench.close().await.findings.close(unseen);
    let (fleet, robot) = (fleet.to_string(), robot.to_string());
    let seconds = begun.elapsed().as_secs_f64();
    Ok(Report { fleet, robot, whisker, epoch, seconds, is_interrupted, findings, notes })
}

async fn run(bench: &mut Bench, connection: &Connection, progress: Told<'_>) -> anyhow::Result<()> {
    progress(Progress::Step("reading the retained messages"));
    bench.open().await?;
    take_epoch(bench);
    progress(Progress::Step("contacts and receipts: keep touching its whiskers now"));
    bench.contacts().await?;
    progress(Progress::Step("watching its status"));
    bench.watch().await?;
    progress(Progress::Step("requests"));
    bench.ask().await?;
    bench.choose().await?;
    if let Some(trial) = bench.trial.clone() {
        tell_trial(bench, &trial);
        progress(Progress::Step("setpoints"));
        bench.setpoints(&trial).await?;
        progress(Progress::Step("setpoints that the robot must refuse"));
        bench.refusals(&trial).await?;
        progress(Progress::Step("touch tests"));
        bench.touch_tests(&trial).await?;
        progress(Progress::Step("the gain of readings"));
        bench.gains(&trial).await?;
    }
    progress(Progress::Step("malformed messages"));
    bench.malformed().await?;
    // Before the power is cut, because the robot may then change the pressure on its own.
    bench.go_home().await?;
    let is_assisted = bench.options.help == Help::All;
    if is_assisted {
        with_help(bench, progress).await?;
    } else {
        bench.skip(&assisted::RULES, "requires --assisted, and somebody at the robot, or --assistant");
    }
    progress(Progress::Step("restart"));
    bench.restart(progress).await?;
    if is_assisted {
        progress(Progress::Step("the end of the robot's program, and its next start"));
        if !bench.farewell(progress).await? {
            bench.skip(&assisted::RULES, "the robot was not started again");
            return Ok(());
        }
        progress(Progress::Step("estimates of lengths"));
        bench.estimates(connection, progress).await?;
    }
    Ok(())
}

/// Tests what needs help while the robot runs.
async fn with_help(bench: &mut Bench, progress: Told<'_>) -> anyhow::Result<()> {
    if let Some(trial) = bench.trial.clone() {
        progress(Progress::Step("a setpoint without air supply"));
        bench.supply(&trial, progress).await?;
    }
    progress(Progress::Step("a full memory of contacts"));
    bench.memory(progress).await?;
    if let Some(trial) = bench.trial.clone() {
        bench.silence(&trial, progress).await?;
    }
    Ok(())
}

/// The epoch of a supervisor that takes over a fleet now: ms since 1970.
#[must_use]
pub fn present_epoch() -> u64 {
    wall_clock().0 / 1000
}

/// Chooses the epoch, and notes the consequences for the next supervisor.
fn take_epoch(bench: &mut Bench) {
    let last = bench.heard.supervisor.as_ref().map(|state| state.epoch);
    // Where nothing is retained there may have been a supervisor: the present time is above its epoch and below the next.
    let unknown = if bench.heard.retains { 0 } else { present_epoch() };
    bench.epoch = bench.options.epoch.or(last).unwrap_or(unknown);
    let epoch = bench.epoch;
    let note = match last {
        Some(last) if epoch > last => format!(
            "epoch {epoch} was used, above the last supervisor's ({last}): RESTART THE ROBOT before it is supervised, \
             otherwise it refuses every supervisor's setpoints as STALE until their epoch is above {epoch}"
        ),
        Some(last) if epoch < last => format!("epoch {epoch} was used, below the last supervisor's ({last})"),
        Some(_) => format!(
            "epoch {epoch} was used, the last supervisor's: the next one's is higher, and the robot obeys it. Make \
             sure that the last one has stopped, and is not merely disconnected from the broker"
        ),
        // Supervisors take the present time for an epoch, unless a higher one was given before.
        None if epoch > 0 && epoch <= present_epoch() => format!(
            "epoch {epoch} was used: no lasting effect on the next supervisor, whose epoch is the time at which it begins"
        ),
        None if epoch > 0 => format!(
            "epoch {epoch} was used, which lies ahead of the clock: RESTART THE ROBOT before it is supervised, \
             otherwise it refuses every supervisor's setpoints as STALE until their epoch is above {epoch}"
        ),
        None => "epoch 0 was used: no lasting effect on the next supervisor, whose epoch is higher".into(),
    };
    bench.heard.findings.note(note);
    bench.heard.findings.note(
        "contacts of this time, and those that the robot had buffered, were partly receipted and not recorded"
            .to_owned(),
    );
}

fn tell_trial(bench: &mut Bench, trial: &Trial) {
    let Trial { array, whisker, home_mpa, away_mpa, max_mpa } = trial;
    bench.heard.findings.note(format!(
        "setpoints were tried on whisker {array}/{whisker}, between {home_mpa:.4} and {away_mpa:.4} MPa; those that \
         it must refuse were up to 0.001 MPa above its limit of {max_mpa:.4} MPa, at 0.002 MPa/s"
    ));
}

/// Restores the lengths and the chamber's first setpoint, whatever has happened. Returns and notes the changes that the
/// helper may not have undone.
async fn put_back(bench: &mut Bench) -> Vec<String> {
    let owed = std::mem::take(&mut bench.owed).into_iter().map(|action| format!("THIS MAY STILL BE TO DO: {action}"));
    let owed: Vec<String> = owed.collect();
    owed.iter().for_each(|note| bench.heard.findings.note(note.clone()));
    if let Err(problem) = bench.withdraw_lengths().await {
        bench.heard.findings.note(format!("THE ROBOT KEEPS A WRONG LENGTH until the next supervisor: {problem:#}"));
    }
    put_back_pressure(bench).await;
    owed
}

async fn put_back_pressure(bench: &mut Bench) {
    if let Some(trial) = bench.trial.as_ref().filter(|_| bench.has_reset_gain()) {
        let note = format!(
            "THE READINGS OF WHISKER {} HAVE THE FACTOR 1 NOW, as those of whiskers that need none: the check cannot know the \
             last supervisor's. Restart the robot, and the next supervisor sends it again",
            trial.spot()
        );
        bench.heard.findings.note(note);
    }
    let note = match (bench.go_home().await, &bench.trial) {
        (_, None) => return,
        (Ok(true), Some(trial)) => format!("its setpoint of {:.4} MPa was restored", trial.home_mpa),
        (Ok(false), Some(trial)) => {
            format!("ITS SETPOINT MAY NOT BE RESTORED: {:.4} MPa was sent, and not APPLIED", trial.home_mpa)
        }
        (Err(problem), Some(trial)) => {
            let home_mpa = trial.home_mpa;
            tracing::error!(%problem, "cannot restore the setpoint of {home_mpa:.4} MPa");
            format!("ITS SETPOINT WAS NOT RESTORED ({home_mpa:.4} MPa): {problem}")
        }
    };
    bench.heard.findings.note(note);
}

fn is_factsheet(message: &Message) -> bool {
    matches!(message, Message::Factsheet(_))
}
