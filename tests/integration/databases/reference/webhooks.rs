//! Steps of webhooks: targets, holds, deliveries, dead letters.

use std::time::Duration;

use rand::Rng;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;
use vibrissa_store::events::StoredEvent;
use vibrissa_store::webhooks::dead::Fate;
use vibrissa_store::webhooks::manage::{Set, WebhookSettings};
use vibrissa_store::webhooks::queue::{Job, Outcome};
use vibrissa_tests::actions::asks;

use super::subject::{Behind, Subject};
use super::text;

/// No hold lapses while the test runs.
const HOLD: Duration = Duration::from_secs(600);
/// Pause after which nothing is due while the test runs, µs.
const LONG_US: i64 = 3_600_000_000;
/// Most targets of a fleet.
const TARGETS: usize = 3;
const HOLDERS: [&str; 2] = ["one", "two"];

/// What webhooks have been asked so far.
#[derive(Default)]
pub(super) struct Known {
    targets: Vec<(i64, WebhookSettings)>,
    /// Jobs, each with its holder.
    jobs: Vec<(Job, &'static str)>,
}

pub(super) async fn step(subject: &mut Subject, random: &mut ChaCha8Rng) -> String {
    if subject.webhooks.targets.is_empty() {
        return add(subject, random).await;
    }
    match random.random_range(0..13) {
        0 => add(subject, random).await,
        1 => enable(subject, random).await,
        2..6 => take(subject, random).await,
        6..9 => finish(subject, random).await,
        9 => settle(subject, random).await,
        10 => release(subject, random).await,
        11 => step_clock(subject, random).await,
        _ => queues(subject).await,
    }
}

async fn add(subject: &mut Subject, random: &mut ChaCha8Rng) -> String {
    let number = subject.webhooks.targets.len();
    let kinds = *[None, Some("TRIM,ALARM_RAISED,ALARM_CLEARED"), Some("ALARM_RAISED")].choose(random).unwrap();
    let level = *["WARNING", "URGENT"].choose(random).unwrap();
    if number == TARGETS {
        return "no further target".to_owned();
    }
    let settings = WebhookSettings {
        name: format!("{}-{number}", subject.fleet()),
        url: "http://receiver/".to_owned(),
        fleets: Some(subject.fleet().to_string()),
        kinds: kinds.map(str::to_owned),
        level: level.to_owned(),
        enabled: true,
    };
    let webhook_id = match &subject.behind {
        Behind::Model(at_hand) => at_hand.store().add_webhook(&settings),
        Behind::Database(_) => {
            let set = subject.store.add_webhook(&settings, b"secret", &asks("WEBHOOK_CREATE", "{}")).await.unwrap();
            let Set::Done(webhook_id) = set else { panic!("{set:?}") };
            webhook_id
        }
    };
    let told = format!("add target {settings:?}");
    subject.webhooks.targets.push((webhook_id, settings));
    told
}

async fn enable(subject: &mut Subject, random: &mut ChaCha8Rng) -> String {
    let at = random.random_range(0..subject.webhooks.targets.len());
    let (webhook_id, settings) = &mut subject.webhooks.targets[at];
    settings.enabled = random.random_bool(0.7);
    match &subject.behind {
        Behind::Model(at_hand) => at_hand.store().enable_webhook(*webhook_id, settings.enabled),
        Behind::Database(_) => {
            let asked = asks("WEBHOOK_UPDATE", "{}");
            let set = subject.store.change_webhook(*webhook_id, settings, &asked).await.unwrap();
            assert_eq!(set, Set::Done(*webhook_id));
        }
    }
    format!("target {at} is enabled: {}", settings.enabled)
}

fn told(event: &StoredEvent) -> String {
    let StoredEvent { recorded_us, version, kind, word, fleet, robot, array, whisker, data, .. } = event;
    format!("{recorded_us} {version} {kind} {word:?} {fleet} {robot:?} {array:?} {whisker:?} {data}")
}

async fn take(subject: &mut Subject, random: &mut ChaCha8Rng) -> String {
    let holder = HOLDERS[usize::from(random.random_bool(0.3))];
    let at = random.random_range(0..subject.webhooks.targets.len());
    let place = |id: &i64| subject.webhooks.targets.iter().position(|(target, _)| target == id);
    let due = subject.store.due_webhooks(holder, HOLD).await.unwrap();
    let mut due: Vec<usize> = due.iter().filter_map(place).collect();
    due.sort_unstable();
    let webhook_id = subject.webhooks.targets[at].0;
    let job = subject.store.take_webhook_job(webhook_id, holder, HOLD).await.unwrap();
    let taken = job.as_ref().map(|job| {
        let row = &job.webhook;
        (told(&job.event), job.attempts, job.is_again, row.streak, row.delivered, row.failed)
    });
    subject.webhooks.jobs.extend(job.map(|job| (job, holder)));
    format!("{holder} takes target {at} of {due:?}: {taken:?}")
}

async fn finish(subject: &mut Subject, random: &mut ChaCha8Rng) -> String {
    let outcome = match random.random_range(0..5) {
        0..3 => Outcome::Delivered { status: 204 },
        what => Outcome::Failed {
            status: random.random_bool(0.5).then_some(500),
            problem: "broken".to_owned(),
            is_dead: what == 3,
            pause_us: if random.random_bool(0.2) { LONG_US } else { 0 },
        },
    };
    let is_repeated = random.random_bool(0.1);
    let Some((job, holder)) = subject.webhooks.jobs.last().cloned() else { return "no job to finish".to_owned() };
    if !is_repeated {
        subject.webhooks.jobs.pop();
    }
    let is_held = subject.store.finish_webhook_job(&job, holder, &outcome).await;
    format!("{holder} finishes {}: {outcome:?} {}", told(&job.event), text(is_held))
}

async fn settle(subject: &mut Subject, random: &mut ChaCha8Rng) -> String {
    let at = random.random_range(0..subject.webhooks.targets.len());
    let webhook_id = subject.webhooks.targets[at].0;
    let fate = if random.random_bool(0.8) { Fate::Again } else { Fate::Discarded };
    let letters = match &subject.behind {
        Behind::Model(at_hand) => at_hand.store().settle_dead_letters(webhook_id, fate),
        Behind::Database(_) => {
            let asked = asks("WEBHOOK_REDELIVER", "{}");
            subject.store.settle_dead_letters(webhook_id, None, fate, &asked).await.unwrap().1
        }
    };
    format!("dead letters of target {at}: {letters} {fate:?}")
}

async fn release(subject: &mut Subject, random: &mut ChaCha8Rng) -> String {
    let holder = HOLDERS[usize::from(random.random_bool(0.5))];
    format!("{holder} lets go: {}", text(subject.store.release_webhooks(holder).await))
}

/// The database's clock is stepped back, or ahead again.
async fn step_clock(subject: &mut Subject, random: &mut ChaCha8Rng) -> String {
    let at = random.random_range(0..subject.webhooks.targets.len());
    let webhook_id = subject.webhooks.targets[at].0;
    let by_us = *[-2 * LONG_US, 2 * LONG_US].choose(random).unwrap();
    match &mut subject.behind {
        Behind::Model(at_hand) => at_hand.store().move_attempt(webhook_id, by_us),
        Behind::Database(admin) => {
            let moved = format!("next_us = next_us + {by_us}, last_us = last_us + {by_us}");
            admin.execute(format!("UPDATE webhooks SET {moved} WHERE webhook_id = {webhook_id}")).await;
        }
    }
    format!("move the last attempt of target {at} by {by_us}")
}

/// Dead letters, each with whether it is delivered again.
async fn letters(subject: &Subject, webhook_id: i64) -> Vec<bool> {
    match &subject.behind {
        Behind::Model(at_hand) => at_hand.store().dead_letters(webhook_id).map(|(_, again)| again).collect(),
        Behind::Database(_) => {
            let letters = subject.store.dead_letters(webhook_id).await.unwrap();
            letters.iter().map(|(letter, _)| letter.again).collect()
        }
    }
}

async fn queues(subject: &mut Subject) -> String {
    subject.store.trim_events_for_webhooks(1).await.unwrap();
    let mut rows = subject.store.webhooks().await.unwrap();
    rows.retain(|row| subject.webhooks.targets.iter().any(|(id, _)| *id == row.webhook_id));
    let queues = subject.store.webhook_queues(&rows).await.unwrap();
    let now_us = vibrissa_edge::clock::wall_clock().0 as i64;
    let mut dead = Vec::new();
    for row in &rows {
        dead.push(letters(subject, row.webhook_id).await);
    }
    let told = rows.iter().zip(queues).map(|(row, queue)| {
        let counts = [row.streak, row.delivered, row.failed, row.lost];
        let (waits, status, problem) = (row.next_us > now_us, row.last_status, &row.last_problem);
        let times = (row.last_us.is_some(), row.last_success_us.is_some());
        format!("{} {} {counts:?} {waits} {status:?} {problem:?} {times:?} {queue:?}", row.name, row.enabled)
    });
    format!("queues {:?}, dead letters {dead:?}", told.collect::<Vec<_>>())
}
