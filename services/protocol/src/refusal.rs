//! Why a message was not taken.

use crate::name::BadName;

/// Why a message was not taken: a closed set, so that each kind is counted under its label.
///
/// The display names the field, what it held and what is allowed, for the person who builds the sender.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// The topic is not one of the contract.
    #[error("{topic:?} is no topic of this contract: {expected}")]
    UnknownTopic {
        /// The topic, shortened.
        topic: String,
        /// What would have been one.
        expected: &'static str,
    },
    /// A level of the topic is no name.
    #[error("topic level {level}: {source}")]
    BadName {
        /// `fleet` or `robot`.
        level: &'static str,
        /// What is wrong with it.
        source: BadName,
    },
    /// The payload is longer than [`crate::PAYLOAD_MAX_BYTES`].
    #[error("the payload has {bytes} bytes, but must have at most {most}")]
    TooLarge {
        /// Its length.
        bytes: usize,
        /// The limit.
        most: usize,
    },
    /// The payload is not JSON in UTF-8.
    #[error("the payload is not JSON: {problem}")]
    NotJson {
        /// What the JSON reader says, with line and column.
        problem: String,
    },
    /// A field is missing, of the wrong type, or holds a word that is not in its list.
    #[error("{path}: {problem}")]
    Malformed {
        /// Where, such as `contacts[3].ratio`; `.` for the message as a whole.
        path: String,
        /// What is wrong.
        problem: String,
    },
    /// A number is outside what its quantity can be.
    #[error("{path} is {value}, but must be {allowed}")]
    OutOfRange {
        /// Where.
        path: String,
        /// What it held.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A list is longer than allowed.
    #[error("{path} has {count} entries, but must have at most {most}")]
    TooMany {
        /// Where.
        path: String,
        /// Its length.
        count: usize,
        /// The limit.
        most: usize,
    },
    /// The same array or whisker twice in one message.
    #[error("{path}: {what} is in the message more than once")]
    Duplicate {
        /// Where the second one is.
        path: String,
        /// Which.
        what: String,
    },
    /// A whisker names a neighbour that its array does not have.
    #[error("{path}: whisker {neighbour} cannot be a neighbour here: {why}")]
    WrongNeighbour {
        /// Where.
        path: String,
        /// The number given.
        neighbour: u16,
        /// Why not.
        why: &'static str,
    },
}

impl Refusal {
    /// Every label, in the order of the variants: to set up counters that start at zero.
    pub const LABELS: [&'static str; 9] = [
        "unknown_topic",
        "bad_name",
        "too_large",
        "not_json",
        "malformed",
        "out_of_range",
        "too_many",
        "duplicate",
        "wrong_neighbour",
    ];

    /// The kind as a word in `snake_case`, for metrics.
    #[must_use]
    pub fn label(&self) -> &'static str {
        match self {
            Self::UnknownTopic { .. } => "unknown_topic",
            Self::BadName { .. } => "bad_name",
            Self::TooLarge { .. } => "too_large",
            Self::NotJson { .. } => "not_json",
            Self::Malformed { .. } => "malformed",
            Self::OutOfRange { .. } => "out_of_range",
            Self::TooMany { .. } => "too_many",
            Self::Duplicate { .. } => "duplicate",
            Self::WrongNeighbour { .. } => "wrong_neighbour",
        }
    }

    /// Puts the element's place before the field's: checks know only what is below them.
    pub(crate) fn within(mut self, list: &str, index: usize) -> Self {
        match &mut self {
            Self::Malformed { path, .. }
            | Self::OutOfRange { path, .. }
            | Self::TooMany { path, .. }
            | Self::Duplicate { path, .. }
            | Self::WrongNeighbour { path, .. } => {
                *path = if path.is_empty() { format!("{list}[{index}]") } else { format!("{list}[{index}].{path}") };
            }
            Self::UnknownTopic { .. } | Self::BadName { .. } | Self::TooLarge { .. } | Self::NotJson { .. } => {}
        }
        self
    }
}
