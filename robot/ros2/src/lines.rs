//! Messages of ROS in the words of the agent, and back. ROS uses metres, the agent millimetres.

use ros2_client::builtin_interfaces::Time;

use crate::messages::{self, Contact, Fault, Header, Strain, TouchTestGoal};
use crate::words::{ContactLine, Estimate, Named, Samples, StrainLine, TestOrder};

/// Longest identifier of a touch test, in bytes.
const TEST_ID_MAX: usize = 64;
/// Most samples in a line of strain.
const SAMPLES_MAX: usize = 1000;
/// Time between samples that the agent takes, us.
const EVERY_US: std::ops::RangeInclusive<u32> = 500..=100_000;
/// States of a gauge.
const GAUGE: [&str; 4] = ["OK", "SATURATED", "OPEN", "SHORT"];
/// States of a regulator.
const REGULATOR: [&str; 6] = ["OK", "FILLING", "VENTING", "SUPPLY_LOW", "LEAK", "FAULT"];

/// A contact in the words of the agent, which checks ranges itself.
///
/// # Errors
/// A number is not finite, or the place is unknown.
pub(crate) fn contact_line(contact: Contact, t_us: Option<u64>) -> Result<ContactLine, String> {
    let name = format!("{}/{}", contact.array, contact.whisker);
    let numbers = [
        ("deflection_m", contact.deflection_m),
        ("strain", contact.strain),
        ("distance_m", contact.distance_m),
        ("distance_sd_m", contact.distance_sd_m),
        ("ratio", contact.ratio),
        ("ratio_sd", contact.ratio_sd),
    ];
    if let Some((field, value)) = numbers.iter().find(|(_, value)| !value.is_finite()) {
        return Err(format!("a contact of {name}: {field} is {value}"));
    }
    if contact.test_id.len() > TEST_ID_MAX {
        return Err(format!("a contact of {name}: test_id has more than {TEST_ID_MAX} bytes"));
    }
    let above_0 = |value: f64| (value > 0.0).then_some(value);
    let (distance_mm, distance_sd_mm) = (contact.distance_m * 1e3, above_0(contact.distance_sd_m * 1e3));
    let mut line = ContactLine {
        array: contact.array,
        whisker: contact.whisker,
        t_us,
        deflection_mm: contact.deflection_m * 1e3,
        strain: contact.strain,
        saturated: contact.saturated.then_some(true),
        distance_mm: None,
        distance_sd_mm: None,
        ratio: None,
        ratio_sd: None,
        tip: None,
        test_id: Some(contact.test_id).filter(|test_id| !test_id.is_empty()),
        touched: contact.missed.then_some(false),
    };
    match contact.place {
        0 => {}
        1 => (line.distance_mm, line.distance_sd_mm) = (Some(distance_mm), distance_sd_mm),
        2 => (line.ratio, line.ratio_sd) = (Some(contact.ratio), above_0(contact.ratio_sd)),
        3 => {
            line.tip = Some(true);
            line.distance_mm = above_0(distance_mm);
            line.distance_sd_mm = line.distance_mm.and(distance_sd_mm);
        }
        other => return Err(format!("a contact of {name}: place is {other}, and none of the constants 0 to 3")),
    }
    Ok(line)
}

/// Time from the first to the last sample, us.
///
/// # Errors
/// The number of samples, or the time between them, is out of range.
pub(crate) fn span_us(name: &str, strain: &Strain) -> Result<u32, String> {
    let count = strain.strain.len();
    if !(1..=SAMPLES_MAX).contains(&count) {
        return Err(format!("strain of {name}: {count} samples; a message has 1 to {SAMPLES_MAX}"));
    }
    if count > 1 && !EVERY_US.contains(&strain.every_us) {
        let every_us = strain.every_us;
        return Err(format!("strain of {name}: every_us is {every_us}; several samples need 500 to 100000"));
    }
    let steps = u32::try_from(count - 1).unwrap_or(u32::MAX);
    Ok(if steps == 0 { 0 } else { steps.saturating_mul(strain.every_us) })
}

