//! Ownership of fleets: renews this supervisor's leases, acquires its share, and releases the surplus.

use std::collections::BTreeMap;

use tokio::sync::watch;
use tokio::task::{AbortHandle, JoinSet};
use tokio::time::{Duration, Instant, sleep};
use tracing::{error, info, warn};
use vibrissa_host::task;
use vibrissa_protocol::Name;

use crate::clocks::Clocks;
use crate::ending::stopped;
use crate::fleet::{Fleet, Shared};
use crate::hearing_trials::HearingTrials;
use crate::metrics::{LOST, TAKEN};
use crate::readiness::Standing;
use crate::sharing::shares;
use vibrissa_store::{Lease, Membership, StoreError, Supervisor, Writer};

/// Number of turns in a lease's time to live. Each turn renews the leases and looks for free ones.
const TURNS_A_TIME_TO_LIVE: u32 = 8;

/// Shortest pause between two turns: an owner may be renewing at this moment.
const SHORTEST_PAUSE: Duration = Duration::from_millis(20);

/// Longest pause between two turns of a supervisor that shares its database with no other.
const ALONE_PAUSE: Duration = Duration::from_secs(1);

/// Pause between two turns while a step of the host's clock is followed.
const STEP_PAUSE: Duration = Duration::from_millis(50);

