//! Words of the contract that requests may name.

/// A closed enum of words, as JSON and the database write them.
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
    /// Mechanical condition of a whisker.
    pub enum ConditionWord {
        /// Cold start.
        Learning = "LEARNING",
        /// As the factsheet says.
        Healthy = "HEALTHY",
        /// An alarm of the detector is being looked into.
        Suspected = "SUSPECTED",
        /// Shorter than whole, by a cut.
        Trimmed = "TRIMMED",
        /// Becoming shorter.
        Eroding = "ERODING",
        /// Less sensitive, which no trim explains.
        SensitivityLoss = "SENSITIVITY_LOSS",
    }
}

words! {
    /// Length of the spans of time that contacts are added up over.
    pub enum ResolutionWord {
        /// Minutes.
        Minute = "minute",
        /// Hours.
        Hour = "hour",
    }
}

words! {
    /// Whether a robot is connected.
    pub enum ConnectionWord {
        /// It is.
        Online = "ONLINE",
        /// It has signed off, or was never there.
        Offline = "OFFLINE",
        /// It has fallen silent.
        ConnectionBroken = "CONNECTION_BROKEN",
    }
}

words! {
    /// Case of the paper.
    pub enum CaseWord {
        /// The broken whisker itself, at another pressure.
        SelfCompensation = "SELF_COMPENSATION",
        /// A shorter neighbour.
        ShorterForLonger = "SHORTER_FOR_LONGER",
        /// A longer neighbour.
        LongerForShorter = "LONGER_FOR_SHORTER",
    }
}

words! {
    /// How far a setpoint is.
    pub enum SetpointStateWord {
        /// Decided, not answered yet.
        Pending = "PENDING",
        /// The robot has it.
        Received = "RECEIVED",
        /// The robot is moving there.
        Applying = "APPLYING",
        /// The robot is there.
        Applied = "APPLIED",
        /// The robot will not take it.
        Rejected = "REJECTED",
        /// The robot could not reach it.
        Failed = "FAILED",
        /// A newer one took its place.
        Superseded = "SUPERSEDED",
        /// No answer in time.
        Expired = "EXPIRED",
        /// The robot started anew before it answered.
        Abandoned = "ABANDONED",
    }
}

words! {
    /// What a change of health is of.
    pub enum HealthKindWord {
        /// Of the mechanical condition.
        Condition = "CONDITION",
        /// Of the fault.
        Fault = "FAULT",
    }
}

words! {
    /// What people are told of.
    pub enum AlarmKindWord {
        /// A trimmed whisker that no one can serve.
        Uncompensated = "UNCOMPENSATED",
        /// A compensation that waits for approval.
        Proposed = "PROPOSED",
        /// A setpoint that was given up.
        SetpointFailed = "SETPOINT_FAILED",
        /// A whisker that feels less, which no trim explains.
        SensitivityLoss = "SENSITIVITY_LOSS",
        /// A whisker that becomes shorter.
        Eroding = "ERODING",
        /// A change that a whole array feels.
        ArrayShift = "ARRAY_SHIFT",
        /// A gauge whose baseline is off.
        BaselineDrift = "BASELINE_DRIFT",
        /// A whisker that is silent.
        Stale = "STALE",
        /// A gauge that is open.
        GaugeOpen = "GAUGE_OPEN",
        /// A gauge with a short circuit.
        GaugeShort = "GAUGE_SHORT",
        /// A gauge at its limit.
        GaugeSaturated = "GAUGE_SATURATED",
        /// A gauge that is not to be trusted.
        Gauge = "GAUGE",
        /// A pressure that is not held.
        Leak = "LEAK",
        /// A regulator that is out of order.
        Regulator = "REGULATOR",
        /// Too little air.
        SupplyLow = "SUPPLY_LOW",
    }
}

words! {
    /// What there is to do about an alarm.
    pub enum AlarmStateWord {
        /// To look at it.
        Unacknowledged = "UNACKNOWLEDGED",
        /// Somebody has seen it.
        Acknowledged = "ACKNOWLEDGED",
        /// It shall be quiet for a while.
        Shelved = "SHELVED",
        /// Its cause is over.
        Cleared = "CLEARED",
    }
}

words! {
    /// Who has said that a compensation begins.
    pub enum ApprovalWord {
        /// Nobody was asked.
        Automatic = "AUTOMATIC",
        /// It waits for somebody's word.
        Proposed = "PROPOSED",
        /// An operator said yes.
        Approved = "APPROVED",
        /// An operator said no.
        Refused = "REFUSED",
    }
}
