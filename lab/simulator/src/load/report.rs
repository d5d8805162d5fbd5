//! Result of a load.

use serde::{Deserialize, Serialize};

use super::line::{Common, Counts};

/// Clock ticks per second in Linux's process statistics, whatever the kernel's own rate.
const TICKS_PER_S: f64 = 100.0;

/// Result of a load.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct LoadReport {
    /// Boot id of all robots.
    pub boot_id: String,
    /// Number of robots.
    pub robots: usize,
    /// Number of whiskers of all robots.
    pub whiskers: usize,
    /// Contacts in one message.
    pub contacts: usize,
    /// Number of contacts in this boot including the preparation: the expected number of recorded rows.
    pub contacts_in_all: u64,
    /// Duration of the preparation, in seconds.
    pub prepared_s: f64,
    /// Number of messages, each counted once.
    pub sent: u64,
    /// Number of repeated transmissions.
    pub sent_again: u64,
    /// Number of receipted messages.
    pub receipted: u64,
    /// Time of the first message, in microseconds since 1970 UTC.
    pub first_sent_us: u64,
    /// Time from the first message to the last receipt (without receipts: until the broker had all messages), in
    /// seconds.
    pub seconds: f64,
    /// Processor time of the generator during the measurement, in seconds.
    pub cpu_s: f64,
    /// Number of received setpoints.
    pub setpoints: u64,
    /// Number of cut whiskers that got no setpoint.
    pub missed: u64,
    /// Times from a contact to the setpoint that it caused, ascending, in microseconds.
    pub latencies_us: Vec<u64>,
}

impl LoadReport {
    /// Adds up the counters of all connections. `before` is the number of contacts in the preparation; `times_us`
    /// are the times of the start, of the first measured message, and of the end.
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

/// Processor time of this process since its start, in seconds; 0 without /proc.
pub(super) fn cpu_s() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // The fields follow the process name, which may contain anything; user and system time are the 12th and 13th.
    let fields = stat.rsplit_once(") ").map_or("", |(_, fields)| fields);
    let ticks = fields.split(' ').skip(11).take(2).filter_map(|field| field.parse::<f64>().ok());
    ticks.sum::<f64>() / TICKS_PER_S
}