/// Largest number of leases that are acquired in one transaction, which locks their rows.
const FLEETS_AT_ONCE: usize = 64;

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
    ending_fleets: BTreeMap<Name, AbortHandle>,
    is_prepared: bool,
    hearing: HearingTrials,
    clocks: Clocks,
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
        let clocks = Clocks::new(shared.hold_back.clone());
        Self {
            supervisor,
            shared,
            writer,
            fleets: BTreeMap::new(),
            ending: JoinSet::new(),
            ending_fleets: BTreeMap::new(),
            is_prepared,
            hearing: HearingTrials::default(),
            clocks,
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
                Ok(_) => {
                    self.shared.metrics.database_up.set(1);
                    self.shared.readiness.database_answered();
                }
                Err(_) => self.shared.metrics.database_failed(),
            }
            self.outage.note(turn.as_ref().err());
            let pause = *turn.as_ref().unwrap_or(&self.pause());
            self.shared.readiness.set(PART, turn.err().map(|problem| problem.message()));
            tokio::select! {
                () = sleep(pause) => {}
                () = stopped(&mut stop) => break,
            }
        }
        self.leave().await;
    }

    fn pause(&self) -> Duration {
        // A database that is not shared needs no frequent renewal: there is no competitor. But clocks are read each time.
        match self.shared.store.is_shared() {
            true => self.supervisor.time_to_live / TURNS_A_TIME_TO_LIVE,
            false => self.supervisor.time_to_live.min(ALONE_PAUSE),
        }
    }

    /// One turn: renew, read the membership, release, acquire. Returns the time until the next turn, which is due at the
    /// latest when another supervisor's lease expires.
    async fn turn(&mut self) -> Result<Duration, StoreError> {
        if !self.is_prepared {
            self.shared.store.prepare().await?;
            self.is_prepared = true;
        }
        self.remove_ended();
        let is_idle = self.fleets.is_empty() && self.ending_fleets.is_empty();
        if is_idle && self.clocks.must_follow_host() {
            self.clocks.follow_host();
        }
        let held: Vec<_> = self.fleets.values().map(Fleet::lease).cloned().collect();
        if self.shared.store.is_shared() {
            let links = self.fleets.iter().map(|(name, fleet)| (name, fleet.link()));
            self.hearing.listen(links, &self.shared);
        }
        let (hearing, clock) = (self.hearing.report(), self.clocks.report());
        let membership = self.writer.sign_in_reporting(&self.supervisor, &held, &hearing, clock).await?;
        let Shared { robot_clocks, metrics, readiness, .. } = &self.shared;
        self.clocks.read(&membership, (&*self.supervisor.id, robot_clocks), (metrics, readiness));
        self.drop_lost(&membership);
        if self.clocks.must_follow_host() {
            return Ok(self.end_all());
        }
        if self.shared.store.is_shared() {
            self.hearing.try_doubtful(&membership, &self.supervisor.id, &self.shared);
        }
        let shares = shares(&membership);
        let mine = |fleet: &Name| shares.get(fleet).is_some_and(|owner| **owner == *self.supervisor.id);
        let too_many: Vec<Name> = self.fleets.keys().filter(|fleet| !mine(fleet)).cloned().collect();
        let missing: Vec<Name> = membership
            .leases
            .iter()
            .map(|lease| &lease.fleet)
            .filter(|fleet| mine(fleet))
            .filter(|fleet| !self.fleets.contains_key(*fleet) && !self.ending_fleets.contains_key(*fleet))
            .cloned()
            .collect();
        for fleet in too_many {
            info!(%fleet, "releasing fleet to rebalance");
            self.end(&fleet);
        }
        for some in missing.chunks(FLEETS_AT_ONCE) {
            for lease in self.writer.acquire_several(&self.supervisor, some).await? {
                self.begin(lease);
            }
        }
        self.show(&membership);
        let soonest = membership
            .leases
            .iter()
            .filter(|lease| !self.fleets.contains_key(&lease.fleet))
            .filter_map(|lease| lease.free_in)
            .min();
        Ok(soonest.map_or(self.pause(), |soonest| soonest.clamp(SHORTEST_PAUSE, self.pause())))
    }

    /// Ends the supervision of all fleets, because their times do not fit a new time line. They begin anew as after a
    /// takeover. Returns the time until the next turn.
    fn end_all(&mut self) -> Duration {
        for fleet in self.fleets.keys().cloned().collect::<Vec<_>>() {
            info!(%fleet, "releasing fleet to follow a step of the host's clock");
            self.end(&fleet);
        }
        STEP_PAUSE
    }

    /// Starts the supervision of a fleet.
    fn begin(&mut self, lease: Lease) {
        let fleet = lease.fleet().clone();
        info!(%fleet, epoch = lease.epoch(), "fleet lease acquired");
        let metrics = self.shared.metrics.of_fleet(&fleet);
        metrics.lease_held.set(1);
        metrics.lease_epoch.set(lease.epoch() as i64);
        metrics.lease_changes.count([TAKEN]);
        self.fleets.insert(fleet, Fleet::start(lease, &self.shared));
    }

    /// Shows this supervisor's role in each fleet.
    fn show(&self, membership: &Membership) {
        for lease in &membership.leases {
            if !self.fleets.contains_key(&lease.fleet) {
                let holder = lease.holder.clone().filter(|_| !lease.free);
                self.shared.readiness.stands(&lease.fleet, Standing::Standby { holder });
            }
        }
    }

    /// Removes fleets whose supervision has ended on its own, and collects the stopped ones.
    fn remove_ended(&mut self) {
        let over: Vec<Name> =
            self.fleets.iter().filter(|(_, fleet)| fleet.is_over()).map(|(name, _)| name.clone()).collect();
        for fleet in over {
            self.end(&fleet);
        }
        while let Some(ended) = self.ending.try_join_next() {
            if let Err(problem) = ended {
                error!(%problem, "fleet task failed");
            }
        }
        self.ending_fleets.retain(|_, task| !task.is_finished());
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
        for fleet in lost {
            warn!(%fleet, "fleet lease lost to another supervisor");
            self.end(&fleet);
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
        let task = task::spawn_in(&mut self.ending, async move {
            let lease = fleet.stop().await;
            if let Err(problem) = writer.release(&lease).await {
                warn!(%problem, "cannot release the lease, it will expire");
            }
        });
        self.ending_fleets.insert(name.clone(), task);
    }

    /// Stops all fleets, then signs out, so that other supervisors can acquire them.
    async fn leave(mut self) {
        for fleet in self.fleets.keys().cloned().collect::<Vec<_>>() {
            self.end(&fleet);
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
