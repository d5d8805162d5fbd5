//! A whisker of 70 mm is cut to 65 mm. Feeds its contacts to the core, and prints the detected cut and the decided
//! setpoint: `cargo run -p vibrissa-core --example detect_cut`.

#![allow(clippy::disallowed_macros, reason = "the core knows no I/O, but this program prints its effects")]

use std::error::Error;

use vibrissa_core::mechanics::{Formulation, Model};
use vibrissa_core::robot::effect::Effect;
use vibrissa_core::robot::event::{
    AirControl, ArrayKind, ArraySheet, Contact, ContactPlace, Factsheet, Link, Task, TouchTests, WhiskerSheet,
};
use vibrissa_core::robot::{Event, Numbers, Params, Robot};
use vibrissa_core::units::{ContactRatio, Megapascal, Micros, Millimetre, Strain};

/// Number of contacts before the cut: more than the cold start needs.
const CUT_AT: u64 = 300;

fn main() -> Result<(), Box<dyn Error>> {
    let model = Model::nguyen_2021(Formulation::Published);
    let params = Params::nguyen_2021(Formulation::Published);
    let mut robot = Robot::new(1, Numbers::default());
    let (boot_id, pressure) = ("boot-1", Megapascal::new(0.1)?);
    let factsheet = factsheet(Millimetre::new(70.0)?, pressure);

    // A robot is known by its birth and its factsheet. The caller states the time of each event.
    let mut effects = Vec::new();
    let mut now = Micros::from_s(1_000.0);
    robot.step(&params, now, &Event::Connection { boot_id, link: Link::Online }, &mut effects);
    robot.step(&params, now, &Event::Factsheet { boot_id, factsheet: &factsheet }, &mut effects);

    println!("the cut is before contact {CUT_AT}");
    for seq in 0..CUT_AT + 100 {
        now = now.after(Micros::from_s(0.1));
        let length = Millimetre::new(if seq < CUT_AT { 70.0 } else { 65.0 })?;
        // Places, deflections and errors of 2 % that are spread evenly, without randomness.
        let spread = |step: f64| (seq as f64 * step).fract();
        let ratio = ContactRatio::new(0.5 + 0.5 * spread(0.618_034))?;
        let deflection = Millimetre::new(1.0 + 3.0 * spread(0.754_878))?;
        let error = 0.02 * (2.0 * spread(0.414_214) - 1.0);
        let per_mm = model.sensitivity_per_mm(ratio, length, &model.morphology(pressure))?;
        let contact = Contact {
            array: "left",
            whisker: 0,
            robot_time: now,
            place: ContactPlace::Ratio { ratio, sd: None },
            deflection,
            strain: Strain::new(per_mm * deflection.mm() * (1.0 + error))?,
            pressure,
            is_test: false,
            angle_is_stated: false,
            saturated: false,
            temperature_c: None,
        };
        effects.clear();
        robot.step(&params, now, &Event::Contacts { boot_id, seq, contacts: &[contact], missed: &[] }, &mut effects);
        for effect in &effects {
            print(seq, effect);
        }
    }
    Ok(())
}

/// One whisker that compensates for itself, of the paper's model.
fn factsheet(length: Millimetre, pressure: Megapascal) -> Factsheet {
    let whisker = WhiskerSheet {
        number: 0,
        x_mm: 0.0,
        y_mm: 0.0,
        model: "nguyen-2021".to_owned(),
        length,
        pressure,
        pressure_max: Megapascal::EXAMINED_MAX,
        length_tolerance_mm: 0.5,
        strain_max: None,
        neighbours: Vec::new(),
    };
    let array =
        ArraySheet { name: "left".to_owned(), kind: ArrayKind::Type2, task: Task::Ratio, whiskers: vec![whisker] };
    Factsheet {
        arrays: vec![array],
        touch_tests: TouchTests::default(),
        applies_gain: false,
        air_control: AirControl::FillAndVent,
    }
}

/// Prints the effects that belong to a cut. A supervisor commits all of them first, and then publishes setpoints.
fn print(seq: u64, effect: &Effect) {
    if let Effect::Condition { from, to, .. } = effect {
        println!("contact {seq}: {from:?} -> {to:?}");
    }
    if let Effect::Trim(trim) = effect {
        let (before, after) = (trim.length_before.mm(), trim.length_after);
        println!("  cut from {before:.1} to {:.1} mm, standard deviation {:.1} mm", after.length.mm(), after.sd_mm);
    }
    if let Effect::Command(setpoint) = effect {
        let pressure_mpa = setpoint.pressure.mpa();
        println!("  setpoint {pressure_mpa:.4} MPa for whisker {}: {:?}", setpoint.whisker, setpoint.reason);
    }
}
