//! Injects faults into the cluster, repairs them, and waits until everything works again.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use sqlx::ConnectOptions;
use tokio::task::JoinHandle;
use tokio::time::sleep;
use vibrissa_protocol::Name;
use vibrissa_tests::oracle::robots::Robots;

use super::plan::{Deed, Fault, Hold, LONGEST, Strike, Victim};
use super::stage::{CLIENT, SUPERVISORS, Stage};
use super::watch::Watch;
use super::{NODES_PATIENCE, PATIENCE, PAUSE, probe};
use crate::forget::forget;
use crate::plan::Control;

/// A fault that has struck, with times in seconds from the hit.
#[derive(Debug, Clone)]
pub struct Struck {
    /// Kind of the fault.
    pub fault: Fault,
    /// Time of the hit.
    pub at: Instant,
    /// Time at which all the victim's fleets had another owner.
    pub owned_s: Option<f64>,
    /// Number of the victim's fleets that others took over, and the time of the last one's first commit.
    pub takeover: Option<(usize, f64)>,
    /// Time at which the engine itself worked again: a new leader of the database, or messages between the other nodes
    /// of the broker.
    pub engine_s: Option<f64>,
    /// Time of the repair.
    pub repaired_s: f64,
    /// Time at which every robot had a receipt for a message made after the hit.
    pub recovered_s: Option<f64>,
    /// Time at which all redundancy was back; if faults overlap, at which the part worked again.
    pub whole_s: Option<f64>,
}

impl Struck {
    /// A fault that strikes now.
    pub fn new(fault: Fault) -> Self {
        Self {
            fault,
            at: Instant::now(),
            owned_s: None,
            takeover: None,
            engine_s: None,
            repaired_s: 0.0,
            recovered_s: None,
            whole_s: None,
        }
    }

    /// Notes the time of the repair.
    pub fn is_repaired(&mut self) {
        self.repaired_s = self.at.elapsed().as_secs_f64();
    }

    /// Notes that all redundancy is back.
    pub fn is_whole(&mut self) {
        self.whole_s = Some(self.at.elapsed().as_secs_f64());
    }
}

/// Counts of unintended events.
#[derive(Debug, Clone, Copy, Default)]
pub struct Surprises {
    /// Supervisors that ended unexpectedly.
    pub ended: u64,
    /// Brokers that forgot nothing.
    pub stuck: u64,
    /// Nodes of engines that ended unexpectedly, or had to be started again to work.
    pub engines: u64,
}

/// Injects faults one after the other.
pub struct Striker<'a> {
    pub stage: &'a mut Stage,
    pub watch: &'a Watch,
    pub robots: &'a Robots,
    /// The robots, each with its fleet.
    pub names: &'a [(Name, Name)],
    pub control: Control,
    pub struck: Vec<Struck>,
    pub surprises: Surprises,
}

