//! The log filter: levels, and levels of parts of the program.

use tracing_subscriber::EnvFilter;

/// Levels of the log, from silence to everything.
const LEVELS: [&str; 6] = ["off", "error", "warn", "info", "debug", "trace"];

/// Checks a log filter: parts separated by commas, each a level or `TARGET=LEVEL`. `EnvFilter` alone takes a misspelt
/// level for the name of a target, and a number for a level.
///
/// # Errors
/// A part is invalid.
pub fn log_filter(text: &str) -> Result<String, String> {
    // Filters of spans, such as target[span{field=value}]=level, may have commas and equal signs in their brackets.
    let text = if text.contains('[') {
        text.to_owned()
    } else {
        let parts: Vec<&str> = text.split(',').map(str::trim).collect();
        parts.iter().try_for_each(|part| check(part))?;
        parts.join(",")
    };
    let parsed = EnvFilter::try_new(&text);
    parsed.map(|_| text).map_err(|problem| format!("is not a log filter ({problem}): {}", example()))
}

fn check(part: &str) -> Result<(), String> {
    let bad = |what: String| Err(format!("is not a log filter: {what}; {}", example()));
    match part.split_once('=') {
        None if is_level(part) => Ok(()),
        None if part.is_empty() => bad("it has an empty part".to_owned()),
        None => bad(format!("{part:?} is not a level")),
        Some((target, _)) if !is_target(target) => bad(format!("{target:?} in {part:?} is not the name of a module")),
        Some((_, level)) if is_level(level) => Ok(()),
        Some((_, level)) => bad(format!("{level:?} in {part:?} is not a level")),
    }
}

fn is_level(text: &str) -> bool {
    LEVELS.iter().any(|level| level.eq_ignore_ascii_case(text))
}

fn is_target(text: &str) -> bool {
    !text.is_empty() && text.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | ':'))
}

fn example() -> String {
    format!("the levels are {}: write one, such as info, or info,vibrissa=debug", LEVELS.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_and_targets_are_accepted() {
        for good in ["info", "WARN", "off", "info,vibrissa=debug", "vibrissa_core::robot=trace"] {
            assert_eq!(log_filter(good).as_deref(), Ok(good));
        }
        assert_eq!(log_filter("error, mqtt5=error").as_deref(), Ok("error,mqtt5=error"));
        assert!(log_filter("warn,vibrissa[request]=debug").is_ok());
    }

    #[test]
    fn the_bad_part_is_named_with_the_levels() {
        for (bad, part) in [
            ("blah=5", "\"5\" in \"blah=5\" is not a level"),
            ("info,vibrissa=loud", "\"loud\" in \"vibrissa=loud\" is not a level"),
            ("blah", "\"blah\" is not a level"),
            ("infoo,vibrissa=debug", "\"infoo\" is not a level"),
            ("3", "\"3\" is not a level"),
            ("info,,warn", "it has an empty part"),
            ("=info", "\"\" in \"=info\" is not the name of a module"),
            ("a b=info", "\"a b\" in \"a b=info\" is not the name of a module"),
            ("vibrissa=", "\"\" in \"vibrissa=\" is not a level"),
        ] {
            let problem = log_filter(bad).unwrap_err();
            assert!(
                problem.contains(part) && problem.contains("off, error, warn, info, debug, trace"),
                "{bad}: {problem}"
            );
        }
    }
}
