//! Deserialization of the contract's words, which rows hold as `&'static str`.

use std::collections::BTreeSet;
use std::sync::{Mutex, PoisonError};

use borsh::BorshDeserialize;
use borsh::io::{Error, ErrorKind, Read, Result};

/// Length of the longest accepted word, bytes.
const LENGTH_MAX: usize = 40;
/// Most different words; the contract's set of words is closed and smaller. Together with [`LENGTH_MAX`] it bounds
/// the leaked memory.
const WORDS_MAX: usize = 1000;

/// The words that were read. Each of them is leaked once.
static KNOWN: Mutex<BTreeSet<&'static str>> = Mutex::new(BTreeSet::new());

/// Reads a word.
pub(super) fn word<R: Read>(reader: &mut R) -> Result<&'static str> {
    let word = String::deserialize_reader(reader)?;
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(known) = known.get(word.as_str()) {
        return Ok(known);
    }
    if word.len() > LENGTH_MAX || known.len() >= WORDS_MAX {
        return Err(Error::new(ErrorKind::InvalidData, "not a word of the contract"));
    }
    let word = Box::leak(word.into_boxed_str());
    known.insert(word);
    Ok(word)
}

/// Reads an optional word.
pub(super) fn word_if_any<R: Read>(reader: &mut R) -> Result<Option<&'static str>> {
    bool::deserialize_reader(reader)?.then(|| word(reader)).transpose()
}
