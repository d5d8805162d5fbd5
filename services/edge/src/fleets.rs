//! Names and patterns of fleets, by which people mean one fleet, several, or all halls of a site.
//!
//! A pattern is a name in which `*` stands for any number of the characters of names: `hall-*` means `hall-1` and
//! `hall-west`, also those that begin later. A pattern without `*` is a name.

use std::collections::BTreeSet;
use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Deserializer, Serialize, Serializer};
use vibrissa_protocol::Name;

/// Most characters of a pattern, as of a name.
const CHARS_MAX: usize = 64;
/// Most `*` of a pattern.
const STARS_MAX: usize = 8;
/// Most names and patterns of a selection.
pub const FLEETS_MAX: usize = 100;

/// Why a text selects no fleets.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum FleetError {
    /// The text is neither a name nor a pattern.
    #[error(
        "{0:?} is neither the name of a fleet nor a pattern: both have 1 to 64 letters A-Z a-z, digits, '_' or '-', \
         and a pattern has 1 to 8 '*' among them"
    )]
    NotAPattern(String),
    /// There are too many names and patterns.
    #[error("at most 100 names and patterns of fleets, separated by commas")]
    TooMany,
}

/// Name of a fleet, or a pattern of such names.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct FleetPattern(String);

impl FleetPattern {
    /// Checks a name or a pattern.
    ///
    /// # Errors
    /// The text is neither.
    pub fn new(text: &str) -> Result<Self, FleetError> {
        let is_inner = |byte: u8| byte.is_ascii_alphanumeric() || b"_-*".contains(&byte);
        let is_pattern = (1..=CHARS_MAX).contains(&text.len())
            && text.bytes().all(is_inner)
            && text.bytes().filter(|&byte| byte == b'*').count() <= STARS_MAX;
        let excerpt = || text.chars().take(80).collect();
        if is_pattern { Ok(Self(text.to_owned())) } else { Err(FleetError::NotAPattern(excerpt())) }
    }

    /// The name or pattern as text.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// Whether it means one fleet.
    #[must_use]
    pub fn is_name(&self) -> bool {
        !self.0.contains('*')
    }

    /// Whether it means every fleet: nothing but `*`.
    #[must_use]
    pub fn is_all(&self) -> bool {
        self.0.bytes().all(|byte| byte == b'*')
    }

    /// Whether it means the fleet of this name. A text that is no name is no fleet.
    #[must_use]
    pub fn matches(&self, fleet: &str) -> bool {
        fits(self.0.as_bytes(), fleet.as_bytes()) && Name::new(fleet).is_ok()
    }

    /// Whether it means all fleets that the other means.
    ///
    /// A `*` of the other must lie within a `*` of this one. For otherwise the other also means a name with a character
    /// in its place that this pattern does not have.
    #[must_use]
    pub fn includes(&self, other: &Self) -> bool {
        fits(self.0.as_bytes(), other.0.as_bytes())
    }
}

/// Whether a text fits a pattern. `*` of the text is a character like others, which no letter of the pattern equals.
fn fits(pattern: &[u8], text: &[u8]) -> bool {
    let (mut at, mut read) = (0, 0);
    // The last `*`, and how far the text before it and within it reaches.
    let mut star: Option<(usize, usize)> = None;
    while read < text.len() {
        match pattern.get(at) {
            Some(b'*') => {
                star = Some((at, read));
                at += 1;
            }
            Some(letter) if *letter == text[read] => (at, read) = (at + 1, read + 1),
            Some(_) | None => {
                let Some((star_at, within)) = star else { return false };
                star = Some((star_at, within + 1));
                (at, read) = (star_at + 1, within + 1);
            }
        }
    }
    pattern[at..].iter().all(|&letter| letter == b'*')
}

/// Names and patterns of fleets, separated by commas; a fleet must match one of them: `hall-*,lab`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FleetSelection(BTreeSet<FleetPattern>);

impl FleetSelection {
    /// Reads names and patterns.
    ///
    /// # Errors
    /// One of them is not valid, or there are more than [`FLEETS_MAX`].
    pub fn new(text: &str) -> Result<Self, FleetError> {
        if text.split(',').count() > FLEETS_MAX {
            return Err(FleetError::TooMany);
        }
        text.split(',').map(FleetPattern::new).collect::<Result<_, _>>().map(Self)
    }

    /// Names and patterns, at least one, in order.
    pub fn iter(&self) -> impl Iterator<Item = &FleetPattern> {
        self.0.iter()
    }

    /// Whether it means the fleet of this name.
    #[must_use]
    pub fn matches(&self, fleet: &str) -> bool {
        self.iter().any(|pattern| pattern.matches(fleet))
    }

    /// The fleet, if it means only one by its name.
    #[must_use]
    pub fn only(&self) -> Option<&str> {
        self.0.first().filter(|first| self.0.len() == 1 && first.is_name()).map(FleetPattern::as_str)
    }
}

impl fmt::Display for FleetPattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&self.0)
    }
}

impl fmt::Display for FleetSelection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (at, pattern) in self.iter().enumerate() {
            write!(f, "{}{pattern}", if at == 0 { "" } else { "," })?;
        }
        Ok(())
    }
}

macro_rules! as_text {
    ($($name:ident)+) => {
        $(impl FromStr for $name {
            type Err = FleetError;

            fn from_str(text: &str) -> Result<Self, FleetError> {
                Self::new(text)
            }
        }

        impl Serialize for $name {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.collect_str(self)
            }
        }

        impl<'de> Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                Self::new(&String::deserialize(deserializer)?).map_err(serde::de::Error::custom)
            }
        })+
    };
}
as_text!(FleetPattern FleetSelection);

