//! What the contract asks of a robot, rule by rule: each has a name that stays the same, so that tools, tests and people
//! speak of the same thing.
//!
//! `vibrissa check-robot` tests a robot against them, and the simulator can break each one on purpose.

mod table;

use std::fmt;

pub use table::markdown;

/// Of which robots it is asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Scope {
    /// Of every robot.
    Every,
    /// Of robots that send contacts again until they are receipted, which is to say: with quality of service 0.
    Receipts,
}

/// How it can be seen from outside whether a robot keeps it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Visible {
    /// By talking to the robot.
    Talking,
    /// Only while somebody takes the robot's power away and gives it back.
    Restarting,
    /// Not at all, for this reason.
    Not(&'static str),
}

/// Defines the rules: the enum, and what each one is.
macro_rules! rules {
    ($($variant:ident = $id:literal, $topic:literal, $scope:ident, $visible:expr, $asked:literal;)+) => {
        /// A rule that a robot must keep.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Rule {
            $(#[doc = $asked] $variant,)+
        }

        impl Rule {
            /// Every rule, in the order of the contract's topics.
            pub const ALL: &[Self] = &[$(Self::$variant),+];

            /// Its name, in kebab case; it never changes.
            #[must_use]
            pub const fn id(self) -> &'static str {
                match self { $(Self::$variant => $id,)+ }
            }

            /// The topic that it is about.
            #[must_use]
            pub const fn topic(self) -> &'static str {
                match self { $(Self::$variant => $topic,)+ }
            }

            /// Of which robots it is asked.
            #[must_use]
            pub const fn scope(self) -> Scope {
                match self { $(Self::$variant => Scope::$scope,)+ }
            }

            /// How it can be seen from outside.
            #[must_use]
            pub const fn visible(self) -> Visible {
                match self { $(Self::$variant => $visible,)+ }
            }

            /// What is asked, in one sentence.
            #[must_use]
            pub const fn asked(self) -> &'static str {
                match self { $(Self::$variant => $asked,)+ }
            }
        }
    };
}

use Visible::{Not, Restarting, Talking};

