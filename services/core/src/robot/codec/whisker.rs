//! The stored bytes of a whisker. Parts that are absent or equal to the factsheet take one bit.

use borsh::io::{Read, Result, Write};
use borsh::{BorshDeserialize, BorshSerialize};

use crate::detection::{Detector, Stored};
use crate::encoding;
use crate::estimation::filter::{FilterParams, STATES, STATES_BEFORE_7};
use crate::estimation::{
    ErosionWatch, GainWalks, LeakWatch, LengthFilter, NoiseScale, RatioSpread, ResponseBins, Temperatures,
};
use crate::robot::health::flapping::{Flapping, Vent};
use crate::robot::setpoints::tries::Tries;
use crate::robot::state::factsheet::{LENGTH_TOLERANCE_MM, Sheet, read_numbers, write_numbers};
use crate::robot::state::first_contacts::FirstContacts;
use crate::robot::state::rare_state::{Rare, RareState};
use crate::robot::state::whisker::{Air, DecisionBasis, Holds, Whisker};
use crate::robot::touch_tests::DistanceZero;
use crate::units::{Megapascal, Micros};

/// Version of a whisker's bytes; they begin with it.
const VERSION: u32 = 19;
/// Bytes of a version up to this one are taken for those of a newer program; beyond it they are damaged.
const NEWEST_VERSION: u32 = VERSION + 100;
/// First version that is stored with its number. A whisker of version 5 or older begins with nine flags.
const FIRST_MARKED: u32 = 6;
/// Names of the flags, in stored order.
pub(super) const FLAGS: [&str; 9] =
    ["given_up", "drifting", "drift_told", "undecided", "unserved", "shift_told", "held", "fault", "whole is unknown"];
/// Names of the parts that few whiskers have, in stored order.
pub(super) const PARTS: [&str; 16] = [
    "pending_trim",
    "whole_offset",
    "own",
    "erosion",
    "desired",
    "command",
    "unsteady",
    "refused_servers",
    "tries",
    "reach",
    "length_test",
    "set_at",
    "flapping",
    "vents",
    "gauge_range",
    "changed_at",
];
/// Names of further such parts, in stored order. Not before version 16, `doubt` not before 17,
/// `tolerance` not before 18, and `measured` not before 19.
pub(super) const LATER_PARTS: [&str; 5] = ["zero", "first", "doubt", "tolerance", "measured"];
/// Names of the flags of [`Air`], in stored order.
pub(super) const AIR_FLAGS: [&str; 4] = ["measured", "moved", "learned_at", "unheld_since"];
/// Added to the version; the flags of an older whisker are less than this.
const VERSION_MARK: u32 = 1 << 9;
/// Places for the starts of steps in the detector before version 8.
const STEPS_BEFORE_8: usize = 5;
/// Stored as the time of a whisker that was never heard.
const NEVER: Micros = Micros(u64::MAX);

impl Whisker {
    /// Whether bytes have a version that this program does not know yet. Versions far beyond it are damage.
    pub(super) fn is_of_newer_program(mut bytes: &[u8]) -> bool {
        let first = encoding::read_u32(&mut bytes).unwrap_or_default();
        first.checked_sub(VERSION_MARK).is_some_and(|version| (VERSION + 1..=NEWEST_VERSION).contains(&version))
    }

    /// Flags of the whisker, in stored order.
    pub(super) fn is(&self) -> [bool; FLAGS.len()] {
        [
            self.given_up,
            self.drifting,
            self.drift_told,
            self.undecided,
            self.unserved,
            self.shift_told,
            self.held,
            self.fault.is_some(),
            self.whole == ResponseBins::default(),
        ]
    }

    /// Presence of the parts that few whiskers have, in stored order.
    pub(super) fn has_parts(&self) -> [bool; PARTS.len()] {
        [
            self.rare.pending_trim.is_some(),
            self.rare.whole_offset.is_some(),
            self.rare.own.is_some(),
            self.rare.erosion.is_some(),
            self.desired.is_some(),
            self.command.is_some(),
            self.rare.unsteady.is_some(),
            !self.refused_servers.is_empty(),
            self.rare.tries != Tries::NONE || self.rare.not_before != Micros::default(),
            self.rare.reach.is_some(),
            self.rare.length_test.is_some(),
            self.rare.set_at != Micros::default(),
            self.rare.flapping.is_some(),
            self.rare.vents.is_some(),
            self.sheet.strain_max.is_some(),
            self.rare.changed_at != Micros::default(),
        ]
    }

    /// Presence of the further parts, in stored order.
    pub(super) fn has_later_parts(&self) -> [bool; LATER_PARTS.len()] {
        [
            self.rare.zero != DistanceZero::UNKNOWN,
            self.rare.first.is_some(),
            self.filter.least_sd_mm() > 0.0,
            self.sheet.length_tolerance_mm != LENGTH_TOLERANCE_MM,
            self.is_length_measured(),
        ]
    }
}

