//! The search text of a list.

use std::fmt;

use serde::{Deserialize, Deserializer, Serialize};

/// Most characters of a search text.
const LENGTH_MAX: usize = 100;

/// A text to look for in the names and texts of a list's rows: 1 to 100 characters.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Search(String);

impl fmt::Display for Search {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl<'de> Deserialize<'de> for Search {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        let length = text.chars().count();
        if !(1..=LENGTH_MAX).contains(&length) {
            let error = format!("a search text has 1 to {LENGTH_MAX} characters, not {length}");
            return Err(serde::de::Error::custom(error));
        }
        Ok(Self(text))
    }
}
