//! `vibrissa-lab calibrate` and `validate` on readings of a bench with contacts.

use std::path::Path;

use vibrissa_core::mechanics::{Calibration, Formulation, Model};

use crate::program::{err, out, vibrissa};

const GOLDEN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/golden/bench.csv");
const EXAMPLE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/bench-example.csv");
/// Strains at four pressures, with a scatter of some percent.
const FOUR: &str = "pressure_mpa,strain\n0.02,0.0067\n0.06,0.0278\n0.12,0.0738\n0.2,0.149\n";
/// The built-in calibration.
const PAPER: &str = "name = \"paper\"\nc = 0.46932569\na = 1.62335972\nb_per_mpa = 9.39766614\n\
                     youngs_modulus_mpa = 1.1134477\nelongation_gain_mm = 8.6766199\n";

fn written(folder: &Path, name: &str) -> (String, Model) {
    let path = folder.join(name);
    let model = vibrissa_edge::calibration_file::load(&path, Formulation::Published).unwrap().1;
    (std::fs::read_to_string(path).unwrap(), model)
}

#[test]
fn golden_calibrate_finds_the_whisker_of_an_independent_bench() {
    let folder = tempfile::tempdir().unwrap();
    let report = out(&vibrissa(&["calibrate", GOLDEN, "--out", "own.toml"], folder.path()));
    let (text, model) = written(folder.path(), "own.toml");
    let Calibration { c, a, b_per_mpa, youngs_modulus_mpa, elongation_gain_mm } = *model.calibration();
    for (what, found, expected) in [
        ("c", c, 0.5),
        ("a", a, 1.2),
        ("b", b_per_mpa, 11.0),
        ("E", youngs_modulus_mpa, 0.82),
        ("G", elongation_gain_mm, 8.3),
    ] {
        assert!((found / expected - 1.0).abs() < 1e-5, "{what}: {found} instead of {expected}\n{report}");
    }
    assert!(text.contains("# fitted: E, Young's modulus (MPa) 0.82000"), "{text}");
    assert!(!report.contains("warning"), "{report}");
}

#[test]
fn regress_four_readings_are_fitted_with_a_warning_in_report_and_file() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("four.csv"), FOUR).unwrap();
    let report = out(&vibrissa(&["calibrate", "four.csv", "--out", "four.toml"], folder.path()));
    let (text, _) = written(folder.path(), "four.toml");
    for shown in [&report, &text] {
        let warning = shown.lines().find(|line| line.contains("warning: b (1/MPa) is between")).unwrap();
        assert!(warning.contains("too few readings carry it; 5 more strains without contact at"), "{warning}");
    }
    assert!(report.contains("given: the paper's rubber, as the file has no contacts"), "{report}");
    assert!(report.contains("E is not fitted: strains and elongations without contact determine only"), "{report}");
    assert!(text.contains("# E, Young's modulus (MPa) 1.11345: given"), "{text}");
}

#[test]
fn the_example_bench_fits_its_own_calibration_and_not_that_of_the_paper() {
    let folder = tempfile::tempdir().unwrap();
    let report = out(&vibrissa(&["calibrate", EXAMPLE, "--out", "own.toml", "--fibre-pitch-mm", "3"], folder.path()));
    for note in [
        "the chamber ends at 15 mm, 21 % of a length of 70 mm: within",
        "the fibres lie at 86.0 to 86.3 degrees to the axis: above 54.7",
    ] {
        assert!(report.contains(note), "{report}");
    }
    let validate = |calibration: &str| {
        vibrissa(&["validate", EXAMPLE, "--calibration", calibration, "--svg", "figures"], folder.path())
    };
    let fits = validate("own.toml");
    let table = out(&fits);
    assert!(table.contains("The calibration fits"), "{table}");
    assert!(
        table.contains("Compensation error (eq. 35)") && table.contains("Strain per deflection by length"),
        "{table}"
    );
    let figures =
        ["fig-6-pressure", "fig-7-normal-mode", "fig-8-pressure", "fig-9-lengths", "fig-10-compensation-error"];
    for name in figures.into_iter().chain(["force"]) {
        let svg = std::fs::read_to_string(folder.path().join(format!("figures/{name}.svg"))).unwrap();
        assert!(svg.contains("measured") && svg.contains("computed") && svg.trim_end().ends_with("</svg>"), "{name}");
    }
    std::fs::write(folder.path().join("paper.toml"), PAPER).unwrap();
    let differs = validate("paper.toml");
    assert_eq!(differs.status.code(), Some(3), "{}", err(&differs));
    let table = String::from_utf8(differs.stdout).unwrap();
    let misfits = table.split_once("The calibration does not fit:").unwrap().1;
    assert!(misfits.contains("force at ratio 0.45 is") && misfits.contains("% below the model"), "{misfits}");
}

#[test]
fn the_papers_rule_gives_e_and_contacts_contradict_it() {
    let folder = tempfile::tempdir().unwrap();
    let report = out(&vibrissa(&["calibrate", EXAMPLE, "--paper-rule"], folder.path()));
    assert!(report.contains("given by the paper's rule, E2 at 0.002 MPa (standard error"), "{report}");
    let warning = report.lines().find(|line| line.contains("let the contacts fit it")).unwrap();
    assert!(warning.contains("but the contacts show 0.8"), "{warning}");
    std::fs::write(folder.path().join("four.csv"), FOUR).unwrap();
    let refused = vibrissa(&["calibrate", "four.csv", "--paper-rule"], folder.path());
    assert_eq!(refused.status.code(), Some(1));
    assert!(err(&refused).contains("--paper-rule needs strains without contact at 0.002 MPa"), "{}", err(&refused));
}

#[test]
fn property_bad_contacts_are_refused_with_line_and_column() {
    let folder = tempfile::tempdir().unwrap();
    let header = "pressure_mpa,strain,contact_mm,deflection_mm,force_n";
    for (row, expected) in [
        ("0.1,0.01,40,,1", "line 2: column deflection_mm: empty cell, but the row has a contact"),
        ("0.1,0.01,40,2,abc", "line 2: column force_n: \"abc\" is not a number"),
        ("0.1,0.01,,2,1", "line 2: column deflection_mm: a contact needs its place"),
        ("0.1,-0.01,40,2,1", "the strains of the contacts are below 0: the gauge is reversed"),
    ] {
        std::fs::write(folder.path().join("bad.csv"), format!("{header}\n{row}\n")).unwrap();
        for command in ["calibrate", "validate"] {
            std::fs::write(folder.path().join("paper.toml"), PAPER).unwrap();
            let arguments = if command == "validate" { vec!["--calibration", "paper.toml"] } else { Vec::new() };
            let refused = vibrissa(&[&[command, "bad.csv"], arguments.as_slice()].concat(), folder.path());
            if command == "calibrate" || expected.starts_with("line") {
                assert_eq!(refused.status.code(), Some(1), "{row}");
                assert!(err(&refused).contains(expected), "{} instead of {expected}", err(&refused));
            }
        }
    }
    std::fs::write(folder.path().join("near.csv"), format!("{header}\n0.2,0.01,16,2,1\n")).unwrap();
    let refused = vibrissa(&["validate", "near.csv", "--calibration", "paper.toml"], folder.path());
    assert!(err(&refused).contains("near.csv, line 2: the contact at 16 mm lies on the chamber"), "{}", err(&refused));
}
