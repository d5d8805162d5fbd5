//! Receivers of webhooks: what each has taken, and how it answers.

use std::collections::BTreeMap;
use std::pin::Pin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tokio::sync::oneshot;
use tokio::time::{Instant, sleep, timeout};
use vibrissa_host::{process, task};
use vibrissa_store::webhooks::dead::Fate;
use vibrissa_store::webhooks::manage::WebhookSettings;
use vibrissa_supervisor::webhooks::{AttemptResult, Message, PATIENCE, Pace, Post, message_id};

use crate::history::Step;
use crate::invariants::{Invariant, Violation};
use crate::server::StoreServer;

/// Latency between supervisor and receiver in one direction.
const LATENCY: Duration = Duration::from_millis(2);
/// Time in which a receiver takes an event.
const WORK: Duration = Duration::from_millis(5);
/// Pauses of the supervisors: a receiver that fails for some seconds leaves dead letters.
pub const PACE: Pace = Pace {
    first: Duration::from_secs(1),
    longest: Duration::from_secs(20),
    attempts_max: 4,
    age_max: Duration::from_secs(86_400),
};
/// After a failover that lost commits, holds of targets and positions may be those of before. A hold lasts for less than this.
const UNCERTAIN: Duration = Duration::from_secs(30);
/// A sender closes a request after this time, unless it stands still. Then its hold lapses, and another one sends.
const CLOSED_AFTER: Duration = PATIENCE.saturating_add(LATENCY).saturating_add(LATENCY);
/// Filters of the targets: fleets, kinds, and level.
const FILTERS: [(Option<&str>, Option<&str>, &str); 3] = [
    (None, None, "WARNING"),
    (None, Some("TRIM,ALARM_RAISED,SETPOINT_FAILED"), "URGENT"),
    (Some("fleet-0"), None, "WARNING"),
];

/// How a receiver answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Manner {
    /// It takes the event at once.
    Works,
    /// It takes the event after this time.
    Slow(Duration),
    /// It answers with status 500.
    Fails,
    /// It never answers.
    Silent,
    /// It takes the event, and closes the connection without an answer.
    Cuts,
}

/// The receiver of one target.
#[derive(Debug)]
struct Receiver {
    manner: Manner,
    /// Identifiers of the requests that it works on, and their arrival.
    under_way: Vec<(String, Instant)>,
    /// Number of the newest event of which a request has come.
    newest: i64,
    /// Body of each event that it has taken, by identifier.
    taken: BTreeMap<String, Vec<u8>>,
}

#[derive(Debug, Default)]
struct State {
    /// By the number of the target.
    receivers: BTreeMap<i64, Receiver>,
    /// From then on order and holds are compared again.
    certain_from: Option<Instant>,
    violations: Vec<Violation>,
    steps: Vec<Step>,
}

/// All receivers, one for each target. Clones are the same ones.
#[derive(Debug, Clone)]
pub struct Receivers {
    begun: Instant,
    server: StoreServer,
    state: Arc<Mutex<State>>,
}

impl Receivers {
    /// Receivers that work, of targets in this database.
    #[must_use]
    pub fn new(server: &StoreServer) -> Self {
        let mut state = State::default();
        for (number, (fleets, kinds, level)) in FILTERS.into_iter().enumerate() {
            let settings = WebhookSettings {
                name: format!("receiver-{number}"),
                url: format!("http://receiver-{number}/"),
                fleets: fleets.map(str::to_owned),
                kinds: kinds.map(str::to_owned),
                level: level.to_owned(),
                enabled: true,
            };
            let webhook_id = server.data().add_webhook(&settings);
            let (manner, under_way, newest, taken) = (Manner::Works, Vec::new(), 0, BTreeMap::new());
            state.receivers.insert(webhook_id, Receiver { manner, under_way, newest, taken });
        }
        Self { begun: Instant::now(), server: server.clone(), state: Arc::new(Mutex::new(state)) }
    }

    /// Changes how one of them answers.
    pub fn set(&self, number: usize, manner: Manner) {
        let mut state = self.state();
        let count = state.receivers.len();
        if let Some(receiver) = state.receivers.values_mut().nth(number % count) {
            receiver.manner = manner;
        }
    }

    /// Notes a failover that has lost commits.
    pub fn lose_commits(&self) {
        let mut state = self.state();
        state.certain_from = Some(Instant::now() + UNCERTAIN);
        state.receivers.values_mut().for_each(|receiver| receiver.newest = 0);
    }

    /// Violations since the last call.
    #[must_use]
    pub fn take_violations(&self) -> Vec<Violation> {
        std::mem::take(&mut self.state().violations)
    }

    /// Requests since the last call.
    #[must_use]
    pub fn take_steps(&self) -> Vec<Step> {
        std::mem::take(&mut self.state().steps)
    }

    /// Number of events that were taken.
    #[must_use]
    pub fn taken(&self) -> u64 {
        self.state().receivers.values().map(|receiver| receiver.taken.len() as u64).sum()
    }

