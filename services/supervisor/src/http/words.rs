//! Enumerations of the API, in the words of the contract.

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
    /// Mechanical condition of a whisker.
    pub enum ConditionWord {
        /// Baseline is still being learned (cold start).
        Learning = "LEARNING",
        /// No trim, erosion or sensitivity loss detected.
        Healthy = "HEALTHY",
        /// The detector has raised an alarm that is not confirmed yet.
        Suspected = "SUSPECTED",
        /// Shortened by a cut.
        Trimmed = "TRIMMED",
        /// Shortening gradually (erosion).
        Eroding = "ERODING",
        /// Sensitivity loss that no trim explains.
        SensitivityLoss = "SENSITIVITY_LOSS",
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
    /// Connection state of a robot.
    pub enum ConnectionWord {
        /// The robot is connected.
        Online = "ONLINE",
        /// Signed off, or never connected.
        Offline = "OFFLINE",
        /// Connection lost without sign-off.
        ConnectionBroken = "CONNECTION_BROKEN",
    }
}

words! {
    /// Compensation case of the paper.
    pub enum CaseWord {
        /// The trimmed whisker compensates for itself at another pressure.
        SelfCompensation = "SELF_COMPENSATION",
        /// A shorter neighbour compensates for a longer target.
        ShorterForLonger = "SHORTER_FOR_LONGER",
        /// A longer neighbour compensates for a shorter target.
        LongerForShorter = "LONGER_FOR_SHORTER",
    }
}

words! {
    /// Progress of a setpoint.
    pub enum SetpointStateWord {
        /// Decided; the robot has not answered yet.
        Pending = "PENDING",
        /// The robot has received it.
        Received = "RECEIVED",
        /// The robot is changing the pressure.
        Applying = "APPLYING",
        /// The robot has reached the pressure.
        Applied = "APPLIED",
        /// The robot has rejected it.
        Rejected = "REJECTED",
        /// The robot could not reach the pressure.
        Failed = "FAILED",
        /// Replaced by a newer setpoint.
        Superseded = "SUPERSEDED",
        /// The robot did not answer in time.
        Expired = "EXPIRED",
        /// The robot restarted before it answered.
        Abandoned = "ABANDONED",
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
    /// Kind of alarm.
    pub enum AlarmKindWord {
        /// A trimmed whisker has no possible compensator.
        Uncompensated = "UNCOMPENSATED",
        /// A compensation waits for approval.
        Proposed = "PROPOSED",
        /// A setpoint was given up.
        SetpointFailed = "SETPOINT_FAILED",
        /// A whisker has a sensitivity loss that no trim explains.
        SensitivityLoss = "SENSITIVITY_LOSS",
        /// A whisker is eroding.
        Eroding = "ERODING",
        /// Most healthy whiskers of an array share a shift.
        ArrayShift = "ARRAY_SHIFT",
        /// The baseline of a strain gauge has drifted.
        BaselineDrift = "BASELINE_DRIFT",
        /// A whisker has been silent for too long.
        Stale = "STALE",
        /// Open circuit in a strain gauge.
        GaugeOpen = "GAUGE_OPEN",
        /// Short circuit in a strain gauge.
        GaugeShort = "GAUGE_SHORT",
        /// A strain gauge is saturated.
        GaugeSaturated = "GAUGE_SATURATED",
        /// A strain gauge is unreliable.
        Gauge = "GAUGE",
        /// A chamber does not hold its pressure.
        Leak = "LEAK",
        /// Fault of a pressure regulator.
        Regulator = "REGULATOR",
        /// The supply pressure is too low.
        SupplyLow = "SUPPLY_LOW",
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