impl Striker<'_> {
    /// Injects one fault, and returns when everything works again.
    pub async fn strike(&mut self, strike: Strike) {
        self.surprises.ended += self.stage.revive();
        let Strike { fault, hold } = strike;
        let Some(leader) = self.stage.database.leader().await else { return };
        let fleets = match fault.victim {
            Victim::Supervisor(at) => self.watch.owned_by(SUPERVISORS[at]),
            Victim::Broker(_) | Victim::Leader | Victim::Standby | Victim::Etcd | Victim::Kafka(_) => BTreeMap::new(),
        };
        let marks = self.robots.marks();
        let mut struck = Struck::new(fault);
        let hit = struck.at;
        self.hit(fault, leader).await;
        let is_taken_for_good = hold == Hold::UntilTaken;
        let engine = self.engine_watch(fault, hold, leader, hit);
        let mut is_repaired = false;
        loop {
            let elapsed = hit.elapsed();
            let seconds = elapsed.as_secs_f64();
            if struck.recovered_s.is_none() && self.robots.receipted_beyond(&marks) == self.names.len() {
                struck.recovered_s = Some(seconds);
            }
            if is_taken_for_good && struck.owned_s.is_none() && self.watch.owned_again(&fleets) == fleets.len() {
                struck.owned_s = Some(seconds);
            }
            let has_fence = self.control != Control::NoFence;
            let taken = self.watch.taken(&fleets, has_fence);
            if is_taken_for_good && struck.takeover.is_none() && taken == fleets.len() {
                struck.takeover = Some((taken, seconds));
            }
            let is_due = match hold {
                Hold::For(time) => elapsed >= time,
                // Its return moves fleets again, which would hide how long the robots waited.
                Hold::UntilTaken => struck.takeover.is_some() && struck.recovered_s.is_some(),
                Hold::UntilLed => engine.as_ref().is_some_and(JoinHandle::is_finished),
                Hold::UntilRecovered => struck.recovered_s.is_some(),
            };
            if !is_repaired && (is_due || elapsed > LONGEST) {
                self.repair(fault, leader, elapsed);
                struck.is_repaired();
                is_repaired = true;
            }
            if is_repaired && struck.recovered_s.is_some() || elapsed > PATIENCE {
                break;
            }
            sleep(PAUSE).await;
        }
        struck.engine_s = match engine {
            Some(engine) if engine.is_finished() => engine.await.ok(),
            Some(engine) => {
                engine.abort();
                None
            }
            None => None,
        };
        if self.until_whole().await {
            struck.is_whole();
        }
        tell(&struck, hold);
        self.struck.push(struck);
    }

    async fn hit(&mut self, Fault { victim, deed }: Fault, leader: usize) {
        match victim {
            Victim::Broker(at) => self.stage.brokers().hit(at, deed),
            Victim::Supervisor(at) => {
                self.stage.supervisor(at).hit(deed).await;
                if deed == Deed::KilledAndForgotten {
                    self.forget_all().await;
                }
            }
            Victim::Leader | Victim::Standby | Victim::Etcd => {
                self.stage.database_part().hit(victim, deed, leader).await;
            }
            Victim::Kafka(at) => {
                if let Some(mut kafka) = self.stage.kafka_brokers() {
                    kafka.hit(at, deed);
                }
            }
        }
    }

    /// Before another supervisor takes over, so that only robots can tell it who they are.
    async fn forget_all(&mut self) {
        for (host, port) in self.stage.broker.addresses() {
            let node = (host.as_str(), port);
            // Once more on a busy machine.
            if !forget(node, CLIENT, self.names).await && !forget(node, CLIENT, self.names).await {
                eprintln!("chaos: the broker did not forget its retained messages");
                self.surprises.stuck += 1;
            }
        }
    }

    fn repair(&mut self, Fault { victim, deed }: Fault, leader: usize, length: Duration) {
        match victim {
            Victim::Broker(at) => self.stage.brokers().repair(at, deed),
            Victim::Supervisor(at) => self.stage.supervisor(at).repair(deed),
            Victim::Leader | Victim::Standby | Victim::Etcd => {
                self.stage.database_part().repair(victim, deed, leader, length);
            }
            Victim::Kafka(at) => {
                if let Some(mut kafka) = self.stage.kafka_brokers() {
                    kafka.repair(at, deed);
                }
            }
        }
    }

    /// Measures when the engine itself works again; `None` if the fault does not ask that of an engine.
    fn engine_watch(&self, fault: Fault, hold: Hold, leader: usize, hit: Instant) -> Option<JoinHandle<f64>> {
        match fault.victim {
            Victim::Leader if hold == Hold::UntilLed => {
                let other = self.stage.database.connect(1 - leader);
                Some(tokio::spawn(async move {
                    while !vibrissa_tests::patroni::accepts_writes(&other).await {
                        sleep(PAUSE).await;
                    }
                    hit.elapsed().as_secs_f64()
                }))
            }
            Victim::Broker(node) => {
                let mut nodes = self.stage.broker.addresses();
                // The only node has to come back itself.
                if nodes.len() > 1 {
                    nodes.remove(node);
                }
                Some(tokio::spawn(async move {
                    while !probe::pass(&nodes).await {
                        sleep(PAUSE).await;
                    }
                    hit.elapsed().as_secs_f64()
                }))
            }
            Victim::Leader | Victim::Supervisor(_) | Victim::Standby | Victim::Etcd | Victim::Kafka(_) => None,
        }
    }

    /// Waits until the database has so many whiskers. Returns false after [`PATIENCE`].
    pub async fn until_known(&self, whiskers: usize) -> bool {
        let count = async || {
            let leader = self.stage.database.leader().await?;
            let mut connection = self.stage.database.connect(leader).connect().await.ok()?;
            sqlx::query_scalar("SELECT count(*) FROM whiskers").fetch_one(&mut connection).await.ok()
        };
        let known = async {
            while count().await != Some(whiskers as i64) {
                sleep(PAUSE).await;
            }
        };
        tokio::time::timeout(PATIENCE, known).await.is_ok()
    }

    /// Waits until all supervisors have their share, each commit waits for a standby, messages pass between all nodes of
    /// the broker, and all brokers of Kafka answer. Returns false after [`PATIENCE`].
    pub async fn until_whole(&mut self) -> bool {
        let begun = Instant::now();
        let begun_s = vibrissa_simulator::clock::now_us() as f64 / 1e6;
        let mut nodes_again = false;
        loop {
            let is_shared = self.watch.is_shared_evenly();
            let is_replicated = is_shared && self.stage.database_part().is_redundant(begun_s).await;
            // Supervisors without a broker do not share evenly, so a late look probes the broker first.
            let is_late = begun.elapsed() > NODES_PATIENCE;
            let passes = (is_replicated || is_late) && probe::pass(&self.stage.broker.addresses()).await;
            if is_replicated && passes && self.stage.kafka_answers().await {
                return true;
            }
            self.surprises.engines += self.stage.broker.revive();
            if is_late && !passes && !nodes_again {
                nodes_again = true;
                self.surprises.engines += 1;
                self.stage.brokers().restart_all();
            }
            if begun.elapsed() > PATIENCE {
                eprintln!("chaos: not whole in time: shared evenly {is_shared}, replicated {is_replicated}");
                return false;
            }
            sleep(PAUSE).await;
        }
    }
}

fn tell(struck: &Struck, hold: Hold) {
    let seconds = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |value| format!("{value:.2}"));
    let node = match struck.fault.victim {
        Victim::Broker(at) | Victim::Supervisor(at) | Victim::Kafka(at) => format!(" {at}"),
        Victim::Leader | Victim::Standby | Victim::Etcd => String::new(),
    };
    eprintln!(
        "chaos: {}{node} ({hold:?}): owned {}, takeover {}, engine {}, repaired {:.2}, recovered {}, whole {} s",
        struck.fault,
        seconds(struck.owned_s),
        seconds(struck.takeover.map(|(_, seconds)| seconds)),
        seconds(struck.engine_s),
        struck.repaired_s,
        seconds(struck.recovered_s),
        seconds(struck.whole_s),
    );
}
