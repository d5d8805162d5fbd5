//! The configuration's flags, and `vibrissa config`.

use std::io::Write;
use std::path::PathBuf;

use clap::{Arg, ArgAction, ArgMatches, Args, Command, Error, FromArgMatches};
use vibrissa_protocol::plain;
use vibrissa_protocol::text_file::read_text;
use vibrissa_store::DatabaseAddress;

use crate::config::keys::ValueKind;
use crate::config::{self, Config, Key, Origin, Problem, Problems, Sources, show};

/// Size limit of the configuration file, bytes.
const FILE_BYTES_MAX: u64 = 1024 * 1024;

/// `--config` and a flag for every key.
#[derive(Clone)]
pub struct ConfigArgs {
    file: Option<PathBuf>,
    flags: Vec<(Key, Vec<String>)>,
}

impl std::fmt::Debug for ConfigArgs {
    /// Omits the values: one may be a password.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let keys = self.flags.iter().map(|(key, _)| key);
        f.debug_struct("ConfigArgs").field("file", &self.file).field("flags", &keys.collect::<Vec<_>>()).finish()
    }
}

const FILE: &str = "config";

impl Args for ConfigArgs {
    fn augment_args(command: Command) -> Command {
        augmented(command, Key::ALL)
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

/// The command with `--config` and a flag for each of these keys.
fn augmented(command: Command, keys: &[Key]) -> Command {
    command.arg(file()).args(keys.iter().map(|&key| flag(key)))
}

/// Heading of the key's flag in the help.
fn heading(key: Key) -> &'static str {
    match key.section().0 {
        None => "General settings",
        Some("database" | "lease") => "Database",
        Some("contacts" | "rollups") => "History",
        Some("limits") => "Limits",
        Some("mqtt") => "MQTT broker",
        Some("http") => "HTTP",
        Some("metrics" | "traces") => "Metrics and traces",
        Some("model") => "Model",
        Some("policy") => "Policy of compensations",
        Some("detection") => "Detection",
        Some("touch_tests") => "Touch tests",
        Some(_) => "Other settings",
    }
}

fn file() -> Arg {
    Arg::new(FILE)
        .long("config")
        .env("VIBRISSA_CONFIG")
        .value_name("FILE")
        .value_parser(clap::value_parser!(PathBuf))
        .help_heading("General settings")
        .help("Configuration file (TOML); none is read by default")
}

fn flag(key: Key) -> Arg {
    let default = key.default().map(|default| format!(" [default: {default}]")).unwrap_or_default();
    let flag = Arg::new(key.path())
        .long(key.flag())
        .value_name("VALUE")
        .help_heading(heading(key))
        .help(format!("{}{default} [{}]", key.help(), key.environment()))
        .action(if key.kind().is_list() { ArgAction::Append } else { ArgAction::Set });
    // A secret given as a flag, with or without a value, is answered with a hint to use a file instead.
    let flag = if key.kind() == ValueKind::Secret {
        flag.hide(true).num_args(0..=1).default_missing_value("").allow_hyphen_values(true)
    } else {
        flag
    };
    match key.flag_alias() {
        Some(alias) => flag.visible_alias(alias),
        None => flag,
    }
}

impl FromArgMatches for ConfigArgs {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, Error> {
        Ok(Self::of(matches, Key::ALL))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

/// Defines the flags of commands that use only some keys. The configuration file may still have all keys.
macro_rules! some_flags {
    ($($(#[$meta:meta])* $name:ident = $keys:expr;)+) => { $(
        $(#[$meta])*
        #[derive(Debug, Clone)]
        pub struct $name(ConfigArgs);

        impl Args for $name {
            fn augment_args(command: Command) -> Command {
                augmented(command, &$keys)
            }

            fn augment_args_for_update(command: Command) -> Command {
                Self::augment_args(command)
            }
        }

        impl FromArgMatches for $name {
            fn from_arg_matches(matches: &ArgMatches) -> Result<Self, Error> {
                Ok(Self(ConfigArgs::of(matches, &$keys)))
            }

            fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
                *self = Self::from_arg_matches(matches)?;
                Ok(())
            }
        }

        impl std::ops::Deref for $name {
            type Target = ConfigArgs;

            fn deref(&self) -> &ConfigArgs {
                &self.0
            }
        }
    )+ };
}

some_flags! {
    /// The flags that select the database.
    DatabaseArgs = [Key::DatabaseUrl, Key::DatabasePasswordFile];
    /// The flags of a client of the broker, for `record`.
    BrokerArgs = BROKER_KEYS;
    /// The same with the port of the embedded broker, for `check-robot`.
    BrokerOrPortArgs = with_port();
    /// The flags that select fleets, and the parameters of the core, for `replay`.
    CoreArgs = core_keys();
}

const BROKER_KEYS: [Key; 9] = [
    Key::Fleets,
    Key::Log,
    Key::MqttUrl,
    Key::MqttUsername,
    Key::MqttPassword,
    Key::MqttPasswordFile,
    Key::MqttCaFile,
    Key::MqttClientCertificateFile,
    Key::MqttClientKeyFile,
];

fn with_port() -> Vec<Key> {
    BROKER_KEYS.into_iter().chain([Key::MqttPort]).collect()
}

fn core_keys() -> Vec<Key> {
    let is_core = |key: &Key| {
        let section = key.section().0;
        matches!(key, Key::Fleets | Key::Calibrations)
            || section.is_some_and(|section| ["model", "policy", "detection", "touch_tests"].contains(&section))
    };
    Key::ALL.iter().copied().filter(is_core).collect()
}

impl ConfigArgs {
    fn of(matches: &ArgMatches, keys: &[Key]) -> Self {
        let given = |key: Key| {
            let texts = matches.get_many::<String>(key.path())?;
            Some((key, texts.cloned().collect()))
        };
        Self {
            file: matches.get_one::<PathBuf>(FILE).cloned(),
            flags: keys.iter().copied().filter_map(given).collect(),
        }
    }

    /// Reads the configuration; warnings go to standard error.
    ///
    /// # Errors
    /// Lists all problems of the configuration.
    pub fn read(&self) -> Result<Config, Problems> {
        check(&self.sources()?)
    }

    /// The database in the configuration. An SQLite file must exist: a command that only reads rows, or changes some, would
    /// create an empty one, and find nothing there.
    ///
    /// # Errors
    /// The configuration is invalid, or there is no such file.
    pub fn read_database(&self) -> anyhow::Result<DatabaseAddress> {
        let database = self.read()?.database;
        if let Some(path) = missing(&database) {
            let advice = "name that of the supervisor with --database-url sqlite:FILE, or with --config FILE";
            anyhow::bail!("there is no database {}: {advice}", path.display());
        }
        Ok(database)
    }

    /// Whether a key was given as a flag.
    #[must_use]
    pub fn is_given(&self, key: Key) -> bool {
        self.flags.iter().any(|(given, _)| *given == key)
    }

    fn sources(&self) -> Result<Sources, Problems> {
        let mut problems = Vec::new();
        let file = self.file.clone().and_then(|path| match read_text(&path, FILE_BYTES_MAX) {
            Ok(text) => Some((path, text)),
            Err(problem) => {
                let what = format!(
                    "the configuration file cannot be read: {}; correct --config or VIBRISSA_CONFIG",
                    plain::io(&problem)
                );
                problems.push(Problem { key: String::new(), origin: Origin::File(path), what });
                None
            }
        });
        let mut environment = Vec::new();
        for (name, value) in std::env::vars_os() {
            let Ok(name) = name.into_string() else { continue };
            match value.into_string() {
                Ok(value) => environment.push((name, value)),
                Err(_) => problems.extend(
                    Key::ALL
                        .iter()
                        .copied()
                        .find(|key| key.environment() == name)
                        .map(|key| Problem::new(key, Origin::Environment(name), "is not UTF-8: write it in UTF-8")),
                ),
            }
        }
        if problems.is_empty() {
            Ok(Sources { file, environment, flags: self.flags.clone() })
        } else {
            Err(Problems(problems))
        }
    }
}

/// The whole path of an SQLite file that does not exist.
pub(super) fn missing(database: &DatabaseAddress) -> Option<PathBuf> {
    let DatabaseAddress::Sqlite(path) = database else { return None };
    (!path.exists()).then(|| std::path::absolute(path).unwrap_or_else(|_| path.clone()))
}

fn check(sources: &Sources) -> Result<Config, Problems> {
    let reading = config::read(sources);
    for warning in &reading.warnings {
        eprintln!("vibrissa: {warning}");
    }
    reading.config
}

/// Prints the configuration in effect.
///
/// # Errors
/// The configuration is invalid, or standard output is closed.
pub fn run(args: &ConfigArgs, out: &mut impl Write) -> anyhow::Result<()> {
    let sources = args.sources()?;
    check(&sources)?;
    let rust_log = std::env::var("RUST_LOG").ok();
    // Without a context: a closed pipe is not worth an explanation.
    out.write_all(show::effective(&sources, rust_log.as_deref()).as_bytes())?;
    Ok(out.flush()?)
}
