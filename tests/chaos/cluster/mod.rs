//! Chaos in a cluster: three nodes of RMQTT (or one Mosquitto), three supervisors, a pair of PostgreSQL servers with Patroni and etcd, and
//! six fleets. Each node runs in a network namespace, and is killed, frozen and cut off in turn.
//!
//! Unlike the run with one broker, a fault strikes when everything works again after the last one, not at a given time.
//!
//! With `--overlapping`, each part has faults of its own, which meet those of the others. With `--kafka`, contacts go
//! through Kafka, whose brokers fail, too.
//!
//! Read in this order: [`plan`] (the faults), [`stage`] (the setup), [`bridge`] (from the broker to Kafka), [`parts`]
//! (injection and repair), [`strike`] and [`overlap`] (the run of faults, and waits), [`watch`] (the leases), [`probe`]
//! (the broker without the product), [`report`].

mod bridge;
mod broker;
mod overlap;
mod parts;
mod plan;
mod probe;
mod report;
mod stage;
mod strike;
mod watch;

use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::{Context, ensure};
use sqlx::ConnectOptions;
use tokio::time::sleep;
use vibrissa_tests::oracle::recorded;
use vibrissa_tests::oracle::robots::Robots;

pub use broker::BrokerKind;
pub use report::Report;

use crate::plan::Control;
use crate::replay::Replay;
use crate::scenario;
use crate::stage::{Program, panics_of};
use bridge::Bridge;
use overlap::Happened;
use plan::{Nodes, Plan};
use stage::{CLIENT, FLEETS, SUPERVISORS, Stage};
use strike::{Striker, Surprises};
use watch::Watch;

/// Time without faults at the start, in which robots learn their whiskers, and at the end.
const CALM: Duration = Duration::from_secs(5);
/// Interval of looks at the robots, the leases and the engines.
const PAUSE: Duration = Duration::from_millis(20);
/// Time limit for the robots' recovery, and for the recovery of each engine's redundancy.
const PATIENCE: Duration = Duration::from_secs(90);
/// Time limit until messages pass between the nodes of the broker. Then all are started again, as an operator would do.
const NODES_PATIENCE: Duration = Duration::from_secs(30);

/// Seed, length, number of robots and their contacts per second, and the defect to plant.
pub struct Settings {
    pub seed: u64,
    pub seconds: f64,
    pub robots: usize,
    pub rate: f64,
    pub control: Control,
    pub broker: BrokerKind,
    /// Faults of different parts overlap, instead of one at a time.
    pub overlapping: bool,
    /// Number of brokers of Kafka, through which contacts go; 0 for none.
    pub kafka: usize,
}

/// Runs the cluster under faults. `Ok(Err)` says what is not installed or not allowed here.
pub async fn run(settings: &Settings, program: &Program, logs: &Path) -> anyhow::Result<Result<Report, &'static str>> {
    let Settings { seed, seconds, rate, control, .. } = *settings;
    let names = stage::robots(settings.robots);
    // The folder may contain logs of an earlier run.
    let panics_before = panics_of(logs, &SUPERVISORS);
    let nodes = Nodes { broker: settings.broker.nodes(), kafka: settings.kafka };
    let mut stage = match Stage::set(program, control, (settings.broker, nodes), logs).await {
        Ok(stage) => stage,
        Err(missing) => return Ok(Err(missing)),
    };
    let watch = Watch::start([0, 1].map(|node| stage.database.connect(node)));
    // One link for each fleet: the robots have the fleets by turns, and the links, too.
    let robots: Vec<_> = names.iter().map(|(_, robot)| robot.clone()).collect();
    let fleets = stage::fleets();
    let scenarios = scenario::scenarios(seed, seconds, &robots, rate, control, &fleets);
    let brokers: Vec<_> = (0..fleets.len()).map(|group| stage.broker_of(group)).collect();
    let bridge = stage.kafka.as_ref().map(|kafka| Bridge::start(stage.broker.addresses(), &kafka.addresses(), seed));
    let robots = Robots::start(&scenarios, &brokers)?;
    let addresses = stage.broker.addresses();
    let replays: Vec<Replay> =
        addresses.iter().map(|(host, port)| Replay::start((host, *port), CLIENT, &fleets, seed)).collect();
    let (started, marks) = (Instant::now(), robots.marks());
    let mut striker = Striker {
        stage: &mut stage,
        watch: &watch,
        robots: &robots,
        names: &names,
        control,
        struck: Vec::new(),
        surprises: Surprises::default(),
    };
    ensure!(striker.until_whole().await, "the cluster does not start: see the logs in {logs:?}");
    if let Some(bridge) = &bridge {
        let whiskers = names.len() * usize::from(scenario::WHISKERS);
        ensure!(striker.until_known(whiskers).await, "not every robot is known: see the logs in {logs:?}");
        bridge.open();
    }
    while robots.receipted_beyond(&marks) < names.len() {
        ensure!(started.elapsed() < Duration::from_secs(60), "not every robot is heard: see the logs in {logs:?}");
        sleep(Duration::from_millis(50)).await;
    }
    eprintln!("chaos: everything works after {:.1} s", started.elapsed().as_secs_f64());
    let begun = Instant::now();
    let end = begun + Duration::from_secs_f64(seconds);
    sleep(CALM).await;
    let happened = if settings.overlapping {
        overlap::strike(&mut striker, seed, end - CALM).await
    } else {
        let mut plan = Plan::new(seed, control, nodes);
        while Instant::now() + CALM < end {
            striker.strike(plan.next()).await;
        }
        Happened { struck: std::mem::take(&mut striker.struck), ..Happened::default() }
    };
    sleep(CALM).await;
    let mut surprises = striker.surprises;
    surprises.ended += happened.surprises.ended;
    surprises.engines += happened.surprises.engines;
    surprises.ended += stage.revive();
    let run_s = begun.elapsed().as_secs_f64();

    robots.rest();
    let leader =
        stage.database_part().until_redundant(PATIENCE).await.context("a leader of the database at the end")?;
    let mut connection = stage.database.connect(leader).connect().await?;
    let drain = crate::drain(&robots, &mut connection, &[]).await?;
    surprises.ended += stage.revive();
    let (undelivered, dropped) = (robots.undelivered(), robots.dropped());
    let mut truth = robots.stop().await;
    eprintln!("chaos: reading {} contacts back", truth.ledger.count());
    recorded::contacts(&mut connection, &[], &mut truth.ledger).await?;
    let setpoints = truth.obedience.verdict(&recorded::setpoints(&mut connection, &[]).await?);
    Ok(Ok(Report {
        seed,
        broker: settings.broker.as_str(),
        kafka: settings.kafka,
        records_repeated: bridge.as_ref().map_or(0, Bridge::repeated),
        fleets: FLEETS.len(),
        robots: names.len(),
        repeated: replays.iter().map(Replay::count).sum(),
        dropped,
        undelivered,
        run_s,
        drain_s: drain.as_secs_f64(),
        panics: panics_of(logs, &SUPERVISORS) - panics_before,
        ..Report::new(truth.ledger.verdict(), setpoints, surprises, &happened, started)
    }))
}
