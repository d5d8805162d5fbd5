//! `vibrissa-lab solve`: the pressure at which one whisker feels like another.

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context, Result};
use clap::Args;
use serde_json::json;
use vibrissa_core::mechanics::{
    CONTACT_RATIOS, Compensator, Model, Offset, Solution, Target, compensable_range, solve_setpoint,
};
use vibrissa_core::units::{Megapascal, Millimetre};

use vibrissa::cli::ANSWER_IS_NO;
use vibrissa::config::choices::{FormulationArg, ObjectiveArg};
use vibrissa_edge::calibration_file;

/// Arguments of `vibrissa-lab solve`.
#[derive(Debug, Args)]
#[command(after_long_help = "\
The exit code is 0 if a pressure makes both whiskers feel alike, and 3 if the answer is OUT OF RANGE (with --json: a \
\"solution\" other than IN_RANGE). The answer then has the best setpoint and its remaining error.")]
pub struct SolveArgs {
    /// Length of the target whisker, mm.
    #[arg(long, value_parser = length)]
    target_mm: Millimetre,
    /// Length of the compensator, mm; for self-compensation the remaining length of the target.
    #[arg(long, value_parser = length)]
    length_mm: Millimetre,
    /// Pressure of the target, MPa.
    #[arg(long, value_parser = examined_pressure, default_value = "0.1")]
    pressure_mpa: Megapascal,
    /// Initial pressure of the compensator, MPa; default: the target's.
    #[arg(long, value_parser = examined_pressure)]
    before_mpa: Option<Megapascal>,
    /// Interpretation of the paper's equations.
    #[arg(long, value_enum, default_value_t = FormulationArg::Published)]
    formulation: FormulationArg,
    /// Objective of the solver.
    #[arg(long, value_enum, default_value_t = ObjectiveArg::Tip)]
    objective: ObjectiveArg,
    /// Calibration file of `vibrissa-lab calibrate` to use instead of the paper's whisker.
    #[arg(long, value_name = "FILE")]
    calibration: Option<PathBuf>,
    /// Print the solution as JSON.
    #[arg(long)]
    json: bool,
}

fn length(text: &str) -> Result<Millimetre, String> {
    let value: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    Millimetre::new(value).map_err(|error| error.to_string())
}

fn examined_pressure(text: &str) -> Result<Megapascal, String> {
    let value: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    let pressure = Megapascal::new(value).ok().filter(|pressure| *pressure <= Megapascal::EXAMINED_MAX);
    pressure.ok_or_else(|| "must be from 0 to 0.2 MPa, the pressures that were examined".to_owned())
}

/// Solves, and prints the result. Out of range is a result with its own exit code, not an error.
///
/// # Errors
/// A whisker is cut into its chamber, or the calibration file is invalid.
pub fn run(args: &SolveArgs, out: &mut dyn Write) -> Result<ExitCode> {
    let answer = SolutionReport::new(args)?;
    if args.json {
        serde_json::to_writer_pretty(&mut *out, &answer.json()).context("writing the answer")?;
        writeln!(out)?;
    } else {
        answer.print(out)?;
    }
    Ok(match answer.solution {
        Solution::InRange(_) => ExitCode::SUCCESS,
        Solution::NeedsBelow(_) | Solution::NeedsAbove(_) => ExitCode::from(ANSWER_IS_NO),
    })
}

struct SolutionReport {
    model_name: String,
    target: Target,
    compensator: Compensator,
    solution: Solution,
    range: (Millimetre, Millimetre),
}

impl SolutionReport {
    fn new(args: &SolveArgs) -> Result<Self> {
        let formulation = args.formulation.into();
        let (model_name, model) = match &args.calibration {
            Some(path) => calibration_file::load(path, formulation)?,
            None => ("nguyen-2021".to_owned(), Model::nguyen_2021(formulation)),
        };
        let target = Target { length: args.target_mm, pressure: args.pressure_mpa };
        let compensator = Compensator {
            length: args.length_mm,
            pressure: args.before_mpa.unwrap_or(args.pressure_mpa),
            pressure_min: Megapascal::ZERO,
            pressure_max: Megapascal::EXAMINED_MAX,
        };
        let (none, objective) = (Offset::NONE, args.objective.into());
        let solution = solve_setpoint(&model, target, none, &model, compensator, none, objective)?;
        let range = compensable_range(&model, target, compensator.pressure_min, compensator.pressure_max);
        Ok(Self { model_name, target, compensator, solution, range })
    }

