//! Between those who ask for an action and the engines that carry it out, within one supervisor: it makes things quick.
//! What was asked and what became of it is in the database, where supervisors meet.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::{Notify, broadcast, watch};
use tokio::time::{Duration, Instant, sleep_until};
use vibrissa_protocol::Name;

use vibrissa_store::actions::Action;
use vibrissa_store::{Store, StoreError};

/// How often an answer is looked for that another supervisor may give.
const POLL: Duration = Duration::from_millis(250);

/// Answers that may wait to be noticed; beyond it they are found by looking.
const ANSWERS: usize = 256;

/// Shared by everything that asks, and by the fleets.
#[derive(Debug, Clone)]
pub struct Mailroom(Arc<Inner>);

#[derive(Debug)]
struct Inner {
    bells: Mutex<BTreeMap<Name, Arc<Notify>>>,
    answered: broadcast::Sender<i64>,
    changed: watch::Sender<u64>,
}

impl Default for Mailroom {
    fn default() -> Self {
        Self(Arc::new(Inner {
            bells: Mutex::default(),
            answered: broadcast::channel(ANSWERS).0,
            changed: watch::Sender::new(0),
        }))
    }
}

impl Mailroom {
    /// Announces a new action for a fleet. Its engine reads the action now if the fleet is supervised here, else within a second,
    /// when the owner looks at the table of actions.
    pub fn ring(&self, fleet: &Name) {
        if let Some(bell) = self.bells().get(fleet) {
            bell.notify_one();
        }
    }

    /// What rings when something is asked of a fleet.
    pub(crate) fn bell(&self, fleet: &Name) -> Arc<Notify> {
        self.bells().entry(fleet.clone()).or_default().clone()
    }

    fn bells(&self) -> MutexGuard<'_, BTreeMap<Name, Arc<Notify>>> {
        self.0.bells.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Says that something was committed which live pages show.
    pub(crate) fn changed(&self) {
        self.0.changed.send_modify(|count| *count = count.wrapping_add(1));
    }

    /// What changes with each such commit of this supervisor.
    pub(crate) fn changes(&self) -> watch::Receiver<u64> {
        self.0.changed.subscribe()
    }

    /// Says that these actions are answered, and committed so.
    pub(crate) fn answered(&self, actions: impl IntoIterator<Item = i64>) {
        for action in actions {
            // Nobody may be waiting.
            let _ = self.0.answered.send(action);
        }
    }

    /// Waits until an action is answered, here or elsewhere, but not longer than that; what is given back may be pending
    /// still. None if there is no such action.
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
                    told = answered.recv() => match told {
                        Ok(other) if other != action_id => {}
                        // Also if so many were answered that some were missed.
                        Ok(_) | Err(broadcast::error::RecvError::Lagged(_) | broadcast::error::RecvError::Closed) => break,
                    },
                    () = sleep_until(next) => break,
                }
            }
        }
    }
}
