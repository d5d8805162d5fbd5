//! Labels that operators put on robots: a key with a value, such as `hall` = `2`.
//!
//! The database stores the labels of a robot as one text, in which each line is `key=value`. Keys contain no `=`, and neither
//! keys nor values contain line breaks.

use std::collections::BTreeMap;
use std::fmt;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Most labels of a robot.
pub const LABELS_MAX: usize = 16;
/// Most characters of a key.
pub const KEY_CHARS_MAX: usize = 40;
/// Most characters of a value.
pub const VALUE_CHARS_MAX: usize = 64;
/// Most conditions of a filter.
pub const CONDITIONS_MAX: usize = 8;

/// Keys as a regular expression.
pub const KEY_PATTERN: &str = "^[a-z][a-z0-9_.-]{0,39}$";
/// Values as a regular expression.
pub const VALUE_PATTERN: &str =
    r"^[^\u0000-\u0020\u007f-\u00a0,]([^\u0000-\u001f\u007f-\u009f,]{0,62}[^\u0000-\u0020\u007f-\u00a0,])?$";

/// Why a text is no label.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum LabelError {
    /// The key is not valid.
    #[error("a key begins with a small letter and has at most 40 small letters, digits and . _ -")]
    Key,
    /// The value is not valid.
    #[error("a value has 1 to 64 characters, no comma, no control characters, and no space at its ends")]
    Value,
    /// There are too many conditions.
    #[error("at most 8 conditions, separated by commas")]
    Conditions,
}

/// Key of a label.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(transparent)]
pub struct LabelKey(String);

impl LabelKey {
    /// Checks a key.
    ///
    /// # Errors
    /// The text is no key.
    pub fn new(text: &str) -> Result<Self, LabelError> {
        let is_inner = |byte: u8| byte.is_ascii_lowercase() || byte.is_ascii_digit() || b"_.-".contains(&byte);
        let is_key = text.len() <= KEY_CHARS_MAX
            && text.starts_with(|first: char| first.is_ascii_lowercase())
            && text.bytes().all(is_inner);
        if is_key { Ok(Self(text.to_owned())) } else { Err(LabelError::Key) }
    }

    /// The key as text.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

/// Value of a label.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct LabelValue(String);

impl LabelValue {
    /// Checks a value.
    ///
    /// # Errors
    /// The text is no value.
    pub fn new(text: &str) -> Result<Self, LabelError> {
        let is_inner = |c: char| !c.is_control() && c != ',';
        let is_edge = |c: char| is_inner(c) && c != ' ' && c != '\u{a0}';
        let is_value = (1..=VALUE_CHARS_MAX).contains(&text.chars().count())
            && text.starts_with(is_edge)
            && text.ends_with(is_edge)
            && text.chars().all(is_inner);
        if is_value { Ok(Self(text.to_owned())) } else { Err(LabelError::Value) }
    }

    /// The value as text.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

/// A condition on the labels of a robot: `key=value`, or `key` for any value.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LabelCondition {
    /// Key that the robot must have.
    pub key: LabelKey,
    /// Value that it must have; `None` for any value.
    pub value: Option<LabelValue>,
}

impl LabelCondition {
    /// Reads `key=value` or `key`.
    ///
    /// # Errors
    /// Key or value is not valid.
    pub fn new(text: &str) -> Result<Self, LabelError> {
        let (key, value) = text.split_once('=').map_or((text, None), |(key, value)| (key, Some(value)));
        Ok(Self { key: LabelKey::new(key)?, value: value.map(LabelValue::new).transpose()? })
    }

    /// A text that [`Labels::lines`] between two line breaks contains exactly if the condition holds.
    #[must_use]
    pub fn needle(&self) -> String {
        match &self.value {
            Some(value) => format!("\n{}={}\n", self.key.as_str(), value.as_str()),
            None => format!("\n{}=", self.key.as_str()),
        }
    }
}

impl fmt::Display for LabelCondition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.key.as_str())?;
        self.value.as_ref().map_or(Ok(()), |value| write!(f, "={}", value.as_str()))
    }
}

/// Conditions on the labels of a robot, separated by commas; all must hold: `hall=2,line`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LabelConditions(Vec<LabelCondition>);

impl LabelConditions {
    /// Reads conditions.
    ///
    /// # Errors
    /// A condition is not valid, or there are more than [`CONDITIONS_MAX`].
    pub fn new(text: &str) -> Result<Self, LabelError> {
        let all = text.split(',').map(LabelCondition::new).collect::<Result<Vec<_>, _>>()?;
        if all.len() <= CONDITIONS_MAX { Ok(Self(all)) } else { Err(LabelError::Conditions) }
    }

    /// The conditions, at least one.
    pub fn iter(&self) -> impl Iterator<Item = &LabelCondition> {
        self.0.iter()
    }
}

impl fmt::Display for LabelConditions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (at, condition) in self.0.iter().enumerate() {
            write!(f, "{}{condition}", if at == 0 { "" } else { "," })?;
        }
        Ok(())
    }
}

impl Serialize for LabelConditions {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

macro_rules! read_from_text {
    ($($name:ident)+) => {
        $(impl<'de> Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                Self::new(&String::deserialize(deserializer)?).map_err(serde::de::Error::custom)
            }
        }

        impl std::str::FromStr for $name {
            type Err = LabelError;

            fn from_str(text: &str) -> Result<Self, LabelError> {
                Self::new(text)
            }
        })+
    };
}
read_from_text!(LabelKey LabelValue LabelConditions);

