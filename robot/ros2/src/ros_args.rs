//! Arguments of ROS, as rcl reads them: `--ros-args -r from:=to -p name:=value --params-file FILE --`.

use std::path::PathBuf;

use crate::params::{Override, Source};
use crate::remap::Rule;

/// Severities of ROS, the lowest first.
const LEVELS: [&str; 6] = ["UNSET", "DEBUG", "INFO", "WARN", "ERROR", "FATAL"];
/// The place of WARN in [`LEVELS`]: problems of single messages have it.
const WARN: usize = 3;

/// What `--ros-args` says.
#[derive(Debug, Default, PartialEq)]
pub struct RosArguments {
    /// Rules for names, in their order: the first that fits counts.
    pub rules: Vec<Rule>,
    /// Parameters and files of parameters, in their order: the last value counts.
    pub parameters: Vec<Source>,
    /// Levels, as pairs of a logger (empty: all) and a place in [`LEVELS`].
    levels: Vec<(String, usize)>,
}

/// Divides the words of the command line into those of the program and those of ROS.
#[must_use]
pub fn split(words: impl IntoIterator<Item = String>) -> (Vec<String>, Vec<String>) {
    let (mut own, mut ros, mut is_ros) = (Vec::new(), Vec::new(), false);
    for word in words {
        match (is_ros, word.as_str()) {
            (_, "--ros-args") => is_ros = true,
            (true, "--") => is_ros = false,
            (true, _) => ros.push(word),
            (false, _) => own.push(word),
        }
    }
    (own, ros)
}

fn level(text: &str) -> Result<(String, usize), String> {
    let (logger, name) = text.rsplit_once(":=").unwrap_or(("", text));
    let place = LEVELS.iter().position(|level| level.eq_ignore_ascii_case(name));
    let place = place.ok_or_else(|| format!("--log-level {text}: give one of {}", LEVELS.join(", ")))?;
    Ok((logger.to_owned(), place))
}

impl RosArguments {
    /// Reads the words between `--ros-args` and `--`.
    ///
    /// # Errors
    /// A word is unknown, or its value is invalid; the error is a text.
    pub fn read(words: &[String]) -> Result<Self, String> {
        let mut read = Self::default();
        let mut words = words.iter();
        while let Some(word) = words.next() {
            let mut value = |form: &str| words.next().ok_or_else(|| format!("--ros-args: {word} needs {form}"));
            match word.as_str() {
                "-r" | "--remap" => read.rules.push(Rule::parse(value("from:=to")?)?),
                "-p" | "--param" => read.parameters.push(Source::Value(Override::parse(value("name:=value")?)?)),
                "--params-file" => read.parameters.push(Source::File(PathBuf::from(value("a file")?))),
                "--log-level" => read.levels.push(level(value("a level")?)?),
                // The log goes to standard error alone.
                "--enable-rosout-logs" | "--disable-rosout-logs" => {}
                "--enable-stdout-logs" | "--disable-stdout-logs" => {}
                "--enable-external-lib-logs" | "--disable-external-lib-logs" => {}
                "--log-config-file" => return Err("--log-config-file: the log has no configuration".to_owned()),
                "-e" | "--enclave" => return Err(format!("{word}: this program does not use SROS 2")),
                other => {
                    let known = "-r, -p, --params-file, --log-level";
                    return Err(format!("--ros-args: {other} is unknown; known are {known}, and -- ends them"));
                }
            }
        }
        Ok(read)
    }

    /// Whether warnings are logged by the node whose logger has this name, such as `crawler.vibrissa`.
    #[must_use]
    pub fn logs_warnings(&self, logger: &str) -> bool {
        let of = |name: &str| self.levels.iter().rfind(|(logger, _)| logger == name).map(|(_, place)| *place);
        of(logger).or_else(|| of("")).is_none_or(|place| place <= WARN)
    }
}
