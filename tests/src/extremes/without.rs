//! The parts of a run that are ordinary, to find the cause of a fault.

use vibrissa_protocol::RobotTopic;

use super::FROM_ROBOTS;

/// The ordinary parts.
#[derive(Debug, Clone, Default)]
pub struct Without {
    /// Topics whose messages are ordinary.
    pub topics: Vec<RobotTopic>,
    /// Times are right.
    pub times: bool,
    /// No text is odd.
    pub texts: bool,
}

impl Without {
    /// The words of `FUZZ_WITHOUT`, separated by commas: topics such as `factsheet`, `times`, `texts`.
    ///
    /// # Panics
    /// A word is neither a topic of robots, nor `times`, nor `texts`.
    #[must_use]
    pub fn from_environment() -> Self {
        let words = std::env::var("FUZZ_WITHOUT").unwrap_or_default();
        let mut without = Self::default();
        for word in words.split(',').filter(|word| !word.is_empty()) {
            match (word, FROM_ROBOTS.iter().find(|kind| kind.as_str() == word)) {
                ("times", _) => without.times = true,
                ("texts", _) => without.texts = true,
                (_, Some(kind)) => without.topics.push(*kind),
                (_, None) => panic!("FUZZ_WITHOUT has {word:?}: expected topics of robots, times or texts"),
            }
        }
        without
    }

    /// Whether the messages of a topic are ordinary.
    #[must_use]
    pub fn is_ordinary(&self, kind: RobotTopic) -> bool {
        self.topics.contains(&kind)
    }
}
