//! Ownership of fleets: renews this supervisor's leases, acquires its share of the fleets, releases the surplus.

use std::collections::BTreeMap;

use tokio::sync::watch;
use tokio::task::{AbortHandle, JoinSet};
use tokio::time::{Duration, Instant, sleep};
use tracing::{error, info, warn};
use vibrissa_protocol::Name;

use crate::fleet::{Fleet, Shared};
use crate::hearing_trials::HearingTrials;
use crate::metrics::{LOST, TAKEN};
use crate::mqtt::stopped;
use crate::readiness::Standing;
use crate::sharing::shares;
use vibrissa_store::{Membership, StoreError, Supervisor, Writer};

/// Number of turns in a lease's time to live. Each turn renews the leases and looks for free ones.
const TURNS_A_TIME_TO_LIVE: u32 = 8;

/// Shortest pause between two turns: an owner may be renewing at this moment.
const SHORTEST_PAUSE: Duration = Duration::from_millis(20);

/// Name of this part in the service's readiness.
const PART: &str = "ownership";

/// Renews, acquires and releases leases.
pub(crate) struct Ownership {
    supervisor: Supervisor,
    shared: Shared,
    writer: Writer,
    fleets: BTreeMap<Name, Fleet>,
    /// Fleets that are being stopped. A fleet must have ended before it can be acquired again.
    ending: JoinSet<()>,
    ending_names: BTreeMap<Name, AbortHandle>,
    is_prepared: bool,
    hearing: HearingTrials,
    outage: Outage,
}

/// A period in which leases cannot be renewed. Only its start and its end are logged.
#[derive(Debug, Default)]
struct Outage(Option<Instant>);

impl Outage {
    /// Records the result of an attempt. Returns true, and logs, if the state has changed.
    fn note(&mut self, problem: Option<&StoreError>) -> bool {
        match (problem, self.0) {
            (Some(problem), None) => {
                self.0 = Some(Instant::now());
                warn!(%problem, "cannot renew the leases, retrying");
            }
            (None, Some(since)) => {
                self.0 = None;
                info!(seconds = since.elapsed().as_secs_f32(), "leases renewed again");
            }
            (Some(_), Some(_)) | (None, None) => return false,
        }
        true
    }
}

impl Ownership {
    /// Owns nothing yet. `is_prepared` says that the tables of the database are up to date.
    pub(crate) fn new(supervisor: Supervisor, shared: Shared, is_prepared: bool) -> Self {
        shared.readiness.set(PART, Some("starting: the owners of the fleets are not known yet".to_owned()));
        let writer = shared.store.writer();
        Self {
            supervisor,
            shared,
            writer,
            fleets: BTreeMap::new(),
            ending: JoinSet::new(),
            ending_names: BTreeMap::new(),
            is_prepared,
            hearing: HearingTrials::default(),
            outage: Outage::default(),
        }
    }

    /// Repeats turns until `stop`, then releases all leases.
    pub(crate) async fn run(mut self, mut stop: watch::Receiver<bool>) {
        loop {
            let turn = tokio::select! {
                turn = self.turn() => turn,
                () = stopped(&mut stop) => break,
            };
            match &turn {
                Ok(_) => self.shared.metrics.database_up.set(1),
                Err(_) => self.shared.metrics.database_failed(),
            }
            self.outage.note(turn.as_ref().err());
            let pause = *turn.as_ref().unwrap_or(&self.pause());
            self.shared.readiness.set(PART, turn.err().map(|problem| problem.told()));
            tokio::select! {
                () = sleep(pause) => {}
                () = stopped(&mut stop) => break,
            }
        }
        self.leave().await;
    }

    fn pause(&self) -> Duration {
        // A database that is not shared needs no frequent renewal: there is no competitor.
        let turns = if self.shared.store.is_shared() { TURNS_A_TIME_TO_LIVE } else { 1 };
        self.supervisor.time_to_live / turns
    }

