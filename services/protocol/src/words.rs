//! Closed lists of words in messages.

use std::fmt;

use serde::de::{Error, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

/// Defines a closed list of words: the enum, the word of each variant, and the list of all in order.
macro_rules! words {
    ($(#[$doc:meta])* $name:ident { $($(#[$word_doc:meta])* $variant:ident = $word:literal,)+ }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
        #[cfg_attr(feature = "documents", derive(schemars::JsonSchema))]
        #[cfg_attr(feature = "documents", schemars(inline))]
        pub enum $name {
            $($(#[$word_doc])* #[serde(rename = $word)] $variant,)+
        }

        impl $name {
            /// All words, in order.
            pub const ALL: &[Self] = &[$(Self::$variant),+];

            /// The word as written in messages.
            #[must_use]
            pub const fn as_str(self) -> &'static str {
                match self {
                    $(Self::$variant => $word,)+
                }
            }

            /// The variant of a word, if the list contains it.
            #[must_use]
            pub fn from_word(word: &str) -> Option<Self> {
                Self::ALL.iter().copied().find(|known| known.as_str() == word)
            }
        }

        // A derived reader would take an object with the word as its key, too.
        impl<'de> Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                struct Word;
                impl Visitor<'_> for Word {
                    type Value = $name;
                    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                        f.write_str(concat!("a word of ", stringify!($name)))
                    }
                    fn visit_str<E: Error>(self, word: &str) -> Result<$name, E> {
                        $name::from_word(word).ok_or_else(|| E::unknown_variant(word, &[$($word),+]))
                    }
                }
                deserializer.deserialize_str(Word)
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.pad(self.as_str())
            }
        }
    };
}

