//! Names of fleets, robots and arrays, and boot ids.

use std::fmt;
use std::str::FromStr;

use serde::de::{Error as _, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use smol_str::SmolStr;

use crate::check;

/// Longest name, in characters.
const NAME_MAX_CHARS: usize = 64;

/// A text that is not a valid name or boot id; the message states the rule.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum BadName {
    /// Wrong length, or a character that is not permitted.
    #[error("{0:?} is not a valid name: a name has 1 to 64 letters A-Z a-z, digits, '_' or '-'")]
    NotAName(String),
    /// The reserved name `supervisor` for a robot.
    #[error("a robot cannot be named \"supervisor\": that topic level belongs to the supervisor")]
    Reserved,
    /// A boot id of the wrong length or with control characters.
    #[error("{0:?} is not a valid boot id: a boot id has 1 to 64 characters, none of them a control character")]
    NotABootId(String),
}

/// Shortens an invalid text for an error message.
fn excerpt(text: &str) -> String {
    text.chars().take(80).collect()
}

/// Defines a checked string with serde, ordering and display. Up to 23 bytes are stored inline, so that reading one
/// allocates nothing; clones share a longer text.
macro_rules! text {
    ($(#[$doc:meta])* $name:ident, $expecting:literal, $check:expr, $schema:expr, $error:expr) => {
        $(#[$doc])*
        #[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name(SmolStr);

        impl $name {
            /// Checks the text.
            ///
            /// # Errors
            /// The text is not what the documentation of the type states.
            pub fn new(text: &str) -> Result<Self, BadName> {
                let check: fn(&str) -> bool = $check;
                if check(text) { Ok(Self(SmolStr::new(text))) } else { Err($error(excerpt(text))) }
            }

            /// Returns the text.
            #[must_use]
            pub fn as_str(&self) -> &str {
                &self.0
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.pad(&self.0)
            }
        }

        impl FromStr for $name {
            type Err = BadName;
            fn from_str(text: &str) -> Result<Self, BadName> {
                Self::new(text)
            }
        }

        impl AsRef<str> for $name {
            fn as_ref(&self) -> &str {
                &self.0
            }
        }

        // Maps keyed by the type can be queried with a `&str`: order and hash are those of the text.
        impl std::borrow::Borrow<str> for $name {
            fn borrow(&self) -> &str {
                &self.0
            }
        }

        impl Serialize for $name {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.serialize_str(&self.0)
            }
        }

        #[cfg(feature = "documents")]
        impl schemars::JsonSchema for $name {
            fn inline_schema() -> bool {
                true
            }
            fn schema_name() -> std::borrow::Cow<'static, str> {
                stringify!($name).into()
            }
            fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
                $schema
            }
        }

        impl<'de> Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                struct Text;
                impl Visitor<'_> for Text {
                    type Value = $name;
                    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                        f.write_str($expecting)
                    }
                    fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<$name, E> {
                        $name::new(text).map_err(E::custom)
                    }
                }
                deserializer.deserialize_str(Text)
            }
        }
    };
}

text!(
    /// Name of a fleet, a robot or an array: `[A-Za-z0-9_-]{1,64}`.
    Name,
    "a name as text",
    |text| (1..=NAME_MAX_CHARS).contains(&text.len())
        && text.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_' || b == b'-'),
    crate::schema::matching(&Name::pattern()),
    BadName::NotAName
);
text!(
    /// Identifies a start of a sender, and is new at each one: 1 to 64 characters without control characters.
    BootId,
    "a boot id as text",
    check::is_identifier,
    crate::schema::identifier(),
    BadName::NotABootId
);

impl Name {
    /// Topic level of the supervisor, which no robot may have as its name.
    pub const RESERVED: &str = "supervisor";

    /// Regular expression (ECMA 262) of a valid name.
    #[must_use]
    pub fn pattern() -> String {
        format!("^[A-Za-z0-9_-]{{1,{NAME_MAX_CHARS}}}$")
    }

    /// Regular expression (ECMA 262) of a valid name of a robot.
    #[must_use]
    pub fn robot_pattern() -> String {
        format!("^(?!{}$)[A-Za-z0-9_-]{{1,{NAME_MAX_CHARS}}}$", Self::RESERVED)
    }

    /// Checks the name of a robot: any name but `supervisor`.
    ///
    /// # Errors
    /// The text is not a valid name, or it is the reserved one.
    pub fn robot(text: &str) -> Result<Self, BadName> {
        if text == Self::RESERVED { Err(BadName::Reserved) } else { Self::new(text) }
    }
}

/// For serde's `deserialize_with`: a short free text without control characters, such as the name of a model.
pub(crate) fn short_text<'de, D: Deserializer<'de>>(deserializer: D) -> Result<String, D::Error> {
    let text = String::deserialize(deserializer)?;
    if check::is_identifier(&text) { Ok(text) } else { Err(D::Error::custom(check::identifier_rule())) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_has_1_to_64_of_the_allowed_characters() {
        assert!(Name::new("Crawler_2-b").is_ok());
        assert!(Name::new(&"x".repeat(64)).is_ok());
        for bad in ["", "a/b", "a b", "+", "#", "ä", &"x".repeat(65)] {
            assert!(Name::new(bad).is_err(), "{bad:?} should be refused");
        }
    }

    #[test]
    fn supervisor_is_no_robots_name() {
        assert_eq!(Name::robot("supervisor"), Err(BadName::Reserved));
        assert!(Name::new("supervisor").is_ok(), "a fleet or an array may be called so");
    }

    #[test]
    fn a_boot_id_is_not_empty_and_has_no_control_characters() {
        assert!(BootId::new("b7").is_ok());
        assert!(BootId::new("").is_err());
        assert!(BootId::new("b\n").is_err());
        assert!(BootId::new(&"é".repeat(65)).is_err());
    }
}
