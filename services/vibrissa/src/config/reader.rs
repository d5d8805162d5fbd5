//! Reads and checks the values of keys, and collects the problems.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use toml::Value;
use vibrissa_protocol::plain;

use super::keys::{Key, ValueKind};
use super::layers::{LIST_MAX, Layers};
use super::problem::{Origin, Problem};
use vibrissa_store::secret::Secret;

/// Mask shown in place of a secret; refused as a secret.
pub(super) const MASK: &str = "***";

/// Size limit of a text, in bytes: far above any real one.
const TEXT_MAX_BYTES: usize = 4096;

/// Reads values and collects problems.
pub(super) struct Reader {
    layers: Layers,
    pub(super) problems: Vec<Problem>,
    /// Files that contain secrets, each with the key that led there.
    pub(super) secret_files: Vec<(Key, PathBuf)>,
}

/// Marks a value whose problem is already recorded.
type Refused = ();

impl Reader {
    pub(super) fn new(mut layers: Layers) -> Self {
        let problems = std::mem::take(&mut layers.problems);
        Self { layers, problems, secret_files: Vec::new() }
    }

    /// Origin of the key's value.
    pub(super) fn origin(&self, key: Key) -> Origin {
        self.layers.find(key).1.clone()
    }

    /// Whether the key is set explicitly.
    pub(super) fn is_explicit(&self, key: Key) -> bool {
        self.layers.find(key).1.is_explicit()
    }

    /// Records a problem of a key's value.
    pub(super) fn refuse(&mut self, key: Key, what: impl Into<String>) {
        let origin = self.origin(key);
        self.problems.push(Problem::new(key, origin, what));
    }

    /// The value, if it is set; `None` after a refusal too.
    fn read<T>(&mut self, key: Key, read: impl FnOnce(&Value) -> Result<T, String>) -> Option<T> {
        let (value, _) = self.layers.find(key);
        read(value?).map_err(|what| self.refuse(key, what)).ok()
    }

    /// A text that is not empty.
    pub(super) fn text(&mut self, key: Key) -> Option<String> {
        self.read(key, |value| match value.as_str() {
            Some("") => Err("must not be empty: write a value or leave the key out".to_owned()),
            Some(text) if text.len() > TEXT_MAX_BYTES => Err(format!("must have at most {TEXT_MAX_BYTES} bytes")),
            Some(text) if text.contains('\0') => Err("must not contain a NUL character".to_owned()),
            Some(text) => Ok(text.to_owned()),
            None => Err(wrong_type(key, value)),
        })
    }

    /// A text that `parse` accepts.
    pub(super) fn parsed<T, E: std::fmt::Display>(
        &mut self,
        key: Key,
        parse: impl FnOnce(&str) -> Result<T, E>,
    ) -> Option<T> {
        let text = self.text(key)?;
        parse(&text).map_err(|problem| self.refuse(key, problem.to_string())).ok()
    }

    /// A word of an enumeration, in any case.
    pub(super) fn word<T: ValueEnum>(&mut self, key: Key) -> Option<T> {
        self.parsed(key, |text| {
            T::from_str(text, true).map_err(|_| {
                let words: Vec<_> = T::value_variants().iter().filter_map(ValueEnum::to_possible_value).collect();
                let words: Vec<_> = words.iter().map(|word| word.get_name()).collect();
                format!("must be {}, not {text:?}", words.join(" or "))
            })
        })
    }

    /// A list of texts.
    pub(super) fn texts(&mut self, key: Key) -> Option<Vec<String>> {
        self.read(key, |value| {
            let items = value.as_array().ok_or_else(|| wrong_type(key, value))?;
            if items.len() > LIST_MAX {
                return Err(format!("must have at most {LIST_MAX} entries"));
            }
            let text = |item: &Value| match item.as_str() {
                Some(text) if text.len() > TEXT_MAX_BYTES => {
                    Err(format!("must have at most {TEXT_MAX_BYTES} bytes in an entry"))
                }
                Some(text) => Ok(text.to_owned()),
                None => Err(wrong_type(key, value)),
            };
            items.iter().map(text).collect()
        })
    }

