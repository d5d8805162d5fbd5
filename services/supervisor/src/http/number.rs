//! Row numbers in requests.

use serde::{Deserialize, Deserializer, de::Error};

/// A row number, 0 to 2^53 - 1: the integers that every JSON reader represents exactly.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RowNumber(pub i64);

/// Largest integer that every JSON reader represents exactly.
const NUMBER_MAX: i64 = (1 << 53) - 1;

impl From<RowNumber> for i64 {
    fn from(number: RowNumber) -> Self {
        number.0
    }
}

impl<'de> Deserialize<'de> for RowNumber {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match i64::deserialize(deserializer)? {
            number @ 0..=NUMBER_MAX => Ok(Self(number)),
            number => Err(D::Error::custom(format!("must be from 0 to {NUMBER_MAX}, not {number}"))),
        }
    }
}
