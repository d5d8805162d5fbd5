//! Faults of several parts at the same time: the broker, each supervisor, the databases with etcd, and Kafka are struck
//! again and again, whether or not the other parts work. Within a part, one fault follows the other.
//!
//! Far more faults fit into an hour than one at a time, and a fault meets the recovery from others. In return no time of
//! recovery belongs to one fault. After each round of faults the run waits until everything works again.

use std::ops::Range;
use std::time::{Duration, Instant};

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tokio::time::sleep;

use super::parts::{Brokers, Database, KafkaBrokers, Supervisor};
use super::plan::{Deed, Fault, SUPERVISORS_COUNT, Victim};
use super::stage::{Parts, SUPERVISORS, Stage};
use super::strike::{Striker, Struck, Surprises};
use super::watch::Watch;
use super::{NODES_PATIENCE, PATIENCE, PAUSE, probe};

/// Length in seconds of a short fault: nothing takes over.
const SHORT_S: Range<f64> = 0.3..1.5;
/// Length of a long fault of a supervisor: its lease of 2 s ends, and others take over.
const SUPERVISOR_S: Range<f64> = 2.0..5.0;
const BROKER_S: Range<f64> = 1.5..4.0;
/// The other server leads after some 5 to 8 s.
const LEADER_S: Range<f64> = 1.5..9.0;
const STANDBY_AND_ETCD_S: Range<f64> = 1.5..3.0;
/// Another broker leads the partitions after some 3 to 5 s.
const KAFKA_S: Range<f64> = 1.5..6.0;
/// Pauses between two faults of a part. Robots connect again after pauses of up to 10 s.
const SUPERVISOR_PAUSE_S: Range<f64> = 0.2..1.0;
const BROKER_PAUSE_S: Range<f64> = 1.0..5.0;
const DATABASE_PAUSE_S: Range<f64> = 0.2..1.0;
const KAFKA_PAUSE_S: Range<f64> = 1.0..3.0;

/// Length of a round.
const ROUND: Duration = Duration::from_secs(60);
/// Time limit until everything works again after a round. A robot without receipts for a minute repeats its messages every 30 s.
const ROUND_PATIENCE: Duration = Duration::from_secs(180);

/// The faults of a run, and unintended events.
#[derive(Debug, Default)]
pub struct Happened {
    /// The faults by their time.
    pub struck: Vec<Struck>,
    pub surprises: Surprises,
    /// If faults overlap: times in seconds from the end of a round until every robot had a receipt for a message made after
    /// it; `None` if that took too long.
    pub rounds: Vec<Option<f64>>,
}

/// Strikes in rounds until the end.
pub async fn strike(striker: &mut Striker<'_>, seed: u64, end: Instant) -> Happened {
    let mut all = Happened::default();
    let mut number = 0;
    while Instant::now() < end {
        number += 1;
        let round =
            round(striker.stage, striker.watch, seed.wrapping_mul(1000) + number, end.min(Instant::now() + ROUND));
        for one in round.await {
            all.struck.extend(one.struck);
            all.surprises.ended += one.surprises.ended;
            all.surprises.engines += one.surprises.engines;
        }
        let marks = striker.robots.marks();
        let begun = Instant::now();
        let is_whole = striker.until_whole().await;
        let whole_s = begun.elapsed().as_secs_f64();
        let is_heard = until(ROUND_PATIENCE, async || striker.robots.receipted_beyond(&marks) == marks.len()).await;
        let recovered_s = (is_whole && is_heard).then(|| begun.elapsed().as_secs_f64());
        eprintln!(
            "chaos: round {number}, {} faults so far: all parts work after {whole_s:.1} s, all robots are heard after {}",
            all.struck.len(),
            recovered_s.map_or_else(|| "too long".to_owned(), |seconds| format!("{seconds:.1} s"))
        );
        all.rounds.push(recovered_s);
    }
    all.struck.sort_by_key(|one| one.at);
    all
}

/// Strikes all parts until the end of a round.
async fn round(stage: &mut Stage, watch: &Watch, seed: u64, end: Instant) -> [Happened; 6] {
    let Parts { brokers, supervisors, database, kafka } = stage.parts();
    let has_kafka = kafka.is_some();
    let Ok([a, b, c]) = <[Supervisor<'_>; SUPERVISORS_COUNT]>::try_from(supervisors) else {
        unreachable!("the stage has {SUPERVISORS_COUNT} supervisors")
    };
    let lane = |number: u64| Lane {
        has_kafka,
        random: ChaCha8Rng::seed_from_u64(seed.wrapping_mul(8).wrapping_add(number)),
        end,
        happened: Happened::default(),
    };
    let (brokers, a, b, c, database, kafka) = tokio::join!(
        lane(0).of_brokers(brokers),
        lane(1).of_supervisor(a, watch),
        lane(2).of_supervisor(b, watch),
        lane(3).of_supervisor(c, watch),
        lane(4).of_database(database),
        async {
            match kafka {
                Some(kafka) => lane(5).of_kafka(kafka).await,
                None => Happened::default(),
            }
        },
    );
    [brokers, a, b, c, database, kafka]
}

/// An operator's remedies for a standby that does not follow.
#[derive(Debug, Clone, Copy)]
enum Remedy {
    Restart,
    Rebuild,
}

/// The faults of one part.
struct Lane {
    /// Contacts come from Kafka.
    has_kafka: bool,
    random: ChaCha8Rng,
    end: Instant,
    happened: Happened,
}

