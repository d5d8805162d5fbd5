//! Columns of a bench's table, and the readings of one row.

use anyhow::{Context, Result, anyhow, bail, ensure};
use csv::StringRecord;
use vibrissa_core::mechanics::{BenchContact, BenchReading, Place, Quantity};
use vibrissa_core::units::{ContactRatio, Megapascal, Millimetre, Strain};

use super::Bench;

/// The columns, for `--help`.
pub(crate) const HELP: &str = "\
The CSV file has a header. Columns, in any order:
  pressure_mpa              gauge pressure of the chamber
  strain                    strain of the gauge, m/m; or instead one of
  strain_reading_um_per_m   instrument reading in um/m, which is divided by the gauge factor
  strain_reading_mm_per_m   instrument reading in mm/m, likewise
  elongation_mm             elongation of the chamber
  contact_mm                place of a contact, from the base; or instead
  contact_ratio             place of a contact, as a share of the whisker's length
  deflection_mm             deflection at the contact
  force_n                   force at the contact
  length_mm                 length of the whisker
A row without a place is a reading without contact, and at zero pressure its strain is the gauge's offset. In a row with
a place, strain is the change since before the contact. Standard deviations are optional: pressure_sd_mpa, strain_sd (in
the unit of the strain's column), elongation_sd_mm, contact_sd (in the unit of the place), deflection_sd_mm, force_sd_n.
Columns are separated by commas, and numbers have a decimal point. An empty cell means no reading. Lines that start with
# are ignored. 100 kPa are 0.1 MPa.";

const PRESSURE: &str = "pressure_mpa";
const PRESSURE_SD: &str = "pressure_sd_mpa";
const STRAIN_SD: &str = "strain_sd";
const ELONGATION: &str = "elongation_mm";
const ELONGATION_SD: &str = "elongation_sd_mm";
const CONTACT_MM: &str = "contact_mm";
const CONTACT_RATIO: &str = "contact_ratio";
const CONTACT_SD: &str = "contact_sd";
const DEFLECTION: &str = "deflection_mm";
const DEFLECTION_SD: &str = "deflection_sd_mm";
const FORCE: &str = "force_n";
const FORCE_SD: &str = "force_sd_n";
const LENGTH: &str = "length_mm";
const OTHERS: [&str; 13] = [
    PRESSURE,
    PRESSURE_SD,
    STRAIN_SD,
    ELONGATION,
    ELONGATION_SD,
    CONTACT_MM,
    CONTACT_RATIO,
    CONTACT_SD,
    DEFLECTION,
    DEFLECTION_SD,
    FORCE,
    FORCE_SD,
    LENGTH,
];
/// A column of standard deviations, and the columns one of which it belongs to.
const DEVIATIONS: [(&str, &[&str]); 4] = [
    (ELONGATION_SD, &[ELONGATION]),
    (CONTACT_SD, &[CONTACT_MM, CONTACT_RATIO]),
    (DEFLECTION_SD, &[DEFLECTION]),
    (FORCE_SD, &[FORCE]),
];
/// Strain columns: name, one unit in m/m, and whether the reading still contains the gauge factor.
const STRAINS: [(&str, f64, bool); 3] =
    [("strain", 1.0, false), ("strain_reading_um_per_m", 1e-6, true), ("strain_reading_mm_per_m", 1e-3, true)];

/// The header, checked.
pub(super) struct Columns {
    names: Vec<String>,
    /// Name of the strain's column, and the factor from its numbers to m/m.
    strain: Option<(&'static str, f64)>,
}

impl Columns {
    pub(super) fn find(header: &StringRecord, gauge_factor: f64) -> Result<Self> {
        let has = |name: &str| header.iter().any(|column| column == name);
        for column in header.iter().filter(|column| !column.is_empty()) {
            let known = OTHERS.contains(&column) || STRAINS.iter().any(|(name, ..)| *name == column);
            let hint = if column.to_ascii_lowercase().contains("kpa") {
                format!("; write pressures in MPa into {PRESSURE}: 100 kPa are 0.1 MPa")
            } else {
                String::new()
            };
            ensure!(known, "unknown column {column:?}; known are {}, {}{hint}", strain_names(), OTHERS.join(", "));
            ensure!(header.iter().filter(|other| *other == column).count() == 1, "column {column} appears twice");
        }
        let found: Vec<_> = STRAINS.iter().filter(|(name, ..)| has(name)).collect();
        let strain = match found[..] {
            [] if has(ELONGATION) || has(FORCE) => None,
            [&(name, unit, with_factor)] => Some((name, if with_factor { unit / gauge_factor } else { unit })),
            _ => bail!("exactly one of the columns {} is required", strain_names()),
        };
        ensure!(has(PRESSURE), "missing column {PRESSURE}");
        ensure!(
            !(has(CONTACT_MM) && has(CONTACT_RATIO)),
            "the columns {CONTACT_MM} and {CONTACT_RATIO} exclude each other"
        );
        ensure!(strain.is_some() || !has(STRAIN_SD), "column {STRAIN_SD} needs a column of strains");
        for (deviation, of) in DEVIATIONS {
            ensure!(
                !has(deviation) || of.iter().any(|name| has(name)),
                "column {deviation} needs the column {}",
                of[0]
            );
        }
        Ok(Self { names: header.iter().map(str::to_owned).collect(), strain })
    }

    /// Length of the row's whisker, and the readings of the row.
    pub(super) fn row(&self, cells: &StringRecord, bench: &Bench) -> Result<(Option<Millimetre>, Vec<BenchReading>)> {
        let number = |name: &'static str| self.number(cells, name);
        let pressure = number(PRESSURE)?.with_context(|| format!("column {PRESSURE}: empty cell"))?;
        let pressure = megapascal(pressure).with_context(|| format!("column {PRESSURE}"))?;
        let pressure_sd_mpa = self.deviation(cells, PRESSURE_SD)?.unwrap_or(0.0);
        let length = self.length(cells, bench)?;
        let contact = self.contact(cells, length, pressure)?;
        let mut readings = Vec::new();
        let mut push = |quantity, value, sd| {
            readings.push(BenchReading { pressure, pressure_sd_mpa, quantity, value, sd });
        };
        if let Some((name, factor)) = self.strain
            && let Some(strain) = number(name)?
        {
            let strain = Strain::new(strain * factor).with_context(|| format!("column {name}"))?;
            let sd = self.deviation(cells, STRAIN_SD)?.map(|sd| sd * factor);
            push(contact.map_or(Quantity::AxialStrain, Quantity::ContactStrain), strain.ratio(), sd);
        }
        if let Some(elongation) = number(ELONGATION)? {
            let elongation = Millimetre::new(elongation).with_context(|| format!("column {ELONGATION}"))?;
            push(Quantity::Elongation, elongation.mm(), self.deviation(cells, ELONGATION_SD)?);
        }
        match (number(FORCE)?, contact) {
            (Some(force_n), Some(contact)) => {
                ensure!(force_n >= 0.0, "column {FORCE}: must not be below 0 N, not {force_n}");
                push(Quantity::ContactForce(contact), force_n, self.deviation(cells, FORCE_SD)?);
            }
            (Some(_), None) => bail!("column {FORCE}: a contact needs its place: fill {CONTACT_MM} or {CONTACT_RATIO}"),
            (None, _) => {}
        }
        let is_read = readings.iter().any(|reading| reading.contact().is_some());
        ensure!(contact.is_none() || is_read, "a contact without a reading: fill the strain or {FORCE}");
        Ok((length, readings))
    }

    fn length(&self, cells: &StringRecord, bench: &Bench) -> Result<Option<Millimetre>> {
        let Some(length_mm) = self.number(cells, LENGTH)? else { return Ok(bench.length) };
        let length = Millimetre::new(length_mm).with_context(|| format!("column {LENGTH}"))?;
        ensure!(
            length_mm > bench.chamber_end_mm,
            "column {LENGTH}: a whisker of {length_mm} mm is cut into its chamber, which ends at {} mm",
            bench.chamber_end_mm
        );
        Ok(Some(length))
    }

    fn contact(
        &self,
        cells: &StringRecord,
        length: Option<Millimetre>,
        pressure: Megapascal,
    ) -> Result<Option<BenchContact>> {
        let deflection_mm = self.number(cells, DEFLECTION)?;
        let place = if let Some(contact_mm) = self.number(cells, CONTACT_MM)? {
            let beyond = length.filter(|length| pressure == Megapascal::ZERO && contact_mm > length.mm());
            if let Some(length) = beyond {
                bail!("column {CONTACT_MM}: {contact_mm} mm is beyond the tip of a whisker of {} mm", length.mm());
            }
            Place::Distance(Millimetre::new(contact_mm).with_context(|| format!("column {CONTACT_MM}"))?)
        } else if let Some(ratio) = self.number(cells, CONTACT_RATIO)? {
            let length = length.with_context(|| {
                format!(
                    "column {CONTACT_RATIO}: a ratio needs the whisker's length: fill {LENGTH}, or give --length-mm"
                )
            })?;
            Place::Ratio(ContactRatio::new(ratio).with_context(|| format!("column {CONTACT_RATIO}"))?, length)
        } else {
            ensure!(
                deflection_mm.is_none(),
                "column {DEFLECTION}: a contact needs its place: fill {CONTACT_MM} or {CONTACT_RATIO}"
            );
            return Ok(None);
        };
        let deflection_mm =
            deflection_mm.with_context(|| format!("column {DEFLECTION}: empty cell, but the row has a contact"))?;
        let deflection = Millimetre::new(deflection_mm).with_context(|| format!("column {DEFLECTION}"))?;
        Ok(Some(BenchContact {
            place,
            place_sd: self.deviation(cells, CONTACT_SD)?.unwrap_or(0.0),
            deflection_mm: deflection.mm(),
            deflection_sd_mm: self.deviation(cells, DEFLECTION_SD)?.unwrap_or(0.0),
        }))
    }

    /// A standard deviation. An empty cell means that it is not stated.
    fn deviation(&self, cells: &StringRecord, name: &'static str) -> Result<Option<f64>> {
        let sd = self.number(cells, name)?;
        if let Some(sd) = sd {
            ensure!(sd.is_finite() && sd > 0.0, "column {name}: a standard deviation must be above 0, not {sd}");
        }
        Ok(sd)
    }

    /// The number in a cell; `None` if the cell is empty, or the column is missing.
    fn number(&self, cells: &StringRecord, name: &'static str) -> Result<Option<f64>> {
        let column = self.names.iter().position(|column| column == name);
        let text = column.and_then(|column| cells.get(column)).unwrap_or_default();
        if text.is_empty() {
            return Ok(None);
        }
        let number: Option<f64> = text.parse().ok().filter(|number: &f64| number.is_finite());
        let number = number.with_context(|| {
            let hint = match text {
                _ if text.contains(',') => ": write it with a decimal point, such as 0.05",
                _ if text.contains(char::is_whitespace) => ": write it without spaces, such as 6765",
                _ if text.starts_with('#') => ", but an error of the spreadsheet: leave the cell empty",
                _ => "",
            };
            // A no-break space looks like a space.
            let shown = text.replace(char::is_whitespace, " ");
            format!("column {name}: {shown:?} is not a number{hint}")
        })?;
        Ok(Some(number))
    }
}

/// A pressure. Numbers of the size of kilopascals get a hint.
fn megapascal(value: f64) -> Result<Megapascal> {
    Megapascal::new(value).map_err(|problem| {
        let is_kpa = (1.0..=1000.0).contains(&value);
        let hint = if is_kpa { format!("; if it is in kPa, write {} MPa", value / 1000.0) } else { String::new() };
        anyhow!("{problem}{hint}")
    })
}

fn strain_names() -> String {
    STRAINS.map(|(name, ..)| name).join(", ")
}
