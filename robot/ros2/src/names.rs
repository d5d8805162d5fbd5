//! Names of topics. ROS allows fewer characters than the names of arrays have.

use crate::words::Named;

/// Topics of a whisker, below the namespace.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WhiskerTopics {
    /// Its namespace, such as `/crawler/left/whisker_3`.
    pub namespace: String,
}

/// A part of a ROS name: letters, digits and single underscores, no digit first.
fn part(name: &str) -> String {
    let mut part = String::new();
    for letter in name.chars().map(|letter| if letter.is_ascii_alphanumeric() { letter } else { '_' }) {
        if !(letter == '_' && part.ends_with('_')) {
            part.push(letter);
        }
    }
    let begins_well = part.starts_with(|letter: char| letter.is_ascii_alphabetic());
    if begins_well { part } else { format!("array_{}", part.trim_start_matches('_')) }
}

/// The topics of all whiskers.
///
/// # Errors
/// Two arrays would have the same topics.
pub fn topics(namespace: &str, whiskers: &[Named]) -> Result<Vec<WhiskerTopics>, String> {
    let mut arrays = std::collections::BTreeMap::new();
    let mut topics = Vec::new();
    for whisker in whiskers {
        let part = part(&whisker.array);
        let array = arrays.entry(part.clone()).or_insert_with(|| whisker.array.clone());
        if *array != whisker.array {
            return Err(format!("the arrays {array} and {} would have the same topics: rename one", whisker.array));
        }
        let namespace = format!("{}/{part}/whisker_{}", namespace.trim_end_matches('/'), whisker.whisker);
        topics.push(WhiskerTopics { namespace });
    }
    Ok(topics)
}
