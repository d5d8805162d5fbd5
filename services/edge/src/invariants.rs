//! Statements that always hold, or hold in the end: each one once, with its word, its sentence and those that check it.
//!
//! The simulation, the chaos runs and the running supervisor report a violation under the same word. The functions below
//! compare observed facts; docs/invariants.md lists all invariants.

use std::fmt;

use vibrissa_core::units::Megapascal;

/// A part of the project that checks invariants.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Checker {
    /// Supervisors, robots, broker and store in simulated time.
    Simulation,
    /// Real programs under faults, whose database is compared with the robots' own record.
    Chaos,
    /// The running supervisor, which counts violations as a metric.
    Production,
}

impl Checker {
    /// All checkers.
    pub const ALL: [Self; 3] = [Self::Simulation, Self::Chaos, Self::Production];

    /// Name of the checker in the document.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Simulation => "simulation",
            Self::Chaos => "chaos",
            Self::Production => "production",
        }
    }
}

/// Declares each invariant's word, its sentence, and those that check it.
macro_rules! invariants {
    ($($invariant:ident $word:literal $sentence:literal [$($checker:ident)*];)+) => {
        /// An invariant.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Invariant {
            $(#[doc = $sentence] $invariant,)+
        }

        impl Invariant {
            /// All invariants.
            pub const ALL: &'static [Self] = &[$(Self::$invariant),+];

            /// Its word, in upper snake case.
            #[must_use]
            pub const fn word(self) -> &'static str {
                match self {
                    $(Self::$invariant => $word,)+
                }
            }

            /// The invariant as a sentence.
            #[must_use]
            pub const fn as_str(self) -> &'static str {
                match self {
                    $(Self::$invariant => $sentence,)+
                }
            }

            /// Those that check it.
            #[must_use]
            pub const fn checkers(self) -> &'static [Checker] {
                match self {
                    $(Self::$invariant => &[$(Checker::$checker),*],)+
                }
            }
        }
    };
}

invariants! {
    ReceiptAfterCommit "RECEIPT_AFTER_COMMIT" "a receipt covers only contacts that are committed" [Simulation Production];
    ContactRecorded "CONTACT_RECORDED" "each receipted contact is recorded, and in the end every contact"
        [Simulation Chaos];
    ContactOnce "CONTACT_ONCE" "no contact is recorded twice" [Simulation Chaos Production];
    ContactAsFelt "CONTACT_AS_FELT" "a recorded contact has the values that the robot felt" [Simulation Chaos];
    EpochOnce "EPOCH_ONCE" "no epoch of a fleet is given twice, and epochs rise" [Simulation Production];
    SetpointCommitted "SETPOINT_COMMITTED" "a robot applies only setpoints that are committed"
        [Simulation Chaos Production];
    SetpointNumberedOnce "SETPOINT_NUMBERED_ONCE" "no two setpoints of a robot have the same epoch and version"
        [Production];
    SetpointOnce "SETPOINT_ONCE" "no robot applies a setpoint twice" [Simulation Chaos];
    SetpointFresh "SETPOINT_FRESH" "no robot applies a setpoint that is expired, outdated, or for another boot"
        [Simulation Chaos];
    SetpointExpires "SETPOINT_EXPIRES" "a setpoint lives for its time to live at most, by the robot's clock" [Simulation];
    SetpointForDecision "SETPOINT_FOR_DECISION" "a decision has one setpoint, unless that came to nothing"
        [Simulation Chaos];
    PressureInRange "PRESSURE_IN_RANGE" "the pressure of a setpoint is within the whisker's range"
        [Simulation Production];
    TrimIsTrue "TRIM_IS_TRUE" "a trim is reported only of a whisker that was cut" [Simulation];
    FaultIsTrue "FAULT_IS_TRUE" "a fault is reported only of a whisker that has it" [Simulation];
    FleetOwned "FLEET_OWNED" "in the end each fleet has one owner, which hears its robots" [Simulation Chaos];
    SetpointEnds "SETPOINT_ENDS" "in the end each setpoint has an end" [Simulation];
    WebhookDelivered "WEBHOOK_DELIVERED" "in the end each webhook has got each committed event that it wants"
        [Simulation];
    WebhookInOrder "WEBHOOK_IN_ORDER" "a webhook gets events in the order of their commits, except dead letters"
        [Simulation];
    WebhookOnce "WEBHOOK_ONCE" "a webhook gets one request at a time, unless a sender stands still during one"
        [Simulation];
    WebhookIdOnce "WEBHOOK_ID_ONCE" "no two events of a webhook have the same identifier" [Simulation];
    NewerStateKept "NEWER_STATE_KEPT" "a program keeps the state of a robot that a newer program has written"
        [Simulation];
    NoPanic "NO_PANIC" "no part of the program panics" [Simulation Chaos Production];
}

impl Invariant {
    /// Whether `checker` checks it.
    #[must_use]
    pub fn is_checked_by(self, checker: Checker) -> bool {
        self.checkers().contains(&checker)
    }
}

impl fmt::Display for Invariant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.as_str())
    }
}

/// [`Invariant::ReceiptAfterCommit`] and [`Invariant::SetpointCommitted`]: whether a message that `transaction` made may go
/// out. Transactions are numbered in the order of their commits, and `committed` is the newest one.
#[must_use]
pub const fn is_committed(transaction: i64, committed: i64) -> bool {
    transaction <= committed
}

