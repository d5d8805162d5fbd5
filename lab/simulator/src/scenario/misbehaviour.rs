//! Violations of the contract that a robot can commit on purpose, for tests of checkers.

use serde::Deserialize;
use vibrissa_protocol::Rule;

/// Defines the faults: the enum, their names, and the rule that each breaks.
macro_rules! misbehaviours {
    ($($(#[$doc:meta])* $variant:ident = $word:literal, $rule:expr;)+) => {
        /// A fault in a robot's implementation of the contract.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Deserialize)]
        pub enum Misbehaviour {
            $($(#[$doc])* #[serde(rename = $word)] $variant,)+
        }

        impl Misbehaviour {
            /// All faults.
            pub const ALL: &[Self] = &[$(Self::$variant),+];

            /// Name of the fault, in kebab case.
            #[must_use]
            pub const fn as_str(self) -> &'static str {
                match self { $(Self::$variant => $word,)+ }
            }

            /// The one rule that the fault breaks; `None` if it breaks several.
            #[must_use]
            pub const fn rule(self) -> Option<Rule> {
                match self { $(Self::$variant => $rule,)+ }
            }
        }
    };
}

misbehaviours! {
    /// The birth is not retained.
    BirthNotRetained = "birth-not-retained", Some(Rule::Birth);
    /// The will has the boot id of another boot.
    WillOfAnotherBoot = "will-of-another-boot", Some(Rule::Will);
    /// The will is not retained.
    WillNotRetained = "will-not-retained", Some(Rule::WillRetained);
    /// After a restart, the boot id and the sequence numbers continue.
    KeepsBootId = "keeps-boot-id", Some(Rule::BootIdNew);
    /// Requests for births are ignored.
    IgnoresBirthRequest = "ignores-birth-request", Some(Rule::BirthOnRequest);
    /// The factsheet is sent only on request.
    NoFactsheetAtBirth = "no-factsheet-at-birth", Some(Rule::FactsheetAfterBirth);
    /// The factsheet is not retained.
    FactsheetNotRetained = "factsheet-not-retained", Some(Rule::FactsheetRetained);
    /// Requests for the factsheet are ignored.
    IgnoresFactsheetRequest = "ignores-factsheet-request", Some(Rule::FactsheetOnRequest);
    /// A status is sent every 25 s.
    StatusSeldom = "status-seldom", Some(Rule::StatusPeriod);
    /// A status is sent every 0.1 s.
    StatusOften = "status-often", Some(Rule::StatusPeriod);
    /// Requests for the status are ignored.
    IgnoresStatusRequest = "ignores-status-request", Some(Rule::StatusOnRequest);
    /// The status omits the last whisker.
    StatusLeavesOut = "status-leaves-out", Some(Rule::StatusWhiskers);
    /// Every third status lacks `t_us`.
    MalformedStatus = "malformed-status", Some(Rule::MessageForm);
    /// Every third status has a sequence number that is one too high.
    SkipsNumbers = "skips-numbers", Some(Rule::SeqWithoutGaps);
    /// After a restart, the sequence numbers continue.
    KeepsCounting = "keeps-counting", Some(Rule::SeqFromZero);
    /// The times of contacts are an hour ahead.
    ContactsAhead = "contacts-ahead", Some(Rule::Clock);
    /// The time of every third status is 1.5 s too early.
    TimeBack = "time-back", Some(Rule::TimeForward);
    /// Answers to setpoints have quality of service 0.
    AnswersAtMostOnce = "answers-at-most-once", Some(Rule::QualityOfService);
    /// The status is retained.
    StatusRetained = "status-retained", Some(Rule::NotRetained);
    /// Every fifth contact has a contact ratio above 1.
    RatioAboveOne = "ratio-above-one", Some(Rule::ContactsInRange);
    /// Every fifth contact is of a whisker that does not exist.
    UnknownWhiskerTouched = "unknown-whisker-touched", Some(Rule::ContactsOnFactsheet);
    /// Every fifth contact has one and a half times the `strain_max` of its whisker. For whiskers with a `strain_max`.
    StrainBeyondGauge = "strain-beyond-gauge", Some(Rule::StrainWithinGauge);
    /// Every fifth contact has a distance in place of the contact ratio that the factsheet states.
    AnotherPlace = "another-place", Some(Rule::PlaceAsStated);
    /// Contacts have the strain times `reading_gain`. For robots with `applies_gain`.
    MultipliesStrain = "multiplies-strain", Some(Rule::StrainAsMeasured);
    /// Touch tests are DONE without a touch.
    TestsWithoutTouch = "tests-without-touch", Some(Rule::TestDone);
    /// Touch tests for other boots are done.
    TestsForOtherBoots = "tests-for-other-boots", Some(Rule::TestWrongBoot);
    /// Contacts messages are sent once and not stored.
    SendsOnce = "sends-once", Some(Rule::ContactsResent);
    /// The newest uncovered message is sent again first.
    ResendsNewestFirst = "resends-newest-first", Some(Rule::ResendOldestFirst);
    /// Messages are sent again at a constant rate, with or without receipts.
    NoBackoff = "no-backoff", Some(Rule::ResendBackoff);
    /// Messages that are sent again have changed content.
    ResendsAltered = "resends-altered", Some(Rule::ResendSame);
    /// `next` in receipts is ignored.
    IgnoresNext = "ignores-next", Some(Rule::ReceiptNext);
    /// `held` in receipts is ignored.
    IgnoresHeld = "ignores-held", Some(Rule::ReceiptHeld);
    /// The end of `held` is mistaken for `next`.
    ForgetsGap = "forgets-gap", Some(Rule::ReceiptGap);
    /// Receipts for other boots are applied.
    TakesAnyReceipt = "takes-any-receipt", Some(Rule::ReceiptBoot);
    /// Only the final state of a setpoint is sent.
    SaysOnlyTheEnd = "says-only-the-end", Some(Rule::SetpointAnswers);
    /// The pressure is 0.008 MPa below the setpoint, but the status shows the setpoint, and it is reported as
    /// applied.
    HoldsLess = "holds-less", Some(Rule::SetpointApplied);
    /// The status always shows the nominal pressure as setpoint.
    StatusStaysNominal = "status-stays-nominal", Some(Rule::SetpointInStatus);
    /// Pressures change as fast as possible.
    IgnoresSlew = "ignores-slew", Some(Rule::Slew);
    /// Versions are ignored.
    TakesOldVersions = "takes-old-versions", Some(Rule::RefuseStaleVersion);
    /// Epochs are ignored.
    TakesOldEpochs = "takes-old-epochs", Some(Rule::RefuseStaleEpoch);
    /// Expired setpoints are accepted.
    TakesExpired = "takes-expired", Some(Rule::RefuseExpired);
    /// Setpoints for other boots are accepted.
    TakesOtherBoots = "takes-other-boots", Some(Rule::RefuseWrongBoot);
    /// Any pressure is accepted.
    TakesAnyPressure = "takes-any-pressure", Some(Rule::RefuseOutOfRange);
    /// Setpoints for whiskers that do not exist are not answered.
    SilentOnUnknownWhisker = "silent-on-unknown-whisker", Some(Rule::RefuseUnknownWhisker);
    /// A repeated command is not answered.
    SilentOnRepeats = "silent-on-repeats", Some(Rule::CommandAgainAnswered);
    /// A repeated command is applied again.
    AppliesRepeats = "applies-repeats", Some(Rule::CommandAgainNotApplied);
    /// A superseded setpoint is not reported.
    NeverSuperseded = "never-superseded", Some(Rule::Supersede);
    /// Messages with unknown fields are ignored.
    RefusesUnknownFields = "refuses-unknown-fields", Some(Rule::UnknownFields);
    /// An invalid message causes a restart.
    RestartsOnMalformed = "restarts-on-malformed", Some(Rule::MalformedHarmless);
    /// The connection is closed in good order, without OFFLINE.
    LeavesSilently = "leaves-silently", Some(Rule::Farewell);
    /// A changed condition is reported only by the next regular status.
    ReportsOnSchedule = "reports-on-schedule", Some(Rule::StatusOnChange);
    /// Dropped messages are not counted.
    DropsUncounted = "drops-uncounted", Some(Rule::ContactsDropped);
    /// A full memory drops the newest message.
    DropsNewest = "drops-newest", Some(Rule::ContactsBounded);
    /// A setpoint that cannot be reached has no final state.
    NeverFails = "never-fails", Some(Rule::FailedWithReason);
    /// Without a supervisor the chambers return to their nominal pressures, whatever the factsheet states.
    ReturnsWithoutSupervisor = "returns-without-supervisor", Some(Rule::OnSupervisorLoss);
    /// Any estimate is used, even if it is older than the last one. For robots with `places = "ESTIMATED_RATIO"`.
    TakesOldEstimates = "takes-old-estimates", Some(Rule::EstimateOrder);
    /// Only the first estimate of a boot is used. For robots with `places = "ESTIMATED_RATIO"`.
    KeepsFirstEstimate = "keeps-first-estimate", Some(Rule::EstimateLength);
    /// The robot subscribes to the state of the supervisor.
    ListensElsewhere = "listens-elsewhere", Some(Rule::OwnLevel);
    /// Any setpoint for an existing whisker is applied, even if it is late, repeated, or of an older epoch.
    TakesAnySetpoint = "takes-any-setpoint", None;
}

impl std::str::FromStr for Misbehaviour {
    type Err = String;

    fn from_str(word: &str) -> Result<Self, String> {
        Self::ALL.iter().copied().find(|one| one.as_str().eq_ignore_ascii_case(word)).ok_or_else(|| {
            let known: Vec<&str> = Self::ALL.iter().map(|one| one.as_str()).collect();
            format!("unknown fault; the faults are {}", known.join(", "))
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
    fn there_is_a_fault_for_each_rule() {
        let broken: BTreeSet<Rule> = Misbehaviour::ALL.iter().filter_map(|one| one.rule()).collect();
        assert_eq!(broken, Rule::ALL.iter().copied().collect());
    }

    #[test]
    fn faults_are_read_by_their_names() {
        for one in Misbehaviour::ALL {
            assert_eq!(one.as_str().parse(), Ok(*one));
        }
        assert!("kindness".parse::<Misbehaviour>().is_err());
    }
}
