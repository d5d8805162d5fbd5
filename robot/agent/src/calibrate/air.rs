//! The steps at a pressure sensor and its valves.

use super::finding::{Finding, Verdict};
use super::measure::{Level, moved_after_s};
use super::session::{Ended, Seen, Session};
use super::{Bench, decimals};
use crate::driver::Opening;

/// Time in which a reading must come, and longest time for a chamber to be empty. s.
const FIRST_S: f64 = 5.0;
const VENT_S: f64 = 20.0;
const SECOND_S: f64 = 1.0;
/// Fewest readings of a second, or of a level.
const READINGS: usize = 3;
/// Largest zero of a sensor, and the least that is worth a correction. MPa.
const ZERO_MPA: f64 = 0.01;
const LEAST_ZERO_MPA: f64 = 0.000_05;
/// Part of the highest pressure above which the chamber is vented, and the part of a regulator's order.
const CEILING: f64 = 0.2;
const ASKED: f64 = 0.1;
/// Change of pressure that counts as moved, in MPa and in differences of the readings at rest. A converter of 10 bits and 5 V
/// has steps of 0.001 22 MPa at a sensor of 4 V/MPa, and its readings jump by one step at rest.
const MOVED_MPA: f64 = 0.002_5;
const MOVED_NOISE: f64 = 3.0;
/// Lengths of the pulses, one after the other until the pressure moves, and of the vent after one that moved nothing: a dead
/// sensor must not let the air collect. ms.
const PULSES_MS: [f64; 6] = [10.0, 20.0, 40.0, 80.0, 160.0, 320.0];
const EMPTIED_MS: f64 = 500.0;
/// Time after a pulse in which the pressure must move, time of a regulator, and time until a level is read. s.
const AFTER_S: f64 = 1.0;
const REGULATED_S: f64 = 5.0;
const LEVEL_S: f64 = 2.0;
/// Times of good valves, s.
const GOOD_S: f64 = 0.5;

const NO_PRESSURE: &str = "no driver sends the pressure of this whisker";
const NO_AIR: &str = "the robot has no air that it controls (air_control)";

/// The zero of the sensor, at an empty chamber.
pub(super) async fn zero(session: &mut Session<'_>, bench: &mut Bench) -> Result<Vec<Finding>, Ended> {
    let what = "pressure sensor's zero";
    if !session.wait(FIRST_S, |seen| !seen.pressures.is_empty()).await? {
        return Ok(vec![Finding::skipped(what, NO_PRESSURE)]);
    }
    let level = vent(session, bench).await?;
    let mean_mpa = level.map_or_else(|| level_of(session.seen()).mean(), Level::mean);
    let value = format!("{} MPa", decimals(mean_mpa, 5));
    let Some(level) = level.filter(|_| mean_mpa.abs() <= ZERO_MPA) else {
        let text = "the chamber does not empty, or the sensor's line is wrong: check the vent valve, and volts for MPa";
        return Ok(vec![Finding::new(what, value, Verdict::Bad, text)]);
    };
    (bench.zero_mpa, bench.noise_mpa) = (Some(mean_mpa), level.range());
    session.set_zero(mean_mpa);
    let finding = Finding::new(what, value, Verdict::Good, "an empty chamber may read a little above or below 0");
    let is_written = mean_mpa.abs() >= LEAST_ZERO_MPA || bench.has_zero;
    Ok(vec![if is_written { finding.writes("pressure_zero_mpa", decimals(mean_mpa, 6)) } else { finding }])
}

/// Opens the vent until the readings stand; their level, if they do.
async fn vent(session: &mut Session<'_>, bench: &Bench) -> Result<Option<Level>, Ended> {
    session.hold(0.0).await;
    let until_s = session.now_s() + VENT_S;
    let mut before: Option<Level> = None;
    while session.now_s() < until_s {
        if bench.regulate {
            session.pulse(Opening::Vent, 1000.0).await;
        }
        session.clear();
        session.wait(SECOND_S, |_| false).await?;
        session.wait(FIRST_S, |seen| seen.pressures.len() >= READINGS).await?;
        let level = level_of(session.seen());
        if level.count() < READINGS {
            continue;
        }
        if let Some(still) = before.and_then(|before| level.still_after(before)) {
            return Ok(Some(still));
        }
        before = Some(level);
    }
    Ok(None)
}

fn level_of(seen: &Seen) -> Level {
    Level::of(seen.pressures.iter().map(|(_, mpa)| *mpa))
}

