//! Result of a cluster's run: a table for people, a line of JSON for programs.

use std::collections::BTreeMap;
use std::fmt;
use std::time::Instant;

use serde::Serialize;
use vibrissa_edge::invariants::Invariant;
use vibrissa_tests::oracle::verdicts::{self, Verdict};
use vibrissa_tests::oracle::{ledger, obedience};

use super::overlap::Happened;
use super::strike::{Struck, Surprises};

/// All counts of a run. Most of them must be 0; see `forbidden`.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Report {
    /// Seed of all random decisions.
    pub seed: u64,
    /// The broker and the number of its nodes.
    pub broker: &'static str,
    /// Number of brokers of Kafka, if contacts went through it, and records that the bridge wrote twice.
    pub kafka: usize,
    pub records_repeated: u64,
    /// Numbers of fleets and of robots.
    pub fleets: usize,
    pub robots: usize,
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
    /// Supervisors that ended unexpectedly, brokers that forgot nothing, panics in the supervisors' logs.
    pub ended_by_themselves: u64,
    pub stuck: u64,
    pub panics: u64,
    /// If faults of different parts overlapped: times in seconds, ascending, from the end of a round of faults until
    /// everything worked again.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub rounds_s: Vec<f64>,
    /// Faults, or rounds of them, after which not every robot was heard again, and faults after which redundancy did not come back.
    pub unrecovered: u64,
    pub not_whole: u64,
    /// Nodes of engines that ended on their own or had to be started again: no fault of the product.
    pub engine_restarts: u64,
    /// Seconds with contacts, and seconds until everything was recorded afterwards.
    pub run_s: f64,
    pub drain_s: f64,
    /// Faults that struck, in order.
    pub faults: Vec<FaultReport>,
}

/// A fault that struck, with times in seconds from the hit.
#[derive(Debug, Clone, Serialize)]
pub struct FaultReport {
    /// Kind of the fault.
    pub fault: String,
    /// Seconds after the robots' start.
    pub at_s: f64,
    /// Until all the victim's fleets had another owner.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub owned_s: Option<f64>,
    /// Number of the victim's fleets that others took over, and the time until the last one's first commit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub takeover: Option<(usize, f64)>,
    /// Until the engine itself worked again.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub engine_s: Option<f64>,
    /// Until the repair, until every robot had a new receipt, and until all redundancy was back.
    pub repaired_s: f64,
    pub recovered_s: Option<f64>,
    pub whole_s: Option<f64>,
}

impl FaultReport {
    fn new(struck: &Struck, started: Instant) -> Self {
        Self {
            fault: struck.fault.to_string(),
            at_s: (struck.at - started).as_secs_f64(),
            owned_s: struck.owned_s,
            takeover: struck.takeover,
            engine_s: struck.engine_s,
            repaired_s: struck.repaired_s,
            recovered_s: struck.recovered_s,
            whole_s: struck.whole_s,
        }
    }

    /// Time from the later one of the hit and the engine's own recovery to that of all robots. The robots may be first:
    /// they need not the nodes that the engine's clients of the harness use.
    fn after_engine_s(&self) -> Option<f64> {
        Some((self.recovered_s? - self.engine_s?).max(0.0))
    }
}

impl Report {
    /// A report with the results of the comparisons and the faults; all other counts are empty.
    pub fn new(
        contacts: ledger::Verdict,
        setpoints: obedience::Verdict,
        surprises: Surprises,
        happened: &Happened,
        started: Instant,
    ) -> Self {
        let struck = &happened.struck;
        let is_overlapping = !happened.rounds.is_empty();
        let mut rounds_s: Vec<f64> = happened.rounds.iter().flatten().copied().collect();
        rounds_s.sort_by(f64::total_cmp);
        let unheard = struck.iter().filter(|one| !is_overlapping && one.recovered_s.is_none()).count();
        let unrecovered = unheard + happened.rounds.iter().filter(|one| one.is_none()).count();
        Self {
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
            ended_by_themselves: surprises.ended,
            stuck: surprises.stuck,
            engine_restarts: surprises.engines,
            unrecovered: unrecovered as u64,
            not_whole: struck.iter().filter(|one| one.whole_s.is_none()).count() as u64,
            faults: struck.iter().map(|one| FaultReport::new(one, started)).collect(),
            rounds_s,
            ..Self::default()
        }
    }

