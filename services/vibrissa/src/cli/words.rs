//! Closed words on the command line.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use vibrissa_edge::words::{Word, Words};

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
    use clap::{Command, CommandFactory};
    use vibrissa_simulator::options::lenient;

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
    fn every_option_of_every_command_takes_numbers_below_zero_and_words_in_any_case() {
        let mut seen = 0;
        options(&lenient(crate::cli::Cli::command()), &mut seen);
        assert!(seen > 100, "{seen} options");
    }
}
