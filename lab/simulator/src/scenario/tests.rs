use std::collections::BTreeMap as Table;

use vibrissa_core::mechanics::{Calibration, Geometry};

use super::*;

const SMALL: &str = r#"
fleet = "f"
[[robots]]
robot = "r"
[[robots.arrays]]
array = "left"
type = "TYPE_1"
whiskers = [{ whisker = 0, neighbours = [1] }, { whisker = 1 }]
"#;

fn refused(extra: &str) -> String {
    Scenario::from_toml_str(&format!("{SMALL}{extra}")).unwrap_err().to_string()
}

#[test]
fn the_example_can_be_read() {
    let scenario = Scenario::from_toml_str(include_str!("../../scenarios/example.toml")).unwrap();
    assert_eq!(scenario.robots.len(), 2);
    assert_eq!(scenario.noise, Noise::default(), "the example states the defaults");
    let behaviour = Behaviour { contacts_per_second: 5.0, ..Behaviour::default() };
    assert_eq!(scenario.behaviour, behaviour, "the example states the defaults");
}

#[test]
fn what_is_not_said_has_its_default() {
    let scenario = Scenario::from_toml_str(SMALL).unwrap();
    let (array, whisker) = scenario.robots[0].whiskers().next().unwrap();
    assert_eq!((array.array.as_str(), whisker.length_mm, whisker.pressure_mpa), ("left", 70.0, 0.1));
    assert_eq!(scenario.calibration_error, 0.03);
}

/// The scenario with whiskers of other dimensions.
fn with_calibration(geometry: Geometry) -> Result<Scenario, BadScenario> {
    let calibration = Calibration { youngs_modulus_mpa: 0.9, ..Calibration::nguyen_2021() };
    let file = CalibrationFile::new(&Name::new("wide").unwrap(), &geometry, &calibration);
    let (before, after) = SMALL.split_once("[[robots]]").unwrap();
    let section = toml::to_string(&Table::from([("calibration", file)])).unwrap();
    Scenario::from_toml_str(&format!("{before}{section}[[robots]]{after}"))
}

#[test]
fn whiskers_of_other_dimensions_have_the_mechanics_of_their_calibration() {
    let built_in = Geometry::nguyen_2021();
    let wide = Geometry { d3_large_mm: 1.2 * built_in.d3_large_mm, ..built_in };
    let scenario = with_calibration(wide).unwrap();
    let model = scenario.model().unwrap();
    assert_eq!((*model.geometry(), model.calibration().youngs_modulus_mpa), (wide, 0.9));
    let deviating = Rubber { c: 1.1, ..Rubber::default() }.model(&model).unwrap();
    assert_eq!((*deviating.geometry(), deviating.calibration().youngs_modulus_mpa), (wide, 0.9));
    assert!((deviating.calibration().c / model.calibration().c - 1.1).abs() < 1e-12);
    let refused = with_calibration(Geometry { d3_large_mm: -1.0, ..built_in }).unwrap_err().to_string();
    assert!(refused.starts_with("calibration: ") && refused.contains("D3 must be"), "{refused}");
}

#[test]
fn an_unknown_field_is_refused_by_name() {
    let text = SMALL.replace("neighbours = [1]", "neighbors = [1]");
    let error = Scenario::from_toml_str(&text).unwrap_err().to_string();
    assert!(error.contains("neighbors"), "{error}");
}

#[test]
fn a_length_inside_the_chamber_is_refused() {
    let text = SMALL.replace("whisker = 1 }", "whisker = 1, length_mm = 14.0 }");
    let error = Scenario::from_toml_str(&text).unwrap_err().to_string();
    assert_eq!(error, "robot r array left whisker 1 length_mm is 14, but must be between 40 and 150");
}

#[test]
fn a_pressure_above_the_whiskers_own_limit_is_refused() {
    let text = SMALL.replace("whisker = 1 }", "whisker = 1, pressure_mpa = 0.15, pressure_max_mpa = 0.12 }");
    assert!(Scenario::from_toml_str(&text).is_err());
}

#[test]
fn the_same_robot_array_or_whisker_twice_is_refused() {
    let text = SMALL.replace("whisker = 1 }", "whisker = 0 }");
    let error = Scenario::from_toml_str(&text).unwrap_err().to_string();
    assert_eq!(error, "robot r array left: whisker 0 occurs more than once");
    let robot = &SMALL[SMALL.find("[[robots]]").unwrap()..];
    assert!(refused(robot).contains("robots: r occurs more than once"));
}

#[test]
fn an_event_needs_one_time_and_whom_it_happens_to() {
    let trim = "change = { kind = \"TRIM\", length_mm = 60.0 }\n";
    for (event, expected) in [
        (format!("array = \"left\"\nwhisker = 0\n{trim}"), "either at_s or at_contact"),
        (format!("at_s = 1\n{trim}"), "needs array and whisker"),
        (format!("at_s = 1\narray = \"right\"\nwhisker = 0\n{trim}"), "no array right"),
        (format!("at_s = 1\narray = \"left\"\nwhisker = 9\n{trim}"), "no whisker 9"),
        ("at_contact = 1\nchange = { kind = \"RESTART\" }".into(), "needs at_s"),
        ("at_s = 1\narray = \"left\"\nchange = { kind = \"RESTART\" }".into(), "affects the whole robot"),
        ("at_s = 1\nchange = { kind = \"LOSE\", fraction = 2, for_s = 1 }".into(), "fraction is 2"),
        (
            "at_s = 1\narray = \"left\"\nwhisker = 0\n\
             change = { kind = \"BASELINE_DRIFT\", strain_per_contact = 1e-6, until_strain = -1e-4 }"
                .into(),
            "have opposite signs",
        ),
        ("at_s = 1\nchange = { kind = \"SILENT\" }".into(), "needs array and whisker"),
        ("at_s = 1\nchange = { kind = \"DEFLECTION_SCALE\", factor = 0 }".into(), "factor is 0"),
    ] {
        let error = refused(&format!("[[robots.events]]\n{event}"));
        assert!(error.contains(expected), "{error}");
    }
}
