//! Measures bursts at the highest possible rate: into a subscriber that does nothing, and into supervisors with both
//! databases.

use serde_json::json;
use vibrissa_tests::mosquitto::Mosquitto;

use crate::child::{Helper, Loaded, load};
use crate::null::Received;
use crate::report::{Figure, Target, median};
use crate::stage::{self, Store, Supervisor};
use crate::{Bench, Pace};

/// Number of robots, and of whiskers per robot.
pub const ROBOTS: usize = 100;
pub const WHISKERS: usize = 10;
/// Contacts per whisker: enough to learn the baseline, and some more.
pub const LEARN: usize = 160;
/// Messages of a first burst, whose rate determines the length of the others.
const FIRST_MESSAGES: u64 = 10_000;
/// Largest number of messages in one burst.
const MESSAGES_MAX: f64 = 1e6;
/// Fleet of the subscriber that does nothing.
const NULL_FLEET: &str = "null";

/// A supervisor under test and its database.
pub struct Subject<'a> {
    /// Fleet of the supervisor.
    pub fleet: String,
    /// Database of the supervisor.
    pub store: &'a Store,
    /// The running process.
    pub supervisor: Supervisor,
}

/// Result of one burst into a supervisor.
pub struct Burst {
    /// Report of the generator and usage of the processes.
    pub loaded: Loaded,
    /// Contacts sent minus contacts recorded.
    pub lost: i64,
    /// Contacts that were recorded more than once.
    pub duplicated: i64,
}

impl<'a> Subject<'a> {
    /// Starts a supervisor for a fleet named after the part and the database.
    pub async fn start(bench: &Bench, broker: &Mosquitto, store: &'a Store, part: &str) -> anyhow::Result<Self> {
        let fleet = format!("{part}-{}", store.name().to_lowercase());
        let supervisor = Supervisor::start(&bench.stage, broker, store, &fleet).await?;
        Ok(Self { fleet, store, supervisor })
    }

    /// Sends a burst and compares the recorded contacts with those that were sent.
    pub async fn burst(&self, broker: &Mosquitto, arguments: &[(&str, String)]) -> anyhow::Result<Burst> {
        let mut watched = vec![("supervisor", self.supervisor.pid()), ("broker", broker.pid())];
        watched.extend(self.store.pid().map(|pid| ("postgresql", pid)));
        let loaded = load(broker.port(), &self.fleet, arguments, &watched, None).await?;
        let recorded = self.store.recorded(&loaded.report.boot_id).await?;
        let lost = loaded.report.contacts_in_all as i64 - recorded.distinct;
        Ok(Burst { loaded, lost, duplicated: recorded.rows - recorded.distinct })
    }
}

impl Burst {
    /// The result as a line of JSON.
    pub fn json(&self, subject: &str) -> serde_json::Value {
        let mut report = serde_json::to_value(&self.loaded.report).unwrap_or_default();
        if let Some(report) = report.as_object_mut() {
            report.remove("latencies_us");
        }
        json!({
            "subject": subject, "messages_per_s": self.loaded.messages_per_s(), "load": report,
            "usages": self.loaded.usages, "lost": self.lost, "duplicated": self.duplicated,
        })
    }
}

/// Number of messages that takes about the time of one burst at this rate.
pub fn messages(pace: &Pace, messages_per_s: f64) -> u64 {
    (messages_per_s * pace.burst_s).clamp(1000.0, MESSAGES_MAX) as u64
}

/// Arguments of the generator.
pub fn arguments(qos: u8, contacts: usize, messages: u64) -> Vec<(&'static str, String)> {
    vec![
        ("robots", ROBOTS.to_string()),
        ("whiskers", WHISKERS.to_string()),
        ("array-whiskers", WHISKERS.to_string()),
        ("qos", qos.to_string()),
        ("contacts", contacts.to_string()),
        ("messages", messages.to_string()),
    ]
}

/// Sends a burst to a subscriber that does nothing. Returns messages per second, processor seconds per million
/// messages, and the line of JSON.
async fn null(broker: &Mosquitto, qos: u8, messages: u64) -> anyhow::Result<(f64, f64, serde_json::Value)> {
    let helper_arguments =
        ["null-subscriber", "--port", &broker.port().to_string(), "--fleet", NULL_FLEET].map(str::to_owned);
    let helper_arguments = [helper_arguments.as_slice(), &["--messages".to_owned(), messages.to_string()]].concat();
    let mut subscriber = Helper::start(&helper_arguments)?;
    subscriber.ready().await?;
    let mut arguments = arguments(qos, 1, messages);
    arguments.push(("no-receipts", String::new()));
    let loaded = load(broker.port(), NULL_FLEET, &arguments, &[("broker", broker.pid())], Some(subscriber)).await?;
    let received: Received = serde_json::from_str(&loaded.helper)?;
    let seconds = received.last_us.saturating_sub(loaded.report.first_sent_us) as f64 / 1e6;
    let (rate, cpu_s) = (received.messages as f64 / seconds, received.cpu_s * 1e6 / received.messages as f64);
    let line = json!({
        "subject": "null", "messages_per_s": rate, "cpu_s_per_million": cpu_s, "received": received,
        "sent": loaded.report.sent, "generator_cpu_s": loaded.report.cpu_s, "usages": loaded.usages,
    });
    Ok((rate, cpu_s, line))
}

