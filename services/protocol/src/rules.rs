//! Rules of the contract for robots. Each has a permanent name for tools, tests and documents.
//!
//! `vibrissa-lab check-robot` tests a robot against them, and the simulator can break each one on purpose.

mod table;

use std::fmt;

pub use table::markdown;

/// Robots to which a rule applies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Scope {
    /// It applies to all robots.
    Every,
    /// It applies to robots that send contacts again until they are receipted, that is, with quality of service 0.
    Receipts,
}

/// How a test from outside verifies that a robot obeys a rule.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Visible {
    /// By an exchange of messages with the robot.
    Talking,
    /// Only while the robot is switched off and on again.
    Restarting,
    /// Only with help at the robot, or with more time than other rules need.
    Assisted,
    /// Only if the robot's connection to the broker passes the relay of the test.
    Relayed,
}

/// Defines the rules: the enum and the properties of each.
macro_rules! rules {
    ($($variant:ident = $id:literal, $topic:literal, $scope:ident, $visible:expr, $asked:literal;)+) => {
        /// A rule for robots.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Rule {
            $(#[doc = $asked] $variant,)+
        }

        impl Rule {
            /// All rules, in the order of the contract's topics.
            pub const ALL: &[Self] = &[$(Self::$variant),+];

            /// Name of the rule, in kebab case; it never changes.
            #[must_use]
            pub const fn id(self) -> &'static str {
                match self { $(Self::$variant => $id,)+ }
            }

            /// Topic that the rule applies to.
            #[must_use]
            pub const fn topic(self) -> &'static str {
                match self { $(Self::$variant => $topic,)+ }
            }

            /// Robots to which the rule applies.
            #[must_use]
            pub const fn scope(self) -> Scope {
                match self { $(Self::$variant => Scope::$scope,)+ }
            }

            /// How a test from outside verifies the rule.
            #[must_use]
            pub const fn visible(self) -> Visible {
                match self { $(Self::$variant => $visible,)+ }
            }

            /// Text of the rule, in one sentence.
            #[must_use]
            pub const fn asked(self) -> &'static str {
                match self { $(Self::$variant => $asked,)+ }
            }
        }
    };
}

use Visible::{Assisted, Relayed, Restarting, Talking};

