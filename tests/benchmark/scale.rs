//! Measures the cost of a contact in a fleet of one or many shards, with one or several supervisors, and a takeover.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use anyhow::ensure;
use serde_json::json;
use sqlx::{ConnectOptions, Connection};
use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::web;

use crate::child::load;
use crate::report::{Figure, Target, median};
use crate::stage::{self, Stage, Store, Supervisor};
use crate::{Bench, usage};

const PART: &str = "scale";
/// Numbers of shards, each with one supervisor, and of supervisors, each with [`SHARED`] shards.
const SHARDS: [u32; 4] = [1, 4, 16, 64];
const SUPERVISORS: [usize; 2] = [2, 4];
const SHARED: u32 = 16;
/// Robots, whiskers of each, contacts of a message, and messages per second of all robots: 10,000 contacts per second.
const ROBOTS: usize = 256;
const WHISKERS: usize = 10;
const CONTACTS: usize = 20;
const RATE: f64 = 500.0;
/// Time with this load before the measurement, s, and after it.
const WARM_UP_S: f64 = 6.0;
const AFTER_S: f64 = 2.0;
/// Measured time, as a multiple of the pace's.
const MEASURED: f64 = 1.5;
/// The load may take longer than planned by this factor.
const LATE: f64 = 1.05;
/// Whiskers of a robot in the takeover.
const OF_ROBOT: usize = 100;
/// Time limit until all shards are heard.
const PATIENCE: Duration = Duration::from_secs(180);
const PAUSE: Duration = Duration::from_millis(100);

/// A case, and what was measured of it in each round.
struct Case {
    shards: u32,
    supervisors: usize,
    /// Processor time per contact, us: of the supervisors together, of PostgreSQL, and of the broker.
    supervisor_us: Vec<f64>,
    postgres_us: Vec<f64>,
    broker_us: Vec<f64>,
    wal_bytes: Vec<f64>,
    wrong: i64,
}

impl Case {
    fn new(shards: u32, supervisors: usize) -> Self {
        let (supervisor_us, postgres_us, broker_us, wal_bytes) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Self { shards, supervisors, supervisor_us, postgres_us, broker_us, wal_bytes, wrong: 0 }
    }

    fn name(&self) -> String {
        format!("{} shards, {} supervisors", self.shards, self.supervisors)
    }