impl Whisker {
    /// Whether its length owes less to the factory length than that of a new whisker.
    fn is_length_measured(&self) -> bool {
        let of_new = LengthFilter::whole_sd_of(self.sheet.length_tolerance_mm, &FilterParams::default());
        self.filter.whole_sd_mm() != of_new
    }
}

impl BorshSerialize for Whisker {
    fn serialize<W: Write>(&self, writer: &mut W) -> Result<()> {
        encoding::write_u32(VERSION_MARK + VERSION, writer)?;
        encoding::write_u32(encoding::pack_flags(self.is()).into(), writer)?;
        encoding::write_u32(encoding::pack_flags(self.has_parts()).into(), writer)?;
        encoding::write_u32(encoding::pack_flags(self.has_later_parts()).into(), writer)?;
        encoding::write_u32(self.array.into(), writer)?;
        self.sheet.serialize(writer)?;
        self.air.write(&self.sheet, writer)?;
        (&self.filter, &self.noise, self.temperatures, &self.spread, &self.walks).serialize(writer)?;
        (&self.detector, &self.leak, &self.gauge).serialize(writer)?;
        (&self.whole_waiting, self.condition, self.holds, &self.standing).serialize(writer)?;
        if self.whole != ResponseBins::default() {
            self.whole.serialize(writer)?;
        }
        encoding::write_u64(self.contacts, writer)?;
        (self.heard.unwrap_or(NEVER), self.told_since_alarm).serialize(writer)?;
        self.fault.iter().try_for_each(|one| one.serialize(writer))?;
        self.rare.pending_trim.iter().try_for_each(|one| one.serialize(writer))?;
        self.rare.whole_offset.iter().try_for_each(|one| one.serialize(writer))?;
        self.rare.own.iter().try_for_each(|one| one.serialize(writer))?;
        self.rare.erosion.iter().try_for_each(|one| one.serialize(writer))?;
        self.rare.unsteady.iter().try_for_each(|one| one.serialize(writer))?;
        self.desired.iter().try_for_each(|one| one.serialize(writer))?;
        self.command.iter().try_for_each(|one| one.serialize(writer))?;
        let [.., refused, waits, _, _, set, _, _, _, changed] = self.has_parts();
        if refused {
            write_numbers(&self.refused_servers, writer)?;
        }
        if waits {
            (self.rare.tries.to_byte(), self.rare.not_before).serialize(writer)?;
        }
        self.rare.reach.iter().try_for_each(|one| one.serialize(writer))?;
        self.rare.length_test.iter().try_for_each(|one| one.serialize(writer))?;
        if set {
            (self.rare.set_at, self.rare.set_heard).serialize(writer)?;
        }
        self.rare.flapping.iter().try_for_each(|one| one.serialize(writer))?;
        self.rare.vents.iter().try_for_each(|one| one.serialize(writer))?;
        let range = self.sheet.strain_max.map(|strain_max| (strain_max, self.rare.largest_deflection_mm));
        range.iter().try_for_each(|one| one.serialize(writer))?;
        if changed {
            self.rare.changed_at.serialize(writer)?;
        }
        let [zero, _, doubt, tolerance, measured] = self.has_later_parts();
        if zero {
            self.rare.zero.serialize(writer)?;
        }
        self.rare.first.iter().try_for_each(|one| one.serialize(writer))?;
        if doubt {
            self.filter.least_sd_mm().serialize(writer)?;
        }
        if tolerance {
            encoding::write_number(self.sheet.length_tolerance_mm, writer)?;
        }
        if measured {
            self.filter.whole_sd_mm().serialize(writer)?;
        }
        Ok(())
    }
}

