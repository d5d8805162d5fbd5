//! The work of upkeep, as it is logged and counted.

/// A piece of work that upkeep has done.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Done {
    /// A partition was created.
    Made {
        /// Name of the partition.
        partition: String,
    },
    /// A partition that has ended was indexed.
    Indexed {
        /// Name of the partition.
        partition: String,
    },
    /// A partition was dropped, because all its rows were too old.
    Dropped {
        /// Name of the partition.
        partition: String,
        /// Size of the partition with its indices, bytes.
        bytes: i64,
    },
    /// Rows were deleted, because they were too old.
    Removed {
        /// Name of the table.
        table: &'static str,
        /// Number of rows.
        rows: u64,
    },
}
