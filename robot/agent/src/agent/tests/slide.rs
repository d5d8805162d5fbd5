//! The way of a real board, as docs/first-robot.md describes it: the sketch with a slide, whose whisker slips off the tip of
//! a rod again and again. It may start in each phase of that, with both polarities of the gauge and five gains of the
//! amplifier.

use vibrissa_protocol::{Contact, Gauge, PlaceKind};

use super::*;
use crate::config::Sign;

/// Strain a millimetre of a touch at the tip of a whisker of 70 mm.
const PER_MM: f64 = 0.0036;
/// Deflection at which the whisker slips off, and the time after which it is free. mm, s.
const SLIP_MM: f64 = 1.2;
const FREE_S: f64 = 0.01;
/// A cycle: forwards in the first part of it, with the touch from here to the slip-off; then back. s.
const CYCLE_S: f64 = 1.0;
const FORTH_S: f64 = 0.5;
const TOUCH_S: f64 = 0.2;
/// Speed of the slide, mm/s.
const MM_PER_S: f64 = 12.0;
/// Steps of a converter of ten bits, and the travel of the potentiometer, mm.
const STEPS: f64 = 1024.0;
const TRAVEL_MM: f64 = 30.0;
/// Samples in a line of the sketch, and the time between them.
const COUNT: u64 = 10;
const EVERY_US: u64 = 10_000;
/// Seconds that are watched, and those after which each touch counts.
const SECONDS: f64 = 24.0;
const GRACE_S: f64 = 10.0;

/// Strain and way of the slide at a time of the cycle. `returns`: on its way back the whisker touches the rod again, from the
/// other side.
fn at(seconds: f64, returns: bool) -> (f64, f64) {
    let at_s = seconds % CYCLE_S;
    let way_mm = if at_s < FORTH_S { at_s } else { CYCLE_S - at_s } * MM_PER_S;
    let touched = |from_s: f64| {
        let since_s = at_s - from_s;
        let slip_s = SLIP_MM / MM_PER_S;
        if since_s <= slip_s {
            since_s.max(0.0) * MM_PER_S
        } else {
            SLIP_MM * (1.0 - (since_s - slip_s) / FREE_S).max(0.0)
        }
    };
    // The tip passes the rod at the slip-off, and meets it there on its way back.
    let back_s = CYCLE_S - TOUCH_S - SLIP_MM / MM_PER_S;
    let back_mm = if returns { touched(back_s) } else { 0.0 };
    (PER_MM * (touched(TOUCH_S) - back_mm), way_mm)
}

/// Lets a board run from a phase of the cycle on; the contacts, with the seconds since its start.
fn run(bench: &mut Bench, phase_s: f64, polarity: f64, end: f64, returns: bool) -> Vec<(f64, Contact)> {
    let (begin_us, mut sent) = (bench.now_us, BTreeMap::new());
    for block in 0..(SECONDS / 0.1) as u64 {
        let list = |value: &dyn Fn(f64, u64) -> f64| {
            let values = (0..COUNT).map(|one| {
                let index = block * COUNT + one;
                format!("{:.6}", value(phase_s + index as f64 * 0.01, index))
            });
            values.collect::<Vec<String>>().join(",")
        };
        let grain = 2.0 * end / STEPS;
        let strain = list(&|s, index| {
            // The noise of an amplifier is more than a step of the converter.
            let noise = 0.7 * grain * (((index * 7919) % 21) as f64 / 10.0 - 1.0);
            let strain = polarity * at(s, returns).0 + 0.05 * end + noise;
            ((strain / grain).round() * grain).clamp(-end, end)
        });
        let way = list(&|s, _| (at(s, returns).1 / TRAVEL_MM * STEPS).round() * TRAVEL_MM / STEPS);
        let t_ms = 700 + block * COUNT * EVERY_US / 1000;
        bench.run(0.1);
        bench.read(0, 0.1);
        bench.line(&format!(
            r#"{{"type":"strain","array":"left","whisker":0,"t_ms":{t_ms},"every_us":{EVERY_US},"strain":[{strain}],"deflection_mm":[{way}]}}"#
        ));
        for message in bench.contacts() {
            bench.receipt("b1", message.seq + 1);
            sent.insert(message.seq, message.contacts);
        }
    }
    let since_s = |contact: &Contact| contact.t_us.saturating_sub(begin_us) as f64 / 1e6;
    sent.into_values().flatten().map(|contact| (since_s(&contact), contact)).collect()
}

