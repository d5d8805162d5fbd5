//! Writes values of a whisker into the text of `agent.toml`, and leaves all other text as it is.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};
use vibrissa_protocol::Name;

/// The text with a value of a whisker, as TOML, at a key such as `segmenter.sign`.
///
/// # Errors
/// A sentence: where the value cannot be written.
pub(super) fn with_value(text: &str, array: &Name, whisker: u16, key: &str, value: &str) -> Result<String, String> {
    let file = DeTable::parse(text).map_err(|problem| problem.message().to_owned())?;
    let place = || format!("whisker {array}/{whisker} is not found in the file");
    let found = whisker_in(file.get_ref(), array, whisker).ok_or_else(place)?;
    let table = found.get_ref().as_table().ok_or_else(place)?;
    if let Some(old) = value_at(table, key) {
        return Ok(spliced(text, old, value));
    }
    let number = table.get("whisker").ok_or_else(place)?.span();
    let is_inline = text.get(found.span()).is_some_and(|inside| inside.starts_with('{'));
    if is_inline {
        return Ok(spliced(text, number.end..number.end, &format!(", {key} = {value}")));
    }
    let line_end = text[number.end..].find('\n').map_or(text.len(), |at| number.end + at);
    // A line may end with a carriage return.
    let line_end = line_end - usize::from(text[..line_end].ends_with('\r'));
    let line_start = text[..number.start].rfind('\n').map_or(0, |at| at + 1);
    let indent: String = text[line_start..].chars().take_while(|one| matches!(one, ' ' | '\t')).collect();
    Ok(spliced(text, line_end..line_end, &format!("\n{indent}{key} = {value}")))
}

/// The text without a key of a whisker that has no dots; the same text if the key is not there.
///
/// # Errors
/// A sentence: the whisker is not found.
pub(super) fn without(text: &str, array: &Name, whisker: u16, key: &str) -> Result<String, String> {
    let file = DeTable::parse(text).map_err(|problem| problem.message().to_owned())?;
    let place = || format!("whisker {array}/{whisker} is not found in the file");
    let found = whisker_in(file.get_ref(), array, whisker).ok_or_else(place)?;
    let table = found.get_ref().as_table().ok_or_else(place)?;
    let Some((name, value)) = table.iter().find(|(name, _)| name.get_ref() == key) else { return Ok(text.to_owned()) };
    let (from, to) = (name.span().start, value.span().end);
    if !text.get(found.span()).is_some_and(|inside| inside.starts_with('{')) {
        // A line of its own, with its comment.
        let line_start = text[..from].rfind('\n').map_or(0, |at| at + 1);
        let line_end = text[to..].find('\n').map_or(text.len(), |at| to + at + 1);
        return Ok(spliced(text, line_start..line_end, ""));
    }
    // With the comma behind it, or of the last key with the one before.
    let rest = text[to..].trim_start();
    Ok(match rest.strip_prefix(',') {
        Some(rest) => spliced(text, from..text.len() - rest.trim_start().len(), ""),
        None => {
            let before = text[..from].trim_end();
            spliced(text, before.strip_suffix(',').unwrap_or(before).len()..to, "")
        }
    })
}

fn whisker_in<'a, 'i>(file: &'a DeTable<'i>, array: &Name, whisker: u16) -> Option<&'a Spanned<DeValue<'i>>> {
    let has = |table: &DeTable<'_>, key: &str, value: &str| match table.get(key).map(Spanned::get_ref) {
        Some(DeValue::String(text)) => text == value,
        Some(DeValue::Integer(number)) => number.as_str() == value,
        Some(_) | None => false,
    };
    let arrays = file.get("arrays")?.get_ref().as_array()?;
    let arrays = arrays.iter().filter_map(|one| one.get_ref().as_table());
    let array = arrays.into_iter().find(|one| has(one, "array", array.as_str()))?;
    let number = whisker.to_string();
    let is_it =
        |one: &&Spanned<DeValue<'_>>| one.get_ref().as_table().is_some_and(|table| has(table, "whisker", &number));
    array.get("whiskers")?.get_ref().as_array()?.iter().find(is_it)
}

