//! `contacts` messages in CBOR (RFC 8949): the fields of the JSON message under the same names, in a map.
//!
//! The first byte of a payload tells the encodings apart: a CBOR map begins with 0xA0 to 0xBF, which no text in UTF-8 does.
//! A fast reader takes what robots write. It leaves everything else to [`json::of`], which writes the same message as
//! JSON for the full reader. So CBOR has the limits and the errors of JSON, and only the full reader refuses messages.

mod input;
pub(super) mod json;
mod write;

use cbor4ii::core::types::{Array, Map};

use self::input::Input;
use crate::{BootId, Contact, Contacts, Name};

pub(super) use write::contacts as write;

/// Whether a payload is CBOR rather than JSON.
pub(super) fn is_cbor(payload: &[u8]) -> bool {
    matches!(payload.first(), Some(0xa0..=0xbf))
}

/// Reads a message; its contacts replace the contents of `list`. `None` if the message has another form, such as lists of
/// unknown length, missed touches, unknown or missing fields, or any error.
pub(super) fn contacts(payload: &[u8], list: &mut Vec<Contact>) -> Option<Contacts> {
    list.clear();
    let mut input = Input::new(payload);
    let (mut boot_id, mut seq, mut is_listed) = (None, None, false);
    for _ in 0..Map::len(&mut input).ok()?? {
        match input.text()? {
            "boot_id" if boot_id.is_none() => boot_id = Some(BootId::new(input.text()?).ok()?),
            "seq" if seq.is_none() => seq = Some(input.integer()?),
            "contacts" if !is_listed => {
                is_listed = true;
                for _ in 0..Array::len(&mut input).ok()?? {
                    let one = usual_contact(&mut input).or_else(|| contact(&mut input))?;
                    list.push(one);
                }
            }
            _ => return None,
        }
    }
    if !input.is_empty() || !is_listed {
        return None;
    }
    Some(Contacts { boot_id: boot_id?, seq: seq?, contacts: std::mem::take(list), missed: Vec::new() })
}

/// Reads a contact with the fields that nearly all robots write, in the contract's order, by comparing their names as they are
/// encoded. Otherwise the input stays where it is.
fn usual_contact(input: &mut Input<'_>) -> Option<Contact> {
    let mut at = *input;
    let array = Name::new(at.after(b"\xa8\x65array")?.text()?).ok()?;
    let whisker = u16::try_from(at.after(b"\x67whisker")?.integer()?).ok()?;
    let t_us = at.after(b"\x64t_us")?.integer()?;
    let ratio = Some(at.after(b"\x65ratio")?.number()?);
    let deflection_mm = at.after(b"\x6ddeflection_mm")?.number()?;
    let strain = at.after(b"\x66strain")?.number()?;
    let pressure_mpa = at.after(b"\x6cpressure_mpa")?.number()?;
    let temperature_c = at.after(b"\x6dtemperature_c")?.number()?;
    *input = at;
    Some(Contact {
        array,
        whisker,
        t_us,
        ratio,
        ratio_sd: None,
        distance_mm: None,
        distance_sd_mm: None,
        tip: false,
        deflection_mm,
        strain,
        saturated: false,
        pressure_mpa,
        temperature_c,
        angle_deg: None,
        angle_sd_deg: None,
        test_id: None,
    })
}

/// Sets a field that must not be there already.
macro_rules! set {
    ($field:ident, $value:expr) => {{
        if $field.is_some() {
            return None;
        }
        $field = Some($value);
    }};
}

fn contact(input: &mut Input<'_>) -> Option<Contact> {
    let (mut array, mut whisker, mut t_us, mut test_id) = (None, None, None, None);
    let (mut tip, mut saturated) = (None, None);
    let (mut ratio, mut ratio_sd, mut distance_mm, mut distance_sd_mm) = (None, None, None, None);
    let (mut deflection_mm, mut strain, mut pressure_mpa, mut temperature_c) = (None, None, None, None);
    let (mut angle_deg, mut angle_sd_deg) = (None, None);
    for _ in 0..Map::len(input).ok()?? {
        match input.text()? {
            "array" => set!(array, Name::new(input.text()?).ok()?),
            "whisker" => set!(whisker, u16::try_from(input.integer()?).ok()?),
            "t_us" => set!(t_us, input.integer()?),
            "ratio" => set!(ratio, input.number()?),
            "deflection_mm" => set!(deflection_mm, input.number()?),
            "strain" => set!(strain, input.number()?),
            "pressure_mpa" => set!(pressure_mpa, input.number()?),
            "temperature_c" => set!(temperature_c, input.number()?),
            "ratio_sd" => set!(ratio_sd, input.number()?),
            "distance_mm" => set!(distance_mm, input.number()?),
            "distance_sd_mm" => set!(distance_sd_mm, input.number()?),
            "tip" => set!(tip, input.truth()?),
            "angle_deg" => set!(angle_deg, input.number()?),
            "angle_sd_deg" => set!(angle_sd_deg, input.number()?),
            "saturated" => set!(saturated, input.truth()?),
            "test_id" => set!(test_id, input.text()?.to_owned()),
            _ => return None,
        }
    }
    Some(Contact {
        array: array?,
        whisker: whisker?,
        t_us: t_us?,
        ratio,
        ratio_sd,
        distance_mm,
        distance_sd_mm,
        tip: tip.unwrap_or(false),
        deflection_mm: deflection_mm?,
        strain: strain?,
        saturated: saturated.unwrap_or(false),
        pressure_mpa: pressure_mpa?,
        temperature_c: temperature_c?,
        angle_deg,
        angle_sd_deg,
        test_id,
    })
}

#[cfg(test)]
mod tests;
