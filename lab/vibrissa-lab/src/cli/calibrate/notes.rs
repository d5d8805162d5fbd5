//! Warnings about wide intervals, and notes about the shape.

use vibrissa_core::mechanics::{Advice, BenchFit, Formulation, Geometry, Kind, Quantity, Unknown};
use vibrissa_core::units::Megapascal;

use super::Reading;
use super::report::name_of;

/// Upper over lower end of an interval from which a parameter is not known well enough for setpoints.
const SPAN_MAX: f64 = 2.0;
/// Share of the chamber in the whisker's length that the paper kept.
const CHAMBER_SHARE: std::ops::RangeInclusive<f64> = 0.15..=0.25;
/// Least angle of the fibres to the whisker's axis, degrees: below it the chamber widens instead of stretching.
const FIBRE_ANGLE_MIN_DEG: f64 = 54.7;
/// Share of a scatter that counts as clearly less.
const CLEARLY_LESS: f64 = 0.8;
/// Error of a gauge's factor that matters, as a ratio.
const GAUGE_ERROR: f64 = 0.02;
/// Deflection up to which the model's straight line errs by less than 1 %, mm.
const STRAIGHT_MM: f64 = 3.0;

/// Warnings about the parameters that the readings leave open. `by_contacts` is the fit of a given E to the contacts.
pub(super) fn warnings(fit: &BenchFit, by_contacts: Option<&BenchFit>) -> Vec<String> {
    let mut warnings = Vec::new();
    for (unknown, parameter) in &fit.fitted {
        if *unknown == Unknown::GaugeOffset || parameter.span() <= SPAN_MAX {
            continue;
        }
        let advice = fit.advice(*unknown).map_or_else(String::new, |advice| advice_words(&advice));
        warnings.push(format!(
            "{} is between {:.4} and {:.4}, a factor of {:.1}: too few readings carry it{advice}",
            name_of(*unknown),
            parameter.low,
            parameter.high,
            parameter.span()
        ));
    }
    for (one, other, correlation) in fit.hardly_distinct() {
        warnings.push(format!(
            "the readings hardly tell {} and {} apart (correlation {correlation:.3})",
            name_of(one),
            name_of(other)
        ));
    }
    if let Some(modulus) = by_contacts.and_then(|fit| fit.parameter(Unknown::Modulus)) {
        let given_mpa = fit.calibration.youngs_modulus_mpa;
        if !(modulus.low..=modulus.high).contains(&given_mpa) {
            warnings.push(format!(
                "E is given as {given_mpa:.4} MPa, but the contacts show {:.4} ({:.4} to {:.4}) MPa: let the contacts fit it",
                modulus.value, modulus.low, modulus.high
            ));
        }
    }
    warnings
}

/// A warning if the contacts scatter clearly less about the other reading of the equations.
pub(super) fn formulation(fit: &BenchFit, other: &BenchFit) -> Option<String> {
    let scatter = |fit: &BenchFit| {
        let of_contacts =
            fit.scatters.iter().filter(|one| matches!(one.kind, Kind::ContactStrain | Kind::ContactForce));
        of_contacts.map(|one| one.sd).fold(0.0, f64::hypot)
    };
    let name = match other.model().formulation() {
        Formulation::Published => "published",
        Formulation::Consistent => "consistent",
    };
    let (here, there) = (scatter(fit), scatter(other));
    (there < CLEARLY_LESS * here).then(|| {
        format!(
            "the contacts scatter by {:.0} % less about the other reading of the equations: try --formulation {name}, here and \
             in the supervisor",
            100.0 * (1.0 - there / here)
        )
    })
}

/// A warning if a fitted gain of the gauge is clearly not 1.
pub(super) fn gauge_gain(fitted: &BenchFit) -> Option<String> {
    let gain = fitted.parameter(Unknown::GaugeGain)?;
    let differs = !(gain.low..=gain.high).contains(&1.0) && (gain.value - 1.0).abs() > GAUGE_ERROR;
    differs.then(|| {
        format!(
            "a gain of the gauge of {:.3} ({:.3} to {:.3}) explains the readings better: check the gauge factor, or try \
             --fit-gauge-gain",
            gain.value, gain.low, gain.high
        )
    })
}

