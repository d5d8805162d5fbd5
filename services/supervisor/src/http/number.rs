//! Numbers of rows in requests.

use serde::{Deserialize, Deserializer, de::Error};

/// The number of a row: 0 to 2^63 - 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RowNumber(pub i64);

impl From<RowNumber> for i64 {
    fn from(number: RowNumber) -> Self {
        number.0
    }
}

impl<'de> Deserialize<'de> for RowNumber {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match i64::deserialize(deserializer)? {
            number @ 0.. => Ok(Self(number)),
            number => Err(D::Error::custom(format!("must not be below 0, but is {number}"))),
        }
    }
}
