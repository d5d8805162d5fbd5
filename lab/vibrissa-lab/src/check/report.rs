//! Report of a check: one result for each rule.

use std::collections::BTreeMap;
use std::fmt;
use std::time::Duration;

use serde::{Serialize, Serializer};
use vibrissa_protocol::Rule;

/// Result of a rule.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "UPPERCASE")]
pub enum Outcome {
    /// The robot was observed to follow the rule.
    Pass,
    /// The robot was observed to violate the rule.
    Fail,
    /// The rule could not be tested, for the reason in [`Finding::seen`].
    Skipped,
    /// The rule does not concern the robot, for the reason in [`Finding::seen`].
    Exempt,
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Pass => "PASS",
            Self::Fail => "FAIL",
            Self::Skipped => "SKIPPED",
            Self::Exempt => "EXEMPT",
        })
    }
}

/// Result of one rule with its reason.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// The rule of the contract.
    #[serde(serialize_with = "id")]
    pub rule: Rule,
    /// Result of the test.
    pub outcome: Outcome,
    /// Observation, or the reason why the rule was not tested.
    pub seen: String,
    /// Requirement of the rule.
    pub expected: &'static str,
}

fn id<S: Serializer>(rule: &Rule, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(rule.id())
}

/// Report of a check.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// Name of the fleet.
    pub fleet: String,
    /// Name of the robot.
    pub robot: String,
    /// Whisker on which setpoints were tried, as `array/number`.
    pub whisker: Option<String>,
    /// Epoch of these setpoints.
    pub epoch: u64,
    /// Duration of the check, in seconds.
    pub seconds: f64,
    /// Whether the check was stopped before its end.
    pub is_interrupted: bool,
    /// Results of all rules, in the contract's order.
    pub findings: Vec<Finding>,
    /// Additional notes for the operator.
    pub notes: Vec<String>,
}

impl Report {
    /// Number of rules with this result.
    #[must_use]
    pub fn count(&self, outcome: Outcome) -> usize {
        self.findings.iter().filter(|finding| finding.outcome == outcome).count()
    }

    /// Rules with this result.
    #[must_use]
    pub fn rules(&self, outcome: Outcome) -> Vec<Rule> {
        self.findings.iter().filter(|finding| finding.outcome == outcome).map(|finding| finding.rule).collect()
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for Finding { rule, outcome, seen, expected } in &self.findings {
            writeln!(f, "{rule:26} {outcome:8} {seen}")?;
            if *outcome == Outcome::Fail {
                writeln!(f, "{:35} expected: {expected}", "")?;
            }
        }
        let [passed, failed, skipped, exempt] =
            [Outcome::Pass, Outcome::Fail, Outcome::Skipped, Outcome::Exempt].map(|outcome| self.count(outcome));
        let (fleet, robot, seconds) = (&self.fleet, &self.robot, self.seconds);
        let exempt = if exempt > 0 { format!(", {exempt} exempt") } else { String::new() };
        writeln!(
            f,
            "\n{fleet}/{robot}: {passed} passed, {failed} failed, {skipped} skipped{exempt}, in {seconds:.0} s"
        )?;
        self.notes.iter().try_for_each(|note| writeln!(f, "- {note}"))
    }
}

/// A judgement on a rule, with its reason.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Judgement {
    Pass(String),
    Fail(String),
    Skip(String),
    Exempt(String),
}

/// Results so far. Later results do not replace a rule's first violation.
#[derive(Debug, Default)]
pub(super) struct Findings {
    known: BTreeMap<Rule, (Outcome, String)>,
    notes: Vec<String>,
}

impl Findings {
    /// The rule is followed, as far as this observation shows.
    pub(super) fn pass(&mut self, rule: Rule, seen: impl Into<String>) {
        if !self.has_failed(rule) {
            self.known.insert(rule, (Outcome::Pass, seen.into()));
        }
    }

    /// The rule is violated.
    pub(super) fn fail(&mut self, rule: Rule, seen: impl Into<String>) {
        if !self.has_failed(rule) {
            self.known.insert(rule, (Outcome::Fail, seen.into()));
        }
    }

    /// Passes or fails the rule.
    pub(super) fn judge(&mut self, rule: Rule, holds: bool, seen: impl Into<String>) {
        if holds { self.pass(rule, seen) } else { self.fail(rule, seen) }
    }

    /// Takes a judgement.
    pub(super) fn take(&mut self, rule: Rule, judgement: Judgement) {
        match judgement {
            Judgement::Pass(seen) => self.pass(rule, seen),
            Judgement::Fail(seen) => self.fail(rule, seen),
            Judgement::Skip(why) => self.skip(&[rule], &why),
            Judgement::Exempt(why) => self.exempt(&[rule], &why),
        }
    }

    /// Skips the rules that have no result yet.
    pub(super) fn skip(&mut self, rules: &[Rule], why: &str) {
        for &rule in rules {
            self.known.entry(rule).or_insert_with(|| (Outcome::Skipped, why.to_owned()));
        }
    }

    /// The rules do not concern the robot, unless it was seen to violate them.
    pub(super) fn exempt(&mut self, rules: &[Rule], why: &str) {
        for &rule in rules {
            if !self.has_failed(rule) {
                self.known.insert(rule, (Outcome::Exempt, why.to_owned()));
            }
        }
    }

    /// Adds a note for the operator.
    pub(super) fn note(&mut self, note: String) {
        self.notes.push(note);
    }

    pub(super) fn has_failed(&self, rule: Rule) -> bool {
        matches!(self.known.get(&rule), Some((Outcome::Fail, _)))
    }

    /// The results of all rules, and the notes; `unseen` is the reason for rules without a result.
    pub(super) fn close(mut self, unseen: &str) -> (Vec<Finding>, Vec<String>) {
        let finding = |&rule: &Rule| {
            let (outcome, seen) = self.known.remove(&rule).unwrap_or_else(|| (Outcome::Skipped, unseen.to_owned()));
            Finding { rule, outcome, seen, expected: rule.asked() }
        };
        (Rule::ALL.iter().map(finding).collect(), self.notes)
    }
}

/// A duration as text, in seconds.
pub(super) fn seconds(time: Duration) -> String {
    format!("{:.1} s", time.as_secs_f64())
}
