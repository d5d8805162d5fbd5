//! The closed lists of words in messages.

use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Defines a closed list of words: the enum, its texts, and all of them in order.
macro_rules! words {
    ($(#[$doc:meta])* $name:ident { $($(#[$word_doc:meta])* $variant:ident = $word:literal,)+ }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema)]
        #[schemars(inline)]
        pub enum $name {
            $($(#[$word_doc])* #[serde(rename = $word)] $variant,)+
        }

        impl $name {
            /// Every word, in order.
            pub const ALL: &[Self] = &[$(Self::$variant),+];

            /// The word as it is in messages.
            #[must_use]
            pub const fn as_str(self) -> &'static str {
                match self {
                    $(Self::$variant => $word,)+
                }
            }

            /// The variant of a word, if it is one of the list.
            #[must_use]
            pub fn from_word(word: &str) -> Option<Self> {
                Self::ALL.iter().copied().find(|known| known.as_str() == word)
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
    /// Whether a robot is there.
    ConnectionState {
        /// Connected.
        Online = "ONLINE",
        /// Left in good order.
        Offline = "OFFLINE",
        /// The broker's word that the connection broke (the last will).
        ConnectionBroken = "CONNECTION_BROKEN",
    }
);
words!(
    /// Whether a supervisor owns the fleet.
    SupervisorPresence {
        /// Connected.
        Online = "ONLINE",
        /// Left, or its connection broke.
        Offline = "OFFLINE",
    }
);
words!(
    /// What a whisker array can do about a shortened whisker.
    ArrayType {
        /// An array: a neighbour compensates for the shortened whisker, or the shortened whisker itself does.
        Type1 = "TYPE_1",
        /// Single whiskers: the shortened whisker compensates for itself.
        Type2 = "TYPE_2",
    }
);
words!(
    /// What a robot does with its chambers when the supervisor is gone.
    OnSupervisorLoss {
        /// Keep the last setpoint.
        Hold = "HOLD",
        /// Go back to the factsheet's pressure.
        Nominal = "NOMINAL",
        /// Let the air out.
        Vent = "VENT",
    }
);
words!(
    /// The condition of a chamber's pressure regulator.
    Regulator {
        /// Holds its setpoint.
        Ok = "OK",
        /// On its way up.
        Filling = "FILLING",
        /// On its way down.
        Venting = "VENTING",
        /// The supply cannot give the setpoint.
        SupplyLow = "SUPPLY_LOW",
        /// Air is lost faster than a tight chamber loses it.
        Leak = "LEAK",
        /// Does not work.
        Fault = "FAULT",
    }
);
words!(
    /// The condition of a strain gauge.
    Gauge {
        /// Reads.
        Ok = "OK",
        /// At the end of its range.
        Saturated = "SATURATED",
        /// Its circuit is broken.
        Open = "OPEN",
        /// Its circuit is shorted.
        Short = "SHORT",
    }
);
words!(
    /// Why the supervisor sets a pressure.
    SetpointReason {
        /// A shortened whisker regains its own sensitivity.
        SelfCompensation = "SELF_COMPENSATION",
        /// A shorter neighbour takes the place of a longer target.
        ShorterForLonger = "SHORTER_FOR_LONGER",
        /// A longer neighbour takes the place of a shorter target.
        LongerForShorter = "LONGER_FOR_SHORTER",
        /// A correction from what was measured since.
        Refinement = "REFINEMENT",
        /// Back to the factsheet's pressure.
        Release = "RELEASE",
        /// A person asked for it.
        Operator = "OPERATOR",
    }
);
words!(
    /// What became of a setpoint.
    SetpointOutcome {
        /// Taken, not yet begun.
        Received = "RECEIVED",
        /// The chamber is on its way.
        Applying = "APPLYING",
        /// The chamber holds the pressure.
        Applied = "APPLIED",
        /// Not taken, for the reason in `error`.
        Rejected = "REJECTED",
        /// Taken but not reached, for the reason in `error`.
        Failed = "FAILED",
        /// Replaced by a newer one while it was being applied.
        Superseded = "SUPERSEDED",
    }
);
words!(
    /// Why a setpoint was rejected or failed.
    SetpointError {
        /// Rejected: (`epoch`, `version`) is not higher than any seen for that whisker.
        Stale = "STALE",
        /// Rejected: `expires_us` has passed on the robot's clock.
        Expired = "EXPIRED",
        /// Rejected: the pressure is not in the factsheet's range.
        OutOfRange = "OUT_OF_RANGE",
        /// Rejected: the robot has no such whisker.
        UnknownWhisker = "UNKNOWN_WHISKER",
        /// Rejected: it was meant for another boot of the robot.
        WrongBoot = "WRONG_BOOT",
        /// Rejected: the robot cannot take setpoints now.
        NotReady = "NOT_READY",
        /// Failed: the supply cannot give the pressure.
        SupplyLow = "SUPPLY_LOW",
        /// Failed: the chamber loses more air than the valve gives.
        Leak = "LEAK",
        /// Failed: the regulator does not work.
        Fault = "FAULT",
    }
);
words!(
    /// What a robot is asked to send again.
    RequestKind {
        /// Its factsheet.
        Factsheet = "FACTSHEET",
        /// Its status.
        Status = "STATUS",
    }
);

impl SetpointOutcome {
    /// Whether it must say why.
    #[must_use]
    pub const fn needs_error(self) -> bool {
        match self {
            Self::Rejected | Self::Failed => true,
            Self::Received | Self::Applying | Self::Applied | Self::Superseded => false,
        }
    }

    /// Whether nothing follows it.
    #[must_use]
    pub const fn is_final(self) -> bool {
        match self {
            Self::Applied | Self::Rejected | Self::Failed | Self::Superseded => true,
            Self::Received | Self::Applying => false,
        }
    }
}
