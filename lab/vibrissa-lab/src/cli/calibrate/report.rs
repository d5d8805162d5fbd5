//! The report of a fit, and the comment of the written file.

use std::io::Write;
use std::path::Path;

use anyhow::Result;
use vibrissa_core::mechanics::{
    BenchFit, BenchReading, Geometry, Kind, Parameter, Quantity, Scatter, UNKNOWNS, Unknown,
};
use vibrissa_core::units::Megapascal;
use vibrissa_protocol::Name;

use super::{Modulus, Reading};

/// A fit with the table and the shape that it belongs to.
pub(super) struct Report<'a> {
    pub(super) name: &'a Name,
    pub(super) table: &'a [Reading],
    pub(super) fit: &'a BenchFit,
    pub(super) modulus: Modulus,
    pub(super) geometry: &'a Geometry,
}

/// Name of an unknown in the report.
pub(super) fn name_of(unknown: Unknown) -> &'static str {
    match unknown {
        Unknown::C => "c",
        Unknown::A => "a",
        Unknown::B => "b (1/MPa)",
        Unknown::Modulus => "E, Young's modulus (MPa)",
        Unknown::ElongationGain => "G, elongation gain (mm)",
        Unknown::GaugeGain => "gain of the gauge",
        Unknown::GaugeOffset => "offset of the gauge (m/m)",
    }
}

impl Report<'_> {
    pub(super) fn print(&self, out: &mut dyn Write) -> Result<()> {
        let name = self.name;
        writeln!(out, "Calibration {name}: k2(Q) = c + a exp(-b Q), elongation = G Q / (k2(Q) E)\n")?;
        writeln!(out, "{:<28} {:>11} {:>15}   95 % interval", "parameter", "value", "standard error")?;
        for unknown in UNKNOWNS {
            match self.fit.parameter(unknown) {
                Some(Parameter { value, standard_error, low, high }) => writeln!(
                    out,
                    "{:<28} {value:>11.5} {standard_error:>15.5}   {low:.5} to {high:.5}",
                    name_of(unknown)
                )?,
                None => self.print_given(unknown, out)?,
            }
        }
        if self.fit.parameter(Unknown::ElongationGain).is_some() {
            writeln!(out, "{:<28} {:>11.5}", "  G by geometry (eq. 24)", self.geometry.elongation_gain_mm())?;
        }
        writeln!(out)?;
        for scatter in &self.fit.scatters {
            print_scatter(scatter, out)?;
        }
        self.print_certainty(out)
    }

    fn print_given(&self, unknown: Unknown, out: &mut dyn Write) -> Result<()> {
        let calibration = &self.fit.calibration;
        let (value, why) = match unknown {
            Unknown::Modulus => (calibration.youngs_modulus_mpa, modulus_words(self.modulus)),
            Unknown::ElongationGain => (calibration.elongation_gain_mm, "by geometry (eq. 24)".to_owned()),
            Unknown::GaugeGain => (self.fit.gauge.gain, "given: the gauge's factor is taken as true".to_owned()),
            Unknown::GaugeOffset => (self.fit.gauge.offset, "given: no repeated strains at zero pressure".to_owned()),
            Unknown::C => (calibration.c, "given".to_owned()),
            Unknown::A => (calibration.a, "given".to_owned()),
            Unknown::B => (calibration.b_per_mpa, "given".to_owned()),
        };
        writeln!(out, "{:<28} {value:>11.5}   {why}", name_of(unknown))?;
        Ok(())
    }

    fn print_certainty(&self, out: &mut dyn Write) -> Result<()> {
        writeln!(out, "condition number of the fitted parameters: {:.0}", self.fit.condition())?;
        if self.modulus != Modulus::Fitted {
            writeln!(
                out,
                "E is not fitted: {}. Another E scales c and a inversely, and moves setpoints and lengths.",
                if self.table.iter().any(|one| one.reading.contact().is_some()) {
                    "it was given"
                } else {
                    "strains and elongations without contact determine only its product with k2"
                }
            )?;
        }
        let at_rule = self.fit.k2(Megapascal::known(0.002));
        writeln!(
            out,
            "k2 at 0.002 MPa: {:.4} ({:.4} to {:.4}); 1 by the paper's rule\n",
            at_rule.value, at_rule.low, at_rule.high
        )?;
        Ok(())
    }

    /// One line for each reading.
    pub(super) fn print_readings(&self, out: &mut dyn Write) -> Result<()> {
        writeln!(
            out,
            "\n{:>5} {:>15} {:<11} {:>10} {:>16}   {:>9}   {:>13}",
            "line", "pressure (MPa)", "reading", "place (mm)", "value", "k2", "residual (%)"
        )?;
        let cell = |value: Option<f64>, decimals: usize| value.map_or("-".to_owned(), |v| format!("{v:.decimals$}"));
        for (Reading { line, reading, .. }, residual) in self.table.iter().zip(&self.fit.residuals) {
            let value = format!("{:.6} {}", reading.value, unit(&reading.quantity));
            let place_mm = reading
                .contact()
                .map(|contact| contact.distance_mm(self.fit.model().elongation(reading.pressure).mm()));
            let (k2, residual) = (self.k2(reading), residual.map(|residual| 100.0 * residual));
            writeln!(
                out,
                "{line:>5} {:>15.4} {:<11} {:>10} {value:>16}   {:>9}   {:>13}",
                reading.pressure.mpa(),
                words(&reading.quantity),
                cell(place_mm, 2),
                cell(k2, 4),
                cell(residual, 2),
            )?;
        }
        Ok(())
    }

    /// k2 of a strain without contact (eq. 33).
    fn k2(&self, reading: &BenchReading) -> Option<f64> {
        let gauge = self.fit.gauge;
        let strain = vibrissa_core::units::Strain::new((reading.value - gauge.offset) / gauge.gain).ok()?;
        let e2_mpa = self.geometry.youngs_modulus_from_axial_strain(reading.pressure, strain)?;
        (reading.kind() == Some(Kind::Axial)).then_some(e2_mpa / self.fit.calibration.youngs_modulus_mpa)
    }
}

