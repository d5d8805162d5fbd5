//! Words of the contract, read back from bytes.

use std::collections::BTreeSet;
use std::sync::{Mutex, PoisonError};

use borsh::BorshDeserialize;
use borsh::io::{Error, ErrorKind, Read, Result};

/// No word is longer, in bytes.
const LENGTH_MAX: usize = 40;
/// Nor are there more: it is a closed set.
const WORDS_MAX: usize = 1000;

/// The words that were read, each of which stays in memory, once.
static KNOWN: Mutex<BTreeSet<&'static str>> = Mutex::new(BTreeSet::new());

/// Reads a word.
pub(super) fn word<R: Read>(reader: &mut R) -> Result<&'static str> {
    let word = String::deserialize_reader(reader)?;
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(known) = known.get(word.as_str()) {
        return Ok(known);
    }
    if word.len() > LENGTH_MAX || known.len() >= WORDS_MAX {
        return Err(Error::new(ErrorKind::InvalidData, "this is no word of the contract"));
    }
    let word = Box::leak(word.into_boxed_str());
    known.insert(word);
    Ok(word)
}

/// Reads one that need not be there.
pub(super) fn word_if_any<R: Read>(reader: &mut R) -> Result<Option<&'static str>> {
    bool::deserialize_reader(reader)?.then(|| word(reader)).transpose()
}
