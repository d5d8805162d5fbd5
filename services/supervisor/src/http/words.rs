//! Enumerations of the API, in the words of the contract.
//!
//! Those of the core are [`OneOf`] its words, as `vibrissa_edge::words` declares them; the others are declared here.

pub use crate::one_of::*;

/// Defines an enumeration with its words in JSON and in the database.
macro_rules! words {
    ($(#[$meta:meta])* pub enum $name:ident { $($(#[$variant_meta:meta])* $variant:ident = $word:tt,)+ }) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize, serde::Serialize, utoipa::ToSchema)]
        pub enum $name { $($(#[$variant_meta])* #[serde(rename = $word)] $variant,)+ }

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(match self { $(Self::$variant => $word,)+ })
            }
        }
    };
}
pub(super) use words;

words! {
    /// Format of a list.
    pub enum FormatWord {
        /// A page as a JSON object.
        Json = "json",
        /// Rows as comma-separated values (RFC 4180) with a header row.
        Csv = "csv",
    }
}

words! {
    /// State of a robot on the board, the worst first. Each robot is in one of them, so that their numbers add up.
    pub enum RobotStateWord {
        /// A trimmed whisker has no compensation.
        Uncompensated = "UNCOMPENSATED",
        /// A whisker has a fault.
        Faulty = "FAULTY",
        /// Its connection has broken: nothing is known of its whiskers.
        ConnectionBroken = "CONNECTION_BROKEN",
        /// It is connected, but not heard.
        Silent = "SILENT",
        /// Another alarm stands.
        Alarm = "ALARM",
        /// A whisker is worn or suspected.
        Worn = "WORN",
        /// It has announced that it leaves.
        Offline = "OFFLINE",
        /// All trimmed whiskers are compensated.
        Compensated = "COMPENSATED",
        /// Whiskers are being learned.
        Learning = "LEARNING",
        /// All whiskers are healthy.
        Healthy = "HEALTHY",
    }
}

words! {
    /// Length of the intervals over which contacts are aggregated.
    pub enum ResolutionWord {
        /// Intervals of one minute.
        Minute = "minute",
        /// Intervals of one hour.
        Hour = "hour",
    }
}

words! {
    /// Kind of a health change.
    pub enum HealthKindWord {
        /// Change of the mechanical condition.
        Condition = "CONDITION",
        /// Change of the fault.
        Fault = "FAULT",
    }
}

words! {
    /// State of an alarm.
    pub enum AlarmStateWord {
        /// Not acknowledged yet.
        Unacknowledged = "UNACKNOWLEDGED",
        /// Acknowledged by an operator.
        Acknowledged = "ACKNOWLEDGED",
        /// Silenced for a limited time.
        Shelved = "SHELVED",
        /// The cause is gone.
        Cleared = "CLEARED",
    }
}

words! {
    /// Approval state of a compensation.
    pub enum ApprovalWord {
        /// Started without approval (mode automatic).
        Automatic = "AUTOMATIC",
        /// Waits for an operator's approval.
        Proposed = "PROPOSED",
        /// Approved by an operator.
        Approved = "APPROVED",
        /// Refused by an operator.
        Refused = "REFUSED",
    }
}
