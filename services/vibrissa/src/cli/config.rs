//! The configuration's flags, and `vibrissa config`.

use std::io::Write;
use std::path::PathBuf;

use clap::{Arg, ArgAction, ArgMatches, Args, Command, Error, FromArgMatches};

use crate::config::keys::Kind;
use crate::config::{self, Config, Key, Origin, Problem, Problems, Sources, show};

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
        command.arg(file()).args(Key::ALL.iter().map(|&key| flag(key)))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

fn file() -> Arg {
    Arg::new(FILE)
        .long("config")
        .env("VIBRISSA_CONFIG")
        .value_name("FILE")
        .value_parser(clap::value_parser!(PathBuf))
        .help("Configuration file (TOML); none is read by default")
}

fn flag(key: Key) -> Arg {
    let default = key.default().map(|default| format!(" [default: {default}]")).unwrap_or_default();
    let flag = Arg::new(key.path())
        .long(key.flag())
        .value_name("VALUE")
        .allow_negative_numbers(true)
        .help(format!("{}{default} [{}]", key.help(), key.environment()))
        .action(if key.kind().is_list() { ArgAction::Append } else { ArgAction::Set });
    // A secret given as a flag, with or without a value, is answered with a hint to use a file instead.
    let flag = if key.kind() == Kind::Secret {
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

/// The flags that select the database, for commands whose own flags would clash with the others.
#[derive(Debug, Clone)]
pub struct DatabaseArgs(ConfigArgs);

/// The keys of these flags.
const DATABASE_KEYS: [Key; 2] = [Key::DatabaseUrl, Key::DatabasePasswordFile];

impl Args for DatabaseArgs {
    fn augment_args(command: Command) -> Command {
        command.arg(file()).args(DATABASE_KEYS.map(flag))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for DatabaseArgs {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, Error> {
        Ok(Self(ConfigArgs::of(matches, &DATABASE_KEYS)))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl DatabaseArgs {
    /// Reads the configuration; warnings go to standard error.
    ///
    /// # Errors
    /// Lists all problems of the configuration.
    pub fn read(&self) -> Result<Config, Problems> {
        self.0.read()
    }
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

    /// Whether a key was given as a flag.
    pub(super) fn is_given(&self, key: Key) -> bool {
        self.flags.iter().any(|(given, _)| *given == key)
    }

    fn sources(&self) -> Result<Sources, Problems> {
        let mut problems = Vec::new();
        let file = self.file.clone().and_then(|path| match std::fs::read_to_string(&path) {
            Ok(text) => Some((path, text)),
            Err(problem) => {
                let what =
                    format!("the configuration file cannot be read: {problem}; correct --config or VIBRISSA_CONFIG");
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
