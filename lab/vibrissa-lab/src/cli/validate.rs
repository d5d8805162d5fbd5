//! `vibrissa-lab validate`: compares readings of a bench with a calibration.

mod eq35;
mod groups;

pub(crate) use self::eq35::{Compensation, compensations};
pub(crate) use self::groups::{Compared, Comparison, clusters, rounded};

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context, Result};
use clap::Args;
use vibrissa::cli::ANSWER_IS_NO;
use vibrissa::config::choices::FormulationArg;
use vibrissa_core::mechanics::{FitError, Kind, Model};
use vibrissa_core::units::Millimetre;
use vibrissa_edge::calibration_file;

use self::groups::Errors;
use super::bench_table::{Bench, HELP, read};
use super::calibrate::{at_line, length, positive};
use crate::figures;

/// Arguments of `vibrissa-lab validate`.
#[derive(Debug, Args)]
#[command(after_long_help = format!("\
{HELP}
The exit code is 0 if no group of readings is off by more than 5 % and by more than its own scatter, and 3 otherwise."))]
pub struct ValidateArgs {
    /// CSV file with the readings of the bench, as for `calibrate`.
    #[arg(value_name = "BENCH.csv")]
    file: PathBuf,
    /// Calibration file of the whisker.
    #[arg(long, value_name = "FILE.toml")]
    calibration: PathBuf,
    /// Interpretation of the paper's equations.
    #[arg(long, value_enum, default_value_t = FormulationArg::Published)]
    formulation: FormulationArg,
    /// Gauge factor, for instrument readings that were taken with a factor of 1.
    #[arg(long, default_value_t = 2.21, value_parser = positive)]
    gauge_factor: f64,
    /// Length of the whisker, mm, for rows without length_mm.
    #[arg(long, value_parser = length)]
    length_mm: Option<Millimetre>,
    /// Draw the counterparts of Fig. 6 to 10, measured and computed, as SVG files into this folder.
    #[arg(long, value_name = "DIR")]
    svg: Option<PathBuf>,
}

/// Compares, and prints the tables.
///
/// # Errors
/// A file is invalid or cannot be written, or a contact lies on the chamber.
pub fn run(args: &ValidateArgs, out: &mut dyn Write) -> Result<ExitCode> {
    let (name, model) = calibration_file::load(&args.calibration, args.formulation.into())?;
    let chamber_end_mm = model.geometry().l_mm;
    let table = read(&args.file, &Bench { gauge_factor: args.gauge_factor, length: args.length_mm, chamber_end_mm })?;
    for (at, one) in table.iter().enumerate() {
        if let Some(contact) = one.reading.contact() {
            let row = at + 1;
            let checked = contact.check(&model, one.reading.pressure);
            checked.map_err(|problem| at_line(&args.file, &table, FitError::OnChamber { row, problem }))?;
        }
    }
    let comparison = Comparison::new(&table, &model);
    writeln!(out, "Readings of {} against the calibration {name}: measured / computed - 1", args.file.display())?;
    let misfits = print_groups(&comparison, out)?;
    print_compensations(&comparison, &model, out)?;
    if let Some(folder) = &args.svg {
        std::fs::create_dir_all(folder).with_context(|| format!("creating the folder {}", folder.display()))?;
        for path in figures::bench::draw(folder, &name, &comparison, &model)? {
            writeln!(out, "drawn: {}", path.display())?;
        }
    }
    if misfits.is_empty() {
        writeln!(out, "The calibration fits: no group is off by more than 5 % and its own scatter.")?;
        return Ok(ExitCode::SUCCESS);
    }
    writeln!(out, "The calibration does not fit:")?;
    for misfit in misfits {
        writeln!(out, "  {misfit}")?;
    }
    Ok(ExitCode::from(ANSWER_IS_NO))
}

/// A table: its title, the kind of readings, and the key of its groups with the words for a key.
type Table<'a> = (&'static str, &'static str, Kind, fn(&Compared) -> Option<f64>, &'a dyn Fn(f64) -> String);

/// Prints all tables. Returns a sentence for each misfit.
fn print_groups(comparison: &Comparison, out: &mut dyn Write) -> Result<Vec<String>> {
    let pressure: fn(&Compared) -> Option<f64> = |one| Some(one.reading.pressure.mpa());
    let place: fn(&Compared) -> Option<f64> = |one| one.place;
    let length: fn(&Compared) -> Option<f64> = |one| one.length_mm;
    let in_mpa = |key: f64| format!("{} MPa", rounded(key, 1000.0));
    let at_place = |key: f64| comparison.place(key);
    let of_mm = |key: f64| format!("{} mm long", rounded(key, 10.0));
    let tables: [Table<'_>; 8] = [
        ("Strain without contact by pressure", "strain without contact", Kind::Axial, pressure, &in_mpa),
        ("Elongation by pressure", "elongation", Kind::Elongation, pressure, &in_mpa),
        ("Force per deflection by place", "force", Kind::ContactForce, place, &at_place),
        ("Force per deflection by pressure", "force", Kind::ContactForce, pressure, &in_mpa),
        ("Strain per deflection by place", "strain", Kind::ContactStrain, place, &at_place),
        ("Strain per deflection by pressure", "strain", Kind::ContactStrain, pressure, &in_mpa),
        ("Strain per deflection by length", "strain", Kind::ContactStrain, length, &of_mm),
        ("Force per deflection by length", "force", Kind::ContactForce, length, &of_mm),
    ];
    let mut misfits = Vec::new();
    for (title, what, kind, key, words) in tables {
        let groups = clusters(&comparison.of_kind(kind), key);
        if groups.is_empty() {
            continue;
        }
        writeln!(out, "\n{title:<40} {:>8} {:>15} {:>24}", "readings", "mean error (%)", "95 % of readings (%)")?;
        for (key, group) in groups {
            let errors = Errors::new(&group);
            let half = errors.half_of_one.map_or("-".to_owned(), |half| {
                format!("{:.1} to {:.1}", 100.0 * (errors.mean - half), 100.0 * (errors.mean + half))
            });
            let (words, mean) = (words(key), 100.0 * errors.mean);
            writeln!(out, "  {words:<38} {:>8} {mean:>15.1} {half:>24}", errors.readings)?;
            if errors.is_misfit() {
                let side = if mean > 0.0 { "above" } else { "below" };
                misfits.push(format!("{what} at {words} is {:.0} % {side} the model", mean.abs()));
            }
        }
    }
    writeln!(out)?;
    Ok(misfits)
}

/// Eq. 35 by place, from strains of whiskers of several lengths.
fn print_compensations(comparison: &Comparison, model: &Model, out: &mut dyn Write) -> Result<()> {
    let found = compensations(comparison, model);
    if found.is_empty() {
        return Ok(());
    }
    writeln!(
        out,
        "{:<58} {:>8} {:>12} {:>12}",
        "Compensation error (eq. 35)", "ratio", "measured (%)", "computed (%)"
    )?;
    for one in found {
        for (at, (ratio, measured, computed)) in one.by_ratio.iter().enumerate() {
            let name = if at == 0 { one.name() } else { String::new() };
            let (measured, computed) = (100.0 * measured, 100.0 * computed);
            writeln!(out, "  {name:<56} {:>8} {measured:>12.1} {computed:>12.1}", rounded(*ratio, 100.0))?;
        }
    }
    writeln!(out)?;
    Ok(())
}
