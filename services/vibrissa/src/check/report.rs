//! What a check found: one result for each rule.

use std::collections::BTreeMap;
use std::fmt;
use std::time::Duration;

use serde::{Serialize, Serializer};
use vibrissa_protocol::Rule;
use vibrissa_protocol::rules::Visible;

/// Whether a robot keeps a rule.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "UPPERCASE")]
pub enum Outcome {
    /// It was seen to keep it.
    Pass,
    /// It was seen to break it.
    Fail,
    /// It could not be seen, for the reason in [`Finding::seen`].
    Skipped,
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Pass => "PASS",
            Self::Fail => "FAIL",
            Self::Skipped => "SKIPPED",
        })
    }
}

/// What was found of one rule.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// The rule.
    #[serde(serialize_with = "id")]
    pub rule: Rule,
    /// Whether it is kept.
    pub outcome: Outcome,
    /// What was seen, or why nothing was.
    pub seen: String,
    /// What the rule asks.
    pub expected: &'static str,
}

fn id<S: Serializer>(rule: &Rule, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(rule.id())
}

/// What a check found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// The fleet.
    pub fleet: String,
    /// The robot.
    pub robot: String,
    /// The whisker that setpoints were tried on, as `array/number`.
    pub whisker: Option<String>,
    /// The epoch of those setpoints.
    pub epoch: u64,
    /// How long it took, in seconds.
    pub seconds: f64,
    /// Whether it was stopped before its end.
    pub is_interrupted: bool,
    /// Every rule, in the contract's order.
    pub findings: Vec<Finding>,
    /// What the operator needs to know beyond that.
    pub notes: Vec<String>,
}

impl Report {
    /// How many rules came out so.
    #[must_use]
    pub fn count(&self, outcome: Outcome) -> usize {
        self.findings.iter().filter(|finding| finding.outcome == outcome).count()
    }

    /// The rules that came out so.
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
        let [passed, failed, skipped] =
            [Outcome::Pass, Outcome::Fail, Outcome::Skipped].map(|outcome| self.count(outcome));
        let (fleet, robot, seconds) = (&self.fleet, &self.robot, self.seconds);
        writeln!(f, "\n{fleet}/{robot}: {passed} passed, {failed} failed, {skipped} skipped, in {seconds:.0} s")?;
        self.notes.iter().try_for_each(|note| writeln!(f, "- {note}"))
    }
}

/// What is known of each rule so far. The first thing seen to be wrong stays.
#[derive(Debug, Default)]
pub(super) struct Findings {
    known: BTreeMap<Rule, (Outcome, String)>,
    notes: Vec<String>,
}

impl Findings {
    /// The rule is kept, as far as this shows.
    pub(super) fn pass(&mut self, rule: Rule, seen: impl Into<String>) {
        if !self.has_failed(rule) {
            self.known.insert(rule, (Outcome::Pass, seen.into()));
        }
    }

    /// The rule is broken.
    pub(super) fn fail(&mut self, rule: Rule, seen: impl Into<String>) {
        if !self.has_failed(rule) {
            self.known.insert(rule, (Outcome::Fail, seen.into()));
        }
    }

    /// As it holds or not.
    pub(super) fn judge(&mut self, rule: Rule, holds: bool, seen: impl Into<String>) {
        if holds { self.pass(rule, seen) } else { self.fail(rule, seen) }
    }

    /// Nothing can be seen of these, unless something was already.
    pub(super) fn skip(&mut self, rules: &[Rule], why: &str) {
        for &rule in rules {
            self.known.entry(rule).or_insert_with(|| (Outcome::Skipped, why.to_owned()));
        }
    }

    /// Something for the operator.
    pub(super) fn note(&mut self, note: String) {
        self.notes.push(note);
    }

    fn has_failed(&self, rule: Rule) -> bool {
        matches!(self.known.get(&rule), Some((Outcome::Fail, _)))
    }

    /// All rules, and the notes; `unseen` is why nothing is known of the rest.
    pub(super) fn close(mut self, unseen: &str) -> (Vec<Finding>, Vec<String>) {
        let finding = |&rule: &Rule| {
            let (outcome, seen) = self.known.remove(&rule).unwrap_or_else(|| {
                let why = match rule.visible() {
                    Visible::Not(why) => format!("not tested: {why}"),
                    Visible::Talking | Visible::Restarting => unseen.to_owned(),
                };
                (Outcome::Skipped, why)
            });
            Finding { rule, outcome, seen, expected: rule.asked() }
        };
        (Rule::ALL.iter().map(finding).collect(), self.notes)
    }
}

/// A time for people.
pub(super) fn seconds(time: Duration) -> String {
    format!("{:.1} s", time.as_secs_f64())
}
