//! Places of contacts in the journal.

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
