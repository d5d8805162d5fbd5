//! Measures the cost of a contact in a fleet of one or many shards, with one or several supervisors.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use anyhow::ensure;
use serde_json::json;
use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::web;

use crate::Bench;
use crate::cost::{CONTACTS, Loading};
use crate::report::{Figure, Target, median};
use crate::stage::{self, Stage, Store, Supervisor};

const PART: &str = "scale";
/// Numbers of shards, each with one supervisor, and of supervisors, each with [`SHARED`] shards.
const SHARDS: [u32; 4] = [1, 4, 16, 64];
const SUPERVISORS: [usize; 2] = [2, 4];
const SHARED: u32 = 16;
/// Shards of each of several supervisors that have the same load each.
const OWN: u32 = 4;
/// Messages per second of all robots: 10,000 and 50,000 contacts per second. The fixed cost of a shard counts less at more.
const RATES: [f64; 2] = [500.0, 2500.0];
/// Time with this load before the measurement, s.
const WARM_UP_S: f64 = 6.0;
/// Measured time, as a multiple of the pace's.
const MEASURED: f64 = 1.5;
/// Time limit until all shards are heard.
const PATIENCE: Duration = Duration::from_secs(180);
const PAUSE: Duration = Duration::from_millis(100);

/// A case, and what was measured of it in each round.
struct Case {
    shards: u32,
    supervisors: usize,
    /// Messages per second.
    rate: f64,
    /// Shards and messages per second of the case with one supervisor that this one is compared with.
    base: (u32, f64),
    /// Processor time per contact, us: of the supervisors together, of PostgreSQL, and of the broker.
    supervisor_us: Vec<f64>,
    postgres_us: Vec<f64>,
    broker_us: Vec<f64>,
    wal_bytes: Vec<f64>,
    wrong: i64,
}

impl Case {
    fn new((shards, supervisors, rate): (u32, usize, f64), base: (u32, f64)) -> Self {
        let (supervisor_us, postgres_us, broker_us, wal_bytes) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Self { shards, supervisors, rate, base, supervisor_us, postgres_us, broker_us, wal_bytes, wrong: 0 }
    }

    fn name(&self) -> String {
        let contacts = self.rate * CONTACTS as f64;
        format!("{} shards, {} supervisors, {contacts} contacts/s", self.shards, self.supervisors)
    }

    /// Runs the load once, with a new database.
    async fn round(&mut self, bench: &mut Bench, broker: &Mosquitto, round: usize) -> anyhow::Result<()> {
        let store = Store::postgres().await;
        let fleet = format!("{PART}-{}-{}-{}-{round}", self.shards, self.supervisors, self.rate);
        let supervisors = start(&bench.stage, broker, &store, &fleet, (self.shards, self.supervisors), &[]).await?;
        let mut watched: Vec<_> = supervisors.iter().map(|one| ("supervisor", one.pid())).collect();
        watched.push(("broker", broker.pid()));
        watched.extend(store.pid().map(|pid| ("postgresql", pid)));
        let measured_s = MEASURED * bench.pace.latency_s;
        let (rate, warm_up_s) = (self.rate, WARM_UP_S);
        let loading = Loading { broker, store: &store, fleet: &fleet, rate, warm_up_s, measured_s, watched };
        let costs = loading.costs().await?;
        let [supervisor_us, postgres_us, broker_us] = ["supervisor", "postgresql", "broker"].map(|kind| costs.us(kind));
        let recorded = store.recorded(&costs.report.boot_id).await?;
        self.supervisor_us.push(supervisor_us);
        self.postgres_us.push(postgres_us);
        self.broker_us.push(broker_us);
        self.wal_bytes.push(costs.wal_bytes);
        self.wrong +=
            (costs.report.contacts_in_all as i64 - recorded.distinct).abs() + recorded.rows - recorded.distinct;
        let line = json!({
            "subject": self.name(), "shards": self.shards, "supervisors": self.supervisors, "messages_per_s": rate,
            "contacts": costs.contacts, "supervisor_us_per_contact": supervisor_us,
            "postgresql_us_per_contact": postgres_us, "broker_us_per_contact": broker_us,
            "wal_bytes_per_contact": costs.wal_bytes,
        });
        bench.line(PART, round, line)?;
        bench.say(&format!(
            "{PART}, round {}: {}: supervisors {supervisor_us:.1} us, PostgreSQL {postgres_us:.1} us per contact",
            round + 1,
            self.name()
        ));
        for supervisor in supervisors {
            supervisor.stop().await?;
        }
        Ok(())
    }
}

/// Starts supervisors with further arguments, and waits until they hear all shards.
pub async fn start(
    stage: &Stage,
    broker: &Mosquitto,
    store: &Store,
    fleet: &str,
    (shards, count): (u32, usize),
    further: &[&str],
) -> anyhow::Result<Vec<Supervisor>> {
    let shards_text = shards.to_string();
    let arguments = [&["--fleet-shards", &shards_text, "--lease-time-to-live-s", "5"], further].concat();
    let arguments: Vec<String> = arguments.into_iter().map(str::to_owned).collect();
    let start = |number: usize| Supervisor::launch(stage, broker, store, fleet, &format!("bench-{number}"), &arguments);
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

/// Runs this part of the benchmark.
pub async fn run(bench: &mut Bench) -> anyhow::Result<()> {
    let broker = stage::broker();
    let mut cases = Vec::new();
    for rate in RATES {
        let base = (SHARDS[0], rate);
        cases.extend(SHARDS.map(|shards| Case::new((shards, 1, rate), base)));
        cases.extend(SUPERVISORS.map(|supervisors| Case::new((SHARED, supervisors, rate), base)));
    }
    // As much more load as supervisors, like in a fleet that has grown.
    let loaded = |count: usize| (OWN * count as u32, count, RATES[0] * count as f64);
    cases.extend(SUPERVISORS.map(|count| Case::new(loaded(count), (OWN, RATES[0]))));
    let mut round = 0;
    while bench.has_time_for(round) {
        for case in &mut cases {
            case.round(bench, &broker, round).await?;
        }
        round += 1;
    }
    for case in &cases {
        let first = cases
            .iter()
            .find(|first| first.supervisors == 1 && (first.shards, first.rate) == case.base)
            .expect("a case above");
        // The share is formed within a round.
        let share = median(case.supervisor_us.iter().zip(&first.supervisor_us).map(|(us, first)| us / first));
        let of = |values: &[f64]| median(values.iter().copied());
        let beside = format!(
            "supervisors {} ({}), PostgreSQL {}, broker {} us; WAL {}",
            Figure(of(&case.supervisor_us), ""),
            case.supervisor_us.iter().map(|us| format!("{us:.1}")).collect::<Vec<_>>().join(", "),
            Figure(of(&case.postgres_us), ""),
            Figure(of(&case.broker_us), ""),
            Figure(of(&case.wal_bytes), "bytes")
        );
        let what = format!("{}: CPU per contact, relative to {}", case.name(), first.name());
        bench.row(PART, &what, Target::AtMost(1.1), Figure(share, ""), beside)?;
    }
    let wrong = cases.iter().map(|case| case.wrong).sum::<i64>() as f64;
    bench.row(PART, "contacts lost or duplicated", Target::AtMost(0.0), Figure(wrong, ""), String::new())
}
