//! Rules of the contract that a robot breaks on purpose, so that whoever checks robots can be checked.

use serde::Deserialize;
use vibrissa_protocol::Rule;

/// Defines the faults: the enum, their names, and the rule that each breaks.
macro_rules! misbehaviours {
    ($($(#[$doc:meta])* $variant:ident = $word:literal, $rule:expr;)+) => {
        /// A fault in how a robot keeps the contract.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Deserialize)]
        pub enum Misbehaviour {
            $($(#[$doc])* #[serde(rename = $word)] $variant,)+
        }

        impl Misbehaviour {
            /// Every fault.
            pub const ALL: &[Self] = &[$(Self::$variant),+];

            /// Its name, in kebab case.
            #[must_use]
            pub const fn as_str(self) -> &'static str {
                match self { $(Self::$variant => $word,)+ }
            }

            /// The one rule that it breaks; none for a fault that breaks several.
            #[must_use]
            pub const fn rule(self) -> Option<Rule> {
                match self { $(Self::$variant => $rule,)+ }
            }
        }
    };
}

misbehaviours! {
    /// Its birth is not retained.
    BirthNotRetained = "birth-not-retained", Some(Rule::Birth);
    /// Its will names another boot.
    WillOfAnotherBoot = "will-of-another-boot", Some(Rule::Will);
    /// Its will is not retained.
    WillNotRetained = "will-not-retained", Some(Rule::WillRetained);
    /// It starts again under the boot id that it had, and goes on counting.
    KeepsBootId = "keeps-boot-id", Some(Rule::BootIdNew);
    /// No factsheet comes unless it is asked for.
    NoFactsheetAtBirth = "no-factsheet-at-birth", Some(Rule::FactsheetAfterBirth);
    /// Its factsheet is not retained.
    FactsheetNotRetained = "factsheet-not-retained", Some(Rule::FactsheetRetained);
    /// It does not hear requests for its factsheet.
    IgnoresFactsheetRequest = "ignores-factsheet-request", Some(Rule::FactsheetOnRequest);
    /// A status comes every 25 s.
    StatusSeldom = "status-seldom", Some(Rule::StatusPeriod);
    /// A status comes every 0.1 s.
    StatusOften = "status-often", Some(Rule::StatusPeriod);
    /// It does not hear requests for its status.
    IgnoresStatusRequest = "ignores-status-request", Some(Rule::StatusOnRequest);
    /// Its status leaves the last whisker out.
    StatusLeavesOut = "status-leaves-out", Some(Rule::StatusWhiskers);
    /// Every third status has no `t_us`.
    MalformedStatus = "malformed-status", Some(Rule::MessageForm);
    /// Every third status is numbered one too high.
    SkipsNumbers = "skips-numbers", Some(Rule::SeqWithoutGaps);
    /// After a restart it counts on.
    KeepsCounting = "keeps-counting", Some(Rule::SeqFromZero);
    /// Its contacts are an hour ahead.
    ContactsAhead = "contacts-ahead", Some(Rule::Clock);
    /// Every third status is 1.5 s older than it should be.
    TimeBack = "time-back", Some(Rule::TimeForward);
    /// What became of setpoints is told with quality of service 0.
    AnswersAtMostOnce = "answers-at-most-once", Some(Rule::QualityOfService);
    /// Its status is retained.
    StatusRetained = "status-retained", Some(Rule::NotRetained);
    /// Every fifth contact has a contact ratio above 1.
    RatioAboveOne = "ratio-above-one", Some(Rule::ContactsInRange);
    /// Every fifth contact is of a whisker that it does not have.
    UnknownWhiskerTouched = "unknown-whisker-touched", Some(Rule::ContactsOnFactsheet);
    /// Contacts are sent once and forgotten.
    SendsOnce = "sends-once", Some(Rule::ContactsResent);
    /// Of what it sends again the newest goes first.
    ResendsNewestFirst = "resends-newest-first", Some(Rule::ResendOldestFirst);
    /// It sends again at a steady pace, receipt or not.
    NoBackoff = "no-backoff", Some(Rule::ResendBackoff);
    /// What it sends again is not what it sent.
    ResendsAltered = "resends-altered", Some(Rule::ResendSame);
    /// It does not look at `next`.
    IgnoresNext = "ignores-next", Some(Rule::ReceiptNext);
    /// It does not look at `held`.
    IgnoresHeld = "ignores-held", Some(Rule::ReceiptHeld);
    /// It takes the end of `held` for `next`.
    ForgetsGap = "forgets-gap", Some(Rule::ReceiptGap);
    /// It takes receipts for other boots.
    TakesAnyReceipt = "takes-any-receipt", Some(Rule::ReceiptBoot);
    /// It says nothing of a setpoint before the end.
    SaysOnlyTheEnd = "says-only-the-end", Some(Rule::SetpointAnswers);
    /// It holds 0.008 MPa less than asked, says otherwise in its status, and calls it applied.
    HoldsLess = "holds-less", Some(Rule::SetpointApplied);
    /// Its status always shows the nominal pressure as setpoint.
    StatusStaysNominal = "status-stays-nominal", Some(Rule::SetpointInStatus);
    /// It changes pressures as fast as it can.
    IgnoresSlew = "ignores-slew", Some(Rule::Slew);
    /// It does not look at versions.
    TakesOldVersions = "takes-old-versions", Some(Rule::RefuseStaleVersion);
    /// It does not look at epochs.
    TakesOldEpochs = "takes-old-epochs", Some(Rule::RefuseStaleEpoch);
    /// It takes setpoints that have expired.
    TakesExpired = "takes-expired", Some(Rule::RefuseExpired);
    /// It takes setpoints for other boots.
    TakesOtherBoots = "takes-other-boots", Some(Rule::RefuseWrongBoot);
    /// It takes any pressure.
    TakesAnyPressure = "takes-any-pressure", Some(Rule::RefuseOutOfRange);
    /// It does not answer setpoints for whiskers that it does not have.
    SilentOnUnknownWhisker = "silent-on-unknown-whisker", Some(Rule::RefuseUnknownWhisker);
    /// It does not answer a command again.
    SilentOnRepeats = "silent-on-repeats", Some(Rule::CommandAgainAnswered);
    /// It applies a command again.
    AppliesRepeats = "applies-repeats", Some(Rule::CommandAgainNotApplied);
    /// It does not say that a setpoint was superseded.
    NeverSuperseded = "never-superseded", Some(Rule::Supersede);
    /// A message with a field that it does not know is not taken.
    RefusesUnknownFields = "refuses-unknown-fields", Some(Rule::UnknownFields);
    /// A message that it cannot read makes it start again.
    RestartsOnMalformed = "restarts-on-malformed", Some(Rule::MalformedHarmless);
    /// Any setpoint for a whisker that is there is applied: late, repeated, or of an older epoch.
    TakesAnySetpoint = "takes-any-setpoint", None;
}

impl std::str::FromStr for Misbehaviour {
    type Err = String;

    fn from_str(word: &str) -> Result<Self, String> {
        Self::ALL.iter().copied().find(|one| one.as_str() == word).ok_or_else(|| {
            let known: Vec<&str> = Self::ALL.iter().map(|one| one.as_str()).collect();
            format!("no such fault; there are {}", known.join(", "))
        })
    }
}

impl std::fmt::Display for Misbehaviour {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.as_str())
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn there_is_a_fault_for_each_rule_that_can_be_tested() {
        let broken: BTreeSet<Rule> = Misbehaviour::ALL.iter().filter_map(|one| one.rule()).collect();
        let testable: BTreeSet<Rule> = Rule::ALL.iter().copied().filter(|rule| rule.is_testable()).collect();
        assert_eq!(broken, testable);
    }

    #[test]
    fn faults_are_read_by_their_names() {
        for one in Misbehaviour::ALL {
            assert_eq!(one.as_str().parse(), Ok(*one));
        }
        assert!("kindness".parse::<Misbehaviour>().is_err());
    }
}