fn advice_words(advice: &Advice) -> String {
    let Advice { reading, repetitions, span } = advice;
    let at = format!("{} MPa", reading.pressure.mpa());
    let place = reading.contact().map_or_else(String::new, |contact| {
        format!(" of contacts at {:.0} mm and {} mm of deflection", contact.distance_mm(0.0), contact.deflection_mm)
    });
    let what = match reading.quantity {
        Quantity::AxialStrain => "strains without contact",
        Quantity::Elongation => "elongations",
        Quantity::ContactStrain(_) => "strains",
        Quantity::ContactForce(_) => "forces",
    };
    format!("; {repetitions} more {what}{place} at {at} would narrow it to a factor of {span:.1}")
}

/// Conditions of the model on shape and bench.
pub(super) fn notes(geometry: &Geometry, fit: &BenchFit, table: &[Reading], pitch_mm: Option<f64>) -> Vec<String> {
    let mut notes = Vec::new();
    let mut lengths_mm: Vec<f64> = table.iter().filter_map(|one| Some(one.length?.mm())).collect();
    lengths_mm.sort_by(f64::total_cmp);
    lengths_mm.dedup();
    let chamber_mm = geometry.l_mm;
    for length_mm in &lengths_mm {
        let share = chamber_mm / length_mm;
        let verdict = if CHAMBER_SHARE.contains(&share) { "within" } else { "outside of" };
        notes.push(format!(
            "the chamber ends at {chamber_mm} mm, {:.0} % of a length of {length_mm} mm: {verdict} the 15 to 25 % for which \
             the model was examined",
            100.0 * share
        ));
    }
    if lengths_mm.is_empty() {
        notes.push("the chamber's share of the length is not checked: add length_mm, or give --length-mm".to_owned());
    }
    let stretched_mm = chamber_mm + fit.model().elongation(Megapascal::EXAMINED_MAX).mm();
    notes.push(format!(
        "the model is valid while damage and contacts lie beyond the chamber: {chamber_mm} mm, and {stretched_mm:.1} mm at \
         0.2 MPa"
    ));
    notes.push(match pitch_mm {
        Some(pitch_mm) => fibre_note(geometry, pitch_mm),
        None => "the fibres' angle is not checked: give --fibre-pitch-mm".to_owned(),
    });
    let [large, small] = geometry.thin_wall_errors().map(|share| 100.0 * share);
    notes.push(format!(
        "the thin wall of eq. 6 leaves out {large:.1} % (large end) to {small:.1} % (small end) of the wall's stiffness; a \
         fitted k2 contains it"
    ));
    let deepest_mm = table.iter().filter_map(|one| one.reading.contact()).map(|contact| contact.deflection_mm);
    let deepest_mm = deepest_mm.fold(0.0, f64::max);
    if deepest_mm > STRAIGHT_MM {
        notes.push(format!(
            "deflections reach {deepest_mm} mm: above {STRAIGHT_MM} mm strain grows less than in proportion (3 % less at 6 mm \
             and a ratio of 0.45)"
        ));
    }
    notes
}

/// Angle of the fibres to the axis, from the pitch of their helix.
fn fibre_note(geometry: &Geometry, pitch_mm: f64) -> String {
    let angle_deg = |diameter_mm: f64| (std::f64::consts::PI * diameter_mm / pitch_mm).atan().to_degrees();
    let (large_deg, small_deg) = (angle_deg(geometry.d2_mid_large_mm), angle_deg(geometry.d2_mid_small_mm));
    let verdict = if small_deg > FIBRE_ANGLE_MIN_DEG {
        "above 54.7 degrees, so the chamber stretches along its axis"
    } else {
        "not above 54.7 degrees, so the chamber widens, and the gauge reads more than eq. 32 says"
    };
    format!("the fibres lie at {small_deg:.1} to {large_deg:.1} degrees to the axis: {verdict}")
}

#[cfg(test)]
mod tests {
    use vibrissa_core::mechanics::{BenchContact, BenchReading, Calibration, Gauge, Given, Model, Place, fit_bench};
    use vibrissa_core::units::Millimetre;

