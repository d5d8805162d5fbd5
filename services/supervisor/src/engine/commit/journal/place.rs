//! Places of contacts in the journal.

use borsh::io::{Read, Result, Write};
use borsh::{BorshDeserialize, BorshSerialize};
use vibrissa_core::robot::event::{ContactPlace, Distance};
use vibrissa_protocol as protocol;

/// Place of a journalled contact. Distances in mm.
#[derive(Debug, Clone, Copy, PartialEq, BorshSerialize, BorshDeserialize)]
pub(super) enum JournalPlace {
    Ratio { ratio: f64, sd: Option<f64> },
    Distance { mm: f64, sd_mm: f64 },
    Tip,
    TipAt { mm: f64, sd_mm: f64 },
    Unknown,
}

impl JournalPlace {
    pub(super) fn of(place: &ContactPlace) -> Self {
        match *place {
            ContactPlace::Ratio { ratio, sd } => Self::Ratio { ratio: ratio.a(), sd },
            ContactPlace::Distance(Distance { at, sd_mm }) => Self::Distance { mm: at.mm(), sd_mm },
            ContactPlace::Tip(None) => Self::Tip,
            ContactPlace::Tip(Some(Distance { at, sd_mm })) => Self::TipAt { mm: at.mm(), sd_mm },
            ContactPlace::Unknown => Self::Unknown,
        }
    }

    /// The place as a robot sends it.
    pub(super) fn sent(self) -> protocol::ContactPlace {
        let at = |mm, sd_mm| protocol::Distance { mm, sd_mm: Some(sd_mm) };
        match self {
            Self::Ratio { ratio, sd } => protocol::ContactPlace::Ratio { ratio, sd },
            Self::Distance { mm, sd_mm } => protocol::ContactPlace::Distance(at(mm, sd_mm)),
            Self::Tip => protocol::ContactPlace::Tip(None),
            Self::TipAt { mm, sd_mm } => protocol::ContactPlace::Tip(Some(at(mm, sd_mm))),
            Self::Unknown => protocol::ContactPlace::Unknown,
        }
    }

    pub(super) fn distance_mm(self) -> Option<f64> {
        match self {
            Self::Distance { mm, .. } | Self::TipAt { mm, .. } => Some(mm),
            Self::Ratio { .. } | Self::Tip | Self::Unknown => None,
        }
    }
}

/// Place of a journalled contact, and whether the robot states its angle: then the highest bit of the place's first byte is 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PlaceAndAngle {
    pub(super) place: JournalPlace,
    pub(super) angle_is_stated: bool,
}

const ANGLE_IS_STATED: u8 = 0x80;
/// Largest number of bytes of a place.
const BYTES_MAX: usize = 18;

impl BorshSerialize for PlaceAndAngle {
    fn serialize<W: Write>(&self, writer: &mut W) -> Result<()> {
        if !self.angle_is_stated {
            return self.place.serialize(writer);
        }
        let mut bytes = [0; BYTES_MAX];
        let mut rest = &mut bytes[..];
        self.place.serialize(&mut rest)?;
        let length = BYTES_MAX - rest.len();
        bytes[0] |= ANGLE_IS_STATED;
        writer.write_all(&bytes[..length])
    }
}

impl BorshDeserialize for PlaceAndAngle {
    fn deserialize_reader<R: Read>(reader: &mut R) -> Result<Self> {
        let first = u8::deserialize_reader(reader)?;
        let tag = [first & !ANGLE_IS_STATED];
        let place = JournalPlace::deserialize_reader(&mut (&tag[..]).chain(reader))?;
        Ok(Self { place, angle_is_stated: first & ANGLE_IS_STATED != 0 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stated_angle_is_kept_and_costs_no_byte() {
        let (mm, sd_mm) = (55.0, 0.5);
        let ratio = JournalPlace::Ratio { ratio: 0.7, sd: Some(0.02) };
        let at = [JournalPlace::Distance { mm, sd_mm }, JournalPlace::TipAt { mm, sd_mm }];
        for place in [ratio, at[0], at[1], JournalPlace::Tip, JournalPlace::Unknown] {
            let without = borsh::to_vec(&place).unwrap();
            for angle_is_stated in [false, true] {
                let one = PlaceAndAngle { place, angle_is_stated };
                let bytes = borsh::to_vec(&one).unwrap();
                assert_eq!(bytes.len(), without.len());
                assert!(angle_is_stated || bytes == without);
                assert_eq!(borsh::from_slice::<PlaceAndAngle>(&bytes).unwrap(), one);
            }
        }
    }
}