    fn verdict(&self) -> &'static str {
        match self.solution {
            Solution::InRange(_) => "IN_RANGE",
            Solution::NeedsBelow(_) => "NEEDS_BELOW_RANGE",
            Solution::NeedsAbove(_) => "NEEDS_ABOVE_RANGE",
        }
    }

    fn json(&self) -> serde_json::Value {
        let setpoint = self.solution.setpoint();
        let ratios = (0..CONTACT_RATIOS.len()).map(|k| {
            let error = setpoint.error.used[k].then_some(setpoint.error.by_ratio[k]);
            let (contact_ratio, residual_gain) = (CONTACT_RATIOS[k], setpoint.gain.by_ratio[k]);
            json!({ "contact_ratio": contact_ratio, "predicted_error": error, "residual_gain": residual_gain })
        });
        let (shortest, longest) = self.range;
        json!({
            "model": self.model_name,
            "target_length_mm": self.target.length.mm(),
            "target_pressure_mpa": self.target.pressure.mpa(),
            "compensator_length_mm": self.compensator.length.mm(),
            "pressure_before_mpa": self.compensator.pressure.mpa(),
            "solution": self.verdict(),
            "setpoint_mpa": setpoint.pressure.mpa(),
            "k2": setpoint.k2,
            "reading_gain": setpoint.reading_gain,
            "predicted_error_of_air_alone": (setpoint.error.ratios_used() > 0).then_some(setpoint.air_error),
            "predicted_error_mean": (setpoint.error.ratios_used() > 0).then_some(setpoint.error.mean),
            "by_contact_ratio": ratios.collect::<Vec<_>>(),
            "compensable_length_min_mm": shortest.mm(),
            "compensable_length_max_mm": longest.mm(),
        })
    }

    fn print(&self, out: &mut dyn Write) -> Result<()> {
        let (setpoint, length_mm) = (self.solution.setpoint(), self.compensator.length.mm());
        let target_mm = self.target.length.mm();
        let line = match self.solution {
            Solution::InRange(_) => format!("{length_mm} mm feels like {target_mm} mm at the setpoint below."),
            Solution::NeedsBelow(_) => format!(
                "OUT OF RANGE: {length_mm} mm stays more sensitive than {target_mm} mm at the lowest pressure. \
                 The best setpoint and its remaining error:"
            ),
            Solution::NeedsAbove(_) => format!(
                "OUT OF RANGE: {length_mm} mm stays less sensitive than {target_mm} mm up to the highest pressure. \
                 The best setpoint and its remaining error:"
            ),
        };
        let (shortest, longest) = self.range;
        writeln!(out, "{line}\n")?;
        writeln!(out, "model                 {}", self.model_name)?;
        writeln!(out, "target                {target_mm} mm at {} MPa", self.target.pressure.mpa())?;
        writeln!(out, "compensator           {length_mm} mm, before at {} MPa", self.compensator.pressure.mpa())?;
        writeln!(out, "setpoint              {:.4} MPa", setpoint.pressure.mpa())?;
        writeln!(out, "k2                    {:.4}", setpoint.k2)?;
        if setpoint.reading_gain != 1.0 {
            writeln!(out, "reading gain          {:.4}", setpoint.reading_gain)?;
        }
        writeln!(out, "mean predicted error  {}", self.mean_in_words())?;
        if setpoint.reading_gain != 1.0 {
            writeln!(out, "  of the air alone    {:.2} %", 100.0 * setpoint.air_error)?;
        }
        writeln!(
            out,
            "compensable lengths   {:.1} to {:.1} mm for this target, at the tip",
            shortest.mm(),
            longest.mm()
        )?;
        writeln!(out, "\ncontact ratio   error (%)   residual gain")?;
        for (k, a) in CONTACT_RATIOS.iter().enumerate() {
            let error = setpoint.error.used[k].then_some(100.0 * setpoint.error.by_ratio[k]);
            let error = error.map_or("-".to_owned(), |percent| format!("{percent:.1}"));
            writeln!(out, "{a:>13.2}   {error:>9}   {:>13.3}", setpoint.gain.by_ratio[k])?;
        }
        if setpoint.error.ratios_used() < CONTACT_RATIOS.len() {
            writeln!(
                out,
                "\n-: the contact would lie on the chamber, or there is next to no difference to compensate."
            )?;
        }
        Ok(())
    }

    fn mean_in_words(&self) -> String {
        let error = &self.solution.setpoint().error;
        match error.ratios_used() {
            0 => "none: there is nothing to compensate".to_owned(),
            used if used == CONTACT_RATIOS.len() => format!("{:.2} %", 100.0 * error.mean),
            used => format!("{:.2} % over {used} of {} contact ratios", 100.0 * error.mean, CONTACT_RATIOS.len()),
        }
    }
}
