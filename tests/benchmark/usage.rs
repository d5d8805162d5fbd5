//! Processor time and memory of processes, read from `/proc` (Linux only).

use std::collections::BTreeMap;
use std::fs::{read_dir, read_to_string};

use serde::Serialize;

/// Ticks per second in which Linux reports processor times; independent of the kernel's own tick rate.
const TICKS_PER_S: f64 = 100.0;

/// Resources used by a process and its descendants.
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub struct Usage {
    /// Processor time since their start, seconds, including descendants that have ended.
    pub cpu_s: f64,
    /// Sum of the peak memory of each process since [`forget_peak`], MiB.
    pub peak_mib: f64,
}

impl Usage {
    /// Difference to an earlier measurement.
    pub fn since(self, before: Self) -> Self {
        Self { cpu_s: self.cpu_s - before.cpu_s, peak_mib: self.peak_mib }
    }
}

/// Resources used by a process and its descendants so far.
pub fn of_tree(root: u32) -> Usage {
    let stats = stats();
    let mut usage = Usage::default();
    for (&pid, stat) in &stats {
        if is_within(pid, root, &stats) {
            usage.cpu_s += stat.ticks / TICKS_PER_S;
            usage.peak_mib += peak_mib(pid);
        }
    }
    usage
}

/// Resets the peak memory of a process and its descendants.
pub fn forget_peak(root: u32) {
    let stats = stats();
    for &pid in stats.keys().filter(|&&pid| is_within(pid, root, &stats)) {
        // Another user's process may not be writable; its peak then counts from its start.
        let _ = std::fs::write(format!("/proc/{pid}/clear_refs"), "5");
    }
}

struct Stat {
    parent: u32,
    ticks: f64,
}

fn stats() -> BTreeMap<u32, Stat> {
    let entries = read_dir("/proc").expect("Linux").filter_map(Result::ok);
    let stat = |entry: std::fs::DirEntry| {
        let pid = entry.file_name().to_str()?.parse().ok()?;
        let text = read_to_string(entry.path().join("stat")).ok()?;
        // The process name may contain any character; after it follow the state, the parent's id and others.
        let fields: Vec<&str> = text.rsplit_once(") ")?.1.split(' ').collect();
        let ticks = |at: usize| fields.get(at)?.parse::<f64>().ok();
        // Own time and that of children that have ended, in user and system mode.
        let ticks = ticks(11)? + ticks(12)? + ticks(13)?.max(0.0) + ticks(14)?.max(0.0);
        Some((pid, Stat { parent: fields.get(1)?.parse().ok()?, ticks }))
    };
    entries.filter_map(stat).collect()
}

fn is_within(mut pid: u32, root: u32, stats: &BTreeMap<u32, Stat>) -> bool {
    while pid != root {
        match stats.get(&pid) {
            Some(stat) if stat.parent > 1 => pid = stat.parent,
            Some(_) | None => return false,
        }
    }
    true
}

fn peak_mib(pid: u32) -> f64 {
    let status = read_to_string(format!("/proc/{pid}/status")).unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kib = line.and_then(|line| line.split_whitespace().next()?.parse::<f64>().ok());
    kib.unwrap_or(0.0) / 1024.0
}
