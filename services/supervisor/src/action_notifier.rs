//! Wakes those who wait for actions, within one supervisor: the engine that executes an action, and the request that
//! waits for its answer. It only saves time: actions and their answers are rows of the database, which all supervisors
//! share.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::{Notify, broadcast, watch};
use tokio::time::{Duration, Instant, sleep, sleep_until};
use vibrissa_edge::clock::wall_clock;
use vibrissa_protocol::Name;

use crate::ending::stopped;
use vibrissa_store::actions::{Action, FleetWork};
use vibrissa_store::{Store, StoreError};

/// Polling interval for actions that came over other supervisors, or whose time has come.
const LOOK: Duration = Duration::from_secs(1);

/// Polling interval for answers that another supervisor may give.
const POLL: Duration = Duration::from_millis(250);

/// Capacity of the channel of answers; a receiver that lags behind reads the database instead.
const ANSWERS: usize = 256;

/// Shared by the HTTP handlers and the fleets.
#[derive(Debug, Clone)]
pub struct ActionNotifier(Arc<Inner>);

#[derive(Debug)]
struct Inner {
    waiting: Mutex<BTreeMap<Name, Arc<Notify>>>,
    answered: broadcast::Sender<i64>,
    changed: watch::Sender<u64>,
}

impl Default for ActionNotifier {
    fn default() -> Self {
        Self(Arc::new(Inner {
            waiting: Mutex::default(),
            answered: broadcast::channel(ANSWERS).0,
            changed: watch::Sender::new(0),
        }))
    }
}

impl ActionNotifier {
    /// Announces a new action for a fleet. If the fleet is supervised here, its engine reads the action now; otherwise
    /// its owner finds it within a second in the table of actions.
    pub fn notify(&self, fleet: &Name) {
        if let Some(waiting) = self.waiting().get(fleet) {
            waiting.notify_one();
        }
    }

    /// Until `stop`, looks for pending actions, and for new lists of allowed robots, and wakes the engines of their fleets. One
    /// query for all fleets of this supervisor replaces one of each.
    pub(crate) async fn watch(self, store: Store, mut stop: watch::Receiver<bool>) {
        let mut lists = BTreeMap::new();
        loop {
            // The engines report if the database is unreachable.
            if let Ok(fleets) = store.fleets_with_work(wall_clock().0 as i64).await {
                for FleetWork { fleet, has_actions, allowed_version } in fleets {
                    let Ok(fleet) = Name::new(&fleet) else { continue };
                    let has_new_list = lists.insert(fleet.clone(), allowed_version) != Some(allowed_version);
                    if has_actions || has_new_list {
                        self.notify(&fleet);
                    }
                }
            }
            tokio::select! {
                () = sleep(LOOK) => {}
                () = stopped(&mut stop) => return,
            }
        }
    }

    /// Notified when a new action for a fleet arrives.
    pub(crate) fn subscribe(&self, fleet: &Name) -> Arc<Notify> {
        self.waiting().entry(fleet.clone()).or_default().clone()
    }

    fn waiting(&self) -> MutexGuard<'_, BTreeMap<Name, Arc<Notify>>> {
        self.0.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Announces a commit that changes what live pages show.
    pub(crate) fn changed(&self) {
        self.0.changed.send_modify(|count| *count = count.wrapping_add(1));
    }

    /// Counter that changes with each such commit of this supervisor.
    pub(crate) fn changes(&self) -> watch::Receiver<u64> {
        self.0.changed.subscribe()
    }

    /// Announces actions whose answers are committed.
    pub(crate) fn answered(&self, actions: impl IntoIterator<Item = i64>) {
        for action in actions {
            // An error means that nobody waits.
            let _ = self.0.answered.send(action);
        }
    }

    /// Waits until an action is answered by any supervisor, at most for `patience`; after that, the returned action may
    /// still be pending. `None` if there is no such action.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn answer(
        &self,
        store: &Store,
        action_id: i64,
        patience: Duration,
    ) -> Result<Option<Action>, StoreError> {
        let deadline = Instant::now() + patience;
        let mut answered = self.0.answered.subscribe();
        loop {
            let action = store.action(action_id).await?;
            let now = Instant::now();
            if action.as_ref().is_none_or(|action| !action.is_pending()) || now >= deadline {
                return Ok(action);
            }
            let next = deadline.min(now + POLL);
            loop {
                tokio::select! {
                    received = answered.recv() => match received {
                        Ok(other) if other != action_id => {}
                        // Also if the receiver lagged behind and missed answers.
                        Ok(_) | Err(broadcast::error::RecvError::Lagged(_) | broadcast::error::RecvError::Closed) => break,
                    },
                    () = sleep_until(next) => break,
                }
            }
        }
    }
}
