//! Which fleets this supervisor has: keeps its leases, takes its share, gives back what is too much.

use std::collections::BTreeMap;

use tokio::sync::watch;
use tokio::task::{AbortHandle, JoinSet};
use tokio::time::{Duration, Instant, sleep};
use tracing::{error, info, warn};
use vibrissa_protocol::Name;

use crate::ears::Ears;
use crate::fleet::{Fleet, Shared};
use crate::metrics::{LOST, TAKEN};
use crate::mqtt::stopped;
use crate::readiness::Standing;
use crate::sharing::shares;
use vibrissa_store::{Roll, StoreError, Supervisor, Writer};

/// Turns in a time to live: each renews the leases and looks for free ones.
const TURNS_A_TIME_TO_LIVE: u32 = 8;

/// From one turn to the next at least: an owner may be renewing at this moment.
const SHORTEST_PAUSE: Duration = Duration::from_millis(20);

/// The part of readiness that is kept here.
const PART: &str = "ownership";

/// The keeper of the leases.
pub(crate) struct Ownership {
    supervisor: Supervisor,
    shared: Shared,
    writer: Writer,
    fleets: BTreeMap<Name, Fleet>,
    /// Fleets that are ending, which must be over before they can be taken again.
    ending: JoinSet<()>,
    ending_names: BTreeMap<Name, AbortHandle>,
    is_prepared: bool,
    ears: Ears,
    outage: Outage,
}

/// A time in which leases cannot be renewed. The log has its begin and its end, and nothing in between.
#[derive(Debug, Default)]
struct Outage(Option<Instant>);

impl Outage {
    /// Notes how an attempt went; true if that is news, which is logged.
    fn note(&mut self, problem: Option<&StoreError>) -> bool {
        match (problem, self.0) {
            (Some(problem), None) => {
                self.0 = Some(Instant::now());
                warn!(%problem, "cannot keep the leases; trying again until it works");
            }
            (None, Some(since)) => {
                self.0 = None;
                info!(seconds = since.elapsed().as_secs_f32(), "the leases can be kept again");
            }
            (Some(_), Some(_)) | (None, None) => return false,
        }
        true
    }
}

impl Ownership {
    /// Nothing is owned yet. The database counts as prepared if its tables are up to date.
    pub(crate) fn new(supervisor: Supervisor, shared: Shared, is_prepared: bool) -> Self {
        shared.readiness.set(PART, Some("starting: not known yet whose the fleets are".to_owned()));
        let writer = shared.store.writer();
        Self {
            supervisor,
            shared,
            writer,
            fleets: BTreeMap::new(),
            ending: JoinSet::new(),
            ending_names: BTreeMap::new(),
            is_prepared,
            ears: Ears::default(),
            outage: Outage::default(),
        }
    }

