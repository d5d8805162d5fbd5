//! Members, leases and epochs.

use vibrissa_protocol::Name;
use vibrissa_store::model::Leases;
use vibrissa_store::{
    ClockReport, FleetsHeard, Lease, LeaseCounts, LeaseRow, MemberRow, Renewal, SignedIn, Supervisor,
};

use super::ModelStore;

/// Time after which a supervisor that has not signed out is forgotten, µs.
const FORGOTTEN_US: i64 = 86_400_000_000;

/// An owner of a fleet in its epoch.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Epoch {
    /// Identifier of the owner.
    pub owner: String,
    /// Name of the owner.
    pub holder: String,
    /// Begin, µs since 1970 UTC by the database's clock.
    pub began_us: i64,
}

impl ModelStore {
    fn lease_of(&self, lease: &Lease) -> Option<&LeaseRow> {
        let row = self.leases.get(&lease.fleet().to_string())?;
        let is_it = row.renewal.epoch == lease.epoch() as i64 && row.owner.as_deref() == Some(lease.owner());
        is_it.then_some(row)
    }
}

impl Leases for ModelStore {
    fn sign_in(
        &mut self,
        supervisor: &Supervisor,
        held: &[Lease],
        hearing: &FleetsHeard,
        clock: ClockReport,
    ) -> SignedIn {
        let database_us = self.clock_us;
        let member = MemberRow::new(supervisor, hearing, clock, database_us);
        let expires_us = member.alive_us;
        self.members.set(supervisor.id.to_string(), member);
        let mut renewed = Vec::new();
        for lease in held.iter().filter(|lease| lease.owner() == &*supervisor.id) {
            if self.lease_of(lease).is_some() {
                self.leases.change(&lease.fleet().to_string(), |row| row.renewal.expires_us = expires_us);
                renewed.push(lease.fleet().to_string());
            }
        }
        let mut leases = Vec::new();
        for fleet in supervisor.fleets.iter().map(Name::to_string) {
            if !self.leases.has(&fleet) {
                let renewal = Renewal { epoch: 0, commits: 0, expires_us: 0 };
                self.leases.set(fleet.clone(), LeaseRow { fleet: fleet.clone(), owner: None, holder: None, renewal });
            }
            leases.extend(self.leases.get(&fleet).cloned());
        }
        let members = self.members.iter().map(|(_, row)| row).filter(|row| row.alive_us > database_us);
        SignedIn { leases, members: members.cloned().collect(), database_us, renewed }
    }

    fn acquire(
        &mut self,
        supervisor: &Supervisor,
        fleet: &Name,
        [known, step]: [u64; 2],
        seen: Option<Renewal>,
    ) -> Option<i64> {
        let now_us = self.clock_us;
        for gone in self.members.keys_of(|_, row| row.alive_us < now_us - FORGOTTEN_US) {
            self.members.remove(&gone);
        }
        let (fleet, owner) = (fleet.to_string(), supervisor.id.to_string());
        let row = self.leases.get(&fleet)?;
        let is_free = seen.map_or(row.renewal.expires_us <= now_us, |seen| row.renewal == seen);
        if !is_free && row.owner.as_ref() != Some(&owner) {
            return None;
        }
        let epoch = (row.renewal.epoch.max(known as i64) + step as i64).max(now_us / 1000);
        let expires_us = now_us + supervisor.time_to_live.as_micros() as i64;
        let (holder, renewal) = (supervisor.name.clone(), Renewal { epoch, commits: 0, expires_us });
        self.epochs
            .set((fleet.clone(), epoch), Epoch { owner: owner.clone(), holder: holder.clone(), began_us: now_us });
        let row = LeaseRow { fleet: fleet.clone(), owner: Some(owner), holder: Some(holder), renewal };
        self.leases.set(fleet.clone(), row);
        self.numbers.remove(&fleet);
        Some(epoch)
    }

    fn release(&mut self, lease: &Lease) {
        if self.lease_of(lease).is_some() {
            self.leases.change(&lease.fleet().to_string(), |row| {
                row.owner = None;
                row.renewal.expires_us = 0;
            });
        }
    }

    fn sign_out(&mut self, supervisor: &Supervisor) {
        self.members.remove(&supervisor.id.to_string());
    }

    fn counts(&self, lease: &Lease) -> Option<LeaseCounts> {
        let commits = self.lease_of(lease)?.renewal.commits;
        let numbers = self.numbers.get(&lease.fleet().to_string()).copied().unwrap_or_default();
        Some(LeaseCounts { commits, numbers })
    }

    fn count_commit(&mut self, lease: &Lease, known: LeaseCounts) -> bool {
        let is_known = |row: LeaseCounts| row.commits == known.commits && row.numbers >= known.numbers;
        let is_next = self.counts(lease).is_some_and(is_known);
        if is_next {
            let expires_us = self.clock_us + lease.time_to_live().as_micros() as i64;
            self.leases.change(&lease.fleet().to_string(), |row| {
                row.renewal.commits += 1;
                row.renewal.expires_us = expires_us;
            });
        }
        is_next
    }

    fn count_numbers(&mut self, lease: &Lease, least: i64) -> Option<i64> {
        let numbers = self.counts(lease)?.numbers;
        (numbers >= least).then(|| self.numbers.set(lease.fleet().to_string(), numbers + 1))?;
        Some(numbers + 1)
    }

    fn has_epoch_until(&self, fleet: &Name, epoch: u64) -> bool {
        let (first, last) = ((fleet.to_string(), i64::MIN), (fleet.to_string(), epoch as i64));
        self.epochs.range(first..=last).next().is_some()
    }
}
