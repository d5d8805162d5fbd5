//! Switches parts of a fuzz run back to ordinary values, to find the cause of a fault.

use vibrissa_protocol::RobotTopic;

use super::FROM_ROBOTS;

/// The parts of a run that use ordinary values.
#[derive(Debug, Clone, Default)]
pub struct Without {
    /// Topics whose messages are ordinary.
    pub topics: Vec<RobotTopic>,
    /// Whether all times are correct.
    pub times: bool,
    /// Whether all texts are ordinary.
    pub texts: bool,
}

impl Without {
    /// Reads `FUZZ_WITHOUT`, a comma-separated list of topics such as `factsheet`, `times` and `texts`.
    ///
    /// # Panics
    /// A word is not a topic of robots, `times` or `texts`.
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

    /// Whether messages of this topic are ordinary.
    #[must_use]
    pub fn is_ordinary(&self, kind: RobotTopic) -> bool {
        self.topics.contains(&kind)
    }
}