/// The labels of a robot, by key.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct Labels(BTreeMap<String, String>);

impl Labels {
    /// Reads the text of the database. Lines without `=` are left out.
    #[must_use]
    pub fn from_lines(lines: &str) -> Self {
        let pairs = lines.lines().filter_map(|line| line.split_once('='));
        Self(pairs.map(|(key, value)| (key.to_owned(), value.to_owned())).collect())
    }

    /// The text for the database.
    #[must_use]
    pub fn lines(&self) -> String {
        let lines: Vec<String> = self.0.iter().map(|(key, value)| format!("{key}={value}")).collect();
        lines.join("\n")
    }

    /// Sets a label. Returns false, and changes nothing, if the robot has too many labels.
    pub fn set(&mut self, key: &LabelKey, value: &LabelValue) -> bool {
        let has_room = self.0.len() < LABELS_MAX || self.0.contains_key(key.as_str());
        if has_room {
            self.0.insert(key.as_str().to_owned(), value.as_str().to_owned());
        }
        has_room
    }

    /// Removes a label. Returns false if there is no such label.
    pub fn remove(&mut self, key: &LabelKey) -> bool {
        self.0.remove(key.as_str()).is_some()
    }

    /// Keys and values, by key.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &str)> {
        self.0.iter().map(|(key, value)| (key.as_str(), value.as_str()))
    }

    /// Value of a label; `None` without it.
    #[must_use]
    pub fn get(&self, key: &str) -> Option<&str> {
        self.0.get(key).map(String::as_str)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_and_values_are_checked() {
        for good in ["hall", "a", "floor_2.b-c", &"k".repeat(40)] {
            assert_eq!(LabelKey::new(good).map(|key| key.as_str().to_owned()), Ok(good.to_owned()));
        }
        for bad in ["", "Hall", "2nd", "_x", "a b", "a=b", "ä", "a\n", &"k".repeat(41)] {
            assert_eq!(LabelKey::new(bad), Err(LabelError::Key), "{bad:?}");
        }
        for good in ["2", "north wing", "a=b", "Süd \u{1f916}", &"v".repeat(64), &"ß".repeat(64)] {
            assert!(LabelValue::new(good).is_ok(), "{good:?}");
        }
        for bad in ["", " a", "a ", "\u{a0}a", "a\nb", "a\0", "\u{85}", "a,b", "a\u{9f}b", &"v".repeat(65)] {
            assert_eq!(LabelValue::new(bad), Err(LabelError::Value), "{bad:?}");
        }
    }

    #[test]
    fn a_condition_is_a_key_with_or_without_a_value() {
        for (text, needle) in [("hall", "\nhall="), ("hall=2", "\nhall=2\n"), ("a=b=c", "\na=b=c\n")] {
            let condition = LabelCondition::new(text).unwrap();
            assert_eq!((condition.to_string().as_str(), condition.needle().as_str()), (text, needle));
        }
        assert_eq!(LabelCondition::new("hall="), Err(LabelError::Value));
        let all = LabelConditions::new("hall=2,line").unwrap();
        assert_eq!((all.to_string().as_str(), all.iter().count()), ("hall=2,line", 2));
        assert_eq!(LabelConditions::new("a,b,c,d,e,f,g,h,i"), Err(LabelError::Conditions));
        for bad in ["", ",", "hall=2,", "hall=2, line"] {
            assert!(LabelConditions::new(bad).is_err(), "{bad:?}");
        }
        assert_eq!(LabelCondition::new("=2"), Err(LabelError::Key));
    }

    #[test]
    fn labels_are_stored_by_key_and_found_by_needles() {
        let mut labels = Labels::default();
        for (key, value) in [("zone", "a=1"), ("hall", "1"), ("hall", "2")] {
            assert!(labels.set(&LabelKey::new(key).unwrap(), &LabelValue::new(value).unwrap()));
        }
        assert_eq!(labels.lines(), "hall=2\nzone=a=1");
        assert_eq!(Labels::from_lines(&labels.lines()), labels);
        assert_eq!(Labels::from_lines(""), Labels::default());
        let has = |text: &str| format!("\n{}\n", labels.lines()).contains(&LabelCondition::new(text).unwrap().needle());
        for (text, expected) in
            [("hall", true), ("hall=2", true), ("hall=1", false), ("hal", false), ("zone=a=1", true), ("all=2", false)]
        {
            assert_eq!(has(text), expected, "{text}");
        }
        let key = LabelKey::new("hall").unwrap();
        assert!(labels.remove(&key) && !labels.remove(&key));
    }

    #[test]
    fn a_robot_has_at_most_so_many_labels() {
        let mut labels = Labels::default();
        let value = LabelValue::new("x").unwrap();
        for number in 0..LABELS_MAX {
            assert!(labels.set(&LabelKey::new(&format!("k{number}")).unwrap(), &value));
        }
        assert!(!labels.set(&LabelKey::new("more").unwrap(), &value));
        assert!(labels.set(&LabelKey::new("k3").unwrap(), &value));
    }
}
