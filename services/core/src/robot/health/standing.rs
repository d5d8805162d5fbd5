//! The alarms of a whisker that stand, and their stored bytes.

use borsh::io::{Read, Result, Write};
use borsh::{BorshDeserialize, BorshSerialize};

use crate::encoding;
use crate::robot::effect::{AlarmKind, Fault};

/// All kinds of a whisker except faults, of which there are several. A cause comes before its consequences.
const KINDS: [AlarmKind; 13] = [
    AlarmKind::SensitivityLoss,
    AlarmKind::Eroding,
    AlarmKind::ArrayShift,
    AlarmKind::BaselineDrift,
    AlarmKind::SetpointFailed,
    AlarmKind::Uncompensated,
    AlarmKind::Proposed,
    AlarmKind::ReachLost,
    AlarmKind::Vented,
    AlarmKind::CablesExchanged,
    AlarmKind::WhiskerReplaced,
    AlarmKind::GaugeReversed,
    AlarmKind::ModelMisfit,
];

/// Names of the stored parts of [`Standing`].
pub(in crate::robot) const PARTS: [&str; 1 + KINDS.len()] = [
    "Fault",
    "SensitivityLoss",
    "Eroding",
    "ArrayShift",
    "BaselineDrift",
    "SetpointFailed",
    "Uncompensated",
    "Proposed",
    "ReachLost",
    "Vented",
    "CablesExchanged",
    "WhiskerReplaced",
    "GaugeReversed",
    "ModelMisfit",
];

/// The first kinds, which fill a stored byte together with the bit for a fault.
const IN_ONE_BYTE: u32 = 7;
/// Two alarms that never stand together, because a condition is either SENSITIVITY_LOSS or ERODING. A stored byte with
/// both announces another one with the kinds from the eighth on.
const ANNOUNCES_ANOTHER: u8 = 0b11;

// A second byte has room for as many.
const _: () = assert!(KINDS.len() <= IN_ONE_BYTE as usize + 8, "stored alarms need a third byte: see Standing");

/// The alarms that stand for a whisker: of its faults only the worst.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Standing {
    pub(super) fault: Option<Fault>,
    /// One bit for each of [`KINDS`], the first in the lowest bit.
    kinds: u16,
}

impl Standing {
    /// The alarms of a fault, and of the kinds that are due, in the order of [`KINDS`].
    pub(super) fn new(fault: Option<Fault>, is_due: [bool; KINDS.len()]) -> Self {
        Self { fault, kinds: encoding::pack_flags(is_due) }
    }

    /// The kinds of the standing alarms, each once.
    pub fn kinds(&self) -> impl Iterator<Item = AlarmKind> + '_ {
        let stands = |(at, _): &(usize, AlarmKind)| self.kinds & 1 << at != 0;
        let others = KINDS.into_iter().enumerate().filter(stands).map(|(_, kind)| kind);
        self.fault.map(AlarmKind::Fault).into_iter().chain(others)
    }

    /// Whether it has a fault, and each of [`KINDS`].
    pub(in crate::robot) fn has(&self) -> [bool; 1 + KINDS.len()] {
        std::array::from_fn(|at| at.checked_sub(1).map_or(self.fault.is_some(), |kind| self.kinds & 1 << kind != 0))
    }

    /// The same alarms, with that of the whisker's silence.
    pub(super) fn with_silence(self) -> Self {
        Self { fault: Some(Fault::Stale), ..self }
    }

    /// The alarms that do not stand in the other.
    pub(super) fn without(&self, other: &Self) -> Self {
        Self { fault: self.fault.filter(|_| self.fault != other.fault), kinds: self.kinds & !other.kinds }
    }
}

/// One byte with the first seven kinds and a bit for a fault that follows. If a further kind stands, a byte that announces
/// them and the bit for a fault comes first, then one with the first seven kinds and one with the further ones.
impl BorshSerialize for Standing {
    fn serialize<W: Write>(&self, writer: &mut W) -> Result<()> {
        let [first, further] = [self.kinds & 0x7f, self.kinds >> IN_ONE_BYTE].map(|bits| bits as u8);
        let fault = u8::from(self.fault.is_some()) << IN_ONE_BYTE;
        if further == 0 {
            (first | fault).serialize(writer)?;
        } else {
            (ANNOUNCES_ANOTHER | fault, first, further).serialize(writer)?;
        }
        self.fault.iter().try_for_each(|fault| fault.serialize(writer))
    }
}

impl BorshDeserialize for Standing {
    fn deserialize_reader<R: Read>(reader: &mut R) -> Result<Self> {
        let (bits, fault) = (u8::deserialize_reader(reader)?, 1 << IN_ONE_BYTE);
        let kinds = if bits & !fault == ANNOUNCES_ANOTHER {
            let [first, further] = <[u8; 2]>::deserialize_reader(reader)?;
            u16::from(first) | u16::from(further) << IN_ONE_BYTE
        } else {
            u16::from(bits & !fault)
        };
        let has_fault = (bits & fault != 0).then(|| Fault::deserialize_reader(reader));
        Ok(Self { fault: has_fault.transpose()?, kinds })
    }
}