/// Samples of strain in the words of the agent; `t_us` is the time of the first one.
///
/// # Errors
/// Numbers are not finite, or lists have different lengths.
pub(crate) fn strain_line(whisker: &Named, strain: Strain, t_us: u64) -> Result<StrainLine, String> {
    let name = format!("{}/{}", whisker.array, whisker.whisker);
    let count = strain.strain.len();
    let samples = |field: &str, values: Vec<f64>, factor: f64, allows_one: bool| {
        if values.iter().any(|value| !value.is_finite()) {
            return Err(format!("strain of {name}: {field} has a number that is not finite"));
        }
        match values[..] {
            [] => Ok(None),
            [value] if count == 1 || allows_one => Ok(Some(Samples::One(value * factor))),
            _ if values.len() == count => {
                Ok(Some(Samples::Many(values.into_iter().map(|value| value * factor).collect())))
            }
            _ => Err(format!("strain of {name}: {field} has {} numbers for {count} samples", values.len())),
        }
    };
    if strain.test_id.len() > TEST_ID_MAX {
        return Err(format!("strain of {name}: test_id has more than {TEST_ID_MAX} bytes"));
    }
    let first = samples("strain", strain.strain, 1.0, false)?;
    Ok(StrainLine {
        t_us,
        strain: first.ok_or_else(|| format!("strain of {name}: no samples"))?,
        strain_2: samples("strain_2", strain.strain_2, 1.0, false)?,
        every_us: (count > 1).then_some(strain.every_us),
        deflection_mm: samples("deflection_m", strain.deflection_m, 1e3, true)?,
        distance_mm: samples("distance_m", strain.distance_m, 1e3, true)?,
        test_id: Some(strain.test_id).filter(|test_id| !test_id.is_empty()),
        array: whisker.array.clone(),
        whisker: whisker.whisker,
    })
}

/// The states of gauge and regulator; `None` where the message says nothing.
///
/// # Errors
/// A word is unknown or missing.
pub(crate) fn states_of(fault: &Fault) -> Result<[Option<&'static str>; 2], String> {
    let word = |field: &str, text: &str, words: &[&'static str]| {
        let known = words.iter().find(|word| **word == text).copied();
        if known.is_some() || text.is_empty() {
            return Ok(known);
        }
        let (array, whisker) = (&fault.array, fault.whisker);
        Err(format!("a fault of {array:.64}/{whisker}: {field} is {text:.32}, and none of {}", words.join(", ")))
    };
    let states = [word("gauge", &fault.gauge, &GAUGE)?, word("regulator", &fault.regulator, &REGULATOR)?];
    if states == [None, None] {
        return Err(format!("a fault of {:.64}/{}: gauge and regulator are empty", fault.array, fault.whisker));
    }
    Ok(states)
}

/// An estimate as a message.
pub(crate) fn estimate_message(stamp: Time, estimate: &Estimate) -> messages::Estimate {
    let (gain_ratio, gain) = estimate.gain.iter().copied().unzip();
    messages::Estimate {
        header: Header { stamp, frame_id: format!("{}/{}", estimate.array, estimate.whisker) },
        array: estimate.array.clone(),
        whisker: estimate.whisker,
        length_m: estimate.length_mm * 1e-3,
        length_low_m: estimate.length_low_mm * 1e-3,
        length_high_m: estimate.length_high_mm * 1e-3,
        condition: estimate.condition.clone(),
        gain_ratio,
        gain,
    }
}

/// The order for a touch test as the goal of an action.
///
/// # Errors
/// The kind is unknown.
pub(crate) fn goal_of(order: TestOrder) -> Result<TouchTestGoal, String> {
    let kind = match order.kind.as_str() {
        "WALL" => 1,
        "TIP" => 2,
        other => return Err(format!("the agent orders a touch test of the unknown kind {other:.32}")),
    };
    let metres = |values: Vec<f64>| values.into_iter().map(|mm| mm * 1e-3).collect();
    Ok(TouchTestGoal {
        test_id: order.test_id,
        array: order.array,
        whisker: order.whisker,
        kind,
        distances_m: metres(order.distances_mm),
        deflections_m: metres(order.deflections_mm),
        contacts: order.contacts,
    })
}
