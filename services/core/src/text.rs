//! Names that lie in place: comparing one looks at no other memory, which for one robot among thousands is what costs.

use borsh::io::{Read, Result, Write};
use borsh::{BorshDeserialize, BorshSerialize};
use smallvec::SmallVec;

/// As many bytes lie in place; an UUID has 36.
const HERE: usize = 40;

/// A short name, such as a boot's or an array's; a longer one lies elsewhere. Stored as the text that it is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ShortText(SmallVec<[u8; HERE]>);

impl ShortText {
    /// The text itself.
    #[must_use]
    pub fn as_str(&self) -> &str {
        // They were those of a text when they came in.
        std::str::from_utf8(&self.0).unwrap_or_default()
    }
}

impl From<&str> for ShortText {
    fn from(text: &str) -> Self {
        Self(SmallVec::from_slice(text.as_bytes()))
    }
}

impl PartialEq<str> for ShortText {
    fn eq(&self, other: &str) -> bool {
        self.0.as_slice() == other.as_bytes()
    }
}

impl BorshSerialize for ShortText {
    fn serialize<W: Write>(&self, writer: &mut W) -> Result<()> {
        self.as_str().serialize(writer)
    }
}

impl BorshDeserialize for ShortText {
    fn deserialize_reader<R: Read>(reader: &mut R) -> Result<Self> {
        Ok(Self::from(String::deserialize_reader(reader)?.as_str()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_stored_as_a_text_and_equals_it_wherever_it_lies() {
        for text in ["", "b7", "550e8400-e29b-41d4-a716-446655440000", &"é".repeat(20), &"é".repeat(64)] {
            let short = ShortText::from(text);
            assert_eq!((short.as_str(), short == *text, short == *"b8"), (text, true, false));
            let bytes = borsh::to_vec(&short).unwrap();
            assert_eq!(bytes, borsh::to_vec(text).unwrap());
            assert_eq!(borsh::from_slice::<ShortText>(&bytes).unwrap(), short);
        }
    }
}