fn board(sign: Option<Sign>) -> Bench {
    let mut bench = Bench::new(|config| {
        config.facts.arrays[0].whiskers.iter_mut().for_each(|whisker| whisker.place = Some(PlaceKind::Tip));
        config.whiskers.values_mut().for_each(|whisker| whisker.sign = sign);
    });
    bench.step(Input::Connected);
    bench.step(Input::DriverStarted(0));
    bench.read(0, 0.1);
    bench.take();
    bench
}

/// Slip-offs between the time of grace and the last second.
fn expected(phase_s: f64) -> usize {
    let slip_s = TOUCH_S + SLIP_MM / MM_PER_S;
    let times = (0..=SECONDS as usize + 1).map(|cycle| cycle as f64 * CYCLE_S + slip_s - phase_s);
    times.filter(|at_s| (GRACE_S..SECONDS - 1.0).contains(at_s)).count()
}

#[test]
fn a_board_may_start_in_each_phase_with_both_polarities_and_five_gains() {
    // The converter ends at these strains; the first one is below that of the touch.
    for end in [0.003, 0.005, 0.01, 0.02, 0.04] {
        for (polarity, sign) in [(1.0, None), (1.0, Some(Sign::Rises)), (-1.0, Some(Sign::Falls))] {
            for phase in 0..10 {
                let (phase_s, what) = (f64::from(phase) * 0.1, format!("end {end}, {sign:?}, phase {phase}"));
                let mut bench = board(sign);
                let contacts = run(&mut bench, phase_s, polarity, end, false);
                let counted =
                    contacts.iter().filter(|(at_s, _)| (GRACE_S..SECONDS - 1.0).contains(at_s)).collect::<Vec<_>>();
                assert!(counted.len().abs_diff(expected(phase_s)) <= 1, "{what}: {} contacts", counted.len());
                let clips = end < PER_MM * SLIP_MM;
                for (_, contact) in &contacts {
                    assert!(contact.tip && contact.strain > 0.0, "{what}: {contact:?}");
                    assert_eq!(contact.saturated, clips, "{what}: {contact:?}");
                    assert!((contact.deflection_mm / SLIP_MM - 1.0).abs() < 0.15, "{what}: {contact:?}");
                    let part = contact.strain / (PER_MM * SLIP_MM);
                    assert!(clips || (part - 1.0).abs() < 0.1, "{what}: {part} of the strain");
                }
                let gauge = bench.agent.snapshot(Now::of_us(bench.now_us)).whiskers[0].gauge;
                assert_eq!(gauge == Gauge::Saturated, clips, "{what}");
            }
        }
    }
}

#[test]
fn touches_of_the_way_back_have_the_other_sign_and_do_not_invert_the_others() {
    for phase in 0..10 {
        let phase_s = f64::from(phase) * 0.1;
        let contacts = run(&mut board(None), phase_s, 1.0, 0.01, true);
        let positive = contacts.iter().filter(|(at_s, one)| *at_s >= GRACE_S && one.strain > 0.0).count();
        let negative = contacts.iter().filter(|(at_s, one)| *at_s >= GRACE_S && one.strain < 0.0).count();
        let least = expected(phase_s) - 1;
        assert!(positive >= least && negative >= least, "phase {phase}: {positive} and {negative} of {least}");
        assert!(positive + negative <= 2 * expected(phase_s) + 4, "phase {phase}: {positive} and {negative}");
    }
}