#[derive(Default)]
struct Series {
    rates: Vec<f64>,
    ratios: Vec<f64>,
    cpus: Vec<f64>,
    cpu_ratios: Vec<f64>,
    broker_cpus: Vec<f64>,
    database_cpus: Vec<f64>,
    peaks_mib: Vec<f64>,
    resent: Vec<f64>,
    lost: i64,
    duplicated: i64,
}

impl Series {
    fn push(&mut self, burst: &Burst, (null_rate, null_cpu): (f64, f64)) {
        let loaded = &burst.loaded;
        let (rate, cpu) = (loaded.messages_per_s(), loaded.cpu_s_per_million("supervisor"));
        self.rates.push(rate);
        self.ratios.push(rate / null_rate);
        self.cpus.push(cpu);
        self.cpu_ratios.push(cpu / null_cpu);
        self.broker_cpus.push(loaded.cpu_s_per_million("broker"));
        self.database_cpus.push(loaded.cpu_s_per_million("postgresql"));
        self.peaks_mib.push(loaded.usages.get("supervisor").map_or(f64::NAN, |usage| usage.peak_mib));
        self.resent.push(loaded.report.sent_again as f64 / loaded.report.sent as f64);
        self.lost += burst.lost;
        self.duplicated += burst.duplicated;
    }
}

/// Runs this part of the benchmark.
pub async fn run(bench: &mut Bench, qos: u8) -> anyhow::Result<()> {
    let part = if qos == 1 { "burst" } else { "burst-qos0" };
    bench.say(&format!("{part}: {} whiskers learn their baselines", ROBOTS * WHISKERS));
    let broker = stage::broker();
    let sqlite = Store::Sqlite(bench.stage.folder.path().join(format!("{part}.sqlite3")));
    let stores = [Store::postgres().await, sqlite];
    let mut subjects = Vec::new();
    for store in &stores {
        let subject = Subject::start(bench, &broker, store, part).await?;
        let mut first = arguments(qos, 1, FIRST_MESSAGES);
        first.push(("learn", LEARN.to_string()));
        let rate = subject.burst(&broker, &first).await?.loaded.messages_per_s();
        subjects.push((subject, rate, Series::default()));
    }
    let (mut null_rate, ..) = null(&broker, qos, 10 * FIRST_MESSAGES).await?;
    let (mut null_rates, mut null_cpus) = (Vec::new(), Vec::new());
    let mut round = 0;
    while bench.has_time_for(round) {
        let (rate, null_cpu, line) = null(&broker, qos, messages(&bench.pace, null_rate)).await?;
        null_rate = rate;
        bench.line(part, round, line)?;
        null_rates.push(null_rate);
        null_cpus.push(null_cpu);
        let mut said = format!("{part}, round {}: null {:.0}/s", round + 1, null_rate);
        for (subject, rate, series) in &mut subjects {
            let burst = subject.burst(&broker, &arguments(qos, 1, messages(&bench.pace, *rate))).await?;
            *rate = burst.loaded.messages_per_s();
            series.push(&burst, (null_rate, null_cpu));
            said += &format!(", {} {:.0}/s", subject.store.name(), rate);
            bench.report.line(part, round, burst.json(subject.store.name()))?;
        }
        bench.say(&said);
        round += 1;
    }
    for (subject, _, series) in &subjects {
        rows(bench, part, qos, subject.store.name(), series, (median(null_rates.clone()), median(null_cpus.clone())))?;
    }
    for (subject, ..) in subjects {
        subject.supervisor.stop().await?;
    }
    Ok(())
}

fn rows(
    bench: &mut Bench,
    part: &'static str,
    qos: u8,
    store: &str,
    series: &Series,
    (null_rate, null_cpu): (f64, f64),
) -> anyhow::Result<()> {
    let is_judged = store == "PostgreSQL";
    let target = |target| if is_judged { target } else { Target::None };
    let of = |values: &[f64]| median(values.iter().copied());
    let what = |text: &str| format!("{store}: {text}");
    let least = if qos == 1 { 0.85 } else { 0.6 };
    let beside = format!("{} of {}", Figure(of(&series.rates), "msg/s"), Figure(null_rate, ""));
    bench.row(
        part,
        &what("share of null subscriber"),
        target(Target::AtLeast(least)),
        Figure(of(&series.ratios), ""),
        beside,
    )?;
    let most = if qos == 1 { target(Target::AtMost(2.0)) } else { Target::None };
    let beside = format!("{} of {} s per million", Figure(of(&series.cpus), ""), Figure(null_cpu, ""));
    bench.row(part, &what("CPU, relative to null subscriber"), most, Figure(of(&series.cpu_ratios), ""), beside)?;
    if is_judged {
        let figure = Figure(of(&series.database_cpus), "s");
        bench.row(part, &what("database's CPU per million"), Target::AtMost(10.0), figure, String::new())?;
        bench.row(
            part,
            "broker's CPU per million",
            Target::None,
            Figure(of(&series.broker_cpus), "s"),
            String::new(),
        )?;
    }
    bench.row(part, &what("peak memory"), Target::None, Figure(of(&series.peaks_mib), "MiB"), String::new())?;
    bench.row(
        part,
        &what("messages sent again"),
        Target::None,
        Figure(100.0 * of(&series.resent), "%"),
        String::new(),
    )?;
    let wrong = (series.lost.abs() + series.duplicated) as f64;
    let beside = format!("{} lost, {} duplicated", series.lost, series.duplicated);
    bench.row(part, &what("contacts lost or duplicated"), Target::AtMost(0.0), Figure(wrong, ""), beside)
}