    use super::*;

    /// Readings of a true whisker whose errors alternate by 2 %.
    fn readings(truth: &Model) -> Vec<BenchReading> {
        let mut readings = Vec::new();
        for (at, pressure_mpa) in [0.0, 0.01, 0.05, 0.1, 0.15, 0.2].into_iter().enumerate() {
            for (place, contact_mm) in [32.0, 50.0, 70.0].into_iter().enumerate() {
                let contact = BenchContact {
                    place: Place::Distance(Millimetre::new(contact_mm).unwrap()),
                    place_sd: 0.0,
                    deflection_mm: 2.0,
                    deflection_sd_mm: 0.0,
                };
                let off = if (at + place) % 2 == 0 { 1.02 } else { 0.98 };
                for quantity in
                    [Quantity::AxialStrain, Quantity::ContactStrain(contact), Quantity::ContactForce(contact)]
                {
                    let pressure = Megapascal::new(pressure_mpa).unwrap();
                    let blank = BenchReading { pressure, pressure_sd_mpa: 0.0, quantity, value: 0.0, sd: None };
                    readings.push(BenchReading { value: off * blank.modelled(truth, Gauge::TRUE), ..blank });
                }
            }
        }
        readings
    }

    #[test]
    fn property_the_reading_of_the_equations_that_fits_worse_is_warned_of() {
        let geometry = Geometry::nguyen_2021();
        let fit = |formulation, readings: &[BenchReading]| {
            let given = Given { geometry, formulation, youngs_modulus_mpa: None, fits_gauge_gain: false };
            fit_bench(&given, readings).unwrap()
        };
        for (truth, other) in
            [(Formulation::Published, Formulation::Consistent), (Formulation::Consistent, Formulation::Published)]
        {
            let readings = readings(&Model::new(geometry, Calibration::nguyen_2021(), truth).unwrap());
            let (right, wrong) = (fit(truth, &readings), fit(other, &readings));
            assert_eq!(formulation(&right, &wrong), None);
            let warning = formulation(&wrong, &right).unwrap();
            assert_eq!(warning.contains("--formulation published"), truth == Formulation::Published, "{warning}");
        }
    }

    #[test]
    fn property_a_wrong_gauge_factor_is_warned_of() {
        let truth = Model::nguyen_2021(Formulation::Published);
        let given = Given {
            geometry: Geometry::nguyen_2021(),
            formulation: Formulation::Published,
            youngs_modulus_mpa: None,
            fits_gauge_gain: true,
        };
        let warning = |factor: f64| {
            let mut readings = readings(&truth);
            for reading in &mut readings {
                if matches!(reading.quantity, Quantity::AxialStrain | Quantity::ContactStrain(_)) {
                    reading.value *= factor;
                }
            }
            gauge_gain(&fit_bench(&given, &readings).unwrap())
        };
        assert_eq!(warning(1.0), None);
        assert!(warning(1.2).unwrap().contains("a gain of the gauge of 1."));
    }

    #[test]
    fn a_shape_outside_of_the_examined_one_is_noted() {
        let geometry = Geometry::nguyen_2021();
        assert!(fibre_note(&geometry, 3.0).contains("above 54.7 degrees, so the chamber stretches"));
        assert!(fibre_note(&geometry, 40.0).contains("not above 54.7 degrees"));
        let truth = Model::nguyen_2021(Formulation::Published);
        let given =
            Given { geometry, formulation: Formulation::Published, youngs_modulus_mpa: None, fits_gauge_gain: false };
        let readings = readings(&truth);
        let fit = fit_bench(&given, &readings).unwrap();
        let table: Vec<_> = [52.0, 70.0]
            .map(|length_mm| Reading { line: 2, reading: readings[1], length: Millimetre::new(length_mm).ok() })
            .into();
        let notes = notes(&geometry, &fit, &table, None);
        assert!(notes[0].contains("29 % of a length of 52 mm: outside of the 15 to 25 %"), "{notes:?}");
        assert!(notes[1].contains("21 % of a length of 70 mm: within"), "{notes:?}");
    }
}