impl BorshDeserialize for Whisker {
    fn deserialize_reader<R: Read>(reader: &mut R) -> Result<Self> {
        let first = encoding::read_u32(reader)?;
        // Up to version 5 the flags came first; version 6 has the same parts.
        let (version, flags) = match first.checked_sub(VERSION_MARK) {
            None => (FIRST_MARKED - 1, first),
            Some(version @ FIRST_MARKED..=VERSION) => (version, encoding::read_u32(reader)?),
            Some(_) => return Err(encoding::invalid("a whisker of another version")),
        };
        let bits_of = |flags: u32| u16::try_from(flags).map_err(|_| encoding::invalid("unknown flag bits are set"));
        let [given_up, drifting, drift_told, undecided, unserved, shift_told, held, fault, untold] =
            encoding::unpack_flags(bits_of(flags)?)?;
        let has = encoding::unpack_flags(bits_of(encoding::read_u32(reader)?)?)?;
        let [
            pending_trim,
            whole_offset,
            own,
            erosion,
            desired,
            command,
            unsteady,
            refused,
            waits,
            reach,
            length_test,
            // Not before version 10.
            set,
            // Not before version 12.
            flapping,
            // Not before version 13.
            vents,
            // Not before version 14.
            gauge_range,
            // Not before version 15.
            changed,
        ] = has;
        let later = if version < 16 { 0 } else { encoding::read_u32(reader)? };
        let [zero, first, doubt, tolerance, measured] = encoding::unpack_flags(bits_of(later)?)?;
        let array =
            u16::try_from(encoding::read_u32(reader)?).map_err(|_| encoding::invalid("no index of an array"))?;
        let sheet = Sheet::deserialize_reader(reader)?;
        let air = Air::read(&sheet, reader)?;
        let Learned { filter, noise, temperatures, spread, walks, detector } = Learned::read(version, reader)?;
        let leak = LeakWatch::read_stored(version < 8, reader)?;
        let gauge = BorshDeserialize::deserialize_reader(reader)?;
        let (whole_waiting, condition, holds, standing) = BorshDeserialize::deserialize_reader(reader)?;
        let whole = if untold { ResponseBins::default() } else { ResponseBins::deserialize_reader(reader)? };
        let contacts = encoding::read_u64(reader)?;
        let (heard, told_since_alarm) = <(Micros, f32)>::deserialize_reader(reader)?;
        let fault = of(fault, reader)?;
        let mut read = Self {
            array,
            sheet,
            filter,
            noise,
            temperatures,
            spread,
            walks,
            detector,
            contacts,
            condition,
            whole,
            whole_waiting,
            air,
            leak,
            gauge,
            heard: Some(heard).filter(|heard| *heard != NEVER),
            given_up,
            told_since_alarm,
            drifting,
            drift_told,
            undecided,
            unserved,
            shift_told,
            held,
            standing,
            holds,
            decided_on: DecisionBasis { condition, fault, given_up, held, undecided },
            fault,
            rare: Rare::from(RareState {
                pending_trim: of(pending_trim, reader)?,
                whole_offset: of(whole_offset, reader)?,
                own: of(own, reader)?,
                erosion: match erosion {
                    true if version < 18 => Some(Box::new(ErosionWatch::read_before_18(reader)?)),
                    is_there => of(is_there, reader)?,
                },
                unsteady: of(unsteady, reader)?,
                reach: None,
                length_test: None,
                tries: Tries::NONE,
                not_before: Micros::default(),
                set_at: Micros::default(),
                set_heard: Micros::default(),
                flapping: None,
                vents: None,
                largest_deflection_mm: 0.0,
                changed_at: Micros::default(),
                zero: DistanceZero::UNKNOWN,
                first: None,
            }),
            desired: of(desired, reader)?,
            command: of(command, reader)?,
            refused_servers: if refused { read_numbers(reader)? } else { Vec::new() },
        };
        if waits {
            let rare = read.rare.get_or_insert();
            let (tries, not_before) = <(u8, Micros)>::deserialize_reader(reader)?;
            (rare.tries, rare.not_before) = (Tries::from_byte(tries), not_before);
        }
        if reach || length_test {
            let rare = read.rare.get_or_insert();
            (rare.reach, rare.length_test) = (of(reach, reader)?, of(length_test, reader)?);
        }
        if set {
            let rare = read.rare.get_or_insert();
            rare.set_at = BorshDeserialize::deserialize_reader(reader)?;
            if version >= 11 {
                rare.set_heard = BorshDeserialize::deserialize_reader(reader)?;
            }
        }
        if flapping {
            read.rare.get_or_insert().flapping = of(true, reader)?;
        }
        if vents {
            read.rare.get_or_insert().vents = of(true, reader)?;
        } else if version < 13 && holds == Holds::Vented {
            read.rare.get_or_insert().vents = Some(Flapping::steady(Some(Vent)));
        }
        if gauge_range {
            let (strain_max, largest_deflection_mm) = BorshDeserialize::deserialize_reader(reader)?;
            read.sheet.strain_max = Some(strain_max);
            read.rare.get_or_insert().largest_deflection_mm = largest_deflection_mm;
        }
        if changed {
            read.rare.get_or_insert().changed_at = BorshDeserialize::deserialize_reader(reader)?;
        }
        if zero {
            read.rare.get_or_insert().zero = BorshDeserialize::deserialize_reader(reader)?;
        }
        if first {
            let first = if version < 19 {
                FirstContacts::read_before_19(reader)?
            } else {
                FirstContacts::deserialize_reader(reader)?
            };
            read.rare.get_or_insert().first = Some(Box::new(first));
        }
        if doubt {
            read.filter.keep_doubt(f32::deserialize_reader(reader)?.into());
        }
        // Not before version 18.
        if tolerance {
            read.sheet.length_tolerance_mm = encoding::read_number(reader)?;
        }
        read.keep_tolerance(&FilterParams::default());
        if measured {
            let sd_mm = f32::deserialize_reader(reader)?;
            if !(0.0..=1000.0).contains(&sd_mm) {
                return Err(encoding::invalid("no error of a length"));
            }
            read.filter.keep_whole_sd(sd_mm);
        }
        Ok(read)
    }
}

