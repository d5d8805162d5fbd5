//! Closed words on the command line.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use vibrissa_edge::words::{Word, Words};

/// Takes the word of one of these values. An error lists all words.
pub fn one_of<T: Copy + Send + Sync + 'static>(
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
pub fn word_of<T: Words + Copy + Send + Sync>() -> impl TypedValueParser<Value = T> {
    one_of(T::all(), <T as Word>::word)
}