impl Lane {
    async fn of_brokers(mut self, mut brokers: Brokers<'_>) -> Happened {
        while let Some(deed) = self.next_deed(BROKER_PAUSE_S).await {
            self.happened.surprises.engines += brokers.nodes.revive();
            let addresses = brokers.nodes.addresses();
            let at = self.random.random_range(0..addresses.len());
            let mut struck = Struck::new(Fault { victim: Victim::Broker(at), deed });
            brokers.hit(at, deed);
            self.hold(BROKER_S).await;
            brokers.repair(at, deed);
            struck.is_repaired();
            let mut passes = until(NODES_PATIENCE, async || probe::pass(&addresses).await).await;
            if !passes {
                self.happened.surprises.engines += 1;
                brokers.restart_all();
                passes = until(PATIENCE, async || probe::pass(&addresses).await).await;
            }
            if passes {
                struck.is_whole();
            }
            self.tell(struck);
        }
        self.happened
    }

    async fn of_supervisor(mut self, mut supervisor: Supervisor<'_>, watch: &Watch) -> Happened {
        let at = supervisor.at;
        while let Some(mut deed) = self.next_deed(SUPERVISOR_PAUSE_S).await {
            if self.has_kafka && deed == Deed::Killed && self.random.random_bool(0.25) {
                deed = Deed::KilledAndSetBack;
            }
            if let Some(status) = supervisor.process.ended_already() {
                eprintln!("chaos: supervisor {} has ended unexpectedly: {status}", SUPERVISORS[at]);
                self.happened.surprises.ended += 1;
                supervisor.process.restart();
            }
            let mut struck = Struck::new(Fault { victim: Victim::Supervisor(at), deed });
            supervisor.hit(deed).await;
            self.hold(SUPERVISOR_S).await;
            supervisor.repair(deed);
            struck.is_repaired();
            if until(PATIENCE, async || !watch.owned_by(SUPERVISORS[at]).is_empty()).await {
                struck.is_whole();
            }
            self.tell(struck);
        }
        self.happened
    }

    async fn of_database(mut self, mut database: Database<'_>) -> Happened {
        while let Some(mut deed) = self.next_deed(DATABASE_PAUSE_S).await {
            let victim = [Victim::Leader, Victim::Standby, Victim::Etcd][self.random.random_range(0..3)];
            if victim == Victim::Leader && self.random.random_bool(0.25) {
                deed = Deed::SeparatedThenKilled;
            }
            let Some(leader) = self.until_redundant(&mut database).await else { continue };
            let mut struck = Struck::new(Fault { victim, deed });
            database.hit(victim, deed, leader).await;
            self.hold(if victim == Victim::Leader { LEADER_S } else { STANDBY_AND_ETCD_S }).await;
            database.repair(victim, deed, leader, struck.at.elapsed());
            struck.is_repaired();
            if self.until_redundant(&mut database).await.is_some() {
                struck.is_whole();
            }
            self.tell(struck);
        }
        self.happened
    }

    async fn of_kafka(mut self, mut brokers: KafkaBrokers<'_>) -> Happened {
        while let Some(deed) = self.next_deed(KAFKA_PAUSE_S).await {
            let at = self.random.random_range(0..brokers.nodes.count());
            let mut struck = Struck::new(Fault { victim: Victim::Kafka(at), deed });
            brokers.hit(at, deed);
            self.hold(KAFKA_S).await;
            brokers.repair(at, deed);
            struck.is_repaired();
            if until(PATIENCE, async || brokers.nodes.all_answer().await).await {
                struck.is_whole();
            }
            self.tell(struck);
        }
        self.happened
    }

    /// The server that leads once the pair is redundant. If this takes long, the standby is started again, then made anew.
    async fn until_redundant(&mut self, database: &mut Database<'_>) -> Option<usize> {
        for remedy in [None, Some(Remedy::Restart), Some(Remedy::Rebuild)] {
            if let Some(remedy) = remedy {
                eprintln!("chaos: the database is not redundant: {remedy:?} of the standby");
                self.happened.surprises.engines += 1;
            }
            match remedy {
                None => {}
                Some(Remedy::Restart) => database.restart_standby().await,
                Some(Remedy::Rebuild) => database.rebuild_standby().await,
            }
            let leader = database.until_redundant(PATIENCE / 3).await;
            if leader.is_some() {
                return leader;
            }
        }
        None
    }

    /// Draws the next fault after a pause; `None` at the end of the run.
    async fn next_deed(&mut self, pause_s: Range<f64>) -> Option<Deed> {
        let pause = Duration::from_secs_f64(self.random.random_range(pause_s));
        if Instant::now() + pause >= self.end {
            return None;
        }
        sleep(pause).await;
        Some([Deed::Killed, Deed::Frozen, Deed::CutOff][self.random.random_range(0..3)])
    }

    /// Waits for the length of a fault: half of them are short.
    async fn hold(&mut self, long_s: Range<f64>) {
        let length_s = if self.random.random_bool(0.5) { SHORT_S } else { long_s };
        sleep(Duration::from_secs_f64(self.random.random_range(length_s))).await;
    }

    fn tell(&mut self, struck: Struck) {
        let whole = struck.whole_s.map_or_else(|| "not in time".to_owned(), |seconds| format!("{seconds:.2} s"));
        eprintln!("chaos: {}: repaired {:.2} s, its part works again {whole}", struck.fault, struck.repaired_s);
        self.happened.struck.push(struck);
    }
}

/// Whether it becomes true within this time.
async fn until(patience: Duration, is_true: impl AsyncFn() -> bool) -> bool {
    let wait = async {
        while !is_true().await {
            sleep(PAUSE).await;
        }
    };
    tokio::time::timeout(patience, wait).await.is_ok()
}
