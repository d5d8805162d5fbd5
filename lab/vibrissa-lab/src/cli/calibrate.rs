//! `vibrissa-lab calibrate`: fits a whisker's calibration to readings of a bench.

mod notes;
mod report;

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow, ensure};
use clap::Args;
use vibrissa::config::choices::FormulationArg;
use vibrissa_core::mechanics::{BenchReading, Calibration, FitError, Formulation, Geometry, Given, Kind, fit_bench};
use vibrissa_core::units::{Millimetre, Strain};
use vibrissa_edge::calibration_file::{self, CalibrationFile};
use vibrissa_protocol::Name;

use self::report::Report;
use super::bench_table::{Bench, HELP, Reading, read};
use crate::figures::calibration;

/// Pressures that count as the paper's 0.002 MPa.
const PAPER_RULE_MPA: std::ops::RangeInclusive<f64> = 0.001..=0.003;

/// Arguments of `vibrissa-lab calibrate`.
#[derive(Debug, Args)]
#[command(after_long_help = format!("\
{HELP}
Without contacts, at least 4 strains at 3 or more pressures above zero are needed, and E is given. With contacts, E is \
fitted. Example (docs/calibration-example.csv):
  pressure_mpa,strain_reading_um_per_m
  0.04,33400
  0.10,118200
docs/bench-example.csv has contacts, too."))]
pub struct CalibrateArgs {
    /// CSV file with the readings of the bench.
    #[arg(value_name = "FILE.csv")]
    file: PathBuf,
    /// Young's modulus of the rubber, MPa. Default: fitted to the contacts of the file, and without contacts 1.1134.
    #[arg(long, value_parser = positive)]
    youngs_modulus_mpa: Option<f64>,
    /// Take E as the modulus of the chamber's wall at 0.002 MPa, as the paper does. The file needs strains there.
    #[arg(long, conflicts_with = "youngs_modulus_mpa")]
    paper_rule: bool,
    /// Fit a factor on all strains, too: for a gauge whose factor is not known. Needs forces or elongations.
    #[arg(long)]
    fit_gauge_gain: bool,
    /// Gauge factor, for instrument readings that were taken with a factor of 1.
    #[arg(long, default_value_t = 2.21, value_parser = positive)]
    gauge_factor: f64,
    /// Length of the whisker, mm, for rows without length_mm.
    #[arg(long, value_parser = length)]
    length_mm: Option<Millimetre>,
    /// Interpretation of the paper's equations.
    #[arg(long, value_enum, default_value_t = FormulationArg::Published)]
    formulation: FormulationArg,
    /// Pitch of the fibres around the chamber, mm, to check their angle.
    #[arg(long, value_parser = positive)]
    fibre_pitch_mm: Option<f64>,
    /// Name of the model in factsheets; default: the name of the file.
    #[arg(long)]
    name: Option<Name>,
    /// Calibration file with the whisker's [geometry]; default: the paper's.
    #[arg(long, value_name = "FILE.toml")]
    geometry: Option<PathBuf>,
    /// Write the calibration to this file.
    #[arg(long, value_name = "FILE.toml")]
    out: Option<PathBuf>,
    /// Draw the readings and the fit to this file.
    #[arg(long, value_name = "FILE.svg")]
    svg: Option<PathBuf>,
}

pub(super) fn positive(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    if value.is_finite() && value > 0.0 { Ok(value) } else { Err("must be above 0".to_owned()) }
}

pub(super) fn length(text: &str) -> Result<Millimetre, String> {
    let value: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    Millimetre::new(value).map_err(|error| error.to_string())
}

/// Where E comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Modulus {
    /// The contacts of the file.
    Fitted,
    /// The caller, with `--youngs-modulus-mpa`.
    Stated,
    /// The paper's rubber, because the file has no contacts.
    Assumed,
    /// E2 at 0.002 MPa, with its standard error in MPa if it was read more than once.
    PaperRule(Option<f64>),
}