/// [`Invariant::ContactOnce`]: whether a message of contacts is new to a boot of which all numbers below `next` and all
/// numbers in `held` are accounted for. The ranges of `held` include both ends, and ascend.
#[must_use]
pub fn is_new(seq: u64, next: u64, held: &[(u64, u64)]) -> bool {
    let at = held.partition_point(|&(_, last)| last < seq);
    seq >= next && held.get(at).is_none_or(|&(first, _)| seq < first)
}

/// [`Invariant::EpochOnce`]: whether two owners, each with its epoch and its boot, can be owners of one fleet.
#[must_use]
pub fn is_epoch_once((epoch, boot_id): (u64, &str), (other, other_boot_id): (u64, &str)) -> bool {
    epoch != other || boot_id == other_boot_id
}

/// [`Invariant::PressureInRange`]: whether a setpoint's pressure is from 0 to the lower one of the whisker's limit and the
/// highest pressure that the paper examined, MPa.
#[must_use]
pub fn is_pressure_in_range(pressure_mpa: f64, limit_mpa: f64) -> bool {
    (0.0..=limit_mpa.min(Megapascal::EXAMINED_MAX.mpa())).contains(&pressure_mpa)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::fmt::Write as _;

    use super::*;

    const HEAD: &str = "| invariant | sentence | simulation | chaos | production |";

    /// The table of the document.
    fn table() -> String {
        let mut text = format!("{HEAD}\n| --- | --- | --- | --- | --- |\n");
        for invariant in Invariant::ALL {
            write!(text, "| `{}` | {invariant} |", invariant.word()).unwrap();
            for checker in Checker::ALL {
                text.push_str(if invariant.is_checked_by(checker) { " yes |" } else { " |" });
            }
            text.push('\n');
        }
        text
    }

    #[test]
    fn the_table_in_docs_has_each_invariant_and_its_checkers() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/invariants.md");
        let there = std::fs::read_to_string(path).unwrap();
        let (before, rest) = there.split_once(HEAD).expect("the head of the table");
        let (_, after) = rest.split_once("\n\n").expect("an empty line after the table");
        let written = format!("{before}{}\n{after}", table());
        if std::env::var_os("VIBRISSA_WRITE_DOCS").is_some() {
            std::fs::write(path, &written).unwrap();
        }
        let there = std::fs::read_to_string(path).unwrap();
        assert!(there == written, "docs/invariants.md differs from the code: write it with VIBRISSA_WRITE_DOCS=1");
        let checkers = Checker::ALL.map(Checker::as_str).join(" | ");
        assert!(HEAD.ends_with(&format!("| {checkers} |")), "the columns are the checkers");
    }

    #[test]
    fn each_word_and_each_sentence_stands_for_one_invariant() {
        let words: BTreeSet<_> = Invariant::ALL.iter().map(|one| one.word()).collect();
        let sentences: BTreeSet<_> = Invariant::ALL.iter().map(|one| one.as_str()).collect();
        assert_eq!((words.len(), sentences.len()), (Invariant::ALL.len(), Invariant::ALL.len()));
        for invariant in Invariant::ALL {
            let name = format!("{invariant:?}").to_uppercase();
            assert_eq!(invariant.word().replace('_', ""), name, "the word is the name in upper snake case");
        }
    }

    #[test]
    fn a_message_of_a_transaction_that_is_not_committed_violates() {
        assert_eq!([1, 7, 8].map(|transaction| is_committed(transaction, 7)), [true, true, false]);
    }

    #[test]
    fn brute_force_a_number_that_is_accounted_for_violates() {
        let held = [(5, 6), (9, 9), (11, 13)];
        let accounted_for: BTreeSet<u64> = (0..3).chain([5, 6, 9, 11, 12, 13]).collect();
        for seq in 0..20 {
            assert_eq!(is_new(seq, 3, &held), !accounted_for.contains(&seq), "{seq}");
            assert_eq!(is_new(seq, 3, &[]), seq >= 3, "{seq}");
        }
    }

    #[test]
    fn an_epoch_of_two_boots_violates() {
        let ours = (7, "one-7");
        for (other, is) in [((7, "one-7"), true), ((6, "two-6"), true), ((8, "two-8"), true), ((7, "two-7"), false)] {
            assert_eq!(is_epoch_once(ours, other), is, "{other:?}");
        }
    }

    #[test]
    fn paper_a_pressure_beyond_the_whisker_or_the_paper_violates() {
        for (pressure_mpa, limit_mpa) in [(0.0, 0.15), (0.15, 0.15), (0.2, 0.2), (0.2, 0.5), (0.0, 0.0)] {
            assert!(is_pressure_in_range(pressure_mpa, limit_mpa), "{pressure_mpa} of {limit_mpa}");
        }
        let beyond = [(-1e-9, 0.2), (0.15 + 1e-9, 0.15), (0.2 + 1e-9, 0.5), (f64::NAN, 0.2), (f64::INFINITY, 0.2)];
        for (pressure_mpa, limit_mpa) in beyond {
            assert!(!is_pressure_in_range(pressure_mpa, limit_mpa), "{pressure_mpa} of {limit_mpa}");
        }
    }
}
