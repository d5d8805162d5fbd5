//! Result of a run: a table for people, a line of JSON for programs.

use std::collections::BTreeMap;
use std::fmt;
use std::time::Instant;

use serde::Serialize;
use vibrissa_edge::invariants::Invariant;
use vibrissa_tests::oracle::verdicts::{self, Verdict};
use vibrissa_tests::oracle::{ledger, obedience};

use crate::owner::Reign;
use crate::plan::Fault;
use crate::strike::{Struck, Surprises};

/// All counts of a run. Most of them must be 0; see `forbidden`.
#[derive(Debug, Clone, Serialize)]
pub struct Report {
    /// Seed of all random decisions.
    pub seed: u64,
    /// Contacts that robots made, and rows in the database.
    pub sent: u64,
    pub recorded: u64,
    /// Contacts that are missing, recorded twice, or recorded with wrong values.
    pub missing: u64,
    pub duplicate: u64,
    pub wrong: u64,
    /// Setpoints in the database, and those that robots applied.
    pub decided: u64,
    pub applied: u64,
    /// Setpoints that should not have been applied or decided.
    pub applied_twice: u64,
    pub applied_stale: u64,
    pub uncommitted: u64,
    pub two_for_one: u64,
    /// Setpoints that the harness published again.
    pub repeated: u64,
    /// Messages that robots dropped, and messages without a receipt at the end.
    pub dropped: u64,
    pub undelivered: u64,
    /// Supervisors that ended unexpectedly or did not end after SIGTERM, and faults that found no owner.
    pub ended_by_themselves: u64,
    pub stuck: u64,
    pub ownerless: u64,
    /// Panics in the supervisors' logs.
    pub panics: u64,
    /// Seconds with contacts, and seconds until everything was recorded afterwards.
    pub run_s: f64,
    pub drain_s: f64,
    /// Number of hostile robots, and messages and connections of each behaviour.
    pub hostile_robots: u64,
    pub hostile: BTreeMap<String, u64>,
    /// Setpoints that hostile robots received, repetitions included.
    pub hostile_setpoints: u64,
    /// Lower bounds of the supervisors' counters of refused messages and of violated invariants.
    pub refusals: BTreeMap<String, u64>,
    /// Faults that struck, in order.
    pub faults: Vec<FaultReport>,
}

/// The supervisors' counter of violated invariants.
const COUNTED: &str = "vibrissa_invariant_violations_total";
/// Longest list of faults in the table for people.
const LISTED: usize = 60;

/// A fault that struck.
#[derive(Debug, Clone, Serialize)]
pub struct FaultReport {
    /// Kind of the fault.
    pub fault: Fault,
    /// Seconds after the robots' start.
    pub at_s: f64,
    /// Takeover, for faults that end the owner's lease.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub takeover: Option<Takeover>,
}

/// Takeover by another supervisor, or by the same one after a restart.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Takeover {
    /// Seconds from the signal to the first commit with contacts; None if there was none until the end.
    pub seconds: Option<f64>,
}

impl FaultReport {
    /// Finds the takeover that followed a fault.
    pub fn new(struck: &Struck, started: Instant, reigns: &[Reign]) -> Self {
        let takeover = struck.owner_hit.map(|(hit, epoch)| {
            let next = reigns.iter().find(|reign| reign.epoch > epoch && reign.first_commit > hit);
            Takeover { seconds: next.map(|reign| (reign.first_commit - hit).as_secs_f64()) }
        });
        Self { fault: struck.fault, at_s: (struck.at - started).as_secs_f64(), takeover }
    }
}

impl Report {
    /// A report with the results of the comparisons; all other counts are empty.
    pub fn new(seed: u64, contacts: ledger::Verdict, setpoints: obedience::Verdict, surprises: Surprises) -> Self {
        Self {
            seed,
            sent: contacts.felt,
            recorded: contacts.recorded,
            missing: contacts.missing,
            duplicate: contacts.duplicate,
            wrong: contacts.wrong,
            decided: setpoints.decided,
            applied: setpoints.applied,
            applied_twice: setpoints.twice,
            applied_stale: setpoints.stale,
            uncommitted: setpoints.uncommitted,
            two_for_one: setpoints.two_for_one,
            repeated: 0,
            dropped: 0,
            undelivered: 0,
            ended_by_themselves: surprises.ended,
            stuck: surprises.stuck,
            ownerless: surprises.ownerless,
            panics: 0,
            run_s: 0.0,
            drain_s: 0.0,
            hostile_robots: 0,
            hostile: BTreeMap::new(),
            hostile_setpoints: 0,
            refusals: BTreeMap::new(),
            faults: Vec::new(),
        }
    }

