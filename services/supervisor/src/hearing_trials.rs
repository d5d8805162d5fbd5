//! Fleets whose robots may be unheard: this supervisor reports to the others, in the membership, which fleets it hears.
//!
//! An owner that has not heard its robots for a while reports the fleet as deaf. Supervisors that could acquire the
//! fleet then test whether they hear it, and report the result. A supervisor that has given a fleet up keeps testing,
//! and acquires it again only after it hears it.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use tokio::sync::watch;
use tokio::task::JoinHandle;
use tokio::time::sleep;
use tracing::{info, warn};
use vibrissa_host::task;
use vibrissa_protocol::{BootId, Name};

use crate::fleet::Shared;
use crate::mqtt::{BrokerLink, Connection, try_hearing};
use vibrissa_store::{FleetsHeard, Membership};

/// Pause between two trials.
const TRIAL_PAUSE: Duration = Duration::from_secs(2);
/// Name of this part in the service's readiness.
const PART: &str = "hearing";

/// Fleets that some supervisor may not hear, and the trials to hear them from here.
#[derive(Default)]
pub(crate) struct HearingTrials {
    /// Fleets that were not heard for too long, and why.
    deaf: BTreeMap<Name, String>,
    /// Trials of fleets that are not supervised here.
    trials: BTreeMap<Name, Trial>,
}

/// Repeatedly opens a short connection to test whether a fleet can be heard. Dropping it ends the test.
struct Trial {
    /// Result of the last trial; `None` until the first one has ended.
    shown: watch::Receiver<Option<Result<(), String>>>,
    task: JoinHandle<()>,
}

impl Drop for Trial {
    fn drop(&mut self) {
        self.task.abort();
    }
}

impl Trial {
    fn start(fleet: &Name, shared: &Shared) -> Option<Self> {
        let boot_id = BootId::new(&shared.supervisor).ok()?;
        let connection = Connection::new(shared.broker.clone(), shared.prepared.clone(), fleet.clone(), boot_id);
        let (show, shown) = watch::channel(None);
        let task = task::spawn(async move {
            loop {
                let tried = try_hearing(&connection).await;
                // The trial was dropped.
                if show.send(Some(tried)).is_err() {
                    return;
                }
                sleep(TRIAL_PAUSE).await;
            }
        });
        Some(Self { shown, task })
    }
}

impl HearingTrials {
    /// Reads the hearing of the owned fleets from their links, and of the others from their trials.
    pub(crate) fn listen<'a>(
        &mut self,
        owned: impl Iterator<Item = (&'a Name, Option<&'a BrokerLink>)>,
        shared: &Shared,
    ) {
        let limit = shared.broker.deaf_release_after;
        let mut owned_here = BTreeSet::new();
        for (fleet, link) in owned {
            owned_here.insert(fleet.clone());
            self.trials.remove(fleet);
            // Before the engine has started, nothing is known.
            match link.map(BrokerLink::deafness) {
                None => {}
                Some(None) => drop(self.deaf.remove(fleet)),
                Some(Some((deaf_for, _))) if deaf_for < limit => {}
                Some(Some((deaf_for, why))) => {
                    if !self.deaf.contains_key(fleet) {
                        let seconds = deaf_for.as_secs_f32();
                        warn!(%fleet, seconds, why, "fleet not heard, any supervisor that hears it may acquire it");
                    }
                    self.deaf.insert(fleet.clone(), why);
                }
            }
        }
        for (fleet, trial) in &self.trials {
            match trial.shown.borrow().as_ref() {
                None => {}
                Some(Ok(())) if self.deaf.remove(fleet).is_some() => info!(%fleet, "trial heard the fleet again"),
                Some(Ok(())) => {}
                Some(Err(why)) => {
                    if let Some(reason) = self.deaf.get_mut(fleet) {
                        reason.clone_from(why);
                    }
                }
            }
        }
        for fleet in shared.readiness.fleets().keys() {
            // The owner's link reports its problem itself.
            let given_up = self.deaf.get(fleet).filter(|_| !owned_here.contains(fleet));
            let problem = given_up.map(|why| format!("released, because its robots were not heard: {why}"));
            shared.readiness.set_of(fleet, PART, problem);
        }
    }

    /// Hearing report for the other supervisors.
    pub(crate) fn report(&self) -> FleetsHeard {
        let heard = |trial: &Trial| matches!(&*trial.shown.borrow(), Some(Ok(())));
        FleetsHeard {
            deaf: self.deaf.keys().cloned().collect(),
            heard: self.trials.iter().filter(|(_, trial)| heard(trial)).map(|(fleet, _)| fleet.clone()).collect(),
        }
    }

    /// Starts trials of fleets that a supervisor may not hear, and stops those that are no longer needed.
    pub(crate) fn try_doubtful(&mut self, membership: &Membership, supervisor: &str, shared: &Shared) {
        let is_doubtful = |fleet: &Name| {
            self.deaf.contains_key(fleet)
                || membership.present.iter().any(|one| {
                    one.supervisor != supervisor
                        && one.hearing.deaf.contains(fleet)
                        && owns(membership, &one.supervisor, fleet)
                })
        };
        let doubtful: BTreeSet<Name> = membership
            .leases
            .iter()
            .map(|lease| &lease.fleet)
            .filter(|fleet| is_doubtful(fleet) && !owns(membership, supervisor, fleet))
            .cloned()
            .collect();
        self.trials.retain(|fleet, _| doubtful.contains(fleet));
        for fleet in doubtful {
            if !self.trials.contains_key(&fleet)
                && let Some(trial) = Trial::start(&fleet, shared)
            {
                info!(%fleet, "testing whether the fleet can be heard");
                self.trials.insert(fleet, trial);
            }
        }
    }
}

fn owns(membership: &Membership, supervisor: &str, fleet: &Name) -> bool {
    membership
        .leases
        .iter()
        .any(|lease| lease.fleet == *fleet && !lease.free && lease.owner.as_deref() == Some(supervisor))
}