    /// Keeps at it until told to stop, then gives everything back.
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
        // What is not shared has no lease to keep, and nobody to give way to.
        let turns = if self.shared.store.is_shared() { TURNS_A_TIME_TO_LIVE } else { 1 };
        self.supervisor.time_to_live / turns
    }

    /// One turn: renew, look, give back, take. Tells when the next one is due: at the latest when a lease of
    /// somebody else's expires unless it is renewed.
    async fn turn(&mut self) -> Result<Duration, StoreError> {
        if !self.is_prepared {
            self.shared.store.prepare().await?;
            self.is_prepared = true;
        }
        self.bury();
        let held: Vec<_> = self.fleets.values().map(|fleet| fleet.lease().clone()).collect();
        if self.shared.store.is_shared() {
            let links = self.fleets.iter().map(|(name, fleet)| (name, fleet.link()));
            self.ears.listen(links, &self.shared);
        }
        let roll = self.writer.sign_in_hearing(&self.supervisor, &held, &self.ears.told()).await?;
        self.drop_lost(&roll);
        if self.shared.store.is_shared() {
            self.ears.try_doubtful(&roll, &self.supervisor.id, &self.shared);
        }
        let shares = shares(&roll);
        let mine = |fleet: &Name| shares.get(fleet).is_some_and(|owner| **owner == *self.supervisor.id);
        let too_many: Vec<Name> = self.fleets.keys().filter(|fleet| !mine(fleet)).cloned().collect();
        let missing: Vec<Name> = roll
            .leases
            .iter()
            .filter(|lease| mine(&lease.fleet))
            .filter(|lease| !self.fleets.contains_key(&lease.fleet) && !self.ending_names.contains_key(&lease.fleet))
            .map(|lease| lease.fleet.clone())
            .collect();
        for fleet in too_many {
            info!(%fleet, "handing over");
            self.end(&fleet);
        }
        for fleet in missing {
            if let Some(lease) = self.writer.acquire(&self.supervisor, &fleet).await? {
                info!(%fleet, epoch = lease.epoch(), "taken");
                let metrics = self.shared.metrics.of_fleet(&fleet);
                metrics.lease_held.set(1);
                metrics.lease_epoch.set(lease.epoch() as i64);
                metrics.lease_changes.count([TAKEN]);
                self.fleets.insert(fleet, Fleet::start(lease, &self.shared));
            }
        }
        for lease in roll.leases.iter().filter(|lease| !self.fleets.contains_key(&lease.fleet)) {
            let holder = lease.holder.clone().filter(|_| !lease.free);
            self.shared.readiness.stands(&lease.fleet, Standing::Standby { holder });
        }
        let soonest = roll
            .leases
            .iter()
            .filter(|lease| !self.fleets.contains_key(&lease.fleet))
            .filter_map(|lease| lease.free_in)
            .min();
        Ok(soonest.map_or(self.pause(), |soonest| soonest.clamp(SHORTEST_PAUSE, self.pause())))
    }

    /// Fleets whose supervision has ended by itself, and those whose end is through.
    fn bury(&mut self) {
        let over: Vec<Name> =
            self.fleets.iter().filter(|(_, fleet)| fleet.is_over()).map(|(name, _)| name.clone()).collect();
        for name in over {
            self.end(&name);
        }
        while let Some(ended) = self.ending.try_join_next() {
            if let Err(problem) = ended {
                error!(%problem, "a fleet ended abnormally");
            }
        }
        self.ending_names.retain(|_, task| !task.is_finished());
    }

    /// Fleets that somebody else has by now: it would be a fault to go on, even without writing.
    fn drop_lost(&mut self, roll: &Roll) {
        let is_ours = |fleet: &Fleet| {
            roll.leases.iter().any(|row| {
                row.fleet == *fleet.lease().fleet()
                    && row.epoch == fleet.lease().epoch()
                    && row.owner.as_deref() == Some(&*self.supervisor.id)
            })
        };
        let lost: Vec<Name> =
            self.fleets.iter().filter(|(_, fleet)| !is_ours(fleet)).map(|(name, _)| name.clone()).collect();
        for name in lost {
            warn!(fleet = %name, "its lease was taken over");
            self.end(&name);
        }
    }

    /// Ends the supervision of a fleet and gives its lease back, if it is still ours; in the background, because
    /// the leases of the others must be kept meanwhile.
    fn end(&mut self, name: &Name) {
        let Some(fleet) = self.fleets.remove(name) else { return };
        let metrics = self.shared.metrics.of_fleet(name);
        metrics.lease_held.set(0);
        metrics.lease_changes.count([LOST]);
        let mut writer = self.shared.store.writer();
        let task = self.ending.spawn(async move {
            let lease = fleet.stop().await;
            if let Err(problem) = writer.release(&lease).await {
                warn!(%problem, "not given back: its lease expires by itself");
            }
        });
        self.ending_names.insert(name.clone(), task);
    }

    /// Ends everything at once, and says that it can be had.
    async fn leave(mut self) {
        let names: Vec<Name> = self.fleets.keys().cloned().collect();
        for name in names {
            self.end(&name);
        }
        while let Some(ended) = self.ending.join_next().await {
            if let Err(problem) = ended {
                error!(%problem, "a fleet ended abnormally");
            }
        }
        if let Err(problem) = self.writer.sign_out(&self.supervisor).await {
            warn!(%problem, "not signed out");
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
        assert!(!outage.note(None), "nothing was wrong");
        for _ in 0..2 {
            let logged = (0..100).filter(|_| outage.note(Some(&problem))).count();
            assert_eq!(logged, 1);
            assert!(outage.note(None) && !outage.note(None));
        }
    }
}
