//! A few numbers of whiskers: mostly so few that they lie where they belong.

use std::ops::Deref;

use borsh::io::{Read, Result, Write};
use borsh::{BorshDeserialize, BorshSerialize};

use crate::counts;

/// As many lie in place.
const HERE: usize = 6;

/// Numbers of whiskers of one array, in an order.
#[derive(Clone)]
pub struct Few(Place);

#[derive(Clone)]
enum Place {
    Here { count: u8, numbers: [u16; HERE] },
    Elsewhere(Box<More>),
}

#[derive(Clone)]
struct More(Vec<u16>);

impl Default for Few {
    fn default() -> Self {
        Self(Place::Here { count: 0, numbers: [0; HERE] })
    }
}

impl From<&[u16]> for Few {
    fn from(all: &[u16]) -> Self {
        if all.len() > HERE {
            return Self(Place::Elsewhere(Box::new(More(all.to_vec()))));
        }
        let mut numbers = [0; HERE];
        numbers[..all.len()].copy_from_slice(all);
        Self(Place::Here { count: all.len() as u8, numbers })
    }
}

impl Deref for Few {
    type Target = [u16];

    fn deref(&self) -> &[u16] {
        match &self.0 {
            Place::Here { count, numbers } => &numbers[..usize::from(*count)],
            Place::Elsewhere(more) => &more.0,
        }
    }
}

impl Few {
    /// One more, at the end.
    pub(in crate::robot) fn push(&mut self, number: u16) {
        *self = Self::from(&[&**self, &[number]].concat()[..]);
    }
}

/// Such numbers where mostly there are none.
#[derive(Debug, Clone, PartialEq, Default)]
pub(in crate::robot) struct Fewer(Option<Box<Few>>);

impl Fewer {
    /// One more, at the end.
    pub(in crate::robot) fn push(&mut self, number: u16) {
        self.0.get_or_insert_default().push(number);
    }

    /// None any more.
    pub(in crate::robot) fn clear(&mut self) {
        self.0 = None;
    }
}

impl From<Few> for Fewer {
    fn from(few: Few) -> Self {
        Self((!few.is_empty()).then(|| Box::new(few)))
    }
}

impl Deref for Fewer {
    type Target = [u16];

    fn deref(&self) -> &[u16] {
        self.0.as_deref().map_or(&[], |few| few)
    }
}

impl PartialEq for Few {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl std::fmt::Debug for Few {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_list().entries(self.iter()).finish()
    }
}

impl BorshSerialize for Few {
    fn serialize<W: Write>(&self, writer: &mut W) -> Result<()> {
        counts::write(self.len() as u32, writer)?;
        self.iter().try_for_each(|&number| counts::write(number.into(), writer))
    }
}

impl BorshDeserialize for Few {
    fn deserialize_reader<R: Read>(reader: &mut R) -> Result<Self> {
        let count = u16::try_from(counts::read(reader)?).map_err(|_| counts::refused("more whiskers than numbers"))?;
        // No room is made for more than there are bytes of.
        let mut numbers = Vec::new();
        for _ in 0..count {
            let number = u16::try_from(counts::read(reader)?);
            numbers.push(number.map_err(|_| counts::refused("no number of a whisker"))?);
        }
        Ok(Self::from(&numbers[..]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn property_few_or_many_they_are_what_was_put_in() {
        let (mut few, mut all) = (Few::default(), Vec::new());
        for number in (0..20).map(|k| k * 3000) {
            few.push(number);
            all.push(number);
            assert_eq!(*few, *all);
            assert_eq!(few, Few::from(&all[..]));
            let bytes = borsh::to_vec(&few).unwrap();
            assert_eq!(borsh::from_slice::<Few>(&bytes).unwrap(), few);
            assert!(borsh::from_slice::<Few>(&bytes[..bytes.len() - 1]).is_err());
        }
        let mut fewer = Fewer::from(few);
        assert_eq!(*fewer, *all);
        fewer.clear();
        assert_eq!(fewer, Fewer::from(Few::default()));
        assert_eq!(size_of::<Few>(), 16);
    }
}