/// Fits the readings, prints the result, and writes the requested files.
///
/// # Errors
/// The readings are invalid (with line and column) or determine no calibration, or a file cannot be written.
pub fn run(args: &CalibrateArgs, out: &mut dyn Write) -> Result<()> {
    let name = args.model_name()?;
    let geometry = match &args.geometry {
        Some(path) => *calibration_file::load(path, Formulation::default())?.1.geometry(),
        None => Geometry::nguyen_2021(),
    };
    let bench = Bench { gauge_factor: args.gauge_factor, length: args.length_mm, chamber_end_mm: geometry.l_mm };
    let table = read(&args.file, &bench)?;
    let readings: Vec<BenchReading> = table.iter().map(|one| one.reading).collect();
    let (modulus, youngs_modulus_mpa) = args.modulus(&geometry, &readings)?;
    let given = Given {
        geometry,
        formulation: args.formulation.into(),
        youngs_modulus_mpa,
        fits_gauge_gain: args.fit_gauge_gain,
    };
    let fit = fit_bench(&given, &readings).map_err(|error| at_line(&args.file, &table, error))?;
    // A given E is an assumption. Contacts, if there are any, measure it.
    let by_contacts = match modulus {
        Modulus::PaperRule(_) | Modulus::Stated if has_contacts(&readings) => {
            fit_bench(&Given { youngs_modulus_mpa: None, ..given }, &readings).ok()
        }
        Modulus::PaperRule(_) | Modulus::Fitted | Modulus::Stated | Modulus::Assumed => None,
    };
    let mut warnings = notes::warnings(&fit, by_contacts.as_ref());
    if modulus == Modulus::Fitted {
        let formulation = other(given.formulation);
        let fitted = fit_bench(&Given { formulation, ..given }, &readings).ok();
        warnings.extend(fitted.and_then(|fitted| notes::formulation(&fit, &fitted)));
        let fitted = fit_bench(&Given { fits_gauge_gain: true, ..given }, &readings).ok();
        warnings.extend(fitted.filter(|_| !given.fits_gauge_gain).and_then(|fitted| notes::gauge_gain(&fitted)));
    }
    // Files first, so that they exist even if the reader of the report closes the pipe.
    if let Some(path) = &args.out {
        let comment = report::comment(&args.file, &fit, modulus, &warnings);
        write_toml(path, &comment, &CalibrationFile::new(&name, &geometry, &fit.calibration))?;
    }
    if let Some(path) = &args.svg {
        calibration::draw(path, name.as_str(), &readings, &fit)?;
    }
    let report = Report { name: &name, table: &table, fit: &fit, modulus, geometry: &geometry };
    report.print(out)?;
    for warning in &warnings {
        writeln!(out, "warning: {warning}")?;
    }
    for note in notes::notes(&geometry, &fit, &table, args.fibre_pitch_mm) {
        writeln!(out, "note: {note}")?;
    }
    report.print_readings(out)?;
    for (done, path) in [("written", &args.out), ("drawn", &args.svg)] {
        if let Some(path) = path {
            writeln!(out, "{done}: {}", path.display())?;
        }
    }
    Ok(())
}

fn other(formulation: Formulation) -> Formulation {
    match formulation {
        Formulation::Published => Formulation::Consistent,
        Formulation::Consistent => Formulation::Published,
    }
}

fn has_contacts(readings: &[BenchReading]) -> bool {
    readings.iter().any(|reading| reading.contact().is_some())
}

impl CalibrateArgs {
    fn model_name(&self) -> Result<Name> {
        if let Some(name) = &self.name {
            return Ok(name.clone());
        }
        let stem = self.file.file_stem().unwrap_or_default().to_string_lossy();
        Name::new(&stem).context("the file's name is not a valid model name: give one with --name")
    }

    /// Where E comes from, and its value in MPa if it is given.
    fn modulus(&self, geometry: &Geometry, readings: &[BenchReading]) -> Result<(Modulus, Option<f64>)> {
        if self.paper_rule {
            let (modulus_mpa, error_mpa) = paper_rule(geometry, readings).with_context(|| {
                format!("{}: --paper-rule needs strains without contact at 0.002 MPa", self.file.display())
            })?;
            return Ok((Modulus::PaperRule(error_mpa), Some(modulus_mpa)));
        }
        Ok(match self.youngs_modulus_mpa {
            Some(modulus_mpa) => (Modulus::Stated, Some(modulus_mpa)),
            None if has_contacts(readings) => (Modulus::Fitted, None),
            None => (Modulus::Assumed, Some(Calibration::nguyen_2021().youngs_modulus_mpa)),
        })
    }
}