    /// Delivers the dead letters of all targets again, as an operator does.
    pub fn redeliver(&self) {
        let targets: Vec<i64> = self.state().receivers.keys().copied().collect();
        let mut data = self.server.data();
        for webhook_id in targets {
            if data.dead_letters(webhook_id).any(|(_, again)| !again) {
                data.settle_dead_letters(webhook_id, Fate::Again);
            }
        }
    }

    /// The first committed event that a target wants and has not taken.
    #[must_use]
    pub fn first_missing(&self) -> Option<String> {
        let (data, state) = (self.server.data(), self.state());
        state.receivers.iter().find_map(|(webhook_id, receiver)| {
            let mut wanted = data.events_for(*webhook_id).map(|event| message_id(*webhook_id, &event));
            wanted.find(|id| !receiver.taken.contains_key(id))
        })
    }

    /// A request arrives; returns how the receiver answers.
    fn arrives(&self, message: &Message) -> Manner {
        let Some((webhook_id, event_id)) = parts(&message.id) else { return Manner::Fails };
        let is_dead = self.server.data().dead_letters(webhook_id).any(|(of, _)| of == event_id);
        let mut state = self.state();
        let is_certain = state.certain_from.is_none_or(|from| from <= Instant::now());
        let Some(receiver) = state.receivers.get_mut(&webhook_id) else { return Manner::Fails };
        let mut found = Vec::new();
        receiver.under_way.retain(|(_, since)| since.elapsed() <= CLOSED_AFTER);
        if is_certain && let Some((other, _)) = receiver.under_way.first() {
            found.push((Invariant::WebhookOnce, format!("{} comes during {other}", message.id)));
        }
        if is_certain && event_id < receiver.newest && !is_dead {
            found.push((Invariant::WebhookInOrder, format!("{} comes after event {}", message.id, receiver.newest)));
        }
        receiver.newest = receiver.newest.max(event_id);
        receiver.under_way.push((message.id.clone(), Instant::now()));
        let manner = receiver.manner;
        let (from, to) = ("webhooks".to_owned(), format!("receiver-{webhook_id}"));
        state.steps.push(Step { at: self.begun.elapsed(), from, to, what: format!("{} {manner:?}", message.id) });
        state.violations.extend(found.into_iter().map(|(invariant, what)| Violation { invariant, what }));
        manner
    }

    fn takes(&self, message: &Message) {
        let Some((webhook_id, _)) = parts(&message.id) else { return };
        let mut state = self.state();
        let Some(receiver) = state.receivers.get_mut(&webhook_id) else { return };
        let former = receiver.taken.insert(message.id.clone(), message.body.clone());
        if former.is_some_and(|former| former != message.body) {
            let what = format!("{} is another event than before", message.id);
            state.violations.push(Violation { invariant: Invariant::WebhookIdOnce, what });
        }
    }

    fn leaves(&self, message: &Message) {
        let mut state = self.state();
        for receiver in state.receivers.values_mut() {
            receiver.under_way.retain(|(id, _)| *id != message.id);
        }
    }

    /// Serves a request until it is answered, or until the sender has closed the connection.
    async fn serve(self, message: Message, mut answer: oneshot::Sender<u16>) {
        sleep(LATENCY).await;
        let manner = self.arrives(&message);
        let work = async {
            match manner {
                Manner::Works | Manner::Cuts => sleep(WORK).await,
                Manner::Slow(pause) => sleep(pause).await,
                Manner::Fails => return Some(500),
                Manner::Silent => std::future::pending().await,
            }
            self.takes(&message);
            (manner != Manner::Cuts).then_some(204)
        };
        let status = tokio::select! {
            biased;
            () = answer.closed() => None,
            status = work => status,
        };
        self.leaves(&message);
        if let Some(status) = status {
            sleep(LATENCY).await;
            let _ = answer.send(status);
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Post for Receivers {
    fn post(&self, message: Message) -> Pin<Box<dyn Future<Output = AttemptResult> + Send + '_>> {
        let (answer, answered) = oneshot::channel();
        let receivers = self.clone();
        // A receiver is no part of the process that sends.
        process::enter(None, || task::spawn(receivers.serve(message, answer)));
        Box::pin(async {
            let failed = |why: &str| AttemptResult { status: None, failure: Some(why.to_owned()) };
            match timeout(PATIENCE, answered).await {
                Ok(Ok(status)) => AttemptResult { status: Some(status), failure: None },
                Ok(Err(_)) => failed("it closed the connection without an answer"),
                Err(_) => failed("no answer in time"),
            }
        })
    }
}

/// Numbers of the target and of the event in the identifier of a request.
fn parts(id: &str) -> Option<(i64, i64)> {
    let mut parts = id.split('-').skip(1).map_while(|part| part.parse().ok());
    parts.next().zip(parts.next())
}
