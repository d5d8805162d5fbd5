//! Metrics of this process, from Linux's folder `/proc/self`: the seven that Prometheus' client library for Rust has.

use std::fs::{read_dir, read_to_string};

use prometheus::core::{Collector, Desc};
use prometheus::proto::MetricFamily;
use prometheus::{Counter, IntGauge, Result};
use rustix::process::{Resource, getrlimit};

/// Clock ticks per second in Linux's `/proc`, on every platform that Rust supports.
const TICKS_PER_S: f64 = 100.0;

/// The process's metrics, which are read when they are collected.
pub(super) struct ProcessMetrics {
    cpu: Counter,
    open_files: IntGauge,
    files_max: IntGauge,
    virtual_memory: IntGauge,
    resident_memory: IntGauge,
    start: IntGauge,
    threads: IntGauge,
}

impl ProcessMetrics {
    /// # Errors
    /// A metric's name is invalid.
    pub(super) fn new() -> Result<Self> {
        Ok(Self {
            cpu: Counter::new("process_cpu_seconds_total", "Total user and system CPU time spent in seconds.")?,
            open_files: IntGauge::new("process_open_fds", "Number of open file descriptors.")?,
            files_max: IntGauge::new("process_max_fds", "Maximum number of open file descriptors.")?,
            virtual_memory: IntGauge::new("process_virtual_memory_bytes", "Virtual memory size in bytes.")?,
            resident_memory: IntGauge::new("process_resident_memory_bytes", "Resident memory size in bytes.")?,
            start: IntGauge::new(
                "process_start_time_seconds",
                "Start time of the process since unix epoch in seconds.",
            )?,
            threads: IntGauge::new("process_threads", "Number of OS threads in the process.")?,
        })
    }

    fn all(&self) -> [&dyn Collector; 7] {
        [
            &self.cpu,
            &self.open_files,
            &self.files_max,
            &self.virtual_memory,
            &self.resident_memory,
            &self.start,
            &self.threads,
        ]
    }

    /// Reads the values; those that cannot be read stay as they are.
    fn read(&self) {
        if let Ok(files) = read_dir("/proc/self/fd") {
            self.open_files.set(signed(files.count() as u64));
        }
        if let Some(files_max) = getrlimit(Resource::Nofile).current {
            self.files_max.set(signed(files_max));
        }
        if let Some(stat) = read_to_string("/proc/self/stat").ok().as_deref().and_then(Stat::parse) {
            // If two scrapes at the same time add the same difference, the counter is ahead until the true value
            // reaches it.
            self.cpu.inc_by((stat.cpu_s - self.cpu.get()).max(0.0));
            self.threads.set(signed(stat.threads));
            self.virtual_memory.set(signed(stat.virtual_bytes));
            let boot = read_to_string("/proc/stat").ok().as_deref().and_then(|text| number(text, "btime"));
            if let Some(boot) = boot {
                self.start.set(signed(boot + stat.started_s));
            }
        }
        let resident_kib = read_to_string("/proc/self/status").ok().as_deref().and_then(|text| number(text, "VmRSS:"));
        if let Some(kib) = resident_kib {
            self.resident_memory.set(signed(kib * 1024));
        }
    }
}

impl Collector for ProcessMetrics {
    fn desc(&self) -> Vec<&Desc> {
        self.all().into_iter().flat_map(Collector::desc).collect()
    }

    fn collect(&self) -> Vec<MetricFamily> {
        self.read();
        self.all().into_iter().flat_map(Collector::collect).collect()
    }
}

/// Values of `/proc/self/stat`.
#[derive(Debug, PartialEq)]
struct Stat {
    cpu_s: f64,
    threads: u64,
    /// Time from the machine's boot to the start of the process, s.
    started_s: u64,
    virtual_bytes: u64,
}

impl Stat {
    /// Reads the fields that proc_pid_stat(5) numbers 14, 15, 20, 22 and 23.
    fn parse(text: &str) -> Option<Self> {
        // Field 2 is the program's name in parentheses, and may contain spaces and parentheses.
        let (_, after) = text.rsplit_once(") ")?;
        let fields: Vec<&str> = after.split_whitespace().collect();
        let field = |number: usize| -> Option<u64> { fields.get(number - 3)?.parse().ok() };
        Some(Self {
            cpu_s: (field(14)? + field(15)?) as f64 / TICKS_PER_S,
            threads: field(20)?,
            started_s: (field(22)? as f64 / TICKS_PER_S) as u64,
            virtual_bytes: field(23)?,
        })
    }
}

/// The number after a word at the beginning of a line.
fn number(text: &str, word: &str) -> Option<u64> {
    text.lines().find_map(|line| line.strip_prefix(word))?.split_whitespace().next()?.parse().ok()
}

fn signed(number: u64) -> i64 {
    i64::try_from(number).unwrap_or(i64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_of_proc_is_read_whatever_the_programs_name() {
        let line = "4242 (a) b) S 1 4242 4242 0 -1 4194560 1000 0 3 0 250 51 0 0 20 0 9 0 360050 123456789 4000 184467";
        let stat = Stat { cpu_s: 3.01, threads: 9, started_s: 3600, virtual_bytes: 123_456_789 };
        assert_eq!(Stat::parse(line), Some(stat));
        for broken in ["", "4242 (a) S 1", &line.replace("250", "x")] {
            assert_eq!(Stat::parse(broken), None, "{broken}");
        }
        assert_eq!(number("cpu 1 2\nbtime 1700000000\n", "btime"), Some(1_700_000_000));
        assert_eq!(number("VmSize:\t 5 kB\nVmRSS:\t   204800 kB\n", "VmRSS:"), Some(204_800));
        assert_eq!(number("VmRSS:\n", "VmRSS:"), None);
    }

    #[test]
    fn the_values_are_those_of_this_process() {
        let metrics = ProcessMetrics::new().unwrap();
        assert_eq!((metrics.desc().len(), metrics.collect().len()), (7, 7));
        let now_s = vibrissa_host::clock::host_clock_us() / 1_000_000;
        assert!((now_s - 3600..=now_s + 1).contains(&metrics.start.get()), "{} at {now_s}", metrics.start.get());
        assert!((3..=metrics.files_max.get()).contains(&metrics.open_files.get()));
        assert!((1 << 20..metrics.virtual_memory.get()).contains(&metrics.resident_memory.get()));
        assert!(metrics.threads.get() >= 2, "the test's thread and the main thread");
        let before = metrics.cpu.get();
        let began = tokio::time::Instant::now();
        while began.elapsed().as_millis() < 100 {
            std::hint::spin_loop();
        }
        metrics.collect();
        assert!((0.0..10.0).contains(&(metrics.cpu.get() - before)));
    }
}
