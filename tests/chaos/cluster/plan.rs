//! Draws the faults of a cluster's run from a seed.

use std::fmt;
use std::time::Duration;

use rand::seq::SliceRandom;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Serialize, Serializer};

use crate::plan::{Control, LEASE_S};

/// Number of supervisors.
pub const SUPERVISORS_COUNT: usize = 3;

/// Sizes of the engines that may have more than one node, or none.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Nodes {
    /// Number of nodes of the broker.
    pub broker: usize,
    /// Number of brokers of Kafka; 0 for none.
    pub kafka: usize,
}

/// A part of the cluster that fails.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Victim {
    /// A node of the broker, by its number.
    Broker(usize),
    /// A supervisor, by its number.
    Supervisor(usize),
    /// The database node that leads when the fault strikes.
    Leader,
    /// The other database node.
    Standby,
    /// The only node of etcd.
    Etcd,
    /// A broker of Kafka, by its number.
    Kafka(usize),
}

/// What happens to it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Deed {
    /// SIGKILL to all its processes; they are started again later.
    Killed,
    /// SIGSTOP to all its processes, later SIGCONT.
    Frozen,
    /// No packet from or to it passes for a while.
    CutOff,
    /// The database leader loses its way to the standby and to etcd, but not to supervisors. Then it is killed.
    SeparatedThenKilled,
    /// A supervisor is killed, and the broker forgets all retained messages before another one takes over.
    KilledAndForgotten,
    /// A supervisor is killed, and its fleets' positions in Kafka are set back before another one takes over.
    KilledAndSetBack,
}

/// A kind of fault: victims of one role count together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Fault {
    /// The part that fails.
    pub victim: Victim,
    /// What happens to it.
    pub deed: Deed,
}

impl Fault {
    /// Every fault for every node.
    pub fn all(nodes: Nodes) -> Vec<Self> {
        let each = [Deed::Killed, Deed::Frozen, Deed::CutOff];
        let supervisors = (0..SUPERVISORS_COUNT).map(Victim::Supervisor);
        let brokers = (0..nodes.broker).map(Victim::Broker).chain((0..nodes.kafka).map(Victim::Kafka));
        let victims = brokers.chain(supervisors).chain([Victim::Leader, Victim::Standby, Victim::Etcd]);
        let mut all: Vec<Self> = victims.flat_map(|victim| each.map(|deed| Self { victim, deed })).collect();
        all.push(Self { victim: Victim::Leader, deed: Deed::SeparatedThenKilled });
        let mut of_each_supervisor =
            |deed| all.extend((0..SUPERVISORS_COUNT).map(|node| Self { victim: Victim::Supervisor(node), deed }));
        of_each_supervisor(Deed::KilledAndForgotten);
        if nodes.kafka > 0 {
            of_each_supervisor(Deed::KilledAndSetBack);
        }
        all
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let victim = match self.victim {
            Victim::Broker(_) => "broker node",
            Victim::Supervisor(_) => "supervisor",
            Victim::Leader => "database leader",
            Victim::Standby => "database standby",
            Victim::Etcd => "etcd",
            Victim::Kafka(_) => "Kafka broker",
        };
        let deed = match self.deed {
            Deed::Killed => "killed",
            Deed::Frozen => "frozen",
            Deed::CutOff => "cut off",
            Deed::SeparatedThenKilled => "separated, then killed",
            Deed::KilledAndForgotten => "killed, retained messages forgotten",
            Deed::KilledAndSetBack => "killed, positions in Kafka set back",
        };
        f.pad(&format!("{victim} {deed}"))
    }
}

impl Serialize for Fault {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// When the damage is repaired.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Hold {
    /// After this time.
    For(Duration),
    /// When other supervisors have committed for all fleets of the victim, and every robot has a new receipt.
    UntilTaken,
    /// When the other database node accepts writes.
    UntilLed,
    /// When every robot has a receipt for a message made after the fault.
    UntilRecovered,
}

/// One fault, and its end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Strike {
    /// Kind of the fault.
    pub fault: Fault,
    /// When it ends.
    pub hold: Hold,
}

/// Draws the faults one after the other, in complete rounds. The first round of a run is short: one fault for each role.
#[derive(Debug)]
pub struct Plan {
    random: ChaCha8Rng,
    control: Control,
    nodes: Nodes,
    round: Vec<Fault>,
    is_first: bool,
}

impl Plan {
    /// Begins with a seed.
    pub fn new(seed: u64, control: Control, nodes: Nodes) -> Self {
        let random = ChaCha8Rng::seed_from_u64(seed);
        Self { random, control, nodes, round: Vec::new(), is_first: true }
    }

    /// The next fault.
    pub fn next(&mut self) -> Strike {
        if self.round.is_empty() {
            self.round = self.draw_round();
            self.round.shuffle(&mut self.random);
        }
        let fault = self.round.pop().expect("a round has faults");
        Strike { fault, hold: self.hold(fault) }
    }