    /// Counts that must be 0, with their names.
    fn forbidden(&self) -> [Verdict; 14] {
        use Invariant::{
            ContactAsFelt, ContactOnce, ContactRecorded, FleetOwned, NoPanic, SetpointCommitted, SetpointForDecision,
            SetpointFresh, SetpointOnce,
        };
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
            Verdict::of_run("brokers that forgot nothing", self.stuck),
            Verdict::of(NoPanic, "panics of supervisors", self.panics),
            Verdict::of(FleetOwned, "faults or rounds after which a robot stayed unheard", self.unrecovered),
            Verdict::of_run("faults after which something stayed missing", self.not_whole),
        ]
    }

    /// Violations: forbidden counts above 0, and parts of the run that had no data.
    pub fn violations(&self) -> Vec<String> {
        let mut violations = verdicts::violations(&self.forbidden());
        let faults = self.faults.len() as u64;
        for (name, count) in [("contacts", self.sent), ("setpoints", self.applied), ("faults", faults)] {
            if count == 0 {
                violations.push(format!("no {name}: the run is not conclusive"));
            }
        }
        violations
    }

    /// Times of each kind of fault, ascending.
    fn times(&self, which: impl Fn(&FaultReport) -> Option<f64>) -> BTreeMap<&str, Vec<f64>> {
        let mut by_fault: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
        for fault in &self.faults {
            by_fault.entry(&fault.fault).or_default().extend(which(fault));
        }
        by_fault.values_mut().for_each(|seconds| seconds.sort_by(f64::total_cmp));
        by_fault.retain(|_, seconds| !seconds.is_empty());
        by_fault
    }

    fn fmt_times(
        &self,
        f: &mut fmt::Formatter<'_>,
        head: &str,
        which: impl Fn(&FaultReport) -> Option<f64>,
    ) -> fmt::Result {
        writeln!(f, "\n{head:<58}{:>9}{:>9}{:>9}{:>9}", "times", "min", "median", "max")?;
        for (fault, seconds) in self.times(which) {
            let (min, median, max) = (seconds[0], seconds[seconds.len() / 2], seconds[seconds.len() - 1]);
            writeln!(f, "{fault:<58}{:>9}{min:>9.2}{median:>9.2}{max:>9.2}", seconds.len())?;
        }
        Ok(())
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { seed, broker, kafka, fleets, robots, run_s, drain_s, .. } = self;
        let kafka = if *kafka > 0 { format!(", Kafka, {kafka} nodes") } else { String::new() };
        writeln!(
            f,
            "seed {seed}: {} faults in {run_s:.0} s, {broker}{kafka}, {fleets} fleets, {robots} robots; then {drain_s:.1} s until everything \
             was recorded\n",
            self.faults.len()
        )?;
        for (name, count) in [
            ("contacts sent", self.sent),
            ("contacts recorded", self.recorded),
            ("setpoints decided", self.decided),
            ("setpoints applied", self.applied),
            ("setpoints repeated by the harness", self.repeated),
            ("records written twice by the bridge", self.records_repeated),
            ("engines' nodes started again", self.engine_restarts),
        ] {
            writeln!(f, "{name:<58}{count:>9}")?;
        }
        writeln!(f)?;
        verdicts::write_table(f, &self.forbidden(), 58)?;
        self.fmt_times(f, "hit to another owner of all fleets, s", |one| one.owned_s)?;
        self.fmt_times(f, "hit to the first commit for all fleets by others, s", |one| {
            one.takeover.map(|(_, seconds)| seconds)
        })?;
        self.fmt_times(f, "hit to the engine's own failover, s", |one| one.engine_s)?;
        self.fmt_times(f, "engine's failover to a new receipt for every robot, s", FaultReport::after_engine_s)?;
        self.fmt_times(f, "hit to a new receipt for every robot, s", |one| one.recovered_s)?;
        self.fmt_times(f, "hit until everything, or its part, worked again, s", |one| one.whole_s)?;
        if let Some(max) = self.rounds_s.last() {
            let (count, median) = (self.rounds_s.len(), self.rounds_s[self.rounds_s.len() / 2]);
            writeln!(
                f,
                "\nuntil everything worked again after each of {count} rounds: median {median:.1} s, max {max:.1} s"
            )?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn good() -> Report {
        let fault = FaultReport {
            fault: "etcd killed".to_owned(),
            at_s: 1.0,
            owned_s: None,
            takeover: None,
            engine_s: Some(2.0),
            repaired_s: 1.0,
            recovered_s: Some(3.0),
            whole_s: Some(4.0),
        };
        Report { sent: 10, recorded: 10, applied: 1, faults: vec![fault], ..Report::default() }
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
            |report| report.panics = 1,
            |report| report.unrecovered = 1,
            |report| report.not_whole = 1,
        ];
        for edit in edits {
            let mut report = good();
            edit(&mut report);
            assert_eq!(report.violations().len(), 1, "{report:?}");
        }
        assert_eq!(Report { faults: Vec::new(), ..good() }.violations().len(), 1);
    }

    #[test]
    fn times_are_listed_by_kind_of_fault() {
        let text = good().to_string();
        assert!(text.contains("etcd killed") && text.contains("3.00"), "{text}");
        assert_eq!(good().times(FaultReport::after_engine_s)["etcd killed"], [1.0]);
    }
}