    /// One turn: renew, read the membership, release, acquire. Returns the time until the next turn, which is due at the
    /// latest when another supervisor's lease expires.
    async fn turn(&mut self) -> Result<Duration, StoreError> {
        if !self.is_prepared {
            self.shared.store.prepare().await?;
            self.is_prepared = true;
        }
        self.remove_ended();
        let held: Vec<_> = self.fleets.values().map(|fleet| fleet.lease().clone()).collect();
        if self.shared.store.is_shared() {
            let links = self.fleets.iter().map(|(name, fleet)| (name, fleet.link()));
            self.hearing.listen(links, &self.shared);
        }
        let membership = self.writer.sign_in_hearing(&self.supervisor, &held, &self.hearing.report()).await?;
        self.drop_lost(&membership);
        if self.shared.store.is_shared() {
            self.hearing.try_doubtful(&membership, &self.supervisor.id, &self.shared);
        }
        let shares = shares(&membership);
        let mine = |fleet: &Name| shares.get(fleet).is_some_and(|owner| **owner == *self.supervisor.id);
        let too_many: Vec<Name> = self.fleets.keys().filter(|fleet| !mine(fleet)).cloned().collect();
        let missing: Vec<Name> = membership
            .leases
            .iter()
            .filter(|lease| mine(&lease.fleet))
            .filter(|lease| !self.fleets.contains_key(&lease.fleet) && !self.ending_names.contains_key(&lease.fleet))
            .map(|lease| lease.fleet.clone())
            .collect();
        for fleet in too_many {
            info!(%fleet, "releasing fleet to rebalance");
            self.end(&fleet);
        }
        for fleet in missing {
            if let Some(lease) = self.writer.acquire(&self.supervisor, &fleet).await? {
                info!(%fleet, epoch = lease.epoch(), "fleet lease acquired");
                let metrics = self.shared.metrics.of_fleet(&fleet);
                metrics.lease_held.set(1);
                metrics.lease_epoch.set(lease.epoch() as i64);
                metrics.lease_changes.count([TAKEN]);
                self.fleets.insert(fleet, Fleet::start(lease, &self.shared));
            }
        }
        for lease in membership.leases.iter().filter(|lease| !self.fleets.contains_key(&lease.fleet)) {
            let holder = lease.holder.clone().filter(|_| !lease.free);
            self.shared.readiness.stands(&lease.fleet, Standing::Standby { holder });
        }
        let soonest = membership
            .leases
            .iter()
            .filter(|lease| !self.fleets.contains_key(&lease.fleet))
            .filter_map(|lease| lease.free_in)
            .min();
        Ok(soonest.map_or(self.pause(), |soonest| soonest.clamp(SHORTEST_PAUSE, self.pause())))
    }

    /// Removes fleets whose supervision has ended on its own, and collects the stopped ones.
    fn remove_ended(&mut self) {
        let over: Vec<Name> =
            self.fleets.iter().filter(|(_, fleet)| fleet.is_over()).map(|(name, _)| name.clone()).collect();
        for name in over {
            self.end(&name);
        }
        while let Some(ended) = self.ending.try_join_next() {
            if let Err(problem) = ended {
                error!(%problem, "fleet task failed");
            }
        }
        self.ending_names.retain(|_, task| !task.is_finished());
    }

    /// Stops fleets that another supervisor owns by now. Fencing already keeps them from writing.
    fn drop_lost(&mut self, membership: &Membership) {
        let is_ours = |fleet: &Fleet| {
            membership.leases.iter().any(|row| {
                row.fleet == *fleet.lease().fleet()
                    && row.epoch == fleet.lease().epoch()
                    && row.owner.as_deref() == Some(&*self.supervisor.id)
            })
        };
        let lost: Vec<Name> =
            self.fleets.iter().filter(|(_, fleet)| !is_ours(fleet)).map(|(name, _)| name.clone()).collect();
        for name in lost {
            warn!(fleet = %name, "fleet lease lost to another supervisor");
            self.end(&name);
        }
    }

    /// Stops the supervision of a fleet and releases its lease, if this supervisor still owns it. This runs in the
    /// background, because the other leases must be renewed meanwhile.
    fn end(&mut self, name: &Name) {
        let Some(fleet) = self.fleets.remove(name) else { return };
        let metrics = self.shared.metrics.of_fleet(name);
        metrics.lease_held.set(0);
        metrics.lease_changes.count([LOST]);
        let mut writer = self.shared.store.writer();
        let task = self.ending.spawn(async move {
            let lease = fleet.stop().await;
            if let Err(problem) = writer.release(&lease).await {
                warn!(%problem, "cannot release the lease, it will expire");
            }
        });
        self.ending_names.insert(name.clone(), task);
    }

    /// Stops all fleets, then signs out, so that other supervisors can acquire them.
    async fn leave(mut self) {
        let names: Vec<Name> = self.fleets.keys().cloned().collect();
        for name in names {
            self.end(&name);
        }
        while let Some(ended) = self.ending.join_next().await {
            if let Err(problem) = ended {
                error!(%problem, "fleet task failed");
            }
        }
        if let Err(problem) = self.writer.sign_out(&self.supervisor).await {
            warn!(%problem, "cannot sign out");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regress_an_outage_is_logged_at_its_begin_and_at_its_end() {
        let problem = StoreError::NoAnswer { what: "keep the leases", patience: Duration::from_secs(2) };
        let mut outage = Outage::default();
        assert!(!outage.note(None), "no outage before the first failure");
        for _ in 0..2 {
            let logged = (0..100).filter(|_| outage.note(Some(&problem))).count();
            assert_eq!(logged, 1);
            assert!(outage.note(None) && !outage.note(None));
        }
    }
}
