//! Delivery of events to programs elsewhere, and of mails to people. A person's address is a target as a program is: its
//! URL is `mailto:` and the address. One mail tells all events that came since the one before.
//!
//! Events come from the log (`vibrissa_store::events`), each webhook with its own position. Every supervisor looks for targets with waiting events each second. It takes hold of a target in the database, so that
//! one supervisor at a time delivers to it, and sends its events one after the other. Each target has its own task: a dead
//! one delays no other, and the engines never wait.

mod delivery;
mod letter;
mod mail;
mod sending;
pub mod signature;
mod smtp;
pub mod target;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use tokio::sync::watch;
use tokio::task::JoinHandle;
use tokio::time::{Instant, timeout};
use tracing::warn;
use vibrissa_host::task;

use crate::clocks::HoldBack;
use crate::metrics::Metrics;
pub use delivery::message_id;
use delivery::{Delivery, HOLD};
pub use letter::Letter;
pub use mail::{Encryption, MailOptions, sender as mail_sender};
pub use sending::{AttemptResult, Message, PATIENCE, Post, Sender};
use target::Hosts;
use vibrissa_edge::clock::wall_clock;
use vibrissa_store::{Store, StoreError};

/// Polling interval for waiting events.
const LOOK_EVERY: Duration = Duration::from_secs(1);
/// Interval between two measurements of the queues for the metrics.
const MEASURE_EVERY: Duration = Duration::from_secs(10);
/// Interval between two removals of old events, and of those beyond the outbox's limit. As often, ended maintenances are
/// looked for.
const TRIM_EVERY: Duration = Duration::from_secs(10);
/// Time limit for attempts that are under way when the service stops.
const STOP_PATIENCE: Duration = Duration::from_secs(3);

/// Pauses between attempts, and their number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pace {
    /// Pause after the first failed attempt; it doubles with each further one.
    pub first: Duration,
    /// Longest pause.
    pub longest: Duration,
    /// Failed attempts after which an event becomes a dead letter.
    pub attempts_max: i64,
    /// Age from which on a failed attempt makes an event a dead letter.
    pub age_max: Duration,
}

impl Default for Pace {
    fn default() -> Self {
        Self {
            first: Duration::from_secs(1),
            longest: Duration::from_secs(600),
            attempts_max: 12,
            age_max: Duration::from_secs(86_400),
        }
    }
}

impl Pace {
    /// The pause after so many failed attempts, before the jitter.
    fn pause(&self, failures: i64) -> Duration {
        let doublings = (failures - 1).clamp(0, 20);
        self.first.saturating_mul(1 << doublings).min(self.longest)
    }
}

/// Options of webhooks.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct WebhookOptions {
    /// Hosts that may have private addresses.
    pub allowed_hosts: Vec<String>,
    /// Pauses between attempts.
    pub pace: Pace,
    /// The mail server, if people get mails.
    pub mail: Option<MailOptions>,
}

impl WebhookOptions {
    /// Sends over HTTP to public addresses and to the allowed hosts, and mails over the mail server.
    #[must_use]
    pub fn sender(&self) -> Sender {
        Sender::new(Hosts::new(&self.allowed_hosts), self.mail.clone())
    }
}

/// Sends events. Clones share their connections.
#[derive(Debug, Clone)]
pub struct Webhooks {
    store: Store,
    sender: Sender,
    pace: Pace,
    metrics: Metrics,
    /// Name of this process as the holder of targets.
    holder: Arc<str>,
    hold_back: HoldBack,
}

impl Webhooks {
    /// Sends nothing yet. `holder` is unique among the processes of the database.
    #[must_use]
    pub fn new((sender, pace): (Sender, Pace), store: Store, metrics: Metrics, holder: Arc<str>) -> Self {
        Self { store, sender, pace, metrics, holder, hold_back: HoldBack::default() }
    }

    /// Removes old events by this time.
    pub(crate) fn holding_back(self, hold_back: HoldBack) -> Self {
        Self { hold_back, ..self }
    }

    /// Sends single requests, for tests of targets.
    #[must_use]
    pub fn sender(&self) -> &Sender {
        &self.sender
    }

    /// Delivers until `stop` becomes true.
    pub async fn run(self, mut stop: watch::Receiver<bool>) {
        let mut tasks: BTreeMap<i64, JoinHandle<()>> = BTreeMap::new();
        let (mut measured, mut trimmed, mut is_prepared, mut is_failing) = (None, None, false, false);
        while timeout(LOOK_EVERY, stop.wait_for(|&stop| stop)).await.is_err() {
            let looked = async {
                if !is_prepared {
                    self.store.prepare_events().await?;
                    is_prepared = true;
                }
                tasks.retain(|_, task| !task.is_finished());
                for webhook_id in self.store.due_webhooks(&self.holder, HOLD).await? {
                    tasks.entry(webhook_id).or_insert_with(|| {
                        let delivery = Delivery::new(&self, webhook_id);
                        task::spawn(delivery.run(stop.clone()))
                    });
                }
                if is_due(&mut measured, MEASURE_EVERY) {
                    self.measure().await?;
                }
                if is_due(&mut trimmed, TRIM_EVERY) {
                    let now_us = wall_clock().0 as i64;
                    self.store.tell_after_maintenance(now_us).await?;
                    self.store.trim_events_for_webhooks(self.hold_back.old_by_us(now_us)).await?;
                }
                Ok::<(), StoreError>(())
            };
            let problem = self.store.with_leader(looked).await.err();
            if let Some(problem) = problem.as_ref().filter(|_| !is_failing) {
                warn!(%problem, "cannot read the queues of the webhooks, retrying");
            }
            is_failing = problem.is_some();
        }
        let ended = futures_util::future::join_all(tasks.into_values());
        // Otherwise another supervisor would wait for the end of the hold. While an attempt is under way, it must.
        if timeout(STOP_PATIENCE, ended).await.is_ok() {
            let _ = timeout(STOP_PATIENCE, self.store.release_webhooks(&self.holder)).await;
        }
    }

    async fn measure(&self) -> Result<(), StoreError> {
        let (mut waiting, mut dead, mut oldest_us) = (0, 0, None::<i64>);
        let mut webhooks = self.store.webhooks().await?;
        webhooks.retain(|webhook| webhook.enabled);
        for queue in self.store.webhook_queues(&webhooks).await? {
            waiting += queue.waiting;
            dead += queue.dead;
            oldest_us = oldest_us.into_iter().chain(queue.oldest_us).min();
        }
        let age_us = oldest_us.map_or(0, |oldest_us| (wall_clock().0 as i64 - oldest_us).max(0));
        self.metrics.webhooks.queue(waiting, dead, age_us as f64 / 1e6);
        Ok(())
    }
}

/// Whether something is due that was done last at a time, which becomes now.
fn is_due(last: &mut Option<Instant>, every: Duration) -> bool {
    let is_due = last.is_none_or(|last| last.elapsed() >= every);
    if is_due {
        *last = Some(Instant::now());
    }
    is_due
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pauses_double_up_to_the_longest() {
        let pace = Pace::default();
        let pauses: Vec<u64> = (1..=12).map(|failures| pace.pause(failures).as_secs()).collect();
        assert_eq!(pauses, [1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 600, 600]);
        assert_eq!(pace.pause(i64::MAX), pace.longest);
    }
}
