//! `vibrissa-lab paper`, `solve` and `calibrate` on the command line.

use serde_json::Value;

use crate::program::{err, out, vibrissa};

#[test]
fn paper_table_and_figures() {
    let folder = tempfile::tempdir().unwrap();
    let table = out(&vibrissa(&["paper", "--svg", "figures"], folder.path()));
    let line = |part: &str, number: &str| table.lines().any(|line| line.contains(part) && line.contains(number));
    assert!(line("case 1", "0.0480") && line("case 1", "1.5033") && line("case 1", "20.385"), "{table}");
    assert!(line("case 2", "0.1920") && line("case 2", "0.7365") && line("case 2", "36.1837"), "{table}");
    assert!(line("k2 at 0.002 MPa", "contradicted") && line("k2 at the setpoint of case 1", "reproduced"), "{table}");
    for name in ["fig-7-normal-mode", "fig-8-pressure", "fig-9-compensation"] {
        let svg = std::fs::read_to_string(folder.path().join(format!("figures/{name}.svg"))).unwrap();
        assert!(svg.contains("strain") && svg.trim_end().ends_with("</svg>"), "{name}");
    }
}

#[test]
fn paper_solve_answers_case_1() {
    let folder = tempfile::tempdir().unwrap();
    let answer = out(&vibrissa(&["solve", "--target-mm", "70", "--length-mm", "65", "--json"], folder.path()));
    let answer: Value = serde_json::from_str(&answer).unwrap();
    assert_eq!(answer["solution"], "IN_RANGE");
    assert!((answer["setpoint_mpa"].as_f64().unwrap() - 0.048).abs() < 1e-9);
    assert_eq!(answer["by_contact_ratio"].as_array().unwrap().len(), 12);
}

#[test]
fn property_solve_out_of_range_is_an_answer_and_a_cut_into_the_chamber_is_not() {
    let folder = tempfile::tempdir().unwrap();
    let solve = |length_mm: &str| vibrissa(&["solve", "--target-mm", "70", "--length-mm", length_mm], folder.path());
    for (length_mm, statement) in [("55", "55 mm stays more sensitive"), ("82", "82 mm stays less sensitive")] {
        let answer = solve(length_mm);
        assert_eq!(answer.status.code(), Some(3), "{}", err(&answer));
        let text = String::from_utf8(answer.stdout).unwrap();
        assert!(text.starts_with(&format!("OUT OF RANGE: {statement}")) && text.contains("setpoint  "), "{text}");
    }
    let json = vibrissa(&["solve", "--target-mm", "70", "--length-mm", "55", "--json"], folder.path());
    assert_eq!(json.status.code(), Some(3), "{}", err(&json));
    assert_eq!(serde_json::from_slice::<Value>(&json.stdout).unwrap()["solution"], "NEEDS_BELOW_RANGE");
    let refused = solve("14");
    assert_eq!(refused.status.code(), Some(1));
    assert!(err(&refused).contains("cut into its chamber"), "{}", err(&refused));
}

/// Exact readings of k2 = 0.5 + 1.4 exp(-10 Q), E = 1.2 MPa, and G = 9 mm.
fn readings(header: &str, strain_unit: f64) -> String {
    use vibrissa_core::mechanics::{Calibration, Formulation, Geometry, Model};
    use vibrissa_core::units::Megapascal;
    let calibration = Calibration { c: 0.5, a: 1.4, b_per_mpa: 10.0, youngs_modulus_mpa: 1.2, elongation_gain_mm: 9.0 };
    let model = Model::new(Geometry::nguyen_2021(), calibration, Formulation::Published).unwrap();
    let mut text = format!("# made up\npressure_mpa,{header},elongation_mm\n0,,\n");
    for pressure in [0.002, 0.02, 0.05, 0.1, 0.15, 0.2].map(|mpa| Megapascal::new(mpa).unwrap()) {
        let (strain, stretch_mm) =
            (model.axial_strain(pressure).ratio() / strain_unit, model.elongation(pressure).mm());
        text += &format!("{},{strain},{stretch_mm}\n", pressure.mpa());
    }
    text
}

#[test]
fn property_calibrate_finds_the_parameters_and_its_file_can_be_used() {
    let folder = tempfile::tempdir().unwrap();
    for (header, unit) in
        [("strain", 1.0), ("strain_reading_um_per_m", 1e-6 / 2.21), ("strain_reading_mm_per_m", 1e-3 / 2.21)]
    {
        std::fs::write(folder.path().join("front.csv"), readings(header, unit)).unwrap();
        let arguments =
            ["calibrate", "front.csv", "--youngs-modulus-mpa", "1.2", "--out", "front.toml", "--svg", "front.svg"];
        out(&vibrissa(&arguments, folder.path()));
        let (name, model) = vibrissa_edge::calibration_file::load(
            &folder.path().join("front.toml"),
            vibrissa_core::mechanics::Formulation::Published,
        )
        .unwrap();
        assert_eq!(name, "front");
        let svg = std::fs::read_to_string(folder.path().join("front.svg")).unwrap();
        assert!(svg.starts_with("<svg") && svg.contains("elongation of the chamber"), "{svg}");
        let found = model.calibration();
        for (what, found, expected) in [
            ("c", found.c, 0.5),
            ("a", found.a, 1.4),
            ("b", found.b_per_mpa, 10.0),
            ("E", found.youngs_modulus_mpa, 1.2),
            ("G", found.elongation_gain_mm, 9.0),
        ] {
            assert!((found / expected - 1.0).abs() <= 1e-6, "{what} by {header}: {found} instead of {expected}");
        }
    }
    let answer =
        vibrissa(&["solve", "--target-mm", "70", "--length-mm", "66", "--calibration", "front.toml"], folder.path());
    assert!(out(&answer).contains("front"));
}