/// Times of the valves, with a pressure of at most a fifth of the highest one.
pub(super) async fn valves(session: &mut Session<'_>, bench: &mut Bench) -> Result<Vec<Finding>, Ended> {
    let what = "valves";
    if !bench.has_air {
        return Ok(vec![Finding::skipped(what, NO_AIR)]);
    }
    if bench.zero_mpa.is_none() {
        // After a restart of the calibration, or because it could not be measured.
        zero(session, bench).await?;
    }
    let Some(zero_mpa) = bench.zero_mpa else {
        return Ok(vec![Finding::skipped(what, "the pressure of the empty chamber is not known")]);
    };
    let by_mpa = MOVED_MPA.max(MOVED_NOISE * bench.noise_mpa);
    if ASKED * bench.max_mpa < 2.0 * by_mpa {
        return Ok(vec![Finding::skipped(what, "pressure_max_mpa is too small for the noise of the sensor")]);
    }
    session.guard(zero_mpa + CEILING * bench.max_mpa);
    // So much that the vent valve, too, can move it by enough.
    let filled = moved(session, bench, true, (zero_mpa, 2.0 * by_mpa), Opening::Fill).await?;
    session.clear();
    session.wait(LEVEL_S, |seen| seen.pressures.len() >= READINGS).await?;
    let high_mpa = level_of(session.seen()).mean();
    let has_fallen = high_mpa - zero_mpa < 1.5 * by_mpa;
    let vented = match filled.filter(|_| !has_fallen) {
        Some(Moved { pulse_ms, .. }) => {
            moved(session, bench, pulse_ms.is_some(), (high_mpa, -by_mpa), Opening::Vent).await?
        }
        None => None,
    };
    session.hold(0.0).await;
    session.clear();
    session.wait(LEVEL_S, |_| false).await?;
    let every_ms = reading_every_ms(session.seen());
    if session.has_exceeded() {
        let text = format!(
            "the pressure exceeded {} MPa, a fifth of pressure_max_mpa, so the chamber was vented: the valve lets too much \
             through, or does not close. Put a throttle before it",
            decimals(zero_mpa + CEILING * bench.max_mpa, 4)
        );
        return Ok(vec![Finding::new(what, format!("{} MPa", decimals(high_mpa, 4)), Verdict::Bad, text)]);
    }
    let silent = "the pressure did not rise: open the air supply, and check the fill valve and its wires";
    let Some(filled) = filled else { return Ok(vec![Finding::new("fill valve", String::new(), Verdict::Bad, silent)]) };
    if has_fallen {
        let text = "the pressure fell before this valve was opened: look for a leak, and check that the valve closes";
        let leaking = Finding::new("vent valve", String::new(), Verdict::Bad, text);
        return Ok(vec![filled.finding("fill valve", every_ms), leaking]);
    }
    let kept = "the pressure did not fall: check the vent valve and its wires";
    let vented = vented.map_or_else(
        || Finding::new("vent valve", String::new(), Verdict::Bad, kept),
        |moved| moved.finding("vent valve", every_ms),
    );
    Ok(vec![filled.finding("fill valve", every_ms), vented])
}

/// A pressure that moved.
#[derive(Debug, Clone, Copy)]
struct Moved {
    /// Time from the order to the first reading that has moved.
    after_s: f64,
    /// Length of the pulse; `None` if the driver's regulator moved it.
    pulse_ms: Option<f64>,
}

impl Moved {
    fn finding(self, what: &str, every_ms: f64) -> Finding {
        let value = format!("{:.0} ms", self.after_s * 1000.0);
        let order = match self.pulse_ms {
            Some(ms) => format!("a pulse of {ms:.0} ms"),
            None => "the order to the driver's regulator".to_owned(),
        };
        let text = format!("from {order} to the first reading that has moved; readings come every {every_ms:.0} ms");
        let is_good = self.after_s <= GOOD_S + every_ms / 1000.0;
        Finding::new(what, value, if is_good { Verdict::Good } else { Verdict::Check }, text)
    }
}

/// Time until the pressure moves by so much: by pulses that get longer, or by the driver's regulator if it takes none.
async fn moved(
    session: &mut Session<'_>,
    bench: &Bench,
    takes_pulses: bool,
    (from_mpa, by_mpa): (f64, f64),
    open: Opening,
) -> Result<Option<Moved>, Ended> {
    for pulse_ms in PULSES_MS.into_iter().filter(|_| takes_pulses) {
        session.clear();
        let from_s = session.now_s();
        session.pulse(open, pulse_ms).await;
        let find = |seen: &Seen| moved_after_s(&seen.pressures, from_s, from_mpa, by_mpa).is_some();
        if session.wait(pulse_ms / 1000.0 + AFTER_S, find).await? {
            let after_s = moved_after_s(&session.seen().pressures, from_s, from_mpa, by_mpa);
            return Ok(after_s.map(|after_s| Moved { after_s, pulse_ms: Some(pulse_ms) }));
        }
        if open == Opening::Fill {
            session.pulse(Opening::Vent, EMPTIED_MS).await;
            session.wait(EMPTIED_MS / 1000.0, |_| false).await?;
        }
    }
    if bench.regulate {
        return Ok(None);
    }
    // The driver does not know the word `valve`: its regulator moves them.
    session.clear();
    let from_s = session.now_s();
    let asked_mpa = bench.zero_mpa.unwrap_or(0.0) + ASKED * bench.max_mpa;
    session.hold(if by_mpa > 0.0 { asked_mpa } else { 0.0 }).await;
    let find = |seen: &Seen| moved_after_s(&seen.pressures, from_s, from_mpa, by_mpa).is_some();
    session.wait(REGULATED_S, find).await?;
    let after_s = moved_after_s(&session.seen().pressures, from_s, from_mpa, by_mpa);
    Ok(after_s.map(|after_s| Moved { after_s, pulse_ms: None }))
}

/// Mean time between two readings, ms.
fn reading_every_ms(seen: &Seen) -> f64 {
    match (seen.pressures.first(), seen.pressures.last(), seen.pressures.len()) {
        (Some((first_s, _)), Some((last_s, _)), count @ 2..) => 1000.0 * (last_s - first_s) / (count - 1) as f64,
        _ => 0.0,
    }
}