rules! {
    Birth = "birth", "connection", Every, Talking,
        "After it has connected and subscribed, the robot publishes ONLINE, retained.";
    Will = "will", "connection", Every, Restarting,
        "The last will is CONNECTION_BROKEN with the boot_id of the birth of the same connection.";
    WillRetained = "will-retained", "connection", Every, Restarting,
        "The last will is retained.";
    BootIdNew = "boot-id-new", "connection", Every, Restarting,
        "Each start of the robot has a boot_id that was never used before.";
    BirthOnRequest = "birth-on-request", "connection", Every, Talking,
        "On a request for BIRTH to its fleet, the robot sends ONLINE and then its factsheet within 2 s, in the same boot.";
    Farewell = "farewell", "connection", Every, Assisted,
        "Before a deliberate disconnect the robot publishes OFFLINE, retained.";

    FactsheetAfterBirth = "factsheet-after-birth", "factsheet", Every, Talking,
        "The robot sends its factsheet after each birth.";
    FactsheetRetained = "factsheet-retained", "factsheet", Every, Talking,
        "The factsheet is retained.";
    FactsheetOnRequest = "factsheet-on-request", "factsheet", Every, Talking,
        "The robot sends its factsheet again on a request for FACTSHEET.";

    StatusPeriod = "status-period", "status", Every, Talking,
        "The robot sends a status every 1 to 10 s, even if nothing changes.";
    StatusOnRequest = "status-on-request", "status", Every, Talking,
        "The robot sends a status on a request for STATUS.";
    StatusWhiskers = "status-whiskers", "status", Every, Talking,
        "A status contains each whisker of the factsheet once, and no others.";
    StatusOnChange = "status-on-change", "status", Every, Assisted,
        "The robot sends a status when the condition of a regulator or a gauge changes.";
    ContactsDropped = "contacts-dropped", "status", Receipts, Assisted,
        "Contacts messages dropped because of a full store are counted in contacts_dropped.";

    MessageForm = "message-form", "all", Every, Talking,
        "Every message is JSON in UTF-8, or CBOR for contacts, with all required fields, and with words and names of the contract.";
    SeqWithoutGaps = "seq-without-gaps", "all", Every, Talking,
        "Within a boot, seq rises by one with each message of a topic, and identifies one message only.";
    SeqFromZero = "seq-from-zero", "all", Every, Restarting,
        "In each boot the first message of a topic has seq 0.";
    Clock = "clock", "all", Every, Talking,
        "Times are microseconds since 1970 UTC, or RFC 3339 in UTC, and correct to 2 s.";
    TimeForward = "time-forward", "all", Every, Talking,
        "Within a boot, the times of status, setpoint_state and factsheet do not decrease.";
    QualityOfService = "qos", "all", Every, Talking,
        "Quality of service is 1 for connection, factsheet and setpoint_state, 0 for status, and 0 or 1 for contacts.";
    NotRetained = "not-retained", "all", Every, Talking,
        "Contacts, status and setpoint_state are not retained.";

    ContactsInRange = "contacts-in-range", "contacts", Every, Talking,
        "The numbers of a contact are within their ranges: ratio from 0.01 to 1, deflection from 0.01 mm, and so on.";
    ContactsOnFactsheet = "contacts-on-factsheet", "contacts", Every, Talking,
        "Contacts are of whiskers in the factsheet.";
    StrainAsMeasured = "strain-as-measured", "contacts", Every, Talking,
        "The strain of a contact is as measured, without the reading_gain by which the robot multiplies its readings.";
    StrainWithinGauge = "strain-within-gauge", "contacts", Every, Talking,
        "The strain of a contact is at most the strain_max that the factsheet states for its whisker, if it states one.";
    PlaceAsStated = "place-as-stated", "contacts", Every, Talking,
        "Contacts have the place that the factsheet states for their whisker; those of a touch test have its own.";
    ContactsResent = "contacts-resent", "contacts", Receipts, Talking,
        "The robot sends a contacts message again if no receipt covers it.";
    ResendOldestFirst = "resend-oldest-first", "contacts", Receipts, Talking,
        "The robot sends the oldest uncovered message again first.";
    ResendBackoff = "resend-backoff", "contacts", Receipts, Talking,
        "Without receipts, the intervals between transmissions of a message grow exponentially.";
    ResendSame = "resend-same", "contacts", Receipts, Talking,
        "A message that is sent again has the same seq and content.";

    ReceiptNext = "receipt-next", "receipt", Receipts, Talking,
        "Messages below a receipt's next are not sent again.";
    ReceiptHeld = "receipt-held", "receipt", Receipts, Talking,
        "Messages in a receipt's held ranges are not sent again.";
    ReceiptGap = "receipt-gap", "receipt", Receipts, Talking,
        "Messages between a receipt's next and its held ranges are sent again.";
    ReceiptBoot = "receipt-boot", "receipt", Receipts, Talking,
        "A receipt for another boot covers nothing.";
    ContactsBounded = "contacts-bounded", "contacts", Receipts, Assisted,
        "The robot stores a limited number of contacts messages and drops the oldest.";

    SetpointAnswers = "setpoint-answers", "setpoint_state", Every, Talking,
        "An accepted setpoint is answered RECEIVED, then APPLYING, then with one final state.";
    SetpointApplied = "setpoint-applied", "setpoint_state", Every, Talking,
        "A valid setpoint is APPLIED, and the chamber then has its pressure within 0.005 MPa.";
    SetpointInStatus = "setpoint-in-status", "status", Every, Talking,
        "The status shows the setpoint in force as setpoint_mpa.";
    Slew = "slew", "setpoint", Every, Talking,
        "The pressure changes no faster than slew_mpa_per_s.";
    RefuseStaleVersion = "refuse-stale-version", "setpoint", Every, Talking,
        "A version not higher than all versions seen for the whisker in that epoch is REJECTED as STALE.";
    RefuseStaleEpoch = "refuse-stale-epoch", "setpoint", Every, Talking,
        "An epoch below the highest seen for the whisker is REJECTED as STALE, whatever the version.";
    RefuseExpired = "refuse-expired", "setpoint", Every, Talking,
        "A setpoint whose expires_us has passed on the robot's own clock is REJECTED as EXPIRED.";
    RefuseWrongBoot = "refuse-wrong-boot", "setpoint", Every, Talking,
        "A setpoint for another boot is REJECTED as WRONG_BOOT.";
    RefuseOutOfRange = "refuse-out-of-range", "setpoint", Every, Talking,
        "A pressure above the factsheet's pressure_max_mpa is REJECTED as OUT_OF_RANGE.";
    RefuseUnknownWhisker = "refuse-unknown-whisker", "setpoint", Every, Talking,
        "A setpoint for a whisker that is not in the factsheet is REJECTED as UNKNOWN_WHISKER.";
    CommandAgainAnswered = "command-again-answered", "setpoint", Every, Talking,
        "A repeated command_id is answered again, with the state of its setpoint.";
    CommandAgainNotApplied = "command-again-not-applied", "setpoint", Every, Talking,
        "A repeated command_id is not applied again.";
    Supersede = "supersede", "setpoint", Every, Talking,
        "A newer setpoint replaces one that is being applied, which is answered SUPERSEDED.";
    FailedWithReason = "failed-with-reason", "setpoint_state", Every, Assisted,
        "An accepted setpoint that cannot be reached is answered FAILED, with the reason.";
    OnSupervisorLoss = "on-supervisor-loss", "factsheet", Every, Assisted,
        "Without a supervisor the robot behaves as its factsheet's on_supervisor_loss states. Only messages on its own topics \
         show that it has one.";

    TestDone = "test-done", "test_state", Every, Talking,
        "A touch test that the factsheet names is ACCEPTED, and DONE after all its touches, which carry its test_id.";
    TestWrongBoot = "test-wrong-boot", "request", Every, Talking,
        "A touch test for another boot is REJECTED as WRONG_BOOT.";

    EstimateOrder = "estimate-order", "estimate", Every, Assisted,
        "The robot ignores an estimate whose (epoch, version) is not higher than that of the last one that it took in this boot.";
    EstimateLength = "estimate-length", "contacts", Every, Assisted,
        "A robot that divides distances by a length uses length_mm of the newest estimate; before the first one it sends distances.";

    UnknownFields = "unknown-fields", "all", Every, Talking,
        "The robot ignores unknown fields and processes the message.";
    MalformedHarmless = "malformed-harmless", "all", Every, Talking,
        "An invalid message has no effect: the robot continues in the same boot.";
    OwnLevel = "own-level", "all", Every, Relayed,
        "A robot publishes only below its own topic level, and subscribes only there and to supervisor/request of its fleet.";
}

impl Rule {
    /// The rule with this name.
    #[must_use]
    pub fn from_id(id: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|rule| rule.id() == id)
    }
}

impl fmt::Display for Rule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.id())
    }
}
