//! Closed words and numbers on the command line.

use std::ffi::OsString;

use clap::Command;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use vibrissa_edge::words::{Word, Words};

/// Accepts the closed words of all options in any case, and numbers below zero as their values, so that the range check
/// of the option answers them.
pub(super) fn lenient(command: Command) -> Command {
    let lenient_arg = |arg: clap::Arg| {
        let is_option = arg.get_action().takes_values() && !arg.is_positional();
        if is_option { arg.allow_negative_numbers(true).ignore_case(true) } else { arg }
    };
    command.mut_args(lenient_arg).mut_subcommands(lenient)
}

/// Writes a number below zero without an exponent: the parser would take `-1e-3` for an option.
pub(super) fn decimal(argument: OsString) -> OsString {
    let number = argument.to_str().filter(|text| text.starts_with('-')).and_then(|text| text.parse::<f64>().ok());
    number.filter(|number| number.is_finite()).map_or(argument, |number| number.to_string().into())
}

/// Takes the word of one of these values. An error lists all words.
pub(super) fn one_of<T: Copy + Send + Sync + 'static>(
    values: Vec<T>,
    word: fn(T) -> &'static str,
) -> impl TypedValueParser<Value = T> {
    let words: Vec<&'static str> = values.iter().map(|&value| word(value)).collect();
    let named = move |given: String| {
        let found = values.iter().find(|&&value| word(value).eq_ignore_ascii_case(&given));
        found.copied().ok_or("not one of the words")
    };
    PossibleValuesParser::new(words).try_map(named)
}

/// Takes a word of a closed enum of the core.
pub(super) fn word_of<T: Words + Copy + Send + Sync>() -> impl TypedValueParser<Value = T> {
    one_of(T::all(), <T as Word>::word)
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    fn options(command: &Command, seen: &mut u32) {
        for arg in command.get_arguments().filter(|arg| arg.get_action().takes_values() && !arg.is_positional()) {
            let name = format!("{} --{}", command.get_name(), arg.get_id());
            assert!(arg.is_allow_negative_numbers_set(), "{name}");
            assert!(arg.is_ignore_case_set(), "{name}");
            *seen += 1;
        }
        command.get_subcommands().for_each(|command| options(command, seen));
    }

    #[test]
    fn numbers_below_zero_lose_their_exponents_and_options_stay() {
        for (given, taken) in [("-1e-3", "-0.001"), ("-2.5E2", "-250"), ("-0.01", "-0.01"), ("-inf", "-inf")] {
            assert_eq!(decimal(given.into()), taken);
        }
        for option in ["-h", "--url", "1e-3", "-e", "-"] {
            assert_eq!(decimal(option.into()), option);
        }
    }

    #[test]
    fn every_option_of_every_command_takes_numbers_below_zero_and_words_in_any_case() {
        let mut seen = 0;
        options(&lenient(crate::cli::Cli::command()), &mut seen);
        assert!(seen > 100, "{seen} options");
    }
}
