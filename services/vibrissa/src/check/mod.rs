//! Tests one robot against the contract, rule by rule, as its supervisor would talk to it. For the people who build robots.
//!
//! It hears everything that the robot says ([`listener`]: what every message must keep), and then, in this order, sends receipts
//! ([`contacts`]), watches it ([`opening`]), sends setpoints ([`setpoints`], [`refusals`]), and looks at a restart ([`restart`]).
//!
//! **Epochs.** A robot takes nothing of an epoch below the highest that it has seen for a whisker, until it starts again. So the check takes
//! the *last supervisor's own epoch*, which it finds in what the broker retains, with versions far above those that supervisors count
//! from one. Every supervisor takes a fleet in a new epoch, higher by at least one, so that the robot obeys the next one at once. The price: the
//! last supervisor itself, should it be cut off and not ended, would find its setpoints refused as STALE if it came back in its old epoch.

mod bench;
mod contacts;
mod ledger;
mod listener;
mod log;
mod opening;
mod refusals;
mod report;
mod restart;
mod setpoints;
mod timings;

use std::fmt;
use std::time::{Duration, Instant};

use vibrissa_protocol::{Message, Name, RobotTopic, Topic};

pub use report::{Finding, Outcome, Report};
pub use timings::Timings;

use bench::{Bench, Trial};
use vibrissa_supervisor::mqtt::{Connection, Talk};

/// How a robot is checked.
#[derive(Debug, Clone)]
pub struct CheckOptions {
    /// Its fleet.
    pub fleet: Name,
    /// Its name.
    pub robot: Name,
    /// The whisker that setpoints are tried on; the first of the factsheet if not said.
    pub whisker: Option<(Name, u16)>,
    /// The epoch of those setpoints; the last supervisor's if not said, 0 if there was none.
    pub epoch: Option<u64>,
    /// Whether somebody takes the robot's power away when the check asks for it, and gives it back.
    pub restart: bool,
    /// How long what is waited for.
    pub timings: Timings,
}

/// What a check is at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Progress {
    /// This is looked at now.
    Step(&'static str),
    /// Somebody is to take the robot's power away and to give it back, within that time.
    RestartNow(Duration),
}

impl fmt::Display for Progress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Step(what) => f.write_str(what),
            Self::RestartNow(limit) => {
                write!(f, "NOW take the robot's power away, and give it back: {} s are left for both", limit.as_secs())
            }
        }
    }
}

/// Checks a robot until the end, or until `stop`: then the pressure is put back, and what was found until then is the report.
///
/// # Errors
/// There is no broker, a supervisor owns the fleet, the robot is not there, or it has seen a higher epoch.
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
    let talk = Talk::open(connection, &topics).await?;
    let mut bench = Bench::new(talk, options, connection.boot_id.clone());
    let ended = tokio::select! {
        ended = run(&mut bench, progress) => Some(ended),
        () = stop => None,
    };
    let unseen = match &ended {
        Some(_) => "nothing of it was seen",
        None => "the check was interrupted",
    };
    let is_interrupted = ended.is_none();
    put_back(&mut bench).await;
    if let Some(ended) = ended {
        ended?;
    } else {
        bench.heard.findings.note("interrupted: what is missing was not looked at".to_owned());
    }
    let (whisker, epoch) =
        (bench.trial.as_ref().map(|trial| format!("{}/{}", trial.array, trial.whisker)), bench.epoch);
    let (findings, notes) = bench.close().await.findings.close(unseen);
    let (fleet, robot) = (fleet.to_string(), robot.to_string());
    let seconds = begun.elapsed().as_secs_f64();
    Ok(Report { fleet, robot, whisker, epoch, seconds, is_interrupted, findings, notes })
}

async fn run(bench: &mut Bench, progress: &mut (dyn FnMut(Progress) + Send)) -> anyhow::Result<()> {
    progress(Progress::Step("what the broker retains"));
    bench.open().await?;
    take_epoch(bench);
    progress(Progress::Step("contacts and receipts: touch its whiskers now, and again and again"));
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
        progress(Progress::Step("setpoints that it must refuse"));
        bench.refusals(&trial).await?;
    }
    progress(Progress::Step("messages that cannot be read"));
    bench.malformed().await?;
    // Before its power goes: it may go back to another pressure by itself.
    bench.go_home().await?;
    progress(Progress::Step("restart"));
    bench.restart(progress).await
}

/// Chooses the epoch, and says what that means for the next supervisor.
fn take_epoch(bench: &mut Bench) {
    let last = bench.heard.supervisor.as_ref().map(|told| told.epoch);
    bench.epoch = bench.options.epoch.or(last).unwrap_or(0);
    let epoch = bench.epoch;
    let told = match last {
        Some(last) if epoch > last => format!(
            "epoch {epoch} was used, which is above the last supervisor's ({last}): RESTART THE ROBOT before it is supervised, or it refuses \
             every supervisor's setpoints as STALE until their epoch is above {epoch}"
        ),
        Some(last) if epoch < last => format!("epoch {epoch} was used, below the last supervisor's ({last})"),
        Some(_) => format!(
            "epoch {epoch} was used, which is the last supervisor's: the next one's is higher, and the robot obeys it. Make sure that the last \
             one has ended, and is not only cut off from the broker"
        ),
        None if epoch > 0 => format!(
            "epoch {epoch} was used, and the broker knows of no supervisor: RESTART THE ROBOT before it is supervised, or it refuses every \
             supervisor's setpoints as STALE until their epoch is above {epoch}"
        ),
        None => {
            "epoch 0 was used, as the broker knows of no supervisor: the first one's is higher, and the robot obeys it"
                .into()
        }
    };
    bench.heard.findings.note(told);
    bench.heard.findings.note(
        "contacts of this time, and what the robot had kept, were receipted in part: those are recorded nowhere"
            .to_owned(),
    );
}

fn tell_trial(bench: &mut Bench, trial: &Trial) {
    let Trial { array, whisker, home_mpa, away_mpa, max_mpa } = trial;
    bench.heard.findings.note(format!(
        "setpoints were tried on whisker {array}/{whisker}, between {home_mpa:.4} and {away_mpa:.4} MPa; what must be refused was up to \
         0.001 MPa above its limit of {max_mpa:.4} MPa, at 0.002 MPa/s"
    ));
}

/// Gives the chamber its first setpoint back, whatever has happened.
async fn put_back(bench: &mut Bench) {
    let told = match (bench.go_home().await, &bench.trial) {
        (_, None) => return,
        (Ok(true), Some(trial)) => format!("its setpoint is {:.4} MPa again, as before", trial.home_mpa),
        (Ok(false), Some(trial)) => {
            format!("ITS SETPOINT MAY NOT BE WHAT IT WAS: {:.4} MPa was sent, and not APPLIED", trial.home_mpa)
        }
        (Err(problem), Some(trial)) => {
            let home_mpa = trial.home_mpa;
            tracing::error!(%problem, "the setpoint of {home_mpa:.4} MPa could not be put back");
            format!("ITS SETPOINT IS NOT WHAT IT WAS ({home_mpa:.4} MPa): {problem}")
        }
    };
    bench.heard.findings.note(told);
}

fn is_factsheet(message: &Message) -> bool {
    matches!(message, Message::Factsheet(_))
}
