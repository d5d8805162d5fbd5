//! Ownership of fleets and their shards: renews this supervisor's leases, acquires its share, releases the surplus, and
//! begins changes of the number of shards.

use std::collections::BTreeMap;

use tokio::sync::watch;
use tokio::task::{AbortHandle, JoinSet};
use tokio::time::{Duration, Instant, sleep};
use tracing::{error, info, warn};
use vibrissa_edge::shard::FleetShard;
use vibrissa_protocol::Name;

use crate::clocks::Clocks;
use crate::division::divide;
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
const SHARDS_AT_ONCE: usize = 64;

/// Name of this part in the service's readiness.
const PART: &str = "ownership";

/// Renews, acquires and releases leases.
pub(crate) struct Ownership {
    supervisor: Supervisor,
    shared: Shared,
    writer: Writer,
    shards: BTreeMap<FleetShard, Fleet>,
    /// Shards that are being stopped. A shard must have ended before it can be acquired again.
    ending: JoinSet<()>,
    ending_shards: BTreeMap<FleetShard, AbortHandle>,
    /// Changes of the number of shards that this supervisor makes, with the leases that they need.
    divisions: BTreeMap<Name, (Vec<Lease>, AbortHandle)>,
    /// Least number of shards of each fleet, until the database has it.
    least_shards: Option<u32>,
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
    /// Owns nothing yet. Each fleet shall have at least `shards` shards. `is_prepared` says that the tables of the database
    /// are up to date.
    pub(crate) fn new(supervisor: Supervisor, shared: Shared, shards: u32, is_prepared: bool) -> Self {
        shared.readiness.set(PART, Some("starting: the owners of the fleets are not known yet".to_owned()));
        let writer = shared.store.writer();
        let clocks = Clocks::new(shared.hold_back.clone());
        Self {
            supervisor,
            shared,
            writer,
            shards: BTreeMap::new(),
            ending: JoinSet::new(),
            ending_shards: BTreeMap::new(),
            divisions: BTreeMap::new(),
            least_shards: Some(shards).filter(|&shards| shards > 1),
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
            self.shared.readiness.set(PART, turn.err().map(|problem| problem.told()));
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
        if let Some(shards) = self.least_shards {
            for fleet in &self.supervisor.fleets {
                self.writer.want_shards(fleet, shards).await?;
            }
            self.least_shards = None;
        }
        self.remove_ended();
        let is_idle = self.shards.is_empty() && self.ending_shards.is_empty() && self.divisions.is_empty();
        if is_idle && self.clocks.must_follow_host() {
            self.clocks.follow_host();
        }
        let of_divisions = self.divisions.values().flat_map(|(leases, _)| leases);
        let held: Vec<_> = self.shards.values().map(Fleet::lease).chain(of_divisions).cloned().collect();
        if self.shared.store.is_shared() {
            let links = self.shards.iter().map(|(shard, fleet)| (shard, fleet.link()));
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
        let mine = |shard: &FleetShard| shares.get(shard).is_some_and(|owner| **owner == *self.supervisor.id);
        let dividing: BTreeMap<Name, u32> = membership
            .leases
            .iter()
            .filter(|lease| lease.shards_wanted != lease.shard.count())
            .map(|lease| (lease.shard.fleet().clone(), lease.shards_wanted))
            .collect();
        let is_dividing = |shard: &FleetShard| dividing.contains_key(shard.fleet());
        let too_many: Vec<FleetShard> =
            self.shards.keys().filter(|shard| !mine(shard) || is_dividing(shard)).cloned().collect();
        let missing: Vec<FleetShard> = membership
            .leases
            .iter()
            .map(|lease| &lease.shard)
            .filter(|shard| mine(shard) && !is_dividing(shard))
            .filter(|shard| !self.shards.contains_key(*shard) && !self.ending_shards.contains_key(*shard))
            .cloned()
            .collect();
        let divided_here: Vec<(&Name, u32)> = dividing
            .iter()
            .filter(|(fleet, _)| membership.leases.iter().any(|one| one.shard.fleet() == *fleet && mine(&one.shard)))
            .map(|(fleet, count)| (fleet, *count))
            .collect();
        for shard in too_many {
            match is_dividing(&shard) {
                true => info!(fleet = %shard, "releasing fleet to change its number of shards"),
                false => info!(fleet = %shard, "releasing fleet to rebalance"),
            }
            self.end(&shard);
        }
        for some in missing.chunks(SHARDS_AT_ONCE) {
            for lease in self.writer.acquire_shards(&self.supervisor, some).await? {
                self.begin(lease);
            }
        }
        for (fleet, count) in divided_here {
            self.begin_division(fleet, count, &membership).await?;
        }
        self.show(&membership);
        let soonest = membership
            .leases
            .iter()
            .filter(|lease| !self.shards.contains_key(&lease.shard))
            .filter_map(|lease| lease.free_in)
            .min();
        Ok(soonest.map_or(self.pause(), |soonest| soonest.clamp(SHORTEST_PAUSE, self.pause())))
    }

    /// Ends the supervision of all shards, because their times do not fit a new time line. They begin anew as after a
    /// takeover. Returns the time until the next turn.
    fn end_all(&mut self) -> Duration {
        for shard in self.shards.keys().cloned().collect::<Vec<_>>() {
            info!(fleet = %shard, "releasing fleet to follow a step of the host's clock");
            self.end(&shard);
        }
        STEP_PAUSE
    }

    /// Starts the supervision of a shard.
    fn begin(&mut self, lease: Lease) {
        let shard = lease.shard().clone();
        info!(fleet = %shard, epoch = lease.epoch(), "fleet lease acquired");
        let metrics = self.shared.metrics.of_shard(&shard);
        metrics.lease_held.set(1);
        metrics.lease_epoch.set(lease.epoch() as i64);
        metrics.lease_changes.count([TAKEN]);
        self.shards.insert(shard, Fleet::start(lease, &self.shared));
    }

    /// Acquires all shards of a fleet, and changes their number in the background. Does nothing while a shard has an
    /// owner.
    async fn begin_division(&mut self, fleet: &Name, count: u32, membership: &Membership) -> Result<(), StoreError> {
        let leases: Vec<_> = membership.leases.iter().filter(|lease| lease.shard.fleet() == fleet).collect();
        let is_ending = self.ending_shards.keys().any(|shard| shard.fleet() == fleet);
        if is_ending || self.divisions.contains_key(fleet) || !leases.iter().all(|lease| lease.free) {
            return Ok(());
        }
        let all: Vec<FleetShard> = leases.iter().map(|lease| lease.shard.clone()).collect();
        let held = self.writer.acquire_shards(&self.supervisor, &all).await?;
        if held.len() < leases.len() {
            // Another supervisor is faster.
            for lease in &held {
                self.writer.release(lease).await?;
            }
            return Ok(());
        }
        info!(%fleet, before = leases.len(), shards = count, "changing the number of shards");
        let task = self.ending.spawn(divide(held.clone(), count, self.shared.clone()));
        self.divisions.insert(fleet.clone(), (held, task));
        Ok(())
    }

    /// Shows this supervisor's role in each shard.
    fn show(&self, membership: &Membership) {
        // The metrics of a fleet are hundreds of series to look up.
        let counts: BTreeMap<&Name, u32> =
            membership.leases.iter().map(|lease| (lease.shard.fleet(), lease.shard.count())).collect();
        for (fleet, count) in counts {
            self.shared.metrics.of_fleet(fleet).fleet_shards.set(i64::from(count));
        }
        for lease in &membership.leases {
            if !self.shards.contains_key(&lease.shard) {
                let holder = lease.holder.clone().filter(|_| !lease.free);
                self.shared.readiness.stands(&lease.shard, Standing::Standby { holder });
            }
        }
        self.shared.readiness.retain(|shard| membership.leases.iter().any(|lease| lease.shard == *shard));
    }

    /// Removes shards whose supervision has ended on its own, and collects the stopped ones.
    fn remove_ended(&mut self) {
        let over: Vec<FleetShard> =
            self.shards.iter().filter(|(_, fleet)| fleet.is_over()).map(|(shard, _)| shard.clone()).collect();
        for shard in over {
            self.end(&shard);
        }
        while let Some(ended) = self.ending.try_join_next() {
            if let Err(problem) = ended {
                error!(%problem, "fleet task failed");
            }
        }
        self.ending_shards.retain(|_, task| !task.is_finished());
        self.divisions.retain(|_, (_, task)| !task.is_finished());
    }

    /// Stops shards that another supervisor owns by now. Fencing already keeps them from writing.
    fn drop_lost(&mut self, membership: &Membership) {
        let is_ours = |fleet: &Fleet| {
            membership.leases.iter().any(|row| {
                row.shard == *fleet.lease().shard()
                    && row.epoch == fleet.lease().epoch()
                    && row.owner.as_deref() == Some(&*self.supervisor.id)
            })
        };
        let lost: Vec<FleetShard> =
            self.shards.iter().filter(|(_, fleet)| !is_ours(fleet)).map(|(shard, _)| shard.clone()).collect();
        for shard in lost {
            warn!(fleet = %shard, "fleet lease lost to another supervisor");
            self.end(&shard);
        }
    }

    /// Stops the supervision of a shard and releases its lease, if this supervisor still owns it. This runs in the
    /// background, because the other leases must be renewed meanwhile.
    fn end(&mut self, shard: &FleetShard) {
        let Some(fleet) = self.shards.remove(shard) else { return };
        let metrics = self.shared.metrics.of_shard(shard);
        metrics.lease_held.set(0);
        metrics.lease_changes.count([LOST]);
        let mut writer = self.shared.store.writer();
        let task = self.ending.spawn(async move {
            let lease = fleet.stop().await;
            if let Err(problem) = writer.release(&lease).await {
                warn!(%problem, "cannot release the lease, it will expire");
            }
        });
        self.ending_shards.insert(shard.clone(), task);
    }

    /// Stops all shards, then signs out, so that other supervisors can acquire them.
    async fn leave(mut self) {
        for shard in self.shards.keys().cloned().collect::<Vec<_>>() {
            self.end(&shard);
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
