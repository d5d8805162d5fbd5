//! Problems of a configuration, for the person who wrote it.

use std::fmt;
use std::path::PathBuf;

use super::keys::Key;

/// Origin of a value.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Origin {
    /// The value is the built-in default.
    Default,
    /// The configuration file.
    File(PathBuf),
    /// An environment variable.
    Environment(String),
    /// A flag, without its dashes.
    Flag(String),
}

impl Origin {
    /// Whether the value was set explicitly.
    #[must_use]
    pub fn is_explicit(&self) -> bool {
        *self != Self::Default
    }
}

impl fmt::Display for Origin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Default => f.write_str("default"),
            Self::File(path) => write!(f, "file {}", path.display()),
            Self::Environment(name) => write!(f, "environment {name}"),
            Self::Flag(name) => write!(f, "flag --{name}"),
        }
    }
}

/// A problem, and what to do.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problem {
    /// Path of the key, or the text in its place; empty for a file as a whole.
    pub key: String,
    /// Origin of the value.
    pub origin: Origin,
    /// Description of the problem and its remedy. Contains no secret.
    pub what: String,
}

impl Problem {
    /// A problem of a key's value.
    #[must_use]
    pub fn new(key: Key, origin: Origin, what: impl Into<String>) -> Self {
        Self { key: key.path().to_owned(), origin, what: what.into() }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // One problem is one line, whatever a name or a value holds.
        let what = self.what.split(char::is_control).collect::<Vec<_>>().join(" ");
        if self.key.is_empty() {
            write!(f, "{}: {what}", self.origin)
        } else {
            write!(f, "{} ({}): {what}", self.key.escape_debug(), self.origin)
        }
    }
}

/// All problems of a configuration; never empty.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problems(pub Vec<Problem>);

impl fmt::Display for Problems {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let [one] = self.0.as_slice() {
            return one.fmt(f);
        }
        write!(f, "the configuration has {} problems:", self.0.len())?;
        self.0.iter().try_for_each(|problem| write!(f, "\n  {problem}"))
    }
}

impl std::error::Error for Problems {}

impl From<Problem> for Problems {
    fn from(problem: Problem) -> Self {
        Self(vec![problem])
    }
}

/// "; did you mean NAME?" if a name is similar, otherwise an empty text.
#[must_use]
pub fn did_you_mean<'a>(text: &str, names: impl Iterator<Item = &'a str>) -> String {
    // Long foreign names are not typing errors, and the cost is the product of both lengths.
    if text.len() > 100 {
        return String::new();
    }
    names
        .map(|name| (strsim::jaro_winkler(text, name), name))
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .filter(|&(likeness, _)| likeness > 0.85)
        .map_or_else(String::new, |(_, name)| format!("; did you mean {name}?"))
}
