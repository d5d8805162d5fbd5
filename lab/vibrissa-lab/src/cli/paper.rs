//! `vibrissa-lab paper`: the paper's compensation experiments beside the model's results.

mod statements;

use std::io::Write;
use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::Args;
use vibrissa_core::mechanics::{
    CONTACT_RATIOS, Compensator, Formulation, Model, Objective, Offset, Setpoint, Target, solve_setpoint,
};
use vibrissa_core::units::{Megapascal, Millimetre};

use crate::figures;

/// Arguments of `vibrissa-lab paper`.
#[derive(Debug, Args)]
pub struct PaperArgs {
    /// Draw the model's curves of Fig. 7, 8 and 9 as SVG files into this folder.
    #[arg(long, value_name = "DIR")]
    svg: Option<PathBuf>,
}

/// One of the paper's experiments with its printed results.
struct Experiment {
    name: &'static str,
    compensator_mm: f64,
    target_mm: f64,
    printed_pressure_mpa: &'static str,
    printed_k2: &'static str,
    measured_error_percent: &'static str,
}

/// Both whiskers start at 0.1 MPa. For the model, case 1 and self-compensation are the same: a whisker trimmed to 65 mm
/// is one of 65 mm.
const EXPERIMENTS: [Experiment; 3] = [
    Experiment {
        name: "case 1: 65 mm for a neighbour of 70 mm",
        compensator_mm: 65.0,
        target_mm: 70.0,
        printed_pressure_mpa: "0.048",
        printed_k2: "1.5033",
        measured_error_percent: "20.385",
    },
    Experiment {
        name: "self: trimmed from 70 to 65 mm",
        compensator_mm: 65.0,
        target_mm: 70.0,
        printed_pressure_mpa: "0.048",
        printed_k2: "1.5033",
        measured_error_percent: "(case 1)",
    },
    Experiment {
        name: "case 2: 70 mm for a neighbour of 65 mm",
        compensator_mm: 70.0,
        target_mm: 65.0,
        printed_pressure_mpa: "0.192",
        printed_k2: "0.7365",
        measured_error_percent: "36.1837",
    },
];

const START_MPA: f64 = 0.1;

/// Prints the table, and draws the figures on request.
///
/// # Errors
/// The folder or a figure cannot be written.
pub fn run(args: &PaperArgs, out: &mut dyn Write) -> Result<()> {
    let solved = EXPERIMENTS
        .iter()
        .map(|experiment| {
            let published = solve(experiment, Formulation::Published)?;
            Ok((experiment, published, solve(experiment, Formulation::Consistent)?))
        })
        .collect::<Result<Vec<_>>>()?;
    print_setpoints(&solved, out)?;
    print_errors(&solved, out)?;
    statements::print(out)?;
    print_beyond(out)?;
    if let Some(folder) = &args.svg {
        std::fs::create_dir_all(folder).with_context(|| format!("creating the folder {}", folder.display()))?;
        for path in figures::paper::draw(folder)? {
            writeln!(out, "drawn: {}", path.display())?;
        }
    }
    Ok(())
}

fn solve(experiment: &Experiment, formulation: Formulation) -> Result<Setpoint> {
    solve_for(experiment.compensator_mm, experiment.target_mm, formulation, Objective::Tip)
}

fn solve_for(compensator_mm: f64, target_mm: f64, formulation: Formulation, objective: Objective) -> Result<Setpoint> {
    let model = Model::nguyen_2021(formulation);
    let start = Megapascal::new(START_MPA)?;
    let target = Target { length: Millimetre::new(target_mm)?, pressure: start };
    let compensator = Compensator {
        length: Millimetre::new(compensator_mm)?,
        pressure: start,
        pressure_min: Megapascal::ZERO,
        pressure_max: Megapascal::EXAMINED_MAX,
    };
    let none = Offset::NONE;
    Ok(*solve_setpoint(&model, target, none, &model, compensator, none, objective)?.setpoint())
}

/// Compensator and target of the table beyond the paper, mm.
const BEYOND_MM: [(f64, f64); 7] =
    [(69.0, 70.0), (65.0, 70.0), (60.0, 70.0), (55.0, 70.0), (50.0, 70.0), (40.0, 70.0), (70.0, 65.0)];

