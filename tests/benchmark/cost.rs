//! Processor time and log bytes of a contact under a constant load.

use std::collections::BTreeMap;
use std::time::Duration;

use anyhow::ensure;
use sqlx::{ConnectOptions, Connection};
use vibrissa_simulator::load::LoadReport;
use vibrissa_tests::mosquitto::Mosquitto;

use crate::child::load;
use crate::stage::Store;
use crate::usage;

/// Robots, whiskers of each, and contacts of a message.
const ROBOTS: usize = 256;
const WHISKERS: usize = 10;
pub const CONTACTS: usize = 20;
/// Time with the load after the measurement, s.
const AFTER_S: f64 = 2.0;
/// The load may take longer than planned by this factor.
const LATE: f64 = 1.05;

/// A load and the servers that it passes.
pub struct Loading<'a> {
    pub broker: &'a Mosquitto,
    pub store: &'a Store,
    pub fleet: &'a str,
    /// Messages per second of all robots.
    pub rate: f64,
    /// Time with this load before the measurement, s. In it the robots and whiskers get their rows, and the engine
    /// prepares its statements.
    pub warm_up_s: f64,
    /// Measured time, s.
    pub measured_s: f64,
    /// Processes by their kind. Those of a kind count together.
    pub watched: Vec<(&'static str, u32)>,
}

/// Cost of a contact.
pub struct Costs {
    /// Number of contacts that were measured.
    pub contacts: f64,
    /// Processor time per contact by the kind of the process, us.
    pub us: BTreeMap<&'static str, f64>,
    /// Bytes of PostgreSQL's log per contact.
    pub wal_bytes: f64,
    /// Report of the generator, which has counted all of the load.
    pub report: LoadReport,
}

impl Costs {
    /// Processor time per contact of a kind, us; 0 for a kind without processes.
    pub fn us(&self, kind: &str) -> f64 {
        self.us.get(kind).copied().unwrap_or_default()
    }
}

impl Loading<'_> {
    /// Runs the load.
    ///
    /// # Errors
    /// The load falls behind its rate, or PostgreSQL does not answer.
    pub async fn costs(&self) -> anyhow::Result<Costs> {
        let messages = (self.rate * (self.warm_up_s + self.measured_s + AFTER_S)) as u64;
        let arguments = [
            ("robots", ROBOTS.to_string()),
            ("whiskers", WHISKERS.to_string()),
            ("array-whiskers", WHISKERS.to_string()),
            ("contacts", CONTACTS.to_string()),
            ("messages", messages.to_string()),
            ("rate", self.rate.to_string()),
        ];
        let sampled = async {
            tokio::time::sleep(Duration::from_secs_f64(self.warm_up_s)).await;
            let before = self.sample().await?;
            tokio::time::sleep(Duration::from_secs_f64(self.measured_s)).await;
            Ok::<_, anyhow::Error>((before, self.sample().await?))
        };
        let (loaded, sampled) = tokio::join!(load(self.broker.port(), self.fleet, &arguments, &[], None), sampled);
        let (report, ((before, wal_before), (after, wal_after))) = (loaded?.report, sampled?);
        let planned_s = messages as f64 / self.rate;
        ensure!(report.seconds < LATE * planned_s, "the load took {:.1} s, not {planned_s:.1}", report.seconds);
        let contacts = self.rate * self.measured_s * CONTACTS as f64;
        let of_contact = |(kind, after_s): (&'static str, f64)| (kind, (after_s - before[kind]) * 1e6 / contacts);
        let us = after.into_iter().map(of_contact).collect();
        Ok(Costs { contacts, us, wal_bytes: (wal_after - wal_before) as f64 / contacts, report })
    }

    /// Processor seconds by kind, and PostgreSQL's position in its log, bytes.
    async fn sample(&self) -> anyhow::Result<(BTreeMap<&'static str, f64>, i64)> {
        let mut cpu_s = BTreeMap::new();
        for &(kind, pid) in &self.watched {
            *cpu_s.entry(kind).or_default() += usage::of_tree(pid).cpu_s;
        }
        Ok((cpu_s, wal(self.store).await?))
    }
}

async fn wal(store: &Store) -> anyhow::Result<i64> {
    let Store::Postgres(server) = store else { return Ok(0) };
    let mut connection = server.connect().connect().await?;
    let sql = "SELECT (pg_current_wal_insert_lsn() - '0/0'::pg_lsn)::bigint";
    let bytes = sqlx::query_scalar(sql).fetch_one(&mut connection).await?;
    connection.close().await?;
    Ok(bytes)
}