#[test]
fn property_bad_readings_are_refused_with_line_and_column() {
    let folder = tempfile::tempdir().unwrap();
    for (text, expected) in [
        ("pressure_mpa,strain\n0.1,0.05\n0.1,abc\n", "line 3: column strain: \"abc\" is not a number"),
        ("pressure_mpa,strain\n0.1,0.05\n1.5,0.03\n", "line 3: column pressure_mpa: pressure in MPa is 1.5"),
        ("# x\npressure_mpa,strain\n0.1,0.05\n0.05,-0.03\n", "line 4, strain: must be above 0 under pressure"),
        ("pressure_mpa,strain\n0.1,0.05\n0.1,0.05,3\n", "line 3: 3 cells, but the header has 2 columns"),
        ("pressure_mpa;strain\n0,1;0,05\n", "its columns are separated by semicolons: separate them by commas"),
        ("pressure_mpa\tstrain\n0.1\t0.05\n", "its columns are separated by tabs"),
        ("pressure_mpa,strain\n0.1,\"0,05\"\n", "\"0,05\" is not a number: write it with a decimal point"),
        (
            "pressure_mpa,strain\n0.1,0.05\n100,0.05\n",
            "line 3: column pressure_mpa: pressure in MPa is 100, but must be between 0 and 1; if it is in kPa, write 0.1 MPa",
        ),
        ("pressure_kpa,strain\n100,0.05\n", "unknown column \"pressure_kpa\""),
        ("pressure_kpa,strain\n100,0.05\n", "100 kPa are 0.1 MPa"),
        ("pressure_mpa,strain\n", "the table has no readings below its header: write a header such as"),
        (
            "pressure_mpa,strain\n0.05,0.02\n0.1,0.03\n0.15,0.04\n0.2,0.045\n",
            "The chamber must become softer with the pressure",
        ),
        (
            "pressure_mpa,strain\n0.01,0.01\n0.05,0.06\n0.1,0.2\n0.15,0.45\n0.2,0.95\n",
            "these readings lead to an impossible chamber: at 0.2 MPa the chamber would stretch",
        ),
        ("pressure_mpa,strain,elogation_mm\n0.1,0.05,1\n", "unknown column \"elogation_mm\""),
        ("pressure_mpa\n0.1\n", "exactly one of the columns strain"),
        ("pressure_mpa,strain\n0.1,0.05\n", "1 rows with a strain above zero pressure: at least 4"),
    ] {
        std::fs::write(folder.path().join("bad.csv"), text).unwrap();
        let refused = vibrissa(&["calibrate", "bad.csv"], folder.path());
        assert!(!refused.status.success());
        assert!(err(&refused).contains(expected), "{} instead of {expected}", err(&refused));
    }
}

#[test]
fn the_example_in_the_documents_gives_the_calibration_of_the_paper() {
    let folder = tempfile::tempdir().unwrap();
    let example = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/calibration-example.csv");
    out(&vibrissa(&["calibrate", example, "--out", "own.toml"], folder.path()));
    let (name, model) = vibrissa_edge::calibration_file::load(
        &folder.path().join("own.toml"),
        vibrissa_core::mechanics::Formulation::Published,
    )
    .unwrap();
    assert_eq!(name, "calibration-example");
    let paper = vibrissa_core::mechanics::Calibration::nguyen_2021();
    let found = model.calibration();
    // The readings scatter by 1 %, and are those of a whisker like the paper's.
    for (what, found, expected) in
        [("c", found.c, paper.c), ("a", found.a, paper.a), ("b", found.b_per_mpa, paper.b_per_mpa)]
    {
        assert!((found / expected - 1.0).abs() < 0.05, "{what}: {found} instead of {expected}");
    }
    out(&vibrissa(&["config", "--calibration", "own.toml"], folder.path()));
}

#[test]
fn property_a_bad_calibration_file_is_refused_by_file_and_key() {
    let folder = tempfile::tempdir().unwrap();
    let good = "name = \"x\"\nc = 0.5\na = 1.4\nb_per_mpa = 10\nyoungs_modulus_mpa = 1.2\nelongation_gain_mm = 9\n";
    for (from, to, expected) in [
        ("c = 0.5\n", "", "missing field `c`"),
        ("c = 0.5", "c = \"much\"", "line 2"),
        ("c = 0.5", "c = -0.5", "calibration c must be a number above 0, not -0.5"),
        ("c = 0.5", "c = 0.5\nd = 1", "unknown field `d`"),
        ("\"x\"", "\"a b\"", "key `name`"),
    ] {
        std::fs::write(folder.path().join("x.toml"), good.replace(from, to)).unwrap();
        let refused =
            vibrissa(&["solve", "--target-mm", "70", "--length-mm", "66", "--calibration", "x.toml"], folder.path());
        assert!(!refused.status.success());
        assert!(err(&refused).contains("x.toml") && err(&refused).contains(expected), "{}", err(&refused));
    }
}
