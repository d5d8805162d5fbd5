//! Reasons for refusing a message.

use crate::name::BadName;
use crate::plain;

/// Why a message was refused: a closed set, so that each kind is counted under its label.
///
/// The text names the field, its value and the permitted values, for the developer of the sender.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// The topic is not part of the contract.
    #[error("{topic:?} is not a topic of this contract: {expected}")]
    UnknownTopic {
        /// The topic, truncated.
        topic: String,
        /// Form of valid topics.
        expected: &'static str,
    },
    /// A level of the topic is not a valid name.
    #[error("topic level {level}: {source}")]
    BadName {
        /// `fleet` or `robot`.
        level: &'static str,
        /// The violated rule.
        source: BadName,
    },
    /// The payload is longer than [`crate::PAYLOAD_MAX_BYTES`].
    #[error("the payload has {bytes} bytes, but must have at most {most}")]
    TooLarge {
        /// Length of the payload, in bytes.
        bytes: usize,
        /// Largest permitted length, in bytes.
        most: usize,
    },
    /// The payload is not JSON in UTF-8.
    #[error("the payload is not JSON: {problem}")]
    NotJson {
        /// Defect of the JSON, with line and column.
        problem: String,
    },
    /// The payload begins as a map in CBOR, but is not well-formed or has values that JSON lacks.
    #[error("the payload is not CBOR of the contract: {problem}")]
    NotCbor {
        /// The violated rule and the position in bytes.
        problem: String,
    },
    /// A field is missing, has the wrong type, or has a word that is not in its list.
    #[error("{path}: {}", plain::data(problem))]
    Malformed {
        /// Path of the field, such as `contacts[3].ratio`; `.` for the whole message.
        path: String,
        /// Description of the error.
        problem: String,
    },
    /// A number is outside the range of its quantity.
    #[error("{path} is {value}, but must be {allowed}")]
    OutOfRange {
        /// Path of the number.
        path: String,
        /// The refused value.
        value: f64,
        /// The permitted range.
        allowed: &'static str,
    },
    /// A list is longer than permitted.
    #[error("{path} has {count} entries, but must have at most {most}")]
    TooMany {
        /// Path of the list.
        path: String,
        /// Length of the list.
        count: usize,
        /// Largest permitted length.
        most: usize,
    },
    /// An array or whisker occurs twice in one message.
    #[error("{path}: {what} occurs more than once in the message")]
    Duplicate {
        /// Path of the second occurrence.
        path: String,
        /// The repeated array or whisker.
        what: String,
    },
    /// A whisker has an invalid neighbour.
    #[error("{path}: whisker {neighbour} cannot be a neighbour here: {why}")]
    WrongNeighbour {
        /// Path of the neighbour.
        path: String,
        /// Number of the invalid neighbour.
        neighbour: u16,
        /// Reason why it is invalid.
        why: &'static str,
    },
}

impl Refusal {
    /// All labels, in the order of the variants, for counters that start at zero.
    pub const LABELS: [&'static str; 10] = [
        "unknown_topic",
        "bad_name",
        "too_large",
        "not_json",
        "not_cbor",
        "malformed",
        "out_of_range",
        "too_many",
        "duplicate",
        "wrong_neighbour",
    ];

    /// Label of the refusal in `snake_case`, for metrics.
    #[must_use]
    pub fn label(&self) -> &'static str {
        match self {
            Self::UnknownTopic { .. } => "unknown_topic",
            Self::BadName { .. } => "bad_name",
            Self::TooLarge { .. } => "too_large",
            Self::NotJson { .. } => "not_json",
            Self::NotCbor { .. } => "not_cbor",
            Self::Malformed { .. } => "malformed",
            Self::OutOfRange { .. } => "out_of_range",
            Self::TooMany { .. } => "too_many",
            Self::Duplicate { .. } => "duplicate",
            Self::WrongNeighbour { .. } => "wrong_neighbour",
        }
    }

    /// Removes the position that the JSON reader adds to a problem.
    pub(crate) fn without_position(mut self) -> Self {
        if let Self::Malformed { problem, .. } | Self::NotJson { problem } = &mut self
            && let Some((before, _)) = problem.rsplit_once(" at line ")
        {
            *problem = before.to_owned();
        }
        self
    }

    /// Puts the name of a field before the path, since checks only know the path below the field.
    pub(crate) fn in_field(mut self, field: &str) -> Self {
        match &mut self {
            Self::Malformed { path, .. }
            | Self::OutOfRange { path, .. }
            | Self::TooMany { path, .. }
            | Self::Duplicate { path, .. }
            | Self::WrongNeighbour { path, .. } => *path = format!("{field}.{path}"),
            Self::UnknownTopic { .. }
            | Self::BadName { .. }
            | Self::TooLarge { .. }
            | Self::NotJson { .. }
            | Self::NotCbor { .. } => {}
        }
        self
    }

    /// Puts the element's position before the path, since checks only know the path below the element.
    pub(crate) fn within(mut self, list: &str, index: usize) -> Self {
        match &mut self {
            Self::Malformed { path, .. }
            | Self::OutOfRange { path, .. }
            | Self::TooMany { path, .. }
            | Self::Duplicate { path, .. }
            | Self::WrongNeighbour { path, .. } => {
                *path = if path.is_empty() { format!("{list}[{index}]") } else { format!("{list}[{index}].{path}") };
            }
            Self::UnknownTopic { .. }
            | Self::BadName { .. }
            | Self::TooLarge { .. }
            | Self::NotJson { .. }
            | Self::NotCbor { .. } => {}
        }
        self
    }
}
