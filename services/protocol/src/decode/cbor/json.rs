//! Writes a message in CBOR as JSON: the slow way, for messages with rare forms or errors, and for people.

use std::borrow::Cow;

use cbor4ii::core::types::{Array, Bytes, F16, Map, Simple, Tag};

use super::input::{Input, of_half};
use crate::decode::repair;

/// Deepest nesting of lists and maps, as in the JSON reader.
const DEPTH_MAX: usize = 127;
/// The byte that ends a list or map of unknown length.
const BREAK: u8 = 0xff;

/// Why a payload is not a message in CBOR.
type Problem = String;

/// The message as JSON, with equal values.
pub(in crate::decode) fn of(payload: &[u8]) -> Result<Vec<u8>, Problem> {
    let (text, problem) = begin_of(payload);
    problem.map_or(Ok(text), Err)
}

/// The message as JSON with a mark in the place of each value that JSON does not have. `None` if it is not well-formed.
pub(in crate::decode) fn marked(payload: &[u8]) -> Option<Vec<u8>> {
    let (text, problem) = written(payload, true);
    problem.is_none().then_some(text)
}

/// The message as JSON up to the first problem, and the problem.
pub(in crate::decode) fn begin_of(payload: &[u8]) -> (Vec<u8>, Option<Problem>) {
    written(payload, false)
}

fn written(payload: &[u8], marks: bool) -> (Vec<u8>, Option<Problem>) {
    let mut writer = Writer { input: Input::new(payload), at: 0, out: Vec::with_capacity(2 * payload.len()), marks };
    let done = writer.value(0);
    let done = done.and_then(|()| match writer.input.is_empty() {
        true => Ok(()),
        false => Err(writer.here().problem("unexpected bytes after the message")),
    });
    (writer.out, done.err())
}

struct Writer<'a> {
    input: Input<'a>,
    /// Begin of the present value or name.
    at: usize,
    out: Vec<u8>,
    /// A value that JSON does not have is replaced by a mark, instead of ending the message.
    marks: bool,
}

impl Writer<'_> {
    fn here(&mut self) -> &Self {
        self.at = self.input.at();
        self
    }

    fn problem(&self, problem: &str) -> Problem {
        format!("{problem}, at byte {}", self.at)
    }

    fn read<T>(&self, value: Option<T>) -> Result<T, Problem> {
        value.ok_or_else(|| self.problem("the message ends early, or a value is not well-formed"))
    }

    fn write(&mut self, value: &impl serde::Serialize) {
        // Writing numbers and texts into memory cannot fail.
        let _ = serde_json::to_writer(&mut self.out, value);
    }

    fn value(&mut self, depth: usize) -> Result<(), Problem> {
        let first = self.here().input.peek();
        let first = self.read(first)?;
        match first {
            0x00..=0x1b => {
                let number: Option<u64> = self.input.value();
                let number = self.read(number)?;
                self.write(&number);
            }
            0x20..=0x3b => {
                let number: Option<i128> = self.input.value();
                let number = self.read(number)?;
                self.write(&number);
            }
            0x60..=0x7b | 0x7f => self.text()?,
            0x80..=0x9b | 0x9f => self.list(depth)?,
            0xa0..=0xbb | 0xbf => self.map(depth)?,
            0xf4 | 0xf5 => {
                let truth = self.input.truth();
                let truth = self.read(truth)?;
                self.write(&truth);
            }
            0xf6 => {
                self.input.value::<Option<u8>>();
                self.out.extend_from_slice(b"null");
            }
            0xf9..=0xfb => self.float(first)?,
            0x40..=0x5f => {
                self.mark("a byte string", "a byte string, but JSON has no such value")?;
                let bytes: Option<Bytes<Cow<'_, [u8]>>> = self.input.value();
                self.read(bytes)?;
            }
            0xc0..=0xdb => {
                self.mark("a tag", "a tag, but the contract has none")?;
                let tag = Tag::tag(&mut self.input).ok();
                self.read(tag)?;
                let end = self.out.len();
                if depth >= DEPTH_MAX {
                    return Err(self.problem("values are nested too deeply"));
                }
                self.value(depth + 1)?;
                self.out.truncate(end);
            }
            _ => {
                self.mark("undefined", "a value that JSON does not have")?;
                let value: Option<Simple> = self.input.value();
                self.read(value)?;
            }
        }
        Ok(())
    }

    /// Writes a mark for a value, or ends the message with a problem.
    fn mark(&mut self, value: &str, problem: &str) -> Result<(), Problem> {
        if !self.marks {
            return Err(self.problem(problem));
        }
        self.out.extend_from_slice(repair::marked(value).as_bytes());
        Ok(())
    }

    fn text(&mut self) -> Result<(), Problem> {
        let before = self.input;
        let text: Option<Cow<'_, str>> = self.input.value();
        if text.is_none() && self.marks {
            self.input = before;
            let bytes = self.input.text_bytes();
            self.read(bytes)?;
            return self.mark("a text that is not UTF-8", "");
        }
        let text = self.read(text)?;
        self.write(&text);
        Ok(())
    }

    fn float(&mut self, first: u8) -> Result<(), Problem> {
        let number = match first {
            0xf9 => self.input.value::<F16>().map(|half| of_half(half.0)),
            0xfa => self.input.value::<f32>().map(f64::from),
            _ => self.input.value::<f64>(),
        };
        let number = self.read(number)?;
        if !number.is_finite() {
            let problem = format!("the number {number}, but numbers must be finite");
            return self.mark(&number.to_string(), &problem);
        }
        self.write(&number);
        Ok(())
    }

    fn list(&mut self, depth: usize) -> Result<(), Problem> {
        let count = Array::len(&mut self.input).ok();
        let count = self.read(count)?;
        self.entries(depth, count, b"[]", |writer| writer.value(depth + 1))
    }

    fn map(&mut self, depth: usize) -> Result<(), Problem> {
        let count = Map::len(&mut self.input).ok();
        let count = self.read(count)?;
        self.entries(depth, count, b"{}", |writer| {
            writer.here();
            let name: Option<Cow<'_, str>> = writer.input.value();
            let name = name.ok_or_else(|| writer.problem("the name of a field must be a text"))?;
            writer.write(&name);
            writer.out.push(b':');
            writer.value(depth + 1)
        })
    }

    /// Writes the entries of a list or map; without a count they end with a byte of their own.
    fn entries(
        &mut self,
        depth: usize,
        count: Option<usize>,
        brackets: &[u8; 2],
        mut entry: impl FnMut(&mut Self) -> Result<(), Problem>,
    ) -> Result<(), Problem> {
        if depth >= DEPTH_MAX {
            return Err(self.problem("lists and maps are nested too deeply"));
        }
        self.out.push(brackets[0]);
        let mut written = 0;
        loop {
            let is_over = match count {
                Some(count) => written == count,
                None => self.input.peek() == Some(BREAK),
            };
            if is_over {
                break;
            }
            if written > 0 {
                self.out.push(b',');
            }
            entry(self)?;
            written += 1;
        }
        if count.is_none() {
            cbor4ii::core::dec::Read::advance(&mut self.input, 1);
        }
        self.out.push(brackets[1]);
        Ok(())
    }
}