/// State that is learned from the contacts' strain.
struct Learned {
    filter: LengthFilter,
    noise: NoiseScale,
    temperatures: Option<Temperatures>,
    spread: RatioSpread,
    walks: GainWalks,
    detector: Detector,
}

impl Learned {
    fn read<R: Read>(version: u32, reader: &mut R) -> Result<Self> {
        let (is_before_7, is_before_8) = (version < 7, version < 8);
        let filter =
            if is_before_7 { LengthFilter::read_before_7(reader)? } else { LengthFilter::deserialize_reader(reader)? };
        let noise = match version {
            ..7 => NoiseScale::read_before_7(reader)?,
            7 => NoiseScale::read_7(reader)?,
            8.. => NoiseScale::deserialize_reader(reader)?,
        };
        let temperatures = match version {
            ..7 => None,
            7 | 8 => Option::deserialize_reader(reader)?.map(Temperatures::of),
            9.. => Option::deserialize_reader(reader)?,
        };
        let spread = match version {
            ..7 => RatioSpread::default(),
            7 => RatioSpread::read_7(reader)?,
            8.. => RatioSpread::deserialize_reader(reader)?,
        };
        let walks = if is_before_8 { GainWalks::default() } else { GainWalks::deserialize_reader(reader)? };
        let stored = Stored {
            states: if is_before_7 { STATES_BEFORE_7 } else { STATES },
            steps: if is_before_8 { STEPS_BEFORE_8 } else { Stored::NOW.steps },
        };
        Ok(Self { filter, noise, temperatures, spread, walks, detector: Detector::read(&stored, reader)? })
    }
}

/// Reads an optional part.
fn of<T: BorshDeserialize, R: Read>(is_there: bool, reader: &mut R) -> Result<Option<T>> {
    is_there.then(|| T::deserialize_reader(reader)).transpose()
}

impl Air {
    /// Its flags, in stored order.
    pub(super) fn is(&self, sheet: &Sheet) -> [bool; AIR_FLAGS.len()] {
        let [moved, learned] = [self.setpoint != sheet.pressure, self.learned_at != self.setpoint];
        [self.measured().is_some(), moved, learned, self.unheld_since.is_some()]
    }

    /// Writes the pressures; those equal to the factsheet's `sheet` take one bit.
    fn write<W: Write>(&self, sheet: &Sheet, writer: &mut W) -> Result<()> {
        let is = self.is(sheet);
        let [_, moved, learned, _] = is;
        (encoding::pack_flags(is) as u8).serialize(writer)?;
        self.measured().iter().try_for_each(|one| encoding::write_number(one.mpa(), writer))?;
        for (pressure, _) in [(self.setpoint, moved), (self.learned_at, learned)].iter().filter(|(_, is)| *is) {
            encoding::write_number(pressure.mpa(), writer)?;
        }
        self.unheld_since.iter().try_for_each(|one| one.serialize(writer))?;
        self.regulator.serialize(writer)
    }

    /// Reads what [`Self::write`] wrote.
    fn read<R: Read>(sheet: &Sheet, reader: &mut R) -> Result<Self> {
        let [measured, moved, learned, unheld] = encoding::unpack_flags(u8::deserialize_reader(reader)?.into())?;
        let mut pressure = |is_there: bool| -> Result<Option<Megapascal>> {
            let mpa = is_there.then(|| encoding::read_number(reader)).transpose()?;
            mpa.map(Megapascal::new).transpose().map_err(|_| encoding::invalid("a pressure out of range"))
        };
        let (measured, setpoint) = (pressure(measured)?, pressure(moved)?.unwrap_or(sheet.pressure));
        let learned_at = pressure(learned)?.unwrap_or(setpoint);
        let mut air = Self::held(setpoint, learned_at);
        if let Some(measured) = measured {
            air.measure(measured);
        }
        air.unheld_since = of(unheld, reader)?;
        air.regulator = BorshDeserialize::deserialize_reader(reader)?;
        Ok(air)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A million whiskers with the rest of their robots must fit into 2.5 GiB of memory.
    #[test]
    fn a_whisker_takes_no_more_room_than_was_meant() {
        assert!(size_of::<Whisker>() <= 2256, "{}", size_of::<Whisker>());
    }
}