/// Place of the value at a key with dots.
fn value_at(table: &DeTable<'_>, key: &str) -> Option<Range<usize>> {
    match key.split_once('.') {
        Some((first, rest)) => value_at(table.get(first)?.get_ref().as_table()?, rest),
        None => Some(table.get(key)?.span()),
    }
}

fn spliced(text: &str, at: Range<usize>, with: &str) -> String {
    [&text[..at.start], with, &text[at.end..]].concat()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::Config;
    use crate::config::Sign;
    use crate::config::tests::EXAMPLE;

    fn left() -> Name {
        Name::new("left").unwrap()
    }

    #[test]
    fn a_value_is_written_into_an_inline_table_and_replaced_later() {
        let sign = |text: &str| Config::from_toml_str(text, Path::new("")).unwrap().whiskers[&(left(), 1)].sign;
        let text = with_value(EXAMPLE, &left(), 1, "segmenter.sign", "\"FALLS\"").unwrap();
        assert_eq!(text, EXAMPLE.replacen("whisker = 1,", "whisker = 1, segmenter.sign = \"FALLS\",", 1));
        assert_eq!(sign(&text), Some(Sign::Falls));
        let again = with_value(&text, &left(), 1, "segmenter.sign", "\"RISES\"").unwrap();
        assert_eq!(again, text.replacen("FALLS", "RISES", 1));
        let nested = text.replacen("segmenter.sign = \"FALLS\"", "segmenter = { sign = \"FALLS\" }", 1);
        assert_eq!(sign(&with_value(&nested, &left(), 1, "segmenter.sign", "\"RISES\"").unwrap()), Some(Sign::Rises));
    }

    #[test]
    fn a_value_is_written_below_the_number_of_a_table_with_its_comment() {
        for end in ["\n", "\r\n"] {
            let text =
                ["[[arrays]]", "array = \"left\"", "  [[arrays.whiskers]]", "  whisker = 0 # first", "  length_mm = 7"]
                    .join(end);
            let expected = text.replacen("first", "first\n  strain_max = 0.01", 1);
            assert_eq!(with_value(&text, &left(), 0, "strain_max", "0.01"), Ok(expected));
        }
    }

    #[test]
    fn regress_a_key_is_removed_where_it_stands() {
        let with = with_value(EXAMPLE, &left(), 1, "strain_max", "0.012").unwrap();
        assert_eq!(without(&with, &left(), 1, "strain_max").unwrap(), EXAMPLE);
        assert_eq!(without(EXAMPLE, &left(), 1, "strain_max").unwrap(), EXAMPLE);
        let inline = |keys: &str| format!("[[arrays]]\narray = \"left\"\nwhiskers = [{{ {keys} }}]\n");
        let last = inline("whisker = 0, strain_max = 0.01");
        assert_eq!(without(&last, &left(), 0, "strain_max").unwrap(), inline("whisker = 0"));
        let first = inline("strain_max = 0.01 , whisker = 0");
        assert_eq!(without(&first, &left(), 0, "strain_max").unwrap(), inline("whisker = 0"));
        for end in ["\n", "\r\n"] {
            let lines =
                ["[[arrays]]", "array = \"left\"", "[[arrays.whiskers]]", "whisker = 0", "strain_max = 1e-2 # end"];
            let text = [&lines[..], &["length_mm = 7", ""]].concat().join(end);
            let expected = [&lines[..4], &["length_mm = 7", ""]].concat().join(end);
            assert_eq!(without(&text, &left(), 0, "strain_max").unwrap(), expected);
        }
    }

    #[test]
    fn a_whisker_that_is_not_there_is_named() {
        let problem = with_value(EXAMPLE, &left(), 7, "strain_max", "0.01").unwrap_err();
        assert_eq!(problem, "whisker left/7 is not found in the file");
    }
}
