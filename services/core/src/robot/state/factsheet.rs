//! The factsheet's data of a whisker in compact form: whiskers of a robot share the name of a model.

use std::sync::Arc;

use borsh::io::{Read, Result, Write};
use borsh::{BorshDeserialize, BorshSerialize};
use smallvec::SmallVec;

use crate::encoding;
use crate::robot::event::WhiskerSheet;
use crate::units::{Megapascal, Millimetre};

/// Longest name of a model in stored bytes; a longer one is invalid.
const NAME_MAX: u32 = 1 << 16;
/// Error of a length whose factsheet states no tolerance, mm.
pub const LENGTH_TOLERANCE_MM: f64 = 0.5;

/// Data of a whisker in the factsheet, see [`WhiskerSheet`].
#[derive(Debug, Clone, PartialEq)]
pub struct Sheet {
    /// Number, unique in its array.
    pub number: u16,
    /// Numbers of its neighbours in the array.
    pub neighbours: SmallVec<[u16; 6]>,
    /// Position on the array along x, mm.
    pub x_mm: f64,
    /// Position on the array along y, mm.
    pub y_mm: f64,
    /// Name of its model.
    pub model: Arc<String>,
    /// Length of the whole whisker.
    pub length: Millimetre,
    /// Error of the length, mm: it is within this with 95 % probability. Stored as a part of the whisker.
    pub length_tolerance_mm: f64,
    /// Pressure at which the whole whisker is used.
    pub pressure: Megapascal,
    /// Highest pressure that the robot allows.
    pub pressure_max: Megapascal,
    /// Largest strain that the gauge reads, m/m; `None` if the factsheet does not state it. Stored as a part of the whisker.
    pub strain_max: Option<f64>,
}

impl From<&WhiskerSheet> for Sheet {
    fn from(sheet: &WhiskerSheet) -> Self {
        Self {
            number: sheet.number,
            neighbours: SmallVec::from_slice(&sheet.neighbours),
            x_mm: sheet.x_mm,
            y_mm: sheet.y_mm,
            model: Arc::new(sheet.model.clone()),
            length: sheet.length,
            length_tolerance_mm: sheet.length_tolerance_mm,
            pressure: sheet.pressure,
            pressure_max: sheet.pressure_max,
            strain_max: sheet.strain_max,
        }
    }
}

impl From<&Sheet> for WhiskerSheet {
    fn from(kept: &Sheet) -> Self {
        Self {
            number: kept.number,
            x_mm: kept.x_mm,
            y_mm: kept.y_mm,
            model: String::clone(&kept.model),
            length: kept.length,
            length_tolerance_mm: kept.length_tolerance_mm,
            pressure: kept.pressure,
            pressure_max: kept.pressure_max,
            strain_max: kept.strain_max,
            neighbours: kept.neighbours.to_vec(),
        }
    }
}

impl Sheet {
    /// Whether it can be the same whisker at the same place; its neighbours, the range of its gauge and the
    /// tolerance of its length may differ.
    pub(in crate::robot) fn is_same_whisker(&self, sheet: &WhiskerSheet) -> bool {
        let place = (self.number, self.x_mm, self.y_mm) == (sheet.number, sheet.x_mm, sheet.y_mm);
        let pressures = (self.pressure, self.pressure_max) == (sheet.pressure, sheet.pressure_max);
        place && *self.model == sheet.model && self.length == sheet.length && pressures
    }

    /// Whether a factsheet has the same data.
    pub(in crate::robot) fn is_as_told(&self, sheet: &WhiskerSheet) -> bool {
        self.is_same_whisker(sheet)
            && self.neighbours[..] == sheet.neighbours[..]
            && self.strain_max == sheet.strain_max
            && self.length_tolerance_mm == sheet.length_tolerance_mm
    }
}

/// Writes numbers of whiskers, in their order.
pub(in crate::robot) fn write_numbers<W: Write>(numbers: &[u16], writer: &mut W) -> Result<()> {
    encoding::write_u32(numbers.len() as u32, writer)?;
    numbers.iter().try_for_each(|&number| encoding::write_u32(number.into(), writer))
}

/// Reads what [`write_numbers`] wrote.
pub(in crate::robot) fn read_numbers<R: Read>(reader: &mut R) -> Result<Vec<u16>> {
    let count =
        u16::try_from(encoding::read_u32(reader)?).map_err(|_| encoding::invalid("more whiskers than numbers"))?;
    // A count that is wrong must not reserve memory: the vector grows with the bytes that are there.
    let mut numbers = Vec::new();
    for _ in 0..count {
        let number = u16::try_from(encoding::read_u32(reader)?);
        numbers.push(number.map_err(|_| encoding::invalid("the number of a whisker is too large"))?);
    }
    Ok(numbers)
}

impl BorshSerialize for Sheet {
    fn serialize<W: Write>(&self, writer: &mut W) -> Result<()> {
        encoding::write_u32(self.number.into(), writer)?;
        write_numbers(&self.neighbours, writer)?;
        encoding::write_u32(self.model.len() as u32, writer)?;
        writer.write_all(self.model.as_bytes())?;
        let numbers = [self.x_mm, self.y_mm, self.length.mm(), self.pressure.mpa(), self.pressure_max.mpa()];
        numbers.iter().try_for_each(|&number| encoding::write_number(number, writer))
    }
}

impl BorshDeserialize for Sheet {
    fn deserialize_reader<R: Read>(reader: &mut R) -> Result<Self> {
        let number =
            u16::try_from(encoding::read_u32(reader)?).map_err(|_| encoding::invalid("no number of a whisker"))?;
        let neighbours = read_numbers(reader)?.into();
        let length = encoding::read_u32(reader)?;
        if length > NAME_MAX {
            return Err(encoding::invalid("no name of a model"));
        }
        let mut name = Vec::new();
        for _ in 0..length {
            name.push(u8::deserialize_reader(reader)?);
        }
        let name = String::from_utf8(name).map_err(|_| encoding::invalid("no name of a model"))?;
        let mut number_of = || encoding::read_number(reader);
        let [x_mm, y_mm, length, pressure, pressure_max] =
            [number_of()?, number_of()?, number_of()?, number_of()?, number_of()?];
        let mpa = |mpa| Megapascal::new(mpa).map_err(|_| encoding::invalid("a pressure out of range"));
        let length = Millimetre::new(length).map_err(|_| encoding::invalid("a length out of range"))?;
        let (pressure, pressure_max) = (mpa(pressure)?, mpa(pressure_max)?);
        let model = Arc::new(name);
        Ok(Self {
            number,
            neighbours,
            x_mm,
            y_mm,
            model,
            length,
            length_tolerance_mm: LENGTH_TOLERANCE_MM,
            pressure,
            pressure_max,
            strain_max: None,
        })
    }
}
