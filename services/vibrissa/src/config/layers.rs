//! The four layers of the configuration: defaults, file, environment, flags. Each value remembers its origin.

use std::path::{Path, PathBuf};

use toml::{Table, Value};
use vibrissa_protocol::plain;

use super::keys::{ENVIRONMENT_PREFIX, Key, ValueKind};
use super::problem::{Origin, Problem, did_you_mean};

/// Size limit of a configuration file, in bytes: far above any real one.
pub const FILE_MAX_BYTES: usize = 64 * 1024;
/// Size limit of a list, in entries: far above any real one.
pub(super) const LIST_MAX: usize = 256;

/// Variables with our prefix that are used elsewhere: by `--config`, the simulator, the tests, and the API's client.
const KNOWN_ELSEWHERE: [&str; 6] = [
    "VIBRISSA_CONFIG",
    "VIBRISSA_SCENARIO",
    "VIBRISSA_TEST_FAULT",
    "VIBRISSA_TOKEN",
    "VIBRISSA_TOKEN_FILE",
    "VIBRISSA_URL",
];

/// Settings as users wrote them.
#[derive(Clone, Default)]
pub struct Sources {
    /// The configuration file and its text.
    pub file: Option<(PathBuf, String)>,
    /// Environment variables, also those of other programs.
    pub environment: Vec<(String, String)>,
    /// Flags; the flag of a list may have several values.
    pub flags: Vec<(Key, Vec<String>)>,
}

/// Each key's value in the uppermost layer that has one, and the problems found so far.
pub(super) struct Layers {
    /// In the order of [`Key::ALL`].
    settings: Vec<(Option<Value>, Origin)>,
    /// Unknown keys of the file, or its syntax error.
    pub(super) problems: Vec<Problem>,
    /// Warnings about unknown environment variables with our prefix.
    pub(super) warnings: Vec<String>,
}

impl Layers {
    pub(super) fn new(sources: &Sources) -> Self {
        let mut problems = Vec::new();
        let file = sources.file.as_ref().map(|(path, text)| (path, file(path, text, &mut problems)));
        let defaults = defaults();
        let setting = |&key: &Key| {
            if let Some(value) = flag(&sources.flags, key) {
                return (Some(value), Origin::Flag(key.flag().to_owned()));
            }
            if let Some(value) = environment(&sources.environment, key) {
                return (Some(value), Origin::Environment(key.environment().to_owned()));
            }
            if let Some((path, values)) = &file
                && let Some(value) = at(values, key)
            {
                return (Some(value.clone()), Origin::File((*path).clone()));
            }
            let default = if key == Key::Name { Some(host_name().into()) } else { defaults.get(key.path()).cloned() };
            (default, Origin::Default)
        };
        let settings = Key::ALL.iter().map(setting).collect();
        Self { settings, problems, warnings: unknown_variables(&sources.environment) }
    }

    /// A key's value, if it is set, and its origin.
    pub(super) fn find(&self, key: Key) -> (Option<&Value>, &Origin) {
        let (value, origin) = &self.settings[key as usize];
        (value.as_ref(), origin)
    }
}

/// The value of a key in a file.
fn at(values: &Table, key: Key) -> Option<&Value> {
    match key.section() {
        (None, name) => values.get(name),
        (Some(section), name) => values.get(section)?.as_table()?.get(name),
    }
}

/// The defaults of the table of keys, by path.
fn defaults() -> Table {
    let defaults = Key::ALL.iter().filter_map(|key| Some(format!("{:?} = {}\n", key.path(), key.default()?)));
    defaults.collect::<String>().parse().unwrap_or_default()
}

fn host_name() -> String {
    let name = std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
    let name = name.trim();
    if name.is_empty() { "vibrissa".to_owned() } else { name.to_owned() }
}

/// The file's values. The parser's own message would show the line, possibly with a password.
fn file(path: &Path, text: &str, problems: &mut Vec<Problem>) -> Table {
    let mut whole = |what: String| {
        problems.push(Problem { key: String::new(), origin: Origin::File(path.to_owned()), what });
        Table::new()
    };
    if text.len() > FILE_MAX_BYTES {
        return whole(format!("is larger than {} KiB: is it the configuration file?", FILE_MAX_BYTES / 1024));
    }
    match text.parse::<Table>() {
        Ok(values) => {
            unknown_keys(path, "", &values, problems);
            values
        }
        Err(problem) => {
            let what = plain::in_file(text, problem.span(), problem.message());
            whole(format!("{what}; correct the TOML there"))
        }
    }
}