    fn draw_round(&mut self) -> Vec<Fault> {
        let is_first = std::mem::take(&mut self.is_first);
        let of_supervisors =
            |deed| (0..SUPERVISORS_COUNT).map(move |node| Fault { victim: Victim::Supervisor(node), deed });
        match self.control {
            Control::NoFence => of_supervisors(Deed::Frozen).collect(),
            Control::OffsetBeforeState => of_supervisors(Deed::Killed).collect(),
            Control::Asynchronous => vec![Fault { victim: Victim::Leader, deed: Deed::SeparatedThenKilled }],
            Control::None | Control::ReceiptBeforeCommit | Control::RobotIgnoresEpochs | Control::NoRobotBuffer => {
                let mut all = Fault::all(self.nodes);
                if is_first {
                    all.shuffle(&mut self.random);
                    let role = |fault: &Fault| match (fault.victim, fault.deed) {
                        (_, Deed::KilledAndForgotten) => 0,
                        (_, Deed::KilledAndSetBack) => 7,
                        (Victim::Broker(_), _) => 1,
                        (Victim::Supervisor(_), _) => 2,
                        (Victim::Leader, _) => 3,
                        (Victim::Standby, _) => 4,
                        (Victim::Etcd, _) => 5,
                        (Victim::Kafka(_), _) => 6,
                    };
                    all.sort_by_key(role);
                    all.dedup_by_key(|fault| role(fault));
                }
                all
            }
        }
    }

    /// Half of the faults that end by themselves are short, so that nothing takes over.
    fn hold(&mut self, fault: Fault) -> Hold {
        let mut seconds = |range| Hold::For(Duration::from_secs_f64(self.random.random_range(range)));
        let (short, long) = (seconds(0.3..1.5), seconds(1.5..6.0));
        let is_short = self.random.random_bool(0.5);
        match (fault.victim, fault.deed) {
            (Victim::Supervisor(_), Deed::Killed | Deed::KilledAndForgotten | Deed::KilledAndSetBack) => {
                Hold::UntilTaken
            }
            (Victim::Supervisor(_), _) if self.control == Control::None && is_short => short,
            (Victim::Supervisor(_), _) => Hold::UntilTaken,
            (Victim::Leader, Deed::Killed | Deed::SeparatedThenKilled) => Hold::UntilLed,
            (Victim::Leader, _) if is_short => short,
            (Victim::Leader, _) => Hold::UntilLed,
            (Victim::Broker(_), _) if is_short || self.nodes.broker == 1 => long,
            (Victim::Kafka(_), _) if is_short || self.nodes.kafka == 1 => long,
            (Victim::Broker(_) | Victim::Kafka(_), _) => Hold::UntilRecovered,
            (Victim::Standby | Victim::Etcd, _) => long,
        }
    }
}

/// Time for which a leader is separated before it is killed: shorter than Patroni needs to notice.
pub const SEPARATED: Duration = Duration::from_millis(1200);

/// Time after which a fault that waits for an event ends anyway.
pub const LONGEST: Duration = Duration::from_secs(45);

const _: () = assert!(LEASE_S > 1.5, "a short fault is shorter than a lease");

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    const NODES: Nodes = Nodes { broker: 3, kafka: 3 };

    fn faults(seed: u64, control: Control, count: usize) -> Vec<Fault> {
        let mut plan = Plan::new(seed, control, NODES);
        (0..count).map(|_| plan.next().fault).collect()
    }

    #[test]
    fn the_first_round_strikes_each_role_once_and_the_second_each_node_in_each_way() {
        for seed in 0..50 {
            let faults = faults(seed, Control::None, 8 + Fault::all(NODES).len());
            let (first, second) = faults.split_at(8);
            let roles: BTreeSet<String> = first.iter().map(ToString::to_string).collect();
            assert_eq!(roles.len(), 8, "{roles:?}");
            assert_eq!(BTreeSet::from_iter(second), BTreeSet::from_iter(&Fault::all(NODES)), "seed {seed}");
        }
    }

    #[test]
    fn the_same_seed_makes_the_same_plan_and_another_another() {
        assert_eq!(faults(1, Control::None, 100), faults(1, Control::None, 100));
        assert_ne!(faults(1, Control::None, 100), faults(2, Control::None, 100));
    }

    #[test]
    fn a_control_has_the_faults_that_bring_it_to_light() {
        assert!(faults(1, Control::Asynchronous, 4).iter().all(|one| one.deed == Deed::SeparatedThenKilled));
        assert!(
            faults(1, Control::NoFence, 4)
                .iter()
                .all(|one| one.deed == Deed::Frozen && matches!(one.victim, Victim::Supervisor(_)))
        );
        let mut plan = Plan::new(1, Control::NoFence, NODES);
        assert!((0..20).all(|_| plan.next().hold == Hold::UntilTaken), "longer than a lease");
    }
}
