//! `vibrissa-lab calibrate`: fits a whisker's calibration to readings under pressure.

mod readings;

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow};
use clap::Args;
use vibrissa_core::mechanics::{Calibration, Fit, FitError, Formulation, Geometry, Parameter, fit_calibration};
use vibrissa_protocol::Name;

use self::readings::{Reading, read};
use crate::figures::calibration;
use vibrissa_edge::calibration_file::{self, CalibrationFile};

/// Arguments of `vibrissa-lab calibrate`.
#[derive(Debug, Args)]
#[command(after_long_help = "\
The CSV file has a header. Columns, in any order:
  pressure_mpa              gauge pressure of the chamber
  strain                    axial strain of the gauge, m/m; or instead one of
  strain_reading_um_per_m   instrument reading in um/m, which is divided by the gauge factor
  strain_reading_mm_per_m   instrument reading in mm/m, likewise
  elongation_mm             elongation of the chamber (optional)
Columns are separated by commas, and numbers have a decimal point. An empty cell means no reading. Lines that start with
# are ignored. At least 4 strains at 3 or more pressures above zero are needed. Example (docs/calibration-example.csv):
  pressure_mpa,strain_reading_um_per_m
  0.04,33400
  0.10,118200
100 kPa are 0.1 MPa.")]
pub struct CalibrateArgs {
    /// CSV file with the readings: pressure and strain without contact.
    #[arg(value_name = "FILE.csv")]
    file: PathBuf,
    /// Young's modulus of the rubber, MPa; strains alone determine only its product with k2.
    #[arg(long, default_value_t = Calibration::nguyen_2021().youngs_modulus_mpa, value_parser = positive)]
    youngs_modulus_mpa: f64,
    /// Gauge factor, for instrument readings that were taken with a factor of 1.
    #[arg(long, default_value_t = 2.21, value_parser = positive)]
    gauge_factor: f64,
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

fn positive(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    if value.is_finite() && value > 0.0 { Ok(value) } else { Err("must be above 0".to_owned()) }
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
    let readings = read(&args.file, args.gauge_factor)?;
    let rows: Vec<_> = readings.iter().map(|reading| reading.row).collect();
    let fit = fit_calibration(&geometry, args.youngs_modulus_mpa, &rows)
        .map_err(|error| at_line(&args.file, &readings, error))?;
    // Files first, so that they exist even if the reader of the report closes the pipe.
    if let Some(path) = &args.out {
        write_toml(path, &args.file, &CalibrationFile::new(&name, &geometry, &fit.calibration))?;
    }
    if let Some(path) = &args.svg {
        calibration::draw(path, name.as_str(), &rows, &fit)?;
    }
    print_fit(&name, &geometry, &fit, out)?;
    print_readings(&readings, &fit, out)?;
    for (done, path) in [("written", &args.out), ("drawn", &args.svg)] {
        if let Some(path) = path {
            writeln!(out, "{done}: {}", path.display())?;
        }
    }
    Ok(())
}

impl CalibrateArgs {
    fn model_name(&self) -> Result<Name> {
        if let Some(name) = &self.name {
            return Ok(name.clone());
        }
        let stem = self.file.file_stem().unwrap_or_default().to_string_lossy();
        Name::new(&stem).context("the file's name is not a valid model name: give one with --name")
    }
}

/// Replaces the fit's row numbers by the file's line numbers.
fn at_line(path: &Path, readings: &[Reading], error: FitError) -> anyhow::Error {
    let file = path.display();
    let line = |row: usize| readings.get(row - 1).map_or(0, |reading| reading.line);
    match error {
        FitError::StrainNotPositive { row, value } => {
            anyhow!("{file}, line {}, strain: must be above 0 under pressure, not {value} m/m", line(row))
        }
        FitError::ElongationNotPositive { row, value_mm } => {
            anyhow!("{file}, line {}, elongation_mm: must be above 0 under pressure, not {value_mm}", line(row))
        }
        FitError::NotDetermined { .. } => anyhow!(
            "{file}: {error}. The chamber must become softer with the pressure: its strain must rise faster than the \
             pressure. Check the order of the columns, their units, and that nothing touched the whisker"
        ),
        FitError::NothingAboveZeroPressure
        | FitError::TooFewStrains { .. }
        | FitError::TooFewPressures { .. }
        | FitError::OneElongation => anyhow!("{file}: {error}"),
        FitError::Model(_) => anyhow!(
            "{file}: these readings lead to an impossible chamber: {error}. Check the units of the strains, and \
             --gauge-factor: a strain of 0.01 m/m is a reading of 22100 um/m at a gauge factor of 2.21"
        ),
    }
}

fn print_fit(name: &Name, geometry: &Geometry, fit: &Fit, out: &mut dyn Write) -> Result<()> {
    let calibration = &fit.calibration;
    writeln!(out, "Calibration {name}: k2(Q) = c + a exp(-b Q), elongation = G Q / (k2(Q) E)\n")?;
    writeln!(out, "{:<28} {:>11} {:>15}   95 % interval", "parameter", "value", "standard error")?;
    let line = |out: &mut dyn Write, name: &str, p: &Parameter| {
        writeln!(out, "{name:<28} {:>11.5} {:>15.5}   {:.5} to {:.5}", p.value, p.standard_error, p.low, p.high)
    };
    line(out, "c", &fit.c)?;
    line(out, "a", &fit.a)?;
    line(out, "b (1/MPa)", &fit.b_per_mpa)?;
    let by_shape_mm = geometry.elongation_gain_mm();
    match &fit.elongation_gain_mm {
        Some(gain) => {
            line(out, "G, elongation gain (mm)", gain)?;
            writeln!(out, "{:<28} {by_shape_mm:>11.5}", "  G by geometry (eq. 24)")?;
        }
        None => writeln!(out, "{:<28} {by_shape_mm:>11.5}   by geometry (eq. 24)", "G, elongation gain (mm)")?,
    }
    writeln!(out, "{:<28} {:>11.5}   given", "E, Young's modulus (MPa)", calibration.youngs_modulus_mpa)?;
    writeln!(out, "\nscatter of one strain reading: {:.2} %", 100.0 * fit.residual_sd)?;
    if let Some(sd) = fit.elongation_residual_sd {
        writeln!(out, "scatter of one elongation: {:.2} %", 100.0 * sd)?;
    }
    Ok(())
}

fn print_readings(readings: &[Reading], fit: &Fit, out: &mut dyn Write) -> Result<()> {
    writeln!(
        out,
        "\n{:>5} {:>15} {:>11}   {:>9}   {:>13}   {:>20}",
        "line", "pressure (MPa)", "strain", "k2", "residual (%)", "elongation res. (%)"
    )?;
    let cell = |value: Option<f64>, decimals: usize| value.map_or("-".to_owned(), |v| format!("{v:.decimals$}"));
    for (reading, residual) in readings.iter().zip(&fit.residuals) {
        let strain = cell(reading.row.axial_strain.map(|strain| strain.ratio()), 6);
        let (k2, off) = (cell(residual.k2, 4), cell(residual.k2_residual.map(|off| 100.0 * off), 2));
        let elongation_off = cell(residual.elongation_residual.map(|off| 100.0 * off), 2);
        let (line, pressure_mpa) = (reading.line, reading.row.pressure.mpa());
        writeln!(out, "{line:>5} {pressure_mpa:>15.4} {strain:>11}   {k2:>9}   {off:>13}   {elongation_off:>20}")?;
    }
    Ok(())
}

fn write_toml(path: &Path, from: &Path, file: &CalibrationFile) -> Result<()> {
    let body = toml::to_string(file).context("writing the calibration as TOML")?;
    let from = from.file_name().unwrap_or_default().to_string_lossy();
    let text = format!("# Whisker calibration, fitted to {from}: k2 = c + a exp(-b Q).\n{body}");
    if path.is_symlink() {
        anyhow::bail!("{} is a symbolic link: name the file itself", path.display());
    }
    std::fs::write(path, text).with_context(|| format!("writing {}", path.display()))
}
