//! What came of a load.

use serde::{Deserialize, Serialize};

use super::line::{Common, Counts};

/// Ticks per second in which Linux tells times of processes, whatever the kernel's own are.
const TICKS_PER_S: f64 = 100.0;

/// What came of a load.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct LoadReport {
    /// The boot of all its robots.
    pub boot_id: String,
    /// Robots.
    pub robots: usize,
    /// Whiskers of all robots.
    pub whiskers: usize,
    /// Contacts in one message.
    pub contacts: usize,
    /// Contacts of this boot in all, those of the preparation among them: as many rows must be recorded.
    pub contacts_in_all: u64,
    /// Seconds until every robot was known and had learned.
    pub prepared_s: f64,
    /// Messages, each counted once.
    pub sent: u64,
    /// Messages that were sent again, counted as often as they were.
    pub sent_again: u64,
    /// Messages that a receipt covers.
    pub receipted: u64,
    /// When the first one was sent, in microseconds since 1970 UTC.
    pub first_sent_us: u64,
    /// From the first message to the last receipt; without receipts, until the broker had everything. Seconds.
    pub seconds: f64,
    /// The generator's own processor time meanwhile, seconds.
    pub cpu_s: f64,
    /// Setpoints that came.
    pub setpoints: u64,
    /// Cut whiskers for which none came.
    pub missed: u64,
    /// From each contact that led to a setpoint until that came, ascending, in microseconds.
    pub latencies_us: Vec<u64>,
}

impl LoadReport {
    /// Adds up what connections have counted; `before` are the contacts of the preparation, times are those of beginning, of the first measured message, and of the end.
    pub(super) fn new(
        common: &Common,
        counts: Vec<(Counts, u64)>,
        before: u64,
        times_us: [u64; 3],
        cpu_s: f64,
    ) -> Self {
        let [begun_us, measured_us, ended_us] = times_us;
        let sum = |of: fn(&Counts) -> u64| counts.iter().map(|(counts, _)| of(counts)).sum();
        let first_sent_us = counts.iter().map(|(counts, _)| counts.first_sent_us).min().unwrap_or(measured_us);
        let last_us = counts.iter().map(|(counts, _)| counts.last_receipt_us).max().filter(|&last_us| last_us > 0);
        let mut latencies_us: Vec<u64> = counts.iter().flat_map(|(counts, _)| counts.latencies_us.clone()).collect();
        latencies_us.sort_unstable();
        Self {
            boot_id: common.boot_id.to_string(),
            robots: common.plan.robots,
            whiskers: common.plan.robots * common.plan.whiskers,
            contacts: common.plan.contacts,
            contacts_in_all: before + sum(|counts| counts.sent) * common.plan.contacts as u64,
            prepared_s: seconds(begun_us, measured_us),
            sent: sum(|counts| counts.sent),
            sent_again: sum(|counts| counts.sent_again),
            receipted: sum(|counts| counts.receipted),
            first_sent_us,
            seconds: seconds(first_sent_us, last_us.unwrap_or(ended_us)),
            cpu_s,
            setpoints: sum(|counts| counts.setpoints),
            missed: counts.iter().map(|(_, missed)| missed).sum(),
            latencies_us,
        }
    }
}

fn seconds(from_us: u64, to_us: u64) -> f64 {
    to_us.saturating_sub(from_us) as f64 / 1e6
}

/// Processor time of this process since its start, in seconds; 0 where there is no /proc.
pub(super) fn cpu_s() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // After the name, which may hold anything; user and system time are the 12th and 13th field from there.
    let fields = stat.rsplit_once(") ").map_or("", |(_, fields)| fields);
    let ticks = fields.split(' ').skip(11).take(2).filter_map(|field| field.parse::<f64>().ok());
    ticks.sum::<f64>() / TICKS_PER_S
}