    /// Runs the load once, with a new database.
    async fn round(&mut self, bench: &mut Bench, broker: &Mosquitto, round: usize) -> anyhow::Result<()> {
        let store = Store::postgres().await;
        let fleet = format!("{PART}-{}-{}-{round}", self.shards, self.supervisors);
        let supervisors = start(&bench.stage, broker, &store, &fleet, self.shards, self.supervisors).await?;
        let pids: Vec<u32> = supervisors.iter().map(Supervisor::pid).collect();
        let measured_s = MEASURED * bench.pace.latency_s;
        let messages = (RATE * (WARM_UP_S + measured_s + AFTER_S)) as u64;
        let arguments = [
            ("robots", ROBOTS.to_string()),
            ("whiskers", WHISKERS.to_string()),
            ("array-whiskers", WHISKERS.to_string()),
            ("contacts", CONTACTS.to_string()),
            ("messages", messages.to_string()),
            ("rate", RATE.to_string()),
        ];
        let names = ["supervisor 1", "supervisor 2", "supervisor 3", "supervisor 4"];
        let mut watched: Vec<(&'static str, u32)> = names.into_iter().zip(pids).collect();
        watched.push(("broker", broker.pid()));
        watched.extend(store.pid().map(|pid| ("postgresql", pid)));
        let sample = async || {
            let cpu: BTreeMap<_, _> = watched.iter().map(|&(name, pid)| (name, usage::of_tree(pid).cpu_s)).collect();
            Ok::<_, anyhow::Error>((cpu, wal(&store).await?))
        };
        // First the robots and whiskers get their rows, and each shard opens its connections and prepares its statements.
        let sampled = async {
            tokio::time::sleep(Duration::from_secs_f64(WARM_UP_S)).await;
            let before = sample().await?;
            tokio::time::sleep(Duration::from_secs_f64(measured_s)).await;
            Ok::<_, anyhow::Error>((before, sample().await?))
        };
        let (loaded, sampled) = tokio::join!(load(broker.port(), &fleet, &arguments, &[], None), sampled);
        let (loaded, ((before, wal_before), (after, wal_after))) = (loaded?, sampled?);
        let planned_s = messages as f64 / RATE;
        ensure!(
            loaded.report.seconds < LATE * planned_s,
            "the load took {:.1} s, not {planned_s:.1}",
            loaded.report.seconds
        );
        let contacts = RATE * measured_s * CONTACTS as f64;
        let wal = wal_after - wal_before;
        let us = |name: &str| {
            after.get(name).zip(before.get(name)).map_or(0.0, |(after, before)| (after - before) * 1e6 / contacts)
        };
        let recorded = store.recorded(&loaded.report.boot_id).await?;
        let supervisor_us: f64 = names.into_iter().map(us).sum();
        self.supervisor_us.push(supervisor_us);
        self.postgres_us.push(us("postgresql"));
        self.broker_us.push(us("broker"));
        self.wal_bytes.push(wal as f64 / contacts);
        self.wrong +=
            (loaded.report.contacts_in_all as i64 - recorded.distinct).abs() + recorded.rows - recorded.distinct;
        let line = json!({
            "subject": self.name(), "shards": self.shards, "supervisors": self.supervisors, "contacts": contacts,
            "supervisor_us_per_contact": supervisor_us, "postgresql_us_per_contact": us("postgresql"),
            "broker_us_per_contact": us("broker"), "wal_bytes_per_contact": wal as f64 / contacts,
        });
        bench.line(PART, round, line)?;
        bench.say(&format!(
            "{PART}, round {}: {}: supervisors {supervisor_us:.1} us, PostgreSQL {:.1} us per contact",
            round + 1,
            self.name(),
            us("postgresql")
        ));
        for supervisor in supervisors {
            supervisor.stop().await?;
        }
        Ok(())
    }
}

/// Position in the log of PostgreSQL, bytes.
async fn wal(store: &Store) -> anyhow::Result<i64> {
    let Store::Postgres(server) = store else { return Ok(0) };
    let mut connection = server.connect().connect().await?;
    let sql = "SELECT (pg_current_wal_insert_lsn() - '0/0'::pg_lsn)::bigint";
    let bytes = sqlx::query_scalar(sql).fetch_one(&mut connection).await?;
    connection.close().await?;
    Ok(bytes)
}

/// Starts supervisors and waits until they hear all shards.
async fn start(
    stage: &Stage,
    broker: &Mosquitto,
    store: &Store,
    fleet: &str,
    shards: u32,
    count: usize,
) -> anyhow::Result<Vec<Supervisor>> {
    let further =
        ["--fleet-shards".to_owned(), shards.to_string(), "--lease-time-to-live-s".to_owned(), "5".to_owned()];
    let start = |number: usize| Supervisor::launch(stage, broker, store, fleet, &format!("bench-{number}"), &further);
    let mut supervisors: Vec<Supervisor> = (0..count).map(start).collect();
    let begun = Instant::now();
    loop {
        let mut heard = BTreeMap::new();
        for supervisor in &mut supervisors {
            ensure!(supervisor.is_running(), "a supervisor has ended: {}", supervisor.log());
            heard.insert(supervisor.pid(), shards_heard(supervisor, fleet).await);
        }
        let is_shared = heard.values().all(|&heard| heard > 0) || (shards as usize) < count;
        if heard.values().sum::<usize>() == shards as usize && is_shared {
            return Ok(supervisors);
        }
        ensure!(begun.elapsed() < PATIENCE, "not all shards are heard: {heard:?}");
        tokio::time::sleep(PAUSE).await;
    }
}

/// Number of shards of the fleet that a supervisor owns and hears.
async fn shards_heard(supervisor: &Supervisor, fleet: &str) -> usize {
    let Ok((200, text)) = web::try_get(supervisor.http, "/metrics").await else { return 0 };
    let begin = format!("vibrissa_broker_connected{{fleet=\"{fleet}\"");
    text.lines().filter(|line| line.starts_with(&begin) && line.ends_with(" 1")).count()
}

/// Whiskers that a supervisor takes over per second of its processor time.
async fn takeover(bench: &mut Bench, broker: &Mosquitto) -> anyhow::Result<()> {
    let whiskers = bench.pace.whiskers_max;
    let store = Store::postgres().await;
    let fleet = format!("{PART}-takeover");
    let first = start(&bench.stage, broker, &store, &fleet, 1, 1).await?;
    let arguments = [
        ("robots", (whiskers / OF_ROBOT).to_string()),
        ("whiskers", OF_ROBOT.to_string()),
        ("array-whiskers", OF_ROBOT.to_string()),
        ("contacts", OF_ROBOT.to_string()),
        ("messages", (whiskers / OF_ROBOT).to_string()),
        ("patience-s", PATIENCE.as_secs().to_string()),
    ];
    load(broker.port(), &fleet, &arguments, &[], None).await?;
    for supervisor in first {
        supervisor.stop().await?;
    }
    // A supervisor without robots needs this much until it is ready.
    let empty = start(&bench.stage, broker, &store, "empty", 1, 1).await?;
    let base_s: f64 = empty.iter().map(|one| usage::of_tree(one.pid()).cpu_s).sum();
    for supervisor in empty {
        supervisor.stop().await?;
    }
    let begun = Instant::now();
    let heirs = start(&bench.stage, broker, &store, &fleet, 1, 1).await?;
    let elapsed_s = begun.elapsed().as_secs_f64();
    let cpu_s = heirs.iter().map(|one| usage::of_tree(one.pid()).cpu_s).sum::<f64>() - base_s;
    for supervisor in heirs {
        supervisor.stop().await?;
    }
    let rate = whiskers as f64 / cpu_s;
    bench.line(
        PART,
        0,
        json!({ "subject": "takeover", "whiskers": whiskers, "cpu_s": cpu_s, "elapsed_s": elapsed_s }),
    )?;
    let beside = format!("{whiskers} whiskers, {} of CPU, {} elapsed", Figure(cpu_s, "s"), Figure(elapsed_s, "s"));
    bench.row(PART, "states taken over per second and core", Target::AtLeast(200_000.0), Figure(rate, "/s"), beside)
}

/// Runs this part of the benchmark.
pub async fn run(bench: &mut Bench) -> anyhow::Result<()> {
    let broker = stage::broker();
    let mut cases: Vec<Case> = SHARDS.map(|shards| Case::new(shards, 1)).into();
    cases.extend(SUPERVISORS.map(|supervisors| Case::new(SHARED, supervisors)));
    let mut round = 0;
    while bench.has_time_for(round) {
        for case in &mut cases {
            case.round(bench, &broker, round).await?;
        }
        round += 1;
    }
    let first = cases[0].supervisor_us.clone();
    for case in &cases {
        // The share is formed within a round.
        let share = median(case.supervisor_us.iter().zip(&first).map(|(us, first)| us / first));
        let of = |values: &[f64]| median(values.iter().copied());
        let beside = format!(
            "supervisors {} ({}), PostgreSQL {}, broker {} us; WAL {}",
            Figure(of(&case.supervisor_us), ""),
            case.supervisor_us.iter().map(|us| format!("{us:.1}")).collect::<Vec<_>>().join(", "),
            Figure(of(&case.postgres_us), ""),
            Figure(of(&case.broker_us), ""),
            Figure(of(&case.wal_bytes), "bytes")
        );
        let what = format!("{}: CPU per contact, relative to one shard", case.name());
        bench.row(PART, &what, Target::AtMost(1.1), Figure(share, ""), beside)?;
    }
    let wrong = cases.iter().map(|case| case.wrong).sum::<i64>() as f64;
    bench.row(PART, "contacts lost or duplicated", Target::AtMost(0.0), Figure(wrong, ""), String::new())?;
    takeover(bench, &broker).await
}