    /// Counts that must be 0, with their names.
    fn forbidden(&self) -> [Verdict; 15] {
        use Invariant::{
            ContactAsFelt, ContactOnce, ContactRecorded, FleetOwned, NoPanic, SetpointCommitted, SetpointForDecision,
            SetpointFresh, SetpointOnce,
        };
        let takeovers = self.faults.iter().filter_map(|fault| fault.takeover);
        let counted = self.refusals.iter().filter(|(name, _)| name.starts_with(COUNTED));
        let unowned = takeovers.filter(|one| one.seconds.is_none()).count() as u64;
        [
            Verdict::of(ContactRecorded, "contacts missing", self.missing),
            Verdict::of(ContactOnce, "contacts duplicate", self.duplicate),
            Verdict::of(ContactAsFelt, "contacts wrong", self.wrong),
            Verdict::of(SetpointOnce, "setpoints applied twice", self.applied_twice),
            Verdict::of(SetpointFresh, "setpoints applied stale", self.applied_stale),
            Verdict::of(SetpointCommitted, "setpoints applied, not in the database", self.uncommitted),
            Verdict::of(SetpointForDecision, "setpoints, two for one decision", self.two_for_one),
            Verdict::of(ContactRecorded, "messages dropped by robots", self.dropped),
            Verdict::of(ContactRecorded, "messages without a receipt at the end", self.undelivered),
            Verdict::of_run("supervisors ended unexpectedly", self.ended_by_themselves),
            Verdict::of_run("supervisors not ended by SIGTERM, brokers that forgot nothing", self.stuck),
            Verdict::of_run("faults without an owner to hit", self.ownerless),
            Verdict::of_run("violations that supervisors have counted", counted.map(|(_, count)| count).sum()),
            Verdict::of(NoPanic, "panics of supervisors", self.panics),
            Verdict::of(FleetOwned, "owners hit without a takeover", unowned),
        ]
    }

    /// Violations: forbidden counts above 0, and parts of the run that had no data.
    pub fn violations(&self) -> Vec<String> {
        let mut violations = verdicts::violations(&self.forbidden());
        for (name, count) in [("contacts", self.sent), ("setpoints", self.applied), ("repetitions", self.repeated)] {
            if count == 0 {
                violations.push(format!("no {name}: the run is not conclusive"));
            }
        }
        let idle = self.hostile.iter().filter(|(_, count)| **count == 0 && self.hostile_robots > 0);
        violations.extend(idle.map(|(name, _)| format!("no hostile robot did {name}: the run is not conclusive")));
        if self.hostile_robots > 0 && self.hostile.is_empty() {
            violations.push("hostile robots did nothing: the run is not conclusive".to_owned());
        }
        violations
    }