/// Air for the shape and one gain on the readings, beside the objectives that use air alone.
fn print_beyond(out: &mut dyn Write) -> Result<()> {
    writeln!(
        out,
        "
Beyond the paper: a robot that multiplies its readings by one number needs air only for the shape of the
response over the contact ratio (objective shape). The paper's pressure for the tip (tip) and the best single
pressure (mean) have air alone; out of range, they have the error of the nearest pressure.

{:<20} {:>20} {:>20} {:>31}
{:<20} {:>20} {:>20} {:>12} {:>9} {:>8}",
        "",
        "tip",
        "mean",
        "shape, with a gain",
        "mm",
        "MPa      error (%)",
        "MPa      error (%)",
        "MPa",
        "gain",
        "error (%)"
    )?;
    for (compensator_mm, target_mm) in BEYOND_MM {
        let solved = |objective| solve_for(compensator_mm, target_mm, Formulation::Published, objective);
        let [tip, mean, shape] = [solved(Objective::Tip)?, solved(Objective::Mean)?, solved(Objective::Shape)?];
        let air = |one: &Setpoint| format!("{:.4} {:>10.2}", one.pressure.mpa(), 100.0 * one.error.mean);
        writeln!(
            out,
            "{:<20} {:>20} {:>20} {:>12.4} {:>9.3} {:>8.2}",
            format!("{compensator_mm} for {target_mm}"),
            air(&tip),
            air(&mean),
            shape.pressure.mpa(),
            shape.reading_gain,
            100.0 * shape.error.mean
        )?;
    }
    Ok(())
}

type Solved<'a> = (&'a Experiment, Setpoint, Setpoint);

fn print_setpoints(solved: &[Solved<'_>], out: &mut dyn Write) -> Result<()> {
    writeln!(
        out,
        "\
The compensation experiments of \"Mechanics and Morphological Compensation Strategy for Trimmed
Soft Whisker Sensor\", as printed and as computed by the model. Both whiskers start at {START_MPA} MPa; the
setpoint makes their tips (a = 1) equally sensitive (eq. 34).

published    eq. 27, 29 and 31 as printed (the default)
consistent   their cubed factor under pressure too, as Table 2 would have it
error        eq. 35, mean over the contact ratios 0.45 to 1; the paper's was measured on real
             whiskers, over lengths of 65 to 69 mm (case 1) and 66 to 70 mm (case 2)
"
    )?;
    for (quantity, decimals, of) in QUANTITIES {
        writeln!(out, "{quantity:<40} {:>10} {:>12} {:>12}", "paper", "published", "consistent")?;
        for (experiment, published, consistent) in solved {
            let [published, consistent] = [published, consistent].map(|setpoint| of.ours(setpoint));
            let (name, printed) = (experiment.name, of.printed(experiment));
            writeln!(out, "  {name:<38} {printed:>10} {published:>12.decimals$} {consistent:>12.decimals$}")?;
        }
        writeln!(out)?;
    }
    Ok(())
}

/// A block of the table.
#[derive(Clone, Copy)]
enum Quantity {
    Pressure,
    K2,
    Error,
}

const QUANTITIES: [(&str, usize, Quantity); 3] = [
    ("setpoint (MPa)", 4, Quantity::Pressure),
    ("k2 at the setpoint", 4, Quantity::K2),
    ("mean error (%)", 2, Quantity::Error),
];

impl Quantity {
    fn printed(self, experiment: &Experiment) -> &'static str {
        match self {
            Self::Pressure => experiment.printed_pressure_mpa,
            Self::K2 => experiment.printed_k2,
            Self::Error => experiment.measured_error_percent,
        }
    }

    fn ours(self, setpoint: &Setpoint) -> f64 {
        match self {
            Self::Pressure => setpoint.pressure.mpa(),
            Self::K2 => setpoint.k2,
            Self::Error => 100.0 * setpoint.error.mean,
        }
    }
}

/// Omits self-compensation, which would repeat case 1.
fn print_errors(solved: &[Solved<'_>], out: &mut dyn Write) -> Result<()> {
    let [(_, one, one_consistent), _, (_, two, two_consistent)] = solved else { return Ok(()) };
    writeln!(out, "{:<16} {:>24} {:>24}", "error (%)", "case 1 and self", "case 2")?;
    writeln!(
        out,
        "{:<16} {:>12} {:>11} {:>12} {:>11}",
        "contact ratio", "published", "consistent", "published", "consistent"
    )?;
    for (k, a) in CONTACT_RATIOS.iter().enumerate() {
        let [one, one_consistent, two, two_consistent] =
            [one, one_consistent, two, two_consistent].map(|setpoint| 100.0 * setpoint.error.by_ratio[k]);
        writeln!(out, "{a:<16.2} {one:>12.2} {one_consistent:>11.2} {two:>12.2} {two_consistent:>11.2}")?;
    }
    Ok(())
}
