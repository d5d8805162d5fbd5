//! Names of topics. ROS allows fewer characters than the names of arrays have.

use crate::words::Named;

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

/// Where the topics of the whiskers are, below the node's namespace: such as `left/whisker_3`.
///
/// # Errors
/// Two arrays would have the same topics.
pub fn topics(whiskers: &[Named]) -> Result<Vec<String>, String> {
    let mut arrays = std::collections::BTreeMap::new();
    let mut topics = Vec::new();
    for whisker in whiskers {
        let part = part(&whisker.array);
        let array = arrays.entry(part.clone()).or_insert_with(|| whisker.array.clone());
        if *array != whisker.array {
            return Err(format!("the arrays {array} and {} would have the same topics: rename one", whisker.array));
        }
        topics.push(format!("{part}/whisker_{}", whisker.whisker));
    }
    Ok(topics)
}