rules! {
    Birth = "birth", "connection", Every, Talking,
        "After it has connected and subscribed, the robot says ONLINE, retained.";
    Will = "will", "connection", Every, Restarting,
        "The last will says CONNECTION_BROKEN with the boot_id of the birth of the same connection.";
    WillRetained = "will-retained", "connection", Every, Restarting,
        "The last will is retained.";
    BootIdNew = "boot-id-new", "connection", Every, Restarting,
        "Each start of the robot has a boot_id that none before had.";
    Farewell = "farewell", "connection", Every, Not("nothing that is sent to a robot makes it leave"),
        "A robot that leaves in good order says OFFLINE, retained, before it disconnects.";

    FactsheetAfterBirth = "factsheet-after-birth", "factsheet", Every, Talking,
        "The factsheet follows each birth.";
    FactsheetRetained = "factsheet-retained", "factsheet", Every, Talking,
        "The factsheet is retained.";
    FactsheetOnRequest = "factsheet-on-request", "factsheet", Every, Talking,
        "The factsheet is sent again when request asks for FACTSHEET.";

    StatusPeriod = "status-period", "status", Every, Talking,
        "A status comes every 1 to 10 s, also if nothing changes.";
    StatusOnRequest = "status-on-request", "status", Every, Talking,
        "A status is sent when request asks for STATUS.";
    StatusWhiskers = "status-whiskers", "status", Every, Talking,
        "A status names each whisker of the factsheet once, and no other.";
    StatusOnChange = "status-on-change", "status", Every, Not("only the robot knows when its regulators and gauges change"),
        "A status is sent when the condition of a regulator or a gauge changes.";
    ContactsDropped = "contacts-dropped", "status", Receipts, Not("a robot's memory cannot be filled in a reasonable time"),
        "Contacts messages that were dropped because too many were kept are counted in contacts_dropped.";

    MessageForm = "message-form", "all", Every, Talking,
        "Every message is JSON in UTF-8 with all fields of its kind, and words and names as the contract has them.";
    SeqWithoutGaps = "seq-without-gaps", "all", Every, Talking,
        "In a boot, seq grows by one from message to message of a topic, and names one message only.";
    SeqFromZero = "seq-from-zero", "all", Every, Restarting,
        "In each boot the first message of a topic has seq 0.";
    Clock = "clock", "all", Every, Talking,
        "Times are of the present: microseconds since 1970 UTC, or RFC 3339 in UTC, right to 2 s.";
    TimeForward = "time-forward", "all", Every, Talking,
        "In a boot, the times of status, setpoint_state and factsheet do not run backwards.";
    QualityOfService = "qos", "all", Every, Talking,
        "Quality of service is 1 for connection, factsheet and setpoint_state, 0 for status, and 0 or 1 for contacts.";
    NotRetained = "not-retained", "all", Every, Talking,
        "Contacts, status and setpoint_state are not retained.";

    ContactsInRange = "contacts-in-range", "contacts", Every, Talking,
        "The numbers of a contact are ones that there can be: ratio from 0.01 to 1, deflection from 0.01 mm on, and so on.";
    ContactsOnFactsheet = "contacts-on-factsheet", "contacts", Every, Talking,
        "Contacts are of whiskers that are on the factsheet.";
    ContactsResent = "contacts-resent", "contacts", Receipts, Talking,
        "A contacts message that no receipt covers is sent again.";
    ResendOldestFirst = "resend-oldest-first", "contacts", Receipts, Talking,
        "Of the messages to be sent again the oldest goes first.";
    ResendBackoff = "resend-backoff", "contacts", Receipts, Talking,
        "While no receipt comes, the pauses between two sendings of a message grow exponentially.";
    ResendSame = "resend-same", "contacts", Receipts, Talking,
        "What is sent again has the same seq and the same content.";

    ReceiptNext = "receipt-next", "receipt", Receipts, Talking,
        "What lies below a receipt's next is not sent again.";
    ReceiptHeld = "receipt-held", "receipt", Receipts, Talking,
        "What lies in a receipt's held ranges is not sent again.";
    ReceiptGap = "receipt-gap", "receipt", Receipts, Talking,
        "What lies between a receipt's next and its held ranges is sent again.";
    ReceiptBoot = "receipt-boot", "receipt", Receipts, Talking,
        "A receipt for another boot covers nothing.";
    ContactsBounded = "contacts-bounded", "contacts", Receipts, Not("a robot's memory cannot be filled in a reasonable time"),
        "A bounded number of contacts messages is kept, of which the oldest are dropped.";

    SetpointAnswers = "setpoint-answers", "setpoint_state", Every, Talking,
        "A setpoint that is taken is answered RECEIVED, then APPLYING, then with one final state.";
    SetpointApplied = "setpoint-applied", "setpoint_state", Every, Talking,
        "A setpoint that is right is APPLIED, and the chamber then has its pressure within 0.005 MPa.";
    SetpointInStatus = "setpoint-in-status", "status", Every, Talking,
        "The status shows the setpoint in force as setpoint_mpa.";
    Slew = "slew", "setpoint", Every, Talking,
        "The pressure changes no faster than slew_mpa_per_s.";
    RefuseStaleVersion = "refuse-stale-version", "setpoint", Every, Talking,
        "A version that is not higher than any seen for the whisker in that epoch is REJECTED as STALE.";
    RefuseStaleEpoch = "refuse-stale-epoch", "setpoint", Every, Talking,
        "An epoch below the highest seen for the whisker is REJECTED as STALE, whatever the version.";
    RefuseExpired = "refuse-expired", "setpoint", Every, Talking,
        "A setpoint whose expires_us has passed on the robot's own clock is REJECTED as EXPIRED.";
    RefuseWrongBoot = "refuse-wrong-boot", "setpoint", Every, Talking,
        "A setpoint for another boot is REJECTED as WRONG_BOOT.";
    RefuseOutOfRange = "refuse-out-of-range", "setpoint", Every, Talking,
        "A pressure above the factsheet's pressure_max_mpa is REJECTED as OUT_OF_RANGE.";
    RefuseUnknownWhisker = "refuse-unknown-whisker", "setpoint", Every, Talking,
        "A setpoint for a whisker that is not on the factsheet is REJECTED as UNKNOWN_WHISKER.";
    CommandAgainAnswered = "command-again-answered", "setpoint", Every, Talking,
        "The same command_id again is answered again, with what became of it.";
    CommandAgainNotApplied = "command-again-not-applied", "setpoint", Every, Talking,
        "The same command_id again is not applied again.";
    Supersede = "supersede", "setpoint", Every, Talking,
        "A newer setpoint takes the place of one that is being applied, which is answered SUPERSEDED.";
    FailedWithReason = "failed-with-reason", "setpoint_state", Every, Not("supply and chambers cannot be broken from outside"),
        "A setpoint that was taken and cannot be reached is answered FAILED, with the reason.";
    OnSupervisorLoss = "on-supervisor-loss", "factsheet", Every, Not("when the supervisor counts as lost is the robot's affair"),
        "Without a supervisor the robot does what its factsheet's on_supervisor_loss says.";

    UnknownFields = "unknown-fields", "all", Every, Talking,
        "Fields that the robot does not know are ignored, and the message counts.";
    MalformedHarmless = "malformed-harmless", "all", Every, Talking,
        "A message that cannot be read changes nothing: the robot goes on, in the same boot.";
    OwnLevel = "own-level", "all", Every, Not("what a user may do is the broker's access list's to say"),
        "A robot publishes and subscribes below its own level only.";
}

impl Rule {
    /// The rule of that name.
    #[must_use]
    pub fn from_id(id: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|rule| rule.id() == id)
    }

    /// Whether it can be tested from outside.
    #[must_use]
    pub const fn is_testable(self) -> bool {
        match self.visible() {
            Visible::Talking | Visible::Restarting => true,
            Visible::Not(_) => false,
        }
    }
}

impl fmt::Display for Rule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.id())
    }
}
