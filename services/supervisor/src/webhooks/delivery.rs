//! Delivery to one target: its events one after the other, until none is left or an attempt fails.

use std::time::Duration;

use tokio::sync::watch;
use tokio::time::Instant;
use tracing::{info, warn};
use uuid::Uuid;
use vibrissa_host::random;

use super::letter::Letter;
use super::sending::{AttemptResult, Message, PATIENCE};
use super::{Pace, Webhooks};
use crate::events::published;
use vibrissa_store::StoreError;
use vibrissa_store::events::StoredEvent;
use vibrissa_store::fault::{self, Fault};
use vibrissa_store::webhooks::queue::{Job, Outcome};

/// Time for which a target is held. It is longer than an attempt and the storage of its result may take, so that no other
/// supervisor begins meanwhile.
pub(super) const HOLD: Duration = Duration::from_secs(15);

/// Delivers to a target.
pub(super) struct Delivery {
    webhooks: Webhooks,
    webhook_id: i64,
}

impl Delivery {
    pub(super) fn new(webhooks: &Webhooks, webhook_id: i64) -> Self {
        Self { webhooks: webhooks.clone(), webhook_id }
    }

    /// Delivers until no event is left, an attempt fails, or `stop` becomes true.
    pub(super) async fn run(self, stop: watch::Receiver<bool>) {
        while !*stop.borrow() {
            match self.next().await {
                Ok(true) => {}
                Ok(false) => return,
                Err(problem) => {
                    warn!(webhook_id = self.webhook_id, %problem, "cannot deliver to a webhook, retrying");
                    return;
                }
            }
        }
    }

    /// Delivers the next event; false if there is none, or it failed.
    async fn next(&self) -> Result<bool, StoreError> {
        let Webhooks { store, sender, pace, metrics, holder, hold_back: _ } = &self.webhooks;
        let asked = Instant::now();
        let Some(job) = store.with_leader(store.take_webhook_job(self.webhook_id, holder, HOLD)).await? else {
            return Ok(false);
        };
        if let Some(pause) = self.too_early(&job) {
            let outcome = Outcome::Postponed { pause_us: pause.as_micros() as i64 };
            store.with_leader(store.finish_webhook_job(&job, holder, &outcome)).await?;
            return Ok(false);
        }
        // This process was frozen meanwhile, and another supervisor may hold the target.
        if asked.elapsed() + PATIENCE > HOLD {
            return Ok(false);
        }
        if fault::is(Fault::DeliveredBeforeRequest) {
            store.finish_webhook_job(&job, holder, &Outcome::Delivered { status: 204 }).await?;
        }
        let id = message_id(job.webhook.webhook_id, &job.event);
        let answer = if job.webhook.is_mail() {
            sender.send_mail(|mail| Letter::about(&job.webhook, id, job.events(), mail)).await
        } else {
            let (url, body) = (job.webhook.url.clone(), published(&job.event).into_bytes());
            sender.send(Message { url, id, body, secrets: job.secrets.clone() }).await
        };
        let outcome = outcome(&job, &answer, pace);
        let is_held = store.with_leader(store.finish_webhook_job(&job, holder, &outcome)).await?;
        let (event_id, name) = (job.event.event_id, job.webhook.name.as_str());
        match &outcome {
            Outcome::Delivered { .. } => {
                metrics.webhooks.delivered();
                if job.webhook.streak > 0 {
                    info!(webhook = name, event_id, failures = job.webhook.streak, "webhook takes events again");
                }
            }
            Outcome::Postponed { .. } => {}
            Outcome::Failed { problem, is_dead: true, .. } => {
                metrics.webhooks.dead();
                warn!(webhook = name, event_id, problem, "event becomes a dead letter of a webhook");
            }
            Outcome::Failed { problem, .. } => {
                metrics.webhooks.failed();
                if job.webhook.streak == 0 {
                    warn!(webhook = name, event_id, problem, "webhook did not take an event, retrying");
                }
            }
        }
        Ok(is_held && matches!(outcome, Outcome::Delivered { .. }))
    }

    /// Time until a mail may leave: its first event waits for others, and a person gets one mail at a time.
    fn too_early(&self, job: &Job) -> Option<Duration> {
        let mail = self.webhooks.sender.mail().filter(|_| job.webhook.is_mail())?;
        // After a clock was set back, a wait that began in the future is over.
        let age = |us: i64| u64::try_from(us).map_or(Duration::MAX, Duration::from_micros);
        let now_us = job.event.recorded_us.saturating_add(job.age_us);
        let since_last = job.webhook.last_success_us.map_or(Duration::MAX, |last_us| age(now_us - last_us));
        let wait = mail.gather.saturating_sub(age(job.age_us)).max(mail.pause.saturating_sub(since_last));
        (!wait.is_zero()).then_some(wait)
    }
}

/// Identifier of an event for a target: the same at each attempt. After a failover that lost events, a database gives their numbers
/// to others, even to one of the same time: so the identifier has a part of a hash of the content.
#[must_use]
pub fn message_id(webhook_id: i64, event: &StoredEvent) -> String {
    let StoredEvent { event_id, recorded_us, kind, word, fleet, robot, array, whisker, data, .. } = event;
    let content = format!("{kind} {word:?} {fleet} {robot:?} {array:?} {whisker:?} {data}");
    let (content, ..) = Uuid::new_v5(&Uuid::NAMESPACE_OID, content.as_bytes()).as_fields();
    format!("vibrissa-{webhook_id}-{event_id}-{recorded_us}-{content:08x}")
}

/// What becomes of an event after an attempt.
fn outcome(job: &Job, answer: &AttemptResult, pace: &Pace) -> Outcome {
    let Some(problem) = answer.problem() else {
        return Outcome::Delivered { status: answer.status.unwrap_or_default() };
    };
    let pause = pace.pause(job.webhook.streak + 1);
    let is_old = job.age_us > pace.age_max.as_micros() as i64 && !job.is_again;
    Outcome::Failed {
        status: answer.status,
        problem,
        is_dead: job.attempts + 1 >= pace.attempts_max || is_old,
        pause_us: jittered(pause).as_micros() as i64,
    }
}

/// Between half the pause and the pause, so that targets behind one broken server are not all tried at once.
fn jittered(pause: Duration) -> Duration {
    pause.mul_f64(0.5 + random::fraction() / 2.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A failover lost the first of two events of one time, and the second one got its number.
    #[test]
    fn regress_an_event_with_number_and_time_of_a_lost_one_has_an_identifier_of_its_own() {
        let event = |kind: &str, data: &str| StoredEvent {
            event_id: 93,
            tx: 3,
            recorded_us: 1_800_000_101_431_378,
            version: 1,
            kind: kind.to_owned(),
            word: None,
            fleet: "f".to_owned(),
            robot: Some("r".to_owned()),
            array: Some("left".to_owned()),
            whisker: Some(1),
            data: data.to_owned(),
        };
        let first = message_id(1, &event("TRIM", "{}"));
        assert_eq!(first, message_id(1, &event("TRIM", "{}")), "the same at each attempt");
        let others = [message_id(1, &event("CONDITION", "{}")), message_id(1, &event("TRIM", "{\"trim\":{}}"))];
        assert!(!others.contains(&first) && others[0] != others[1], "{first} {others:?}");
    }

    #[test]
    fn the_jitter_takes_at_most_half_of_a_pause() {
        let pause = Duration::from_secs(8);
        let all: Vec<Duration> = (0..200).map(|_| jittered(pause)).collect();
        assert!(all.iter().all(|one| *one >= pause / 2 && *one <= pause));
        assert!(all.iter().any(|one| *one != all[0]));
    }
}
