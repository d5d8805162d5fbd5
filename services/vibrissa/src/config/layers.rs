//! The four layers of the configuration: defaults, file, environment, flags. Each value remembers its origin.

use std::path::{Path, PathBuf};

use figment::providers::{Format, Toml};
use figment::value::{Dict, Map, Value};
use figment::{Figment, Metadata, Profile, Provider};

use super::keys::{ENVIRONMENT_PREFIX, Key, Kind};
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

/// The merged layers, and the problems found so far.
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
        let mut figment = Figment::new().merge(Layer { metadata: Metadata::named(DEFAULT), values: defaults() });
        if let Some((path, text)) = &sources.file {
            let values = file(path, text, &mut problems);
            let metadata = Metadata::from(FILE, figment::Source::File(path.clone()));
            figment = figment.merge(Layer { metadata, values });
        }
        let environment = environment(&sources.environment);
        let metadata = Metadata::named(ENVIRONMENT).interpolater(|_, keys| name(keys, |key| key.environment()));
        figment = figment.merge(Layer { metadata, values: environment });
        let metadata = Metadata::named(FLAG).interpolater(|_, keys| name(keys, |key| key.flag()));
        figment = figment.merge(Layer { metadata, values: flags(&sources.flags) });
        Self { settings: settings(&figment), problems, warnings: unknown_variables(&sources.environment) }
    }

    /// A key's value, if it is set, and its origin.
    pub(super) fn find(&self, key: Key) -> (Option<&Value>, &Origin) {
        let (value, origin) = &self.settings[key as usize];
        (value.as_ref(), origin)
    }
}

/// The merged value of every key. Extracted once, because each look-up in the layers copies their content.
fn settings(figment: &Figment) -> Vec<(Option<Value>, Origin)> {
    let merged = figment.data().ok().and_then(|mut profiles| profiles.remove(&Profile::Default));
    let merged = Value::from(merged.unwrap_or_default());
    let setting = |&key: &Key| match merged.find_ref(key.path()) {
        Some(value) => (Some(value.clone()), origin(figment, key, value)),
        None => (None, Origin::Default),
    };
    Key::ALL.iter().map(setting).collect()
}

fn origin(figment: &Figment, key: Key, value: &Value) -> Origin {
    let Some(metadata) = figment.get_metadata(value.tag()) else { return Origin::Default };
    let keys: Vec<&str> = key.path().split('.').collect();
    let name = || metadata.interpolate(&Profile::Default, &keys);
    match (&*metadata.name, metadata.source.as_ref().and_then(figment::Source::file_path)) {
        (FILE, Some(path)) => Origin::File(path.to_owned()),
        (ENVIRONMENT, _) => Origin::Environment(name()),
        (FLAG, _) => Origin::Flag(name()),
        _ => Origin::Default,
    }
}

const DEFAULT: &str = "default";
const FILE: &str = "file";
const ENVIRONMENT: &str = "environment";
const FLAG: &str = "flag";

/// Values with the description of their source.
struct Layer {
    metadata: Metadata,
    values: Dict,
}

impl Provider for Layer {
    fn metadata(&self) -> Metadata {
        self.metadata.clone()
    }

    fn data(&self) -> Result<Map<Profile, Dict>, figment::Error> {
        Ok(Profile::Default.collect(self.values.clone()))
    }
}

fn name(keys: &[&str], of: fn(Key) -> &'static str) -> String {
    Key::at(&keys.join(".")).map_or_else(|| keys.join("."), |key| of(key).to_owned())
}

fn put(values: &mut Dict, key: Key, value: Value) {
    match key.section() {
        (None, name) => {
            values.insert(name.to_owned(), value);
        }
        (Some(section), name) => {
            let section = values.entry(section.to_owned()).or_insert_with(|| Dict::new().into());
            if let Value::Dict(_, section) = section {
                section.insert(name.to_owned(), value);
            }
        }
    }
}

fn defaults() -> Dict {
    let mut values = Dict::new();
    for &key in Key::ALL {
        let default = key.default().and_then(|text| {
            let line: Dict = Toml::from_str(&format!("value = {text}")).ok()?;
            line.get("value").cloned()
        });
        if let Some(value) = default {
            put(&mut values, key, value);
        }
    }
    let name = host_name().unwrap_or_else(|| "vibrissa".to_owned());
    put(&mut values, Key::Name, name.into());
    values
}

fn host_name() -> Option<String> {
    let name = std::fs::read_to_string("/proc/sys/kernel/hostname").ok()?;
    Some(name.trim().to_owned()).filter(|name| !name.is_empty())
}

