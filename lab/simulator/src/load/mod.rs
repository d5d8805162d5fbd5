//! Load generator: as many contacts messages of as many robots as a broker accepts, at low cost.
//!
//! Unlike in [`crate::Fleet`], robots share connections, their chambers reach setpoints at once, and the readings
//! of whole whiskers are drawn from precomputed ones. The robots obey the contract: births and factsheets first,
//! sequence numbers without gaps, a new boot for each run, statuses, answers to setpoints and requests, and
//! repeated transmission until all messages are receipted.
//!
//! Read in this order: [`plan`], [`texts`] and [`robots`] (messages), [`kept`] (repeated transmission), `line`
//! (connections), [`cuts`].

pub mod cuts;
pub mod kept;
mod line;
pub mod packet;
pub mod plan;
mod report;
pub mod robots;
pub mod texts;

use std::io;
use std::sync::Arc;

use vibrissa_protocol::BootId;

pub use plan::{BadPlan, LoadPlan, Quality};
pub use report::LoadReport;

use vibrissa_robot::mqtt::{BadBroker, address};

use crate::clock::now_us;
use crate::fleet::Broker;
use line::{Common, Line, Task};
use texts::Texts;

/// Text printed by [`say_prepared`].
pub const PREPARED: &str = "prepared";
/// Contacts in each message of the preparation.
const LEARN_CONTACTS: usize = 20;

/// Why load could not be generated to the end.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// The plan is invalid.
    #[error(transparent)]
    Plan(#[from] BadPlan),
    /// The broker's URL is invalid or requires TLS.
    #[error("--mqtt-url: {0}")]
    Address(String),
    /// The broker cannot be reached, or receipts stopped.
    #[error("the load stopped before its end: {0}")]
    Broken(#[from] io::Error),
}

/// Generates load until all messages are receipted. Needs a tokio runtime, for which one thread is enough.
/// `prepared` is called after the preparation, before the first message that counts.
///
/// # Errors
/// See [`LoadError`].
pub async fn run(plan: LoadPlan, prepared: impl FnOnce()) -> Result<LoadReport, LoadError> {
    plan.check()?;
    let broker =
        Broker::from_url(&plan.mqtt_url).map_err(|problem: BadBroker| LoadError::Address(problem.to_string()))?;
    if broker.tls.is_some() {
        return Err(LoadError::Address("the load generator does not support TLS".to_owned()));
    }
    if !broker.others.is_empty() {
        return Err(LoadError::Address("the load generator uses one node: name one address".to_owned()));
    }
    let boot_id = BootId::new(&format!("load-{:016x}-{}", now_us(), std::process::id())).expect("a short text");
    let texts = Texts::new(&plan, boot_id.as_str()).map_err(io::Error::other)?;
    let common =
        Common { plan: Arc::new(plan), texts: Arc::new(texts), boot_id, address: address(&broker.host, broker.port) };

    let begun_us = now_us();
    let mut lines = Vec::new();
    for index in 0..common.plan.connections {
        lines.push(Line::connect(common.clone(), index).await?);
    }
    lines = each(lines, async |line| line.introduce().await).await?;
    if !common.plan.no_receipts {
        lines = each(lines, async |line| line.work(preparation(&common.plan, line.robots())).await).await?;
    }
    let learning = if common.plan.learn > 0 { LEARN_CONTACTS } else { 1 };
    let before = lines.iter_mut().map(|line| line.take_counts().sent * learning as u64).sum();
    prepared();

    let (measured_us, cpu_before_s) = (now_us(), report::cpu_s());
    lines = each(lines, async |line| line.work(measured(&common.plan, line.robots(), measured_us)).await).await?;
    let (ended_us, cpu_s) = (now_us(), report::cpu_s() - cpu_before_s);
    let counts = lines.iter_mut().map(|line| (line.take_counts(), line.missed())).collect();
    let report = LoadReport::new(&common, counts, before, [begun_us, measured_us, ended_us], cpu_s);
    each(lines, async |line| line.end().await).await?;
    Ok(report)
}

/// Messages before the measurement: at least one for each robot, whose receipt shows that the supervisor knows the
/// robot.
fn preparation(plan: &LoadPlan, robots: usize) -> Task {
    let of_each = (plan.learn * plan.whiskers).div_ceil(LEARN_CONTACTS).max(1);
    let contacts = if plan.learn > 0 { LEARN_CONTACTS } else { 1 };
    Task { messages: (of_each * robots) as u64, contacts, schedule: None, cuts: false }
}

/// Prints on standard error that the preparation is over, so that a caller can start its own measurements of
/// processor time.
pub fn say_prepared() {
    eprintln!("{PREPARED}");
}

/// This connection's share of the measured messages.
fn measured(plan: &LoadPlan, robots: usize, now_us: u64) -> Task {
    let share = robots as f64 / plan.robots as f64;
    let schedule = plan.rate.map(|rate| (now_us as f64, rate * share));
    let messages = (plan.messages as f64 * share).round() as u64;
    Task { messages, contacts: plan.contacts, schedule, cuts: plan.trim_every.is_some() }
}

/// Runs `work` on all connections concurrently, and waits for all.
async fn each(mut lines: Vec<Line>, work: impl AsyncFn(&mut Line) -> io::Result<()>) -> io::Result<Vec<Line>> {
    futures_util::future::try_join_all(lines.iter_mut().map(|line| work(line))).await?;
    Ok(lines)
}