    /// Writes the counts of hostile messages and of refusals.
    fn fmt_hostile(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "\n{:<42}{:>9}", format!("{} hostile robots", self.hostile_robots), "messages")?;
        for (name, count) in &self.hostile {
            writeln!(f, "{name:<42}{count:>9}")?;
        }
        writeln!(f, "{:<42}{:>9}", "setpoints sent to them", self.hostile_setpoints)?;
        writeln!(f, "\nrefused by the supervisors (lower bounds)")?;
        for (name, count) in &self.refusals {
            writeln!(f, "{name:<78}{count:>9}")?;
        }
        Ok(())
    }

    /// Takeover times by kind of fault, ascending.
    fn takeovers(&self) -> BTreeMap<Fault, Vec<f64>> {
        let mut by_fault: BTreeMap<Fault, Vec<f64>> = BTreeMap::new();
        for fault in &self.faults {
            if let Some(seconds) = fault.takeover.and_then(|takeover| takeover.seconds) {
                by_fault.entry(fault.fault).or_default().push(seconds);
            }
        }
        by_fault.values_mut().for_each(|seconds| seconds.sort_by(f64::total_cmp));
        by_fault
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "seed {}: {:.0} s, then {:.1} s until everything was recorded",
            self.seed, self.run_s, self.drain_s
        )?;
        writeln!(f)?;
        for (name, count) in [
            ("contacts sent", self.sent),
            ("contacts recorded", self.recorded),
            ("setpoints decided", self.decided),
            ("setpoints applied", self.applied),
            ("setpoints repeated by the harness", self.repeated),
        ] {
            writeln!(f, "{name:<42}{count:>9}")?;
        }
        writeln!(f)?;
        verdicts::write_table(f, &self.forbidden(), 42)?;
        self.fmt_hostile(f)?;
        writeln!(f, "\n{:<42}{:>9}  takeover, s", "fault", "at, s")?;
        if self.faults.len() > LISTED {
            writeln!(f, "{} faults: --json lists them", self.faults.len())?;
        }
        for fault in self.faults.iter().filter(|_| self.faults.len() <= LISTED) {
            write!(f, "{:<42}{:>9.1}", fault.fault, fault.at_s)?;
            match fault.takeover {
                Some(Takeover { seconds: Some(seconds) }) => writeln!(f, "  {seconds:.2}")?,
                Some(Takeover { seconds: None }) => writeln!(f, "  none")?,
                None => writeln!(f)?,
            }
        }
        writeln!(
            f,
            "\n{:<42}{:>9}{:>9}{:>9}{:>9}",
            "from the signal to the next commit, s", "times", "min", "median", "max"
        )?;
        for (fault, seconds) in self.takeovers() {
            let (min, median, max) = (seconds[0], seconds[seconds.len() / 2], seconds[seconds.len() - 1]);
            writeln!(f, "{fault:<42}{:>9}{min:>9.2}{median:>9.2}{max:>9.2}", seconds.len())?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    fn good() -> Report {
        let contacts = ledger::Verdict { felt: 10, recorded: 10, ..Default::default() };
        let setpoints = obedience::Verdict { decided: 2, applied: 1, ..Default::default() };
        Report { repeated: 1, ..Report::new(1, contacts, setpoints, Surprises::default()) }
    }

    #[test]
    fn whatever_is_forbidden_is_a_violation() {
        assert_eq!(good().violations(), Vec::<String>::new());
        let edits: [fn(&mut Report); 14] = [
            |report| report.missing = 1,
            |report| report.duplicate = 1,
            |report| report.wrong = 1,
            |report| report.applied_twice = 1,
            |report| report.applied_stale = 1,
            |report| report.uncommitted = 1,
            |report| report.two_for_one = 1,
            |report| report.dropped = 1,
            |report| report.undelivered = 1,
            |report| report.ended_by_themselves = 1,
            |report| report.stuck = 1,
            |report| report.ownerless = 1,
            |report| report.panics = 1,
            |report| report.refusals = BTreeMap::from([(format!("{COUNTED}{{invariant=\"EPOCH_ONCE\"}}"), 1)]),
        ];
        for edit in edits {
            let mut report = good();
            edit(&mut report);
            assert_eq!(report.violations().len(), 1, "{report:?}");
        }
    }

    #[test]
    fn a_run_in_which_nothing_happens_shows_nothing() {
        assert_eq!(Report { applied: 0, ..good() }.violations().len(), 1);
        assert_eq!(Report { repeated: 0, ..good() }.violations().len(), 1);
    }

    #[test]
    fn a_hostile_behaviour_that_did_not_take_place_is_a_violation() {
        let hostile = |count| BTreeMap::from([("flood".to_owned(), 5), ("garbage".to_owned(), count)]);
        assert!(Report { hostile_robots: 1, hostile: hostile(1), ..good() }.violations().is_empty());
        let violations = Report { hostile_robots: 1, hostile: hostile(0), ..good() }.violations();
        assert!(violations.len() == 1 && violations[0].contains("garbage"), "{violations:?}");
        assert_eq!(Report { hostile_robots: 1, ..good() }.violations().len(), 1);
        assert!(Report { hostile: hostile(0), ..good() }.violations().is_empty());
    }

    #[test]
    fn a_takeover_is_the_next_epochs_first_commit_after_the_signal() {
        let start = Instant::now();
        let after = |s: f64| start + Duration::from_secs_f64(s);
        let reign = |epoch, s| Reign { epoch, holder: "b".to_owned(), first_commit: after(s) };
        let struck = Struck { fault: Fault::OwnerKilled, at: after(5.0), owner_hit: Some((after(5.0), 1)) };
        let seconds = |reigns: &[Reign]| FaultReport::new(&struck, start, reigns).takeover.unwrap().seconds;
        assert_eq!(seconds(&[reign(1, 1.0), reign(2, 7.5)]), Some(2.5));
        assert_eq!(seconds(&[reign(1, 1.0)]), None);
        let report = Report { faults: vec![FaultReport::new(&struck, start, &[])], ..good() };
        assert_eq!(report.violations(), ["FLEET_OWNED: owners hit without a takeover: 1"]);
    }
}