/// The file's values. The parser's own message would show the line, possibly with a password.
fn file(path: &Path, text: &str, problems: &mut Vec<Problem>) -> Dict {
    let mut whole = |what: String| {
        problems.push(Problem { key: String::new(), origin: Origin::File(path.to_owned()), what });
        Dict::new()
    };
    if text.len() > FILE_MAX_BYTES {
        return whole(format!("is larger than {} KiB: is it the configuration file?", FILE_MAX_BYTES / 1024));
    }
    match Toml::from_str::<Dict>(text) {
        Ok(values) => {
            unknown_keys(path, "", &values, problems);
            values
        }
        Err(problem) => {
            let before = problem.span().and_then(|span| text.get(..span.start)).unwrap_or_default();
            let line = before.matches('\n').count() + 1;
            whole(format!("line {line}: {}; correct the TOML there", problem.message()))
        }
    }
}

fn unknown_keys(path: &Path, parent: &str, values: &Dict, problems: &mut Vec<Problem>) {
    for (name, value) in values {
        let key = if parent.is_empty() { name.clone() } else { format!("{parent}.{name}") };
        if Key::at(&key).is_some() {
            continue;
        }
        let is_section = parent.is_empty() && Key::ALL.iter().any(|known| known.section().0 == Some(name.as_str()));
        let what = match value {
            Value::Dict(_, values) if is_section => {
                unknown_keys(path, &key, values, problems);
                continue;
            }
            _ if is_section => format!("is a section: write [{name}] and its keys below it"),
            Value::Dict(..) => {
                let sections = Key::ALL.iter().filter_map(|key| key.section().0);
                format!("no such section{}", did_you_mean(&key, sections))
            }
            Value::String(..)
            | Value::Char(..)
            | Value::Bool(..)
            | Value::Num(..)
            | Value::Empty(..)
            | Value::Array(..) => {
                format!("no such key{}", did_you_mean(&key, Key::ALL.iter().map(|key| key.path())))
            }
        };
        let key = if key.chars().count() > 100 { key.chars().take(100).chain("...".chars()).collect() } else { key };
        problems.push(Problem { key, origin: Origin::File(path.to_owned()), what });
    }
}

/// An empty variable counts as unset.
fn environment(variables: &[(String, String)]) -> Dict {
    let mut values = Dict::new();
    for &key in Key::ALL {
        let named = |(name, text): &&(String, String)| name == key.environment() && !text.is_empty();
        if let Some((_, text)) = variables.iter().find(named) {
            put(&mut values, key, written(key.kind(), std::slice::from_ref(text)));
        }
    }
    values
}

fn flags(flags: &[(Key, Vec<String>)]) -> Dict {
    let mut values = Dict::new();
    for (key, texts) in flags {
        put(&mut values, *key, written(key.kind(), texts));
    }
    values
}

/// The value that a text stands for. An invalid one stays a text, and is refused as such.
fn written(kind: Kind, texts: &[String]) -> Value {
    let text = texts.last().map(String::as_str).unwrap_or_default();
    match kind {
        Kind::Text | Kind::Secret | Kind::DatabaseUrl | Kind::File => text.into(),
        Kind::Texts | Kind::Files => {
            let items = texts.iter().flat_map(|text| text.split(',')).map(str::trim).filter(|text| !text.is_empty());
            // One entry too many refuses the whole list, so the rest can be dropped.
            items.take(LIST_MAX + 1).map(str::to_owned).collect::<Vec<String>>().into()
        }
        Kind::Number { .. } => text.parse::<f64>().map_or_else(|_| text.into(), Into::into),
        Kind::Whole { .. } => text.parse::<i64>().map_or_else(|_| text.into(), Into::into),
    }
}

/// Unknown variables cause only warnings: Kubernetes sets some for every service of a namespace.
fn unknown_variables(variables: &[(String, String)]) -> Vec<String> {
    let is_known = |name: &str| Key::ALL.iter().any(|key| key.environment() == name) || KNOWN_ELSEWHERE.contains(&name);
    let foreign = variables.iter().map(|(name, _)| name.as_str());
    let foreign = foreign.filter(|name| name.starts_with(ENVIRONMENT_PREFIX) && !is_known(name));
    let told = foreign.map(|name| {
        let meant = did_you_mean(name, Key::ALL.iter().map(|key| key.environment()));
        format!("the environment variable {} is unknown and ignored{meant}", name.escape_debug())
    });
    told.collect()
}