/// E2 of the mean strain at 0.002 MPa, and its standard error if there are several strains.
fn paper_rule(geometry: &Geometry, readings: &[BenchReading]) -> Option<(f64, Option<f64>)> {
    let moduli_mpa: Vec<f64> = readings
        .iter()
        .filter(|reading| reading.kind() == Some(Kind::Axial) && PAPER_RULE_MPA.contains(&reading.pressure.mpa()))
        .filter_map(|reading| {
            geometry.youngs_modulus_from_axial_strain(reading.pressure, Strain::new(reading.value).ok()?)
        })
        .collect();
    let count = moduli_mpa.len() as f64;
    // The mean strain at one pressure belongs to the harmonic mean of the moduli.
    let mean = count / moduli_mpa.iter().map(|one| one.recip()).sum::<f64>();
    let squares: f64 = moduli_mpa.iter().map(|one| (one - mean).powi(2)).sum();
    let error = (count > 1.0).then(|| (squares / (count - 1.0) / count).sqrt());
    (count > 0.0).then_some((mean, error))
}

/// Replaces the fit's row numbers by the file's line numbers.
pub(super) fn at_line(path: &Path, table: &[Reading], error: FitError) -> anyhow::Error {
    let file = path.display();
    let line = |row: usize| table.get(row - 1).map_or(0, |reading| reading.line);
    match error {
        FitError::StrainNotPositive { row, value } => {
            anyhow!("{file}, line {}, strain: must be above 0 under pressure, not {value} m/m", line(row))
        }
        FitError::ElongationNotPositive { row, value_mm } => {
            anyhow!("{file}, line {}, elongation_mm: must be above 0 under pressure, not {value_mm}", line(row))
        }
        FitError::ForceBelowZero { row, value_n } => {
            anyhow!("{file}, line {}, force_n: must not be below 0 N, not {value_n}", line(row))
        }
        FitError::OnChamber { row, problem } => {
            anyhow!("{file}, line {}: {problem}. The model is valid beyond the chamber only", line(row))
        }
        FitError::NotDetermined { parameter: parameter @ ("c" | "a" | "b") } => anyhow!(
            "{file}: the readings do not determine {parameter}: add readings at more pressures from low to high. The \
             chamber must become softer with the pressure: its strain must rise faster than the pressure. Check the order \
             of the columns, their units, and that nothing touched the whisker"
        ),
        FitError::NotDetermined { parameter } => anyhow!(
            "{file}: the readings do not determine {parameter}: its interval is as wide as it was assumed before any reading. \
             Add forces, and strains of contacts at two or more places (ratios 0.45 and 1) and at pressures from 0 to 0.2 MPa; \
             or give E with --youngs-modulus-mpa, and leave out --fit-gauge-gain"
        ),
        FitError::NothingAboveZeroPressure
        | FitError::TooFewStrains { .. }
        | FitError::TooFewPressures { .. }
        | FitError::OneElongation
        | FitError::GaugeReversed
        | FitError::ModulusWithoutContacts
        | FitError::NoScatter { .. } => anyhow!("{file}: {error}"),
        FitError::Model(_) => anyhow!(
            "{file}: these readings lead to an impossible chamber: {error}. Check the units of the strains, and \
             --gauge-factor: a strain of 0.01 m/m is a reading of 22100 um/m at a gauge factor of 2.21"
        ),
    }
}

fn write_toml(path: &Path, comment: &str, file: &CalibrationFile) -> Result<()> {
    let body = toml::to_string(file).context("writing the calibration as TOML")?;
    ensure!(!path.is_symlink(), "{} is a symbolic link: name the file itself", path.display());
    std::fs::write(path, format!("{comment}{body}")).with_context(|| format!("writing {}", path.display()))
}