fn modulus_words(modulus: Modulus) -> String {
    match modulus {
        Modulus::Fitted => "fitted".to_owned(),
        Modulus::Stated => "given".to_owned(),
        Modulus::Assumed => "given: the paper's rubber, as the file has no contacts".to_owned(),
        Modulus::PaperRule(Some(error)) => {
            format!("given by the paper's rule, E2 at 0.002 MPa (standard error {error:.5})")
        }
        Modulus::PaperRule(None) => "given by the paper's rule, E2 at 0.002 MPa (one strain)".to_owned(),
    }
}

fn words(quantity: &Quantity) -> &'static str {
    match quantity {
        Quantity::AxialStrain => "strain",
        Quantity::Elongation => "elongation",
        Quantity::ContactStrain(_) => "contact",
        Quantity::ContactForce(_) => "force",
    }
}

fn unit(quantity: &Quantity) -> &'static str {
    match quantity {
        Quantity::AxialStrain | Quantity::ContactStrain(_) => "m/m",
        Quantity::Elongation => "mm",
        Quantity::ContactForce(_) => "N",
    }
}

fn print_scatter(scatter: &Scatter, out: &mut dyn Write) -> Result<()> {
    let what = match scatter.kind {
        Kind::Zero => "one strain at zero pressure",
        Kind::Axial => "one strain reading",
        Kind::Elongation => "one elongation",
        Kind::ContactStrain => "one strain of a contact",
        Kind::ContactForce => "one force of a contact",
    };
    let (sd, count) = (scatter.sd, scatter.readings);
    match (scatter.stated, scatter.kind) {
        (true, _) => writeln!(out, "scatter of {what}: {sd:.2} times as stated ({count} readings)")?,
        (false, Kind::Zero) => writeln!(out, "scatter of {what}: {sd:.2e} m/m ({count} readings)")?,
        (false, Kind::Axial | Kind::Elongation | Kind::ContactStrain | Kind::ContactForce) => {
            writeln!(out, "scatter of {what}: {:.2} % ({count} readings)", 100.0 * sd)?;
        }
    }
    Ok(())
}

/// Comment at the top of the written file: fitted and given parameters, and the warnings.
pub(super) fn comment(from: &Path, fit: &BenchFit, modulus: Modulus, warnings: &[String]) -> String {
    let from = from.file_name().unwrap_or_default().to_string_lossy();
    let mut text = format!("# Whisker calibration, fitted to {from}: k2 = c + a exp(-b Q).\n");
    for (unknown, parameter) in &fit.fitted {
        let Parameter { value, low, high, .. } = parameter;
        text += &format!("# fitted: {} {value:.5}, 95 % interval {low:.5} to {high:.5}\n", name_of(*unknown));
    }
    if modulus != Modulus::Fitted {
        let value = fit.calibration.youngs_modulus_mpa;
        text += &format!("# {} {value:.5}: {}\n", name_of(Unknown::Modulus), modulus_words(modulus));
    }
    for warning in warnings {
        text += &format!("# warning: {warning}\n");
    }
    text
}
