//! Text that is JSON except for some values, made JSON, so that the entries around such a value can be read.
//!
//! Programs of robots write `NaN`, `-inf`, `?`, `.5` or a byte that is not UTF-8 where a number or a name should be. Each
//! such value becomes a text with a control character, which no field of the contract accepts: it is refused there, with
//! its place.

use serde::de::IgnoredAny;

use crate::Refusal;

/// Begin of a text in the place of a value that JSON does not have.
const MARK: char = '\0';
/// [`MARK`] in a text in JSON.
const MARK_IN_TEXT: &str = "\\u0000";
/// Most characters of such a value that are kept.
const SHOWN_CHARS_MAX: usize = 40;

/// The value that stands for one that JSON does not have.
pub(super) fn marked(value: &str) -> String {
    let shown: String = [MARK].into_iter().chain(value.chars().take(SHOWN_CHARS_MAX)).collect();
    serde_json::Value::from(shown).to_string()
}

/// A refusal without the marks.
pub(super) fn with_remedy(mut refusal: Refusal) -> Refusal {
    if let Refusal::Malformed { problem, .. } = &mut refusal {
        *problem = problem.replace("string \"\\0", "\"").replace("\\0", "");
    }
    refusal
}

/// The text with a mark in the place of each value that is not JSON.
pub(super) fn repaired(payload: &[u8]) -> String {
    let mut text = String::with_capacity(payload.len());
    for chunk in payload.utf8_chunks() {
        text.push_str(chunk.valid());
        if !chunk.invalid().is_empty() {
            text.push(MARK);
        }
    }
    let mut out = String::with_capacity(text.len());
    let (mut rest, mut needs_value) = (text.as_str(), false);
    while let Some(first) = rest.chars().next() {
        let length = match first {
            '"' => write_text(rest, &mut out),
            '{' | '}' | '[' | ']' | ',' | ':' => {
                if needs_value && matches!(first, ',' | '}') {
                    out.push_str(&marked("nothing"));
                }
                out.push(first);
                1
            }
            ' ' | '\n' | '\r' | '\t' => {
                out.push(first);
                rest = &rest[1..];
                continue;
            }
            _ => write_word(rest, &mut out),
        };
        needs_value = first == ':';
        rest = &rest[length..];
    }
    out
}

/// Writes a text, and returns its length in the input. What a text in JSON must not have becomes a mark.
fn write_text(rest: &str, out: &mut String) -> usize {
    out.push('"');
    let mut characters = rest.char_indices().skip(1);
    while let Some((at, character)) = characters.next() {
        match character {
            '"' => {
                out.push('"');
                return at + 1;
            }
            '\\' => match characters.next() {
                Some((_, escaped @ ('"' | '\\' | '/' | 'b' | 'f' | 'n' | 'r' | 't'))) => out.extend(['\\', escaped]),
                Some((at, 'u')) if is_hexadecimal(rest, at + 1) => out.push_str("\\u"),
                Some(_) => out.push_str(MARK_IN_TEXT),
                None => break,
            },
            _ if character < ' ' => out.push_str(MARK_IN_TEXT),
            _ => out.push(character),
        }
    }
    rest.len()
}

fn is_hexadecimal(rest: &str, at: usize) -> bool {
    rest.as_bytes().get(at..at + 4).is_some_and(|digits| digits.iter().all(u8::is_ascii_hexdigit))
}

/// Writes a value that is no text, and returns its length in the input.
fn write_word(rest: &str, out: &mut String) -> usize {
    let is_end = |one: char| matches!(one, '"' | '{' | '}' | '[' | ']' | ',' | ':' | ' ' | '\n' | '\r' | '\t');
    let length = rest.find(is_end).unwrap_or(rest.len());
    let word = &rest[..length];
    match serde_json::from_str::<IgnoredAny>(word) {
        Ok(_) => out.push_str(word),
        Err(_) => out.push_str(&marked(word)),
    }
    length
}
