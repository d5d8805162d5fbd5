//! Stored or received items that cannot be read. They are set aside, so that the items after them are read: logged, counted,
//! and named in `/readyz` for a while.

/// Who reads the items.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Reader {
    /// Records of the partitioned log.
    Log,
    /// Rows of the journal.
    Journal,
    /// Checkpoints of robots.
    Checkpoint,
    /// The policy in force.
    Policy,
    /// Active calibrations.
    Calibration,
    /// The open roll-out.
    Rollout,
}

impl Reader {
    /// All readers.
    pub(crate) const ALL: [Self; 6] =
        [Self::Log, Self::Journal, Self::Checkpoint, Self::Policy, Self::Calibration, Self::Rollout];

    /// The reader as a label of metrics.
    pub(crate) const fn word(self) -> &'static str {
        match self {
            Self::Log => "LOG",
            Self::Journal => "JOURNAL",
            Self::Checkpoint => "CHECKPOINT",
            Self::Policy => "POLICY",
            Self::Calibration => "CALIBRATION",
            Self::Rollout => "ROLLOUT",
        }
    }
}