words!(
    /// State of a robot's connection.
    ConnectionState {
        /// The robot is connected.
        Online = "ONLINE",
        /// The robot has disconnected deliberately.
        Offline = "OFFLINE",
        /// The connection broke; the broker publishes this as the last will.
        ConnectionBroken = "CONNECTION_BROKEN",
    }
);
words!(
    /// Whether a supervisor owns the fleet.
    SupervisorPresence {
        /// A supervisor owns the fleet and is connected.
        Online = "ONLINE",
        /// The supervisor has left, or its connection broke.
        Offline = "OFFLINE",
    }
);
words!(
    /// Ways in which a whisker array can compensate for a shortened whisker.
    ArrayType {
        /// A neighbour or the shortened whisker itself compensates.
        Type1 = "TYPE_1",
        /// Single whiskers: only the shortened whisker itself compensates.
        Type2 = "TYPE_2",
    }
);
words!(
    /// Ways in which a robot can change the pressure of its chambers.
    AirControl {
        /// It has a supply, and vents.
        FillAndVent = "FILL_AND_VENT",
        /// It can only vent: no setpoint is above the factsheet's `pressure_mpa`.
        VentOnly = "VENT_ONLY",
        /// It cannot change the pressure: each setpoint has the factsheet's `pressure_mpa`, and a gain.
        None = "NONE",
    }
);
words!(
    /// Kinds of programs of a robot.
    SoftwareKind {
        /// It keeps the contract.
        Agent = "AGENT",
        /// It reads sensors and moves valves, on a computer.
        Driver = "DRIVER",
        /// It does so on a board.
        Firmware = "FIRMWARE",
    }
);
words!(
    /// Behaviour of a robot's chambers without a supervisor.
    OnSupervisorLoss {
        /// Keep the last setpoint.
        Hold = "HOLD",
        /// Return to the factsheet's pressure.
        Nominal = "NOMINAL",
        /// Vent the chambers.
        Vent = "VENT",
    }
);
words!(
    /// Condition of a chamber's pressure regulator.
    Regulator {
        /// The regulator holds its setpoint.
        Ok = "OK",
        /// The regulator raises the pressure.
        Filling = "FILLING",
        /// The regulator lowers the pressure.
        Venting = "VENTING",
        /// The supply cannot provide the setpoint.
        SupplyLow = "SUPPLY_LOW",
        /// The chamber loses air faster than a tight one.
        Leak = "LEAK",
        /// The regulator does not work.
        Fault = "FAULT",
    }
);
words!(
    /// How far contacts can be relied on that a robot finds in samples of strain.
    Segmenter {
        /// Something is missing to report contacts: samples, stillness, or evidence which strain is rest.
        Learning = "LEARNING",
        /// Rest was known and is in doubt: contacts are held back.
        Lost = "LOST",
        /// The last contact was beyond the gauge's limit.
        Clipped = "CLIPPED",
        /// The whisker shakes, or the converter has many glitches: only strong touches are found.
        Noisy = "NOISY",
        /// Touches go the other way: the gauge's wires are swapped.
        Inverted = "INVERTED",
        /// Contacts are reported as they end.
        Ready = "READY",
    }
);
words!(
    /// Condition of a strain gauge.
    Gauge {
        /// The gauge works.
        Ok = "OK",
        /// The gauge is at the end of its range.
        Saturated = "SATURATED",
        /// The gauge's circuit is open.
        Open = "OPEN",
        /// The gauge's circuit is shorted.
        Short = "SHORT",
    }
);
words!(
    /// Reason of a setpoint.
    SetpointReason {
        /// A shortened whisker regains its own sensitivity.
        SelfCompensation = "SELF_COMPENSATION",
        /// A shorter neighbour compensates for a longer target.
        ShorterForLonger = "SHORTER_FOR_LONGER",
        /// A longer neighbour compensates for a shorter target.
        LongerForShorter = "LONGER_FOR_SHORTER",
        /// A correction from measurements since the compensation began.
        Refinement = "REFINEMENT",
        /// Return to the factsheet's pressure.
        Release = "RELEASE",
        /// An operator requested it.
        Operator = "OPERATOR",
    }
);
words!(
    /// Progress or result of a setpoint.
    SetpointOutcome {
        /// Accepted, not started.
        Received = "RECEIVED",
        /// The chamber is moving toward the pressure.
        Applying = "APPLYING",
        /// The chamber has reached the pressure.
        Applied = "APPLIED",
        /// Not accepted, for the reason in `error`.
        Rejected = "REJECTED",
        /// Accepted but not reached, for the reason in `error`.
        Failed = "FAILED",
        /// Replaced by a newer one while it was being applied.
        Superseded = "SUPERSEDED",
    }
);
words!(
    /// Reason why a setpoint was rejected or failed.
    SetpointError {
        /// Rejected: (`epoch`, `version`) is not higher than all seen for that whisker.
        Stale = "STALE",
        /// Rejected: `expires_us` has passed on the robot's clock.
        Expired = "EXPIRED",
        /// Rejected: the pressure is outside the factsheet's range.
        OutOfRange = "OUT_OF_RANGE",
        /// Rejected: the robot has no such whisker.
        UnknownWhisker = "UNKNOWN_WHISKER",
        /// Rejected: it is for another boot of the robot.
        WrongBoot = "WRONG_BOOT",
        /// Rejected: the robot cannot accept setpoints now.
        NotReady = "NOT_READY",
        /// Rejected: the robot is in a task, and takes no setpoint before its end. The supervisor tries again, in
        /// pauses of 4 s to 5 minutes. That is no failure, however long the task takes.
        InTask = "IN_TASK",
        /// Failed: the supply cannot provide the pressure.
        SupplyLow = "SUPPLY_LOW",
        /// Failed: the chamber loses more air than the valve supplies.
        Leak = "LEAK",
        /// Failed: the regulator does not work.
        Fault = "FAULT",
    }
);
words!(
    /// Mechanical condition of a whisker.
    WhiskerCondition {
        /// The supervisor is learning the whisker's calibration; its length is still that of the factsheet.
        Learning = "LEARNING",
        /// As long and as sensitive as at its installation.
        Healthy = "HEALTHY",
        /// A change is suspected: the length may be outdated.
        Suspected = "SUSPECTED",
        /// Shorter by a cut.
        Trimmed = "TRIMMED",
        /// Becoming shorter by wear.
        Eroding = "ERODING",
        /// Less sensitive, which no cut explains.
        SensitivityLoss = "SENSITIVITY_LOSS",
    }
);
words!(
    /// Message that a robot shall send again.
    RequestKind {
        /// The robot's factsheet.
        Factsheet = "FACTSHEET",
        /// The robot's status.
        Status = "STATUS",
        /// No message, but the touch test in `touch_test`.
        TouchTest = "TOUCH_TEST",
    }
);
words!(
    /// Messages that all robots of a fleet shall send.
    SupervisorRequestKind {
        /// `connection` with `ONLINE` and then `factsheet`, in the present boot, within 2 s at a random time.
        Birth = "BIRTH",
    }
);
words!(
    /// Place of a contact on the whisker, as far as a robot can know it.
    PlaceKind {
        /// Contact distance / present length.
        Ratio = "RATIO",
        /// Distance from the base.
        Distance = "DISTANCE",
        /// The tip, with or without its distance from the base.
        Tip = "TIP",
        /// Somewhere on the whisker.
        Unknown = "UNKNOWN",
    }
);
words!(
    /// Use of an array's readings.
    Task {
        /// Readings are compared at equal contact ratio: a cut whisker needs another pressure.
        Ratio = "RATIO",
        /// Readings are compared at equal distance from the base: a cut whisker reads as before and has lost reach.
        Distance = "DISTANCE",
    }
);
words!(
    /// Kind of a touch test.
    TouchTestKind {
        /// Sweep an object so that the contact leaves over the tip. The contacts have `tip`, and `distance_mm` if the robot
        /// can measure it.
        Tip = "TIP",
        /// Press against a known surface at the given distances and deflections. The contacts have `distance_mm`; the list
        /// `missed` has the touches that did not come.
        Wall = "WALL",
    }
);
words!(
    /// Reason of a touch test.
    TouchTestReason {
        /// Contacts near the tip have failed to come, or a touch was missed.
        Suspicion = "SUSPICION",
        /// A setpoint of a compensation was applied: its error is to be measured.
        Setpoint = "SETPOINT",
        /// An operator requested it.
        Operator = "OPERATOR",
        /// The whisker was not touched for long, or the robot has started anew.
        Pause = "PAUSE",
        /// The interval since the last test is over.
        Schedule = "SCHEDULE",
        /// The whisker became more sensitive, and its contacts leave open whether it was cut.
        Change = "CHANGE",
    }
);
words!(
    /// Progress or result of a touch test.
    TouchTestOutcome {
        /// The robot will do it.
        Accepted = "ACCEPTED",
        /// The robot is at it.
        Running = "RUNNING",
        /// All contacts and missed touches are sent.
        Done = "DONE",
        /// Not accepted, for the reason in `error`.
        Rejected = "REJECTED",
        /// Accepted and not finished.
        Failed = "FAILED",
    }
);
words!(
    /// Reason why a touch test was rejected.
    TouchTestError {
        /// The robot cannot test now.
        NotReady = "NOT_READY",
        /// (`epoch`, `version`) is not higher than all seen for that whisker.
        Stale = "STALE",
        /// `expires_us` has passed on the robot's clock.
        Expired = "EXPIRED",
        /// The robot has no such whisker.
        UnknownWhisker = "UNKNOWN_WHISKER",
        /// It is for another boot of the robot.
        WrongBoot = "WRONG_BOOT",
        /// The robot is in a task, and tests nothing before its end.
        InTask = "IN_TASK",
    }
);

impl SetpointOutcome {
    /// Whether the outcome requires a reason in `error`.
    #[must_use]
    pub const fn needs_error(self) -> bool {
        match self {
            Self::Rejected | Self::Failed => true,
            Self::Received | Self::Applying | Self::Applied | Self::Superseded => false,
        }
    }

    /// Whether no further state follows.
    #[must_use]
    pub const fn is_final(self) -> bool {
        match self {
            Self::Applied | Self::Rejected | Self::Failed | Self::Superseded => true,
            Self::Received | Self::Applying => false,
        }
    }
}