/// Keys of earlier versions, and what to do instead.
const REMOVED: [(&str, &str); 1] = [(
    "fleet.shards",
    "a fleet has one owner and no shards any more: remove this key, and give the parts of a large site as several fleets, \
     such as fleets = [\"hall-1\", \"hall-2\"]",
)];

/// What to do about a key that is not known.
fn unknown_key(key: &str) -> String {
    match REMOVED.iter().find(|(removed, _)| *removed == key) {
        Some((_, instead)) => (*instead).to_owned(),
        None => format!("no such key{}", did_you_mean(key, Key::ALL.iter().map(|key| key.path()))),
    }
}

fn unknown_keys(path: &Path, parent: &str, values: &Table, problems: &mut Vec<Problem>) {
    for (name, value) in values {
        let key = if parent.is_empty() { name.clone() } else { format!("{parent}.{name}") };
        if Key::at(&key).is_some() {
            continue;
        }
        let is_section = parent.is_empty() && Key::ALL.iter().any(|known| known.section().0 == Some(name.as_str()));
        let had_keys =
            REMOVED.iter().any(|(removed, _)| removed.strip_prefix(&*key).is_some_and(|rest| rest.starts_with('.')));
        let what = match value {
            Value::Table(values) if is_section || had_keys => {
                unknown_keys(path, &key, values, problems);
                continue;
            }
            _ if is_section => format!("is a section: write [{name}] and its keys below it"),
            Value::Table(_) => {
                let sections = Key::ALL.iter().filter_map(|key| key.section().0);
                format!("no such section{}", did_you_mean(&key, sections))
            }
            Value::String(_)
            | Value::Integer(_)
            | Value::Float(_)
            | Value::Boolean(_)
            | Value::Datetime(_)
            | Value::Array(_) => unknown_key(&key),
        };
        let key = if key.chars().count() > 100 { key.chars().take(100).chain("...".chars()).collect() } else { key };
        problems.push(Problem { key, origin: Origin::File(path.to_owned()), what });
    }
}

/// An empty variable counts as unset.
fn environment(variables: &[(String, String)], key: Key) -> Option<Value> {
    let (_, text) = variables.iter().find(|(name, text)| name == key.environment() && !text.is_empty())?;
    Some(written(key.kind(), std::slice::from_ref(text)))
}

/// Of a repeated flag the last one counts.
fn flag(flags: &[(Key, Vec<String>)], key: Key) -> Option<Value> {
    let (_, texts) = flags.iter().rfind(|(known, _)| *known == key)?;
    Some(written(key.kind(), texts))
}

/// The value that a text stands for. An invalid one stays a text, and is refused as such.
fn written(kind: ValueKind, texts: &[String]) -> Value {
    let text = texts.last().map(String::as_str).unwrap_or_default();
    match kind {
        ValueKind::Text | ValueKind::Secret | ValueKind::DatabaseUrl | ValueKind::File => text.into(),
        ValueKind::Texts | ValueKind::Files => {
            let items = texts.iter().flat_map(|text| text.split(',')).map(str::trim).filter(|text| !text.is_empty());
            // One entry too many refuses the whole list, so the rest can be dropped.
            items.take(LIST_MAX + 1).map(str::to_owned).collect::<Vec<String>>().into()
        }
        ValueKind::Number { .. } => text.parse::<f64>().map_or_else(|_| text.into(), Into::into),
        ValueKind::Whole { .. } => text.parse::<i64>().map_or_else(|_| text.into(), Into::into),
    }
}

/// Unknown variables cause only warnings: Kubernetes sets some for every service of a namespace.
fn unknown_variables(variables: &[(String, String)]) -> Vec<String> {
    let is_known = |name: &str| Key::ALL.iter().any(|key| key.environment() == name) || KNOWN_ELSEWHERE.contains(&name);
    let foreign = variables.iter().map(|(name, _)| name.as_str());
    let foreign = foreign.filter(|name| name.starts_with(ENVIRONMENT_PREFIX) && !is_known(name));
    let warnings = foreign.map(|name| {
        let meant = did_you_mean(name, Key::ALL.iter().map(|key| key.environment()));
        format!("the environment variable {} is unknown and ignored{meant}", name.escape_debug())
    });
    warnings.collect()
}