/// Regular expression (ECMA 262) of a selection.
#[must_use]
pub fn selection_pattern() -> String {
    // An item has no more `*` than allowed.
    let item = format!("(?!([^,*]*\\*){{{}}})[A-Za-z0-9_*-]{{1,{CHARS_MAX}}}", STARS_MAX + 1);
    format!("^{item}(,{item}){{0,{}}}$", FLEETS_MAX - 1)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn pattern(text: &str) -> FleetPattern {
        FleetPattern::new(text).unwrap()
    }

    /// All texts of at most so many of these letters.
    fn texts(letters: &str, length_max: usize) -> Vec<String> {
        let mut all = vec![String::new()];
        let mut last = all.clone();
        for _ in 0..length_max {
            last = last.iter().flat_map(|text| letters.chars().map(move |letter| format!("{text}{letter}"))).collect();
            all.extend(last.iter().cloned());
        }
        all.split_off(1)
    }

    /// The definition: each `*` takes none, one, or more letters.
    fn fits_by_definition(pattern: &[u8], text: &[u8]) -> bool {
        match pattern.split_first() {
            None => text.is_empty(),
            Some((b'*', rest)) => (0..=text.len()).any(|taken| fits_by_definition(rest, &text[taken..])),
            Some((letter, rest)) => text.first() == Some(letter) && fits_by_definition(rest, &text[1..]),
        }
    }

    #[test]
    fn a_pattern_has_the_characters_of_a_name_and_up_to_8_stars() {
        for good in ["hall-1", "*", "hall-*", "*-west", "h*l_*", "********", &"x".repeat(64)] {
            assert_eq!(pattern(good).as_str(), good);
        }
        for bad in ["", "a b", "a,b", "a?", "[a]", "%", "é*", "a.*", "*********", &"x".repeat(65)] {
            let problem = FleetPattern::new(bad).unwrap_err().to_string();
            assert!(problem.contains("1 to 8 '*'"), "{problem}");
        }
        assert!(pattern("hall").is_name() && !pattern("hall*").is_name());
        assert!(pattern("**").is_all() && !pattern("*a").is_all());
    }

    #[test]
    fn a_star_stands_for_characters_of_names_and_case_counts() {
        assert!(pattern("hall-*").matches("hall-1") && pattern("hall-*").matches("hall-"));
        for other in ["hall", "Hall-1", "hall_1", "xhall-1", "hall-/", "hall-1,x", "hall-*", ""] {
            assert!(!pattern("hall-*").matches(other), "{other}");
        }
        assert!(!pattern("*").matches(&"x".repeat(65)), "no name is so long");
    }

    #[test]
    fn brute_force_a_pattern_matches_the_names_of_its_definition() {
        let names = texts("ab", 6);
        for text in texts("ab*", 5) {
            let pattern = pattern(&text);
            for name in &names {
                let expected = fits_by_definition(text.as_bytes(), name.as_bytes());
                assert_eq!(pattern.matches(name), expected, "{text} {name}");
            }
        }
    }

    /// The third letter is in no pattern. It stands for the many that a pattern of at most 64 characters does not have.
    #[test]
    fn brute_force_a_pattern_includes_another_exactly_if_it_matches_all_its_names() {
        let names = texts("abc", 6);
        let patterns: Vec<_> = texts("ab*", 4).iter().map(|text| pattern(text)).collect();
        let matched: Vec<Vec<bool>> =
            patterns.iter().map(|one| names.iter().map(|name| one.matches(name)).collect()).collect();
        for (wide, of_wide) in patterns.iter().zip(&matched) {
            for (narrow, of_narrow) in patterns.iter().zip(&matched) {
                let expected = of_narrow.iter().zip(of_wide).all(|(narrow, wide)| !narrow || *wide);
                assert_eq!(wide.includes(narrow), expected, "{wide} {narrow}");
            }
        }
    }

    #[test]
    fn a_selection_has_names_and_patterns_between_commas() {
        let some = FleetSelection::new("lab,hall-*,lab").unwrap();
        assert_eq!(some.to_string(), "hall-*,lab");
        assert!(some.matches("hall-2") && some.matches("lab") && !some.matches("lab-2"));
        assert_eq!((some.only(), FleetSelection::new("lab").unwrap().only()), (None, Some("lab")));
        assert_eq!(FleetSelection::new("hall-*").unwrap().only(), None);
        for bad in ["", "a,", ",a", "a,,b", "a, b"] {
            assert!(FleetSelection::new(bad).is_err(), "{bad}");
        }
        let many = |count: usize| (0..count).map(|at| format!("f{at}")).collect::<Vec<_>>().join(",");
        assert!(FleetSelection::new(&many(100)).is_ok());
        assert_eq!(FleetSelection::new(&many(101)), Err(FleetError::TooMany));
    }

    proptest! {
        #[test]
        fn property_long_patterns_match_as_defined(text in "[ab*]{1,12}", name in "[ab]{1,14}") {
            if let Ok(pattern) = FleetPattern::new(&text) {
                prop_assert_eq!(pattern.matches(&name), fits_by_definition(text.as_bytes(), name.as_bytes()));
            }
        }

        #[test]
        fn property_what_is_included_matches_no_more(
            wide in "[ab*]{1,8}",
            narrow in "[ab*]{1,8}",
            name in "[abc]{1,8}",
        ) {
            let (Ok(wide), Ok(narrow)) = (FleetPattern::new(&wide), FleetPattern::new(&narrow)) else { return Ok(()) };
            prop_assert!(!wide.includes(&narrow) || !narrow.matches(&name) || wide.matches(&name));
        }
    }
}
