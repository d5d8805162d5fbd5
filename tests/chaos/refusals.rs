//! The supervisors' counters of refused messages and of violated invariants, summed over restarts.

use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use tokio::task::JoinHandle;
use tokio::time::{sleep, timeout};
use vibrissa_tests::web::try_get;

/// Interval of the requests. Counts between the last request and a kill are lost.
const PAUSE: Duration = Duration::from_secs(1);
/// Time limit of an answer.
const PATIENCE: Duration = Duration::from_secs(2);
/// Words that the counters' names contain.
const WORDS: [&str; 10] = [
    "invariant_violations",
    "refused",
    "duplicate",
    "shed",
    "given_up",
    "quarantin",
    "takeover",
    "conflict",
    "forged",
    "forgotten",
];

/// Reads the counters repeatedly until it is dropped.
pub struct Refusals {
    sums: Arc<Mutex<BTreeMap<String, u64>>>,
    task: JoinHandle<()>,
}

impl Drop for Refusals {
    fn drop(&mut self) {
        self.task.abort();
    }
}

impl Refusals {
    /// Starts to read the metrics at these addresses.
    pub fn start(supervisors: Vec<SocketAddr>) -> Self {
        let sums = Arc::new(Mutex::new(BTreeMap::new()));
        let task = tokio::spawn(ask(supervisors, sums.clone()));
        Self { sums, task }
    }

    /// Lower bounds of the counters above zero, by name and labels.
    pub fn counts(&self) -> BTreeMap<String, u64> {
        self.sums.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

async fn ask(supervisors: Vec<SocketAddr>, sums: Arc<Mutex<BTreeMap<String, u64>>>) {
    let mut last: Vec<BTreeMap<String, u64>> = vec![BTreeMap::new(); supervisors.len()];
    loop {
        for (address, last) in supervisors.iter().zip(&mut last) {
            let Ok(Ok((200, text))) = timeout(PATIENCE, try_get(*address, "/metrics")).await else { continue };
            let now = counters(&text);
            let mut sums = sums.lock().unwrap_or_else(PoisonError::into_inner);
            for (name, &count) in &now {
                let more = added(last.get(name).copied().unwrap_or_default(), count);
                if more > 0 {
                    *sums.entry(name.clone()).or_default() += more;
                }
            }
            *last = now;
        }
        sleep(PAUSE).await;
    }
}

/// The increase of a counter; a lower value means that the supervisor has restarted.
fn added(before: u64, now: u64) -> u64 {
    if now >= before { now - before } else { now }
}

/// Counters of refused messages and of violated invariants, by name and labels.
fn counters(text: &str) -> BTreeMap<String, u64> {
    let line = |line: &str| {
        let (name, value) = line.rsplit_once(' ')?;
        let of_family = name.split('{').next()?;
        let is_one = of_family.ends_with("_total") && WORDS.iter().any(|word| of_family.contains(word));
        is_one.then_some(())?;
        Some((name.to_owned(), value.parse::<f64>().ok()? as u64))
    };
    text.lines().filter_map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counters_of_refusals_are_read_and_other_counters_are_not() {
        let text = "# HELP vibrissa_messages_refused_total Messages.\n\
            vibrissa_messages_refused_total{fleet=\"f\",reason=\"malformed\"} 3\n\
            vibrissa_messages_received_total{fleet=\"f\",topic=\"contacts\"} 9\nvibrissa_messages_shed_total{fleet=\"f\"} 0\n";
        let found = counters(text);
        assert_eq!(found.len(), 2);
        assert_eq!(found["vibrissa_messages_refused_total{fleet=\"f\",reason=\"malformed\"}"], 3);
    }

    #[test]
    fn a_lower_count_means_a_restart() {
        assert_eq!([added(0, 5), added(5, 7), added(7, 2)], [5, 2, 2]);
    }
}