    /// A number in its range.
    pub(super) fn number(&mut self, key: Key) -> Option<f64> {
        let ValueKind::Number { min, max } = key.kind() else { return None };
        self.read(key, |value| {
            let number = value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64));
            let number = number.ok_or_else(|| wrong_type(key, value))?;
            let allowed = (min..=max).contains(&number);
            allowed.then_some(number).ok_or_else(|| format!("must be from {min:?} to {max:?}, not {number:?}"))
        })
    }

    /// A whole number in its range.
    pub(super) fn whole(&mut self, key: Key) -> Option<u32> {
        let ValueKind::Whole { min, max } = key.kind() else { return None };
        self.read(key, |value| {
            let number = value.as_integer().ok_or_else(|| wrong_type(key, value))?;
            let allowed = u32::try_from(number).ok().filter(|number| (min..=max).contains(number));
            allowed.ok_or_else(|| format!("must be a whole number from {min} to {max}, not {number}"))
        })
    }

    /// A file that can be opened.
    pub(super) fn file(&mut self, key: Key) -> Option<PathBuf> {
        let path = PathBuf::from(self.text(key)?);
        self.opens(key, &path).ok()?;
        Some(path)
    }

    /// A file that only this user should be able to read.
    pub(super) fn private_file(&mut self, key: Key) -> Option<PathBuf> {
        let path = self.file(key)?;
        self.secret_files.push((key, path.clone()));
        Some(path)
    }

    /// Records that the configuration file contains a secret, if the key's value comes from there.
    pub(super) fn holds_secret(&mut self, key: Key) {
        if let Origin::File(path) = self.origin(key) {
            self.secret_files.push((key, path));
        }
    }

    fn opens(&mut self, key: Key, path: &Path) -> Result<std::fs::File, Refused> {
        let opened = std::fs::File::open(path).and_then(|file| {
            let is_folder = file.metadata()?.is_dir();
            if is_folder { Err(std::io::ErrorKind::IsADirectory.into()) } else { Ok(file) }
        });
        opened.map_err(|problem| {
            let what = format!(
                "the file {} cannot be read: {}; correct its name, or let this user read it",
                path.display(),
                plain::io(&problem)
            );
            self.refuse(key, what);
        })
    }

    /// A secret given directly, in the configuration file or the environment.
    pub(super) fn secret(&mut self, key: Key) -> Option<Secret> {
        if matches!(self.origin(key), Origin::Flag(_)) {
            let file = format!("{key}_file");
            let flag = Key::at(&file).map_or(file, |key| format!("{key} (--{} FILE)", key.flag()));
            let what = format!(
                "is refused on the command line, which everyone on this machine can read (ps): set {flag}, or the \
                 environment variable {}",
                key.environment()
            );
            self.refuse(key, what);
            return None;
        }
        let text = self.text(key)?;
        self.holds_secret(key);
        if text == MASK {
            self.refuse(key, format!("{MASK} is only the mask of a hidden password: write the password itself"));
            return None;
        }
        Some(Secret::new(text))
    }

    /// The secret in a file, without the line end.
    pub(super) fn secret_file(&mut self, key: Key) -> Option<Secret> {
        let path = PathBuf::from(self.text(key)?);
        self.opens(key, &path).ok()?;
        self.secret_files.push((key, path.clone()));
        Secret::from_file(&path).map_err(|what| self.refuse(key, what)).ok()
    }
}

/// Message about a wrong type: the expected and the given one. It does not show a secret's value.
fn wrong_type(key: Key, value: &Value) -> String {
    let (should, example) = match key.kind() {
        ValueKind::Text | ValueKind::Secret | ValueKind::DatabaseUrl => ("a text", "\"...\""),
        ValueKind::File => ("a file's name", "\"FILE\""),
        ValueKind::Texts => ("a list of texts", "[\"a\", \"b\"]"),
        ValueKind::Files => ("a list of files' names", "[\"FILE\"]"),
        ValueKind::Number { .. } => ("a number", "1.5"),
        ValueKind::Whole { .. } => ("a whole number", "10"),
    };
    let is = match value {
        Value::String(text) if matches!(key.kind(), ValueKind::Number { .. } | ValueKind::Whole { .. }) => {
            let kubernetes = if text.starts_with("tcp://") {
                " (Kubernetes sets such variables for services: give the service another name, or set enableServiceLinks: false)"
            } else {
                ""
            };
            let shown: String = text.chars().take(40).collect();
            return format!("must be {should}, such as {example}, not {shown:?}{kubernetes}");
        }
        Value::String(_) => "a text",
        Value::Boolean(_) => "true or false",
        Value::Integer(_) | Value::Float(_) => "a number",
        Value::Datetime(_) => "a date or time",
        Value::Table(_) => "a section",
        Value::Array(_) if key.kind().is_list() => "a list with something else",
        Value::Array(_) => "a list",
    };
    format!("must be {should}, such as {} = {example}, but is {is}", key.section().1)
}
