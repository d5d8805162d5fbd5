//! Leases of three supervisors: the model and PostgreSQL, with the same clock, which is stepped by chance.

use std::sync::Arc;
use std::time::Duration;

use rand::seq::IndexedRandom;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use vibrissa_protocol::Name;
use vibrissa_simulation::store::AtHand;
use vibrissa_store::batch::EventRow;
use vibrissa_store::{Batch, ClockReport, FleetsHeard, Lease, Membership, Store, Supervisor, Writer};

use super::subject::Behind;
use super::text;
use crate::Fresh;

const RUNS: u64 = 8;
const STEPS: u64 = 120;
/// No lease falls silent for so long while the test runs.
const TIME_TO_LIVE_S: i64 = 600;

/// A database with three supervisors.
struct Cluster {
    store: Store,
    behind: Behind,
    fleets: Vec<Name>,
    writers: Vec<Writer>,
    /// Each with the place of its supervisor; some are lost.
    leases: Vec<(usize, Lease)>,
    /// The epochs in the order of their begins, each with its fleet.
    epochs: Vec<(Name, u64)>,
    clock_us: i64,
}

impl Cluster {
    fn new(store: &Store, behind: Behind, seed: u64) -> Self {
        let fleets = ["x", "y"].map(|name| Name::new(&format!("{name}{seed}")).unwrap()).to_vec();
        let writers = (0..3).map(|_| store.writer()).collect();
        Self {
            store: store.clone(),
            behind,
            fleets,
            writers,
            leases: Vec::new(),
            epochs: Vec::new(),
            clock_us: 1_795_248_000_000_000,
        }
    }

    fn supervisor(&self, at: usize) -> Supervisor {
        let id = format!("{}-{at}", self.fleets[0]);
        let (name, time_to_live) = (format!("supervisor {id}"), Duration::from_secs(TIME_TO_LIVE_S as u64));
        Supervisor { id: id.into(), name, fleets: self.fleets.clone(), time_to_live }
    }

    async fn set_clock(&mut self, clock_us: i64) {
        self.clock_us = clock_us;
        match &mut self.behind {
            Behind::Model(at_hand) => at_hand.stop_clock(clock_us),
            Behind::Database(admin) => {
                let sql = "CREATE OR REPLACE FUNCTION clock_us() RETURNS BIGINT LANGUAGE SQL VOLATILE AS";
                admin.execute(format!("{sql} 'SELECT {clock_us}::BIGINT'")).await;
            }
        }
    }

    /// An epoch's place in the order of their begins: its value has a random part. `None` if it is not known, as that of a fleet
    /// without one.
    fn number(&self, fleet: &Name, epoch: u64) -> Option<usize> {
        self.epochs.iter().position(|(of, one)| of == fleet && *one == epoch)
    }

    /// Without the times by this process's clock, and in an order of its own.
    fn told(&self, mut membership: Membership) -> String {
        let mut leases: Vec<_> = (membership.leases.into_iter())
            .map(|one| {
                let epoch = self.number(&one.fleet, one.epoch);
                (one.fleet, epoch, one.owner, one.holder, one.free, one.free_in.is_some())
            })
            .collect();
        leases.sort();
        membership.present.sort_by(|one, other| one.supervisor.cmp(&other.supervisor));
        // Members of other runs are the same everywhere.
        format!("{leases:?} {:?}", membership.present)
    }

    /// Does a step, and tells about it.
    async fn step(&mut self, random: &mut ChaCha8Rng) -> String {
        let at = random.random_range(0..3);
        let own = self.supervisor(at);
        let fleet = self.fleets.choose(random).unwrap().clone();
        match random.random_range(0..12) {
            0..3 => {
                let some: Vec<Lease> =
                    self.leases.iter().filter(|(of, _)| *of == at).map(|(_, one)| one.clone()).collect();
                let deaf = if random.random_bool(0.3) { vec![fleet] } else { Vec::new() };
                let heard = FleetsHeard { deaf, heard: Vec::new() };
                let clock = ClockReport { ahead_us: Some(random.random_range(-5..5)), ..ClockReport::default() };
                let membership = self.writers[at].sign_in_reporting(&own, &some, &heard, clock).await;
                format!("sign {at} in: {}", self.told(membership.unwrap()))
            }
            3..6 => {
                let fleets = if random.random_bool(0.5) { self.fleets.clone() } else { vec![fleet] };
                let taken = self.writers[at].acquire_several(&own, &fleets).await.unwrap();
                self.epochs.extend(taken.iter().map(|lease| (lease.fleet().clone(), lease.epoch())));
                let epochs: Vec<_> =
                    taken.iter().map(|lease| (lease.fleet(), self.number(lease.fleet(), lease.epoch()))).collect();
                let told = format!("{at} acquires {fleets:?}: {epochs:?}");
                self.leases.extend(taken.into_iter().map(|lease| (at, lease)));
                told
            }
            6 => match self.leases.choose(random).cloned() {
                Some((of, lease)) => format!("{of} releases: {}", text(self.writers[of].release(&lease).await)),
                None => "nothing to release".to_owned(),
            },
            7..9 => match self.leases.choose(random).cloned() {
                Some((of, lease)) => {
                    let event = EventRow::new(vibrissa_edge::events::EventKind::Policy, self.clock_us);
                    let batch = Batch { events: vec![event], ..Batch::default() };
                    let written = text(self.writers[of].commit(&lease, &batch).await);
                    let registered = self.writers[of].register(&lease, ("r", "b"), 1).await.map(|one| one.is_some());
                    let epoch = self.number(lease.fleet(), lease.epoch());
                    format!("{of} writes in epoch {epoch:?}: {written} {}", text(registered))
                }
                None => "nothing to write".to_owned(),
            },
            9 => {
                // As after a restart: it knows no rows and no epochs.
                self.writers[at] = self.store.writer();
                format!("{at} begins anew")
            }
            10 => {
                let signed_out =
                    if random.random_bool(0.3) { text(self.writers[at].sign_out(&own).await) } else { String::new() };
                let mut known = Vec::new();
                for (_, lease) in self.leases.iter().take(3) {
                    known.push(self.store.has_epoch_until(&fleet, lease.epoch()).await.unwrap());
                }
                format!("sign {at} out: {signed_out} {known:?}")
            }
            _ => {
                let step_s = *[-100, 1, TIME_TO_LIVE_S / 2, TIME_TO_LIVE_S + 1, 90_000].choose(random).unwrap();
                self.set_clock(self.clock_us + step_s * 1_000_000).await;
                format!("step the clock by {step_s} s")
            }
        }
    }
}

#[tokio::test]
async fn property_leases_of_the_model_are_those_of_postgres() {
    let (server, at_hand) = (Fresh::postgres().await, Arc::new(AtHand::default()));
    let modelled = Store::modelled(at_hand.clone());
    for seed in 0..RUNS {
        let mut model = Cluster::new(&modelled, Behind::Model(at_hand.clone()), seed);
        let mut other = Cluster::new(&server.store, Behind::of(&server).await, seed);
        for cluster in [&mut model, &mut other] {
            cluster.set_clock(cluster.clock_us + seed as i64 * 1_000_000_000_000).await;
        }
        for step in 0..STEPS {
            let random = || ChaCha8Rng::seed_from_u64(seed << 32 | step);
            let expected = model.step(&mut random()).await;
            let answer = other.step(&mut random()).await;
            assert_eq!(answer, expected, "PostgreSQL (left) and the model differ: seed {seed}, step {step}");
        }
        let epochs = model.leases.len();
        assert!(epochs > 10, "{epochs} epochs");
    }
}
